"""The lights and the background colour of all images."""

from __future__ import annotations

from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer

from inspector.viewport.bone_colours import mix
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array


def light(renderer: vtkRenderer) -> None:
    """Add a key light from the upper left of the camera and a faint fill light."""
    for place_, strength in (((-0.7, 0.9, 1.0), 0.85), ((0.8, -0.2, 0.6), 0.30)):
        lamp = vtkLight()
        lamp.SetLightTypeToCameraLight()
        lamp.SetPosition(*place_)
        lamp.SetIntensity(strength)
        renderer.AddLight(lamp)


def background(theme: Theme) -> Array:
    """Return the background colour, (3,) in 0…255. A gradient would cost 3 ms per frame."""
    return mix(theme.surface, theme.window, 0.6)
