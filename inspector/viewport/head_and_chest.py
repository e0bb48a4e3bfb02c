"""Heads with a face, and rib cages, which show the direction in which a person faces.

Joints are found by their position, not by name: the chest is the last joint above both arms, and
the head is at the end of the line of joints that rises from the chest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inspector.viewport.bodies import (
    BACK,
    BAND,
    FRONT,
    SPHERE,
    STRIPE,
    TRIANGLES,
    Attached,
    BoneSegment,
)
from inspector.viewport.mesh_actor import Index
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import joint_path
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, conjugate, normalise, rotate

_FRAMES = 60  # number of frames from which the usual direction of a joint is determined
# Half the size across, up and forward, in heights of the figure
_SKULL = np.array([0.042, 0.064, 0.052])
_CAGE = np.array([0.075, 0.095, 0.048])
_RISE = 0.75  # distance from the head's joint to its middle, in half heights of the head
# Distance from the middle of the shoulders down to the middle of the chest, in figure heights
_DROP = 0.085
# Largest width of the chest, which does not hide the arms, relative to the shoulders' width
_SLIM = 0.62
_NOSE = np.array([[0.0, 0.22, 0.86], [-0.2, -0.22, 0.9], [0.2, -0.22, 0.9], [0.0, -0.16, 1.3]])
_NOSE_FACES = np.array([[0, 1, 3], [2, 0, 3], [1, 2, 3]])
_EYE = np.array([[-0.16, 0.0, 0.0], [0.0, -0.12, 0.0], [0.16, 0.0, 0.0], [0.0, 0.12, 0.0]])
_EYES_AT = np.array([0.38, 0.2, 0.99])


@dataclass(frozen=True, eq=False)
class Front:
    """The head or the chest of a person.

    Attributes
    ----------
    body
        The body to draw.
    bone
        A bone that represents the body in calculations. It leads from the joint to the middle of
        the body, and its normal points forward.
    face
        True for a head.
    """

    body: Attached
    bone: BoneSegment
    face: bool


def heads_and_chests(
    chains: Sequence[Chain],
    skeleton: Skeleton,
    rotations: Array,
    positions: Array,
    height: float,
) -> tuple[Front, ...]:
    """Return the chest and, if there is one, the head of each person with two arms.

    `rotations` (frames, joints, 4) and `positions` (frames, joints, 3) are global. `height` is the
    height of the figure.
    """
    some = slice(None, None, max(1, len(positions) // _FRAMES))
    pose = rotations[some], positions[some]
    people = dict.fromkeys(chain.person for chain in chains)
    found: list[Front] = []
    for person in people:
        found += _of_person([c for c in chains if c.person == person], skeleton, *pose, height)
    return tuple(found)


def _of_person(
    chains: Sequence[Chain], skeleton: Skeleton, rotations: Array, positions: Array, height: float
) -> list[Front]:
    arms = {c.side: c.parent for c in chains if c.segment == "Arm"}
    legs = {c.side: c.parent for c in chains if c.segment == "UpLeg"}
    if not {"Left", "Right"} <= arms.keys():
        return []
    shoulders = positions[:, [arms["Left"], arms["Right"]]]
    hips = positions[:, list(legs.values()) or [0]].mean(axis=1)
    across, middle = shoulders[:, 0] - shoulders[:, 1], shoulders.mean(axis=1)
    rise = middle - hips
    ahead = np.cross(across, rise)
    if np.linalg.norm(ahead, axis=1).min() < 1e-9 * height**2:
        return []
    chest, head = _chest_and_head(skeleton, list(arms.values()), positions, rise)
    wide = min(_CAGE[0] * height, _SLIM * 0.5 * float(np.median(np.linalg.norm(across, axis=1))))
    cage = np.array([wide, *(_CAGE[1:] * height)])
    place = middle - _DROP * height * normalise(rise)
    turn = conjugate(rotations[:, chest])
    centre = rotate(turn, place - positions[:, chest]).mean(axis=0)
    axes = _axes(rotate(turn, ahead), rotate(turn, rise))
    fronts = [_front(chest, centre, axes, cage, face=False)]
    if head >= 0:
        turn = conjugate(rotations[:, head])
        axes = _axes(rotate(turn, ahead), rotate(turn, rise))
        skull = _SKULL * height
        fronts.append(_front(head, _RISE * skull[1] * axes[1], axes, skull, face=True))
    return fronts


def _chest_and_head(
    skeleton: Skeleton, arms: Sequence[int], positions: Array, rise: Array
) -> tuple[int, int]:
    """Return the joints of the chest and the head. If there is no head, its index is −1.

    The chest is the lowest joint of the hierarchy that is above both arms. `arms` contains the
    first joint of each arm, and `rise` is the vector from the hips to the shoulders, (frames, 3).
    """
    above = [set(joint_path(skeleton, -1, joint)) for joint in arms]
    chest, on_the_way = max(set.intersection(*above)), set.union(*above)
    upright = normalise(rise)

    def level(joint: int) -> float:
        return float(((positions[:, joint] - positions[:, chest]) * upright).sum(axis=-1).mean())

    line = chest
    while below := [j for j in skeleton.children[line] if j not in on_the_way]:
        if line != chest and len(below) > 1:
            break  # these are the eyes and the jaw
        line = max(below, key=level)
    if level(line) <= 0.0 or line == chest:
        return chest, -1
    ends = {joint for joint, offset in skeleton.ends if np.linalg.norm(offset) > 0.0}
    parent = int(skeleton.parents[line])
    is_top = not skeleton.children[line] and line not in ends  # the top of the head, without a bone
    return chest, parent if is_top and parent != chest else line


def _axes(ahead: Array, rise: Array) -> Array:
    """Return the mean sideways, upward and forward axes as rows, (3, 3).

    `ahead` and `rise` are forward and upward vectors in each frame, (frames, 3).
    """
    up = normalise(normalise(rise).mean(axis=0))
    forward = normalise(ahead).mean(axis=0)
    forward = normalise(forward - (forward @ up) * up)
    return np.stack([np.cross(up, forward), up, forward])


def _front(joint: int, centre: Array, axes: Array, half: Array, *, face: bool) -> Front:
    """Return a head or chest as an ellipsoid that is light at the front and dark at the back.

    `half` contains the lengths of the semi-axes, (3,).
    """
    corners = SPHERE[TRIANGLES]
    middle = normalise(corners.mean(axis=1))
    ahead = middle[:, 2] - (0.45 * np.maximum(middle[:, 1], 0.0) if face else 0.0)
    part = np.repeat(np.where(ahead > 0.1, FRONT, BAND if face else BACK), 3)
    points = corners.reshape(-1, 3)
    faces = np.arange(len(points)).reshape(-1, 3)
    if face:
        points, part, faces = _with_face(points, part, faces)
    body = Attached(joint, centre + (points * half) @ axes, part, faces)
    return Front(body, BoneSegment(joint, -1, centre, axes[2], float(half[0])), face)


def _with_face(points: Array, part: Index, faces: Index) -> tuple[Array, Index, Index]:
    """Add a nose and two eyes to the front of a unit sphere."""
    nose = _NOSE[_NOSE_FACES].reshape(-1, 3)
    eyes = np.vstack([_EYE + _EYES_AT * (side, 1.0, 1.0) for side in (-1.0, 1.0)])
    diamond = np.array([[0, 1, 2], [0, 2, 3]])
    start, after = len(points), len(points) + len(nose)
    return (
        np.vstack([points, nose, eyes]),
        np.concatenate([part, np.full(len(nose), BACK), np.full(len(eyes), STRIPE)]),
        np.vstack(
            [
                faces,
                start + np.arange(len(nose)).reshape(-1, 3),
                after + diamond,
                after + 4 + diamond,
            ]
        ),
    )
