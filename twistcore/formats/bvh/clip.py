"""A clip read from a BVH file, with the position of every number in the text."""

from __future__ import annotations

from dataclasses import field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.files.wide_text import WideText
from twistcore.formats.bvh.channels import JointChannels, motion_from_channels
from twistcore.formats.bvh.patch import (
    changed_position_values,
    changed_rotation_values,
    replace_numbers,
)
from twistcore.formats.clip import Clip, Patch
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

_BLOCK = 1 << 18  # number of bytes that are searched in one step


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class BvhClip(Clip):
    """A clip read from a BVH file.

    Parameters
    ----------
    text
        The file's bytes, converted to UTF-8 if the file is in UTF-16 or UTF-32.
    wide
        The encoding of a file in UTF-16 or UTF-32, or None.
    data_start
        Offset of the first motion number in the text.
    channels
        The channels of each joint.
    values
        The motion numbers as written, in degrees and length units, shape (frames, columns).
    """

    format = "bvh"

    text: bytes = field(repr=False)
    wide: WideText | None = None
    data_start: int
    channels: tuple[JointChannels, ...]
    values: Array

    @property
    def frames(self) -> int:
        """The number of frames."""
        return len(self.values)

    @property
    def columns(self) -> int:
        """The number of values in a row."""
        return int(self.values.shape[1])

    def read_motion(self) -> Motion:
        """Convert the numbers in `values` to a motion."""
        return motion_from_channels(self.skeleton, self.channels, self.values, self.frame_time)

    @cached_property
    def token_spans(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return two arrays: the byte offsets of the starts and the ends of all motion numbers."""
        return token_spans(self.text, self.data_start)

    def angles(self, joint: int) -> Array:
        """Return a joint's rotation channels in degrees, (frames, channels)."""
        return self.values[:, list(self.channels[joint].rotation)]

    def euler(self, joint: int) -> tuple[str, Array] | None:
        """Return a joint's Euler order and its angles in radians, (frames, 3), or None.

        The result is None for a joint without three rotation channels.
        """
        layout = self.channels[joint]
        return (layout.order, np.radians(self.angles(joint))) if layout.rotatable else None

    def patched(
        self, motion: Motion, changed: NDArray[np.bool_], *, positions: bool = False
    ) -> Patch:
        """Return the file's bytes, with the rotations in `changed` replaced by those of `motion`.

        Other bytes stay the same. A new number has as many decimals as the old one, but at least 6,
        and no exponent.

        Parameters
        ----------
        motion
            The motion to write.
        changed
            Mask of the rotations to write, shape (frames, joints).
        positions
            True to also write positions in frames in which they differ.

        Raises
        ------
        ValueError
            If a changed joint does not have three rotation channels.
        """
        names = self.skeleton.names
        found = changed_rotation_values(self.values, self.channels, names, motion, changed)
        tokens, numbers, jumps = found
        if positions:
            places, there = changed_position_values(
                self.channels, self.columns, self.motion, motion
            )
            tokens, numbers = np.concatenate([tokens, places]), np.concatenate([numbers, there])
        if not len(tokens):
            return Patch(self.data)
        text = replace_numbers(self.text, self.token_spans, tokens, numbers)
        return Patch(text if self.wide is None else self.wide.encoded(text), jumps)


def token_spans(data: bytes, start: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the start and end offsets of the tokens in `data` from offset `start`.

    Tokens are separated by white space.
    """
    buffer = np.frombuffer(data, dtype=np.uint8)
    edges = []
    blank = np.True_
    for a in range(start, len(data), _BLOCK):  # a mask of all bytes would be as large as the file
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
