"""The visible range of frames: zooming, panning, and scrolling to a frame or an interval."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from inspector.session.document import Document
from twistcore.detection import Interval
from twistcore.review import Judged

SMALLEST = 8.0  # smallest range in frames
_SPARE = 3.5  # largest margin on either side, as a multiple of the interval's length


class VisibleRange(QObject):
    """The range of frames that the plots show.

    Attributes
    ----------
    ends
        The first and the last visible frame, which may be fractional.
    """

    changed = Signal()
    arrived = Signal()  # the range shows an interval that was zoomed to

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self.ends = (-0.5, 0.5)

    def show(self, first: float, last: float) -> None:
        """Show a range of frames, limited to the frames of the clip."""
        low, high = -0.5, max(1, self._document.frames) - 0.5
        margin = 0.01 * (high - low)
        low, high = low - margin, high + margin
        span = min(max(last - first, SMALLEST), high - low)
        middle = 0.5 * (first + last)
        first = min(max(middle - 0.5 * span, low), high - span)
        self.ends = (first, first + span)
        self.changed.emit()

    def show_all(self) -> None:
        """Show the whole clip."""
        self.show(-1e9, 1e9)

    def pan(self, frames: float) -> None:
        """Move the range by a number of frames, which may be negative."""
        self.show(self.ends[0] + frames, self.ends[1] + frames)

    def zoom_to_interval(self, judged: Judged | None = None) -> None:
        """Show an interval with a margin of half a second on either side.

        By default, this is the selected interval. The margin is smaller for a short interval, so
        that the interval fills at least an eighth of the width.
        """
        judged = judged or self._document.interval
        if judged is None or self._document.data is None:
            return
        start, stop = judged.interval.start, judged.interval.stop
        pad = min(0.5 * self._document.data.motion.fps, _SPARE * (stop - start))
        self.show(start - 0.5 - pad, stop - 0.5 + pad)
        self.arrived.emit()

    def deselect_hidden(self) -> None:
        """Deselect the selected interval if it is not visible.

        This prevents a key press from accepting or rejecting an interval that the user cannot see.
        """
        if (judged := self._document.interval) and not self._sees(judged.interval):
            self._document.select_interval(None)

    def _sees(self, interval: Interval) -> bool:
        return interval.stop >= self.ends[0] and interval.start <= self.ends[1]

    def reach_frame(self, frame: int) -> None:
        """Scroll to a frame unless it is visible."""
        first, last = self.ends
        if not first <= frame <= last:
            span = last - first
            self.show(frame - 0.1 * span, frame + 0.9 * span)

    def reach_interval(self, interval: Interval) -> None:
        """Scroll to the middle of an interval unless the interval is visible."""
        first, last = self.ends
        if not self._sees(interval):
            self.pan(0.5 * (interval.start + interval.stop - first - last))
