"""Compute the evidence for and against a correction as terms, relative to the rest of the clip.

All angles are in degrees. P is the parent and C the child of a chain. A term in nats is the cost of
a rotation as natural motion minus its cost as the error. The scale of a cost is the usual rotation
of the same signal over as many frames elsewhere in the clip.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.evidence.chain_signals import (
    ALONG,
    PACE,
    ChainSignals,
    Mask,
    evict_oldest_cache_entries,
)
from twistcore.detection.interval import Interval
from twistcore.detection.robust_cost import residual_cost
from twistcore.skeleton.angles import wrap_degrees
from twistcore.skeleton.medians import median, quantile
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

BENT = 0.117  # sin² of a bend of 20°, the smallest bend with a reliable azimuth at an edge
_LEAST = 0.3  # degrees; an edge with a smaller rotation is not evidence
_REACHED = 0.8  # share of the largest offset at which an edge ends
# Uncertainty of a bone's direction in degrees. The uncertainty of the azimuth is this divided by
# the sine of the bend.
_BONE = 2.5
_ELSEWHERE = 1.0  # minimum time without errors that shows the natural motion, in seconds
_BESIDE = 0.1  # time on either side of an edge that is near it, in seconds
_NOISE = 3  # frames next to an error in which a burst of noise is evidence against it
# A hinge is exact, built into the rig, if the bone leaves it by less than this number of degrees;
# the second value is the minimum number of frames that show this.
_EXACT, _ENOUGH = 0.5, 20
_STRAIGHT = np.sin(np.radians(3.0))  # in a straighter limb, even an exact hinge is not evidence
_NEAR = 0.6  # time on either side of an edge in which rotations have more weight, in seconds


@dataclass(frozen=True, eq=False)
class SuspectedError:
    """A possible error of a chain in frames [start, stop).

    Attributes
    ----------
    start, stop
        The first frame and the frame after the last.
    offset
        The wrong angle of P in each frame, degrees.
    silent
        True if the error appears at a joint that never twists elsewhere in the clip.
    """

    start: int
    stop: int
    offset: Array
    silent: bool = False

    @classmethod
    def of(cls, interval: Interval) -> SuspectedError:
        """Return the possible error that an interval describes."""
        silent = bool((interval.evidence or {}).get("silent_joint"))
        return cls(interval.start, interval.stop, np.degrees(interval.offset), silent)


@dataclass(frozen=True)
class Edge:
    """Frames [start, stop) in which the offset rises or falls by `turn` degrees."""

    start: int
    stop: int
    turn: float

    @property
    def width(self) -> int:
        """The number of frames of the edge."""
        return self.stop - self.start


@dataclass(frozen=True)
class Terms:
    """The evidence about one error. Angles are in degrees.

    Attributes
    ----------
    hinged
        True if the azimuth of C's bone is known.
    for_x, for_y, for_azimuth
        The evidence that P, C and the azimuth change with the error at the edges, nats.
    rougher
        The increase in the roughness of the azimuth that the correction causes, nats.
    edge_bend
        sin² of the bend, at the edge at which the limb is bent more.
    off_before, off_after
        The angle of C's bone from its usual side before and after the correction, NaN if unknown.
    side_spread
        The 95 % quantile of the angle from this side in the rest of the clip, NaN if unknown.
    for_side
        The evidence that the correction brings C's bone closer to this side, nats.
    least_bend
        The smallest bend in the frames of the error.
    together
        The combined rotation of P and C at an edge, divided by the change of the offset. The larger
        value of the two edges.
    rate
        The number of similar opposite rotations of P and C per second elsewhere in the clip, None
        if there is too little motion without errors.
    natural
        The 99 % quantile of such rotations elsewhere, None if there is too little such motion.
    step
        The magnitude of the change of the offset at an edge, the median of both edges.
    seconds
        The duration of the error.
    quiet
        The usual rotation of P or C over as many frames as an edge has, whichever is smaller. NaN
        if unknown.
    silent
        True if the error appears at a joint that never twists elsewhere.
    noise
        σ of a burst of noise during the error or next to it, 0 if there is none.
    """

    hinged: bool
    for_x: float
    for_y: float
    for_azimuth: float
    rougher: float
    edge_bend: float
    off_before: float
    off_after: float
    side_spread: float
    for_side: float
    least_bend: float
    together: float
    rate: float | None
    natural: float | None
    step: float
    seconds: float
    quiet: float
    silent: bool
    noise: float


def measure_evidence(background: Background, error: SuspectedError) -> Terms:
    """Return the evidence about an error of a chain, compared with the rest of its motion."""
    return _Measured(background.without(error), error).terms()


@dataclass(frozen=True, eq=False)
class Background:
    """The motion of a chain outside its errors, with which each error is compared.

    `chain` contains the signals of the chain, and `taken` is the mask of the frames of its errors,
    (frames,).
    """

    chain: ChainSignals
    taken: Mask
    _known: dict[tuple[str, int], _Usual] = field(default_factory=dict)  # the latest few
    _against: dict[int, _Against] = field(default_factory=dict)  # the latest few

    @classmethod
    def of(cls, chain: ChainSignals, errors: Iterable[SuspectedError]) -> Background:
        """Return the background of a chain, given the signals and all errors of the chain."""
        return cls(chain, error_frames_mask(chain.frames, errors))

    def without(self, error: SuspectedError) -> Background:
        """Return the background without the frames of an additional error."""
        if self.taken[error.start : error.stop].all():
            return self
        return Background(self.chain, self.taken | error_frames_mask(self.chain.frames, [error]))

    @cached_property
    def busy(self) -> Mask:
        """Mask of the frames in errors or next to them, which do not show natural motion."""
        busy = self.taken.copy()
        busy[:-1] |= self.taken[1:]
        busy[1:] |= self.taken[:-1]
        return busy

    @cached_property
    def _busy_before(self) -> NDArray[np.int32]:
        """The number of frames of :attr:`busy` before each frame, (frames + 1,)."""
        return np.concatenate([[0], np.cumsum(self.busy, dtype=np.int32)]).astype(np.int32)

    @cached_property
    def side(self) -> Side | None:
        """The side to which the child's bone usually bends, or None if it is unknown."""
        return usual_bend_side(self.chain, self.busy)

    @cached_property
    def spread(self) -> float:
        """The usual angle between the child's bone and its usual side, in degrees.

        NaN if the usual side is unknown.
        """
        if self.side is None:
            return math.nan
        there = ~self.busy & (self.chain.sine > (_STRAIGHT if self.side.exact else ALONG))
        roots, weight = np.sqrt(np.abs(self.side.off[there])), self.chain.sine[there] ** 2
        return 1.48 * float(np.average(roots, weights=weight)) ** 2

    @cached_property
    def known_azimuth(self) -> Mask:
        """Mask of the frames in which the change of the azimuth's pace is known, (frames,).

        The change is computed from three frames.
        """
        both = self.chain.both_frames
        return np.asarray(np.minimum(both, np.append(both[1:], 0.0)) > ALONG)

    @cached_property
    def roughness(self) -> float:
        """The usual change of the azimuth's pace from frame to frame, in degrees."""
        known = self.known_azimuth
        rough = np.zeros(self.chain.frames)
        rough[1:-1] = wrap_degrees(np.diff(self.chain.azimuth_turns[1:]))
        free = known & ~self.busy
        usual = rough[free] if free.sum() > 10 else rough[known]
        return robust_scale(usual, 0.02) if len(usual) > 10 else 5.0

    def usual(self, name: str, width: int) -> _Usual:
        """Return the usual changes of a signal over `width` frames.

        `name` is the name of the signal, an attribute of :class:`ChainSignals`.
        """
        if (name, width) not in self._known:
            chain = self.chain
            turned = chain.beyond_pace(name, width)
            t = np.arange(chain.frames)
            later = np.minimum(t + width + 1, chain.frames)
            before = self._busy_before
            free = np.isfinite(turned) & (before[later] == before[np.maximum(t - 1, 0)])
            if name == "azimuth_turns":
                free &= chain.bent(width)
            enough = free.sum() > 5
            everywhere = robust_scale(turned[free], 0.03) if enough else math.nan
            evict_oldest_cache_entries(self._known, chain.frames)[name, width] = _Usual(
                turned, free, everywhere
            )
        return self._known[name, width]

    def against(self, width: int) -> _Against:
        """Return the opposite rotations of parent and child over `width` frames, outside errors."""
        if width not in self._against:
            c, reach = self.chain, edge_neighbourhood_frames(self.chain.fps)
            around = 2 * (width // 2 + reach) + width

            def beyond(turns: Array) -> Array:
                inner = np.convolve(turns, np.ones(width), "same")[: c.frames]
                outer = np.convolve(turns, np.ones(around) / around, "same")[: c.frames]
                return np.asarray(inner - width * outer)

            x, y = (beyond(t) if len(t) >= around else np.zeros(len(t)) for t in (c.x, c.y))
            against = np.where(x * y < 0.0, np.minimum(np.abs(x), np.abs(y)), 0.0)
            beside = width + reach + 2
            near = np.convolve(self.busy, np.ones(2 * beside + 1), "same")[: c.frames] > 0.5
            free = ~near if c.frames > 2 * beside else np.zeros(c.frames, dtype=bool)
            free[:3] = free[-3:] = False
            count = int(free.sum())
            natural = quantile(against[free], 0.99) if count else 0.0
            made = _Against(np.where(free, against, -1.0), count, natural)
            evict_oldest_cache_entries(self._against, c.frames)[width] = made
        return self._against[width]


@dataclass(frozen=True, eq=False)
class _Usual:
    """The changes of a signal over a fixed number of frames.

    Attributes
    ----------
    turned
        The changes, compared with the pace nearby, degrees, shape (frames,).
    free
        Mask of the frames without errors, shape (frames,).
    scale
        The scale of the changes in these frames, degrees, NaN if there are too few frames.
    """

    turned: Array
    free: Mask
    scale: float


@dataclass(frozen=True, eq=False)
class _Against:
    """The opposite rotations of the parent P and the child C over a fixed number of frames.

    Attributes
    ----------
    turned
        The smaller of the two rotations, degrees, shape (frames,). It is 0 if they are not
        opposite, and −1 near errors.
    free
        The number of frames that are not near errors.
    natural
        The 99 % quantile of `turned` in these frames, degrees.
    """

    turned: Array
    free: int
    natural: float


def edge_neighbourhood_frames(fps: float) -> int:
    """Return the number of frames on either side of an edge that are considered near it."""
    return max(4, round(_BESIDE * fps))


class _Measured:
    """The measurements of one possible error, from which the evidence about it is computed."""

    def __init__(self, background: Background, error: SuspectedError) -> None:
        self.background, self.chain, self.error = background, background.chain, error

    @cached_property
    def edges(self) -> list[Edge]:
        """The edges of the error, except for an edge at an end of the clip."""
        size = np.abs(self.error.offset)
        half = max(len(size) // 2, 1)

        def come(sizes: Array) -> int:
            return int(np.argmax(sizes >= _REACHED * sizes[:half].max()))

        ends = []
        start, stop = self.error.start, self.error.stop
        if start > 0:
            ends.append((start, start + come(size) + 1))
        if stop < self.chain.frames:
            ends.append((stop - come(size[::-1]), stop + 1))
        made = [Edge(a, b, float(self._steps(a, b).sum())) for a, b in ends]
        return [e for e in made if abs(e.turn) > _LEAST]

    def _steps(self, low: int, high: int) -> Array:
        """Return the changes of the offset in frames [low, high), 0 in the clip's first frame."""
        frames = np.arange(low - 1, high)
        inside = (frames >= self.error.start) & (frames < self.error.stop)
        offset = np.zeros(len(frames))
        offset[inside] = self.error.offset[frames[inside] - self.error.start]
        steps = np.diff(offset)
        if low == 0 and high > 0:
            steps[0] = 0.0
        return steps

    def terms(self) -> Terms:
        """Return the evidence about the error."""
        c, edges = self.chain, self.edges
        before, after, spread, for_side = self._side()
        rate, natural = self._elsewhere()
        return Terms(
            hinged=c.hinged,
            for_x=sum(self._for("x", e, e.turn) for e in edges),
            for_y=sum(self._for("y", e, -e.turn) for e in edges),
            for_azimuth=sum(self._for("azimuth_turns", e, -e.turn) for e in edges)
            if c.hinged
            else 0.0,
            rougher=self._rougher(),
            edge_bend=max((float(self._bend_at(e)) ** 2 for e in edges), default=0.0),
            off_before=before,
            off_after=after,
            side_spread=spread,
            for_side=for_side,
            least_bend=float(c.bend[self.error.start : self.error.stop].min()),
            together=max((self._together(e) for e in edges), default=1.0),
            rate=rate,
            natural=natural,
            step=self._step,
            seconds=(self.error.stop - self.error.start) / c.fps,
            quiet=min((self._usually(e) for e in edges), default=math.nan),
            silent=self.error.silent,
            noise=float(
                c.noise[max(self.error.start - _NOISE, 0) : self.error.stop + _NOISE].max()
            ),
        )

    @cached_property
    def _step(self) -> float:
        """The magnitude of the change of the offset at an edge, the median of both edges."""
        sizes = [abs(e.turn) for e in self.edges] or [float(np.abs(self.error.offset).max())]
        return median(sizes)

    def _bend_at(self, edge: Edge) -> float:
        return float(self.chain.both_frames[max(edge.start - 1, 0) : edge.stop + 1].min())

    def _turn(self, turns: Array, edge: Edge) -> Array:
        """Return the change of a signal at an edge, compared with its pace on either side.

        The pace is the mean of `turns` in two frames before and after the edge.
        """
        before = turns[max(edge.start - PACE, 1) : edge.start]
        beside = np.concatenate([before, turns[edge.stop : edge.stop + PACE]])
        pace = beside.mean(axis=0) if len(beside) else np.zeros(turns.shape[1:])
        return np.asarray(turns[edge.start : edge.stop].sum(axis=0) - edge.width * pace)

    def _for(self, name: str, edge: Edge, expected: float) -> float:
        """Return the log-likelihood ratio of an expected change at an edge over no change, in nats.

        `name` is the name of the signal, and `expected` is the change that the error would cause,
        in degrees.
        """
        c = self.chain
        turns: Array = getattr(c, name)
        usual = self.background.usual(name, edge.width)
        if not math.isnan(usual.scale):
            reach = math.ceil(_NEAR * c.fps + edge.width) - 1
            near = slice(max(edge.start - reach, 0), edge.start + reach + 1)
            beside = usual.turned[near][usual.free[near]]
            here = robust_scale(beside, 0.03) if len(beside) > 5 else usual.scale
            sigma = 0.6 * here + 0.4 * usual.scale
        else:
            sigma = max(robust_scale(np.diff(turns), 0.03) * math.sqrt(edge.width), 0.3)
        if name == "azimuth_turns":
            sigma = math.hypot(sigma, _BONE / max(self._bend_at(edge), 0.01))
        turn = float(wrap_degrees(self._turn(turns, edge)))
        rest = float(wrap_degrees(np.array(turn - expected)))
        cost = residual_cost(np.array([turn, rest]) / sigma)
        return float(cost[0] - cost[1])

    def _usually(self, edge: Edge) -> float:
        return min(self.background.usual(name, edge.width).scale for name in ("x", "y"))

    def _together(self, edge: Edge) -> float:
        low = max(edge.start - PACE - 1, 0)
        turns = self.chain.together(low, min(edge.stop + PACE, self.chain.frames))
        turn = self._turn(turns, Edge(edge.start - low, edge.stop - low, edge.turn))
        return float(np.linalg.norm(turn) / abs(edge.turn))

    def _rougher(self) -> float:
        """Return how much rougher the azimuth at the edges becomes with the correction, in nats."""
        c = self.chain
        if not c.hinged or not self.edges:
            return 0.0
        spans = [(max(e.start - 2, 1), min(e.stop + 2, c.frames - 1)) for e in self.edges]
        start = min(a for a, _ in spans)
        near = np.zeros(max(b for _, b in spans) - start, dtype=bool)
        for a, b in spans:
            near[a - start : b - start] = True
        at = start + np.flatnonzero(near)
        at = at[self.background.known_azimuth[at]]
        if not len(at):
            return 0.0
        low = int(at[0])
        turns = c.azimuth_turns[low : int(at[-1]) + 2]
        steps = self._steps(low, low + len(turns))
        now, then = (wrap_degrees(np.diff(t))[at - low] for t in (turns, turns + steps))
        both = np.minimum(c.both_frames[at], c.both_frames[at + 1])
        sigma = math.hypot(self.background.roughness, 0.05) / np.maximum(both, ALONG)
        return float((residual_cost(then / sigma) - residual_cost(now / sigma)).sum())

    def _side(self) -> tuple[float, float, float, float]:
        """Return `off_before`, `off_after`, `side_spread` and `for_side` of :class:`Terms`."""
        unknown = math.nan, math.nan, math.nan, 0.0
        usual = self.background.side
        if usual is None:
            return unknown
        size = np.abs(self.error.offset)
        full = np.flatnonzero(size > 0.5 * size.max())
        if not len(full):
            return unknown
        at = self.error.start + full
        off, sine = usual.off[at], self.chain.sine[at]
        fixed = wrap_degrees(off + self.error.offset[full])
        known, least = (sine > _STRAIGHT, 0.0) if usual.exact else (sine > ALONG, 0.3)
        sigma = np.hypot(max(self.background.spread, 0.5), _BONE / np.maximum(sine, 0.01))
        gain = residual_cost(off / sigma) - residual_cost(fixed / sigma)
        weight = sine**2 * known
        if not weight.sum() > least:
            return math.nan, math.nan, math.nan, float(gain.mean())
        before, after = (
            math.sqrt(np.average(v[known] ** 2, weights=weight[known])) for v in (off, fixed)
        )
        return before, after, usual.furthest, float(gain.mean())

    def _elsewhere(self) -> tuple[float | None, float | None]:
        """Return `rate` and `natural` of :class:`Terms`."""
        width = max(1, round(median([e.width for e in self.edges] or [1])))
        against = self.background.against(width)
        seconds = against.free / self.chain.fps
        if seconds < _ELSEWHERE and against.free < 60:
            return None, None
        many = against.turned >= 0.5 * self._step
        times = int(np.count_nonzero(many[1:] & ~many[:-1]))
        return (times + 0.15) / (seconds + 1.0), max(against.natural, 0.05)


@dataclass(frozen=True, eq=False)
class Side:
    """The side to which the child's bone usually bends.

    Attributes
    ----------
    off
        The azimuth of the child's bone relative to this side, degrees, shape (frames,).
    furthest
        The 95 % quantile of the magnitude of `off` in the bent limb.
    exact
        True if the bent limb is always on this side, as with a hinge that is built into the rig.
    """

    off: Array
    furthest: float
    exact: bool = False


def usual_bend_side(chain: ChainSignals, busy: Mask) -> Side | None:
    """Return the side to which the child's bone usually bends, or None if it is unknown.

    `chain` contains the signals of the chain, and `busy` is the mask of the frames to exclude,
    shape (frames,).
    """
    if not chain.hinged:
        return None
    weight, there = chain.sine**2, ~busy & (chain.sine > _STRAIGHT)
    if there.sum() >= _ENOUGH:
        off = wrap_degrees(chain.azimuth - _middle(chain.azimuth[there], weight[there]))
        if (furthest := quantile(np.abs(off[there]), 0.95)) < _EXACT:
            return Side(off, furthest, exact=True)
    there = ~busy & (chain.sine > ALONG)
    if (weight * there).sum() < 3.0:
        return None
    off = wrap_degrees(chain.azimuth - _middle(chain.azimuth[there], weight[there]))
    off = wrap_degrees(off - _weighted_quantile(off[there], weight[there], 0.5))
    return Side(off, _weighted_quantile(np.abs(off[there]), weight[there], 0.95))


def robust_scale(residuals: Array, least: float) -> float:
    """Return 1.48 (mean √|r|)² of residuals r, a scale that is robust to a few outliers.

    The result is at least `least`.
    """
    return max(1.48 * float(np.mean(np.sqrt(np.abs(residuals)))) ** 2, least)


def _middle(degrees: Array, weights: Array) -> float:
    turned = (np.exp(1j * np.radians(degrees)) * weights).sum()
    return float(np.degrees(np.angle(turned)))


def _weighted_quantile(values: Array, weights: Array, share: float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, share * total[-1])])


def error_frames_mask(frames: int, errors: Iterable[SuspectedError]) -> Mask:
    """Return a mask of the frames that belong to any of the errors, (frames,)."""
    taken = np.zeros(frames, dtype=bool)
    for error in errors:
        taken[error.start : error.stop] = True
    return taken
