"""The consistency detector: the default [MATH.md §4]."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from twistcore.chain import Chain
from twistcore.detection.confidence import confidence
from twistcore.detection.counter import CounterRotation, counter_rotation
from twistcore.detection.coupling import Limb
from twistcore.detection.cuts import find_cuts
from twistcore.detection.edges import Edge, find_edges
from twistcore.detection.interval import Interval
from twistcore.detection.pairing import (
    LEVEL,
    Pair,
    PairTable,
    best_pairs,
    offset_of,
    pair_table,
    unpaired,
)
from twistcore.detection.prediction import Mask
from twistcore.motion import Motion
from twistcore.rotation import Array

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
    edges: tuple[Edge, ...]
    step: Mask
    segments: tuple[tuple[int, int], ...]
    _tables: list[PairTable] = field(default_factory=list)
    _known: dict[tuple[Pair, bool], Interval] = field(default_factory=dict)  # τ moves: most stay

    @property
    def tables(self) -> list[PairTable]:
        """Gains of pairs, one table a segment; computed when first asked for."""
        if not self._tables:
            self._tables.extend(
                pair_table(self.limb, self.row, self.edges, self.step, low, high)
                for low, high in self.segments
            )
        return self._tables

    def strength(self) -> Array:
        """|d| at events, the |jump| of an edge at its peak, else 0; radians, (frames,)."""
        curve = np.where(self.limb.event[self.row], np.abs(self.limb.d[self.row]), 0.0)
        for edge in self.edges:
            curve[edge.peak] = max(curve[edge.peak], abs(edge.jump))
        return curve

    def intervals(self, tau: float) -> tuple[Interval, ...]:
        """Intervals at τ radians, by start."""
        found = []
        for table in self.tables:
            pairs = best_pairs(table, tau, self.fps)
            found += [self._interval(p, table, open_=False) for p in pairs]
            found += [self._interval(p, table, open_=True) for p in unpaired(table, pairs, tau)]
        return tuple(sorted(found, key=lambda i: (i.start, i.stop)))

    def _interval(self, pair: Pair, table: PairTable, *, open_: bool) -> Interval:
        key = pair, open_
        if key not in self._known:
            self._known[key] = self._built(pair, table, open_=open_)
        return self._known[key]

    def _built(self, pair: Pair, table: PairTable, *, open_: bool) -> Interval:
        start, offset, residual = offset_of(
            pair, self.limb, self.row, self.step, table.low, table.high
        )
        edges = [e for e in (pair.opening, pair.closing) if e is not None]
        sigma = float(np.sqrt(sum(e.sigma**2 for e in edges)))
        margin = float(np.log(min(abs(e.jump) / e.sigma for e in edges)))
        return Interval(
            self.name,
            start,
            start + len(offset),
            offset,
            confidence=confidence(pair.gain, abs(residual) / sigma, margin, len(offset)),
            open=open_,
            residual=residual,
            evidence={
                "gain": pair.gain,
                "follows": _FOLLOWS[pair.follows if pair.opening and pair.closing else LEVEL],
                "edges": [self._evidence(e) for e in edges],
                "closing_residual_deg": float(np.degrees(residual)),
                "closing_sigma_deg": float(np.degrees(sigma)),
            },
        )

    def _evidence(self, edge: Edge) -> dict[str, Any]:
        """Sums over the edge's frames, degrees: x, y as captured, predicted, their residuals."""
        at = self.row, slice(edge.start, edge.stop)
        c = self.limb
        sums = {
            "x": c.x[at], "y": c.y[at], "residual_x": c.rx[at], "residual_y": c.ry[at],
            "sigma_x": c.sigma_x[at], "sigma_y": c.sigma_y[at],
        }  # fmt: skip
        out: dict[str, Any] = {
            f"{name}_deg": float(np.degrees(v.sum())) for name, v in sums.items()
        }
        out["start"], out["stop"] = edge.start, edge.stop
        out["jump_deg"], out["sigma_deg"] = np.degrees([edge.jump, edge.sigma]).tolist()
        out["gain"] = edge.gain
        apart = float(np.abs(c.rx[at].sum() + c.ry[at].sum()))
        out["agreement"] = max(0.0, 1.0 - apart / max(abs(edge.jump), 1e-12))
        return out


@dataclass(frozen=True, eq=False)
class ConsistencyAnalysis:
    """All chains before any τ."""

    chains: Mapping[str, ChainAnalysis]

    def automatic_tau(self, chain: str) -> float:
        """max(1.5°, 6·median σ of the chain), radians."""
        c = self.chains[chain]
        return max(SMALLEST_TAU, TAU_IN_SIGMA * float(np.median(c.limb.sigma[c.row])))

    def strength(self, chain: str) -> Array:
        """m_c(t), radians ≥ 0, (frames,)."""
        return self.chains[chain].strength()

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Intervals of a chain at τ radians, by start."""
        return self.chains[chain].intervals(tau)


class ConsistencyDetector:
    """Counter-rotation beyond what natural motion explains, paired into intervals that close."""

    name = "consistency"

    def analyse(self, motion: Motion, chains: Sequence[Chain]) -> ConsistencyAnalysis:
        """Everything that does not depend on τ."""
        cut = find_cuts(motion.rotations, motion.fps)
        segments = _segments(cut, motion.fps)
        cut[:1] = True
        out: dict[str, ChainAnalysis] = {}
        for line in _lines(chains):
            joints = [line[0].parent, *(c.child for c in line)]
            limb = Limb([motion.rotations[:, j] for j in joints], [c.axis for c in line])
            counter = counter_rotation(limb, motion.fps, cut)
            for row, chain in enumerate(line):
                edges, step = find_edges(counter, row)
                out[chain.name] = ChainAnalysis(
                    chain.name, motion.fps, counter, row, edges, step, segments
                )
        return ConsistencyAnalysis(out)


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


def _segments(cut: Mask, fps: float) -> tuple[tuple[int, int], ...]:
    """Frames [low, high) between cuts; where too short to tell error from motion, left out."""
    shortest = max(2, round(SHORTEST_SEGMENT * fps))
    borders = [0, *np.flatnonzero(cut).tolist(), len(cut)]
    return tuple(
        (a, b) for a, b in pairwise(borders) if b - a >= min(shortest, len(cut)) and b - a > 1
    )
