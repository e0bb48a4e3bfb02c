"""Why intervals were found, told again of those that come from a file, which keeps no reasons."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import Interval, Kind
from twistcore.review.model import Judged, ReviewState


def redetected_intervals(analysis: ClipAnalysis, state: ReviewState) -> tuple[Interval, ...]:
    """What the detector finds at a review's τ.

    Nothing long is started: of chains that this detector was not asked about, nothing is found.
    """
    # A review may be by a detector that is not installed here, or fails on the clip.
    method = analysis.usable(state.method)
    ready = method == state.method and analysis.kept(method) is not None
    detector = analysis.detector(method, frozenset(Kind) if ready else {Kind.LIMB_FLIP})
    there = {chain.name for chain in analysis.chains_and_limbs}
    return tuple(i for n, t in state.tau.items() if n in there for i in detector.intervals(n, t))


def with_reasons(found: Iterable[Interval]) -> Callable[[ReviewState], ReviewState]:
    """What gives a review the reasons of the found intervals of the same chain, kind and frames.

    An interval that knows its own keeps it, and one made by hand has none. The same state and the
    same interval are made the same one each time; what has nothing to get is returned as it is.
    """
    known = {_place(i): i.explain for i in found if i.explain is not None}
    states: dict[ReviewState, ReviewState] = {}
    told: dict[Judged, Judged] = {}

    def tell(judged: Judged) -> Judged:
        interval = judged.interval
        reason = known.get(_place(interval))
        if judged.by_hand or interval.explain is not None or reason is None:
            return judged
        if judged not in told:
            told[judged] = replace(judged, interval=replace(interval, explain=reason))
        return told[judged]

    def change(state: ReviewState) -> ReviewState:
        if state not in states:
            intervals = tuple(map(tell, state.intervals))
            same = all(a is b for a, b in zip(intervals, state.intervals, strict=True))
            states[state] = state if same else replace(state, intervals=intervals)
        return states[state]

    return change


def _place(interval: Interval) -> tuple[str, Kind, str, int, int]:
    return interval.chain, interval.kind, interval.joint, interval.start, interval.stop
