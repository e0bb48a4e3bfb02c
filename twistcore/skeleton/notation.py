"""How coarsely a clip is written: angles in whole degrees, frames held, linear keys.

What a notation cannot express is no motion, and what it makes of motion is no error. All of it is
recognised from the clip itself; a clip in plain notation is never taken for a coarse one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.motion import Motion, once_a_motion
from twistcore.skeleton.notes import Note
from twistcore.skeleton.rotation import Array, conjugate, multiply, wrap
from twistcore.work.frozen import dataclass

Frames = NDArray[np.intp]
Mask = NDArray[np.bool_]

KIND = "notation"  # of the notes
# Steps of written angles, degrees, that count as coarse: what is finer is lost in any motion.
STEPS = (10.0, 5.0, 2.0, 1.0, 0.5, 0.25, 0.2, 0.1)
MULTIPLES, FEWEST = 0.9, 60  # share of the changed angles, and how many at least
_ENOUGH = 400  # changed angles after which a plain clip is known to be one
_SAME = 1e-7  # degrees
SAMPLE = 1024  # frames in the middle of a clip that tell its notation
HELD_SHARE, HELD_ALIKE = 0.4, 0.9  # of repeated frames; of runs as long as most, or one frame off
STILL = 3.0  # times as long as most runs: a figure that stands still
FEWEST_HELD, FEWEST_KEYS = 8, 6  # runs, and keys, that show a rule
USUAL = 0.35  # quantile of the changes of pace in a frame of n that tells it
MOVES = 0.05  # of the usual change of pace: with less a figure stands still from key to key
# Frames from key to key. With fewer the pace changes in most frames, as natural motion does, and a
# piece between two keys cannot outvote a jump in it.
LEAST_BETWEEN, MOST_BETWEEN = 5, 60
FEWEST_A_SECOND = 7.5  # keys: what fewer show is shown, and never corrected automatically
BETWEEN_KEYS = math.radians(60.0)  # a second: natural motion leaves less from key to key
# How much more than its share of all changes of pace falls on one frame in n, 0…1. 87 captures have
# at most 0.05, pieces of them of 30 to 200 frames 0.14; with linear keys they have 0.46 and more.
KEYED = 0.3
UNSEEN = 3.0  # steps of written angles: a smaller error is no more than rounding makes


# -- angles in steps -------------------------------------------------------------------------------


def angle_step(angles: Iterable[Array]) -> float:
    """The step of a clip's written angles, radians; 0 where it is finer than 0.1°.

    angles: of one joint after the other, degrees, (frames, channels). Only angles that differ from
    the frame before tell anything: 0 is a multiple of everything.
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


# -- frames that say it all ------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class DistinctFrames:
    """The frames of a clip that say it all: those that differ, or linear keys.

    motion: these alone, at their own rate; first: where each is in the clip, (kept,); frames: of
    the clip; even: between them all goes on evenly, and is not held.
    """

    motion: Motion
    first: Frames
    frames: int
    even: bool = False

    @property
    def too_few(self) -> bool:
        """Whether so few keys a second do not tell an error from motion."""
        return self.even and self.motion.fps < FEWEST_A_SECOND

    @property
    def smallest(self) -> float:
        """The least τ that tells an error from motion between two keys, radians; 0 if held."""
        return BETWEEN_KEYS / self.motion.fps if self.even else 0.0

    def begin(self, kept: int) -> int:
        """The first frame of the clip that an interval beginning with a kept frame changes."""
        if self.even and kept:
            return int(self.first[kept - 1]) + 1
        return int(self.first[kept]) if kept < len(self.first) else self.frames

    def end(self, kept: int) -> int:
        """The frame of the clip behind an interval that ends before a kept frame."""
        return int(self.first[kept]) if kept < len(self.first) else self.frames

    def of(self, frame: int) -> int:
        """The kept frame that a frame of the clip shows, or comes from."""
        return max(0, int(np.searchsorted(self.first, frame, side="right")) - 1)

    def spread(self, start: int, offset: Array) -> Array:
        """An offset over kept frames [start, start + n) in all frames of the clip that it changes.

        Radians. Held with its frame, or from 0 at the key before to 0 at the key behind.
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


# -- frames held -----------------------------------------------------------------------------------


@once_a_motion
def without_held(motion: Motion) -> DistinctFrames | None:
    """The motion without repeated frames, where most frames are repeated by a rule; else None.

    A frame in which anything differs from the one before is kept, so that an error begins in its
    own frame. Of a figure that stands still the frames are kept that the rule would have.
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
    """Where runs of equal frames begin, and the end, (runs + 1,)."""
    differs = (rotations[1:] != rotations[:-1]).any(axis=(1, 2))
    return np.concatenate([[0], np.flatnonzero(differs) + 1, [len(rotations)]]).astype(np.intp)


def _held_often(starts: Frames) -> float | None:
    """How long runs of equal frames mostly are; None where they follow no rule."""
    lengths = np.diff(starts)
    if len(lengths) < FEWEST_HELD or len(lengths) > (1.0 - HELD_SHARE) * starts[-1]:
        return None
    usual = int(np.bincount(lengths).argmax())
    lengths = lengths[1:-1]  # a clip may begin or end within a run
    moving = lengths[lengths <= STILL * usual]
    alike = np.abs(moving - usual) <= 1
    if usual < 2 or len(moving) < FEWEST_HELD - 2 or alike.mean() < HELD_ALIKE:
        return None
    return float(moving[alike].mean())


# -- linear keys -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Keys:
    """Linear keys: one every `spacing` frames, the first in frame `first`."""

    spacing: int
    first: int

    def mask(self, frames: int) -> Mask:
        """True at keys, (frames,)."""
        mask: Mask = (np.arange(frames) - self.first) % self.spacing == 0
        return mask

    def alone(self, motion: Motion) -> DistinctFrames:
        """The keys of a motion; its first frame is a key, too."""
        first = np.flatnonzero(self.mask(motion.frames))
        if first[0] > 0:
            first = np.concatenate([[0], first])
        own = replace(motion.at(first), frame_time=motion.frame_time * self.spacing)
        return DistinctFrames(own, first, motion.frames, even=True)


@once_a_motion
def linear_keys(motion: Motion) -> Keys | None:
    """The keys between which all joints turn evenly; None where there are none.

    The pace of joints changes at keys and hardly in between: of the changes of pace, folded over n
    frames, one frame has nearly all. Errors, cuts and a rest pose in front are outvoted.
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
        # Below the middle: where every other row has a key the spacing is twice as long.
        folded = np.sort(rows, axis=0)[int(USUAL * len(rows))]
        most = int(folded.argmax())
        share = (folded[most] / max(float(folded.sum()), 1e-12) - 1.0 / spacing) * (
            spacing / (spacing - 1.0)
        )
        if share > best:
            best, found = share, Keys(spacing, (most + 1 + middle.start) % spacing)
    return found if found is not None and found.spacing >= LEAST_BETWEEN else None


# -- in words --------------------------------------------------------------------------------------


def notation_notes(motion: Motion) -> tuple[Note, ...]:
    """What was recognised, in sentences."""
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
            f"Frames are repeated: {held.motion.fps:.4g} frames per second are written as "
            f"{motion.fps:.4g}, and errors are looked for at the lower rate."
        )
    elif keys := linear_keys(motion):
        rate = motion.fps / keys.spacing
        said.append(
            f"There is a key every {keys.spacing} frames, and the joints turn evenly in "
            f"between. Errors of {math.degrees(BETWEEN_KEYS) / rate:.2g}° or more are looked "
            f"for at the keys ({rate:.3g} per second) and at jumps."
        )
        if rate < FEWEST_A_SECOND:
            said.append(
                "There are too few keys to tell errors from motion, so finds are listed but "
                "not corrected automatically."
            )
    return tuple(Note(KIND, text) for text in said)
