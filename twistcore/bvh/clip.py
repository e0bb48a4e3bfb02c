"""A BVH as it was read: its bytes, its motion, and which number stands where."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.motion import Motion, Skeleton
from twistcore.rotation import Array

SHORTEST, LONGEST = 1e-4, 1.0  # seconds: frame times that can be meant
_BLOCK = 1 << 18  # bytes
_ELEMENTS = 1 << 14  # numbers of one kind in a block


@dataclass(frozen=True)
class JointChannels:
    """Where a joint's channels stand in a row.

    order: letters of its rotation channels in file order, such as 'ZYX'; rotation: their columns;
    position: (axis 0-2, column) of its position channels.
    """

    order: str
    rotation: tuple[int, ...]
    position: tuple[tuple[int, int], ...]

    @property
    def rotatable(self) -> bool:
        """Three rotation channels about three distinct axes: every orientation can be written."""
        return len(self.order) == 3 and len(set(self.order)) == 3


@dataclass(frozen=True)
class BvhWarning:
    """What was read with an assumption: a sentence, and the line (from 1) if it has one."""

    text: str
    line: int | None = None

    def __str__(self) -> str:
        return self.text if self.line is None else f"Line {self.line}: {self.text}"


@dataclass(frozen=True, eq=False)
class Clip:
    """A BVH file.

    path: as opened; data: the file's bytes, never changed; data_start: where the first number of
    the motion stands; skeleton: its joints; channels: one entry a joint; values: the numbers as
    written (degrees and length units), shape (frames, columns); frame_time: seconds; warnings:
    everything that was read with an assumption.
    """

    path: Path
    data: bytes
    data_start: int
    skeleton: Skeleton
    channels: tuple[JointChannels, ...]
    values: Array
    frame_time: float
    warnings: tuple[BvhWarning, ...] = ()

    def __repr__(self) -> str:
        size = f"{len(self.values)} frames at {1.0 / self.frame_time:g} fps"
        return f"<Clip {self.name}: {size}, {len(self.skeleton)} joints>"

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

    @cached_property
    def motion(self) -> Motion:
        """What the bytes mean; computed when first asked for."""
        return _motion(self.skeleton, self.channels, self.values, self.frame_time)

    @cached_property
    def sha256(self) -> str:
        """Hash of the bytes: what a session remembers its clip by."""
        return hashlib.sha256(self.data).hexdigest()

    @cached_property
    def token_spans(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Byte offsets of start and end of every number of the motion, in reading order."""
        return token_spans(self.data, self.data_start)


def token_spans(data: bytes, start: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Start and end offsets of the tokens between white space in data[start:]."""
    buffer = np.frombuffer(data, dtype=np.uint8)
    edges = []
    blank = np.True_
    for a in range(start, len(data), _BLOCK):  # in blocks: the mask of all would be a second file
        solid = buffer[a : a + _BLOCK] > 32
        turned = np.empty(len(solid), dtype=np.bool_)
        np.not_equal(solid[1:], solid[:-1], out=turned[1:])
        turned[0] = solid[0] == blank
        blank = ~solid[-1]
        edges.append(np.flatnonzero(turned) + a)
    if not blank:
        edges.append(np.array([len(data)]))
    every = np.concatenate(edges) if edges else np.zeros(0, dtype=np.int64)
    return every[0::2], every[1::2]


def _motion(
    skeleton: Skeleton, channels: tuple[JointChannels, ...], values: Array, frame_time: float
) -> Motion:
    positioned = tuple(j for j, layout in enumerate(channels) if layout.position)
    positions = np.empty((len(values), len(positioned), 3))
    positions[:] = skeleton.offsets[list(positioned)]
    for k, joint in enumerate(positioned):
        for axis, column in channels[joint].position:
            positions[:, k, axis] = values[:, column]
    return Motion(skeleton, _rotations(channels, values), positioned, positions, frame_time)


def _rotations(channels: tuple[JointChannels, ...], values: Array) -> Array:
    """Local rotations, (frames, joints, 4)."""
    by_order: dict[str, list[int]] = {}
    for joint, layout in enumerate(channels):
        if layout.order:
            by_order.setdefault(layout.order, []).append(joint)
    columns = {o: np.array([channels[j].rotation for j in js]).T for o, js in by_order.items()}
    rotations = np.empty((len(values), len(channels), 4))
    # Blocks of frames with the joints in front: every pass over the numbers stays in the cache.
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
    """quaternion_from_euler with components, then joints, in front; fills q[:, joints]."""
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
