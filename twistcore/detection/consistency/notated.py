"""The analysis of clips with held frames or linear keys by the consistency detector.

Held frames are removed, so that an error begins in the frame in which it appears. A clip with
linear keys is analysed twice. First, all frames are searched for errors that jump from one frame to
the next. Then only the keys are analysed, because the frames in between were not captured. All
results are converted to the frame numbers of the clip.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from functools import partial
from typing import Any

import numpy as np

from twistcore.detection.consistency.chain_analysis import ConsistencyAnalysis
from twistcore.detection.interval import Interval
from twistcore.skeleton.notation import DistinctFrames
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

CLEAR = 0.5  # minimum confidence of a clear interval


@dataclass(frozen=True, eq=False)
class NotatedAnalysis:
    """The analysis of a clip in which only some frames are examined.

    Attributes
    ----------
    kept
        The examined frames.
    coarse
        The analysis of the examined frames.
    fine
        The analysis of jumps in all frames; None if the clip has held frames.
    """

    kept: DistinctFrames
    coarse: ConsistencyAnalysis
    fine: ConsistencyAnalysis | None = None
    _known: dict[Interval, Interval] = field(default_factory=dict)  # a cache

    def detached(self) -> NotatedAnalysis:
        """Return the analysis without references to the motion, except for the examined frames."""
        fine = self.fine and self.fine.detached()
        return replace(self, coarse=self.coarse.detached(), fine=fine)

    def automatic_tau(self, chain: str) -> float:
        """Return the automatic τ of a chain, in radians.

        This is the larger τ of the two analyses, and at least `kept.smallest`.
        """
        both = (a.automatic_tau(chain) for a in (self.coarse, self.fine) if a is not None)
        return max(self.kept.smallest, *both)

    def strength(self, chain: str) -> Array:
        """Return the strength of a chain, in radians ≥ 0, (frames,).

        If there are two analyses, the strength in each frame is the larger of the two values.
        """
        curve = np.zeros(self.kept.frames)
        curve[self.kept.first] = self.coarse.strength(chain)
        return curve if self.fine is None else np.maximum(curve, self.fine.strength(chain))

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of a chain at threshold τ in radians, sorted by start.

        Clear jumps take priority over the intervals between keys.
        """
        found = [self._in_clip(i) for i in self.coarse.intervals(chain, tau)]
        if self.fine is not None:
            sharp = self.fine.intervals(chain, tau)
            clear = [i for i in sharp if has_priority_in_interval_overlap(i)]
            found = [*clear, *(i for i in found if not any(_meet(i, s) for s in clear))]
            found += (i for i in sharp if not any(_meet(i, s) for s in found))
        return tuple(sorted(found, key=lambda i: (i.start, i.stop)))

    @property
    def left(self) -> dict[str, tuple[tuple[int, int], ...]]:
        """The frames [low, high) that were not searched for soft errors, keyed by chain name."""
        begin, end = self.kept.begin, self.kept.end
        return {
            name: tuple((begin(low), end(high)) for low, high in spans)
            for name, spans in self.coarse.left.items()
        }

    def _in_clip(self, interval: Interval) -> Interval:
        """Convert an interval of the examined frames to frame numbers of the clip."""
        if interval not in self._known:
            start, stop = self.kept.begin(interval.start), self.kept.end(interval.stop)
            explain = interval.explain and partial(_explained, self.kept, interval)
            self._known[interval] = replace(
                interval,
                open=interval.open or self._not_automatic(interval),
                start=start,
                stop=stop,
                offset=self.kept.spread(interval.start, interval.offset),
                explain=explain,
            )
        return self._known[interval]

    def _not_automatic(self, interval: Interval) -> bool:
        """Return True if the interval must not be corrected automatically.

        This is the case if there are too few linear keys, or if the evidence is a single transition
        of a straight limb.
        """
        if not self.kept.even:
            return False
        return self.kept.too_few or "transition" in (interval.evidence or {})


def has_priority_in_interval_overlap(interval: Interval) -> bool:
    """Return True if an interval is certain enough to take priority over overlapping ones."""
    return not interval.open and (interval.confidence or 0.0) >= CLEAR


def _meet(one: Interval, other: Interval) -> bool:
    return one.start < other.stop and other.start < one.stop


def _explained(kept: DistinctFrames, interval: Interval) -> dict[str, Any]:
    """Return the evidence for an interval, with its frame numbers converted to the clip."""
    evidence = dict(interval.evidence or {})
    if "transition" in evidence:
        evidence["transition"] = kept.end(evidence["transition"])
    if "edges" in evidence:
        evidence["edges"] = [_edge(kept, edge) for edge in evidence["edges"]]
    return evidence


def _edge(kept: DistinctFrames, edge: Mapping[str, Any]) -> dict[str, Any]:
    """Convert the frame numbers of an edge in the evidence to frame numbers of the clip.

    The edge ends at the first examined frame that shows the full change.
    """
    start, stop = kept.begin(edge["start"]), kept.end(edge["stop"] - 1) + 1
    return {**edge, "start": start, "stop": stop}
