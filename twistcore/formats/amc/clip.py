"""An AMC as it was read: its motion, and which number stands where."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.amc.asf import Asf
from twistcore.formats.bvh.channels import motion_from_channels
from twistcore.formats.bvh.clip import token_spans
from twistcore.formats.bvh.patch import moved_numbers, turned_numbers, with_numbers
from twistcore.formats.clip import Clip, Patch
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, conjugate, multiply
from twistcore.work.frozen import dataclass

_UNTURNED = np.array([1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class AmcClip(Clip):
    """An AMC file.

    asf: its skeleton, of another file; values: its numbers in the order of the joints, lengths in
    the file's unit and angles in degrees, (frames, columns); places: which token of the file each
    is, in reading order, (frames, columns); radians: whether the file has its angles so.
    """

    format = "amc"

    asf: Asf
    values: Array
    places: NDArray[np.int64]
    radians: bool = False

    @property
    def companions(self) -> Mapping[str, bytes]:
        """The skeleton."""
        return {self.asf.path.name: self.asf.data}

    @property
    def frames(self) -> int:
        """Number of frames."""
        return len(self.values)

    @property
    def columns(self) -> int:
        """Numbers in a frame."""
        return int(self.values.shape[1])

    def read_motion(self) -> Motion:
        """What the numbers mean."""
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
        """What is added to the translation of the root, which alone can have one."""
        return self.asf.start if self.asf.start.any() else 0.0

    @cached_property
    def token_spans(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Byte offsets of start and end of every token of the file."""
        return token_spans(self.data, 0)

    def angles(self, joint: int) -> Array:
        """A joint's degrees of freedom as written, degrees, (frames, those that it has)."""
        return self.values[:, list(self.asf.channels[joint].rotation[::-1])]

    def euler(self, joint: int) -> tuple[str, Array] | None:
        """Letters and angles, radians, (frames, 3), of :meth:`as_written`; None without three."""
        layout = self.asf.channels[joint]
        if not layout.rotatable:
            return None
        return layout.order, np.radians(self.values[:, list(layout.rotation)])

    def as_written(self, joint: int, q: Array) -> Array:
        """A joint's rotation q, (…, 4), about the bone's own axes: R = C⁻¹ · q · C."""
        axes = self.asf.axes[joint]
        return multiply(multiply(conjugate(axes), q), axes)

    def patched(
        self, motion: Motion, changed: NDArray[np.bool_], *, positions: bool = False
    ) -> Patch:
        """The bytes with the numbers at `changed` (frames, joints) taken from `motion`.

        positions: also the root's translation where it differs. Every other byte stays. A number
        keeps its count of decimals, at least 6, and never gets an exponent. ValueError for a bone
        without three degrees of freedom.
        """
        rotations = motion.rotations.copy()
        for joint in np.flatnonzero(changed.any(axis=0)).tolist():
            rotations[:, joint] = self.as_written(joint, rotations[:, joint])
        turned = motion.with_rotations(rotations)
        layouts = self.asf.channels
        told = self.values, layouts, self.skeleton.names, turned, changed
        tokens, numbers, jumps = turned_numbers(*told)
        if self.radians:
            numbers = np.radians(numbers)
        if positions:
            raw = [replace(m, positions=m.positions - self._start) for m in (self.motion, motion)]
            places, there = moved_numbers(layouts, self.columns, *raw)
            tokens, numbers = np.concatenate([tokens, places]), np.concatenate([numbers, there])
        if not len(tokens):
            return Patch(self.data)
        written = with_numbers(self.data, self.token_spans, self.places.ravel()[tokens], numbers)
        return Patch(written, jumps)
