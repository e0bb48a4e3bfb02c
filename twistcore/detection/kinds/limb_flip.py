"""Limb flips: the first joint P turns about the line from P to the end E of the limb.

E does not move. See `limb_flips/`.
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
