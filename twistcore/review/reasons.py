"""Restore the evidence of the intervals in a session, since session files do not store evidence."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import Interval, Kind
from twistcore.review.model import Judged, ReviewState


def intervals_detected_at_review_tau(
    analysis: ClipAnalysis, state: ReviewState
) -> tuple[Interval, ...]:
    """Return the intervals that the review's detector finds at the review's τ.

    Chains that the detector has not examined yet are skipped, so the function returns quickly.
    """
    # The review's detector may be missing, or it may fail on the clip.
    method = analysis.usable(state.method)
    ready = method == state.method and analysis.kept(method) is not None
    detector = analysis.detector(method, frozenset(Kind) if ready else {Kind.LIMB_FLIP})
    there = {chain.name for chain in analysis.chains_and_limbs}
    return tuple(i for n, t in state.tau.items() if n in there for i in detector.intervals(n, t))


def make_evidence_adder(found: Iterable[Interval]) -> Callable[[ReviewState], ReviewState]:
    """Return a function that adds the evidence of detected intervals to the intervals of a state.

    An interval gets the evidence of an interval in `found` with the same chain, kind, joint and
    frames. Intervals that already have evidence or were made by hand do not change. If the function
    is called again with the same state, it returns the same object. If there is nothing to add, it
    returns the state unchanged.
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
