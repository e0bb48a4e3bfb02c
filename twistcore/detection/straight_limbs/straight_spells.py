"""Spells in which a limb is straight, and the errors that stand in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.rotation import Array, rotate, wrap

Mask = NDArray[np.bool_]

BENT = float(np.radians(30.0))  # of bend: from here on a limb's twist is well determined
ANCHOR_SECONDS = 0.1  # that a clip's limb must be bent for to tell anything of the straight one
WINDOW = 0.13  # seconds of a mirrored transition
LEAST_TURN = float(np.radians(8.0))  # of either joint in it
LEAST_SHARE = 0.35  # of the smaller turn in the larger
EXPLAINED = 0.5  # of the smaller turn, by what δ changes
NOTHING = float(np.radians(0.5))  # δ below is none
PAUSE = 0.1  # seconds of it that part two errors
HINGE = float(np.radians(5.0))  # spread of a hinge's direction in the bent limb, at most


@dataclass(frozen=True, eq=False)
class Bend:
    """How a limb is bent: angle of C's bone off P's, [0, π], and its azimuth, both (frames,).

    azimuth: off the direction in which the bent limb leaves P's bone, radians in (−π, π], or None
    where that is no hinge's.
    """

    angle: Array
    azimuth: Array | None

    @property
    def bent(self) -> Mask:
        """Frames whose twist is well determined."""
        return self.angle > BENT


@dataclass(frozen=True)
class Spell:
    """Frames [start, stop) in which a limb is not bent, of the segment [low, high) between cuts."""

    start: int
    stop: int
    low: int
    high: int

    @property
    def closed(self) -> int:
        """At how many ends the limb is bent."""
        return int(self.start > self.low) + int(self.stop < self.high)

    def windows(self, window: int) -> slice:
        """The windows over its frames and those beside them, by the frame before each."""
        first, last = max(self.start - window, self.low), min(self.stop, self.high - window)
        return slice(first, max(first, last))


@dataclass(frozen=True, eq=False)
class StraightError:
    """An error of a straight limb from frame `start` on: δ a frame, radians.

    peak: the frame in which its clearest transition is halfway; turns: of P and C over it, radians;
    strength: of what δ changes by there, radians ≥ 0; closed: at how many ends the limb is bent.
    """

    start: int
    offset: Array
    peak: int
    turns: tuple[float, float]
    strength: float
    closed: int

    @property
    def stop(self) -> int:
        """Behind its last frame."""
        return self.start + len(self.offset)


def bend_of(q_child: Array, axis: Array, arm: Array, fps: float) -> Bend:
    """Bend of a limb; q_child: (frames, 4); axis, arm: unit, (3,) or (frames, 3)."""
    v = rotate(q_child, arm)
    axis = np.broadcast_to(axis, v.shape)
    along = np.einsum("fi,fi->f", v, axis)
    across = v - along[:, None] * axis
    angle = np.arctan2(np.linalg.norm(across, axis=1), along)
    bent = angle > BENT
    if bent.sum() < max(2, ANCHOR_SECONDS * fps):
        return Bend(angle, None)
    beside = np.cross(axis[0], np.eye(3)[int(np.argmin(np.abs(axis[0])))])
    first = beside - (axis @ beside)[:, None] * axis
    x, y = (np.einsum("fi,fi->f", across, e) for e in (first, np.cross(axis, first)))
    azimuth = np.arctan2(y, x)
    mean = np.angle(np.exp(1j * azimuth[bent]).sum())
    azimuth = wrap(azimuth - mean - np.median(wrap(azimuth[bent] - mean)))
    return Bend(angle, azimuth if np.median(np.abs(azimuth[bent])) < HINGE else None)


def may_err(increments: tuple[Array, Array], bend: Bend, fps: float) -> bool:
    """Whether P and C turn against each other anywhere beside or in a straight spell."""
    hits = _mirrored(*(_over_window(v, fps) for v in increments))
    low = np.minimum(bend.angle[: len(hits)], bend.angle[len(bend.angle) - len(hits) :])
    return bool((hits & (low < BENT)).any()) and bool(bend.bent.any())


def spells(
    increments: tuple[Array, Array], bend: Bend, low: int, high: int, fps: float
) -> list[Spell]:
    """Straight spells of the segment [low, high) beside a bent limb in which P and C counter-turn."""
    window = window_of(fps)
    hits = _mirrored(*(_over_window(v, fps) for v in increments))
    hits[:low] = hits[max(high - window, 0) :] = False
    out = []
    for start, stop in runs(~bend.bent[low:high]):
        spell = Spell(start + low, stop + low, low, high)
        if spell.closed and hits[spell.windows(window)].any():
            out.append(spell)
    return out


def errors_in(
    increments: tuple[Array, Array], delta: Array, spell: Spell, fps: float
) -> list[StraightError]:
    """The runs of δ in a spell that set in or end with a transition in which both joints turn.

    delta: radians, of the spell's frames.
    """
    window = window_of(fps)
    x, y = (_over_window(v, fps) for v in increments)
    hits = _mirrored(x, y)
    hits[: spell.low] = hits[max(spell.high - window, 0) :] = False
    change = np.zeros(len(hits) + window)
    change[spell.start : spell.stop] = delta
    change = change[window:] - change[:-window]
    # The transition must be what δ explains, not motion beside it.
    hits &= change * np.sign(x) >= EXPLAINED * np.minimum(np.abs(x), np.abs(y))
    clear = np.where(hits, np.abs(change), 0.0)
    found = []
    for a, b in _parts(np.abs(delta) > NOTHING, fps):
        first = max(spell.start + a - window, 0)
        own = clear[first : spell.start + b]
        if not own.any():
            continue
        k = int(own.argmax()) + first
        error = StraightError(
            start=spell.start + a,
            offset=delta[a:b],
            peak=k + 1 + window // 2,
            turns=(float(x[k]), float(y[k])),
            strength=float(clear[k]),
            closed=spell.closed,
        )
        found.append(error)
    return found


def left_over(increments: tuple[Array, Array], delta: Array, spell: Spell, fps: float) -> float:
    """The most by which P and C still counter-turn within the window without δ, radians.

    delta: of all frames, (frames,).
    """
    steps = np.diff(delta, prepend=delta[:1])
    own = spell.windows(window_of(fps))
    x, y = increments
    turn = _over_window(wrap(x - steps), fps)[own]
    answer = _over_window(wrap(y + steps), fps)[own]
    both = np.minimum(np.abs(turn), np.abs(answer))
    return float(np.max(both, where=turn * answer < 0.0, initial=0.0))


def window_of(fps: float) -> int:
    """Frames of a mirrored transition."""
    return max(2, round(WINDOW * fps))


def runs(mask: Mask) -> list[tuple[int, int]]:
    """Runs of True as [start, stop)."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return list(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True))


def _parts(there: Mask, fps: float) -> list[tuple[int, int]]:
    """Runs of True, those that a short pause parts as one."""
    out: list[tuple[int, int]] = []
    for start, stop in runs(there):
        if out and start - out[-1][1] < PAUSE * fps:
            start = out.pop()[0]
        out.append((start, stop))
    return out


def _over_window(increments: Array, fps: float) -> Array:
    """Sums over the window behind every frame, which is not part of it; (frames − window,)."""
    window = window_of(fps)
    if len(increments) <= window:
        return np.zeros(0)
    total = np.concatenate([[0.0], np.cumsum(increments)])
    return np.asarray(total[window + 1 :] - total[1:-window])


def _mirrored(turn: Array, answer: Array) -> Mask:
    """Where both turn, against each other, and by about as much."""
    sizes = np.abs(turn), np.abs(answer)
    small, large = np.minimum(*sizes), np.maximum(*sizes)
    return (turn * answer < 0.0) & (small >= LEAST_TURN) & (small >= LEAST_SHARE * large)
