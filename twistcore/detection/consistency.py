"""The consistency detector: the default [MATH.md §4]."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise
from typing import Any

import numpy as np

from twistcore.chain import Chain
from twistcore.detection.confidence import confidence
from twistcore.detection.counter_rotation import CounterRotation, counter_rotation
from twistcore.detection.cuts import find_cuts
from twistcore.detection.edges import Edges, find_edges
from twistcore.detection.interval import Interval
from twistcore.detection.limbs import Limbs
from twistcore.detection.offsets import offsets_of
from twistcore.detection.pairing import Pair, PairTable, best_pairs, pair_table, unpaired
from twistcore.detection.prediction import Mask
from twistcore.detection.straight_limbs import (
    Jumps,
    StraightError,
    interval_of,
    straight_limb,
    without_errors,
)
from twistcore.motion import Motion
from twistcore.progress import Tell, nobody, part
from twistcore.rotation import Array, wrap

SMALLEST_TAU = float(np.radians(1.5))
SHORTEST_SEGMENT = 0.25  # seconds between cuts
TAU_IN_SIGMA = 6.0  # an automatic τ: where natural motion's own σ would fill the table, higher
_FOLLOWS = ("its edges", "its events", "every frame")


@dataclass(frozen=True, eq=False)
class ChainAnalysis:
    """What is known of one chain before any τ."""

    name: str
    fps: float
    limb: CounterRotation
    row: int
    edges: Edges
    step: Mask
    tables: tuple[PairTable, ...]  # one a segment between cuts
    straight: tuple[StraightError, ...] = ()  # whose jumps no table has
    _known: dict[tuple[int, Pair], Interval] = field(default_factory=dict)  # τ moves: most stay
    _solved: dict[tuple[int, int], list[Interval]] = field(default_factory=dict)

    def strength(self) -> Array:
        """|d| at events, the |jump| of an edge at its peak, else 0; radians, (frames,)."""
        curve = np.where(self.limb.event[self.row], np.abs(self.limb.d[self.row]), 0.0)
        np.maximum.at(curve, self.edges.peak, np.abs(self.edges.jump))
        for error in self.straight:
            curve[error.peak] = max(curve[error.peak], error.strength)
        return curve

    def intervals(self, tau: float) -> tuple[Interval, ...]:
        """Intervals at τ radians, by start."""
        found: list[Interval] = []
        for table in self.tables:
            # τ matters by the edges it lets pass, and of sorted jumps their number says which.
            passing = int((np.abs(table.edges.jump) >= tau).sum()) if len(table.edges.jump) else 0
            if not passing:
                continue
            key = table.low, passing
            if key not in self._solved:
                self._solved[key] = self._solve(table, tau)
            found += self._solved[key]
        if past := [i for e, i in self._of_straight if e.strength >= tau]:
            found = sorted(found + past, key=lambda i: (i.start, i.stop))
        return tuple(found)

    @cached_property
    def _of_straight(self) -> list[tuple[StraightError, Interval]]:
        """Errors of the straight limb and their intervals, which no τ makes anew."""
        return [(e, interval_of(self.name, e)) for e in self.straight]

    def _solve(self, table: PairTable, tau: float) -> list[Interval]:
        """Intervals of a segment at τ radians, by start."""
        pairs = best_pairs(table, tau, self.fps)
        applied = len(pairs)
        pairs += unpaired(table, pairs, tau)
        new = [p for p in pairs if (table.low, p) not in self._known]
        levels = offsets_of(new, table, self.limb, self.row, self.step)
        for pair, level in zip(new, levels, strict=True):
            self._known[table.low, pair] = self._interval(pair, table, *level)
        known = [self._known[table.low, p] for p in pairs]
        found = known[:applied] + [replace(i, open=True) for i in known[applied:]]
        return sorted(found, key=lambda i: (i.start, i.stop))

    def _interval(
        self, pair: Pair, table: PairTable, start: int, offset: Array, residual: float
    ) -> Interval:
        at = [k for k in pair[:2] if k >= 0]
        jumps, sigmas = table.edges.jump[at].tolist(), table.edges.sigma[at].tolist()
        sigma = math.hypot(*sigmas)
        margin = math.log(min(abs(j) / s for j, s in zip(jumps, sigmas, strict=True)))
        return Interval(
            self.name,
            start,
            start + len(offset),
            offset,
            confidence=confidence(pair.gain, abs(residual) / sigma, margin, len(offset)),
            residual=residual,
            explain=partial(_explained, self.limb, self.row, table.edges, pair, residual),
        )


def _explained(
    limb: CounterRotation, row: int, edges: Edges, pair: Pair, residual: float
) -> dict[str, Any]:
    """Why an interval was found; degrees."""
    at = [k for k in pair[:2] if k >= 0]
    return {
        "gain": pair.gain,
        "follows": _FOLLOWS[pair.follows],
        "edges": [_edge_explained(limb, row, edges, k) for k in at],
        "closing_residual_deg": math.degrees(residual),
        "closing_sigma_deg": math.degrees(math.hypot(*edges.sigma[at])),
    }


def _edge_explained(limb: CounterRotation, row: int, edges: Edges, k: int) -> dict[str, Any]:
    """Sums over the edge's frames, degrees: x, y as captured, their residuals and scales."""
    start, stop, jump = int(edges.start[k]), int(edges.stop[k]), float(edges.jump[k])
    at = row, slice(start, stop)
    sums = {
        "x": limb.x[at], "y": limb.y[at], "residual_x": limb.rx[at], "residual_y": limb.ry[at],
        "sigma_x": limb.sigma_x[at], "sigma_y": limb.sigma_y[at],
    }  # fmt: skip
    apart = abs(float(wrap(limb.rx[at].sum() + limb.ry[at].sum())))
    return {
        **{f"{name}_deg": math.degrees(v.sum()) for name, v in sums.items()},
        "start": start,
        "stop": stop,
        "jump_deg": math.degrees(jump),
        "sigma_deg": math.degrees(edges.sigma[k]),
        "gain": float(edges.gain[k]),
        "agreement": max(0.0, 1.0 - apart / max(abs(jump), 1e-12)),
    }


@dataclass(frozen=True, eq=False)
class ConsistencyAnalysis:
    """All chains before any τ; cut: steps that are no motion, that into frame 0 too, (frames,)."""

    chains: Mapping[str, ChainAnalysis]
    cut: Mask

    def automatic_tau(self, chain: str) -> float:
        """max(1.5°, 6·median σ of the chain), radians."""
        return _automatic_tau(self.chains[chain].limb, self.chains[chain].row)

    def strength(self, chain: str) -> Array:
        """m_c(t), radians ≥ 0, (frames,)."""
        return self.chains[chain].strength()

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Intervals of a chain at τ radians, by start."""
        return self.chains[chain].intervals(tau)


class ConsistencyDetector:
    """Counter-rotation beyond what natural motion explains, paired into intervals that close."""

    name = "consistency"

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell = nobody
    ) -> ConsistencyAnalysis:
        """Everything that does not depend on τ; tell: how far it is."""
        cut = find_cuts(motion.rotations, motion.fps)
        segments = _segments(cut, motion.fps)
        cut[:1] = True
        out: dict[str, ChainAnalysis] = {}
        for lines in _alike(_lines(chains)):
            shares = len(out) / len(chains), (len(out) + sum(map(len, lines))) / len(chains)
            here = part(tell, *shares)
            limbs = _limbs(lines, motion)
            strung = [c for same in zip(*lines, strict=True) for c in same]
            jumps = _jumps(limbs, motion.fps, cut, segments, here)
            straight = {
                row: found
                for row, chain in enumerate(strung)
                if (found := straight_limb(motion, chain, jumps[row]))
            }
            if straight:  # an error of one chain shows in those beside it
                jumps = _jumps(without_errors(limbs, straight), motion.fps, cut, segments, here)
            for row, chain in enumerate(strung):
                errors: tuple[StraightError, ...] = ()
                own = jumps[row]
                if row in straight:
                    own, errors = straight[row].leaves(own), straight[row].errors
                out[chain.name] = ChainAnalysis(
                    chain.name,
                    motion.fps,
                    own.counter,
                    row,
                    own.edges,
                    own.step,
                    own.tables,
                    errors,
                )
        return ConsistencyAnalysis(out, cut)


def _automatic_tau(counter: CounterRotation, row: int) -> float:
    return max(SMALLEST_TAU, TAU_IN_SIGMA * float(np.median(counter.sigma[row])))


def _jumps(
    limbs: Limbs, fps: float, cut: Mask, segments: Sequence[tuple[int, int]], tell: Tell
) -> list[Jumps]:
    """The jumps of all chains of limbs, by row."""
    counter = counter_rotation(limbs, fps, cut, tell)
    out = []
    for row in range(len(counter.x)):
        tell(1.0)
        edges, step = find_edges(counter, row)
        tables = tuple(pair_table(counter, row, edges, step, low, high) for low, high in segments)
        out.append(Jumps(counter, row, edges, step, tables, _automatic_tau(counter, row), fps))
    return out


def _lines(chains: Sequence[Chain]) -> list[list[Chain]]:
    """Chains strung together where one's child is the next one's parent."""
    left = list(chains)
    lines: list[list[Chain]] = []
    while left:
        line = [next((c for c in left if not any(o.child == c.parent for o in left)), left[0])]
        left.remove(line[0])
        while follower := next((c for c in left if c.parent == line[-1].child), None):
            line.append(follower)
            left.remove(follower)
        lines.append(line)
    return lines


def _alike(lines: list[list[Chain]]) -> list[list[list[Chain]]]:
    """Lines of equal length, with or without axes per frame, together."""
    kinds: dict[tuple[int, bool], list[list[Chain]]] = {}
    for line in lines:
        kinds.setdefault((len(line), any(c.axis.ndim > 1 for c in line)), []).append(line)
    return list(kinds.values())


def _limbs(lines: list[list[Chain]], motion: Motion) -> Limbs:
    """Rotations and axes of lines of equal length."""
    parents = [[line[0].parent for line in lines]]
    children = [[c.child for c in same] for same in zip(*lines, strict=True)]
    joints = motion.rotations.transpose(1, 0, 2)[np.array(parents + children)]
    varying = any(c.axis.ndim > 1 for line in lines for c in line)
    shape = (motion.frames, 3) if varying else (3,)
    axes = [[np.broadcast_to(c.axis, shape) for c in same] for same in zip(*lines, strict=True)]
    return Limbs(joints, np.array(axes))


def _segments(cut: Mask, fps: float) -> tuple[tuple[int, int], ...]:
    """Frames [low, high) between cuts; where too short to tell error from motion, left out."""
    shortest = max(2, round(SHORTEST_SEGMENT * fps))
    borders = [0, *np.flatnonzero(cut).tolist(), len(cut)]
    return tuple(
        (a, b) for a, b in pairwise(borders) if b - a >= min(shortest, len(cut)) and b - a > 1
    )
