"""The 3D view gets a surface of its own: all else then reaches the screen without it.

Qt puts a window with an OpenGL view in it together by OpenGL, all of it, whatever has changed:
with software OpenGL 8 ms, a third of the time from a moved τ to its plots. With the view apart,
everything else is copied to the screen as it was painted.
"""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QGuiApplication, QPaintEvent, QWindow
from PySide6.QtWidgets import QWidget


def own_surface(view: QWidget) -> None:
    """Give a part of a window its own surface, where that is known to work: X11."""
    if QGuiApplication.platformName() == "xcb":
        # Not its siblings and parents as well: menus would leave their picture between them.
        QGuiApplication.setAttribute(Qt.ApplicationAttribute.AA_DontCreateNativeWidgetSiblings)
        view.setAttribute(Qt.WidgetAttribute.WA_DontCreateNativeAncestors)
        view.setAttribute(Qt.WidgetAttribute.WA_NativeWindow)
        _Uncovered(view.window())


class _Uncovered(QObject):
    """Copies what was painted to the screen again where something lay over the window.

    Without a compositor the screen forgets what is covered. Qt then takes a window with an OpenGL
    view for one that OpenGL puts together, and copies nothing: a menu's picture stayed.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self._handle: QWindow | None = None
        window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Watch only."""
        if watched is self._window:
            handle = self._window.windowHandle()
            if event.type() == QEvent.Type.Show and handle is not None:
                self._window.removeEventFilter(self)
                self._handle = handle
                handle.installEventFilter(self)
        elif event.type() == QEvent.Type.Paint and isinstance(event, QPaintEvent):
            store = self._window.backingStore()
            if store is not None and self._handle is not None:
                store.flush(event.region(), self._handle)
        return False
