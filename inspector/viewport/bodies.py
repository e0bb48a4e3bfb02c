"""Bodies of a skeleton: wedges in which roll is plain to see, rigidly attached to joints.

The body of the bone P→C hangs on P, as the bone itself does: a twist error of P rolls it.
Everything is built once per clip as one soup of vertices in joint coordinates; a frame is one
gather of rotation matrices.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from twistcore.motion import Motion
from twistcore.rotation import Array, matrix_from_quaternion, normalise

Index = NDArray[np.int64]

# What a vertex belongs to; its colour follows. SKIN and BAND: light and dark stripes of a limb.
FRONT, BACK, SIDE, STRIPE, JOINT, SKIN, BAND = PARTS = range(7)
_SHORTEST = 1e-4  # of the height: a shorter bone gets no body

# The wedge along its bone: (where 0…1, half the width, half the thickness); widths and thickness
# in units of the bone's width. It is widest near the parent, so the bone's direction shows too.
_STATIONS = ((0.03, 0.42, 0.20), (0.16, 1.0, 0.36), (0.97, 0.46, 0.17))
# The stripe is a rail on one edge, thinner than it: from the side the wedge's own colour is seen
# on either hand of it, and a turn by 180° shows in the outline.
_RAIL = (0.80, 1.24)
_RAIL_THICK = 0.42


@dataclass(frozen=True, eq=False)
class Bone:
    """A straight piece from a joint to its child or End Site.

    parent: the joint whose rotation it has; child: −1 at an End Site; tip: (3,) in the parent's
    coordinates; normal: the unit normal of its front face, there too; width: half of it.
    """

    parent: int
    child: int
    tip: Array
    normal: Array
    width: float


@dataclass(frozen=True, eq=False)
class Soup:
    """Polygons whose vertices are rigidly attached to joints.

    vertices: (V, 3) in joint coordinates; joint, bone, part: (V,), bone −1 on the spheres of
    joints; faces: VTK's padded list of polygons; edges: its list of lines; blocks: the vertices
    again as (first, stop, joints), of whose joints each has equally many of them, in turn.
    """

    vertices: Array
    joint: Index
    bone: Index
    part: Index
    faces: Index
    edges: Index
    blocks: tuple[tuple[int, int, Index], ...]


def find_bones(motion: Motion, up: Array, height: float) -> tuple[Bone, ...]:
    """Every bone with a length, sized by it and by the figure's height; End Sites included."""
    skeleton = motion.skeleton
    pieces = [
        (int(p), j, _offset(motion, j))
        for j, p in enumerate(skeleton.parents)
        if p >= 0 and not _is_free(motion, j)
    ]
    pieces += [(joint, -1, np.asarray(offset)) for joint, offset in skeleton.ends]
    bones = []
    for parent, child, tip in pieces:
        length = float(np.linalg.norm(tip))
        if length < _SHORTEST * height:
            continue
        # Thin enough to keep its direction, broad enough to have a face.
        width = np.clip(0.15 * length, 0.009 * height, 0.026 * height)
        width = min(float(width), 0.35 * length)
        bones.append(Bone(parent, child, tip, _front(tip / length, up), width))
    return tuple(bones)


def build_soup(
    bones: tuple[Bone, ...],
    *,
    grown: float = 1.0,
    joints: bool = True,
    without: frozenset[int] = frozenset(),
) -> Soup:
    """The wedges of all bones, across the bone `grown` times as large, and spheres at joints.

    without: numbers of bones that something else covers.
    """
    builder = _Builder()
    kept = [(n, bone) for n, bone in enumerate(bones) if n not in without]
    for number, bone in kept:
        _add_wedge(builder, number, bone, grown)
    if joints:
        radius: dict[int, float] = {}
        for _, bone in kept:
            for joint in (bone.parent, bone.child):
                radius[joint] = max(radius.get(joint, 0.0), 0.50 * bone.width)
        radius.pop(-1, None)
        for joint, r in radius.items():
            builder.polygons(r * SPHERE, TRIANGLES, joint, -1, JOINT)
    return builder.soup()


def faces_without(soup: Soup, *parts: int) -> Index:
    """VTK's list of the polygons that belong to no such part: for a shadow, what is small."""
    kept = [face for face in cells_of(soup.faces) if soup.part[face[1]] not in parts]
    return np.concatenate(kept) if kept else soup.faces[:0]


def cells_of(padded: Index) -> Iterator[Index]:
    """The cells of VTK's padded list, as views: how many points there are, and which."""
    at = 0
    while at < len(padded):
        stop = at + 1 + int(padded[at])
        yield padded[at:stop]
        at = stop


def place(soup: Soup, rotations: Array, positions: Array) -> Array:
    """Vertices in the world, (V, 3), from global rotations (joints, 4), positions (joints, 3)."""
    matrices = matrix_from_quaternion(rotations).transpose(0, 2, 1)
    world = np.empty(soup.vertices.shape)
    for first, stop, joints in soup.blocks:
        shape = (len(joints), -1, 3)
        out = world[first:stop].reshape(shape)
        np.matmul(soup.vertices[first:stop].reshape(shape), matrices[joints], out=out)
        out += positions[joints][:, None]
    return world


def _is_free(motion: Motion, joint: int) -> bool:
    """True of hips that move against a root on the ground: no bone joins the two."""
    below_root = motion.skeleton.parents[motion.skeleton.parents[joint]] < 0
    offset = motion.translation(joint)
    return bool(below_root and offset.ndim == 2 and np.ptp(offset, axis=0).any())


def _offset(motion: Motion, joint: int) -> Array:
    """The joint's place in its parent's coordinates, (3,): the median where channels move it."""
    offset = motion.translation(joint)
    if offset.ndim == 2:
        still: Array = np.median(offset, axis=0)
        return still if still.any() else motion.skeleton.offsets[joint]
    return offset


def _front(axis: Array, up: Array) -> Array:
    """The unit normal of the front face: forward in the rest pose, or up for a bone that points so.

    All rotations are zero in the rest pose, so P's coordinates are the world's there.
    """
    forward = np.array([0.0, 0.0, 1.0]) if up[1] > 0.5 else np.array([0.0, -1.0, 0.0])
    normal = forward - (forward @ axis) * axis
    if np.linalg.norm(normal) < 0.5:
        normal = up - (up @ axis) * axis
    return normalise(normal)


def _add_wedge(builder: _Builder, number: int, bone: Bone, grown: float) -> None:
    """Three stations of a flattened box, with a ridge along one of its edges."""
    v = np.cross(bone.normal, normalise(bone.tip))  # across the face; the stripe is on +v
    n, w = bone.normal, bone.width * grown

    def ring(at: float, low: float, high: float, thick: float) -> Array:
        centre = at * bone.tip
        corners = [(high, thick), (low, thick), (low, -thick), (high, -thick)]
        return np.array([centre + w * (x * v + y * n) for x, y in corners])

    rings = [ring(at, -half, half, thick) for at, half, thick in _STATIONS]
    stripe = [
        ring(at, _RAIL[0] * half, _RAIL[1] * half, _RAIL_THICK * thick)
        for at, half, thick in _STATIONS
    ]
    for shape, parts in ((rings, (FRONT, SIDE, BACK, SIDE)), (stripe, (STRIPE,) * 4)):
        for lower, upper in pairwise(shape):
            for k, part in enumerate(parts):
                m = (k + 1) % 4
                corners = np.array([lower[k], lower[m], upper[m], upper[k]])
                builder.polygon(corners, bone.parent, number, part)
        cap = SIDE if parts[1] == SIDE else STRIPE
        builder.polygon(shape[0][::-1], bone.parent, number, cap)
        builder.polygon(shape[-1], bone.parent, number, cap)
    for k in range(4):  # the outline of the wedge, for the ghost
        builder.line([r[k] for r in rings], bone.parent, number, SIDE)
    for r in rings:
        builder.line([*r, r[0]], bone.parent, number, SIDE)


class _Builder:
    """Collects polygons; those of a wedge share no vertex, since each has a colour of its own."""

    def __init__(self) -> None:
        self._vertices: list[Array] = []
        self._tags: list[tuple[int, int, int]] = []
        self._faces: list[int] = []
        self._edges: list[int] = []

    def polygon(self, corners: Array, joint: int, bone: int, part: int) -> None:
        self._faces += self._add(list(corners), joint, bone, part)

    def polygons(self, corners: Array, faces: Index, joint: int, bone: int, part: int) -> None:
        first = self._add(list(corners), joint, bone, part)[1]
        for face in faces:
            self._faces += [len(face), *(first + face)]

    def line(self, corners: list[Array], joint: int, bone: int, part: int) -> None:
        self._edges += self._add(corners, joint, bone, part)

    def _add(self, corners: list[Array], joint: int, bone: int, part: int) -> list[int]:
        first = len(self._vertices)
        self._vertices += corners
        self._tags += [(joint, bone, part)] * len(corners)
        return [len(corners), *range(first, first + len(corners))]

    def soup(self) -> Soup:
        tags = np.array(self._tags, dtype=np.int64).reshape(-1, 3)
        return Soup(
            np.array(self._vertices).reshape(-1, 3),
            tags[:, 0],
            tags[:, 1],
            tags[:, 2],
            np.array(self._faces, dtype=np.int64),
            np.array(self._edges, dtype=np.int64),
            _blocks(tags),
        )


def _blocks(tags: Index) -> tuple[tuple[int, int, Index], ...]:
    """Runs of one joint and bone, (joint, bone, part) by vertex, put together by their size."""
    if not len(tags):
        return ()
    ends = np.flatnonzero((np.diff(tags[:, :2], axis=0) != 0).any(axis=1)) + 1
    starts = np.concatenate([[0], ends])
    sizes = np.diff(np.concatenate([starts, [len(tags)]]))
    changes = np.concatenate([[0], np.flatnonzero(np.diff(sizes)) + 1, [len(sizes)]])
    return tuple(
        (int(starts[a]), int(starts[b - 1] + sizes[b - 1]), tags[starts[a:b], 0])
        for a, b in pairwise(changes)
    )


def _sphere() -> tuple[Array, Index]:
    """A unit icosahedron once subdivided: corners (42, 3), triangles (80, 3)."""
    g = (1.0 + 5.0**0.5) / 2.0
    signs = [(s, t * g) for s in (-1, 1) for t in (-1, 1)]
    corners = [(s, t, 0.0) for s, t in signs] + [(0.0, s, t) for s, t in signs]
    twelve = normalise(corners + [(t, 0.0, s) for s, t in signs])
    gap = np.linalg.norm(twelve[:, None] - twelve[None], axis=-1)
    near = (gap > 0.1) & (gap < 1.1)
    edges = [(i, j) for i in range(12) for j in range(i + 1, 12) if near[i, j]]
    middle = {edge: 12 + k for k, edge in enumerate(edges)}
    points = np.vstack([twelve, normalise([twelve[i] + twelve[j] for i, j in edges])])
    faces = []
    for i, j in edges:
        for k in range(j + 1, 12):
            if near[i, k] and near[j, k]:
                ij, jk, ik = middle[i, j], middle[j, k], middle[i, k]
                faces += [(i, ij, ik), (j, jk, ij), (k, ik, jk), (ij, jk, ik)]
    return points, np.array(faces, dtype=np.int64)


SPHERE, TRIANGLES = _sphere()
