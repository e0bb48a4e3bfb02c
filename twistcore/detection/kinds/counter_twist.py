"""P turns about its bone, C turns back [Choi26]: found by the detectors."""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="counter-twist",
    label="Counter-twists",
    short="twist",
    place=10,
    repair="twist",
    automatic=True,
    here="counter-twist {frames} ({size})",
)
