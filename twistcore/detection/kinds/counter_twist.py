"""Counter-twists: a parent rotates about its bone, and its child rotates back [Choi26].

The detectors find these errors, so this module needs no finder function.
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
