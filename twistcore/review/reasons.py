"""Restore the evidence for the intervals of a session, since session files do not store it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import Interval, Kind
from twistcore.review.model import Judged, ReviewState


def redetected_intervals(analysis: ClipAnalysis, state: ReviewState) -> tuple[Interval, ...]:
    """Return the intervals that the detector finds at a review's τ.

    No long computation is started. Chains that the detector has not processed yet are left out.
    """
    # The review's detector may be missing, or it may fail on the clip.
    method = analysis.usable(state.method)
    ready = method == state.method and analysis.kept(method) is not None
    detector = analysis.detector(method, frozenset(Kind) if ready else {Kind.LIMB_FLIP})
    there = {chain.name for chain in analysis.chains_and_limbs}
    return tuple(i for n, t in state.tau.items() if n in there for i in detector.intervals(n, t))


def with_reasons(found: Iterable[Interval]) -> Callable[[ReviewState], ReviewState]:
    """Return a function that adds evidence to the intervals of a review.

    The evidence comes from intervals in `found` with the same chain, kind and frames. Existing
    evidence is kept, and no evidence is added to an interval made by hand. Repeated calls with the
    same state return the same objects. If there is nothing to add, the state is returned unchanged.
    """
    known = {_place(i): i.explain for i in found if i.explain is not None}
    states: dict[ReviewState, ReviewState] = {}
    changed: dict[Judged, Judged] = {}

    def explained(judged: Judged) -> Judged:
        interval = judged.interval
        reason = known.get(_place(interval))
        if judged.by_hand or interval.explain is not None or reason is None:
            return judged
        if judged not in changed:
            changed[judged] = replace(judged, interval=replace(interval, explain=reason))
        return changed[judged]

    def change(state: ReviewState) -> ReviewState:
        if state not in states:
            intervals = tuple(map(explained, state.intervals))
            same = all(a is b for a, b in zip(intervals, state.intervals, strict=True))
            states[state] = state if same else replace(state, intervals=intervals)
        return states[state]

    return change


def _place(interval: Interval) -> tuple[str, Kind, str, int, int]:
    return interval.chain, interval.kind, interval.joint, interval.start, interval.stop
