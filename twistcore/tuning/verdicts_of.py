"""Collect reviewers' verdicts on clips as evidence for choosing τ.

An accepted interval is an error, and a rejected interval is natural motion. The following intervals
are not used as evidence:

- undecided intervals
- intervals that were corrected automatically, or accepted together with all other confident ones,
  because nobody examined them

For each verdict, the detector is run at every τ of the grid to see at which τ it finds the
interval.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from pathlib import Path, PurePath
from types import MappingProxyType

import numpy as np

from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.detection import DETECTORS, Analysis, Interval, Kind
from twistcore.detection.prediction import Mask
from twistcore.errors import TwistError
from twistcore.formats.clip import Clip
from twistcore.formats.reading import read_clip
from twistcore.review import Decision, Judged, ReviewState, Session, read_session
from twistcore.review.kind_verdicts import KindVerdict, verdicts_with_kinds
from twistcore.review.left_out import joined_spans
from twistcore.review.model import APPLIED
from twistcore.skeleton.chain import uncorrectable_joints
from twistcore.skeleton.rig import skeleton_hash
from twistcore.tuning.cleaning import Verdicts
from twistcore.tuning.injected_curve import GRID
from twistcore.work.frozen import dataclass

SAME = 0.5  # minimum fraction of common frames if a detection and an error are the same
_PERFORMER = re.compile(
    r"(?P<number>\d{1,3})_\d+|.*?(?P<word>(?:subject|performer|actor)[-_ ]?\d+)", re.IGNORECASE
)


@dataclass(frozen=True, eq=False)
class Verdict:
    """A person's verdict on one interval.

    Attributes
    ----------
    chain, start, stop
        The interval's chain and frames [start, stop).
    error
        True if the interval was accepted.
    found
        Mask of the grid's τ at which the detector finds the interval, shape (n,).
    confidence
        The detector's confidence, or None if the interval was made by hand or has no confidence.
    size
        The largest |δ| of the interval, in radians.
    by_hand
        True if a person inserted the interval.
    """

    chain: str
    start: int
    stop: int
    error: bool
    found: Mask
    confidence: float | None
    size: float
    by_hand: bool = False


@dataclass(frozen=True, eq=False)
class JudgedClip:
    """The verdicts on a clip, with its rig and performer.

    Attributes
    ----------
    name
        The clip's name.
    method
        The detector whose intervals were judged.
    rig
        A string that identifies the skeleton.
    performer
        Name of the performer, '' if unknown.
    minutes
        The clip's duration in minutes, without frames that are excluded from tuning.
    reviewed
        The lowest τ, in radians, at which each reviewed chain was examined, keyed by chain name.
    verdicts
        The verdicts.
    shares
        The fraction of intervals of each reviewed chain that have been judged, keyed by chain name.
        For a missing chain, the fraction is 1.
    of_kinds
        A verdict for each interval of any kind, including those without a decision.
    """

    name: str
    method: str
    rig: str
    performer: str
    minutes: float
    reviewed: Mapping[str, float]
    verdicts: tuple[Verdict, ...]
    shares: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    of_kinds: tuple[KindVerdict, ...] = ()

    @property
    def reviewed_chains(self) -> float:
        """Return the number of reviewed chains. A partly reviewed chain counts as a fraction."""
        return sum(self.shares.get(chain, 1.0) for chain in self.reviewed)

    def of_chain(self, chain: str) -> JudgedClip:
        """Return a copy with only the verdicts on one chain."""
        return self.without(self.reviewed.keys() - {chain})

    def without(self, chains: Collection[str]) -> JudgedClip:
        """Return a copy without verdicts on the given chains, as if nobody had reviewed them."""
        verdicts = tuple(v for v in self.verdicts if v.chain not in chains)
        reviewed = {k: t for k, t in self.reviewed.items() if k not in chains}
        return replace(self, reviewed=reviewed, verdicts=verdicts)


def performer_of_clip(name: str) -> str:
    """Return the performer named in a clip's file name, such as '05' for 05_03.bvh, or ''."""
    said = _PERFORMER.match(PurePath(name).stem)
    return (said["number"] or said["word"]) if said else ""


def judged_clip_from_review(
    analysis: ClipAnalysis, state: ReviewState, performer: str | None = None
) -> JudgedClip:
    """Return the verdicts of a review, with the τ at which its detector finds each interval.

    `performer` is the name of the performer; by default, it is derived from the file name.
    Intervals in frames that are excluded from tuning are ignored.
    """
    decided = _decided(state)
    detector = analysis.by(state.method)
    names = [c.name for c in analysis.chains if not uncorrectable_joints(analysis.motion, c)]
    verdicts = [v for n in names if n in decided for v in _verdicts(detector, n, decided[n])]
    reviewed, shares = _reviewed(detector, state, [n for n in names if n in state.tau], verdicts)
    motion = analysis.motion
    spans = joined_spans(state.left_out)
    left_out = sum(max(min(stop, motion.frames) - start, 0) for start, stop in spans)
    return JudgedClip(
        analysis.name,
        state.method,
        skeleton_hash(motion.skeleton),
        performer_of_clip(analysis.name) if performer is None else performer,
        (motion.frames - left_out) * motion.frame_time / 60.0,
        reviewed,
        tuple(verdicts),
        shares,
        verdicts_with_kinds(state),
    )


def is_judged_counter_twist(judged: Judged) -> bool:
    """Return True if the interval is a counter-twist that a person examined and decided on.

    Automatic corrections and intervals that were accepted in bulk are excluded.
    """
    return (
        judged.decision != Decision.UNDECIDED
        and judged.verdict != APPLIED
        and not judged.in_bulk
        and judged.interval.kind == Kind.COUNTER_TWIST
    )


def counter_twist_verdicts_of_review(state: ReviewState) -> Verdicts:
    """Return the accepted intervals and the spans of rejected intervals of a review."""
    said = [j for j in state.intervals if is_judged_counter_twist(j)]
    return Verdicts(
        errors=tuple(
            # Pickling an interval with `explain` would first compute its evidence.
            replace(j.interval, explain=None)
            for j in said
            if j.decision == Decision.ACCEPTED
        ),
        natural=tuple(
            (j.interval.chain, j.interval.start, j.interval.stop)
            for j in said
            if j.decision == Decision.REJECTED
        ),
    )


def _counts(state: ReviewState, interval: Interval) -> bool:
    """Return True if the interval is a counter-twist of an existing chain, in frames for tuning."""
    left_out = any(
        interval.start < stop and start < interval.stop for start, stop in state.left_out
    )
    return interval.kind == Kind.COUNTER_TWIST and interval.chain in state.tau and not left_out


def _decided(state: ReviewState) -> dict[str, list[Judged]]:
    out: dict[str, list[Judged]] = {}
    for judged in filter(is_judged_counter_twist, state.intervals):
        if _counts(state, judged.interval):
            out.setdefault(judged.interval.chain, []).append(judged)
    return out


def _reviewed(
    detector: Analysis, state: ReviewState, names: Iterable[str], verdicts: Sequence[Verdict]
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the lowest τ at which each chain was reviewed, and the fraction of judged intervals.

    If a chain has undecided intervals, its weakest judged interval determines the lowest τ, since
    lowering τ alone does not mean that anybody reviewed the chain. A chain without intervals counts
    as reviewed when no interval of any other chain is undecided.
    """
    asked = [
        j for j in state.intervals if _counts(state, j.interval) and not is_judged_counter_twist(j)
    ]
    reviewed: dict[str, float] = {}
    shares: dict[str, float] = {}
    for name in names:
        own = [v for v in verdicts if v.chain == name]
        waiting = [j.interval for j in asked if j.interval.chain == name]
        # A listed interval shows that τ was once at or below the largest τ that finds it.
        weakest = [
            float(GRID[np.flatnonzero(v.found)[-1]]) for v in own if not v.by_hand and v.found.any()
        ]
        if own and not waiting:
            reviewed[name] = min([state.tau[name], *weakest])
        elif own:
            tau = reviewed[name] = min(weakest, default=state.tau[name])
            listed = detector.intervals(name, tau)
            left = sum(any(_meet(i, found) for found in listed) for i in waiting)
            shares[name] = len(own) / (len(own) + left)
        elif verdicts and not asked:
            reviewed[name] = state.tau[name]
    return reviewed, shares


def _meet(one: Interval, other: Interval) -> bool:
    return one.start < other.stop and other.start < one.stop


def _verdicts(detector: Analysis, chain: str, decided: Sequence[Judged]) -> Iterator[Verdict]:
    found = judged_intervals_found_per_tau(
        [j.interval for j in decided], _accepted(decided), detector, chain
    )
    for judged, by_tau in zip(decided, found, strict=True):
        interval = judged.interval
        yield Verdict(
            chain,
            interval.start,
            interval.stop,
            judged.decision == Decision.ACCEPTED,
            by_tau,
            None if judged.by_hand else interval.confidence,
            abs(interval.largest),
            judged.by_hand,
        )


def _accepted(decided: Sequence[Judged]) -> list[bool]:
    return [j.decision == Decision.ACCEPTED for j in decided]


def judged_intervals_found_per_tau(
    judged: Sequence[Interval], errors: Sequence[bool], detector: Analysis, chain: str
) -> Mask:
    """Return a mask of the τ at which each judged interval is found, shape (judged, n).

    A detection belongs to the interval with which it shares the largest fraction of frames. An
    error counts as found if this fraction is at least a half. Natural motion counts as found if any
    of its frames is detected.

    Parameters
    ----------
    judged
        The intervals.
    errors
        True for each interval that is an error, False for natural motion.
    detector
        The detector applied to the clip.
    chain
        Name of the chain.
    """
    out = np.zeros((len(judged), len(GRID)), dtype=bool)
    start = np.array([i.start for i in judged])
    stop = np.array([i.stop for i in judged])
    least = np.where(errors, SAME, 1e-9)
    for k, tau in enumerate(GRID):
        for i in detector.intervals(chain, float(tau)):
            common = np.minimum(stop, i.stop) - np.maximum(start, i.start)
            share = np.maximum(common, 0) / (np.maximum(stop, i.stop) - np.minimum(start, i.start))
            best = int(share.argmax())
            if share[best] >= least[best]:
                out[best, k] = True
    return out


# -- verdicts in files --------------------------------------------------------------------------


def read_judged_clip(
    clip: Path | Clip, session: Path | Session, performer: str | None = None
) -> JudgedClip:
    """Read a clip and a session file, and return the verdicts on the clip.

    Raises TwistError if a file cannot be read, or if the session was made for another version of
    the clip, since the frames may differ.
    """
    read = read_clip(clip) if isinstance(clip, Path) else clip
    kept = read_session(session) if isinstance(session, Path) else session
    check_session_matches_clip(read, kept)
    return judged_clip_from_review(analyse(read, rig=kept.state.rig), kept.state, performer)


def check_session_matches_clip(clip: Clip, session: Session) -> None:
    """Raise TwistError unless a session was made for the clip's current content."""
    if session.sha256 != clip.sha256:
        raise TwistError(f"{clip.name}: its session belongs to another version of the clip")


def check_session_detector_and_chains(clip: Clip, session: Session) -> None:
    """Raise TwistError if a session's detector or a chain of its intervals does not exist."""
    state = session.state
    if state.method not in DETECTORS:
        known = " or ".join(sorted(DETECTORS))
        raise TwistError(
            f"{clip.name}: expected a session of the detector {known}, found {state.method!r}"
        )
    there = {chain.name for chain in state.rig.chains(clip.motion)}
    for name in (judged.interval.chain for judged in state.intervals):
        if name not in there:
            raise TwistError(
                f"{clip.name}: its session has a chain {name!r}, which the clip does not have"
            )


def count_accepted_and_rejected_intervals(clips: Iterable[JudgedClip]) -> tuple[int, int]:
    """Return the total number of accepted and of rejected intervals in all clips."""
    said = [v.error for clip in clips for v in clip.verdicts]
    return sum(said), len(said) - sum(said)
