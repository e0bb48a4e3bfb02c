"""A striped skin along the limbs. A wrong twist wrings it like a candy wrapper.

As with the twist bones of a game character, the roll of the skin changes evenly along a bone, from
the joint above to the joint below. Correct joints give straight stripes. A wrong twist of a joint
winds the stripes up on one side and back on the other, although no joint moves [Choi26 Fig. 1]. A
rigid fin along the front of each bone shows its own roll: the fins of correct bones form a line,
and the fin of a wrong bone departs from it.
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
    aligned_fronts,
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
STATIONS = np.array([0.0, 0.05, 0.11, 0.19, 0.30, 0.42, 0.54, 0.66, 0.78, 0.87, 0.94, 1.0])
_BEND = 0.20  # share of a bone near a joint where the skin bends with the next bone
_CAP = 0.11  # share of a bone at a limb's end that is rounded
_SWELL = 0.16  # extra thickness of a limb in its upper middle
# Radius at P and at C for each segment, in figure heights.
_GIRTH = {
    "Shoulder": (0.026, 0.027),
    "Arm": (0.029, 0.023),
    "ForeArm": (0.024, 0.016),
    "UpLeg": (0.036, 0.027),
    "Leg": (0.028, 0.017),
}
_USUAL = (0.024, 0.020)
_FIN = 0.10, 0.90  # where the fin begins and ends, as shares of the bone
_FOOT, _EDGE = (0.34, 0.80), (0.17, 1.65)  # half its width, and distance from the bone, in radii
# The part of each vertex of a fin: a flank, the edge, the other flank, and both ends.
FIN_PARTS = np.repeat([STRIPE, FIN, STRIPE, STRIPE, STRIPE], 4)


@dataclass(frozen=True, eq=False)
class Skin:
    """Tubes of B bones with K rings of M vertices, in the order (B, K, M), then the fins' vertices.

    - parent, child: the joints of the bones, (B,)
    - below: the bone after C, or the bone itself, (B,)
    - above: the bone before P, or the bone itself, (B,)
    - axis: P→C in P's coordinates, (B, 3)
    - across: two unit vectors perpendicular to the axis, (B, 2, 3), aligned along the limb in the
      rest pose, so that stripes meet
    - radius: the radius of each ring, (B, K)
    - circle: cosine and sine of the vertices, (M, 2)
    - bone: the index of the body's bone for each vertex, (V,)
    - part: the part of each vertex, from bodies.PARTS, (V,)
    - faces: faces (n, 4)
    - edges: lines (n, 2) along the dark stripes
    - fin, fin_normals: the vertices of the fins and their normals in P's coordinates, (B, F, 3)
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
        """The indices of the bones that the skin covers."""
        return frozenset(self.bone.tolist())


def build_skin(
    bones: Sequence[BoneSegment], chains: Sequence[Chain], height: float, *, fine: bool = False
) -> Skin:
    """Return the skin of every visible bone P→C of a chain. `fine` doubles the vertices."""
    pairs, fronts = bones_of_chains(bones, chains), aligned_fronts(bones, chains)
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


def roll(skin: Skin, rotations: Array) -> Array:
    """Return the twist of each bone's C relative to P about P→C, radians, (B,)."""
    local = multiply(conjugate(rotations[skin.parent]), rotations[skin.child])
    return twist_angle(local, skin.axis)


def drape(
    skin: Skin, rotations: Array, positions: Array, *, grown: float = 1.0
) -> tuple[Array, Array]:
    """Return vertices and normals, (V, 3) each, from the joints' global rotations and positions."""
    if not len(skin.parent):
        return np.zeros((0, 3)), np.zeros((0, 3))
    matrices = matrix_from_quaternion(rotations[skin.parent])
    angle = roll(skin, rotations)[:, None] * STATIONS  # (B, K)
    sides = skin.across @ matrices.transpose(0, 2, 1)  # (B, 2, 3), in the world
    start, stop = positions[skin.parent], positions[skin.child]
    centre = start[:, None] + STATIONS[:, None] * (stop - start)[:, None]
    frame = _turned(angle, sides)  # (B, K, 2, 3)
    # Near a joint, a ring belongs to both bones, as in linear blend skinning, with equal shares at
    # the joint itself. Its position and sides are weighted means.
    end = _turned(angle[:, -1:], sides)  # the roll at the end of a bone …
    for other, ours, reach in ((skin.below, stop, STATIONS - 1.0), (skin.above, start, STATIONS)):
        share = 0.5 * np.clip(1.0 - np.abs(reach) / _BEND, 0.0, 1.0) ** 2
        share = share * (other != np.arange(len(other)))[:, None]  # (B, K)
        # … is the roll at the start of the next.
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


def fins_of(skin: Skin, joints: Sequence[int], rotations: Array, positions: Array) -> Array:
    """Return the vertices of the fins of the bones that begin at joints, (bones, F, 3).

    `rotations` are global, (joints, 4). `positions` have the shape (joints, 3).
    """
    own = np.flatnonzero(np.isin(skin.parent, joints))
    parents = skin.parent[own]
    return positions[parents][:, None] + rotate(rotations[parents][:, None], skin.fin[own])


def _turned(angle: Array, sides: Array) -> Array:
    """Return sides (B, 2, 3) turned by angles (B, K) about their common normal, (B, K, 2, 3)."""
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    first, second = sides[:, None, 0], sides[:, None, 1]
    return np.stack([cosine * first + sine * second, cosine * second - sine * first], axis=-2)


def _fins(
    bones: Sequence[BoneSegment], pairs: Sequence[tuple[Chain, int]], across: Array, radius: Array
) -> tuple[Array, Array, Index, Index]:
    """Return the fins' vertices and normals (B, F, 3), the parts of a fin (F,), and faces (n, 4).

    Vertices and normals are in P's coordinates. A fin has a light edge and dark flanks. Its faces
    share no vertices, because each has its own colour.
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
    """Return cosine and sine (M, 2) of a ring, its dark vertices (M,), and all faces and edges.

    Stripes share no vertices, so that their edges are sharp.
    """
    across = np.linspace(0.0, 1.0, pieces + 1)
    turn = 2.0 * np.pi / _BANDS
    angle = (turn * (np.arange(_BANDS)[:, None] + across - 0.5)).ravel()
    dark = np.repeat(np.arange(_BANDS) % 2 == 0, pieces + 1)
    around, rings = len(angle), len(STATIONS)
    column = np.arange(around).reshape(_BANDS, pieces + 1)
    first = column[:, :-1].ravel()
    quad = np.stack([first, first + 1, first + 1 + around, first + around], axis=1)
    starts = around * (rings * np.arange(bones)[:, None] + np.arange(rings))  # of the rings
    faces = starts[:, :-1].reshape(-1, 1, 1) + quad
    sides = column[::2][:, [0, -1]].ravel()
    lines = starts[:, None, :] + sides[:, None]
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return circle, dark, faces.reshape(-1, 4), segments(lines)
