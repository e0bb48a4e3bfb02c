"""Limb flips: a limb is rotated about the line from its first joint to its end.

The end keeps its position. See `limb_flips/`.
"""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="limb flip",
    label="Limb flips",
    place=20,
    repair="swivel",
    automatic=True,
    below=True,
    weight=1.5,  # a knee on the wrong side is more visible
    here="limb flip {frames} ({size})",
    happens="{part} flips",
)
