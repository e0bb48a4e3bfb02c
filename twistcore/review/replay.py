"""Apply a review to its clip. The window and the command line give exactly the same result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from twistcore.analysis.correction.joint_repairs import JointRepairs, repair_moves_joints
from twistcore.analysis.correction.twist_removal import (
    children_off_axis,
    joints_lacking_channels,
    refine,
)
from twistcore.detection import Interval, Kind
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.files.document_values import format_value_for_message
from twistcore.formats.clip import Clip
from twistcore.formats.reading import read_clip
from twistcore.quamo.clip_tracking import check_tracking_fits_motion, tracked_motion
from twistcore.review import Decision, ReviewState, Session, read_session
from twistcore.review.interrupted_export import interrupted_export_sentence
from twistcore.skeleton.chain import Chain, uncorrectable_joints
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell


def accepted_motion(
    clip: Clip, chains: Sequence[Chain], state: ReviewState, *, tell: Tell | None = None
) -> Motion:
    """Return the motion after the accepted intervals are corrected and the chosen joints tracked.

    Parameters
    ----------
    clip
        The clip.
    chains
        The chains and limbs of the review.
    state
        The state of the review.
    tell
        A function that is called with the completed share of the tracking, 0…1.
    """
    refined = refine(clip.motion, chains, state.chosen())
    return refined if state.tracking is None else tracked_motion(refined, state.tracking, tell)


@dataclass(frozen=True, eq=False)
class Replay:
    """A session applied to its clip.

    Parameters
    ----------
    session, clip
        The session and the clip.
    chains
        The chains and limbs of the review.
    motion
        The corrected motion.
    notes
        A sentence if the export that last wrote the session was interrupted.
    """

    session: Session
    clip: Clip
    chains: tuple[Chain, ...]
    motion: Motion
    notes: tuple[str, ...] = ()


def replay_session(session_path: Path, clip_path: Path) -> Replay:
    """Read a session and its clip, and correct the clip. Raises TwistError or OSError."""
    session = read_session(session_path)
    clip = read_clip(clip_path, fps=session.fps)
    chains = session_chains(session, clip)
    notes = tuple(filter(None, (interrupted_export_sentence(session_path),)))
    return Replay(session, clip, chains, accepted_motion(clip, chains, session.state), notes)


def uncorrected_and_moved_joint_sentences(
    clip: Clip, chains: Sequence[Chain], chosen: Sequence[Interval]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return sentences about uncorrectable intervals and about joints that corrections also move.

    Returns
    -------
    left
        Sentences about accepted intervals that cannot be corrected.
    moved
        Sentences about joints that a correction moves, such as a child off the axis of its chain.
    """
    sentences = uncorrected_chain_sentences(clip.motion, chains, chosen)
    left = tuple(f"{clip.path}: {sentence}" for sentence in sentences)
    moved: list[str] = []
    used = {interval.chain for interval in chosen if interval.repairable}
    for chain in (chain for chain in chains if chain.name in used):
        for name, distance in children_off_axis(clip.motion, chain).items():
            share = 2.0 * distance / clip.motion.skeleton.height
            if share > 1e-6:
                moved.append(
                    f"{clip.path}: {name} is not on the axis of {chain.name}, so the correction "
                    f"moves it by up to {share:.1e} of the figure's height"
                )
    alone = JointRepairs(correctable_intervals(clip.motion, chains, chosen)).intervals
    moving = dict.fromkeys(i.joint for i in alone if repair_moves_joints(clip.motion, i))
    moved += [f"{clip.path}: correcting {name} also moves the joints below it" for name in moving]
    return left, tuple(moved)


def unknown_error_kind_sentences(clip: Clip, state: ReviewState) -> tuple[str, ...]:
    """Return a sentence if accepted intervals have a kind that this version does not know."""
    accepted = (j.interval.kind for j in state.intervals if j.decision == Decision.ACCEPTED)
    unknown = [kind for kind in accepted if not kind.known]
    if not unknown:
        return ()
    kinds, count = ", ".join(sorted(set(unknown))), len(unknown)
    if count == 1:
        return (
            f"{clip.path}: this version cannot correct an accepted interval of the kind {kinds}",
        )
    return (
        f"{clip.path}: this version cannot correct {count} accepted intervals of the kinds {kinds}",
    )


def uncorrected_chain_sentences(
    motion: Motion, chains: Sequence[Chain], chosen: Sequence[Interval]
) -> tuple[str, ...]:
    """Return a sentence for each chain or joint whose accepted intervals cannot be corrected."""
    left = []
    twists = [i for i in chosen if i.repairable]
    for chain in chains:
        if joints := joints_lacking_channels(motion, chain, twists):
            some = uncorrectable_joints(motion, chain, carried=True) != joints
            where = " in intervals that keep the end of the limb" if some else ""
            left.append(
                f"{chain.name} was not corrected{where}, because these joints do not have "
                f"three rotation channels: {', '.join(joints)}"
            )
        left += [
            f"{alone.joint} was not corrected, because these joints do not have three "
            f"rotation channels: {', '.join(joints)}"
            for alone in JointRepairs(i for i in chosen if i.chain == chain.name).intervals
            if (joints := joints_lacking_channels(motion, chain, [alone]))
        ]
    return tuple(dict.fromkeys(left))


def correctable_intervals(
    motion: Motion, chains: Sequence[Chain], chosen: Sequence[Interval]
) -> tuple[Interval, ...]:
    """Return the intervals that :func:`accepted_motion` corrects."""
    by_name = {chain.name: chain for chain in chains}
    return tuple(i for i in chosen if not joints_lacking_channels(motion, by_name[i.chain], [i]))


def session_chains(session: Session, clip: Clip) -> tuple[Chain, ...]:
    """Return the chains and limbs of a clip, as specified by a session.

    Raises ClipMismatchError if the session does not fit the clip, as in
    :func:`check_session_fits_clip`.
    """
    check_session_hash(session, clip)
    try:
        chains = session.state.rig.chains(clip.motion)
    except TwistError as error:
        raise ClipMismatchError(
            f"{clip.path}: the session and the clip have different chains: {error}"
        ) from None
    check_session_fits_clip(session, clip, chains)
    return chains


def check_session_hash(session: Session, clip: Clip) -> None:
    """Raise ClipMismatchError unless a session was made for a clip with exactly these bytes."""
    if session.sha256 != clip.sha256:
        raise ClipMismatchError(
            f"{clip.path}: the session was made for another version of this clip (SHA-256 differs)"
        )


def check_session_fits_clip(session: Session, clip: Clip, chains: Sequence[Chain]) -> None:
    """Raise ClipMismatchError unless a session's hash, chains, frames and tracking fit a clip.

    `chains` are the chains and limbs of the clip.
    """
    check_session_hash(session, clip)
    by_name = {chain.name: chain for chain in chains}
    for judged in session.state.intervals:
        interval = judged.interval
        chain, flips = by_name.get(interval.chain), interval.kind == Kind.LIMB_FLIP
        if chain is None or isinstance(chain, Limb) != flips:
            what = "limb" if flips else "chain"
            raise ClipMismatchError(
                f"{clip.path}: the session has a {what} "
                f"{format_value_for_message(interval.chain)}, but "
                "the clip has none with this name"
            )
        if interval.correctable and not interval.repairable:
            _check_joint(clip, interval)
        if interval.stop > clip.motion.frames:
            raise ClipMismatchError(f"{clip.path}: an interval ends after the clip's last frame")
    if session.state.tracking is not None:
        try:
            check_tracking_fits_motion(clip.motion, session.state.tracking)
        except TwistError as error:
            raise ClipMismatchError(
                f"{clip.path}: the session uses tracking, but {error}"
            ) from None


def _check_joint(clip: Clip, interval: Interval) -> None:
    """Raise ClipMismatchError unless the clip has the joint of an accepted interval."""
    if interval.joint not in clip.motion.skeleton.names:
        raise ClipMismatchError(
            f"{clip.path}: the session corrects a joint "
            f"{format_value_for_message(interval.joint)}, but "
            "the clip has no joint with this name"
        )
