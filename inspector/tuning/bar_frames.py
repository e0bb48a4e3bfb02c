"""Step through the frames in a bar of the strength histogram."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from inspector.language import tr
from inspector.session.document import Document
from inspector.tuning.strength_histogram import histogram_bar_index, histogram_bar_label
from twistcore.skeleton.rotation import Array


class BarFrames:
    """The frames in each bar of the strength histogram, and the current bar.

    The methods move the playhead to one of these frames.
    """

    def __init__(self, document: Document) -> None:
        self._document = document
        self._bars: NDArray[np.int_] = np.zeros(0, dtype=int)
        self._frames: NDArray[np.int_] = np.zeros(0, dtype=int)
        self.chosen: int | None = None
        self._came_from = 0

    def take(self, strength: Array, counted: NDArray[np.bool_]) -> None:
        """Set the data of the histogram.

        `strength` is the strength of each frame in degrees, (frames,). `counted` is True for the
        frames that the histogram counts, (frames,).
        """
        self._frames = np.flatnonzero(counted)
        self._bars = histogram_bar_index(strength[counted])
        self.chosen = None

    def next_frame(self, bar: int) -> None:
        """Go to the next frame whose strength is in a bar. After the last frame, start again.

        `bar` is the index of the bar.
        """
        own = self._frames[self._bars == bar]
        if len(own):
            self.chosen, self._came_from = bar, self._document.frame
            later = own[own > self._document.frame]
            self._document.go_to(int((later if len(later) else own)[0]))

    def first_frame(self, bar: int) -> None:
        """Go to the first frame whose strength is in a bar. `bar` is the index of the bar."""
        own = self._frames[self._bars == bar]
        if len(own):
            self.chosen, self._came_from = bar, self._document.frame
            self._document.go_to(int(own[0]))

    def next_bar(self) -> None:
        """Go to the first frame of the next bar that has frames.

        Bars are visited in order of increasing strength, and the first bar follows the last.
        """
        filled = np.unique(self._bars[self._bars >= 0])
        if len(filled):
            later = filled[filled > (-1 if self.chosen is None else self.chosen)]
            self.first_frame(int((later if len(later) else filled)[0]))

    def next_in_bar(self) -> None:
        """Go to the next frame of the current bar or, without a current bar, to the first bar."""
        if self.chosen is None:
            self.next_bar()
        else:
            self.next_frame(self.chosen)

    def back(self) -> None:
        """Undo the first click of a double-click by returning to the previous frame."""
        if self.chosen is not None:
            self.chosen = None
            self._document.go_to(self._came_from)

    @property
    def words(self) -> str:
        """The position of the current frame among the frames of its bar, as text.

        The text is '' if the current frame is not in the current bar.
        """
        if self.chosen is None:
            return ""
        own = self._frames[self._bars == self.chosen]
        at = np.flatnonzero(own == self._document.frame)
        if not len(at):
            return ""
        frame = self._document.frame + self._document.first_frame
        return tr(
            "frame {frame}, {k} of {n} in {bar}",
            frame=frame,
            k=at[0] + 1,
            n=len(own),
            bar=histogram_bar_label(self.chosen),
        )
