"""A clip read from an AMC file, with the position of every number in the file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.amc.asf import Asf
from twistcore.formats.bvh.channels import motion_from_channels
from twistcore.formats.bvh.clip import token_spans
from twistcore.formats.bvh.patch import (
    changed_position_values,
    changed_rotation_values,
    replace_numbers,
)
from twistcore.formats.clip import Clip, Patch
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, conjugate, multiply
from twistcore.work.frozen import dataclass

_UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class AmcClip(Clip):
    """A clip read from an AMC file.

    Parameters
    ----------
    asf
        The skeleton file.
    values
        The numbers in the order of the joints, lengths in the file's unit and angles in degrees,
        shape (frames, columns).
    places
        Index of each number among all tokens of the file, in reading order, shape (frames,
        columns).
    radians
        True if the file's angles are in radians.
    """

    format = "amc"

    asf: Asf
    values: Array
    places: NDArray[np.int64]
    radians: bool = False

    @property
    def companions(self) -> Mapping[str, bytes]:
        """The bytes of the skeleton file, keyed by its name."""
        return {self.asf.path.name: self.asf.data}

    @property
    def frames(self) -> int:
        """The number of frames."""
        return len(self.values)

    @property
    def columns(self) -> int:
        """The number of values per frame."""
        return int(self.values.shape[1])

    def read_motion(self) -> Motion:
        """Convert the numbers in `values` to a motion."""
        motion = motion_from_channels(
            self.skeleton, self.asf.channels, self.values, self.frame_time
        )
        rotations = motion.rotations
        for joint in np.flatnonzero((self.asf.axes != _UNTURNED).any(axis=1)).tolist():
            axes = self.asf.axes[joint]
            rotations[:, joint] = multiply(multiply(axes, rotations[:, joint]), conjugate(axes))
        return replace(motion, positions=motion.positions + self._start)

    @cached_property
    def _start(self) -> Array | float:
        """Offset added to the translation of the root, (3,), or 0 if there is none."""
        return self.asf.start if self.asf.start.any() else 0.0

    @cached_property
    def token_spans(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Return two arrays: the byte offsets of the starts and of the ends of all tokens."""
        return token_spans(self.data, 0)

    def angles(self, joint: int) -> Array:
        """Return a joint's angles in the order of the file, in degrees, (frames, channels)."""
        return self.values[:, list(self.asf.channels[joint].rotation[::-1])]

    def euler(self, joint: int) -> tuple[str, Array] | None:
        """Return a joint's Euler order and its angles in radians, (frames, 3), or None.

        The angles refer to the bone's own axes, as in :meth:`as_written`. The result is None for a
        joint without three rotation channels.
        """
        layout = self.asf.channels[joint]
        if not layout.rotatable:
            return None
        return layout.order, np.radians(self.values[:, list(layout.rotation)])

    def as_written(self, joint: int, q: Array) -> Array:
        """Convert a joint's rotation q, (…, 4), to the bone's own axes, as in the file.

        The result is C⁻¹ · q · C, where C is the bone's axis rotation.
        """
        axes = self.asf.axes[joint]
        return multiply(multiply(conjugate(axes), q), axes)

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
            True to also write the root's translation in frames in which it differs.

        Raises
        ------
        ValueError
            If a changed bone does not have three degrees of freedom.
        """
        rotations = motion.rotations.copy()
        for joint in np.flatnonzero(changed.any(axis=0)).tolist():
            rotations[:, joint] = self.as_written(joint, rotations[:, joint])
        turned = motion.with_rotations(rotations)
        layouts = self.asf.channels
        names = self.skeleton.names
        found = changed_rotation_values(self.values, layouts, names, turned, changed)
        tokens, numbers, jumps = found
        if self.radians:
            numbers = np.radians(numbers)
        if positions:
            raw = [replace(m, positions=m.positions - self._start) for m in (self.motion, motion)]
            places, there = changed_position_values(layouts, self.columns, *raw)
            tokens, numbers = np.concatenate([tokens, places]), np.concatenate([numbers, there])
        if not len(tokens):
            return Patch(self.data)
        written = replace_numbers(self.data, self.token_spans, self.places.ravel()[tokens], numbers)
        return Patch(written, jumps)
