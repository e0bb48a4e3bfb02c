"""A figure to be drawn: the solid one with its shadow, and the ghost around it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport import opengl
from inspector.viewport.bodies import JOINT, STRIPE, BoneSegment, Soup, build_soup, place
from inspector.viewport.bone_colours import (
    ghost_paint,
    mix,
    paint,
    palette,
    rgb,
    scale_paint,
)
from inspector.viewport.ground import Ground, shadow_points
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.striped_skin import Skin, build_skin, drape
from inspector.widgets.theme import Theme
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.rotation import Array, geodesic_angle

_GROWN = 1.09  # the ghost lies around a solid body of the same pose, not in its faces
_FAINT = 64  # alpha of a body that only stands by
SAME = np.radians(0.05)  # bones that differ by less are not shown apart


class Style(StrEnum):
    """What bodies look like."""

    WEDGES = "wedge bones"
    SKIN = "skinned limbs"


@dataclass(frozen=True, eq=False)
class Pose:
    """What one frame looks like.

    rotations (joints, 4), positions (joints, 3): the solid figure; roles (bones,), of
    bone_colours.Role; ghost: rotations (joints, 4) of the other figure, with which of its bones are
    drawn, (bones,), or None; ghost_positions: (joints, 3), where not those of the solid one;
    offsets: |offset| of the bones, radians, (bones,), where they give the colour; faint: bones that
    only stand by, (bones,), where some do: what is behind them is seen.
    """

    rotations: Array
    positions: Array
    roles: NDArray[np.int64]
    ghost: tuple[Array, NDArray[np.bool_]] | None = None
    offsets: Array | None = None
    ghost_positions: Array | None = None
    faint: NDArray[np.bool_] | None = None


class Shapes:
    """The vertices of a clip's figure in one style, joined by all who draw it."""

    def __init__(
        self,
        style: Style,
        bones: tuple[BoneSegment, ...],
        chains: tuple[Chain, ...],
        height: float,
        *,
        fine: bool | None = None,
    ) -> None:
        """fine: a rounder skin; as the screen's driver can do it where nobody says."""
        self.style = style
        worn = chains if style == Style.SKIN else ()
        fine = not opengl.is_software() if fine is None else fine
        self.skin: Skin = build_skin(bones, worn, height, fine=fine)
        self.bodies: Soup = build_soup(bones, without=self.skin.covered)
        self.around: Soup = build_soup(bones, grown=_GROWN, joints=False, without=self.skin.covered)
        self._parents = np.array([b.parent for b in bones], dtype=np.int64)
        self._ends = [(b.parent, b.child) for b in bones]
        # A wedge turns with its own joint; skin is wrung by the joint below as well.
        self._other = self._parents.copy()
        for number in self.skin.covered:
            self._other[number] = bones[number].child

    def differing(self, before: Array, after: Array) -> NDArray[np.bool_]:
        """Which bones look different in two poses, global rotations (joints, 4); (bones,)."""
        differs = geodesic_angle(before, after) > SAME
        found: NDArray[np.bool_] = differs[self._parents] | differs[self._other]
        return found

    def belonging(self, shape: Soup | Skin, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which vertices belong to chosen bones (bones,) or are of a sphere at their ends, (V,)."""
        own: NDArray[np.bool_] = (shape.bone >= 0) & chosen[shape.bone]
        if isinstance(shape, Soup):
            ends = {j for k in np.flatnonzero(chosen).tolist() for j in self._ends[k]}
            own |= (shape.bone < 0) & np.isin(shape.joint, list(ends))
        return own


class _Figure:
    """Wedges, and skin where there is any: of each the shape, its faces and what goes with them."""

    def __init__(
        self, parts: list[tuple[Soup | Skin, Piece, Piece]], renderer: vtkRenderer
    ) -> None:
        self.parts = parts
        self.pieces = [piece for _, *pieces in parts for piece in pieces]
        for piece in self.pieces:
            piece.add_to(renderer)

    def remove(self) -> None:
        """Take it out of the picture."""
        for piece in self.pieces:
            piece.remove()


class Solid(_Figure):
    """A figure and its shadow in a renderer."""

    def __init__(self, shapes: Shapes, ground: Ground, renderer: vtkRenderer) -> None:
        wedges, skin = shapes.bodies, shapes.skin
        # Without spheres and stripes it is the same shadow of a quarter of the polygons.
        large = ~np.isin(wedges.part[wedges.faces[:, 0]], (JOINT, STRIPE))
        shadows = (wedges, wedges.faces[large]), (skin, skin.faces)
        parts: list[tuple[Soup | Skin, Piece, Piece]] = [
            (
                shape,
                Piece(len(shape.bone), faces=shape.faces, normals=shape is skin).lit(),
                Piece(len(shape.bone), faces=flat, channels=0).unlit(),
            )
            for shape, flat in shadows
            if len(shape.bone)
        ]
        super().__init__(parts, renderer)
        self._shapes, self._ground, self._renderer = shapes, ground, renderer
        self._painted: tuple[bytes, ...] | None = None
        self._faint: list[Piece] = []  # where a pose has some
        self._apart: list[NDArray[np.bool_]] = []  # their vertices

    def colour(self, theme: Theme) -> None:
        """Take over colours; the next pose is painted in them."""
        self._theme = theme
        self._colours = palette(theme)
        self._painted = None
        for _, _, shadow in self.parts:
            shadow.tint(mix(theme.window, "#000000", 0.38 if theme.dark else 0.13))

    def draw(self, pose: Pose) -> None:
        """Move and paint."""
        degrees = b"" if pose.offsets is None else np.round(np.degrees(pose.offsets), 1).tobytes()
        faint = b"" if pose.faint is None else pose.faint.tobytes()
        look = pose.roles.tobytes(), degrees, faint
        afresh = look != self._painted
        if afresh and (self._painted is None or faint != self._painted[2]):
            self._set_apart(pose.faint)
        for k, (shape, faces, shadow) in enumerate(self.parts):
            points, normals = _placed(shape, pose.rotations, pose.positions)
            shadow.move(shadow_points(points, self._ground))
            if afresh:
                self._paint(k, pose)
            if self._faint:
                self._faint[k].move(points)
                points[self._apart[k]] = points[0]  # no area: not drawn
            faces.move(points, normals)
        self._painted = look

    def _paint(self, k: int, pose: Pose) -> None:
        shape, faces, _ = self.parts[k]
        if pose.offsets is None:
            colours = paint(shape, self._colours, pose.roles)
        else:
            colours = scale_paint(shape, self._theme, pose.offsets)
        faces.paint(colours)
        if self._faint:
            alpha = np.full((len(colours), 1), _FAINT, np.uint8)
            self._faint[k].paint(np.hstack([colours, alpha]))

    def _set_apart(self, faint: NDArray[np.bool_] | None) -> None:
        """Find what is faint of the shapes, and make pieces for it."""
        for piece in self._faint:
            piece.remove()
            self.pieces.remove(piece)
        self._faint, self._apart = [], []
        if faint is None:
            return
        for shape, *_ in self.parts:
            apart = ~self._shapes.belonging(shape, ~faint)
            thin = Piece(len(apart), faces=shape.faces[apart[shape.faces[:, 0]]], channels=4)
            thin.unlit(back_faces=False).blended().add_to(self._renderer)
            self._apart.append(apart)
            self._faint.append(thin)
        self.pieces += self._faint


class Ghost(_Figure):
    """The other figure as a thin shell: faces that let the solid through, an outline."""

    def __init__(self, shapes: Shapes, renderer: vtkRenderer) -> None:
        parts: list[tuple[Soup | Skin, Piece, Piece]] = [
            (
                shape,
                Piece(len(shape.bone), faces=shape.faces, channels=4)
                .unlit(back_faces=False)
                .blended(),
                Piece(len(shape.bone), lines=shape.edges, channels=0).unlit(width=2.0),
            )
            for shape in (shapes.around, shapes.skin)
            if len(shape.bone)
        ]
        super().__init__(parts, renderer)

    def colour(self, theme: Theme) -> None:
        """Take over colours."""
        for shape, faces, outline in self.parts:
            faces.paint(ghost_paint(shape, theme))
            outline.tint(rgb(theme.before))

    def draw(self, pose: Pose) -> None:
        """Move it, and show of it what differs."""
        rotations, drawn = pose.ghost or (pose.rotations, None)
        positions = pose.positions if pose.ghost_positions is None else pose.ghost_positions
        for shape, *pieces in self.parts:
            hidden = None if drawn is None else ~drawn[shape.bone]
            shown = hidden is not None and not hidden.all()
            if shown:
                points, _ = _placed(shape, rotations, positions, grown=_GROWN)
                points[hidden] = positions[0]  # no area: not drawn
            for piece in pieces:
                piece.show(shown)
                if shown:
                    piece.move(points)


def _placed(
    shape: Soup | Skin, rotations: Array, positions: Array, *, grown: float = 1.0
) -> tuple[Array, Array | None]:
    """Vertices in the world, and of skin their normals, both (V, 3); wedges have grown already."""
    if isinstance(shape, Skin):
        return drape(shape, rotations, positions, grown=grown)
    return place(shape, rotations, positions), None
