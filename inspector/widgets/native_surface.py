"""Create a native surface for the 3D view, so that Qt draws the other widgets without OpenGL.

If a window contains an OpenGL view, Qt normally composes the whole window with OpenGL. With
software rendering, this takes 8 ms, a third of the time between a change of τ and the repaint of
the plots. With a native surface, Qt copies the other widgets directly to the screen.
"""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QPoint, Qt
from PySide6.QtGui import QGuiApplication, QPaintEvent, QWindow
from PySide6.QtWidgets import QWidget


def give_native_surface(view: QWidget) -> None:
    """Give a widget a native surface on X11. On other platforms, do nothing."""
    if QGuiApplication.platformName() == "xcb":
        # Siblings and parents must not become native, or closed menus would remain visible between
        # them.
        QGuiApplication.setAttribute(Qt.ApplicationAttribute.AA_DontCreateNativeWidgetSiblings)
        view.setAttribute(Qt.WidgetAttribute.WA_DontCreateNativeAncestors)
        view.setAttribute(Qt.WidgetAttribute.WA_NativeWindow)
        _Along(view)
        _Uncovered(view.window())


class _Along(QObject):
    """An event filter that moves the native surface when the view's parent moves.

    Qt does not do this.
    """

    def __init__(self, view: QWidget) -> None:
        super().__init__(view)
        self._view = view
        if (parent := view.parentWidget()) is not None:
            parent.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Move the surface to the position of the view in its window, and pass on all events."""
        surface = self._view.windowHandle()
        if event.type() == QEvent.Type.Move and surface is not None:
            surface.setPosition(self._view.mapTo(self._view.window(), QPoint(0, 0)))
        return False


class _Uncovered(QObject):
    """An event filter that copies the window to the screen again after something covered it.

    Without a compositor, the covered parts of a window are not stored. Qt does not restore them in
    a window with an OpenGL view, because it expects OpenGL to compose that window. Without this
    filter, a menu would remain visible after it was closed.
    """

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self._window = window
        self._handle: QWindow | None = None
        window.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Copy the window to the screen when it must be repainted, and pass on all events."""
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
