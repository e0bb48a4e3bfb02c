"""Read and analyse a clip, and compute the data that stay the same during a review."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.failing_detector import (
    redetect_or_give_up,
    replaced_detector_message,
    unusable_detector_message,
)
from inspector.session.rig_profiles import load_rig_profile
from inspector.session.session_files import find_existing_sessions, rename_damaged
from twistcore.analysis import clip_analysis as core
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Interval, Kind
from twistcore.detection.limb_flips import LimbFlips
from twistcore.errors import ClipMismatchError, FormatError, TwistError
from twistcore.export.exported_clips import REPLAY_SUFFIX
from twistcore.files.document_values import shorten_foreign_message
from twistcore.files.marks import cached_sha256, find_file_by_sha256
from twistcore.formats.clip import Clip
from twistcore.formats.reading import read_clip
from twistcore.review import Judged, Redetect, Review, ReviewState, Session
from twistcore.review.proposal import (
    interval_with_proposed_offset,
    propose_error_at_jump,
    propose_limb_flip_at_frame,
    propose_limb_flip_in_frames,
    proposed_interval,
)
from twistcore.review.replay import session_chains
from twistcore.review.session import read_session_with_hash
from twistcore.skeleton.chain import Chain, chain_warnings, uncorrectable_joints
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.skeleton.rotation import Array
from twistcore.skeleton.signals import TwistSignals
from twistcore.tuning import Profile
from twistcore.work.progress import Tell, ignore_progress, stage_progress


@dataclass(frozen=True)
class Stamp:
    """A file's time, size and inode, used to detect changes without reading the file."""

    modified: int  # nanoseconds
    size: int
    file: int  # the inode


@dataclass(frozen=True, eq=False)
class Analysed:
    """A clip as it was opened, with its analysis and its initial review.

    Attributes
    ----------
    session, session_sha256
        The session file from which the review was read, and its SHA-256.
    earlier
        The intervals of a session for another version of this clip.
    notes
        Sentences to show when the clip is opened.
    added
        The number of intervals added because their kinds of error are newer than the session; None
        if the session already had all kinds.
    stamp
        The stamp of the clip's file before the clip was read; None for a clip in memory.
    blind
        True in an exercise, in which the detector is switched off.
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
        """The motion of the clip."""
        return self.clip.motion

    @property
    def chains(self) -> tuple[Chain, ...]:
        """The chains of the clip."""
        return self.analysis.chains

    @property
    def chains_and_limbs(self) -> tuple[Chain, ...]:
        """Return all chains and limbs of the clip."""
        return self.analysis.chains_and_limbs

    def limb(self, name: str) -> LimbFlips | None:
        """Return the flips of the limb with this name, or None if a chain has this name."""
        return self.analysis.flips.limbs.get(name)

    def proposed(self, chain: str, frame: int) -> Interval:
        """Return a proposed interval of a chain or limb around a frame."""
        if (limb := self.limb(chain)) is not None:
            return propose_limb_flip_at_frame(limb, frame)
        return proposed_interval(chain, self.signals[chain], frame, self.motion.fps)

    def proposed_at(
        self, jump: Interval, others: Iterable[Interval], method: str
    ) -> Interval | None:
        """Propose an interval that begins or ends at a jump, or return None.

        `others` are all other intervals of the clip, and `method` is the detector.
        """
        return propose_error_at_jump(self.analysis.search(method), jump, others)

    def proposed_over(self, chain: str, start: int, stop: int) -> Interval:
        """Return a proposed interval over the frames [start, stop)."""
        if (limb := self.limb(chain)) is not None:
            return propose_limb_flip_in_frames(limb, start, stop)
        return interval_with_proposed_offset(chain, self.signals[chain], start, stop)

    def angle(self, chain: str) -> Array:
        """Return the angle in radians, (frames,), to which the offsets of a chain or limb apply.

        This is the twist θp for a chain and the swivel angle φ for a limb.
        """
        limb = self.limb(chain)
        return self.signals[chain].theta_p if limb is None else limb.swivel.angle

    @property
    def signals(self) -> Mapping[str, TwistSignals]:
        """The twist signals of every chain, keyed by chain name."""
        return self.analysis.signals

    @property
    def rotations(self) -> Array:
        """The global rotations as captured: quaternions, (frames, joints, 4)."""
        return self.analysis.poses[0]

    @property
    def positions(self) -> Array:
        """The global joint positions as captured, (frames, joints, 3)."""
        return self.analysis.poses[1]


class ClipMissingError(TwistError):
    """Raised if a session's clip is neither at its old path nor next to the session."""

    def __init__(self, session: Path, clip: str) -> None:
        message = tr(
            "The clip {clip}, which belongs to {session}, was not found. Locate the clip.",
            session=session.name,
            clip=shorten_foreign_message(clip),
        )
        super().__init__(message)
        self.session = session


Seen = Callable[[Clip], object]  # called with a clip when it has been read


def _ignore(_clip: Clip) -> None:
    """Do nothing with the clip."""


# The progress after reading and after detection.
_READ, _DETECTED = 0.1, 0.9


def analyse_file(
    path: Path, profile: Profile | None = None, tell: Tell = ignore_progress, seen: Seen = _ignore
) -> Analysed:
    """Read a clip and its latest session, and analyse the clip. Raises TwistError. Thread-safe.

    The session determines τ and the chains. If there is no session, τ is read from `profile` and
    the chains from the stored rig of the skeleton. `tell` is called with the progress, and `seen`
    with the clip when it has been read.
    """
    sessions = find_existing_sessions(path)
    if not sessions:
        return _read(path, profile, tell, seen=seen)
    session, *older = sessions
    notes = [
        tr("There is also an older session for {clip}: {path}.", clip=path.name, path=other)
        for other in older
    ]
    try:
        kept, sha256 = read_session_with_hash(session)
    except TwistError as error:
        why = tr(
            "The review of this clip cannot be shown. {error}.",
            error=translate_core_sentence(str(error)),
        )
        if isinstance(error, FormatError):
            why = rename_damaged(session, str(error))
        found, notes = _read(path, profile, tell, seen=seen), [*notes, why]
    else:
        found = _with_session(session, sha256, kept, path, tell, seen)
    return replace(found, notes=(*notes, *found.notes))


def _read(
    path: Path,
    profile: Profile | None,
    tell: Tell,
    session: Session | None = None,
    seen: Seen = _ignore,
) -> Analysed:
    """Read and analyse a clip and start a new review.

    If the chains of `session` fit the clip, they are used. `seen` is called with the clip when it
    has been read.
    """
    stamp = stamp_of(path)
    clip = read_clip(path, tell=stage_progress(tell, 0.0, _READ))
    seen(clip)
    rig, message = _rig_of(session, clip.motion)
    found, missing = _searched(clip, profile, stage_progress(tell, _READ, 1.0), rig)
    if missing and session is None:
        found = replace(found, notes=(replaced_detector_message(found.analysis, missing),))
    return replace(found, stamp=stamp, notes=(*((message,) if message else ()), *found.notes))


def _rig_of(session: Session | None, motion: Motion) -> tuple[Rig, str]:
    """Return the session's rig if it fits the motion; if not, the rig stored for the skeleton.

    The second result is a message if the stored rig cannot be used, or ''.
    """
    if session is not None:
        with suppress(TwistError):
            session.state.rig.chains(motion)
            return session.state.rig, ""
    return load_rig_profile(motion)


def _belongs(session: Session, clip: Clip) -> bool:
    try:
        session_chains(session, clip)
    except ClipMismatchError:
        return False
    return True


def analyse_clip(clip: Clip, profile: Profile | None = None) -> Analysed:
    """Analyse a clip that has already been read."""
    found, missing = _searched(clip, profile, ignore_progress, AS_FOUND)
    return (
        replace(found, notes=(replaced_detector_message(found.analysis, missing),))
        if missing
        else found
    )


def _searched(clip: Clip, profile: Profile | None, tell: Tell, rig: Rig) -> tuple[Analysed, str]:
    """Detect errors in a clip with a profile's τ and detector.

    The second result is the name of the profile's detector if it could not be used, or ''.
    """
    profile = profile or Profile({})
    wanted = method = profile.method or DEFAULT_METHOD
    tell(0.0)
    analysis = core.analyse(clip, rig=rig)
    if DETECTORS.usable(method) == method:
        try:
            analysis.by(method, stage_progress(tell, 0.0, _DETECTED))
        except TwistError:
            if method == DEFAULT_METHOD:
                raise
    if (method := analysis.usable(wanted)) != wanted:
        profile = Profile({})
        analysis.by(method, stage_progress(tell, 0.0, _DETECTED))
    tell(_DETECTED)
    found = analysis.detect(method, tau_radians=profile.of(analysis.chains_and_limbs))
    # Compute the values that the views need first in this thread, so as not to block the window.
    _ = clip.sha256, analysis.poses, analysis.signals, analysis.reliability, analysis.notes
    return Analysed(clip, analysis, Review.of(found)), "" if method == wanted else wanted


def analyse_session(
    path: Path, clip_path: Path | None = None, tell: Tell = ignore_progress, seen: Seen = _ignore
) -> Analysed:
    """Read a session and its clip. Raises TwistError.

    Without `clip_path`, the clip is searched for at its old path and next to the session. If the
    clip has changed, the result has a new review, and `earlier` contains the session's intervals.
    If the session belongs to an export, it is never overwritten; later changes are saved in the
    clip's session. `tell` is called with the progress, and `seen` with the clip when it has been
    read.
    """
    session, sha256 = read_session_with_hash(path)
    if clip_path is None:
        places = Path(session.clip), path.parent / Path(session.clip).name
        clip_path = find_file_by_sha256(places, session.sha256)
    if clip_path is None:
        raise ClipMissingError(path, session.clip)
    return _with_session(path, sha256, session, clip_path, tell, seen)


def _with_session(
    path: Path, sha256: str, session: Session, clip: Path, tell: Tell, seen: Seen = _ignore
) -> Analysed:
    method = session.state.method
    found = _read(clip, Profile({}, method), tell, session, seen)
    if not _belongs(session, found.clip):
        return replace(found, earlier=session.state.intervals)
    own = found.review.state
    known = {name: t for name, t in session.state.tau.items() if name in own.tau}
    limbs = {limb.name for limb in found.analysis.limbs}
    tau = {name: t for name, t in own.tau.items() if name not in limbs} | known
    state = replace(session.state, tau=tau, chain_order=own.chain_order)
    if message := unknown_kinds_sentence(state):
        found = replace(found, notes=(*found.notes, message))
    complete = add_missing_error_kinds(state, found.analysis)
    if complete is not state:
        added = len(complete.intervals) - len(state.intervals)
        found = replace(found, added=added)
    review = Review(complete)
    review.take_reasons(redetect_or_give_up(found.analysis, complete))
    if why := unusable_detector_message(found.analysis, method):
        found = replace(found, notes=(*found.notes, why))
    if path.name.endswith(REPLAY_SUFFIX):
        review.mark_unsaved()  # the review will be saved in the clip's session instead
        return replace(found, review=review)
    return replace(found, review=review, session=path, session_sha256=sha256)


def unknown_kinds_sentence(state: ReviewState) -> str:
    """Return a sentence about intervals whose kinds this version does not know, or ''."""
    kinds = [j.interval.kind for j in state.intervals if not j.interval.kind.known]
    if not kinds:
        return ""
    return tr(
        "Intervals that only a newer version of the program supports: {n} ({kinds}). They "
        "are shown and kept unchanged.",
        n=len(kinds),
        kinds=", ".join(sorted(set(kinds))),
    )


def add_missing_error_kinds(state: ReviewState, analysis: ClipAnalysis) -> ReviewState:
    """Return the review with undecided intervals added for kinds of errors that it lacks.

    Reviews by earlier versions of the program lack the newer kinds. Missing limbs are added with
    their τ, flips and lone jumps. Capture faults and carried rolls are added if the review has none
    of that kind. Undecided errors of single joints get the offset that earlier versions did not
    store. If there is nothing to add, the same object is returned.
    """
    return _with_offsets(_with_faults(_with_limbs(state, analysis), analysis), analysis)


def _with_offsets(state: ReviewState, analysis: ClipAnalysis) -> ReviewState:
    """Return the review with offsets added to undecided errors of single joints."""
    without = {
        j.id
        for j in state.intervals
        if j.interval.kind.info.repairer and not (j.kept or j.interval.offset.any())
    }
    if not without:
        return state
    method = analysis.usable(state.method)
    kinds = {j.interval.kind for j in state.intervals if j.id in without}
    found = {
        (i.chain, i.kind, i.joint, i.start, i.stop): i
        for kind in kinds
        for own in analysis.shown(kind, method).values()
        for i in own
    }

    def with_offset(judged: Judged) -> Judged:
        i = judged.interval
        same = found.get((i.chain, i.kind, i.joint, i.start, i.stop))
        if judged.id not in without or same is None:
            return judged
        return replace(judged, interval=same.for_review)

    return replace(state, intervals=tuple(map(with_offset, state.intervals)))


def _with_faults(state: ReviewState, analysis: ClipAnalysis) -> ReviewState:
    """Return the review, adding capture faults and carried rolls of each kind that it lacks."""
    known = {judged.interval.kind for judged in state.intervals}
    there, method = set(state.tau), analysis.usable(state.method)
    new = [
        fault
        for kind in Kind
        if kind.of_capture and kind.info.find and kind not in known
        for chain, own in analysis.shown(kind, method).items()
        for fault in own
        if chain in there
    ]
    if Kind.CARRIED_ROLL not in known:
        new += _carried_rolls(state, analysis, method)
    return _with_undecided(state, new) if new else state


def _carried_rolls(state: ReviewState, analysis: ClipAnalysis, method: str) -> list[Interval]:
    """Return the carried rolls at the review's τ that overlap no interval of the review."""
    detector = analysis.detector(method, {Kind.CARRIED_ROLL})
    taken = [(j.interval.chain, j.interval.start, j.interval.stop) for j in state.intervals]
    return [
        roll
        for chain in analysis.chains
        if chain.name in state.tau
        for roll in detector.intervals(chain.name, state.tau[chain.name])
        if not any(c == chain.name and a < roll.stop and roll.start < b for c, a, b in taken)
    ]


def _with_undecided(state: ReviewState, new: Sequence[Interval]) -> ReviewState:
    judged = [Judged(k, i.for_review) for k, i in enumerate(new, state.next_id)]
    return state.with_intervals((*state.intervals, *judged), state.next_id + len(judged))


def _with_limbs(state: ReviewState, analysis: ClipAnalysis) -> ReviewState:
    new = [limb.name for limb in analysis.limbs if limb.name not in state.tau]
    if not new:
        return state
    order = {chain.name: k for k, chain in enumerate(analysis.chains_and_limbs)}
    tau = {name: analysis.flips.automatic_tau(name) for name in new}
    found = tuple(i for name, t in tau.items() for i in analysis.flips.intervals(name, t))
    state = Redetect(tau, found).apply(replace(state, chain_order=order))
    jumps = [i for own in analysis.jumps(analysis.usable(state.method)).values() for i in own]
    return _with_undecided(state, jumps)


def opening_notes(
    data: Analysed, away: Path | None, notes: Sequence[str]
) -> Iterator[tuple[str, bool]]:
    """Yield (sentence, stays) pairs about a newly opened clip.

    `stays` is True if the sentence must remain visible until the user closes it. `away` is the
    folder of the clip's review if the clip's folder is read-only. `notes` are sentences about
    problems with the review.
    """
    if data.session is not None:
        message = tr("Continuing your review from {session}.", session=data.session.name)
        if data.added is not None:
            found = tr("{n} found, undecided", n=data.added) if data.added else tr("none found")
            message += " " + tr(
                "This version also looks for new kinds of errors: {found}.",
                found=found,
            )
        if tracking := data.review.state.tracking:
            message += " " + tr(
                "The review includes tracking: {what}.", what=translate_core_sentence(tracking.what)
            )
        yield message, False
    if rig := data.analysis.rig:
        yield (
            tr(
                "The chains of this rig have been changed: {summary}.",
                summary=translate_core_sentence(rig.summary()),
            ),
            False,
        )
    name, notices = data.clip.name, []
    if away is not None:
        message = tr(
            "The folder that contains {name} is read-only, so your decisions are kept in {folder}.",
            name=name,
            folder=away,
        )
        notices.append(message)
    found_out = () if data.blind else data.analysis.notes  # notes may reveal an error
    warned = (*map(str, data.clip.warnings), *map(str, found_out))
    warned = (*warned, *chain_warnings(data.chains_and_limbs))
    notices += [f"{name}: {translate_core_sentence(w)}" for w in warned]
    motion, every = data.motion, data.chains_and_limbs
    stuck = [
        translate_core_sentence(c.label)
        for c in every
        if uncorrectable_joints(motion, c, carried=True)
    ]
    if stuck:
        message = tr(
            "These chains are shown but not corrected, because some of their joints lack "
            "rotation channels: {chains}.",
            chains=", ".join(stuck),
        )
        notices.append(message)
    lasting = [*data.notes, *notes]
    if notices:
        message = " ".join(notices[:3])
        if len(notices) > 3:
            message += " " + plural(
                "The Chains panel shows {n} more note.",
                "The Chains panel shows {n} more notes.",
                len(notices) - 3,
            )
        if data.clip.missing_frames:  # the message stays until the user closes it
            lasting.insert(0, message)
        else:
            yield message, False
    if lasting:
        yield " ".join(lasting), True


def stamp_of(path: Path) -> Stamp | None:
    """Return a file's stamp (time, size, inode), or None if the file is missing."""
    try:
        status = path.stat()
    except OSError:
        return None
    return Stamp(status.st_mtime_ns, status.st_size, status.st_ino)


def clip_changed_sentence(clip: Clip, then: Stamp | None, now: Stamp | None) -> str:
    """Return a sentence stating that the clip has changed on disk since it was read, or ''.

    `then` is the stamp of the file when it was read, and `now` is its current stamp. The bytes are
    compared only if the stamps differ.
    """
    if now == then:
        return ""
    if now is None:
        return tr(
            "{clip} was moved or deleted on disk. The clip in this window is not affected.",
            clip=clip.name,
        )
    try:
        same = cached_sha256(clip.path) == clip.sha256
    except OSError as error:
        why = translate_core_sentence(str(error.strerror))
        return tr("{clip} can no longer be read ({why}).", clip=clip.name, why=why)
    return "" if same else tr("{clip} has changed on disk since it was opened.", clip=clip.name)
