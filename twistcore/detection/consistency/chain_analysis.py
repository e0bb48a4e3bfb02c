"""The analysis of chains by the consistency detector, before a threshold is chosen."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from twistcore.detection.consistency.confidence import counter_twist_confidence
from twistcore.detection.consistency.pieces import shows_in_twist
from twistcore.detection.counter_twist.counter_rotation import CounterRotation
from twistcore.detection.counter_twist.edges import Edges
from twistcore.detection.counter_twist.offsets import Course, interval_twist_errors_over_time
from twistcore.detection.counter_twist.pairing import (
    Pair,
    PairTable,
    best_edge_pairs,
    one_ended_jump_intervals,
)
from twistcore.detection.evidence import (
    Background,
    ChainSignals,
    Judgement,
    SuspectedError,
    Terms,
    judgement_of,
    lacks_rotation_at_error_edges,
    measure_evidence,
)
from twistcore.detection.interval import Interval
from twistcore.detection.prediction import Mask
from twistcore.detection.straight_limbs import STRAIGHT
from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

# Minimum ratio of the smaller to the larger rotation of P and C at an edge, because an error
# rotates both joints. If no edge of an interval reaches this ratio, one joint jumps alone. Such an
# interval is listed but not corrected.
SHOWN_IN_BOTH = 0.35
# In a clip with rounded angles, an interval with a smaller gain (in nats) is listed but not
# corrected. If σ is large, two small jumps of natural motion may add up to 0, which the confidence
# mistakes for evidence because it was fitted to captures with fine angles.
ROUNDED_GAIN = 5.0
_FOLLOWS = ("its edges", "its events", "every frame")  # words for the values of `Pair.follows`
SMALLEST_TAU = float(np.radians(1.5))
_BACKGROUNDS = 2  # maximum number in the cache, because their arrays are as long as the clip
TAU_IN_SIGMA = 6.0  # minimum of the automatic τ in σ, so that natural motion yields few edges


@dataclass(frozen=True, eq=False)
class FixedInterval:
    """An interval whose edges do not depend on τ. It is listed if its strength is at least τ.

    `strength` is in radians. `peak` is the frame in which the strength curve reaches this value.
    """

    interval: Interval
    strength: float
    peak: int


@dataclass(frozen=True, eq=False)
class ChainAnalysis:
    """The analysis of one chain, before a threshold is chosen.

    Attributes
    ----------
    name
        The name of the chain.
    fps
        The frame rate.
    limb
        The counter-rotation of all chains that are analysed together.
    row
        The row of the chain in `limb`.
    edges
        The possible edges of the chain: frames in which an error may begin or end.
    step
        Mask of the frames in which the offset of an interval may change, shape (frames,).
    tables
        The gains of all pairs of edges, one table for each segment between cuts.
    fixed
        Errors of straight limbs and soft errors, which do not depend on τ.
    replaced
        Frames [low, high) in which soft errors replace the intervals between jumps.
    left
        Frames [low, high) that were not searched for soft errors, because the budget was used up.
    rounded
        True if the angles in the file are rounded to coarse steps.
    """

    name: str
    fps: float
    limb: CounterRotation
    row: int
    edges: Edges
    step: Mask
    tables: tuple[PairTable, ...]
    fixed: tuple[FixedInterval, ...] = ()
    replaced: tuple[tuple[int, int], ...] = ()
    left: tuple[tuple[int, int], ...] = ()
    rounded: bool = False
    # Caches, since most intervals stay the same while a person drags τ.
    _known: dict[tuple[int, Pair], Interval] = field(default_factory=dict)
    _solved: dict[tuple[int, int], list[Interval]] = field(default_factory=dict)

    def automatic_tau(self) -> float:
        """Return the automatic τ of the chain in radians (see :func:`automatic_tau`)."""
        return self._automatic_tau

    @cached_property
    def _automatic_tau(self) -> float:
        return automatic_tau(self.limb, self.row)

    def strength(self) -> Array:
        """Return the strength of the chain, which is compared with τ, in radians ≥ 0, (frames,).

        The strength is the magnitude |d| of the counter-rotation in frames in which it is
        significant (events), and 0 in all other frames. At the peak of an edge, it is at least the
        size of the jump. At the peak of a fixed interval, it is at least the strength of the
        interval.
        """
        curve = np.where(self.limb.event[self.row], np.abs(self.limb.d[self.row]), 0.0)
        np.maximum.at(curve, self.edges.peak, np.abs(self.edges.jump))
        for s in self.fixed:
            curve[s.peak] = max(curve[s.peak], s.strength)
        return curve

    def intervals(self, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of the chain at threshold τ in radians, sorted by start."""
        found = [i for i in self.between_edges(tau) if not self.is_replaced(i)]
        past = [s.interval for s in self.fixed if s.strength >= tau]
        return tuple(sorted(found + past, key=lambda i: (i.start, i.stop)) if past else found)

    def is_replaced(self, interval: Interval) -> bool:
        """Return True if soft errors replace this interval, which was found between jumps."""
        return any(_meet(interval, frames) for frames in self.replaced)

    def with_soft(
        self, soft: Sequence[FixedInterval], replaced: Sequence[tuple[int, int]]
    ) -> ChainAnalysis:
        """Return a copy of the analysis with additional soft errors.

        `replaced` contains the frames [low, high) in which the soft errors replace all other
        intervals.
        """
        kept = (s for s in self.fixed if not any(_meet(s.interval, frames) for frames in replaced))
        return replace(self, fixed=(*kept, *soft), replaced=tuple(replaced))

    def between_edges(self, tau: float) -> tuple[Interval, ...]:
        """Return the intervals between jumps at threshold τ in radians, sorted by start."""
        found: list[Interval] = []
        for table in self.tables:
            # The number of edges of at least τ identifies these edges.
            passing = int((np.abs(table.edges.jump) >= tau).sum())
            if not passing:
                continue
            key = table.low, passing
            if key not in self._solved:
                self._solved[key] = self._solve(table, tau)
            found += self._solved[key]
        return tuple(found)

    def _solve(self, table: PairTable, tau: float) -> list[Interval]:
        """Return the intervals of one segment at threshold τ in radians, sorted by start."""
        pairs = best_edge_pairs(table, tau, self.fps)
        applied = len(pairs)
        pairs += one_ended_jump_intervals(table, pairs, tau)
        new = [p for p in pairs if (table.low, p) not in self._known]
        courses = interval_twist_errors_over_time(new, table, self.limb, self.row, self.step)
        for pair, course in zip(new, courses, strict=True):
            self._known[table.low, pair] = self._interval(pair, table, course)
        known = [self._known[table.low, p] for p in pairs]
        found = known[:applied] + [replace(i, open=True) for i in known[applied:]]
        return sorted(found, key=lambda i: (i.start, i.stop))

    def _interval(self, pair: Pair, table: PairTable, course: Course) -> Interval:
        at = [k for k in pair[:2] if k >= 0]
        jumps, sigmas = table.edges.jump[at].tolist(), table.edges.sigma[at].tolist()
        sigma = math.hypot(*sigmas)
        # For a pair with one edge, `pair.gain` includes the prior cost of an interval up to a
        # border, so use the gain of the edge.
        gain = pair.gain if len(at) > 1 else max(pair.gain, float(table.edges.gain[at[0]]))
        margin = math.log(min(abs(j) / s for j, s in zip(jumps, sigmas, strict=True)))
        offset, residual = course.offset, course.residual
        return Interval(
            self.name,
            course.start,
            course.start + len(offset),
            offset,
            confidence=counter_twist_confidence(
                gain,
                abs(residual) / sigma,
                margin,
                len(offset),
                beyond_tau=min(map(abs, jumps)) >= self.automatic_tau(),
            ),
            open=not any(_shown_in_both(self.limb, self.row, table.edges, k) for k in at)
            or (self.rounded and gain < ROUNDED_GAIN),
            residual=residual,
            explain=partial(_explained, self.limb, self.row, table.edges, pair, course),
            followed=course.followed,
        )


@dataclass(frozen=True, eq=False)
class ConsistencyAnalysis:
    """The analysis of a motion by the consistency detector, before a threshold is chosen.

    Attributes
    ----------
    chains
        The analysis of each chain, keyed by chain name.
    cut
        Mask of the frames that do not continue the motion of the previous frame, shape (frames,).
        It includes frame 0.
    own_twist
        The result of :func:`detrended_twist_increments` for each chain whose child is a piece of
        the same bone, keyed by chain name.
    witnesses
        The signals with which the intervals of a chain are judged, keyed by chain name.
    """

    chains: Mapping[str, ChainAnalysis]
    cut: Mask
    own_twist: Mapping[str, Array] = field(default_factory=dict)
    witnesses: Mapping[str, ChainSignals] = field(default_factory=dict)
    _backgrounds: dict[str, Background] = field(default_factory=dict)  # the latest few
    _judging: threading.RLock = field(default_factory=threading.RLock)
    # keyed by the id of an interval: the interval, the judged interval, and True for motion
    _judged: dict[int, tuple[Interval, Interval, bool]] = field(default_factory=dict)

    def detached(self) -> ConsistencyAnalysis:
        """Return the analysis without references to the motion, which can then be freed."""
        return replace(self, witnesses={n: own.detached() for n, own in self.witnesses.items()})

    def automatic_tau(self, chain: str) -> float:
        """Return the automatic τ of a chain, max(1.5°, 6·median σ), in radians."""
        return self.chains[chain].automatic_tau()

    def strength(self, chain: str) -> Array:
        """Return the strength of a chain, which is compared with τ, in radians ≥ 0, (frames,)."""
        return self.chains[chain].strength()

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of a chain at threshold τ in radians, sorted by start.

        Intervals that are judged to be natural motion are omitted.
        """
        return tuple(i for i, motion in self._found(chain, tau) if not motion)

    def taken_for_motion(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of a chain at τ radians that are judged to be natural motion."""
        return tuple(i for i, motion in self._found(chain, tau) if motion)

    def _found(self, chain: str, tau: float) -> Iterator[tuple[Interval, bool]]:
        found = self.chains[chain].intervals(tau)
        if (twist := self.own_twist.get(chain)) is not None:
            found = tuple(i for i in found if shows_in_twist(twist, i))
        return map(self.with_evidence, found)

    def with_evidence(self, interval: Interval) -> tuple[Interval, bool]:
        """Return an interval with its final confidence, and whether it is natural motion.

        The evidence can only lower the confidence. For an error of a straight limb, there is hardly
        any evidence except its course over time. Such an error is not judged if both bones rotate
        at its ends and there is no noise.
        """
        if interval.chain not in self.witnesses:
            return interval, False
        with self._judging:
            return self._with_evidence(interval)

    def _with_evidence(self, interval: Interval) -> tuple[Interval, bool]:
        if id(interval) not in self._judged:
            own, motion, known = interval, False, self.witnesses[interval.chain]
            straight = (interval.evidence or {}).get("follows") == STRAIGHT
            terms = measure_evidence(self._background(interval.chain), SuspectedError.of(interval))
            if not straight or terms.noise > 0.0 or lacks_rotation_at_error_edges(terms):
                own, motion = judge_interval_by_evidence(
                    interval, terms, known.segment, straight=straight
                )
            self._judged[id(interval)] = interval, own, motion and not straight
        return self._judged[id(interval)][1:]

    @property
    def left(self) -> dict[str, tuple[tuple[int, int], ...]]:
        """The frames [low, high) that were not searched for soft errors, keyed by chain name."""
        return {name: chain.left for name, chain in self.chains.items() if chain.left}

    def _background(self, chain: str) -> Background:
        """Return the signals of a chain outside its intervals at its automatic τ."""
        if chain not in self._backgrounds:
            own, known = self.chains[chain], replace(self.witnesses[chain], _series={})
            while len(self._backgrounds) >= _BACKGROUNDS:
                del self._backgrounds[next(iter(self._backgrounds))]
            finds = (SuspectedError.of(i) for i in own.intervals(own.automatic_tau()))
            self._backgrounds[chain] = Background.of(known, finds)
        return self._backgrounds[chain]


def judge_interval_by_evidence(
    interval: Interval, terms: Terms, segment: str, *, straight: bool = False
) -> tuple[Interval, bool]:
    """Return an interval with its confidence limited by evidence, and whether it is natural motion.

    `terms` contains the evidence and `segment` is the segment of the chain. `straight` is True if
    the interval was found as an error of a straight limb.
    """
    found = judgement_of(terms, segment, straight=straight)
    least = halve_low_log_odds(min(interval.confidence or 0.0, found.probability))
    explain = partial(_with_judgement, interval.explain, found)
    left = interval.open or found.small
    return replace(interval, confidence=least, explain=explain, open=left), found.motion


def halve_low_log_odds(probability: float) -> float:
    """Halve the log odds of a probability below 0.5, because the doubts about an interval overlap.

    In a blind test on real captures, two judges regarded a third of the intervals with a
    probability of 0.07 as errors (docs/atlas.md).
    """
    if not 0.0 < probability < 0.5:
        return probability
    root = math.sqrt(probability / (1.0 - probability))
    return root / (1.0 + root)


def _with_judgement(
    explain: Callable[[], dict[str, Any]] | None, found: Judgement
) -> dict[str, Any]:
    """Return the evidence for an interval and the result of its judgement, keyed by name."""
    return {
        **(explain() if explain else {}),
        "evidence": found.score,
        "evidence_terms": dict(found.terms),
        "doubts": list(found.doubts),
        **({"small": True} if found.small else {}),
    }


def automatic_tau(counter: CounterRotation, row: int) -> float:
    """Return the automatic τ of a chain, max(1.5°, 6·median σ), in radians."""
    return max(SMALLEST_TAU, TAU_IN_SIGMA * median(counter.sigma[row]))


def _meet(interval: Interval, frames: tuple[int, int]) -> bool:
    return interval.start < frames[1] and frames[0] < interval.stop


def _shown_in_both(limb: CounterRotation, row: int, edges: Edges, k: int) -> bool:
    """Return True if parent and child rotate by similar angles at the edge with index `k`.

    Directions are ignored, because the sign of a rotation is meaningless near ±180°.
    """
    at = row, slice(edges.start[k], edges.stop[k])
    x, y = (abs(math.remainder(float(r[at].sum()), math.tau)) for r in (limb.rx, limb.ry))
    return min(x, y) >= SHOWN_IN_BOTH * max(x, y)


def _explained(
    limb: CounterRotation, row: int, edges: Edges, pair: Pair, course: Course
) -> dict[str, Any]:
    """Return the evidence for an interval, keyed by name, with angles in degrees."""
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
    """Return the evidence for an edge, keyed by name.

    Angles are sums over the frames of the edge, in degrees.
    """
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
