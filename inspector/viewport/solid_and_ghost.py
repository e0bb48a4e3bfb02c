"""The solid figure with its shadow, and the ghost: a translucent figure in a different pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from vtkmodules.vtkRenderingCore import vtkRenderer

from inspector.viewport import opengl
from inspector.viewport.bodies import (
    JOINT,
    STRIPE,
    Attached,
    BoneSegment,
    Soup,
    build_soup,
    pose_soup_vertices,
)
from inspector.viewport.bone_colours import (
    bone_role_colours,
    ghost_vertex_colours,
    mix,
    rgb,
    vertex_colours_by_offset,
    vertex_colours_by_role,
)
from inspector.viewport.ground import Ground, shadow_points
from inspector.viewport.mesh_actor import Piece
from inspector.viewport.striped_skin import Skin, build_skin, pose_skin
from inspector.widgets.theme import Theme
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.rotation import Array, geodesic_angle

_GROWN = 1.09  # thickness of the ghost relative to the solid figure
_FAINT = 100  # opacity of a translucent body, 0…255
SAME = np.radians(0.05)  # rotations that differ by less are treated as equal


class Style(StrEnum):
    """The style of the bodies."""

    WEDGES = "wedge bones"
    SKIN = "skinned limbs"


@dataclass(frozen=True, eq=False)
class Pose:
    """The poses of the solid figure and the ghost in a frame, with the data for their colours.

    Attributes
    ----------
    rotations, positions
        The global rotations (joints, 4) and positions (joints, 3) of the solid figure.
    roles
        The role of each bone, from bone_colours.Role, (bones,).
    ghost
        The global rotations of the ghost, (joints, 4), and a mask of the bones for which the ghost
        is drawn, (bones,). None hides the ghost.
    offsets
        The |offset| of each bone in radians, (bones,), if it determines the colours. None if the
        roles determine the colours.
    ghost_positions
        The positions of the ghost, (joints, 3). None if the ghost has the same `positions`.
    faint
        A mask of the bones, heads and chests that are translucent, (bodies,), or None.
    """

    rotations: Array
    positions: Array
    roles: NDArray[np.int64]
    ghost: tuple[Array, NDArray[np.bool_]] | None = None
    offsets: Array | None = None
    ghost_positions: Array | None = None
    faint: NDArray[np.bool_] | None = None

    def is_at(self, other: Pose) -> bool:
        """Return True if both poses have equal rotations and positions. Colours are ignored."""
        pairs = (self.rotations, other.rotations), (self.positions, other.positions)
        return all(one is two or np.array_equal(one, two) for one, two in pairs)


class Shapes:
    """The shapes of a clip's bodies in one style. All figures share them.

    Attributes
    ----------
    style
        The style of the bodies.
    skin
        The skin of the limbs. It has no vertices if the style is wedges.
    bodies
        The bodies of the solid figure that the skin does not cover.
    around
        The wedges of the ghost, slightly thicker and without spheres at joints.
    """

    def __init__(
        self,
        style: Style,
        bones: tuple[BoneSegment, ...],
        chains: tuple[Chain, ...],
        height: float,
        *,
        fine: bool | None = None,
        attached: Sequence[Attached] = (),
    ) -> None:
        """Build the shapes for all poses of a clip.

        Parameters
        ----------
        style
            The style of the bodies.
        bones
            All bones of the figures.
        chains
            The chains whose bones have skin if the style is skin.
        height
            The height of the figure.
        fine
            True for a rounder skin. By default, this is True if OpenGL uses a graphics processor.
        attached
            Additional bodies, such as heads and chests.
        """
        self.style = style
        worn = chains if style == Style.SKIN else ()
        fine = not opengl.is_software() if fine is None else fine
        self.skin: Skin = build_skin(bones, worn, height, fine=fine)
        self.bodies: Soup = build_soup(bones, without=self.skin.covered, attached=attached)
        self.around: Soup = build_soup(bones, grown=_GROWN, joints=False, without=self.skin.covered)
        # Index of the attached body of each of its vertices, which are the last vertices
        self._attached = np.repeat(np.arange(len(attached)), [len(a.vertices) for a in attached])
        self._parents = np.array([b.parent for b in bones], dtype=np.int64)
        self._ends = [(b.parent, b.child) for b in bones]
        # In addition to the parent, the shape of a bone may depend on a second joint: the joint at
        # the end of a bone twists its skin. Wedges depend on the parent only, which is repeated.
        self._other = self._parents.copy()
        for number in self.skin.covered:
            self._other[number] = bones[number].child

    def differing(self, before: Array, after: Array) -> NDArray[np.bool_]:
        """Return a mask of the bones that look different in two poses, (bones,).

        `before` and `after` are the global rotations of the joints, (joints, 4).
        """
        differs = geodesic_angle(before, after) > SAME
        found: NDArray[np.bool_] = differs[self._parents] | differs[self._other]
        return found

    def turned(self, before: Array, after: Array) -> NDArray[np.bool_]:
        """Return a mask of the bones that are rotated between two poses, (bones,).

        A bone is excluded if its skin is twisted only by the joint at its end. `before` and `after`
        are the global rotations of the joints, (joints, 4).
        """
        found: NDArray[np.bool_] = (geodesic_angle(before, after) > SAME)[self._parents]
        return found

    def belonging(self, shape: Soup | Skin, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Return a mask of the vertices that belong to given bodies or the spheres at their ends.

        Parameters
        ----------
        shape
            The bodies or the skin.
        chosen
            A mask of these bodies among the bones, heads and chests, (bodies,).

        Returns
        -------
        ndarray of bool
            The mask, (vertices,).
        """
        bones, attached = np.split(chosen, [len(self._ends)])
        own: NDArray[np.bool_] = (shape.bone >= 0) & bones[shape.bone]
        if isinstance(shape, Soup):
            ends = {j for k in np.flatnonzero(bones).tolist() for j in self._ends[k]}
            balls = (shape.bone < 0) & (shape.part == JOINT)
            own |= balls & np.isin(shape.joint, list(ends))
            own[len(own) - len(self._attached) :] = attached[self._attached]
        return own


class _Figure:
    """The meshes of a figure in a renderer.

    Attributes
    ----------
    parts
        Each shape with the mesh of its faces and the mesh of its shadow or outline.
    pieces
        All meshes.
    """

    def __init__(
        self, parts: list[tuple[Soup | Skin, Piece, Piece]], renderer: vtkRenderer
    ) -> None:
        self.parts = parts
        self.pieces = [piece for _, *pieces in parts for piece in pieces]
        for piece in self.pieces:
            piece.add_to(renderer)

    def remove(self) -> None:
        """Remove the figure from the view."""
        for piece in self.pieces:
            piece.remove()


class Solid(_Figure):
    """The solid figure and its shadow in a renderer."""

    def __init__(self, shapes: Shapes, ground: Ground, renderer: vtkRenderer) -> None:
        wedges, skin = shapes.bodies, shapes.skin
        # Shadows of spheres and stripes are left out, because they would be inside the other
        # shadows. This reduces the number of polygons to a quarter.
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
        # Roles, offsets and translucent bodies when the vertices were last coloured
        self._painted: tuple[bytes, ...] | None = None
        # The last drawn pose and, for each shape, its vertices, normals and shadow
        self._pose: Pose | None = None
        self._places: list[tuple[Array, Array | None, Array]] = []
        self._faint: list[Piece] = []  # for each shape, the mesh of its translucent bodies
        self._apart: list[NDArray[np.bool_]] = []  # masks of the vertices of these bodies

    def colour(self, theme: Theme) -> None:
        """Set the theme. The next call of `draw` applies its colours to the bodies."""
        self._theme = theme
        self._colours = bone_role_colours(theme)
        self._painted = None
        for _, _, shadow in self.parts:
            shadow.tint(mix(theme.window, "#000000", 0.38 if theme.dark else 0.13))

    def draw(self, pose: Pose, like: Solid | None = None) -> None:
        """Draw a pose.

        `like` is a solid figure with the same shapes in a different image. If it shows the same
        pose, its vertices are reused.
        """
        if like is not None and like._pose is not None and pose.is_at(like._pose):
            self._places = like._places
        else:
            self._places = [self._placed(shape, pose) for shape, *_ in self.parts]
        self._pose = pose
        degrees = b"" if pose.offsets is None else np.round(np.degrees(pose.offsets), 1).tobytes()
        faint = b"" if pose.faint is None else pose.faint.tobytes()
        look = pose.roles.tobytes(), degrees, faint
        changed = look != self._painted
        if changed and (self._painted is None or faint != self._painted[2]):
            self._set_apart(pose.faint)
        for k, (_, faces, shadow) in enumerate(self.parts):
            points, normals, below = self._places[k]
            shadow.move(below)
            if changed:
                self._paint(k, pose)
            if self._faint:
                self._faint[k].move(points)
                points = points.copy()
                points[self._apart[k]] = points[0]  # faces of zero area are not drawn
            faces.move(points, normals)
        self._painted = look

    def _placed(self, shape: Soup | Skin, pose: Pose) -> tuple[Array, Array | None, Array]:
        """Return the vertices of a shape in a pose, its normals and its shadow.

        All arrays are (vertices, 3). The normals are None for wedges.
        """
        points, normals = _placed(shape, pose.rotations, pose.positions)
        return points, normals, shadow_points(points, self._ground)

    def _paint(self, k: int, pose: Pose) -> None:
        shape, faces, _ = self.parts[k]
        if pose.offsets is None:
            colours = vertex_colours_by_role(shape, self._colours, pose.roles)
        else:
            colours = vertex_colours_by_offset(shape, self._theme, pose.offsets)
        faces.paint(colours)
        if self._faint:
            alpha = np.full((len(colours), 1), _FAINT, np.uint8)
            self._faint[k].paint(np.hstack([colours, alpha]))

    def _set_apart(self, faint: NDArray[np.bool_] | None) -> None:
        """Create separate meshes for the translucent bodies.

        `faint` is a mask of these bodies among the bones, heads and chests, (bodies,), or None if
        none is translucent.
        """
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
    """The ghost in a renderer: a translucent shell with an outline."""

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
        """Apply the theme's colours."""
        for shape, faces, outline in self.parts:
            faces.paint(ghost_vertex_colours(shape, theme))
            outline.tint(rgb(theme.before))

    def draw(self, pose: Pose) -> None:
        """Draw the ghost for the bones that the mask in `pose.ghost` selects."""
        rotations, drawn = pose.ghost or (pose.rotations, None)
        positions = pose.positions if pose.ghost_positions is None else pose.ghost_positions
        for shape, *pieces in self.parts:
            hidden = None if drawn is None else ~drawn[shape.bone]
            shown = hidden is not None and not hidden.all()
            if shown:
                points, _ = _placed(shape, rotations, positions, grown=_GROWN)
                points[hidden] = positions[0]  # faces of zero area are not drawn
            for piece in pieces:
                piece.show(shown)
                if shown:
                    piece.move(points)


def _placed(
    shape: Soup | Skin, rotations: Array, positions: Array, *, grown: float = 1.0
) -> tuple[Array, Array | None]:
    """Return the vertices of a shape in world space and, for skin, the normals.

    Parameters
    ----------
    shape
        The wedges or the skin.
    rotations, positions
        The global rotations (joints, 4) and positions (joints, 3).
    grown
        The thickness of skin relative to its normal thickness. Wedges already have their final
        thickness.

    Returns
    -------
    tuple of ndarray
        The vertices and the normals, each (vertices, 3). The normals are None for wedges.
    """
    if isinstance(shape, Skin):
        return pose_skin(shape, rotations, positions, grown=grown)
    return pose_soup_vertices(shape, rotations, positions), None
