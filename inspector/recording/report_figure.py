"""The body and the poses of a figure in a report, and the data for a web page that animates it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from inspector.viewport.bodies import find_bones
from inspector.viewport.bone_colours import GHOST_ALPHA
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.ground import Ground, ground_at_lowest_joint
from inspector.viewport.limb_side import best_limb_error_view
from inspector.viewport.web_figure import (
    FIGURE_SCRIPTS,
    emphasised_bone_indices,
    figure_data,
    read_page_asset,
    skin_data,
    theme_data,
    three_js,
)
from inspector.widgets.theme import DARK, LIGHT
from twistcore.errors import TwistError
from twistcore.report.picture_job import BeforeAfter, Figure
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import Array

_MARGIN = 1.6  # space around the limb, which shows where in the body the limb is
_EYE = 0.35  # height of the camera above the ground, relative to the figure's height


class FigureToDraw:
    """The body and the poses of a figure, prepared for drawing."""

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
        self.ground = ground_at_lowest_joint(positions, self._up, self.height, roots)

    def poses(self, pair: BeforeAfter) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Return the poses before and after the correction, given a pair of frames.

        A pose is global rotations, (joints, 4), and positions, (joints, 3).
        """
        first, second = (
            (self._rotations[t], self._positions[t]) for t in (pair.first, pair.second)
        )
        return first, second

    def camera(self, pair: BeforeAfter, aspect: float) -> OrbitCamera:
        """Return the camera with the best view of the corrected limb.

        `pair` is a pair of frames before and after the correction. `aspect` is the width of the
        picture divided by its height.
        """
        chain, skeleton = _find_chain(self.figure, pair), self.figure.motion.skeleton
        before, after = self.poses(pair)
        own = tuple(c for c in self.chains if c.person == chain.person)
        facing, body = (
            figure_facing_direction(after[1], own, self._up),
            self._people.get(chain.person, ()),
        )
        above = int(skeleton.parents[chain.parent])
        side = best_limb_error_view(
            chain, self.bones, before, after, facing, self._up,
            skeleton=skeleton, height=self.height, above=above, body=body,
        )  # fmt: skip
        camera = OrbitCamera(np.zeros(3), 0.0, 0.0, self.height, self._up, facing)
        if side is not None:
            camera = replace(side, margin=_MARGIN).camera(camera, self.height, aspect)
        return _above_ground(camera, self.ground, self.height)

    def player(self) -> dict[str, Any]:
        """Return the figure, its views and its scripts as JSON data for a page that plays the clip.

        If three.js is missing, the result has only the key `problem`.
        """
        try:
            library = three_js()
        except TwistError as error:
            return {"problem": str(error)}
        skeleton = self.figure.motion.skeleton
        data = figure_data(skeleton, self.bones, self._up, self.height, self.ground)
        data["skin"] = skin_data(self.bones, self.chains, self.height)
        return {
            "figure": data,
            "themes": {"light": theme_data(LIGHT), "dark": theme_data(DARK)},
            "ghost": GHOST_ALPHA,
            "scripts": [library, *map(read_page_asset, FIGURE_SCRIPTS)],
            "views": [self._view(pair) for pair in self.figure.views],
        }

    def _view(self, pair: BeforeAfter) -> dict[str, Any]:
        """Return JSON data to show a pair: the camera, the limb's bones and the person's joints.

        A pair consists of the frames before and after the correction.
        """
        camera, chain = self.camera(pair, 1.0), _find_chain(self.figure, pair)
        every = range(len(self.figure.motion.skeleton))
        return {
            "ahead": camera.ahead.tolist(),
            "target": camera.target.tolist(),
            **{name: getattr(camera, name) for name in ("azimuth", "elevation", "distance")},
            "strong": emphasised_bone_indices(self.bones, chain, self.figure.motion.skeleton),
            "body": list(self._people.get(chain.person) or every),
        }


def _above_ground(camera: OrbitCamera, ground: Ground, height: float) -> OrbitCamera:
    """Return the camera, raised if the grid on the ground would cover the figure."""
    rise = (ground.level + _EYE * height - float(camera.target @ camera.up)) / camera.distance
    lowest_angle = float(np.arcsin(np.clip(rise, -1.0, 1.0)))
    return replace(camera, elevation=max(camera.elevation, lowest_angle)).orbited(0.0, 0.0)


def _find_chain(figure: Figure, pair: BeforeAfter) -> Chain:
    return next(chain for chain in figure.chains if chain.name == pair.chain)
