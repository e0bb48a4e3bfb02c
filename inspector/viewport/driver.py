"""Which OpenGL there is: none, software or hardware. Asked once."""

from __future__ import annotations

import functools

from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

_GL_RENDERER = 0x1F01
_PICTURELESS = ("offscreen", "minimal")  # Qt platforms on which VTK's picture stays blank
_SOFTWARE = ("llvmpipe", "softpipe", "swiftshader", "software", "swrast", "gdi generic")


@functools.cache
def renderer_name() -> str:
    """What the driver calls itself; empty where no desktop OpenGL 3.2 can be had."""
    if QGuiApplication.platformName() in _PICTURELESS:
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
    """Whether the processor draws."""
    return any(word in renderer_name().lower() for word in _SOFTWARE)


def multisamples() -> int:
    """Samples a pixel: none where the processor would pay for them."""
    return 0 if is_software() else 4
