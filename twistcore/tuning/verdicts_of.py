"""What people have decided of clips, as evidence for a τ: one verdict an interval.

An accepted interval is an error, a rejected one is natural motion, an undecided one says nothing,
nor does one that was applied automatically or accepted with all the sure ones: nobody looked at it.
At which τ a detector finds what a verdict is about is asked of the detector itself, at every τ of
the grid.
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
from twistcore.review.left_out import joined_spans
from twistcore.review.model import APPLIED
from twistcore.skeleton.chain import uncorrectable_joints
from twistcore.skeleton.rig import skeleton_mark
from twistcore.tuning.cleaning import Verdicts
from twistcore.tuning.injected_curve import GRID
from twistcore.work.frozen import dataclass

SAME = 0.5  # of the frames of both: what is found there is the error that was accepted
_PERFORMER = re.compile(
    r"(?P<number>\d{1,3})_\d+|.*?(?P<word>(?:subject|performer|actor)[-_ ]?\d+)", re.IGNORECASE
)


@dataclass(frozen=True, eq=False)
class Verdict:
    """One interval that a person has decided.

    error: accepted; found: whether the detector finds it, by τ of the grid, (n,); confidence: the
    detector's own, None for one made by hand or where the detector has none; size: the largest
    offset, radians; by_hand: the detector had not listed it.
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
    """The verdicts of a clip, and whose it is.

    method: the detector whose intervals were listed; rig: mark of the skeleton; performer: '' where
    nobody knows; minutes: its length, without frames left out of tuning; reviewed: τ, radians, from
    which on intervals were listed, by chain, of those that a person has looked at; shares: of what
    was listed from there on in a chain, how much was decided, 1 where it is not said.
    """

    name: str
    method: str
    rig: str
    performer: str
    minutes: float
    reviewed: Mapping[str, float]
    verdicts: tuple[Verdict, ...]
    shares: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def looked_at(self) -> float:
        """How many chains, those that were decided in part by their share."""
        return sum(self.shares.get(chain, 1.0) for chain in self.reviewed)

    def of_chain(self, chain: str) -> JudgedClip:
        """What was decided of one chain."""
        return self.without(self.reviewed.keys() - {chain})

    def without(self, chains: Collection[str]) -> JudgedClip:
        """What was decided of the others: of these nobody has looked at anything."""
        verdicts = tuple(v for v in self.verdicts if v.chain not in chains)
        reviewed = {k: t for k, t in self.reviewed.items() if k not in chains}
        return replace(self, reviewed=reviewed, verdicts=verdicts)


def performer_of(name: str) -> str:
    """Who performs a clip, by its file's name: '05' of 05_03.bvh; '' where it does not say."""
    said = _PERFORMER.match(PurePath(name).stem)
    return (said["number"] or said["word"]) if said else ""


def judged_clip(
    analysis: ClipAnalysis, state: ReviewState, performer: str | None = None
) -> JudgedClip:
    """What a review says of its clip's chains, as evidence for the τ of its detector.

    performer: as the file's name says where none is given. Frames that were left out of tuning say
    nothing here either.
    """
    decided = _decided(state)
    detector = analysis.by(state.method)
    names = [c.name for c in analysis.chains if not uncorrectable_joints(analysis.motion, c)]
    verdicts = [v for n in names if n in decided for v in _told(detector, n, decided[n])]
    reviewed, shares = _looked_at(detector, state, [n for n in names if n in state.tau], verdicts)
    motion = analysis.motion
    spans = joined_spans(state.left_out)
    left_out = sum(max(min(stop, motion.frames) - start, 0) for start, stop in spans)
    return JudgedClip(
        analysis.name,
        state.method,
        skeleton_mark(motion.skeleton),
        performer_of(analysis.name) if performer is None else performer,
        (motion.frames - left_out) * motion.frame_time / 60.0,
        reviewed,
        tuple(verdicts),
        shares,
    )


def is_verdict(judged: Judged) -> bool:
    """Whether a person looked at a counter-twist and said what it is."""
    return (
        judged.decision != Decision.UNDECIDED
        and judged.verdict != APPLIED
        and not judged.in_bulk
        and judged.interval.kind == Kind.COUNTER_TWIST
    )


def said_in(state: ReviewState) -> Verdicts:
    """What a review calls right and wrong in its clip, for a τ to be tuned on the rest."""
    said = [j for j in state.intervals if is_verdict(j)]
    return Verdicts(
        errors=tuple(
            replace(j.interval, explain=None)  # its evidence would be asked for, to be sent
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
    """Whether it is a counter-twist of a chain there is, and not left out of tuning."""
    left_out = any(
        interval.start < stop and start < interval.stop for start, stop in state.left_out
    )
    return interval.kind == Kind.COUNTER_TWIST and interval.chain in state.tau and not left_out


def _decided(state: ReviewState) -> dict[str, list[Judged]]:
    out: dict[str, list[Judged]] = {}
    for judged in filter(is_verdict, state.intervals):
        if _counts(state, judged.interval):
            out.setdefault(judged.interval.chain, []).append(judged)
    return out


def _looked_at(
    detector: Analysis, state: ReviewState, names: Iterable[str], verdicts: Sequence[Verdict]
) -> tuple[dict[str, float], dict[str, float]]:
    """From which τ on each chain was looked at, and how much of what is listed there was decided.

    A chain in which something still waits was looked at down to the weakest that was decided: a
    lower τ alone is no look. One with nothing to decide was looked at once all others are done.
    """
    asked = [j for j in state.intervals if _counts(state, j.interval) and not is_verdict(j)]
    reviewed: dict[str, float] = {}
    shares: dict[str, float] = {}
    for name in names:
        own = [v for v in verdicts if v.chain == name]
        waiting = [j.interval for j in asked if j.interval.chain == name]
        # Listed, so that τ was no higher than this once.
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


def _told(detector: Analysis, chain: str, decided: Sequence[Judged]) -> Iterator[Verdict]:
    found = found_by_tau([j.interval for j in decided], _accepted(decided), detector, chain)
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


def found_by_tau(
    judged: Sequence[Interval], errors: Sequence[bool], detector: Analysis, chain: str
) -> Mask:
    """Which judged intervals of a chain a detector finds, by τ of the grid, (judged, n).

    What it finds belongs to the one that it shares most with. An error is found where these share
    half of their frames; natural motion raises an alarm wherever any of it is listed.
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


# -- of files -----------------------------------------------------------------------------------


def judged_in(
    clip: Path | Clip, session: Path | Session, performer: str | None = None
) -> JudgedClip:
    """The verdicts that a session holds of a clip; raises TwistError.

    A session of another version of the clip says nothing of this one: its frames may be others.
    """
    read = read_clip(clip) if isinstance(clip, Path) else clip
    kept = read_session(session) if isinstance(session, Path) else session
    of_this_version(read, kept)
    return judged_clip(analyse(read, rig=kept.state.rig), kept.state, performer)


def of_this_version(clip: Clip, session: Session) -> None:
    """Raise TwistError unless a session is of the clip as it is."""
    if session.sha256 != clip.sha256:
        raise TwistError(f"{clip.name}: its session belongs to another version of the clip")


def of_what_is_there(clip: Clip, session: Session) -> None:
    """Raise TwistError unless a session's detector is known and its intervals' chains are there."""
    state = session.state
    if state.method not in DETECTORS:
        known = " or ".join(sorted(DETECTORS))
        raise TwistError(f"{clip.name}: expected {known}, found {state.method!r} in its session")
    there = {chain.name for chain in state.rig.chains(clip.motion)}
    for name in (judged.interval.chain for judged in state.intervals):
        if name not in there:
            raise TwistError(f"{clip.name}: its session names a chain {name!r}, which is not there")


def count_verdicts(clips: Iterable[JudgedClip]) -> tuple[int, int]:
    """Errors and natural intervals that were decided."""
    said = [v.error for clip in clips for v in clip.verdicts]
    return sum(said), len(said) - sum(said)
