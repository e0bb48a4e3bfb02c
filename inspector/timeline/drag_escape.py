"""Let the user cancel a drag in the plots with Esc."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QCoreApplication, QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent

from inspector.session.document import Document
from twistcore.review import ReviewState


class DragEscape(QObject):
    """An event filter that calls a function if the user presses Esc during a drag.

    It works even if no plot has the keyboard focus.
    """

    def __init__(self, document: Document, cancel: Callable[[], object], parent: QObject) -> None:
        super().__init__(parent)
        self._document, self._cancel = document, cancel
        self._before: ReviewState | None = None  # the state of the review when the drag began

    def begin(self) -> None:
        """Start to watch the keyboard. Called when a drag begins."""
        self._before = self._document.review.state if self._document.data else None
        _app().installEventFilter(self)

    def end(self) -> None:
        """Stop watching the keyboard. Called when a drag ends."""
        _app().removeEventFilter(self)

    def undo(self) -> None:
        """Undo the changes that the drag has made, if any."""
        document = self._document
        if not document.data or not document.review.undo_text:
            return
        if document.review.state_before_last is self._before:
            document.undo()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Cancel the drag on Esc, and prevent the key from triggering a shortcut."""
        if not isinstance(event, QKeyEvent) or event.key() != Qt.Key.Key_Escape:
            return False
        if event.type() == QEvent.Type.ShortcutOverride:
            event.accept()
        elif event.type() == QEvent.Type.KeyPress:
            self._cancel()
        return True


def _app() -> QCoreApplication:
    app = QCoreApplication.instance()
    assert app is not None
    return app
