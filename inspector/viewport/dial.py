"""Change the offset of the selected interval when the user drags the hand of the clock."""

from __future__ import annotations

import math

from PySide6.QtCore import QObject

from inspector.session.document import Document
from inspector.viewport.clock import Clock
from twistcore.detection.interval_offsets import with_offset_of_size
from twistcore.review import Judged


class Dial(QObject):
    """Connects the clock drawing to the selected interval. Each drag is one undo step."""

    def __init__(self, document: Document, clock: Clock, parent: QObject) -> None:
        super().__init__(parent)
        self._document, self._clock, self._drag = document, clock, 0
        clock.grasped.connect(self._begin)
        clock.turned.connect(self._turn)
        for signal in (
            document.opened,
            document.frame_changed,
            document.interval_changed,
            document.intervals_changed,
        ):
            signal.connect(self._offer)
        self._offer()

    @property
    def _edited(self) -> Judged | None:
        """The selected interval if its offset can be changed at the current frame, or None."""
        judged, frame = self._document.interval, self._document.frame
        if judged is None or not judged.interval.kind.by_angle:
            return None
        return judged if judged.interval.start <= frame < judged.interval.stop else None

    def _offer(self, *_: object) -> None:
        self._clock.offer(self._edited is not None)

    def _begin(self) -> None:
        self._drag = self._document.begin_drag()

    def _turn(self, degrees: float) -> None:
        if (judged := self._edited) is None:
            return
        interval = judged.interval
        now = interval.largest if interval.soft_ended else interval.delta
        delta = math.remainder(now + math.radians(degrees), math.tau)
        self._document.edit(judged.id, with_offset_of_size(interval, delta), self._drag)
