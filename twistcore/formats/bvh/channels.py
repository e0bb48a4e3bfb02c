"""Find each joint's columns in the motion data of a BVH file, and convert the data to a motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twistcore.skeleton.medians import median, medians
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array, vector_lengths
from twistcore.work.frozen import dataclass

_ELEMENTS = 1 << 14  # maximum number of quaternions that are computed in one block of frames
_NOTHING = 1e-3  # share of the length in position channels; a shorter OFFSET counts as 0
_STRETCH = 0.5  # share of its length by which a bone may vary
_STILL = 0.02  # the same, for a joint that may move the whole figure


@dataclass(frozen=True)
class JointChannels:
    """The columns of a joint's channels in a row of motion numbers.

    Attributes
    ----------
    order
        Axes of the rotation channels, in the order of an intrinsic rotation, such as 'ZYX'.
    rotation
        Columns of the rotation channels.
    position
        Axis, 0-2, and column of each position channel.
    """

    order: str
    rotation: tuple[int, ...]
    position: tuple[tuple[int, int], ...]

    @property
    def rotatable(self) -> bool:
        """Return True if there are rotation channels about three different axes."""
        return len(self.order) == 3 and len(set(self.order)) == 3


def motion_from_channels(
    skeleton: Skeleton, channels: tuple[JointChannels, ...], values: Array, frame_time: float
) -> Motion:
    """Convert rows of numbers to a motion.

    Parameters
    ----------
    skeleton
        The skeleton.
    channels
        The channels of each joint.
    values
        The rows, in degrees and length units, shape (frames, columns).
    frame_time
        Seconds from one frame to the next.
    """
    positioned = tuple(j for j, layout in enumerate(channels) if layout.position)
    positions = np.empty((len(values), len(positioned), 3))
    positions[:] = skeleton.offsets[list(positioned)]
    for k, joint in enumerate(positioned):
        for axis, column in channels[joint].position:
            positions[:, k, axis] = values[:, column]
    placed = with_offsets_from_positions(skeleton, positioned, positions)
    return Motion(placed, _rotations(channels, values), positioned, positions, frame_time)


def with_offsets_from_positions(
    skeleton: Skeleton, positioned: tuple[int, ...], positions: Array
) -> Skeleton:
    """Return the skeleton, with offsets of 0 replaced by offsets from position channels.

    The new offset is the median of the joint's positions. Roots keep their OFFSET, and so does a
    joint that moves the whole figure, such as hips below a reference joint. `positioned` has the
    indices of the joints with position channels, and `positions` their positions, shape (frames,
    len(positioned), 3).
    """
    offsets = skeleton.offsets.copy()
    carrying = _carrying(skeleton)
    for k, joint in enumerate(positioned):
        length = np.linalg.norm(offsets[joint])
        if skeleton.parents[joint] < 0 or length > _NOTHING * np.abs(positions[:, k]).max():
            continue
        bone = medians(positions[:, k], 0)
        usual = np.linalg.norm(bone)
        away = vector_lengths(positions[:, k] - bone)
        steady = (
            away.max() <= _STILL * usual if joint in carrying else median(away) <= _STRETCH * usual
        )
        if length <= _NOTHING * usual and steady:
            offsets[joint] = bone
    if np.array_equal(offsets, skeleton.offsets):
        return skeleton
    return replace(skeleton, offsets=offsets)


def _carrying(skeleton: Skeleton) -> set[int]:
    """Return the joints that may move the whole figure, such as 'Hips' below 'Reference'.

    These are the joints without siblings on the path down from a root. At the end of the path,
    joints with more than two children are added, such as the hips of two people below one reference
    joint.
    """
    found = set()
    for here in np.flatnonzero(skeleton.parents < 0).tolist():
        below = skeleton.children[here]
        while len(below) == 1:
            found.add(below[0])
            below = skeleton.children[below[0]]
        found.update(joint for joint in below if len(skeleton.children[joint]) > 2)
    return found


def _rotations(channels: tuple[JointChannels, ...], values: Array) -> Array:
    """Return the local rotations as quaternions, (frames, joints, 4)."""
    by_order: dict[str, list[int]] = {}
    for joint, layout in enumerate(channels):
        if layout.order:
            by_order.setdefault(layout.order, []).append(joint)
    columns = {o: np.array([channels[j].rotation for j in js]).T for o, js in by_order.items()}
    rotations = np.empty((len(values), len(channels), 4))
    # Frames are processed in blocks that fit into the processor's cache, with frames as the last
    # axis.
    step = max(64, _ELEMENTS // max(len(channels), 1))
    for a in range(0, len(values), step):
        written = np.ascontiguousarray(values[a : a + step].T)
        q = np.zeros((4, len(channels), written.shape[1]))
        q[0] = 1.0
        for order, joints in by_order.items():
            half = np.radians(written[columns[order]])
            half *= 0.5
            _compose(q, joints, order, np.cos(half), np.sin(half))
        rotations[a : a + step] = q.transpose(2, 1, 0)
    return rotations


def _compose(q: Array, joints: list[int], order: str, cos: Array, sin: Array) -> None:
    """Write the rotations of joints with the same Euler order into q, (4, joints, frames).

    The values equal those of `quaternion_from_euler`. `cos` and `sin` contain the cosines and sines
    of half the angles.
    """
    parts = [cos[0], np.zeros_like(cos[0]), np.zeros_like(cos[0]), np.zeros_like(cos[0])]
    parts[1 + "XYZ".index(order[0])] = sin[0]
    for k, letter in enumerate(order[1:], 1):
        i = "XYZ".index(letter)
        o, j, m = 1 + i, 1 + (i + 1) % 3, 1 + (i + 2) % 3
        (w, x), (y, z) = (parts[0], parts[o]), (parts[j], parts[m])
        c, s = cos[k], sin[k]
        parts[0], parts[o] = w * c - x * s, x * c + w * s
        parts[j], parts[m] = y * c + z * s, z * c - y * s
    for component, part in zip(q, parts, strict=True):
        component[joints] = part
