"""What speaks for and against a repair, term by term, each measured against the rest of the clip.

All angles in degrees. A term of evidence is in nats: the cost of a turn if it is motion less its
cost if it is the error, in the scale that the same signal has elsewhere in the clip at that pace.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from twistcore.detection.evidence.witnesses import ALONG, PACE, Mask, Witnesses, wrapped
from twistcore.detection.interval import Interval
from twistcore.detection.robust_cost import residual_cost
from twistcore.rotation import Array

BENT = 0.117  # sin² of a bend of 20°: where the azimuth can be trusted at an edge
_LEAST = 0.3  # an edge that turns by less tells nothing
_REACHED = 0.8  # of the largest offset: there an edge ends
_BONE = 2.5  # by how much a bone's direction is uncertain: over sin(bend) that of the azimuth
_ELSEWHERE = 1.0  # seconds without finds from which the clip tells what is natural
_BESIDE = 0.1  # seconds on either side of an edge
_NOISE = 3  # frames beside a find in which a burst of noise speaks against it
_EXACT, _ENOUGH = 0.5, 20  # degrees off a hinge that the rig makes; frames that tell it
_STRAIGHT = np.sin(np.radians(3.0))  # of a limb straighter than so even that hinge says nothing
_NEAR = 0.6  # seconds in which an edge's neighbours count for more


@dataclass(frozen=True, eq=False)
class Find:
    """Frames [start, stop) and what is to be taken out of P's twist there, degrees.

    silent: whether a joint that is silent elsewhere tells it.
    """

    start: int
    stop: int
    offset: Array
    silent: bool = False

    @classmethod
    def of(cls, interval: Interval) -> Find:
        """An interval's."""
        silent = bool((interval.evidence or {}).get("silent_joint"))
        return cls(interval.start, interval.stop, np.degrees(interval.offset), silent)


@dataclass(frozen=True)
class Edge:
    """Frames [start, stop) in which the offset comes or goes, and by how much, degrees."""

    start: int
    stop: int
    turn: float

    @property
    def width(self) -> int:
        """Length in frames."""
        return self.stop - self.start


@dataclass(frozen=True)
class Terms:
    """The evidence about one find.

    hinged: whether the chain has an azimuth; for_x, for_y, for_azimuth: nats at the edges that the
    witness turns as the error would; rougher: nats by which the azimuth runs rougher with the
    repair; edge_bend: sin² of the bend at its best edge; off_before, off_after: how far C's bone is
    from its side elsewhere, NaN where unknown; side_spread: how far 95 % of the rest of the
    clip is from it at most, NaN likewise; for_side: the same in nats; least_bend; together:
    turn of P and C together at the edges over the offset's; rate: such counter-turns a second
    elsewhere, None where too little is free of finds; natural: their 99 % quantile; step: of the
    smaller edge; seconds: its length; silent: a joint that is silent elsewhere tells it at any
    pace; noise: σ of a burst of it in the find or beside it, 0 for none.
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
    silent: bool
    noise: float


def terms_of(chain: Witnesses, find: Find, taken: Mask) -> Terms:
    """The evidence about a find; taken: frames of all finds of the chain, (frames,)."""
    return _Measured(chain, find, taken).terms()


class _Measured:
    """One find and what is derived from it."""

    def __init__(self, chain: Witnesses, find: Find, taken: Mask) -> None:
        self.chain, self.find = chain, find
        self.offset = np.zeros(chain.frames)
        self.offset[find.start : find.stop] = find.offset
        self.steps = np.diff(self.offset, prepend=self.offset[:1])
        self.inside = np.zeros(chain.frames, dtype=bool)
        self.inside[find.start : find.stop] = True
        grown = np.flatnonzero(taken | self.inside)
        self.busy = np.zeros(chain.frames, dtype=bool)
        for by in (-1, 0, 1):
            self.busy[np.clip(grown + by, 0, chain.frames - 1)] = True
        self.reach = max(4, round(_BESIDE * chain.fps))

    @cached_property
    def edges(self) -> list[Edge]:
        """The edges of the find, at a border of the clip none."""
        size = np.abs(self.find.offset)
        half = max(len(size) // 2, 1)

        def come(sizes: Array) -> int:
            return int(np.argmax(sizes >= _REACHED * sizes[:half].max()))

        ends = []
        start, stop = self.find.start, self.find.stop
        if start > 0:
            ends.append((start, start + come(size) + 1))
        if stop < self.chain.frames:
            ends.append((stop - come(size[::-1]), stop + 1))
        made = [Edge(a, b, float(self.steps[a:b].sum())) for a, b in ends]
        return [e for e in made if abs(e.turn) > _LEAST]

    def terms(self) -> Terms:
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
            least_bend=float(c.bend[self.find.start : self.find.stop].min()),
            together=max((self._together(e) for e in edges), default=1.0),
            rate=rate,
            natural=natural,
            step=self._step,
            seconds=(self.find.stop - self.find.start) / c.fps,
            silent=self.find.silent,
            noise=float(c.noise[max(self.find.start - _NOISE, 0) : self.find.stop + _NOISE].max()),
        )

    @property
    def _step(self) -> float:
        """How far the offset turns at an edge, in the median."""
        sizes = [abs(e.turn) for e in self.edges] or [float(np.abs(self.find.offset).max())]
        return float(np.median(sizes))

    def _bend_at(self, edge: Edge) -> float:
        return float(self.chain.both_frames[max(edge.start - 1, 0) : edge.stop + 1].min())

    def _turn(self, turns: Array, edge: Edge) -> Array:
        """How far a signal turns at an edge beyond the pace of two frames on either side."""
        before = turns[max(edge.start - PACE, 1) : edge.start]
        beside = np.concatenate([before, turns[edge.stop : edge.stop + PACE]])
        pace = beside.mean(axis=0) if len(beside) else np.zeros(turns.shape[1:])
        return np.asarray(turns[edge.start : edge.stop].sum(axis=0) - edge.width * pace)

    def _for(self, name: str, edge: Edge, expected: float) -> float:
        """Nats for a signal that turns by what is expected at an edge, against by nothing."""
        c = self.chain
        turns: Array = getattr(c, name)
        series = c.beyond_pace(name, edge.width)
        busy = np.concatenate([[0], np.cumsum(self.busy)])
        t = np.arange(c.frames)
        later = np.minimum(t + edge.width + 1, c.frames)
        free = np.isfinite(series) & (busy[later] == busy[np.maximum(t - 1, 0)])
        if name == "azimuth_turns":
            free &= c.bent(edge.width)
        near = free & (np.abs(t - edge.start) < _NEAR * c.fps + edge.width)
        if free.sum() > 5:
            everywhere = scale(series[free], 0.03)
            here = scale(series[near], 0.03) if near.sum() > 5 else everywhere
            sigma = 0.6 * here + 0.4 * everywhere
        else:
            sigma = max(scale(np.diff(turns), 0.03) * math.sqrt(edge.width), 0.3)
        if name == "azimuth_turns":
            sigma = math.hypot(sigma, _BONE / max(self._bend_at(edge), 0.01))
        turn = float(wrapped(self._turn(turns, edge)))
        rest = float(wrapped(np.array(turn - expected)))
        cost = residual_cost(np.array([turn, rest]) / sigma)
        return float(cost[0] - cost[1])

    def _together(self, edge: Edge) -> float:
        low = max(edge.start - PACE - 1, 0)
        turns = self.chain.together(low, min(edge.stop + PACE, self.chain.frames))
        turn = self._turn(turns, Edge(edge.start - low, edge.stop - low, edge.turn))
        return float(np.linalg.norm(turn) / abs(edge.turn))

    def _rougher(self) -> float:
        """Nats by which the azimuth runs rougher over the edges once the find is taken out."""
        c = self.chain
        if not c.hinged or not self.edges:
            return 0.0
        # A change of pace takes three frames.
        sine = np.minimum(c.both_frames, np.append(c.both_frames[1:], 0.0))
        known = sine > ALONG

        def rough(turns: Array) -> Array:
            out = np.zeros(c.frames)
            out[1:-1] = wrapped(turns[2:] - turns[1:-1])
            return out

        now, then = rough(c.azimuth_turns), rough(c.azimuth_turns + self.steps)
        free = known & ~self.busy
        usual = now[free] if free.sum() > 10 else now[known]
        natural = scale(usual, 0.02) if len(usual) > 10 else 5.0
        sigma = math.hypot(natural, 0.05) / np.maximum(sine, ALONG)
        at = np.zeros(c.frames, dtype=bool)
        for e in self.edges:
            at[max(e.start - 2, 1) : min(e.stop + 2, c.frames - 1)] = True
        at &= known
        return float(
            (residual_cost(then[at] / sigma[at]) - residual_cost(now[at] / sigma[at])).sum()
        )

    def _side(self) -> tuple[float, float, float, float]:
        """How far C's bone is from its side elsewhere, before and after; its spread; and nats."""
        c = self.chain
        unknown = math.nan, math.nan, math.nan, 0.0
        if not c.hinged:
            return unknown
        weight = c.sine**2
        full = self.inside & (np.abs(self.offset) > 0.5 * np.abs(self.offset).max())
        usual = usual_side(c, self.busy)
        if usual is None or not full.any():
            return unknown
        off, furthest = usual.off, usual.furthest
        known, least = (c.sine > _STRAIGHT, 0.0) if usual.exact else (c.sine > ALONG, 0.3)
        here, there = full & known, ~self.busy & known
        fixed = wrapped(off + self.offset)
        spread = 1.48 * float(np.average(np.sqrt(np.abs(off[there])), weights=weight[there])) ** 2
        sigma = np.hypot(max(spread, 0.5), _BONE / np.maximum(c.sine, 0.01))[full]
        gain = residual_cost(off[full] / sigma) - residual_cost(fixed[full] / sigma)
        if not (weight * here).sum() > least:
            return math.nan, math.nan, math.nan, float(gain.mean())
        before, after = (
            math.sqrt(np.average(v[here] ** 2, weights=weight[here])) for v in (off, fixed)
        )
        return before, after, furthest, float(gain.mean())

    def _elsewhere(self) -> tuple[float | None, float | None]:
        """How often P and C turn against each other so elsewhere, a second; the 99 % quantile."""
        c = self.chain
        width = max(1, round(float(np.median([e.width for e in self.edges] or [1]))))
        around = 2 * (width // 2 + self.reach) + width

        def beyond(turns: Array) -> Array:
            inner = np.convolve(turns, np.ones(width), "same")[: c.frames]
            outer = np.convolve(turns, np.ones(around) / around, "same")[: c.frames]
            return np.asarray(inner - width * outer)

        x, y = (beyond(t) if len(t) >= around else np.zeros(len(t)) for t in (c.x, c.y))
        against = np.where(x * y < 0.0, np.minimum(np.abs(x), np.abs(y)), 0.0)
        reach = width + self.reach + 2
        near = np.convolve(self.busy, np.ones(2 * reach + 1), "same")[: c.frames] > 0.5
        free = ~near if c.frames > 2 * reach else np.zeros(c.frames, dtype=bool)
        free[:3] = free[-3:] = False
        seconds = float(free.sum()) / c.fps
        if seconds < _ELSEWHERE and free.sum() < 60:
            return None, None
        many = np.diff(((against >= 0.5 * self._step) & free).astype(int), prepend=0) == 1
        rate = (float(many.sum()) + 0.15) / (seconds + 1.0)
        return rate, max(float(np.quantile(against[free], 0.99)), 0.05)


@dataclass(frozen=True, eq=False)
class Side:
    """How far C's bone is from its usual side, degrees, (frames,), and 95 % of the clip at most.

    exact: it keeps to it wherever the limb is bent at all, as a rig makes it.
    """

    off: Array
    furthest: float
    exact: bool = False


def usual_side(chain: Witnesses, busy: Mask) -> Side | None:
    """The side to which C's bone leaves P's in most of the clip; None where that is not known.

    busy: frames that say nothing of it, (frames,).
    """
    if not chain.hinged:
        return None
    weight, there = chain.sine**2, ~busy & (chain.sine > _STRAIGHT)
    if there.sum() >= _ENOUGH:
        off = wrapped(chain.azimuth - _middle(chain.azimuth[there], weight[there]))
        if (furthest := float(np.quantile(np.abs(off[there]), 0.95))) < _EXACT:
            return Side(off, furthest, exact=True)
    there = ~busy & (chain.sine > ALONG)
    if (weight * there).sum() < 3.0:
        return None
    off = wrapped(chain.azimuth - _middle(chain.azimuth[there], weight[there]))
    off = wrapped(off - _weighted_quantile(off[there], weight[there], 0.5))
    return Side(off, _weighted_quantile(np.abs(off[there]), weight[there], 0.95))


def scale(residuals: Array, least: float) -> float:
    """1.48 (mean √|r|)²: a scale that a few outliers do not widen."""
    return max(1.48 * float(np.mean(np.sqrt(np.abs(residuals)))) ** 2, least)


def _middle(degrees: Array, weights: Array) -> float:
    turned = (np.exp(1j * np.radians(degrees)) * weights).sum()
    return float(np.degrees(np.angle(turned)))


def _weighted_quantile(values: Array, weights: Array, share: float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, share * total[-1])])


def taken_by(frames: int, finds: Iterable[Find]) -> Mask:
    """Frames in which any of the finds lies, (frames,)."""
    taken = np.zeros(frames, dtype=bool)
    for find in finds:
        taken[find.start : find.stop] = True
    return taken
