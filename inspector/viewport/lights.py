"""Create an empty 3D widget, and set the lights and the background colour of 3D images."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget
from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer

from inspector.viewport import opengl
from inspector.viewport.bone_colours import mix
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array

if TYPE_CHECKING:
    from pyvistaqt import QtInteractor


def light(renderer: vtkRenderer) -> None:
    """Add a light above and to the left of the camera.

    With software rendering, each additional light adds a sixth to the rendering time.
    """
    lamp = vtkLight()
    lamp.SetLightTypeToCameraLight()
    lamp.SetPosition(-0.6, 0.8, 1.1)
    lamp.SetIntensity(0.95)
    renderer.AddLight(lamp)


def background(theme: Theme) -> Array:
    """Return the background colour, (3,) in 0…255. A gradient would take 3 ms per frame."""
    return mix(theme.surface, theme.window, 0.6)


def make_plotter(parent: QWidget) -> QtInteractor | None:
    """Return an empty VTK widget with lights, or None without OpenGL."""
    if not opengl.renderer_name():
        return None
    from pyvistaqt import QtInteractor  # slow to load, and the pictures of reports do not need it

    plotter = QtInteractor(parent, auto_update=False, multi_samples=opengl.multisamples())
    plotter.setAcceptDrops(False)  # the window handles drops
    plotter.reset_key_events()
    plotter.remove_all_lights()
    light(plotter.renderer)
    # Plain blending is enough for the thin, convex ghost, and takes a tenth of the time of VTK's
    # order-independent pass.
    plotter.renderer.SetUseOIT(False)
    return plotter
