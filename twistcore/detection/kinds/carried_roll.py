"""Carried rolls: a parent and its child roll together, and the limb keeps its shape.

As in a counter-twist, the offset is the wrong angle of the parent. See `carried_rolls.py`.
"""

from twistcore.detection.kind import KindInfo

KIND = KindInfo(
    name="carried roll",
    label="Carried rolls",
    place=15,
    repair="carried roll",
    automatic=True,
    sure=0.7,
    doubt="in judged captures, less certain carried rolls were mostly false alarms",
    here="carried roll {frames} ({size})",
    happens="{part} rolls",
    named="the carried roll in {span} ({size})",
    tip="The bone and the next one roll together; the limb's shape does not change",
)
