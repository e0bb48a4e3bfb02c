"""Counter-twists: a parent turns about its bone, and its child turns back [Choi26].

Detectors find errors of this kind.
"""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="counter-twist",
    label="Counter-twists",
    place=10,
    repair="twist",
    automatic=True,
    here="counter-twist {frames} ({size})",
    happens="{part} twists",
)
