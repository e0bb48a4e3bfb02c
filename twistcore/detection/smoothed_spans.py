"""Find spans in which a joint has no fine movement, because gaps were filled or it was smoothed.

A captured motion jitters slightly in every frame, and no body moves as evenly as a filtered
motion. Fine movement is measured by the fourth difference, the deviation from an even curve over
five frames. It is ten to ten thousand times smaller where a joint was smoothed, but it is also
smaller where the joint moves slowly. A joint is therefore compared with other frames of its motion
in which it moves at most as fast. If there are none, it is compared with its slowest frames, and
less fine movement is expected at a lower pace. A joint at rest is therefore not mistaken for a
smoothed joint.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, continuous_quaternion_signs
from twistcore.skeleton.runs import group_overlapping_spans, runs_of_true
from twistcore.work.frozen import dataclass

Mask = NDArray[np.bool_]

_WINDOW, _FEWEST = 0.4, 9  # length of the averaging window in seconds and at least in frames
_A_WINDOW = 8  # number of values per window; more are not needed, since they change slowly
_LEAST = 0.5  # seconds; a shorter span may be a calm moment
_REST = 1e-5  # degrees per frame: the rounding of files
_MOVES = 3e-3  # degrees per frame; a joint with a lower maximum pace does not move
# A frame is suspected if its fine movement is this many orders of magnitude below the usual one.
_SUSPECT = 0.5
# The usual fine movement is this quantile over all frames with the same or a lower pace, but at
# least over this share of the frames. It is computed for this number of groups of frames.
_USUAL, _SLOWER, _STEPS = 0.7, 0.7, 4
# A span is reported if its fine movement is this many orders of magnitude below the quantile
# _NEARLY_ALL over frames of the same pace.
_FINER, _NEARLY_ALL = 0.6, 0.05
_OTHERS = 1.5  # minimum duration of the frames to compare with, in seconds
_PACE = 2.0  # orders of magnitude of fine movement per order of magnitude of pace
# A span ends where the fine movement, averaged over _EVEN frames, is larger than in the span by up
# to _BORDER orders of magnitude.
_BORDER, _EVEN = 1.5, 5
_MOST = 5  # maximum number of notes, and of joints in a note
_NUMBERS = 1 << 17  # frames times joints in a block


@dataclass(frozen=True)
class SmoothedSpan:
    """Frames [start, stop) in which a joint's motion was smoothed or a gap in it was filled."""

    joint: int
    start: int
    stop: int


def smoothed_spans(motion: Motion) -> tuple[SmoothedSpan, ...]:
    """Return the smoothed spans of all joints, sorted by start.

    The result is empty for clips with coarsely rounded angles, because their fine movement is
    mostly rounding error.
    """
    width = max(_FEWEST, round(_WINDOW * motion.fps))
    if motion.frames < 2 * width or motion.angle_step:
        return ()
    joints = motion.rotations.shape[1]
    together = max(1, _NUMBERS // motion.frames)  # fewer joints at a time in long clips
    found = [
        span
        for first in range(0, joints, together)
        for span in _of_joints(motion, range(first, min(first + together, joints)), width)
    ]
    return tuple(sorted(found, key=lambda s: (s.start, s.stop, s.joint)))


def _of_joints(motion: Motion, joints: range, width: int) -> Iterator[SmoothedSpan]:
    """Yield the smoothed spans of a block of joints.

    `width` is the length of the window in frames.
    """
    pace, fine, every = _measured(motion.rotations[:, joints.start : joints.stop], width)
    step = max(1, width // _A_WINDOW)
    pace, fine = pace[::step], fine[::step]
    suspected = _usual(pace, fine) - fine > _SUSPECT
    least = max(_FEWEST, round(_LEAST * motion.fps))
    moves = pace.max(axis=0) > np.log10(_MOVES)
    for k in np.flatnonzero(moves & suspected.any(axis=0)).tolist():
        own = pace[:, k], fine[:, k], every[:, k]
        others = max(1, round(_OTHERS * motion.fps))
        one = _Joint(*own, step, width // 2, others, round(0.8 * least))
        for start, stop in runs_of_true(suspected[:, k]):
            if (stop - start) * step >= least and (span := one.confirmed(start, stop)) is not None:
                yield SmoothedSpan(joints[k], *span)


def smoothed_span_sentences(spans: Iterable[SmoothedSpan], names: Sequence[str]) -> tuple[str, ...]:
    """Return the notes about smoothed spans, which must be sorted by start.

    Overlapping spans share a note. The first few notes are returned, followed by a note with the
    number of remaining notes. `names` contains the names of the joints.
    """
    groups = group_overlapping_spans(spans)
    said = [_sentence(group, names) for group in groups[:_MOST]]
    if len(groups) > _MOST:
        said.append(f"{len(groups) - _MOST} more smoothed spans were found.")
    return tuple(said)


def _sentence(group: Sequence[SmoothedSpan], names: Sequence[str]) -> str:
    joints = list(dict.fromkeys(names[s.joint] for s in group))
    start, stop = min(s.start for s in group), max(s.stop for s in group)
    if len(joints) == 1:
        return (
            f"{joints[0]} is smoother in frames {start}–{stop} than anywhere else in the clip: "
            "it may have been filled in or smoothed."
        )
    listed = ", ".join(joints[:_MOST]) + (" …" if len(joints) > _MOST else "")
    return (
        f"Several joints are smoother in frames {start}–{stop} than anywhere else in the clip "
        f"({listed}): they may have been filled in or smoothed."
    )


def _measured(rotations: Array, width: int) -> tuple[Array, Array, Array]:
    """Return log10 of the speed and the fine movement of joints, in degrees per frame.

    The result has three arrays, (frames, joints): the speed averaged over a window of `width`
    frames, the fine movement averaged over this window, and the fine movement in every frame.
    """
    changes = np.diff(continuous_quaternion_signs(rotations), axis=0)  # half of a turn, in radians
    moved = _mean_around(_squared(changes), width)
    pace = 0.5 * np.log10(np.maximum(moved, 0.0) + _REST**2)
    off = 0.5 * np.log10(_squared(np.diff(changes, 3, axis=0)) + _REST**2)
    # Use a mean of logarithms, so that one or two jumps do not hide a smooth span.
    fine = _mean_around(off, width)
    ends = ((2, 2), (0, 0))
    return (
        np.concatenate([pace[:1], pace]),
        np.pad(fine, ends, mode="edge"),
        np.pad(off, ends, mode="edge"),
    )


def _mean_around(values: Array, width: int) -> Array:
    """Return the mean of `width` rows around each row, padding both ends with the outermost row.

    Sums are computed by doubling, so small sums contain no rounding errors of large sums.
    scipy is not used, because it takes longer to load than the rest of a command.
    """
    before = width // 2
    ends = (before, width - 1 - before), *[(0, 0)] * (values.ndim - 1)
    sums, rows = np.pad(values, ends, mode="edge"), 1
    out, at, left = np.zeros_like(values), 0, width
    while left:
        if left & 1:
            out += sums[at : at + len(values)]
            at += rows
        left >>= 1
        if left:
            sums, rows = sums[:-rows] + sums[rows:], 2 * rows
    return out / width


def _squared(changes: Array) -> Array:
    """Return the squared rotation angles of quaternion differences, in degrees², (n, joints)."""
    sums: Array = np.einsum("...i,...i->...", changes, changes)
    return sums * float(np.degrees(2.0)) ** 2


def _usual(pace: Array, fine: Array) -> Array:
    """Return, for each frame, the usual fine movement in frames of at most the same pace.

    All arrays have the shape (frames, joints) and contain logarithms.
    """
    frames = len(pace)
    order = np.argsort(pace, axis=0)
    by_pace = np.take_along_axis(fine, order, axis=0)
    usual, begin = np.empty_like(fine), 0
    for end in np.linspace(_SLOWER * frames, frames, _STEPS).astype(int):
        usual[begin:end] = _quantile(by_pace[:end], _USUAL)
        begin = end
    out = np.empty_like(fine)
    np.put_along_axis(out, order, usual, axis=0)
    return out


@dataclass(frozen=True)
class _Joint:
    """The pace and the fine movement of a joint, as logarithms.

    Attributes
    ----------
    pace, fine
        The pace and the fine movement in each window, shape (windows,).
    every
        The fine movement in every frame, shape (frames,).
    step
        The number of frames from one window to the next.
    half
        Half the length of a window, in frames.
    others
        The minimum number of frames with which a span is compared.
    least
        The minimum number of frames in a span.
    """

    pace: Array
    fine: Array
    every: Array
    step: int
    half: int
    others: int
    least: int

    def confirmed(self, start: int, stop: int) -> tuple[int, int] | None:
        """Return the exact frames [start, stop) of a suspected span, or None if it is not smoothed.

        `start` and `stop` are the indices of the first suspected window and of the window after the
        last.
        """
        reach = -(-self.half // self.step)
        far = np.ones(len(self.pace), dtype=bool)
        far[max(0, start - reach) : stop + reach] = False
        others = -(-self.others // self.step)
        if far.sum() < others:
            return None
        within = self.fine[start:stop]
        level = float(_quantile(within, 0.5))
        own = float(_quantile(self.pace[start:stop][within <= level], 0.5))
        pace, fine = self.pace[far], self.fine[far]
        slower = pace <= max(own, np.partition(pace, others - 1)[others - 1])
        pace, fine = pace[slower], fine[slower]
        expected = fine - _PACE * np.maximum(0.0, pace - own)
        if float(_quantile(expected, _NEARLY_ALL)) - level < _FINER:
            return None
        border = level + min(0.5 * (float(_quantile(fine, _NEARLY_ALL)) - level), _BORDER)
        low, high = max(0, start * self.step - self.half), stop * self.step + self.half
        even = _mean_around(self.every[low:high], _EVEN) < border
        parts = runs_of_true(~_without_short(~even))
        first, last = max(parts, key=lambda r: r[1] - r[0], default=(0, 0))
        if last - first < self.least:
            return None
        return low + first, low + last


def _quantile(values: Array, share: float) -> Array:
    """Return a quantile (`share`, 0…1) along axis 0, without interpolation.

    This is faster than np.quantile.
    """
    at = round(share * (len(values) - 1))
    row: Array = np.partition(values, at, axis=0)[at]
    return row


def _without_short(mask: Mask) -> Mask:
    """Return a copy of a mask without runs of True that are shorter than _EVEN frames."""
    out = mask.copy()
    for start, stop in runs_of_true(mask):
        if stop - start < _EVEN:
            out[start:stop] = False
    return out
