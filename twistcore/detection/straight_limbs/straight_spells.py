"""Find the spells of a limb (frame ranges in which the limb is straight) and their twist errors.

P is the parent and C the child of the limb's chain, and δ is the twist error of P.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.medians import median, pad_with_edge_values, quantile
from twistcore.skeleton.rotation import Array, cross_products, rotate, vector_lengths, wrap
from twistcore.skeleton.runs import runs_of_true
from twistcore.work.frozen import dataclass

Mask = NDArray[np.bool_]

BENT = float(np.radians(30.0))  # a limb with a larger bend is bent, and shows its twist well
ANCHOR_SECONDS = 0.1  # minimum time for which a limb must be bent to show its hinge
SIDE_KNOWN = float(np.radians(0.5))  # below this bend, the side of the bend is unknown
WINDOW = 0.13  # duration in seconds of a transition, in which P and C turn in opposite directions
LEAST_TURN = float(np.radians(8.0))  # smallest turn of P and of C in a transition
LEAST_SHARE = 0.35  # minimum ratio of the smaller to the larger of these turns
EXPLAINED = 0.5  # minimum share of the smaller turn that the change of δ explains
# If a larger share of the change than SUDDEN takes at most SHARP seconds, the error is left to the
# search for jumps.
SHARP, SUDDEN = 0.015, 0.7
LEAST_CHANGE = float(np.radians(6.0))  # smallest change of δ in a transition
NOTHING = float(np.radians(0.5))  # a smaller δ is ignored
PAUSE = 0.1  # minimum time between two errors in seconds
# In a hinge, this quantile of the azimuth's magnitude in the bent limb is below HINGE.
HINGE, MOSTLY = float(np.radians(2.0)), 0.75


@dataclass(frozen=True, eq=False)
class Bend:
    """The bend of a limb in each frame.

    Attributes
    ----------
    angle
        The angle between the child's bone and the parent's bone, in [0, π], shape (frames,).
    azimuth
        The direction of the child's bone about the parent's bone, relative to its usual direction
        when the limb is bent, radians in (−π, π], shape (frames,); None if the joint is not a
        hinge.
    spread
        The 75 % quantile of the azimuth's magnitude when the limb is bent, radians.
    """

    angle: Array
    azimuth: Array | None
    spread: float = 0.0

    @cached_property
    def bent(self) -> Mask:
        """Mask of the frames in which the limb is bent, (frames,)."""
        return self.angle > BENT

    def nearer(
        self, frames: slice, offset: Array, where: Mask | None = None, share: float = 1.0
    ) -> bool | None:
        """Return True if removing an offset brings the child's bone closer to its hinge plane.

        The result is None if the hinge plane is unknown or `where` selects no frame. Frames are
        weighted by the bend of the limb. In an almost straight limb, a slight backward bend is
        natural and does not matter.

        Parameters
        ----------
        frames
            The frames of the offset, as a slice.
        offset
            The offset in each of these frames, radians.
        where
            Mask of the frames to use, or None for all.
        share
            The largest accepted ratio of the distance after the correction to the distance before.
        """
        if self.azimuth is None or (where is not None and not where.any()):
            return None
        off, weight = self.azimuth[frames], np.sin(self.angle[frames]) ** 2
        weight[self.angle[frames] < SIDE_KNOWN] = 0.0
        back = off + offset
        off, back = (np.where(self.bent[frames], wrap(v), 0.5 * wrap(2.0 * v)) for v in (off, back))
        if where is not None:
            weight = weight * where
        return bool(np.abs(back) @ weight < share * np.abs(off) @ weight)


@dataclass(frozen=True)
class Spell:
    """Frames [start, stop) in which a limb is straight, in a segment [low, high) between cuts."""

    start: int
    stop: int
    low: int
    high: int

    @property
    def closed(self) -> int:
        """The number of sides of the spell (0, 1 or 2) on which the limb is bent."""
        return int(self.start > self.low) + int(self.stop < self.high)

    def windows(self, window: int) -> slice:
        """Return the positions of all windows of `window` frames that overlap the spell.

        The position of a window is the index of the frame before the window.
        """
        first, last = max(self.start - window, self.low), min(self.stop, self.high - window)
        return slice(first, max(first, last))


@dataclass(frozen=True, eq=False)
class StraightError:
    """A twist error δ of a straight limb, which begins in frame `start`.

    Attributes
    ----------
    offset
        δ in each frame, radians.
    peak
        The middle frame of the clearest transition.
    turns
        The rotations of parent and child in that transition, radians.
    strength
        The magnitude of the change of δ in that transition, radians.
    closed
        The number of sides of the spell on which the limb is bent.
    """

    start: int
    offset: Array
    peak: int
    turns: tuple[float, float]
    strength: float
    closed: int

    @property
    def stop(self) -> int:
        """The frame after the error's last frame."""
        return self.start + len(self.offset)


def limb_bend_per_frame(q_child: Array, axis: Array, arm: Array, fps: float) -> Bend:
    """Return the bend of a limb in each frame.

    `q_child` contains the local rotations of the child, (frames, 4). `axis` and `arm` are unit
    vectors along the parent's bone and the child's bone, (3,) or (frames, 3).
    """
    v = rotate(q_child, arm)
    axis = np.broadcast_to(axis, v.shape)
    along = np.einsum("fi,fi->f", v, axis)
    across = v - along[:, None] * axis
    angle = np.arctan2(vector_lengths(across), along)
    bent = angle > BENT
    if bent.sum() < max(2, ANCHOR_SECONDS * fps):
        return Bend(angle, None)
    sideways = cross_products(axis[0], np.eye(3)[int(np.argmin(np.abs(axis[0])))])
    first = sideways - (axis @ sideways)[:, None] * axis
    x, y = (np.einsum("fi,fi->f", across, e) for e in (first, cross_products(axis, first)))
    azimuth = np.arctan2(y, x)
    mean = np.angle(np.exp(1j * azimuth[bent]).sum())
    azimuth = wrap(azimuth - mean - median(wrap(azimuth[bent] - mean)))
    spread = quantile(np.abs(azimuth[bent]), MOSTLY)
    return Bend(angle, azimuth if spread < HINGE else None, spread)


def find_straight_ranges(
    increments: tuple[Array, Array], bend: Bend, low: int, high: int, fps: float
) -> list[Spell]:
    """Return the straight frame ranges (spells) of a segment [low, high) that may have an error.

    In these spells, parent and child rotate in opposite directions. The limb must be bent before or
    after the spell. `increments` contains the twist increments of parent and child in radians.
    """
    out = []
    for start, stop in runs_of_true(~bend.bent[low:high]):
        spell = Spell(start + low, stop + low, low, high)
        if spell.closed and _mirrored(*_turns(increments, spell, fps)).any():
            out.append(spell)
    return out


def find_straight_limb_twist_errors(
    increments: tuple[Array, Array], delta: Array, spell: Spell, fps: float
) -> list[StraightError]:
    """Return the errors in a spell: runs of δ that begin or end with opposite joint rotations.

    `increments` contains the twist increments of parent and child. `delta` contains the twist error
    δ in all frames, which is 0 outside the spell. Both arrays are in radians.
    """
    window = twist_transition_window_frames(fps)
    first = spell.windows(window).start
    turn, answer = _turns(increments, spell, fps)
    change = (delta[window:] - delta[:-window])[spell.windows(window)]
    # δ must explain the transition. If not, the opposite turns are natural motion near an error.
    least = np.maximum(EXPLAINED * np.minimum(np.abs(turn), np.abs(answer)), LEAST_CHANGE)
    clear = np.where(_mirrored(turn, answer) & (change * np.sign(turn) >= least), change, 0.0)
    short = round(SHARP * fps)  # 0 at 30 Hz, where even a gradual transition may take one frame
    jumps = np.abs(delta[short:] - delta[: len(delta) - short])
    found = []
    for start, stop in _joined_runs(np.abs(delta) > NOTHING, fps):
        near = np.abs(clear[max(start - window - first, 0) : max(stop - first, 0)])
        if not near.any():
            continue
        k = int(near.argmax()) + max(start - window - first, 0)
        if jumps[first + k : first + k + window - short + 1].max() > SUDDEN * abs(clear[k]):
            continue
        error = StraightError(
            start=start,
            offset=delta[start:stop],
            peak=first + k + 1 + window // 2,
            turns=(float(turn[k]), float(answer[k])),
            strength=float(abs(clear[k])),
            closed=spell.closed,
        )
        found.append(error)
    return found


def unexplained_opposite_rotation(
    increments: tuple[Array, Array],
    scales: tuple[float, float],
    delta: Array,
    spell: Spell,
    fps: float,
) -> float:
    """Return the opposite rotation of parent and child that remains without δ, in radians.

    The result is the maximum over the windows of the spell. The pace (mean rotation per frame) next
    to each window is subtracted, and the joint with the smaller scale has the greater weight.

    Parameters
    ----------
    increments
        The twist increments of parent and child, radians.
    scales
        The scales of both increments, from :func:`twist_increment_change_scale`.
    delta
        The twist error δ in all frames, radians, shape (frames,).
    spell
        The spell.
    fps
        The frame rate.
    """
    steps = np.diff(delta, prepend=delta[:1])
    x, y = increments
    x_counts, y_counts = (scale**-2.0 for scale in scales)
    turn = _over_windows(wrap(x - steps), spell, fps)[1]
    answer = _over_windows(wrap(y + steps), spell, fps)[1]
    both = (turn * x_counts - answer * y_counts) / (x_counts + y_counts)
    return float(np.abs(both).max(initial=0.0))


def twist_transition_window_frames(fps: float) -> int:
    """Return the length, in frames, of the window in which a transition is searched for."""
    return max(2, round(WINDOW * fps))


def _joined_runs(there: Mask, fps: float) -> list[tuple[int, int]]:
    """Return the runs of True in a mask, after joining runs separated by a short gap."""
    out: list[tuple[int, int]] = []
    for start, stop in runs_of_true(there):
        if out and start - out[-1][1] < PAUSE * fps:
            start = out.pop()[0]
        out.append((start, stop))
    return out


def _turns(increments: tuple[Array, Array], spell: Spell, fps: float) -> tuple[Array, Array]:
    """Return the rotations of parent and child over the windows of a spell, in radians.

    The pace (mean rotation per frame) next to a window is subtracted only if the rotations are not
    clearly opposite without this.
    """
    (x, beyond_x), (y, beyond_y) = (_over_windows(v, spell, fps) for v in increments)
    beyond = (_counter(beyond_x, beyond_y) > _counter(x, y)) & ~_mirrored(x, y)
    return np.where(beyond, beyond_x, x), np.where(beyond, beyond_y, y)


def _over_windows(signal: Array, spell: Spell, fps: float) -> tuple[Array, Array]:
    """Return the sums of a signal over the windows of a spell, and these sums minus the pace.

    The pace is the mean of the signal next to a window. Only values in the segment that contains
    the spell are used, and the outermost values are repeated beyond the segment.
    """
    window = twist_transition_window_frames(fps)
    half = window // 2
    at = spell.windows(window)
    # The range of the increments that are needed.
    first, last = at.start + 1 - half, at.stop + window + half
    low, high = max(first, spell.low + 1), min(last, spell.high)
    asked = pad_with_edge_values(signal[low:high], low - first, last - high)
    total = np.concatenate([[0.0], asked.cumsum()])
    begin = half + window, half, 2 * half + window, 0
    after, before, end, start = (total[k : k + at.stop - at.start] for k in begin)
    inside = after - before
    around = end - start - inside
    return inside, inside - around * (window / (2 * half))


def _counter(turn: Array, answer: Array) -> Array:
    """Return the smaller magnitude of two opposite rotations, or 0 if they are not opposite."""
    return np.where(turn * answer < 0.0, np.minimum(np.abs(turn), np.abs(answer)), 0.0)


def _mirrored(turn: Array, answer: Array) -> Mask:
    """Return True where two joints rotate in opposite directions by similar angles."""
    large = np.maximum(np.abs(turn), np.abs(answer))
    return _counter(turn, answer) >= np.maximum(LEAST_TURN, LEAST_SHARE * large)
