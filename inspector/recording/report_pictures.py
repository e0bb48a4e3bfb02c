"""Draw the pictures for a report: `python -m inspector.recording.report_pictures FOLDER`.

The pictures and a page that plays show the same bodies as the 3D view. No window, event loop or
display is needed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules.vtkIOImage import vtkJPEGWriter
from vtkmodules.vtkRenderingCore import vtkRenderWindow, vtkWindowToImageFilter
from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLRenderer

from inspector.viewport.bodies import find_bones
from inspector.viewport.bone_colours import GHOST_ALPHA, Role, mix
from inspector.viewport.camera import VIEW_ANGLE, OrbitCamera
from inspector.viewport.ground import Ground, ground_lines, lowest
from inspector.viewport.lights import background, light
from inspector.viewport.limb_side import limb_side
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.solid_and_ghost import Pose, Shapes, Solid, Style
from inspector.viewport.web_figure import (
    FIGURE_SCRIPTS,
    emphasised,
    figure_data,
    page_part,
    skin_data,
    theme_data,
    three_js,
)
from inspector.widgets.theme import DARK, LIGHT
from twistcore.errors import TwistError
from twistcore.files.encoding import json_bytes
from twistcore.report.picture_job import BeforeAfter, Figure, picture_path, player_path, read_job
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.figure import figure_size, guess_up, heading
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import Array

_SAMPLES = 8  # samples per pixel
_QUALITY = 84  # JPEG quality, for about 10 kB per picture
_MARGIN = 1.6  # space around the limb that shows whose limb it is
_EYE = 0.35  # height of the camera above the ground, as a share of the figure's height


class Drawing:
    """The body and the poses of a figure."""

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        motion = figure.motion
        self._rotations, positions = forward_kinematics(motion)
        self._positions = positions
        self.chains = tuple(c for c in figure.chains if not isinstance(c, Limb))
        self._up = guess_up(positions, self.chains, motion.skeleton)
        self.height = figure_size(positions, motion.skeleton)
        self.bones = find_bones(motion, self._up, self.height)
        self._people = {p.name: p.joints for p in find_people(motion.skeleton)}
        roots = [joints[0] for joints in self._people.values()]
        self.ground = lowest(positions, self._up, self.height, roots)

    def poses(self, pair: BeforeAfter) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Return the global rotations and positions before and after."""
        first, second = (
            (self._rotations[t], self._positions[t]) for t in (pair.first, pair.second)
        )
        return first, second

    def camera(self, pair: BeforeAfter, aspect: float) -> OrbitCamera:
        """Return the camera from which a pair's limb is seen best."""
        chain, skeleton = _find_chain(self.figure, pair), self.figure.motion.skeleton
        before, after = self.poses(pair)
        own = tuple(c for c in self.chains if c.person == chain.person)
        facing, body = heading(after[1], own, self._up), self._people.get(chain.person, ())
        above = int(skeleton.parents[chain.parent])
        side = limb_side(
            chain, self.bones, before, after, facing, self._up,
            skeleton=skeleton, height=self.height, above=above, body=body,
        )  # fmt: skip
        camera = OrbitCamera(np.zeros(3), 0.0, 0.0, self.height, self._up, facing)
        if side is not None:
            camera = side.camera(camera, self.height, aspect, _MARGIN)
        return _above_ground(camera, self.ground, self.height)

    def player(self) -> dict[str, Any]:
        """Return the figure, its views and its scripts for a page that plays, as JSON data."""
        skeleton = self.figure.motion.skeleton
        data = figure_data(skeleton, self.bones, self._up, self.height, self.ground)
        data["skin"] = skin_data(self.bones, self.chains, self.height)
        return {
            "figure": data,
            "themes": {"light": theme_data(LIGHT), "dark": theme_data(DARK)},
            "ghost": GHOST_ALPHA,
            "scripts": [three_js(), *map(page_part, FIGURE_SCRIPTS)],
            "views": [self._view(pair) for pair in self.figure.views],
        }

    def _view(self, pair: BeforeAfter) -> dict[str, Any]:
        """Return the camera of a pair, its limb and the joints of its person."""
        camera, chain = self.camera(pair, 1.0), _find_chain(self.figure, pair)
        every = range(len(self.figure.motion.skeleton))
        return {
            "ahead": camera.ahead.tolist(),
            "target": camera.target.tolist(),
            **{name: getattr(camera, name) for name in ("azimuth", "elevation", "distance")},
            "strong": emphasised(self.bones, chain, self.figure.motion.skeleton),
            "body": list(self._people.get(chain.person) or every),
        }


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

    def pictures(self, drawing: Drawing) -> Iterator[tuple[int, int, vtkWindowToImageFilter]]:
        """Yield (index of the pair, 0 for before or 1 for after, image) for a figure."""
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


def _above_ground(camera: OrbitCamera, ground: Ground, height: float) -> OrbitCamera:
    """Return the camera raised so that the grid on the ground does not cover the figure."""
    rise = (ground.level + _EYE * height - float(camera.target @ camera.up)) / camera.distance
    lowest_angle = float(np.arcsin(np.clip(rise, -1.0, 1.0)))
    return replace(camera, elevation=max(camera.elevation, lowest_angle)).orbited(0.0, 0.0)


def _find_chain(figure: Figure, pair: BeforeAfter) -> Chain:
    return next(chain for chain in figure.chains if chain.name == pair.chain)


def _player(drawing: Drawing) -> dict[str, Any]:
    """Return the data of a page that plays, or only the reason why there is none."""
    try:
        return drawing.player()
    except TwistError as error:
        return {"problem": str(error)}


def main(folder: Path) -> None:
    """Draw the pictures that are described by files in a folder, and write them there."""
    size, figures = read_job(folder)
    renderer = OffscreenRenderer(size)
    for number, figure in enumerate(figures):
        drawing = Drawing(figure)
        if figure.views:
            player_path(folder, number).write_bytes(json_bytes(_player(drawing)))
        for pair, which, picture in renderer.pictures(drawing):
            writer = vtkJPEGWriter()
            writer.SetInputConnection(picture.GetOutputPort())
            writer.SetQuality(_QUALITY)
            writer.SetFileName(str(picture_path(folder, number, pair, which)))
            writer.Write()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
