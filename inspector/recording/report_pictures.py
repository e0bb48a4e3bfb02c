"""Draw the pictures for a report: `python -m inspector.recording.report_pictures FOLDER`.

The pictures show the same bodies as the 3D view, and so does the page that plays the clip. No
window, event loop or display is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from vtkmodules.vtkIOImage import vtkJPEGWriter
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkWindowToImageFilter
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer

from inspector.recording.report_figure import FigureToDraw
from inspector.viewport.bone_colours import Role, mix
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.ground import ground_lines
from inspector.viewport.lights import background, light
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.solid_and_ghost import Pose, Shapes, Solid, Style
from inspector.widgets.theme import LIGHT
from twistcore.files.encoding import json_bytes
from twistcore.report.picture_job import picture_path, player_path, read_picture_job

_SAMPLES = 8  # samples per pixel
_QUALITY = 84  # JPEG quality; a picture has about 10 kB


class OffscreenRenderer:
    """Draws figures one after another in an off-screen window."""

    def __init__(self, size: tuple[int, int]) -> None:
        self._aspect = size[0] / size[1]
        self._renderer = vtkOpenGLRenderer()
        self._renderer.SetUseOIT(False)
        self._renderer.AutomaticLightCreationOff()
        self._renderer.SetBackground(*(background(LIGHT) / 255.0))
        light(self._renderer)
        self._window = vtkRenderWindow()
        self._window.OffScreenRenderingOn()
        self._window.SetMultiSamples(_SAMPLES)
        self._window.SetSize(*size)
        self._window.AddRenderer(self._renderer)

    def pictures(self, drawing: FigureToDraw) -> Iterator[tuple[int, int, vtkWindowToImageFilter]]:
        """Yield (index of the pair, 0 for before or 1 for after, image) for a figure's views."""
        points, lines, strength = ground_lines(drawing.ground)
        grid = Piece(len(points), lines=lines).unlit().add_to(self._renderer)
        grid.move(points)
        back, ink = background(LIGHT), mix(LIGHT.line, LIGHT.soft, 0.30)
        grid.paint((back + 0.85 * strength[:, None] * (ink - back)).astype(np.uint8))
        shapes = Shapes(Style.SKIN, drawing.bones, drawing.chains, drawing.height, fine=True)
        solid = Solid(shapes, drawing.ground, self._renderer)
        solid.colour(LIGHT)
        try:
            for k, pair in enumerate(drawing.figure.pairs):
                before, after = drawing.poses(pair)
                self._look(drawing.camera(pair, self._aspect), drawing.height)
                differs = shapes.differing(before[0], after[0])
                for which, (pose, role) in enumerate(((before, Role.BEFORE), (after, Role.AFTER))):
                    roles = np.where(differs, role, Role.PLAIN).astype(np.int64)
                    solid.draw(Pose(*pose, roles))
                    yield k, which, self._picture()
        finally:
            solid.remove()
            grid.remove()

    def _look(self, camera: OrbitCamera, height: float) -> None:
        vtk = self._renderer.GetActiveCamera()
        vtk.SetPosition(*camera.position)
        vtk.SetFocalPoint(*camera.target)
        vtk.SetViewUp(*camera.axes[1])
        vtk.SetViewAngle(float(np.degrees(VIEW_ANGLE)))
        near = 0.2 * camera.distance
        vtk.SetClippingRange(near, camera.distance + 20.0 * height)

    def _picture(self) -> vtkWindowToImageFilter:
        self._window.Render()
        grabber = vtkWindowToImageFilter()
        grabber.SetInput(self._window)
        grabber.ReadFrontBufferOff()
        grabber.ShouldRerenderOff()
        return grabber


def main(folder: Path) -> None:
    """Draw the pictures described by the files in a folder, and write them to that folder."""
    size, figures = read_picture_job(folder)
    renderer = OffscreenRenderer(size)
    for number, figure in enumerate(figures):
        drawing = FigureToDraw(figure)
        if figure.views:
            player_path(folder, number).write_bytes(json_bytes(drawing.player()))
        for pair, which, picture in renderer.pictures(drawing):
            writer = vtkJPEGWriter()
            writer.SetInputConnection(picture.GetOutputPort())
            writer.SetQuality(_QUALITY)
            writer.SetFileName(str(picture_path(folder, number, pair, which)))
            writer.Write()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
