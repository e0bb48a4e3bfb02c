"""A striped skin along the limbs, which shows a wrong twist as spiral stripes.

As with the twist bones of a game character, the roll of the skin changes evenly along a bone, from
the joint above to the joint below. Joints without a twist error give straight stripes. A wrong
twist of a joint winds the stripes into a spiral on one side of the joint and into the opposite
spiral on the other side, although no joint moves [Choi26 Fig. 1]. A rigid fin along the front of
each bone shows the roll of this bone: the fins of correct bones form a line, and the fin of a wrong
bone points in a different direction.

In this module, P is the parent joint at the start of a bone, and C is the child joint at its end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from inspector.viewport.bodies import (
    BAND,
    FIN,
    SKIN,
    STRIPE,
    BoneSegment,
    align_bone_fronts,
    bones_of_chains,
)
from inspector.viewport.mesh_actor import Index, segments
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    matrix_from_quaternion,
    multiply,
    normalise,
    rotate,
    twist_angle,
)

_BANDS = 6  # number of dark and light stripes around a limb; the pattern repeats after 120°
# Positions of the rings of vertices along a bone, from 0 at P to 1 at C
STATIONS = np.array([0.0, 0.05, 0.11, 0.19, 0.30, 0.42, 0.54, 0.66, 0.78, 0.87, 0.94, 1.0])
_BEND = 0.20  # share of a bone near a joint where the skin bends with the next bone
_CAP = 0.11  # share of a bone at a limb's end that is rounded
_SWELL = 0.16  # additional thickness, relative to the radius, above the middle of a bone
# Radius at P and at C for each segment, in figure heights.
_GIRTH = {
    "Shoulder": (0.026, 0.027),
    "Arm": (0.029, 0.023),
    "ForeArm": (0.024, 0.016),
    "UpLeg": (0.036, 0.027),
    "Leg": (0.028, 0.017),
}
_USUAL = (0.024, 0.020)  # for other segments
_FIN = 0.10, 0.90  # start and end of the fin along the bone, from 0 at P to 1 at C
# At the foot and at the edge of a fin: half its width, and its distance from the middle of the
# bone, in radii of the skin
_FOOT, _EDGE = (0.34, 0.80), (0.17, 1.65)
# The part, from bodies.PARTS, of each vertex of a fin. A fin has five faces of four vertices: a
# flank, the edge, the other flank, and both ends.
FIN_PARTS = np.repeat([STRIPE, FIN, STRIPE, STRIPE, STRIPE], 4)


@dataclass(frozen=True, eq=False)
class Skin:
    """Tubes and fins for some bones of a figure.

    In the shapes below, B is the number of bones with skin. The tube of a bone has K rings of M
    vertices, and the fin of a bone has F vertices. The V vertices consist of all tube vertices, in
    the order (B, K, M), followed by all fin vertices, in the order (B, F).

    Attributes
    ----------
    parent, child
        The joints P and C of each bone, (B,).
    below, above
        The indices, among the B bones, of the next bone, which begins at C, and of the previous
        bone, which ends at P, (B,). If there is no such bone, this is the index of the bone itself.
    axis
        The unit vector from P to C in P's coordinates, (B, 3).
    across
        Two unit vectors perpendicular to the axis, in P's coordinates, (B, 2, 3). In the rest pose,
        these vectors are aligned along a limb, so the stripes of consecutive bones meet.
    radius
        The radius of each ring, (B, K).
    circle
        The cosine and sine of the angle of each vertex of a ring, (M, 2).
    bone
        The bone of each vertex, as an index into all bones of the figure, (V,).
    part
        The part of each vertex, from bodies.PARTS, (V,).
    faces
        The faces as vertex indices, (n, 4).
    edges
        The lines along the edges of the dark stripes as vertex indices, (n, 2).
    fin, fin_normals
        The vertices of the fins and their normals in P's coordinates, (B, F, 3).
    """

    parent: Index
    child: Index
    below: Index
    above: Index
    axis: Array
    across: Array
    radius: Array
    circle: Array
    bone: Index
    part: Index
    faces: Index
    edges: Index
    fin: Array
    fin_normals: Array

    @property
    def covered(self) -> frozenset[int]:
        """The bones that have skin, as indices into all bones of the figure."""
        return frozenset(self.bone.tolist())


def build_skin(
    bones: Sequence[BoneSegment], chains: Sequence[Chain], height: float, *, fine: bool = False
) -> Skin:
    """Return the skin of the bones that belong to chains.

    Parameters
    ----------
    bones
        All bones of the figure.
    chains
        The chains. The bone of a chain from P to C gets a skin if it is among `bones`.
    height
        The height of the figure.
    fine
        True for a rounder skin with nearly twice as many vertices.
    """
    pairs, fronts = bones_of_chains(bones, chains), align_bone_fronts(bones, chains)
    count = len(pairs)
    parent = np.array([c.parent for c, _ in pairs], dtype=np.int64)
    child = np.array([c.child for c, _ in pairs], dtype=np.int64)
    from_joint = {joint: k for k, joint in reversed([*enumerate(parent.tolist())])}
    to_joint = {joint: k for k, joint in reversed([*enumerate(child.tolist())])}
    below = np.array([from_joint.get(c.child, k) for k, (c, _) in enumerate(pairs)], dtype=np.int64)
    above = np.array([to_joint.get(c.parent, k) for k, (c, _) in enumerate(pairs)], dtype=np.int64)
    axis, across = np.zeros((count, 3)), np.zeros((count, 2, 3))
    radius = np.zeros((count, len(STATIONS)))
    for k, (chain, number) in enumerate(pairs):
        bone, first = bones[number], fronts[number].normal
        length = float(np.linalg.norm(bone.tip))
        axis[k] = bone.tip / length
        across[k] = first, np.cross(axis[k], first)
        start, stop = height * np.array(_GIRTH.get(chain.segment, _USUAL))
        swell = 1.0 + _SWELL * np.sin(np.pi * np.sqrt(STATIONS)) ** 2
        radius[k] = np.minimum((start + (stop - start) * STATIONS) * swell, 0.45 * length)
        for free, away in ((above[k] == k, STATIONS), (below[k] == k, 1.0 - STATIONS)):
            if free:
                radius[k] *= np.sqrt(1.0 - np.clip(1.0 - away / _CAP, 0.0, 1.0) ** 2)
    circle, dark, faces, edges = _ring(6 if fine else 3, count)
    size = len(STATIONS) * len(circle)
    part = np.tile(np.where(dark, BAND, SKIN), count * len(STATIONS))
    fin, fin_normals, fin_part, fin_faces = _fins(bones, pairs, across, radius)
    numbers_of = np.array([number for _, number in pairs], dtype=np.int64)
    bone_of = np.append(np.repeat(numbers_of, size), np.repeat(numbers_of, len(fin_part)))
    return Skin(
        parent, child, below, above, axis, across, radius, circle, bone_of,
        np.append(part, np.tile(fin_part, count)),
        np.vstack([faces, count * size + fin_faces]), edges, fin, fin_normals,
    )  # fmt: skip


def bone_twist_angles(skin: Skin, rotations: Array) -> Array:
    """Return the twist of C relative to P about the axis of each bone with skin, in radians, (B,).

    `rotations` are the global rotations of the joints, (joints, 4).
    """
    local = multiply(conjugate(rotations[skin.parent]), rotations[skin.child])
    return twist_angle(local, skin.axis)


def pose_skin(
    skin: Skin, rotations: Array, positions: Array, *, grown: float = 1.0
) -> tuple[Array, Array]:
    """Return the vertices and normals of the skin in a pose, in world space.

    Parameters
    ----------
    skin
        The skin.
    rotations, positions
        The global rotations (joints, 4) and positions (joints, 3).
    grown
        The thickness of the tubes relative to their normal thickness.

    Returns
    -------
    tuple of ndarray
        The vertices and the normals, each (V, 3).
    """
    if not len(skin.parent):
        return np.zeros((0, 3)), np.zeros((0, 3))
    matrices = matrix_from_quaternion(rotations[skin.parent])
    angle = bone_twist_angles(skin, rotations)[:, None] * STATIONS  # (B, K)
    sides = skin.across @ matrices.transpose(0, 2, 1)  # (B, 2, 3), in world space
    start, stop = positions[skin.parent], positions[skin.child]
    centre = start[:, None] + STATIONS[:, None] * (stop - start)[:, None]
    frame = _turned(angle, sides)  # (B, K, 2, 3)
    # As in linear blend skinning, both bones at a joint influence the rings near it, with equal
    # shares at the joint itself. The position and the sides of a ring are weighted means.
    end = _turned(angle[:, -1:], sides)  # the sides of the last ring of each bone
    for other, ours, reach in ((skin.below, stop, STATIONS - 1.0), (skin.above, start, STATIONS)):
        share = 0.5 * np.clip(1.0 - np.abs(reach) / _BEND, 0.0, 1.0) ** 2
        share = share * (other != np.arange(len(other)))[:, None]  # (B, K)
        # At the joint, the last ring of the previous bone meets the first ring of the next bone.
        theirs = end[other] if other is skin.above else sides[other][:, None]
        length = np.linalg.norm(stop - start, axis=1)[:, None, None]
        along = normalise(stop - start)[other][:, None]
        beyond = ours[:, None] + length * reach[:, None] * along
        centre = centre + share[..., None] * (beyond - centre)
        frame = frame + share[..., None, None] * (theirs - frame)
    frame = frame / np.maximum(np.linalg.norm(frame, axis=-1, keepdims=True), 1e-6)
    normals = skin.circle @ frame  # (B, K, M, 3)
    points = centre[:, :, None] + grown * skin.radius[:, :, None, None] * normals
    turn = matrices.transpose(0, 2, 1)
    fins, across = start[:, None] + skin.fin @ turn, skin.fin_normals @ turn
    return (
        np.vstack([points.reshape(-1, 3), fins.reshape(-1, 3)]),
        np.vstack([normals.reshape(-1, 3), across.reshape(-1, 3)]),
    )


def pose_skin_fins(skin: Skin, joints: Sequence[int], rotations: Array, positions: Array) -> Array:
    """Return the fin vertices of the bones that begin at given joints, in world space.

    Parameters
    ----------
    skin
        The skin.
    joints
        The joints. A joint at which no bone with skin begins has no fin.
    rotations, positions
        The global rotations (joints, 4) and positions (joints, 3).

    Returns
    -------
    ndarray
        The vertices, (fins, F, 3).
    """
    own = np.flatnonzero(np.isin(skin.parent, joints))
    parents = skin.parent[own]
    return positions[parents][:, None] + rotate(rotations[parents][:, None], skin.fin[own])


def _turned(angle: Array, sides: Array) -> Array:
    """Return pairs of perpendicular vectors, rotated about their common normal, (B, K, 2, 3).

    Parameters
    ----------
    angle
        The angles in radians, (B, K).
    sides
        The pairs of vectors, (B, 2, 3).
    """
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    first, second = sides[:, None, 0], sides[:, None, 1]
    return np.stack([cosine * first + sine * second, cosine * second - sine * first], axis=-2)


def _fins(
    bones: Sequence[BoneSegment], pairs: Sequence[tuple[Chain, int]], across: Array, radius: Array
) -> tuple[Array, Array, Index, Index]:
    """Return the vertices, normals, parts and faces of the fins.

    A fin has a light edge and dark flanks. Faces do not share vertices, because each face has a
    different colour.

    Parameters
    ----------
    bones
        All bones of the figure.
    pairs
        The B chains whose bones have skin, each with the index of its bone.
    across
        Two unit vectors perpendicular to each bone, (B, 2, 3), as in :class:`Skin`.
    radius
        The radius of each ring of the tubes, (B, K).

    Returns
    -------
    vertices, normals : ndarray, shape (B, F, 3)
        The vertices and normals in P's coordinates.
    part : ndarray, shape (F,)
        The part of each vertex of a fin, from bodies.PARTS.
    faces : ndarray, shape (n, 4)
        The faces, as indices into the vertices of all fins.
    """
    (foot, inside), (edge, outside) = _FOOT, _EDGE
    section = np.array([[inside, -foot], [outside, -edge], [outside, edge], [inside, foot]])
    sides, normals = [], []
    for a, b in pairwise(section):  # flank, edge, flank
        out = np.array([b[1] - a[1], a[0] - b[0]])
        sides.append([(0, *a), (0, *b), (1, *b), (1, *a)])
        normals.append(np.tile([0.0, *normalise(out)], (4, 1)))
    for at in (0, 1):
        sides.append([(at, *corner) for corner in (section if at else section[::-1])])
        normals.append(np.tile([2.0 * at - 1.0, 0.0, 0.0], (4, 1)))
    corners, out = np.array(sides, dtype=float).reshape(-1, 3), np.concatenate(normals)
    tips = np.array([bones[number].tip for _, number in pairs]).reshape(-1, 3)
    along = np.array(_FIN)[corners[:, 0].astype(int)]  # (F,)
    thick = np.array([np.interp(along, STATIONS, row) for row in radius]).reshape(-1, len(along), 1)
    frame = np.concatenate([normalise(tips)[:, None], across], axis=1)
    placed = along[:, None] * tips[:, None] + thick * (corners[:, 1:] @ across)
    first = np.arange(len(pairs))[:, None, None] * len(corners)
    faces = (first + np.arange(len(corners)).reshape(-1, 4)).reshape(-1, 4)
    return placed, out @ frame, FIN_PARTS, faces


def _ring(pieces: int, bones: int) -> tuple[Array, NDArray[np.bool_], Index, Index]:
    """Return a ring of vertices, and the faces and edges of all tubes.

    Neighbouring stripes do not share vertices, so the edges of the stripes are sharp.

    Parameters
    ----------
    pieces
        The number of faces across a stripe.
    bones
        The number of bones with skin.

    Returns
    -------
    circle : ndarray, shape (M, 2)
        The cosine and sine of the angle of each vertex of a ring.
    dark : ndarray of bool, shape (M,)
        A mask of the vertices of dark stripes.
    faces : ndarray, shape (n, 4)
        The faces of all tubes.
    edges : ndarray, shape (n, 2)
        The lines along the edges of the dark stripes of all tubes.
    """
    across = np.linspace(0.0, 1.0, pieces + 1)
    turn = 2.0 * np.pi / _BANDS
    angle = (turn * (np.arange(_BANDS)[:, None] + across - 0.5)).ravel()
    dark = np.repeat(np.arange(_BANDS) % 2 == 0, pieces + 1)
    around, rings = len(angle), len(STATIONS)
    column = np.arange(around).reshape(_BANDS, pieces + 1)
    first = column[:, :-1].ravel()
    quad = np.stack([first, first + 1, first + 1 + around, first + around], axis=1)
    # Index of the first vertex of each ring, (bones, rings)
    starts = around * (rings * np.arange(bones)[:, None] + np.arange(rings))
    faces = starts[:, :-1].reshape(-1, 1, 1) + quad
    sides = column[::2][:, [0, -1]].ravel()
    lines = starts[:, None, :] + sides[:, None]
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return circle, dark, faces.reshape(-1, 4), segments(lines)
