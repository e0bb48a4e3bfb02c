"""A dashed outline of a third figure, in addition to the figures before and after correction."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from PySide6.QtCore import SignalInstance
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport.bodies import BoneSegment, build_soup, pose_soup_vertices
from inspector.viewport.bone_colours import rgb
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.solid_and_ghost import SAME, Pose
from inspector.widgets.theme import Theme
from twistcore.skeleton.rotation import Array, geodesic_angle

_DASHES = 4  # dashes on each edge
_DRAWN = 0.55  # share of a dash that is drawn
_GROWN = 1.16  # thickness relative to normal; larger than the outline of the ghost
_STILL = 5e-4  # relative to the figure's height; smaller movements are ignored


class Companion(Protocol):
    """A source of a third figure. It emits the signal `changed` when the figure has changed."""

    changed: SignalInstance

    def pose(self, frame: int) -> tuple[Array, Array] | None:
        """Return the pose of the third figure in a frame, or None if there is no figure.

        The pose consists of the global rotations (joints, 4) and positions (joints, 3).
        """


class DashedOutline:
    """A dashed outline of those parts of the third figure that differ from the solid figure."""

    def __init__(
        self, bones: tuple[BoneSegment, ...], height: float, renderer: vtkRenderer
    ) -> None:
        self._soup = build_soup(bones, grown=_GROWN, joints=False)
        self._bones = np.array([b.parent for b in bones], dtype=np.int64)
        self._still = _STILL * height
        starts = np.arange(_DASHES) / _DASHES
        self._shares = np.stack([starts, starts + _DRAWN / _DASHES], axis=1).ravel()
        count = len(self._soup.edges) * len(self._shares)
        lines = np.arange(count).reshape(-1, 2)
        self._piece = Piece(count, lines=lines, channels=0).unlit(width=2.0).add_to(renderer)
        self._piece.show(False)

    @property
    def shown(self) -> bool:
        """True if any part of the third figure is drawn."""
        return self._piece.shown

    def colour(self, theme: Theme) -> None:
        """Apply the theme's colours."""
        self._piece.tint(rgb(theme.tracked))

    def draw(self, figure: tuple[Array, Array] | None, solid: Pose) -> None:
        """Draw the parts of the third figure that differ from the solid figure."""
        if figure is None:
            self._piece.show(False)
            return
        rotations, positions = figure
        moved = np.linalg.norm(positions - solid.positions, axis=-1) > self._still
        differs = (geodesic_angle(rotations, solid.rotations) > SAME) | moved
        drawn = differs[self._bones]
        self._piece.show(bool(drawn.any()))
        if not self._piece.shown:
            return
        points = pose_soup_vertices(self._soup, rotations, positions)
        points[~drawn[self._soup.bone]] = positions[0]  # edges without a length are not drawn
        start, stop = points[self._soup.edges].swapaxes(0, 1)
        dashes = start[:, None] + self._shares[:, None] * (stop - start)[:, None]
        self._piece.move(dashes.reshape(-1, 3))

    def remove(self) -> None:
        """Remove the outline from the view."""
        self._piece.remove()
