"""A message about jitter, shown when a clip is opened."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from inspector.language import tr
from inspector.session.document import Document
from inspector.widgets.background import OneTask
from twistcore.analysis.quality.trembling import TIMES, jitter_if_trembling


class JitterNote(QObject):
    """Measures the jitter of each opened clip in the background.

    If the clip jitters, `trembles` is emitted with a message.
    """

    trembles = Signal(str)

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self._task = OneTask(self)
        document.opened.connect(self._start)

    def stop(self) -> None:
        """Cancel the running measurement."""
        self._task.cancel()

    def _start(self) -> None:
        self.stop()
        data = self._document.data
        if data is None or self._document.borrowed or self._document.review.state.tracking:
            return
        motion = data.motion
        self._task.run(lambda _: jitter_if_trembling(motion), self._take, self._ignore)

    def _take(self, jitter: float | None) -> None:
        if jitter is not None:
            text = tr(
                "The jitter is {jitter:.0f} mm/frame³, at least {times:.0f} times as high as in "
                "real captures.",
                jitter=jitter,
                times=TIMES,
            )
            self.trembles.emit(text)

    def _ignore(self, error: Exception) -> None:
        """Do nothing if the jitter cannot be measured."""
