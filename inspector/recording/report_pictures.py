"""Draw the pictures for a report: `python -m inspector.recording.report_pictures FOLDER`.

The pictures show the same bodies as the 3D view. No window, event loop or display is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from vtkmodules.vtkIOImage import vtkJPEGWriter
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkWindowToImageFilter
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer

from inspector.viewport.bodies import find_bones
from inspector.viewport.bone_colours import Role, mix
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.ground import Ground, ground_lines, lowest
from inspector.viewport.lights import background, light
from inspector.viewport.limb_side import limb_side
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.solid_and_ghost import Pose, Shapes, Solid, Style
from inspector.widgets.theme import LIGHT
from twistcore.report.picture_job import BeforeAfter, Figure, picture_path, read_job
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.figure import figure_size, guess_up, heading
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.people import find_people

_SAMPLES = 8  # samples per pixel
_QUALITY = 84  # JPEG quality, for about 10 kB per picture
_MARGIN = 1.6  # space around the limb that shows whose limb it is
_EYE = 0.35  # height of the camera above the ground, as a share of the figure's height


class OffscreenRenderer:
    """Draws figures one after the other into an off-screen image."""

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

    def pictures(self, figure: Figure) -> Iterator[tuple[int, int, vtkWindowToImageFilter]]:
        """Yield (index of the pair, 0 for before or 1 for after, image) for a figure."""
        motion = figure.motion
        rotations, positions = forward_kinematics(motion)
        chains = tuple(c for c in figure.chains if not isinstance(c, Limb))
        up = guess_up(positions, chains, motion.skeleton)
        height = figure_size(positions, motion.skeleton)
        bones = find_bones(motion, up, height)
        people = {p.name: p.joints for p in find_people(motion.skeleton)}
        ground = lowest(positions, up, height, [joints[0] for joints in people.values()])
        points, lines, strength = ground_lines(ground)
        grid = Piece(len(points), lines=lines).unlit().add_to(self._renderer)
        grid.move(points)
        back, ink = background(LIGHT), mix(LIGHT.line, LIGHT.soft, 0.30)
        grid.paint((back + 0.85 * strength[:, None] * (ink - back)).astype(np.uint8))
        shapes = Shapes(Style.SKIN, bones, chains, height, fine=True)
        solid = Solid(shapes, ground, self._renderer)
        solid.colour(LIGHT)
        try:
            for k, pair in enumerate(figure.pairs):
                chain = _find_chain(figure, pair)
                before, after = ((rotations[t], positions[t]) for t in (pair.first, pair.second))
                own = tuple(c for c in chains if c.person == chain.person)
                facing, body = heading(after[1], own, up), people.get(chain.person, ())
                above = int(motion.skeleton.parents[chain.parent])
                side = limb_side(
                    chain, bones, before, after, facing, up,
                    skeleton=motion.skeleton, height=height, above=above, body=body,
                )  # fmt: skip
                camera = OrbitCamera(np.zeros(3), 0.0, 0.0, height, up, facing)
                if side is not None:
                    camera = side.camera(camera, height, self._aspect, _MARGIN)
                self._look(_above_ground(camera, ground, height), height)
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


def _above_ground(camera: OrbitCamera, ground: Ground, height: float) -> OrbitCamera:
    """Return the camera raised so that the grid on the ground does not cover the figure."""
    rise = (ground.level + _EYE * height - float(camera.target @ camera.up)) / camera.distance
    lowest_angle = float(np.arcsin(np.clip(rise, -1.0, 1.0)))
    return replace(camera, elevation=max(camera.elevation, lowest_angle)).orbited(0.0, 0.0)


def _find_chain(figure: Figure, pair: BeforeAfter) -> Chain:
    return next(chain for chain in figure.chains if chain.name == pair.chain)


def main(folder: Path) -> None:
    """Draw the pictures that are described by files in a folder, and write them there."""
    size, figures = read_job(folder)
    renderer = OffscreenRenderer(size)
    for number, figure in enumerate(figures):
        for pair, which, picture in renderer.pictures(figure):
            writer = vtkJPEGWriter()
            writer.SetInputConnection(picture.GetOutputPort())
            writer.SetQuality(_QUALITY)
            writer.SetFileName(str(picture_path(folder, number, pair, which)))
            writer.Write()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
