"""What figures stand in, on the screen and off it: two lights, and the colour behind everything."""

from __future__ import annotations

from vtkmodules.vtkRenderingCore import vtkLight, vtkRenderer

from inspector.viewport.bone_colours import mix
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array


def light(renderer: vtkRenderer) -> None:
    """A key light from above the camera's left and a faint fill: two lights are cheap."""
    for place_, strength in (((-0.7, 0.9, 1.0), 0.85), ((0.8, -0.2, 0.6), 0.30)):
        lamp = vtkLight()
        lamp.SetLightTypeToCameraLight()
        lamp.SetPosition(*place_)
        lamp.SetIntensity(strength)
        renderer.AddLight(lamp)


def background(theme: Theme) -> Array:
    """The colour behind everything, (3,) in 0…255. A gradient would cost 3 ms a frame."""
    return mix(theme.surface, theme.window, 0.6)
