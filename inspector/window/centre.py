"""The middle of the window: the reviewer line, the 3D view with messages, and the transport."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget

from inspector.feature import HostWindow
from inspector.panels.reviewer_line import ReviewerLine
from inspector.panels.transport import Transport
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import vbox
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.native_surface import give_native_surface

_MARGIN = 6  # pixels between the message bar and the edges of the view
# The events after which the bar is placed again. The bar's own Resize event is not one of them,
# because placing the bar would cause it again.
_OF_VIEW = (QEvent.Type.Resize,)
_OF_BAR = (QEvent.Type.Show, QEvent.Type.LayoutRequest)


class Centre(QWidget):
    """The central widget of the window: reviewer line, 3D view and transport, without gaps.

    Messages are drawn over the upper edge of the 3D view. In this position they neither move other
    widgets nor cover the figure. The Esc key closes a message unless a shortcut or the focused
    widget uses the key.
    """

    def __init__(self, window: HostWindow) -> None:
        super().__init__()
        document = window.document
        self.viewport = Viewport(document, window.colours)
        # A child of the view, because the view may be a native window
        self.bar = MessageBar(self.viewport)
        for widget in (self.viewport, self.bar, window):
            widget.installEventFilter(self)
        self.transport = Transport(document, window.player, window.actions_by_id)
        self.reviewer_line = ReviewerLine(document, window.settings)
        parts = self.reviewer_line, (self.viewport, 1), self.transport
        vbox(*parts, owner=self, margins=(0, 0, 0, 0), spacing=0)
        window.setCentralWidget(self)
        give_native_surface(self.viewport)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Position the message bar after its text or the view has changed; close it on Esc."""
        kinds = _OF_BAR if watched is self.bar else _OF_VIEW if watched is self.viewport else ()
        if event.type() in kinds:
            self._place_bar()
        # Keys reach the window only if neither a shortcut nor the focused widget uses them.
        if watched is self.window() and self.bar.isVisible() and _is_escape(event):
            self.bar.close_message()
            return True
        return super().eventFilter(watched, event)

    def _place_bar(self) -> None:
        room = self.viewport.rect().adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN)
        high = min(self.bar.heightForWidth(room.width()), room.height())
        self.bar.setGeometry(room.left(), room.top(), room.width(), high)
        self.bar.raise_()


def _is_escape(event: QEvent) -> bool:
    if not isinstance(event, QKeyEvent):
        return False
    return event.type() == QEvent.Type.KeyPress and event.key() == Qt.Key.Key_Escape
