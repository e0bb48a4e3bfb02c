"""A clip with everything about it that does not change while it is reviewed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from inspector.language import of_core, tr
from inspector.session.rig_profiles import kept_rig
from inspector.session.session_files import kept_sessions, set_aside
from twistcore.analysis import clip_analysis as core
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Interval, Kind
from twistcore.detection.limb_flips import LimbFlips
from twistcore.errors import ClipMismatchError, FormatError, TwistError
from twistcore.export.exports_beside import REPLAY_SUFFIX
from twistcore.export.replay import chains_of
from twistcore.files.document_values import shown_words
from twistcore.files.marks import file_mark
from twistcore.files.ordinary import is_file
from twistcore.formats.clip import Clip
from twistcore.formats.reading import read_clip
from twistcore.review import Judged, Redetect, Review, ReviewState, Session
from twistcore.review.model import as_written
from twistcore.review.proposal import flip_over, interval_over, proposed_flip, proposed_interval
from twistcore.review.reasons import redetected_intervals
from twistcore.review.session import read_session_file
from twistcore.skeleton.chain import Chain, chain_notes, uncorrectable_joints
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.skeleton.rotation import Array
from twistcore.skeleton.signals import TwistSignals
from twistcore.tuning import Profile
from twistcore.work.progress import Tell, nobody, part


@dataclass(frozen=True)
class Stamp:
    """What changes with a file: seen at no cost, unlike its bytes."""

    modified: int  # nanoseconds
    size: int
    file: int  # its number in the file system


@dataclass(frozen=True, eq=False)
class Analysed:
    """A clip as it was opened: what is known of it, and the review that it begins with.

    session: the file that the review was read from, and its bytes' SHA-256; earlier: a review of
    another version of this clip; added: how many finds of kinds that the session did not
    know were added to it, None where it knew all; stamp: of the clip's file before it was read,
    None if it was in memory; blind: an exercise, in which what the detector knows is not told.
    """

    clip: Clip
    analysis: ClipAnalysis
    review: Review
    session: Path | None = None
    session_sha256: str = ""
    earlier: tuple[Judged, ...] = ()
    notes: tuple[str, ...] = ()
    added: int | None = None
    stamp: Stamp | None = None
    blind: bool = False

    @property
    def motion(self) -> Motion:
        """The motion as read."""
        return self.clip.motion

    @property
    def chains(self) -> tuple[Chain, ...]:
        """Its chains."""
        return self.analysis.chains

    @property
    def chains_and_limbs(self) -> tuple[Chain, ...]:
        """All that a person can select."""
        return self.analysis.chains_and_limbs

    def limb(self, name: str) -> LimbFlips | None:
        """What is known of a limb; None for the name of a chain."""
        return self.analysis.flips.limbs.get(name)

    def proposed(self, chain: str, frame: int) -> Interval:
        """An interval of a chain, or a flip of a limb, for a person to begin with."""
        if (limb := self.limb(chain)) is not None:
            return proposed_flip(limb, frame)
        return proposed_interval(chain, self.signals[chain], frame, self.motion.fps)

    def proposed_over(self, chain: str, start: int, stop: int) -> Interval:
        """One over [start, stop), as a person has drawn it."""
        if (limb := self.limb(chain)) is not None:
            return flip_over(limb, start, stop)
        return interval_over(chain, self.signals[chain], start, stop)

    def angle(self, chain: str) -> Array:
        """What an offset is taken out of, radians, (frames,): θp of a chain, φ of a limb."""
        limb = self.limb(chain)
        return self.signals[chain].theta_p if limb is None else limb.swivel.angle

    @property
    def signals(self) -> Mapping[str, TwistSignals]:
        """Signals of every chain by name."""
        return self.analysis.signals

    @property
    def rotations(self) -> Array:
        """Global rotations as captured, (frames, joints, 4)."""
        return self.analysis.poses[0]

    @property
    def positions(self) -> Array:
        """Positions as captured, (frames, joints, 3)."""
        return self.analysis.poses[1]


class ClipMissingError(TwistError):
    """A session whose clip is neither where it was nor beside the session."""

    def __init__(self, session: Path, clip: str) -> None:
        told = tr(
            "{session}: its clip {clip} is not where it was.",
            session=session.name,
            clip=shown_words(clip),
        )
        super().__init__(told)
        self.session = session


# Where the stages of a long clip end, shares of the whole.
_READ, _DETECTED = 0.1, 0.9


def analyse_file(path: Path, profile: Profile | None = None, tell: Tell = nobody) -> Analysed:
    """Read and analyse a clip, with the session kept of it; raises TwistError.

    profile: τ for a clip without a session, which has its own, as it has its own chains: else those
    kept of the rig; tell: how far it is. Safe to call in any thread.
    """
    sessions = kept_sessions(path)
    if not sessions:
        return _read(path, profile, tell)
    session, *older = sessions
    notes = [
        tr("Another session of {clip}, not the latest, is {path}.", clip=path.name, path=other)
        for other in older
    ]
    try:
        kept, sha256 = read_session_file(session)
    except TwistError as error:
        why = tr("{error}: its review is not shown.", error=of_core(str(error)))
        if isinstance(error, FormatError):
            why = set_aside(session, str(error))
        found, notes = _read(path, profile, tell), [*notes, why]
    else:
        found = _with_session(session, sha256, kept, path, tell)
    return replace(found, notes=(*notes, *found.notes))


def _read(
    path: Path, profile: Profile | None, tell: Tell, session: Session | None = None
) -> Analysed:
    """A clip with a review of its own; session: whose chains it gets, if the clip has such."""
    stamp = stamp_of(path)
    clip = read_clip(path, tell=part(tell, 0.0, _READ))
    rig, told = _rig_of(session, clip.motion)
    found = analyse_clip(clip, profile, part(tell, _READ, 1.0), rig)
    return replace(found, stamp=stamp, notes=(*((told,) if told else ()), *found.notes))


def _rig_of(session: Session | None, motion: Motion) -> tuple[Rig, str]:
    """The session's, else what is kept for the skeleton, and a sentence where that is damaged."""
    if session is not None:
        with suppress(TwistError):
            session.state.rig.chains(motion)
            return session.state.rig, ""
    return kept_rig(motion)


def _belongs(session: Session, clip: Clip) -> bool:
    try:
        chains_of(session, clip)
    except ClipMismatchError:
        return False
    return True


def analyse_clip(
    clip: Clip, profile: Profile | None = None, tell: Tell = nobody, rig: Rig = AS_FOUND
) -> Analysed:
    """Analyse a clip that is in memory already; tell: how far it is."""
    profile = profile or Profile({})
    method = profile.method or DEFAULT_METHOD
    notes: tuple[str, ...] = ()
    if DETECTORS.usable(method) != method:
        told = tr(
            "The detector '{name}', which {clip} was to be searched with, is not installed here: "
            "another one was used, at its own τ.",
            name=method,
            clip=clip.name,
        )
        method, profile, notes = DEFAULT_METHOD, Profile({}), (told,)
    tell(0.0)
    analysis = core.analyse(clip, rig=rig)
    analysis.by(method, part(tell, 0.0, _DETECTED))
    tell(_DETECTED)
    found = analysis.detect(method, tau_radians=profile.of(analysis.chains_and_limbs))
    # What views ask for first is made here, off the GUI thread: on a large clip it takes a while.
    _ = clip.sha256, analysis.poses, analysis.signals, analysis.reliability, analysis.notes
    return Analysed(clip, analysis, Review.of(found), notes=notes)


def analyse_session(path: Path, clip_path: Path | None = None, tell: Tell = nobody) -> Analysed:
    """The clip of a session with the session's review; raises TwistError.

    Without `clip_path` the clip is where it was when the session was saved, or beside the session.
    A clip that has changed gets a review of its own, and the session's as `earlier`. A session that
    replays an export is read, never written: its review goes on in the clip's own session. tell:
    how far it is.
    """
    session, sha256 = read_session_file(path)
    if clip_path is None:
        places = [Path(session.clip), path.parent / Path(session.clip).name]
        there = [p for p in places if is_file(p)]
        if not there:
            raise ClipMissingError(path, session.clip)
        same = (p for p in there if file_mark(p) == session.sha256)
        clip_path = next(same, there[0])
    return _with_session(path, sha256, session, clip_path, tell)


def _with_session(path: Path, sha256: str, session: Session, clip: Path, tell: Tell) -> Analysed:
    method = session.state.method
    found = _read(clip, Profile({}, DETECTORS.usable(method)), tell, session)
    if not _belongs(session, found.clip):
        return replace(found, earlier=session.state.intervals)
    own = found.review.state
    known = {name: t for name, t in session.state.tau.items() if name in own.tau}
    limbs = {limb.name for limb in found.analysis.limbs}
    tau = {name: t for name, t in own.tau.items() if name not in limbs} | known
    state = replace(session.state, tau=tau, chain_order=own.chain_order)
    if DETECTORS.usable(method) != method:
        found = replace(found, notes=(*found.notes, not_installed(method)))
    if told := of_later_kinds(state):
        found = replace(found, notes=(*found.notes, told))
    complete = with_every_kind(state, found.analysis)
    if complete is not state:
        added = len(complete.intervals) - len(state.intervals)
        found = replace(found, added=added)
    review = Review(complete)
    review.take_reasons(redetected_intervals(found.analysis, complete))
    if path.name.endswith(REPLAY_SUFFIX):
        review.mark_unsaved()  # in the clip's own session
        return replace(found, review=review)
    return replace(found, review=review, session=path, session_sha256=sha256)


def not_installed(method: str) -> str:
    """What is to be known of a review whose detector is not there."""
    return tr(
        "This review's intervals were found by the detector '{name}', which is not installed here: "
        "they can be judged and exported, while their τ stays until another detector is chosen.",
        name=method,
    )


def of_later_kinds(state: ReviewState) -> str:
    """A sentence on intervals of kinds that this version does not know; '' where there are none."""
    kinds = [j.interval.kind for j in state.intervals if not j.interval.kind.known]
    if not kinds:
        return ""
    return tr(
        "{n} of the intervals are of kinds that only a later version of the program knows "
        "({kinds}): they are shown and kept as they are.",
        n=len(kinds),
        kinds=", ".join(sorted(set(kinds))),
    )


def with_every_kind(state: ReviewState, analysis: ClipAnalysis) -> ReviewState:
    """A review with what it knows nothing of, undecided.

    Limbs at their own τ, their flips and lone jumps where it knows no limbs; noise bursts and
    frozen frames where it has none of the kind. The very same review where nothing is new.
    """
    return _with_faults(_with_limbs(state, analysis), analysis)


def _with_faults(state: ReviewState, analysis: ClipAnalysis) -> ReviewState:
    """A review with the faults of the capture of each kind of which it has no interval."""
    known = {judged.interval.kind for judged in state.intervals}
    there, method = set(state.tau), DETECTORS.usable(state.method)
    new = [
        fault
        for kind in Kind
        if kind.of_capture and kind.info.find and kind not in known
        for chain, own in analysis.shown(kind, method).items()
        for fault in own
        if chain in there
    ]
    return _with_undecided(state, new) if new else state


def _with_undecided(state: ReviewState, new: Sequence[Interval]) -> ReviewState:
    judged = [Judged(k, as_written(i)) for k, i in enumerate(new, state.next_id)]
    return state.with_intervals((*state.intervals, *judged), state.next_id + len(judged))


def _with_limbs(state: ReviewState, analysis: ClipAnalysis) -> ReviewState:
    new = [limb.name for limb in analysis.limbs if limb.name not in state.tau]
    if not new:
        return state
    order = {chain.name: k for k, chain in enumerate(analysis.chains_and_limbs)}
    tau = {name: analysis.flips.automatic_tau(name) for name in new}
    found = tuple(i for name, t in tau.items() for i in analysis.flips.intervals(name, t))
    state = Redetect(tau, found).apply(replace(state, chain_order=order))
    jumps = [i for own in analysis.jumps(DETECTORS.usable(state.method)).values() for i in own]
    return _with_undecided(state, jumps)


def opening_notes(
    data: Analysed, away: Path | None, notes: Sequence[str]
) -> Iterator[tuple[str, bool]]:
    """What a person is told of a clip that has just been opened: sentences, and if one is bad.

    away: where its review is kept, if not beside it; notes: on taking that up.
    """
    if data.session is not None:
        told = tr("Going on with {session}.", session=data.session.name)
        if data.added is not None:
            found = tr("{n} found, undecided", n=data.added) if data.added else tr("none found")
            told += " " + tr(
                "Kinds of finds of which it knew nothing were looked for as well: {found}.",
                found=found,
            )
        yield told, False
    if rig := data.analysis.rig:
        yield tr("Chains of this rig: {summary}.", summary=of_core(rig.summary())), False
    name, notices = data.clip.name, []
    if away is not None:
        told = tr(
            "{name} lies in a folder that cannot be written: your decisions are kept in {folder}.",
            name=name,
            folder=away,
        )
        notices.append(told)
    warned = (*map(str, data.clip.warnings), *map(str, data.analysis.notes))
    warned = (*warned, *chain_notes(data.chains_and_limbs))
    notices += [f"{name}: {of_core(w)}" for w in warned]
    motion, every = data.motion, data.chains_and_limbs
    stuck = [of_core(c.label) for c in every if uncorrectable_joints(motion, c, carried=True)]
    if stuck:
        told = tr(
            "{chains}: shown but not corrected, for want of rotation channels.",
            chains=", ".join(stuck),
        )
        notices.append(told)
    lasting = [*data.notes, *notes]
    if notices:
        told = " ".join(notices[:3])
        if len(notices) > 3:
            told += " " + tr("(and {n} more: see the chains)", n=len(notices) - 3)
        if data.clip.missing_frames:  # part of the capture is not here: shown until it is closed
            lasting.insert(0, told)
        else:
            yield told, False
    if lasting:
        yield " ".join(lasting), True


def stamp_of(path: Path) -> Stamp | None:
    """The file's stamp; None for one that is not there."""
    try:
        status = path.stat()
    except OSError:
        return None
    return Stamp(status.st_mtime_ns, status.st_size, status.st_ino)


def what_changed(clip: Clip, then: Stamp | None, now: Stamp | None) -> str:
    """A sentence if the file's bytes are no longer the clip's, else ''.

    then: the stamp with which it was read. The bytes are compared only where the stamps differ.
    """
    if now == then:
        return ""
    if now is None:
        return tr("{clip} is no longer where it was; what is open stays as it is.", clip=clip.name)
    try:
        same = file_mark(clip.path) == clip.sha256
    except OSError as error:
        why = of_core(str(error.strerror))
        return tr("{clip} can no longer be read ({why}).", clip=clip.name, why=why)
    return "" if same else tr("{clip} has changed on disk since it was opened.", clip=clip.name)
