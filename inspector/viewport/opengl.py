"""Detect whether OpenGL is available, and whether it renders in software or hardware."""

from __future__ import annotations

import functools

from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

from inspector.language import tr

_GL_RENDERER = 0x1F01
_PICTURELESS = ("offscreen", "minimal")  # Qt platforms on which VTK's image is blank
_WAYLAND = "wayland"  # also matches 'wayland-egl'; pyvistaqt cannot draw there yet
_STRONG = ("nvidia", "geforce", "quadro", "rtx", "radeon", "amd", "apple m")
_NO_OPENGL = tr(
    "The 3D view needs OpenGL 3.2, which is not available on this display.\n"
    "Curves, tables and export work without it."
)
_NO_XWAYLAND = tr(
    "The 3D view needs an X server, which this Wayland desktop does not run. Install Xwayland.\n"
    "Curves, tables and export work without it."
)
_SOFTWARE = ("llvmpipe", "softpipe", "swiftshader", "software", "swrast", "gdi generic")


@functools.cache
def renderer_name() -> str:
    """Return the name of the OpenGL renderer, or '' if desktop OpenGL 3.2 is not available.

    The result is cached.
    """
    platform = QGuiApplication.platformName()
    if platform in _PICTURELESS or platform.startswith(_WAYLAND):
        return ""
    wanted = QSurfaceFormat()
    wanted.setRenderableType(QSurfaceFormat.RenderableType.OpenGL)
    wanted.setProfile(QSurfaceFormat.OpenGLContextProfile.CoreProfile)
    wanted.setVersion(3, 2)
    context, surface = QOpenGLContext(), QOffscreenSurface()
    context.setFormat(wanted)
    surface.setFormat(wanted)
    surface.create()
    if not (context.create() and surface.isValid() and context.makeCurrent(surface)):
        return ""
    got = context.format()
    name = ""
    if (got.majorVersion(), got.minorVersion()) >= (3, 2):
        name = str(context.functions().glGetString(_GL_RENDERER) or "unknown")
    context.doneCurrent()
    surface.destroy()
    return name


def is_software() -> bool:
    """Return True if OpenGL renders in software."""
    return any(word in renderer_name().lower() for word in _SOFTWARE)


def multisamples() -> int:
    """Return the number of samples per pixel for antialiasing.

    It is 0 with software rendering, 8 on a strong graphics card, and 4 on other cards.
    """
    if is_software():
        return 0
    return 8 if any(word in renderer_name().lower() for word in _STRONG) else 4


def missing_3d_view_message() -> str:
    """Return a message for the user with the reason why there is no 3D view.

    Call this function only if `renderer_name` returns ''.
    """
    on_wayland = QGuiApplication.platformName().startswith(_WAYLAND)
    return _NO_XWAYLAND if on_wayland else _NO_OPENGL
