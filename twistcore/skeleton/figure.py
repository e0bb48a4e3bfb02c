"""Estimate a figure's up direction, height and heading."""

from __future__ import annotations

import numpy as np

from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.motion import Motion, Skeleton, forward_kinematics
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rotation import Array


def guess_up(positions: Array, chains: tuple[Chain, ...], skeleton: Skeleton) -> Array:
    """Return the unit vector that points up, (3,): Y, or Z if the figure is upright along Z.

    The result is determined from the direction from the knees to the shoulders, because the rest
    pose may be arbitrary. The rest pose is used only if there are no limbs. `positions` has the
    shape (frames, joints, 3).
    """
    knees = [c.parent for c in chains if c.segment == "Leg"]
    shoulders = [c.parent for c in chains if c.segment == "Arm"]
    if knees and shoulders:
        rise = positions[:, shoulders].mean(axis=(0, 1)) - positions[:, knees].mean(axis=(0, 1))
        extent = np.abs(rise)
    else:
        rest = np.zeros((len(skeleton), 3))
        for joint, parent in enumerate(skeleton.parents):
            rest[joint] = skeleton.offsets[joint] + (rest[parent] if parent >= 0 else 0.0)
        extent = np.ptp(rest, axis=0)
    up: Array = np.eye(3)[2 if extent[2] > 1.5 * extent[1] else 1]
    return up


def vertical_axis_letter(motion: Motion) -> str:
    """Return the name of a motion's vertical axis, 'Y' or 'Z'."""
    up = guess_up(forward_kinematics(motion)[1], find_chains(motion), motion.skeleton)
    return "XYZ"[int(up.argmax())]


def figure_size(positions: Array, skeleton: Skeleton) -> float:
    """Return the height of a figure, in the file's unit, in the frame in which it is largest.

    The result is at most the height of the rest pose. If there are several people, the tallest one
    is measured. About 200 frames are examined. `positions` has the shape (frames, joints, 3).
    """
    some = positions[:: max(1, len(positions) // 200)]
    poses = (some[:, list(person.joints)] for person in find_people(skeleton))
    largest = max(float(np.ptp(pose, axis=1).max()) for pose in poses)
    return min(skeleton.height, largest) if largest > 0.0 else skeleton.height


def figure_facing_direction(positions: Array, chains: tuple[Chain, ...], up: Array) -> Array:
    """Return the horizontal direction that the figure faces, a unit vector of shape (3,).

    The heading is perpendicular to the direction from right to left across hips and shoulders. If
    the sides are unknown, the heading is Z, or −Y if Z is up. If there are several people, the
    result is the heading of the person to whom the first chain belongs.

    Parameters
    ----------
    positions
        Joint positions in one frame, shape (joints, 3).
    chains
        The figure's chains.
    up
        Unit vector that points up, shape (3,).
    """
    across = np.zeros(3)
    own = [c for c in chains if c.person == chains[0].person]
    for segment in ("UpLeg", "Arm"):
        sides = {c.side: positions[c.parent] for c in own if c.segment == segment}
        if {"Left", "Right"} <= sides.keys():
            across += sides["Left"] - sides["Right"]
    ahead = np.cross(across, up)
    size = float(np.linalg.norm(ahead))
    if size > 1e-9:
        return ahead / size
    return np.array([0.0, 0.0, 1.0]) if up[1] > 0.5 else np.array([0.0, -1.0, 0.0])
