"""Counter-twists: a parent P turns about its bone and its child C turns back [Choi26].

The detectors find them.
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
