"""A figure to be drawn: the solid one with its shadow, and the ghost around it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport import opengl
from inspector.viewport.bodies import (
    JOINT,
    STRIPE,
    Bone,
    Soup,
    build_soup,
    collapse,
    faces_without,
    place,
)
from inspector.viewport.bone_colours import ghost_paint, mix, paint, palette, rgb, scale_paint
from inspector.viewport.ground import Ground, shadow_points
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.striped_skin import Skin, build_skin, drape
from inspector.widgets.theme import Theme
from twistcore.chain import Chain
from twistcore.rotation import Array, geodesic_angle

_GROWN = 1.09  # the ghost lies around a solid body of the same pose, not in its faces
_SAME = np.radians(0.05)  # bones that differ by less are not shown apart


class Style(StrEnum):
    """What bodies look like."""

    WEDGES = "wedge bones"
    SKIN = "skinned limbs"


@dataclass(frozen=True, eq=False)
class Pose:
    """What one frame looks like.

    rotations (joints, 4), positions (joints, 3): the solid figure; roles (bones,), of paint.Role;
    ghost: rotations (joints, 4) of the other figure, with which of its bones are drawn,
    (bones,), or None; offsets: |offset| of the bones, radians, (bones,), where they give the
    colour.
    """

    rotations: Array
    positions: Array
    roles: NDArray[np.int64]
    ghost: tuple[Array, NDArray[np.bool_]] | None = None
    offsets: Array | None = None


class Shapes:
    """The vertices of a clip's figure in one style, joined by all who draw it."""

    def __init__(
        self, style: Style, bones: tuple[Bone, ...], chains: tuple[Chain, ...], height: float
    ) -> None:
        self.style = style
        worn = chains if style == Style.SKIN else ()
        self.skin: Skin = build_skin(bones, worn, height, fine=not opengl.is_software())
        self.bodies: Soup = build_soup(bones, without=self.skin.covered)
        self.around: Soup = build_soup(bones, grown=_GROWN, joints=False, without=self.skin.covered)
        self._parents = np.array([b.parent for b in bones], dtype=np.int64)
        self.covered = np.zeros(len(bones), dtype=bool)
        self.covered[list(self.skin.covered)] = True
        # A wedge turns with its own joint; skin is wrung by the joint below as well.
        self._other = self._parents.copy()
        for number in self.skin.covered:
            self._other[number] = bones[number].child

    def differing(self, before: Array, after: Array) -> NDArray[np.bool_]:
        """Which bones look different in two poses, global rotations (joints, 4); (bones,)."""
        differs = geodesic_angle(before, after) > _SAME
        found: NDArray[np.bool_] = differs[self._parents] | differs[self._other]
        return found


class Solid:
    """A figure and its shadow in a renderer."""

    def __init__(self, shapes: Shapes, ground: Ground, renderer: vtkRenderer) -> None:
        self.shapes = shapes
        self._ground = ground
        wedges, skin = shapes.bodies, shapes.skin
        count, covered = len(wedges.vertices), len(skin.bone)
        self._wedges = Piece(count, faces=wedges.faces).lit()
        # Without spheres and stripes it is the same shadow of a quarter of the polygons.
        flat = faces_without(wedges, JOINT, STRIPE)
        self._shadow = Piece(count, faces=flat, channels=0).unlit()
        self.pieces = [self._shadow, self._wedges]
        self._tubes: Piece | None = None
        if covered:
            self._tubes = Piece(covered, faces=skin.faces, normals=True).lit()
            self._tubes_shadow = Piece(covered, faces=skin.faces, channels=0).unlit()
            self.pieces += [self._tubes_shadow, self._tubes]
        for piece in self.pieces:
            piece.add_to(renderer)
        self._painted: tuple[bytes, bytes] | None = None

    def set_theme(self, theme: Theme) -> None:
        """Take over colours; the next pose is painted in them."""
        self._theme = theme
        self._colours = palette(theme)
        self._painted = None
        shade = mix(theme.window, "#000000", 0.38 if theme.dark else 0.13)
        self._shadow.tint(shade)
        if self._tubes is not None:
            self._tubes_shadow.tint(shade)

    def draw(self, pose: Pose) -> None:
        """Move and paint."""
        points = place(self.shapes.bodies, pose.rotations, pose.positions)
        self._wedges.points[:] = points
        self._shadow.points[:] = shadow_points(points, self._ground)
        self._wedges.moved()
        self._shadow.moved()
        if self._tubes is not None:
            points, normals = drape(self.shapes.skin, pose.rotations, pose.positions)
            self._tubes.points[:] = points
            self._tubes.normals[:] = normals
            self._tubes_shadow.points[:] = shadow_points(points, self._ground)
            self._tubes.moved()
            self._tubes_shadow.moved()
        degrees = b"" if pose.offsets is None else np.round(np.degrees(pose.offsets), 1).tobytes()
        look = pose.roles.tobytes(), degrees
        if look != self._painted:
            self._painted = look
            for piece, shape in ((self._wedges, self.shapes.bodies), (self._tubes, self._skin)):
                if piece is not None:
                    piece.colours[:] = self._paint(shape, pose)
                    piece.painted()

    @property
    def _skin(self) -> Skin:
        return self.shapes.skin

    def _paint(self, shape: Soup | Skin, pose: Pose) -> NDArray[np.uint8]:
        if pose.offsets is None:
            return paint(shape, self._colours, pose.roles)
        return scale_paint(shape, self._theme, pose.offsets)

    def remove(self) -> None:
        """Take it out of the picture."""
        for piece in self.pieces:
            piece.remove()


class Ghost:
    """The other figure as a thin shell: faces that let the solid through, an outline."""

    def __init__(self, shapes: Shapes, renderer: vtkRenderer) -> None:
        self.shapes = shapes
        around, skin = shapes.around, shapes.skin
        count, covered = len(around.vertices), len(skin.bone)
        self._wedges = Piece(count, faces=around.faces, channels=4).unlit(back_faces=False)
        self._outline = Piece(count, lines=around.edges, channels=0).unlit(width=2.0)
        self.pieces = [self._wedges.blended(), self._outline]
        self._tubes: Piece | None = None
        self._edges: Piece | None = None
        if covered:
            self._tubes = Piece(covered, faces=skin.faces, channels=4).unlit(back_faces=False)
            self._edges = Piece(covered, lines=skin.edges, channels=0).unlit(width=2.0)
            self.pieces += [self._tubes.blended(), self._edges]
        for piece in self.pieces:
            piece.add_to(renderer)

    def set_theme(self, theme: Theme) -> None:
        """Take over colours."""
        for piece in (self._outline, self._edges):
            if piece is not None:
                piece.tint(rgb(theme.before))
        for piece, shape in ((self._wedges, self.shapes.around), (self._tubes, self.shapes.skin)):
            if piece is not None:
                piece.colours[:] = ghost_paint(shape, theme)
                piece.painted()

    def draw(self, pose: Pose) -> None:
        """Move it, and show of it what differs."""
        shapes, covered = self.shapes, self.shapes.covered
        drawn = np.zeros_like(covered) if pose.ghost is None else pose.ghost[1]
        rotations = pose.rotations if pose.ghost is None else pose.ghost[0]
        bare = bool((drawn & ~covered).any())
        for piece in (self._wedges, self._outline):
            piece.show(bare)
        if bare:
            points = place(shapes.around, rotations, pose.positions)
            collapse(points, shapes.around, pose.positions, drawn)
            for piece in (self._wedges, self._outline):
                piece.points[:] = points
                piece.moved()
        worn = bool((drawn & covered).any())
        if worn:
            points, _ = drape(shapes.skin, rotations, pose.positions, grown=_GROWN)
            points[~drawn[shapes.skin.bone]] = pose.positions[0]  # no area: not drawn
        for piece in (self._tubes, self._edges):
            if piece is not None:
                piece.show(worn)
                if worn:
                    piece.points[:] = points
                    piece.moved()

    def remove(self) -> None:
        """Take it out of the picture."""
        for piece in self.pieces:
            piece.remove()
