"""Find journals of earlier runs with decisions that are not in the open review."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from inspector.language import tr
from inspector.session.opening import add_missing_error_kinds
from inspector.session.session_files import (
    fallback_session_path,
    find_existing_sessions,
    journal_owners,
    journals,
    modified_ns,
    rename_damaged,
    session_path,
)
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.errors import FormatError, TwistError
from twistcore.files.lock import is_file_locked
from twistcore.files.ordinary import path_exists
from twistcore.formats.clip import Clip
from twistcore.review import Judged, Recovered, Review, ReviewState, replay_journal
from twistcore.review.left_out import joined_spans, uncovered_parts
from twistcore.review.session import session_document
from twistcore.skeleton.limb import Limb


@dataclass(frozen=True, eq=False)
class Leftover:
    """A journal that an earlier run left behind.

    Attributes
    ----------
    recovered
        The review as read from the journal.
    same_clip
        True if the journal belongs to this version of the clip.
    completed
        True if the program has added limbs to the review; the journal lacks them and therefore
        cannot be continued.
    """

    recovered: Recovered
    same_clip: bool
    completed: bool = False

    @property
    def path(self) -> Path:
        """Return the path of the journal."""
        return self.recovered.path


def waiting_journals(clip: Path) -> list[Path]:
    """Return all journals of a clip that no running program uses, the latest first."""
    places = dict.fromkeys(
        (session_path(clip), fallback_session_path(clip), *find_existing_sessions(clip))
    )
    there = {path for place in places for path in journals(place)}
    return sorted((p for p in there if not is_file_locked(p)), key=modified_ns, reverse=True)


def clips_to_restore(folder: Path, clips: Sequence[Path]) -> set[Path]:
    """Return the clips of a folder that have an unsaved review to restore."""
    beside = journal_owners(folder)
    away = journal_owners(fallback_session_path(folder / "clip.bvh").parent)
    by_name = [p for p in clips if session_path(p).name in beside]
    if away:
        by_name += [p for p in clips if fallback_session_path(p).name in away]
    return {path for path in by_name if waiting_journals(path)}


def unsaved_clips(clips: Iterable[Path]) -> list[tuple[Path, Path, int]]:
    """Return (clip, latest journal, number of decisions) for clips with unsaved decisions.

    Call this function in a thread, because it may take seconds to replay the journals.
    """
    found = []
    for clip in clips:
        counted = ((clip, path, n) for path in waiting_journals(clip) if (n := decisions_in(path)))
        if (latest := next(counted, None)) and path_exists(clip):
            found.append(latest)
    return found


def decisions_in(journal: Path) -> int:
    """Return the number of intervals that a journal changes compared with its session.

    Returns 0 if the journal cannot be read or has no steps.
    """
    try:
        recovered = replay_journal(journal)
    except TwistError:
        return 0
    began = {_user_changes(judged) for judged in recovered.session.state.intervals}
    new = sum(_user_changes(judged) not in began for judged in recovered.review.state.intervals)
    return new or min(recovered.steps, 1)


def read_leftover(path: Path, clip: Clip, analysis: ClipAnalysis) -> tuple[Leftover | None, str]:
    """Read a journal of an earlier run.

    Returns a tuple of the leftover and a sentence to show. The leftover is None if the journal
    cannot be used, and the sentence is '' if there is no problem. A damaged journal is renamed. If
    the journal is from a version that did not detect limb flips, the clip's flips are added as
    undecided intervals.
    """
    try:
        recovered = replay_journal(path, clip)
    except FormatError as error:
        with suppress(OSError):
            if not path.stat().st_size:  # the program crashed before the first line was written
                path.unlink()
                return None, ""
        return None, rename_damaged(path, str(error))
    except TwistError as error:
        return None, str(error)
    message = ""
    if recovered.damaged:
        message = tr(
            "Damaged entries in {name}: {n}. The entries before the damage are kept.",
            name=path.name,
            n=recovered.damaged,
        )
    began, left = recovered.session.state, recovered.review.state
    if recovered.session.sha256 != clip.sha256 or not _has_chains(began, clip):
        return Leftover(recovered, False), message
    complete = add_missing_error_kinds(left, analysis.with_rig(left.rig))
    if complete is left:
        return Leftover(recovered, True), message
    review = Review(complete)
    review.mark_unsaved()
    began = add_missing_error_kinds(began, analysis.with_rig(began.rig))
    session = replace(recovered.session, state=began)
    return Leftover(replace(recovered, session=session, review=review), True, True), message


def _has_chains(state: ReviewState, clip: Clip) -> bool:
    """Return True if the clip has exactly the chains of the review, not counting limbs."""
    try:
        every = state.rig.chains(clip.motion)
    except TwistError:
        return False
    limbs = {c.name for c in every if isinstance(c, Limb)}
    return {c.name for c in every} - limbs == state.tau.keys() - limbs


def leftover_has_more_decisions(leftover: Leftover, clip: Clip, state: ReviewState) -> bool:
    """Return True if the journal may contain a decision or setting that is not in `state`."""
    left = leftover.recovered.review.state
    if leftover.same_clip:
        return leftover.recovered.damaged > 0 or not same_review(clip, left, state)
    return leftover.recovered.steps > 0 or any(judged.kept for judged in left.intervals)


def same_review(clip: Clip, one: ReviewState, other: ReviewState) -> bool:
    """Return True if both reviews of a clip would be saved as the same file."""
    return _content(clip, one) == _content(clip, other)


def count_missing(leftover: Leftover, state: ReviewState) -> tuple[int, int]:
    """Return the number of a journal's decisions that a review lacks, and their total number.

    Changed settings (τ, detector, chains or tracking) count as one decision, and so do changes to
    the frames excluded from tuning.
    """
    left = leftover.recovered.review.state
    kept = [judged for judged in left.intervals if judged.kept]
    has = {_user_changes(judged) for judged in state.intervals}
    lost = sum(_user_changes(judged) not in has for judged in kept)
    began = leftover.recovered.session.state
    others = [(s.method, dict(s.tau), s.tracking, s.rig) for s in (left, state, began)]
    set_too = [others[0] not in others[1:], _lacks_left_out(began, left, state)]
    return lost + sum(set_too), len(kept) + sum(set_too)


def _lacks_left_out(began: ReviewState, left: ReviewState, state: ReviewState) -> bool:
    """Return True if `state` lacks a journal's changes to the frames excluded from tuning.

    `began` and `left` are the states of the review at the beginning and the end of the journal.
    """
    was, wanted, here = (s.left_out for s in (began, left, state))
    again = uncovered_parts(was, wanted)  # frames that the journal uses for tuning again
    not_again = joined_spans(again) != uncovered_parts(again, here)
    return bool(uncovered_parts(uncovered_parts(wanted, was), here)) or not_again


def _user_changes(judged: Judged) -> tuple[object, ...]:
    """Return a tuple with the user's changes to an interval, for comparison.

    The tuple contains the decision and, if the user set them, the frames and the offset.
    """
    interval = judged.interval
    same = interval.offset.strides == (0,) or not np.ptp(interval.offset)
    offset = interval.offset[:1] if same else interval.offset
    place = (interval.start, interval.stop, offset.tobytes())
    own = place if judged.by_hand or judged.edited else ()
    return interval.chain, judged.decision, judged.note, judged.reason, judged.decided_at, own


def _content(clip: Clip, state: ReviewState) -> dict[str, Any]:
    return {k: v for k, v in session_document(clip, state).items() if k != "next_id"}
