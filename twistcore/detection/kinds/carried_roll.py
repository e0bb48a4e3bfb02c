"""Carried rolls: a parent P turns about its bone and its child C rolls with it.

C's bone keeps its direction. See `carried_rolls.py`.
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
"""The offset is P's, as in a counter-twist; `Interval.carried` is True: C carried along."""
