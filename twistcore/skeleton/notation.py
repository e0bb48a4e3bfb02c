"""Recognise coarsely written clips: angles in whole degrees, held frames and linear keys.

Artefacts of coarse notation are neither motion nor errors. The notation is recognised from the
numbers. A clip in ordinary notation is never mistaken for a clip in a coarse one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.motion import Motion, once_each
from twistcore.skeleton.notes import Note
from twistcore.skeleton.rotation import Array, conjugate, multiply, wrap
from twistcore.work.frozen import dataclass

Frames = NDArray[np.intp]
Mask = NDArray[np.bool_]

KIND = "notation"  # kind of the notes
# Coarse steps of written angles, degrees. Finer steps make no difference in any motion.
STEPS = (10.0, 5.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1)
MULTIPLES, FEWEST = 0.9, 60  # share of the changed angles, and their minimum number
_ENOUGH = 400  # number of changed angles that is enough to recognise an ordinary clip
_SAME = 1e-7  # degrees; a smaller difference counts as 0
SAMPLE = 1024  # frames in the middle of a clip from which its notation is recognised
HELD_SHARE, HELD_ALIKE = 0.4, 0.9  # shares of repeated frames and of runs of usual length, ±1
STILL = 3.0  # times the usual length of runs; in a longer run, the figure is still
FEWEST_HELD, FEWEST_KEYS = 8, 6  # minimum number of runs and of keys for a pattern
USUAL = 0.35  # quantile of the changes of pace at every n-th frame that is compared
MOVES = 0.05  # share of the usual change of pace; below it, the figure is still between keys
# Minimum number of frames between keys. With fewer, the pace changes in most frames, as in natural
# motion, and the frames between two keys cannot outvote a jump among them.
LEAST_BETWEEN, MOST_BETWEEN = 5, 60
FEWEST_A_SECOND = 7.5  # with fewer keys per second, intervals are never corrected automatically
BETWEEN_KEYS = math.radians(60.0)  # per second; natural motion deviates less than this between keys
# How far the share of every n-th frame in all changes of pace exceeds chance, 0…1. 87 captures have
# at most 0.05, their excerpts of 30 to 200 frames 0.14, and clips with linear keys at least 0.46.
KEYED = 0.3
UNSEEN = 3.0  # steps of written angles; a smaller error may be rounding


# -- angles in steps -------------------------------------------------------------------------------


def angle_step(angles: Iterable[Array]) -> float:
    """Return the step of a clip's written angles in radians, or 0 if it is finer than 0.1°.

    `angles` has one array per joint, in degrees, shape (frames, channels). Angles that are equal to
    the previous frame are ignored, since constants such as 0 fit any step.
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
    """The frames that determine a clip: all frames that are not repeated, or the linear keys.

    Attributes
    ----------
    motion
        The motion in these frames only, at the frame rate of these frames.
    first
        Index of each kept frame in the clip, shape (kept,).
    frames
        Number of frames of the clip.
    even
        True if the clip interpolates linearly between these frames, False if it repeats them.
    """

    motion: Motion
    first: Frames
    frames: int
    even: bool = False

    @property
    def too_few(self) -> bool:
        """True if there are too few keys per second to distinguish an error from motion."""
        return self.even and self.motion.fps < FEWEST_A_SECOND

    @property
    def smallest(self) -> float:
        """Return the lowest τ, in radians, at which an error differs from motion between keys.

        The result is 0 if frames are held.
        """
        return BETWEEN_KEYS / self.motion.fps if self.even else 0.0

    def begin(self, kept: int) -> int:
        """Return the first frame of the clip that changes if an interval begins at a kept frame."""
        if self.even and kept:
            return int(self.first[kept - 1]) + 1
        return int(self.first[kept]) if kept < len(self.first) else self.frames

    def end(self, kept: int) -> int:
        """Return the first frame of the clip after an interval that ends before a kept frame."""
        return int(self.first[kept]) if kept < len(self.first) else self.frames

    def of(self, frame: int) -> int:
        """Return the kept frame that a frame of the clip repeats or follows."""
        return max(0, int(np.searchsorted(self.first, frame, side="right")) - 1)

    def spread(self, start: int, offset: Array) -> Array:
        """Return an offset of kept frames [start, start + n) for all clip frames that it changes.

        The offset is in radians. In held frames it stays the same. Between linear keys it rises
        linearly from 0 at the previous key and falls to 0 at the next key.
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


@once_each
def without_held(motion: Motion) -> DistinctFrames | None:
    """Return the motion without regularly repeated frames, or None if most are not repeated.

    A frame that differs in any way from the previous one is kept, so that an error begins in the
    right frame. While the figure is still, the frames that fit the pattern are kept.
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
    """Return the first frame of each run of equal frames, and finally the end, (runs + 1,)."""
    differs = (rotations[1:] != rotations[:-1]).any(axis=(1, 2))
    return np.concatenate([[0], np.flatnonzero(differs) + 1, [len(rotations)]]).astype(np.intp)


def _held_often(starts: Frames) -> float | None:
    """Return the usual length of runs of equal frames, or None if there is no pattern."""
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
    """Linear keys at every `spacing`-th frame, beginning with frame `first`."""

    spacing: int
    first: int

    def mask(self, frames: int) -> Mask:
        """Return a mask of the frames that are keys, (frames,)."""
        mask: Mask = (np.arange(frames) - self.first) % self.spacing == 0
        return mask

    def alone(self, motion: Motion) -> DistinctFrames:
        """Return the motion reduced to its keys. The first frame always counts as a key."""
        first = np.flatnonzero(self.mask(motion.frames))
        if first[0] > 0:
            first = np.concatenate([[0], first])
        own = replace(motion.at(first), frame_time=motion.frame_time * self.spacing)
        return DistinctFrames(own, first, motion.frames, even=True)


@once_each
def linear_keys(motion: Motion) -> Keys | None:
    """Return the keys between which all joints turn at a constant speed, or None without keys.

    The speed of the joints changes at keys and hardly changes between them. If the frames are
    numbered modulo n, nearly all changes of speed are in frames with the same number. Since many
    keys are compared, errors, cuts and a rest pose at the start have little influence.
    """
    middle = _middle(motion.frames)
    q = motion.rotations[middle]
    if len(q) < 2 * FEWEST_KEYS + 2:
        return None
    turns = multiply(conjugate(q[:-1]), q[1:])
    turns = np.where(turns[..., :1] < 0.0, -turns, turns)[..., 1:]
    changes = np.sqrt(np.linalg.norm(np.diff(turns, axis=0), axis=-1))  # (frames − 2, joints)
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
        # A quantile below the median is low if only every other row has a key.
        folded = np.sort(rows, axis=0)[int(USUAL * len(rows))]
        most = int(folded.argmax())
        share = (folded[most] / max(float(folded.sum()), 1e-12) - 1.0 / spacing) * (
            spacing / (spacing - 1.0)
        )
        if share > best:
            best, found = share, Keys(spacing, (most + 1 + middle.start) % spacing)
    return found if found is not None and found.spacing >= LEAST_BETWEEN else None


# -- sentences -------------------------------------------------------------------------------------


def notation_notes(motion: Motion) -> tuple[Note, ...]:
    """Return sentences about the notations that were recognised."""
    said = []
    if motion.angle_step:
        step = math.degrees(motion.angle_step)
        written = "whole degrees" if round(step, 6) == 1.0 else f"steps of {step:g}°"
        least = UNSEEN * step
        said.append(
            f"Angles are written in {written}: errors below {least:.2g}° look the same as rounding."
        )
    held = without_held(motion)
    if held is not None:
        said.append(
            f"Frames are repeated: the motion has {held.motion.fps:.4g} frames per second, "
            f"but the file has {motion.fps:.4g}. Errors are searched for at the lower rate."
        )
    elif keys := linear_keys(motion):
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
