"""Spells in which a limb is straight, and the errors that stand in them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.straight_limbs.straight_course import course
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


def errors_in(
    increments: tuple[Array, Array], bend: Bend, low: int, high: int, fps: float
) -> list[StraightError]:
    """Errors of the limb's straight spells within the segment [low, high), by start.

    increments: x and y without the errors that are known. Only spells beside a bent limb tell; and
    an error must set in or end with a transition in which both joints turn.
    """
    window = window_of(fps)
    x, y = (_over_window(v, fps) for v in increments)
    hits = _mirrored(x, y)
    hits[:low] = hits[max(high - window, 0) :] = False
    found = []
    for start, stop in runs(~bend.bent[low:high]):
        start, stop = start + low, stop + low
        if (start == low and stop == high) or not hits[max(start - window, 0) : stop].any():
            continue
        delta = course(increments, start, stop, low, high, fps)
        change = np.zeros(len(hits) + window)
        change[start:stop] = delta
        change = change[window:] - change[:-window]
        for a, b in _parts(np.abs(delta) > NOTHING, fps):
            own = slice(max(start + a - window, 0), start + b)
            # The transition must be what δ explains, not motion beside it.
            least = EXPLAINED * np.minimum(np.abs(x[own]), np.abs(y[own]))
            clear = np.where(hits[own], np.abs(change[own]), 0.0)
            clear[(change[own] * np.sign(x[own]) < least)] = 0.0
            if not clear.any():
                continue
            k = int(clear.argmax()) + own.start
            closed = int(start > low) + int(stop < high)
            error = StraightError(
                start=start + a,
                offset=delta[a:b],
                peak=k + 1 + window // 2,
                turns=(float(x[k]), float(y[k])),
                strength=float(abs(change[k])),
                closed=closed,
            )
            found.append(error)
    return found


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
