"""Explain the jumps of a limb by runs of frames in which the limb is flipped, at the lowest cost.

A jump is a sudden rotation of the limb about the line from its first joint to its end. Each sharp
jump is an edge of a run, or is inside a run and changes its offset, or remains unexplained at a
cost. The cost of a run grows with its length and with the angle that remains after its edges. The
cost is lower if the distribution of the swivel angle in the clip indicates that the limb belongs on
the other side. Costs are log odds, so a difference between costs shows how certain an explanation
is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from twistcore.detection.limb_flips.jumps import Jump
from twistcore.detection.prediction import Mask
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

RUN = 1.0  # cost of every run
FOLLOWED = 2.5  # cost of a jump inside a run; a second run is cheaper
SECOND = 4.0  # cost of each second of a run
CLOSING = 1.0 / math.radians(80.0)  # cost of each radian that remains after the edges of a run
NEVER_CLOSED = math.radians(110.0)  # maximum angle that may remain after a run
# Additional cost of a run after which at least the angle CLOSED remains. This angle is larger than
# rounding and motion explain.
UNCLOSED, CLOSED = 0.6, math.radians(15.0)
SOFT = 0.8  # cost of an edge that takes several frames
LEFT = 6.0  # cost of a sharp jump of at least FULL_TURN that remains unexplained
FULL_TURN = math.radians(120.0)
# A jump of at most NATURAL times the limb's scale may remain unexplained at no cost, and one of at
# least UNNATURAL times the scale costs the full price.
NATURAL, UNNATURAL = 4.0, 8.0
# The cost is lower if the limb's end moves by more than STEP of the limb's length; UNSTILL is the
# smallest factor.
STEP, UNSTILL = 0.06, 0.4
LONGEST, LONGEST_SOFT = 3.0, 0.25  # maximum duration of a run, and of one with a soft edge, seconds
MOST_SIDE = 6.0  # maximum evidence about the side from all frames of a run
MOST_FOLLOWED = 4  # maximum number of jumps inside a run
OBSERVATION = 0.08  # seconds; the frames in this time count as one observation
FULL_HEIGHT = 0.1  # share of the limb's length; a middle joint nearer to the line has less weight
ROUNDS = 3  # rounds of finding runs and estimating the usual side without them
_BINS, _BLUR = 72, 25.0  # number of bins of the density of the swivel; its smoothing in degrees
_BLOCK = 1000  # number of runs for which the evidence is computed together
_ANYWHERE = 0.1  # share of a uniform density in the density


@dataclass(frozen=True, eq=False)
class Run:
    """Successive frames in which a limb is flipped.

    Attributes
    ----------
    start
        The first frame.
    offset
        The angle of the flip in each frame, radians, shape (frames,).
    first, last
        The sudden rotations at the edges of the run.
    followed
        The jumps inside the run, which the offset follows.
    residual
        The wrapped sum of all these jumps, radians; 0 if the limb returns exactly.
    side
        The evidence that the limb belongs on the other side, as log odds.
    odds
        The additional cost of the cheapest explanation without this run, as log odds.
    """

    start: int
    offset: Array
    first: Jump
    last: Jump
    followed: tuple[Jump, ...]
    residual: float
    side: float
    odds: float

    @property
    def stop(self) -> int:
        """The frame after the run's last frame."""
        return self.start + len(self.offset)


Density = Callable[[Array], Array]  # function that returns the log density at angles in radians


@dataclass(frozen=True, eq=False)
class _Arc:
    """A step of an explanation, which explains the jumps with indices [source, target).

    `run` is a flip that explains these jumps, or None if the step leaves a jump unexplained.
    """

    source: int
    target: int
    cost: float
    run: Run | None = None


def explain_limb_jumps(
    jumps: Sequence[Jump], angle: Array, height: Array, capture: Mask, fps: float
) -> list[Run]:
    """Return the runs of flipped frames that explain the jumps of a limb best, sorted by start.

    Parameters
    ----------
    jumps
        All jumps of the limb, sorted by start.
    angle, height
        The attributes of the limb's :class:`Swivel`, shape (frames,).
    capture
        Mask of the frames from which the usual side of the limb is estimated, shape (frames,).
    fps
        The frame rate.
    """
    if not any(j.leads for j in jumps):
        return []
    runs: list[Run] = []
    possible = _possible_runs(jumps, fps)
    for _ in range(ROUNDS):
        arcs = _ways(jumps, possible, angle, height, capture, fps, runs)
        runs = _cheapest(arcs, len(jumps))
    return runs


@dataclass(frozen=True, eq=False)
class Unexplained:
    """The costs that show why a jump is left unexplained.

    Attributes
    ----------
    cost
        The cost of leaving the jump unexplained.
    run
        The best run with the jump as an edge, or None if there is no such run.
    price
        The cost of that run.
    spared
        The cost of leaving all jumps of that run unexplained.
    """

    cost: float
    run: Run | None = None
    price: float = math.inf
    spared: float = 0.0


def why_unexplained(
    jumps: Sequence[Jump],
    jump: Jump,
    runs: Sequence[Run],
    angle: Array,
    height: Array,
    capture: Mask,
    fps: float,
) -> Unexplained:
    """Return the costs that show why :func:`explain_limb_jumps` left a jump unexplained.

    `jump` is the jump and `runs` is the result of :func:`explain_limb_jumps`. The other parameters
    have the same meaning as in :func:`explain_limb_jumps`.
    """
    best = Unexplained(_price_left(jump))
    possible = _possible_runs(jumps, fps)
    for arc in _ways(jumps, possible, angle, height, capture, fps, runs):
        if (run := arc.run) is not None and (run.first is jump or run.last is jump):
            spared = sum(map(_price_left, (run.first, *run.followed, run.last)))
            if arc.cost - spared < best.price - best.spared:
                best = Unexplained(best.cost, run, arc.cost, spared)
    return best


def _ways(
    jumps: Sequence[Jump],
    possible: Sequence[_Arc],
    angle: Array,
    height: Array,
    capture: Mask,
    fps: float,
    runs: Sequence[Run],
) -> list[_Arc]:
    """Return all possible steps of an explanation: flips, and jumps that are left unexplained.

    The usual side of the limb is estimated from the frames outside the flips in `runs`.
    """
    own = capture.copy()
    for run in runs:
        own[run.start : run.stop] = False
    weight = np.minimum(height / FULL_HEIGHT, 1.0)
    log = _log_density(angle[own], weight[own])
    out = [_Arc(k, k + 1, _price_left(jump)) for k, jump in enumerate(jumps)]
    out += _with_sides(possible, angle, weight / (OBSERVATION * fps), log)
    return sorted(out, key=lambda arc: arc.target)


def _log_density(angle: Array, weight: Array) -> Density:
    """Return a function that computes the log density of a limb's swivel angle.

    `angle` contains the observed angles in radians, and `weight` their weights, both (n,).
    """
    count, _ = np.histogram(angle, _BINS, (-np.pi, np.pi), weights=weight)
    apart = 360.0 / _BINS * ((np.arange(_BINS) + _BINS // 2) % _BINS - _BINS // 2)
    blur = np.exp(-0.5 * (apart / _BLUR) ** 2)
    smooth = np.fft.irfft(np.fft.rfft(count) * np.fft.rfft(blur), _BINS).clip(0.0)
    share = smooth / smooth.sum() if smooth.sum() > 0.0 else np.full(_BINS, 1.0 / _BINS)
    log = np.log((1.0 - _ANYWHERE) * share + _ANYWHERE / _BINS)

    def of(angles: Array) -> Array:
        at = ((wrap(angles) + np.pi) / (2.0 * np.pi) * _BINS).astype(np.int64)
        found: Array = log[np.clip(at, 0, _BINS - 1)]
        return found

    return of


def _possible_runs(jumps: Sequence[Jump], fps: float) -> list[_Arc]:
    """Return all possible flips as steps of an explanation, sorted by target.

    The costs of the steps do not include the evidence about the side of the limb.
    """
    out = []
    for k, last in enumerate(jumps):
        followed: list[Jump] = []
        for i in range(k - 1, -1, -1):
            first = jumps[i]
            if last.start - first.stop > LONGEST * fps or len(followed) > MOST_FOLLOWED:
                break
            if _may_be_edges(first, last, followed, fps):
                start, offset, residual = _between(first, last, followed)
                if abs(residual) < NEVER_CLOSED:
                    inside = tuple(followed[::-1])
                    run = Run(start, offset, first, last, inside, residual, 0.0, 0.0)
                    out.append(_Arc(i, k + 1, _price(run, fps), run))
            if first.leads:
                followed.append(first)
    return out


def _with_sides(possible: Sequence[_Arc], angle: Array, weight: Array, log: Density) -> list[_Arc]:
    """Add to each step the evidence that the limb belongs on the other side, and return the steps.

    The evidence lowers the cost of a step. `weight` contains the weight of each frame in the
    evidence, and `log` is a function that computes the log density of the swivel angle.
    """
    out, as_is = [], log(angle)
    for first in range(0, len(possible), _BLOCK):  # a jittery clip has very many possible runs
        arcs = possible[first : first + _BLOCK]
        runs = [arc.run for arc in arcs if arc.run is not None]
        frames = np.concatenate([np.arange(run.start, run.stop) for run in runs])
        offset = np.concatenate([run.offset for run in runs])
        gain = (log(angle[frames] - offset) - as_is[frames]) * weight[frames]
        firsts = np.cumsum([0, *(len(run.offset) for run in runs[:-1])])
        sides = np.minimum(np.add.reduceat(gain, firsts), MOST_SIDE).tolist()
        out += [
            replace(arc, cost=arc.cost - side, run=replace(run, side=side))
            for arc, run, side in zip(arcs, runs, sides, strict=True)
        ]
    return out


def _may_be_edges(first: Jump, last: Jump, inside: Sequence[Jump], fps: float) -> bool:
    """Return True if two jumps can be the edges of a flip that contains the jumps `inside`."""
    between = last.start - first.stop
    if not (first.leads or last.leads) or between < 0:
        return False
    if not (first.sharp and last.sharp) and between > LONGEST_SOFT * fps:
        return False
    return all(first.stop <= j.start and j.stop <= last.start for j in inside)


def _price(run: Run, fps: float) -> float:
    """Return the cost of explaining jumps by a run of flipped frames.

    The cost does not include the evidence about the side of the limb.
    """
    open_by = abs(run.residual)
    return (
        RUN
        + FOLLOWED * len(run.followed)
        + SECOND * len(run.offset) / fps
        + CLOSING * open_by
        + UNCLOSED * min(1.0, open_by / CLOSED)
        + SOFT * ((not run.first.sharp) + (not run.last.sharp))
    )


def _price_left(jump: Jump) -> float:
    if not jump.leads:
        return 0.0
    large = min(1.0, abs(jump.turn) / FULL_TURN)
    strange = (abs(jump.turn) / jump.scale - NATURAL) / (UNNATURAL - NATURAL)
    still = 2.0 - jump.step / STEP
    return LEFT * large * float(np.clip(strange, 0.0, 1.0) * np.clip(still, UNSTILL, 1.0))


def _between(first: Jump, last: Jump, followed: Sequence[Jump]) -> tuple[int, Array, float]:
    """Return the first frame, the offset and the residual of a flip between two jumps.

    The offset changes by each jump in `followed`. The residual, the angle that remains after the
    flip, is distributed evenly over the frames.
    """
    turns = np.zeros(last.stop - first.start)
    for jump in (first, last, *followed):
        turns[jump.start - first.start : jump.stop - first.start] = jump.turns
    level = np.cumsum(turns)
    residual = float(wrap(level[-1]))
    frames = len(level) - 1  # there is no error after the last turn
    share = np.arange(1, frames + 1) / (frames + 1)
    return first.start, level[:-1] - residual * share, residual


def _cheapest(arcs: Sequence[_Arc], jumps: int) -> list[Run]:
    """Return the flips in the cheapest explanation of all jumps, with their log odds."""
    cost, best = _costs(arcs, jumps)
    runs = []
    node = jumps
    while node:
        arc = best[node]
        assert arc is not None
        node = arc.source
        if (run := arc.run) is not None:
            others, _ = _costs([a for a in arcs if not _alike(a.run, run)], jumps)
            runs.append(replace(run, odds=others - cost))
    return runs[::-1]


def _alike(one: Run | None, other: Run) -> bool:
    """Return True if two runs share at least half of their frames, so they describe one error."""
    if one is None:
        return False
    shared = min(one.stop, other.stop) - max(one.start, other.start)
    return shared >= 0.5 * (max(one.stop, other.stop) - min(one.start, other.start))


def _costs(arcs: Sequence[_Arc], jumps: int) -> tuple[float, list[_Arc | None]]:
    """Return the lowest cost of explaining all jumps, and the best step into each node.

    Node k is the state after the first k jumps have been explained.
    """
    cost = [0.0] + [math.inf] * jumps
    best: list[_Arc | None] = [None] * (jumps + 1)
    for arc in arcs:  # sorted by target
        if (total := cost[arc.source] + arc.cost) < cost[arc.target]:
            cost[arc.target], best[arc.target] = total, arc
    return cost[jumps], best
