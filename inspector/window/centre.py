"""The middle of the window, with the message bar, the reviewer line, the 3D view and the
transport.
"""

from __future__ import annotations

from PySide6.QtWidgets import QWidget

from inspector.feature import HostWindow
from inspector.panels.reviewer_line import ReviewerLine
from inspector.panels.transport import Transport
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import vbox
from inspector.widgets.message_bar import MessageBar
from inspector.widgets.native_surface import own_surface


class Centre(QWidget):
    """The central widget of the window, with its parts one below the other, without gaps."""

    def __init__(self, window: HostWindow) -> None:
        super().__init__()
        document = window.document
        self.bar = MessageBar()
        self.viewport = Viewport(document, window.colours)
        self.transport = Transport(document, window.player, window.actions_by_id)
        self.reviewer_line = ReviewerLine(document, window.settings)
        parts = self.bar, self.reviewer_line, (self.viewport, 1), self.transport
        vbox(*parts, owner=self, margins=(0, 0, 0, 0), spacing=0)
        window.setCentralWidget(self)
        own_surface(self.viewport)
