"""The middle of the window: the reviewer line, the 3D view with messages, and the transport."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QWidget

from inspector.feature import HostWindow
from inspector.panels.reviewer_line import ReviewerLine
from inspector.panels.transport import Transport
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import vbox
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.native_surface import own_surface

_MARGIN = 6  # pixels between the message bar and the edges of the view
# The events after which the bar is placed again; its own Resize would place it within itself.
_OF_VIEW = (QEvent.Type.Resize,)
_OF_BAR = (QEvent.Type.Show, QEvent.Type.LayoutRequest)


class Centre(QWidget):
    """The central widget of the window. Its parts are one above the other, without gaps.

    Messages appear over the lower edge of the 3D view, so that they move no other widget.
    """

    def __init__(self, window: HostWindow) -> None:
        super().__init__()
        document = window.document
        self.viewport = Viewport(document, window.colours)
        self.bar = MessageBar(self.viewport)  # as its child, because the view may be native
        for widget in (self.viewport, self.bar):
            widget.installEventFilter(self)
        self.transport = Transport(document, window.player, window.actions_by_id)
        self.reviewer_line = ReviewerLine(document, window.settings)
        parts = self.reviewer_line, (self.viewport, 1), self.transport
        vbox(*parts, owner=self, margins=(0, 0, 0, 0), spacing=0)
        window.setCentralWidget(self)
        own_surface(self.viewport)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Move the message bar when its text or the size of the view changes."""
        kinds = _OF_VIEW if watched is self.viewport else _OF_BAR
        if event.type() in kinds:
            self._place_bar()
        return super().eventFilter(watched, event)

    def _place_bar(self) -> None:
        room = self.viewport.rect().adjusted(_MARGIN, _MARGIN, -_MARGIN, -_MARGIN)
        high = min(self.bar.heightForWidth(room.width()), room.height())
        self.bar.setGeometry(room.left(), room.bottom() + 1 - high, room.width(), high)
        self.bar.raise_()
