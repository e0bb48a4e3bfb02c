"""The consistency detector: the default [MATH.md §4]."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
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
from twistcore.detection.offsets import Course, offsets_of
from twistcore.detection.pairing import Pair, PairTable, best_pairs, pair_table, unpaired
from twistcore.detection.prediction import Mask
from twistcore.detection.soft_errors import Known, SoftError, soft_intervals
from twistcore.motion import Motion
from twistcore.progress import Tell, nobody, part
from twistcore.rotation import Array, wrap

SMALLEST_TAU = float(np.radians(1.5))
SHORTEST_SEGMENT = 0.25  # seconds between cuts
TAU_IN_SIGMA = 6.0  # an automatic τ: where natural motion's own σ would fill the table, higher
# Of the larger of the sums of rx and ry over an edge, the smaller: an error turns both joints.
# Where no edge of an interval shows so in both, one joint jumps alone: that is only shown.
SHOWN_IN_BOTH = 0.35
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
    soft: tuple[Interval, ...] = ()  # what sets in softly
    instead: tuple[tuple[int, int], ...] = ()  # frames where these stand for what edges say
    _known: dict[tuple[int, Pair], Interval] = field(default_factory=dict)  # τ moves: most stay
    _solved: dict[tuple[int, int], list[Interval]] = field(default_factory=dict)

    def strength(self) -> Array:
        """|d| at events, the |jump| of an edge at its peak, else 0; radians, (frames,)."""
        curve = np.where(self.limb.event[self.row], np.abs(self.limb.d[self.row]), 0.0)
        np.maximum.at(curve, self.edges.peak, np.abs(self.edges.jump))
        for i in self.soft:
            peak = i.start + int(np.abs(np.diff(i.offset, prepend=0.0)).argmax())
            curve[peak] = max(curve[peak], i.size)
        return curve

    def intervals(self, tau: float) -> tuple[Interval, ...]:
        """Intervals at τ radians, by start."""
        found = [i for i in self.of_edges(tau) if not any(_meet(i, f) for f in self.instead)]
        found += (i for i in self.soft if float(np.abs(i.offset).max()) >= tau)
        return tuple(sorted(found, key=lambda i: (i.start, i.stop)))

    def of_edges(self, tau: float) -> tuple[Interval, ...]:
        """Intervals between edges at τ radians, by start."""
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
        return tuple(found)

    def _solve(self, table: PairTable, tau: float) -> list[Interval]:
        """Intervals of a segment at τ radians, by start."""
        pairs = best_pairs(table, tau, self.fps)
        applied = len(pairs)
        pairs += unpaired(table, pairs, tau)
        new = [p for p in pairs if (table.low, p) not in self._known]
        courses = offsets_of(new, table, self.limb, self.row, self.step)
        for pair, course in zip(new, courses, strict=True):
            self._known[table.low, pair] = self._interval(pair, table, course)
        known = [self._known[table.low, p] for p in pairs]
        found = known[:applied] + [replace(i, open=True) for i in known[applied:]]
        return sorted(found, key=lambda i: (i.start, i.stop))

    def _interval(self, pair: Pair, table: PairTable, course: Course) -> Interval:
        at = [k for k in pair[:2] if k >= 0]
        jumps, sigmas = table.edges.jump[at].tolist(), table.edges.sigma[at].tolist()
        sigma = math.hypot(*sigmas)
        margin = math.log(min(abs(j) / s for j, s in zip(jumps, sigmas, strict=True)))
        offset, residual = course.offset, course.residual
        return Interval(
            self.name,
            course.start,
            course.start + len(offset),
            offset,
            confidence=confidence(pair.gain, abs(residual) / sigma, margin, len(offset)),
            open=not any(_shown_in_both(self.limb, self.row, table.edges, k) for k in at),
            residual=residual,
            explain=partial(_explained, self.limb, self.row, table.edges, pair, course),
            followed=course.followed,
        )


def _meet(interval: Interval, frames: tuple[int, int]) -> bool:
    return interval.start < frames[1] and frames[0] < interval.stop


def _shown_in_both(limb: CounterRotation, row: int, edges: Edges, k: int) -> bool:
    """Whether both joints turn at an edge, one way or the other: near ±180° signs say nothing."""
    at = row, slice(edges.start[k], edges.stop[k])
    x, y = (abs(math.remainder(float(r[at].sum()), math.tau)) for r in (limb.rx, limb.ry))
    return min(x, y) >= SHOWN_IN_BOTH * max(x, y)


def _explained(
    limb: CounterRotation, row: int, edges: Edges, pair: Pair, course: Course
) -> dict[str, Any]:
    """Why an interval was found; degrees."""
    at = [k for k in pair[:2] if k >= 0]
    return {
        "gain": pair.gain,
        "follows": _FOLLOWS[pair.follows],
        "edges": [_edge_explained(limb, row, edges, k) for k in at],
        "closing_residual_deg": math.degrees(course.residual),
        "closing_sigma_deg": math.degrees(math.hypot(*edges.sigma[at])),
        "child_follows": course.followed,
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
        return automatic_tau(self.chains[chain])

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
        cut = find_cuts(motion)
        segments = _segments(cut, motion.fps)
        cut[:1] = True
        out: dict[str, ChainAnalysis] = {}
        for lines in _alike(_lines(chains)):
            shares = len(out) / len(chains), (len(out) + sum(map(len, lines))) / len(chains)
            here = part(tell, *shares)
            limbs = _limbs(lines, motion)
            counter = counter_rotation(limbs, motion.fps, cut, here)
            rows = [c for same in zip(*lines, strict=True) for c in same]
            for row, chain in enumerate(rows):
                here(1.0)
                edges, step = find_edges(counter, row)
                tables = tuple(
                    pair_table(counter, row, edges, step, low, high) for low, high in segments
                )
                out[chain.name] = ChainAnalysis(
                    chain.name, motion.fps, counter, row, edges, step, tables
                )
            names = [chain.name for chain in rows]
            out |= _with_soft(limbs, motion.fps, cut, [out[name] for name in names])
        return ConsistencyAnalysis(out, cut)


def _with_soft(
    limbs: Limbs, fps: float, cut: Mask, chains: Sequence[ChainAnalysis]
) -> dict[str, ChainAnalysis]:
    """Chains with what sets in softly, beside their intervals at the automatic τ.

    It is sought as if the children had turned back in full: what they did not is no error of its
    own. Where it then stands for such an error itself, nothing is known of that child.
    """
    jumps = [(c.row, i) for c in chains for i in c.of_edges(automatic_tau(c)) if not i.open]
    known = [Known(row, i.start, i.offset) for row, i in jumps]
    short = {
        k: (row, i.start, (i.followed - 1.0) * i.offset)
        for k, (row, i) in zip(known, jumps, strict=True)
        if i.followed < 1.0
    }
    while True:
        turned = limbs.turned(list(short.values())) if short else limbs
        found, replaced = soft_intervals(turned, fps, cut, known)
        if short.keys().isdisjoint(replaced):
            break
        short = {k: turn for k, turn in short.items() if k not in replaced}
    if not found:
        return {}
    spans: dict[int, list[tuple[int, int]]] = {}
    for f in found:
        for row in range(f.row % limbs.count, len(chains), limbs.count):
            if abs(row - f.row) <= limbs.count:
                spans.setdefault(row, []).append((f.start, f.stop))
    for k in replaced:
        spans.setdefault(k.row, []).append((k.start, k.stop))
    return {
        c.name: replace(
            c,
            soft=tuple(_soft_interval(c.name, f) for f in found if f.row == c.row),
            instead=tuple(spans.get(c.row, ())),
        )
        for c in chains
    }


def _soft_interval(chain: str, found: SoftError) -> Interval:
    share = found.followed
    return Interval(
        chain,
        found.start,
        found.stop,
        found.offset,
        confidence=0.9,
        explain=partial(dict, child_follows=share) if share < 1.0 else None,
        followed=share,
    )


def automatic_tau(c: ChainAnalysis) -> float:
    """max(1.5°, 6·median σ of the chain), radians."""
    return max(SMALLEST_TAU, TAU_IN_SIGMA * float(np.median(c.limb.sigma[c.row])))


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
