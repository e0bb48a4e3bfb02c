"""The 3D view: oriented bones in which roll is plain to see."""

from inspector.viewport.camera import VIEWS
from inspector.viewport.figure import Style
from inspector.viewport.viewport import Viewport

__all__ = ["VIEWS", "Style", "Viewport"]
