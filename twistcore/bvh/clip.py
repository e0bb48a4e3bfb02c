"""A BVH as it was read: its bytes, its motion, and which number stands where."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.motion import Motion
from twistcore.rotation import Array


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


@dataclass(frozen=True, eq=False)
class Clip:
    """A BVH file.

    path: as opened; data: the file's bytes, never changed; data_start: where the first number of
    the motion stands; motion: what the bytes mean; channels: one entry a joint; values: the
    numbers as written (degrees and length units), shape (frames, columns); warnings: sentences
    about everything that was read with an assumption.
    """

    path: Path
    data: bytes
    data_start: int
    motion: Motion
    channels: tuple[JointChannels, ...]
    values: Array
    warnings: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.name

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
    solid = np.frombuffer(data, dtype=np.uint8)[start:] > 32
    edges = np.flatnonzero(np.diff(solid.view(np.int8), prepend=0, append=0))
    return edges[0::2] + start, edges[1::2] + start
