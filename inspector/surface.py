"""Parts of the window that reach the screen without the 3D view.

Qt puts a window with an OpenGL view in it together by OpenGL, all of it, whatever has changed:
with software OpenGL 8 ms, a third of the time from a moved τ to its plots. A part with a surface of
its own is copied to the screen as it was painted.
"""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget


def own_surface(widget: QWidget) -> None:
    """Give a part of a window its own surface, where that is known to work: X11."""
    if QGuiApplication.platformName() == "xcb":
        widget.setAttribute(Qt.WidgetAttribute.WA_DontCreateNativeAncestors)
        widget.setAttribute(Qt.WidgetAttribute.WA_NativeWindow)
