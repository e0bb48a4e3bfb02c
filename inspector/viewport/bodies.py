"""Bodies for the bones of a skeleton: wedges that make roll visible.

The body of a bone is rigidly attached to the parent joint, so a twist error of the parent rolls
the body. All vertices of a clip are computed once, in the local coordinates of their joints. In
each frame, they are only transformed by the pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pyvista as pv

from inspector.viewport.mesh_actor import Index, segments
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, matrix_from_quaternion, normalise, rotate

# The part to which a vertex belongs, which determines its colour. SKIN and BAND are the light and
# dark stripes of a limb's skin, and FIN is the edge of the fin along its front.
FRONT, BACK, SIDE, STRIPE, JOINT, SKIN, BAND, FIN = PARTS = range(8)
_SHORTEST = 1e-4  # relative to the figure's height; shorter bones get no body

# Cross-sections of the wedge: (position along the bone 0…1, half width, half thickness), relative
# to the width of the bone. The wedge is widest near the parent, which shows the bone's direction.
_STATIONS = ((0.03, 0.42, 0.20), (0.16, 1.0, 0.36), (0.97, 0.46, 0.17))
# The stripe is a thin rail on one edge, with the colour of the wedge on both sides, so that a roll
# by 180° also changes the outline.
_RAIL = (0.80, 1.24)
_RAIL_THICK = 0.42


@dataclass(frozen=True, eq=False)
class BoneSegment:
    """A bone from a joint to its child or End Site.

    Attributes
    ----------
    parent
        The joint that rotates the bone.
    child
        The child, or −1 for an End Site.
    tip
        The end of the bone in the parent's coordinates, (3,).
    normal
        The unit normal of the front face in the parent's coordinates, (3,).
    width
        Half the width of the bone.
    """

    parent: int
    child: int
    tip: Array
    normal: Array
    width: float


@dataclass(frozen=True, eq=False)
class Rods:
    """The bones of a figure as line segments.

    Attributes
    ----------
    parent
        The parent joint of each bone, (n,).
    tip
        The end of each bone in the coordinates of its parent joint, (n, 3).
    width
        Half the width of each bone, (n,).
    """

    parent: Index
    tip: Array
    width: Array

    @classmethod
    def of(cls, bones: Sequence[BoneSegment]) -> Rods:
        """Create the line segments of the given bones."""
        return cls(
            np.array([bone.parent for bone in bones], dtype=np.int64),
            np.array([bone.tip for bone in bones]).reshape(-1, 3),
            np.array([bone.width for bone in bones]),
        )

    def ends(self, rotations: Array, positions: Array) -> Array:
        """Return both ends of each bone in world space, (n, 2, 3), for a global pose."""
        start = positions[self.parent]
        return np.stack([start, start + rotate(rotations[self.parent], self.tip)], axis=1)


@dataclass(frozen=True, eq=False)
class Soup:
    """Polygons whose vertices are rigidly attached to joints.

    Attributes
    ----------
    vertices
        The positions in the local coordinates of the joints, (vertices, 3).
    joint, bone, part
        The joint, the bone and the part (from PARTS) of each vertex, (vertices,). The bone is −1
        for the spheres at joints.
    faces
        The triangles as vertex indices, (n, 3).
    edges
        The lines as vertex indices, (n, 2).
    blocks
        Ranges of vertices as (first, stop, joints). Within a range, each joint has the same number
        of vertices.
    """

    vertices: Array
    joint: Index
    bone: Index
    part: Index
    faces: Index
    edges: Index
    blocks: tuple[tuple[int, int, Index], ...]


@dataclass(frozen=True, eq=False)
class Attached:
    """A body that does not belong to a bone and is rigidly attached to a joint.

    Attributes
    ----------
    vertices
        The positions in the local coordinates of the joint, (corners, 3).
    part
        The part (from PARTS) of each vertex, (corners,).
    faces
        The triangles as vertex indices, (n, 3).
    """

    joint: int
    vertices: Array
    part: Index
    faces: Index


@dataclass(frozen=True, eq=False)
class _Shape:
    """The shape of a bone or a joint, before it is scaled and placed.

    Attributes
    ----------
    corners
        The positions, (corners, 3).
    part
        The part (from PARTS) of each corner, (corners,).
    faces, edges
        The triangles and the lines, as indices of corners.
    """

    corners: Array
    part: Index
    faces: Index
    edges: Index


def find_bones(motion: Motion, up: Array, height: float) -> tuple[BoneSegment, ...]:
    """Return all bones of nonzero length, including bones to End Sites.

    `up` is the upward direction, (3,), and `height` is the height of the figure.
    """
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
        # Thin enough to show the bone's direction, and broad enough to show its front.
        width = np.clip(0.15 * length, 0.009 * height, 0.026 * height)
        width = min(float(width), 0.35 * length)
        bones.append(BoneSegment(parent, child, tip, _front(tip / length, up), width))
    return tuple(bones)


def align_bone_fronts(
    bones: Sequence[BoneSegment], chains: Sequence[Chain]
) -> tuple[BoneSegment, ...]:
    """Return the bones, with their fronts aligned along each limb in the rest pose.

    Only the bones from P to C of `chains` change. For example, the front of the forearm is aligned
    with the front of the upper arm.
    """
    found = list(bones)
    pairs = sorted(
        bones_of_chains(bones, chains), key=lambda pair: pair[0].parent
    )  # upper bones first
    into = {chain.child: number for chain, number in reversed(pairs)}
    for chain, number in pairs:
        if (above := into.get(chain.parent)) is not None:
            upper, axis = found[above], normalise(found[number].tip)
            normal = apply_shortest_rotation(upper.normal, normalise(upper.tip), axis)
            found[number] = replace(found[number], normal=normal)
    return tuple(found)


def bones_of_chains(
    bones: Sequence[BoneSegment], chains: Sequence[Chain]
) -> list[tuple[Chain, int]]:
    """Return (chain, bone index) for each chain with a bone from its parent to its child."""
    numbers = {(b.parent, b.child): k for k, b in enumerate(bones) if b.child >= 0}
    return [(c, numbers[c.parent, c.child]) for c in chains if (c.parent, c.child) in numbers]


def build_soup(
    bones: tuple[BoneSegment, ...],
    *,
    grown: float = 1.0,
    joints: bool = True,
    without: frozenset[int] = frozenset(),
    attached: Sequence[Attached] = (),
) -> Soup:
    """Return the wedges of all bones and the spheres at their joints.

    Parameters
    ----------
    grown
        The thickness of the wedges relative to their normal thickness.
    joints
        True to add the spheres.
    without
        The indices of bones that have a skin and therefore get no wedge.
    attached
        Additional bodies. Their bone index is −1.
    """
    kept = [(n, bone) for n, bone in enumerate(bones) if n not in without]
    radius: dict[int, float] = {}
    for _, bone in kept if joints else ():
        for joint in (bone.parent, bone.child):
            radius[joint] = max(radius.get(joint, 0.0), 0.50 * bone.width)
    radius.pop(-1, None)
    wedges = [(bone.parent, n, _wedge_axes(bone, grown)) for n, bone in kept]
    balls = [(joint, -1, r * np.eye(3)) for joint, r in radius.items()]
    vertices, tags, faces, edges, blocks = [], [], [], [], []
    first = 0
    for shape, placed in ((_WEDGE, wedges), (_BALL, balls)):
        size, count = len(shape.corners), len(placed)
        starts = first + size * np.arange(count)[:, None, None]
        vertices += [shape.corners @ frame for *_, frame in placed]
        tags += [(joint, bone, part) for joint, bone, _ in placed for part in shape.part]
        faces.append((starts + shape.faces).reshape(-1, 3))
        edges.append((starts + shape.edges).reshape(-1, 2))
        if placed:
            blocks.append((first, first + size * count, np.array([joint for joint, *_ in placed])))
        first += size * count
    for body in attached:
        size = len(body.vertices)
        vertices.append(body.vertices)
        tags += [(body.joint, -1, part) for part in body.part.tolist()]
        faces.append(first + body.faces)
        blocks.append((first, first + size, np.array([body.joint])))
        first += size
    joint_of, bone_of, part = np.array(tags, dtype=np.int64).reshape(-1, 3).T
    corners = np.concatenate([np.zeros((0, 3)), *vertices])
    return Soup(
        corners, joint_of, bone_of, part, np.concatenate(faces), np.concatenate(edges), (*blocks,)
    )


def pose_soup_vertices(soup: Soup, rotations: Array, positions: Array) -> Array:
    """Return the vertices in world space, (vertices, 3), for a global pose.

    `rotations` are (joints, 4), and `positions` are (joints, 3).
    """
    matrices = matrix_from_quaternion(rotations).transpose(0, 2, 1)
    world = np.empty(soup.vertices.shape)
    for first, stop, joints in soup.blocks:
        shape = (len(joints), -1, 3)
        out = world[first:stop].reshape(shape)
        np.matmul(soup.vertices[first:stop].reshape(shape), matrices[joints], out=out)
        out += positions[joints][:, None]
    return world


def _is_free(motion: Motion, joint: int) -> bool:
    """Return True if the joint is a child of the root and moves relative to it.

    No bone is drawn from the root to such a joint.
    """
    below_root = motion.skeleton.parents[motion.skeleton.parents[joint]] < 0
    offset = motion.translation(joint)
    return bool(below_root and offset.ndim == 2 and np.ptp(offset, axis=0).any())


def _offset(motion: Motion, joint: int) -> Array:
    """Return the median position of a joint in its parent's coordinates, (3,)."""
    offset = motion.translation(joint)
    if offset.ndim == 2:
        still: Array = np.median(offset, axis=0)
        return still if still.any() else motion.skeleton.offsets[joint]
    return offset


def _front(axis: Array, up: Array) -> Array:
    """Return the unit normal of the front face of a bone that points along `axis`, (3,).

    In the rest pose, the front faces forward or, if the bone itself points forward, up. All
    rotations of the rest pose are zero, so the parent's coordinates are world coordinates.
    """
    forward = np.array([0.0, 0.0, 1.0]) if up[1] > 0.5 else np.array([0.0, -1.0, 0.0])
    normal = forward - (forward @ axis) * axis
    if np.linalg.norm(normal) < 0.5:
        normal = up - (up @ axis) * axis
    return normalise(normal)


def _wedge_axes(bone: BoneSegment, grown: float) -> Array:
    """Return the scaled axes of a wedge as rows, (3, 3): along the bone, sideways and front."""
    across = np.cross(bone.normal, normalise(bone.tip))
    return np.stack([bone.tip, grown * bone.width * across, grown * bone.width * bone.normal])


def apply_shortest_rotation(vector: Array, start: Array, stop: Array) -> Array:
    """Rotate `vector` by the shortest rotation that takes `start` to `stop`.

    All vectors are unit vectors, (3,). `vector` is perpendicular to `start`, and the result is
    perpendicular to `stop`.
    """
    across = start + stop
    if across @ across < 1e-6:
        return vector
    moved = vector - across * (2.0 * (across @ vector) / (across @ across))  # two reflections:
    moved = moved - stop * (2.0 * (stop @ moved))  # at the middle, then at the end
    return normalise(moved - (moved @ stop) * stop)


def _wedge() -> _Shape:
    """Return the shape of a bone: a flat box with three cross-sections and a rail on one edge."""

    def rings(low: float, high: float, thick: float) -> Array:
        corners = ((high, thick), (low, thick), (low, -thick), (high, -thick))
        return np.array([[(at, w * x, t * y) for x, y in corners] for at, w, t in _STATIONS])

    box = rings(-1.0, 1.0, 1.0)
    corners, part = [], []
    for solid, parts in (
        (box, (FRONT, SIDE, BACK, SIDE)),
        (rings(*_RAIL, _RAIL_THICK), (STRIPE,) * 4),
    ):
        after = np.roll(solid, -1, axis=1)
        sides = np.stack([solid[:-1], after[:-1], after[1:], solid[1:]], axis=2)
        corners += [sides.reshape(-1, 3), solid[0, ::-1], solid[-1]]
        part += [*parts, *parts, parts[1], parts[1]]
    # Faces share no corners, because each has its own colour. The outline is for the ghost.
    quads = np.arange(4 * len(part)).reshape(-1, 4)
    outline = quads.size + np.arange(12).reshape(3, 4)
    return _Shape(
        np.concatenate([*corners, box.reshape(-1, 3)]),
        np.array([*np.repeat(part, 4), *12 * [SIDE]]),
        quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3),
        np.concatenate([segments(outline.T), segments(outline[:, [0, 1, 2, 3, 0]])]),
    )


_SPHERE = pv.Icosphere(nsub=1)
SPHERE, TRIANGLES = np.asarray(_SPHERE.points, dtype=float), np.asarray(_SPHERE.regular_faces)
_BALL = _Shape(SPHERE, np.full(len(SPHERE), JOINT), TRIANGLES, np.zeros((0, 2), dtype=np.int64))
_WEDGE = _wedge()
