"""The 3D view gets a surface of its own: all else then reaches the screen without it.

Qt puts a window with an OpenGL view in it together by OpenGL, all of it, whatever has changed:
with software OpenGL 8 ms, a third of the time from a moved τ to its plots. With the view apart,
everything else is copied to the screen as it was painted.
"""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QWidget


def own_surface(view: QWidget) -> None:
    """Give a part of a window its own surface, where that is known to work: X11."""
    if QGuiApplication.platformName() == "xcb":
        # Not its siblings and parents as well: menus would leave their picture between them.
        QGuiApplication.setAttribute(Qt.ApplicationAttribute.AA_DontCreateNativeWidgetSiblings)
        view.setAttribute(Qt.WidgetAttribute.WA_DontCreateNativeAncestors)
        view.setAttribute(Qt.WidgetAttribute.WA_NativeWindow)
