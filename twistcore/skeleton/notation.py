"""Recognise clips with a coarse *notation*: rounded angles, held frames or linear keys.

Held frames repeat the previous frame. Between linear keys, joints rotate at constant speed. The
artefacts of such a notation are neither motion nor errors. The notation is recognised from the
values in the clip alone. A clip in ordinary notation is never mistaken for a coarse one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.motion import Motion, cache_per_object
from twistcore.skeleton.notes import Note
from twistcore.skeleton.rotation import Array, conjugate, multiply, vector_lengths, wrap
from twistcore.work.frozen import dataclass

Frames = NDArray[np.intp]
Mask = NDArray[np.bool_]

KIND = "notation"  # kind of the notes about the notation
# Steps of rounded angles that are recognised, in degrees. Finer steps make no difference.
STEPS = (10.0, 5.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1)
# Minimum share of angles that are multiples of the step, and minimum number of angles.
MULTIPLES, FEWEST = 0.9, 60
_ENOUGH = 400  # number of angles after which a clip without a step is recognised as ordinary
# Degrees; an angle within this distance of a multiple of the step counts as a multiple.
_SAME = 1e-7
SAMPLE = 1024  # number of frames in the middle of a clip that are examined
# Minimum shares of repeated frames, and of runs of the usual length ±1.
HELD_SHARE, HELD_ALIKE = 0.4, 0.9
STILL = 3.0  # in a run longer than this multiple of the usual length, the figure is still
FEWEST_HELD, FEWEST_KEYS = 8, 6  # minimum number of runs and of keys that form a pattern
USUAL = 0.35  # quantile over the periods of n frames; see find_keys_of_linear_motion
MOVES = 0.05  # share of the usual change of speed; below it, the figure is still
# Limits of the spacing of keys, in frames. With a smaller spacing, the speed changes in most
# frames, as in natural motion, and there are too few frames between two keys to recognise a jump
# among them.
LEAST_BETWEEN, MOST_BETWEEN = 5, 60
FEWEST_A_SECOND = 7.5  # with fewer keys per second, nothing is corrected automatically
BETWEEN_KEYS = math.radians(60.0)  # radians/second; natural motion deviates less between keys
# Minimum concentration of the changes of speed in every n-th frame: 0 by chance, 1 if all changes
# are in these frames. The concentration is at most 0.05 in 87 captures, at most 0.14 in excerpts of
# 30 to 200 frames from these captures, and at least 0.46 in clips with linear keys.
KEYED = 0.3
UNSEEN = 3.0  # number of steps; a smaller error may be rounding


# -- rounded angles --------------------------------------------------------------------------------


def rounding_step_of_angles(angles: Iterable[Array]) -> float:
    """Return the step to which a clip's angles are rounded, in radians, or 0 if it is below 0.1°.

    `angles` has one array per joint, in degrees, shape (frames, channels). Angles that equal those
    of the previous frame are ignored, because constants such as 0 fit any step.
    """
    told = np.zeros(len(STEPS), dtype=np.int64)
    many = 0
    for of_joint in angles:
        middle = of_joint[_middle(len(of_joint))]
        changed = middle[1:][middle[1:] != middle[:-1]]
        many += len(changed)
        for k, step in enumerate(STEPS):
            told[k] += int((np.abs(changed - step * np.round(changed / step)) < _SAME).sum())
        if many > _ENOUGH and told.max() < 0.5 * many:
            return 0.0
    if many < FEWEST:
        return 0.0
    return next(
        (math.radians(s) for s, n in zip(STEPS, told, strict=True) if n >= MULTIPLES * many), 0.0
    )


def _middle(frames: int) -> slice:
    first = max(0, (frames - SAMPLE) // 2)
    return slice(first, first + SAMPLE)


# -- distinct frames -------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class DistinctFrames:
    """The frames that determine a clip: the frames that are not repeats, or the linear keys.

    These frames are called *kept frames*.

    Attributes
    ----------
    motion
        The motion in the kept frames, with their frame rate.
    first
        Index of each kept frame in the clip, shape (kept,).
    frames
        Number of frames of the clip.
    even
        True if the clip interpolates linearly between kept frames, False if it repeats them.
    """

    motion: Motion
    first: Frames
    frames: int
    even: bool = False

    @property
    def too_few(self) -> bool:
        """Return True if there are too few keys per second to tell an error from motion."""
        return self.even and self.motion.fps < FEWEST_A_SECOND

    @property
    def smallest(self) -> float:
        """Return the smallest τ, in radians, at which errors can be distinguished from motion.

        The result is 0 for held frames.
        """
        return BETWEEN_KEYS / self.motion.fps if self.even else 0.0

    def begin(self, kept: int) -> int:
        """Return the frame of the clip at which an interval begins.

        `kept` is the index of the interval's first kept frame (a frame that is not a repeat, or a
        linear key). Between linear keys, the interval begins directly after the previous key.
        """
        if self.even and kept:
            return int(self.first[kept - 1]) + 1
        return int(self.first[kept]) if kept < len(self.first) else self.frames

    def end(self, kept: int) -> int:
        """Return the first frame of the clip after an interval.

        `kept` is the index of the first kept frame (a frame that is not a repeat, or a linear key)
        after the interval.
        """
        return int(self.first[kept]) if kept < len(self.first) else self.frames

    def of(self, frame: int) -> int:
        """Return the index of the last kept frame at or before a frame of the clip.

        Kept frames are the frames that are not repeats, or the linear keys.
        """
        return max(0, int(np.searchsorted(self.first, frame, side="right")) - 1)

    def spread(self, start: int, offset: Array) -> Array:
        """Extend an interval's offset from the kept frames to all frames of the clip.

        In held frames, the offset stays the same. Between linear keys, it is interpolated, from 0
        at the key before the interval to 0 at the key after it.

        Parameters
        ----------
        start
            Index of the first kept frame of the interval.
        offset
            Offset in the interval's kept frames, radians, shape (kept frames,).

        Returns
        -------
        ndarray, shape (frames of the clip,)
            The offset in radians, in frames from :meth:`begin` to :meth:`end`.
        """
        stop = start + len(offset)
        if not self.even:
            ends = [self.end(k) for k in range(start, stop + 1)]
            return offset.repeat(np.diff(ends))
        low, high = max(start - 1, 0), min(stop + 1, len(self.first))
        at_keys = np.zeros(high - low)
        at_keys[start - low : stop - low] = np.unwrap(offset)
        frames = np.arange(self.begin(start), self.end(stop))
        return wrap(np.interp(frames, self.first[low:high], at_keys))


# -- held frames -----------------------------------------------------------------------------------


@cache_per_object
def without_repeated_frames(motion: Motion) -> DistinctFrames | None:
    """Return the motion without held frames, which repeat the previous frame.

    The result is None if frames are not repeated regularly. Every frame that differs from the
    previous one is kept, so that an error begins in the right frame. While the figure is still,
    frames are kept at the usual spacing.
    """
    starts = _run_starts(motion.rotations[_middle(motion.frames)])
    if _held_often(starts) is None:
        return None
    starts = _run_starts(motion.rotations)
    often = _held_often(starts)
    if often is None:
        return None
    step = max(1, round(often))
    kept = [
        np.arange(a, a + n, step) if n > STILL * often else np.array([a])
        for a, n in zip(starts[:-1].tolist(), np.diff(starts).tolist(), strict=True)
    ]
    first = np.concatenate(kept).astype(np.intp)
    own = replace(motion.at(first), frame_time=motion.frame_time * often)
    return DistinctFrames(own, first, motion.frames)


def _run_starts(rotations: Array) -> Frames:
    """Return the first frame of each run of equal frames, followed by the number of frames.

    The shape is (runs + 1,).
    """
    differs = (rotations[1:] != rotations[:-1]).any(axis=(1, 2))
    return np.concatenate([[0], np.flatnonzero(differs) + 1, [len(rotations)]]).astype(np.intp)


def _held_often(starts: Frames) -> float | None:
    """Return the usual length of runs of equal frames, or None if there is no regular length.

    `starts` is the result of :func:`_run_starts`.
    """
    lengths = np.diff(starts)
    if len(lengths) < FEWEST_HELD or len(lengths) > (1.0 - HELD_SHARE) * starts[-1]:
        return None
    usual = int(np.bincount(lengths).argmax())
    lengths = lengths[1:-1]  # the first and the last run may be incomplete
    moving = lengths[lengths <= STILL * usual]
    alike = np.abs(moving - usual) <= 1
    if usual < 2 or len(moving) < FEWEST_HELD - 2 or alike.mean() < HELD_ALIKE:
        return None
    return float(moving[alike].mean())


# -- linear keys -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Keys:
    """Linear keys in every `spacing`-th frame, beginning with frame `first`.

    Between the keys, all joints rotate at constant speed.
    """

    spacing: int
    first: int

    def mask(self, frames: int) -> Mask:
        """Return a mask of the frames that are keys, (frames,)."""
        mask: Mask = (np.arange(frames) - self.first) % self.spacing == 0
        return mask

    def alone(self, motion: Motion) -> DistinctFrames:
        """Return the motion at the keys only. The first frame is always included."""
        first = np.flatnonzero(self.mask(motion.frames))
        if first[0] > 0:
            first = np.concatenate([[0], first])
        own = replace(motion.at(first), frame_time=motion.frame_time * self.spacing)
        return DistinctFrames(own, first, motion.frames, even=True)


@cache_per_object
def find_keys_of_linear_motion(motion: Motion) -> Keys | None:
    """Return the keys between which all joints rotate at constant speed, or None if there are none.

    The speed of the joints changes at keys and hardly changes between them. If there is a key in
    every n-th frame, nearly all changes of speed are in frames with the same remainder modulo n.
    Because many keys are compared, errors, cuts and a rest pose at the start have little influence.
    """
    middle = _middle(motion.frames)
    q = motion.rotations[middle]
    if len(q) < 2 * FEWEST_KEYS + 2:
        return None
    turns = multiply(conjugate(q[:-1]), q[1:])
    turns = np.where(turns[..., :1] < 0.0, -turns, turns)[..., 1:]
    changes = np.sqrt(vector_lengths(np.diff(turns, axis=0)))  # (frames − 2, joints)
    usual = changes.mean(axis=0)
    changes = changes[:, usual > 1e-4]
    if not changes.shape[1]:
        return None
    pace = (changes / usual[usual > 1e-4]).mean(axis=1)
    best, found = KEYED, None
    for spacing in range(2, min(MOST_BETWEEN, len(pace) // FEWEST_KEYS) + 1):
        whole = len(pace) // spacing * spacing
        rows = pace[:whole].reshape(-1, spacing)
        rows = rows[rows.mean(axis=1) > MOVES]
        if len(rows) < FEWEST_KEYS:
            continue
        # If only every other row has a key, a quantile below the median is low.
        folded = np.sort(rows, axis=0)[int(USUAL * len(rows))]
        most = int(folded.argmax())
        share = (folded[most] / max(float(folded.sum()), 1e-12) - 1.0 / spacing) * (
            spacing / (spacing - 1.0)
        )
        if share > best:
            best, found = share, Keys(spacing, (most + 1 + middle.start) % spacing)
    return found if found is not None and found.spacing >= LEAST_BETWEEN else None


# -- notes -----------------------------------------------------------------------------------------


def notes_on_coarse_motion_notation(motion: Motion) -> tuple[Note, ...]:
    """Return notes for the user about each coarse notation that was recognised."""
    said = []
    if motion.angle_step:
        step = math.degrees(motion.angle_step)
        written = "whole degrees" if round(step, 6) == 1.0 else f"steps of {step:g}°"
        least = UNSEEN * step
        said.append(
            f"Angles are written in {written}: errors below {least:.2g}° look the same as rounding."
        )
    held = without_repeated_frames(motion)
    if held is not None:
        said.append(
            f"Frames are repeated: the motion has {held.motion.fps:.4g} frames per second, "
            f"but the file has {motion.fps:.4g}. The program searches for errors at the "
            "lower rate."
        )
    elif keys := find_keys_of_linear_motion(motion):
        rate = motion.fps / keys.spacing
        said.append(
            f"There is a key every {keys.spacing} frames, and the joints turn evenly in "
            "between. The program searches for errors of "
            f"{math.degrees(BETWEEN_KEYS) / rate:.2g}° or more at the keys ({rate:.3g} per "
            "second) and at jumps."
        )
        if rate < FEWEST_A_SECOND:
            said.append(
                "There are too few keys to tell errors from motion, so detections are listed but "
                "not corrected automatically."
            )
    return tuple(Note(KIND, text) for text in said)
