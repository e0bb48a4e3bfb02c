"""Export the corrected clip, together with its session and a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from inspector.language import plural, tr, translate_core_sentence
from inspector.session.document import Document
from inspector.session.session_files import replay_path
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.twist_removal import joints_lacking_channels
from twistcore.errors import TwistError
from twistcore.export.compare import Difference, compare_motions
from twistcore.files.atomic import same_file
from twistcore.files.marks import cached_sha256, forget_cached_hashes, is_slow_to_hash
from twistcore.files.ordinary import is_file, path_exists, real_path
from twistcore.formats.clip import ChannelJump, Clip, check_clip_suffix, write_clip
from twistcore.formats.reading import companion_file_prefix
from twistcore.report.clip_report import (
    check_report_replaceable,
    read_report_hashes,
    report_files,
    write_clip_report,
)
from twistcore.report.document import Report
from twistcore.review import ReviewState, read_session, write_session
from twistcore.review.replay import accepted_motion
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.work.progress import Tell, ignore_progress

_STILL = 1e-9  # relative to the figure's height; smaller movements of a joint are rounding errors


@dataclass(frozen=True)
class ExportChoice:
    """The options of an export.

    Attributes
    ----------
    path
        The file to write.
    undecided
        True to accept the automatic corrections first.
    replace
        True if the user has agreed to replace existing files.
    session
        True to write a session file next to the clip.
    report
        True to write a report next to the clip.
    """

    path: Path
    undecided: bool = False
    replace: bool = False
    session: bool = True
    report: bool = True


@dataclass(frozen=True, eq=False)
class Export:
    """An export in progress, with the review as it was when the export began.

    Attributes
    ----------
    left_out
        A sentence about intervals that cannot be corrected, or ''.
    changed
        A sentence stating that the clip has changed on disk, or '' if it has not.
    ours
        The SHA-256 of files that this program wrote, including the files of this export.
    own
        Files that only the review itself may write, such as the session.
    by
        The reviewer's name.
    analysis
        The analysis of the clip, for the report.
    """

    choice: ExportChoice
    clip: Clip
    chains: tuple[Chain, ...]
    state: ReviewState
    left_out: str
    changed: str
    ours: dict[Path, str]
    own: frozenset[Path]
    by: str = ""
    analysis: ClipAnalysis | None = None


def prepare_export(document: Document, choice: ExportChoice) -> Export:
    """Return an export of the current review.

    If `choice.undecided` is True, the automatic corrections are accepted first. Raises TwistError
    if the export would overwrite the source or a file that this program did not write.
    """
    data = document.data
    assert data is not None
    choice = replace(choice, path=data.clip.path.absolute().parent / choice.path)
    own = document.keeper.files
    check_targets(choice, data.clip, document.exported, own)
    if choice.undecided and not document.accept_undecided():
        message = tr(
            "{path} was not written, because the undecided intervals cannot be accepted now.",
            path=choice.path,
        )
        raise TwistError(message)
    return Export(
        choice,
        data.clip,
        data.chains_and_limbs,
        document.review.state,
        uncorrected_warning(document),
        document.recovery.check_clip(),
        dict(document.exported),
        own,
        document.reviewer,
        data.analysis,
    )


def export_file_paths(choice: ExportChoice) -> tuple[Path, ...]:
    """Return the paths of all files that an export writes."""
    path = choice.path
    replay = (replay_path(path),) if choice.session else ()
    report = report_files(path.parent, companion_file_prefix(path)) if choice.report else ()
    return (path, *replay, *report)


def files_replaced_by_export(choice: ExportChoice, ours: Mapping[Path, str]) -> dict[Path, bool]:
    """Return the existing files that an export would replace.

    In the result, the value of each path is True if this program wrote the file. `ours` contains
    the SHA-256 of files written in this run; files of earlier runs are listed in the report.
    """
    known = _written_marks(choice, ours)
    listing = report_files(choice.path.parent, companion_file_prefix(choice.path))[-1]
    there = [path for path in export_file_paths(choice) if path_exists(path)]
    return {p: _as_written(p, known) or (p == listing and _lists(p)) for p in there}


def files_to_hash(choice: ExportChoice, ours: Mapping[Path, str]) -> tuple[Path, ...]:
    """Return the large files that :func:`files_replaced_by_export` would hash.

    The caller hashes them in a thread beforehand, so that the window does not block.
    """
    known = _written_marks(choice, ours)
    return tuple(
        path for path in export_file_paths(choice) if path in known and is_slow_to_hash(path)
    )


def _written_marks(
    choice: ExportChoice, ours: Mapping[Path, str]
) -> dict[Path, tuple[object, ...]]:
    """Return the SHA-256 hashes of the files that this program wrote, keyed by path.

    The hashes from earlier runs are read from the report.
    """
    listing = report_files(choice.path.parent, companion_file_prefix(choice.path))[-1]
    marks: Mapping[str, tuple[object, ...]] = {}
    with suppress(TwistError):
        marks = read_report_hashes(listing)
    known = {path: marks[path.name] for path in export_file_paths(choice) if path.name in marks}
    return known | {path: (mark,) for path, mark in ours.items()}


def _lists(listing: Path) -> bool:
    try:
        return bool(read_report_hashes(listing))
    except TwistError:
        return False


def check_targets(
    choice: ExportChoice, clip: Clip, ours: Mapping[Path, str], own: frozenset[Path]
) -> None:
    """Raise TwistError if an export would replace a file that must not be replaced.

    An existing session or report is replaced only if this program wrote it, even if the user has
    agreed to replace the exported clip.

    Parameters
    ----------
    ours
        The SHA-256 of files that this program wrote, to compare with the files on disk.
    own
        Files that only the review itself may write, such as the session.
    """
    path, replay = choice.path, replay_path(choice.path)
    if real_path(path) == real_path(clip.path) or same_file(path, clip.path):
        message = tr(
            "{path} is the source clip, which is never overwritten. Choose another name.", path=path
        )
        raise TwistError(message)
    if path in own or replay in own:
        message = tr("{path} is used by the review itself. Choose another name.", path=path)
        raise TwistError(message)
    check_clip_suffix(clip, path)
    known = _written_marks(choice, ours)
    for file in (path, replay) if choice.session else (path,):
        if not (choice.replace or _as_written(file, known)):
            message = tr("{path} already exists. Choose another name.", path=file)
            raise TwistError(message)
    if choice.session and path_exists(replay):
        try:
            read_session(replay)
        except TwistError:
            message = tr(
                "{path} already exists and was not written by this program. Choose another name.",
                path=replay,
            )
            raise TwistError(message) from None
    if choice.report:
        check_report_replaceable(path.parent, companion_file_prefix(path))


def _as_written(path: Path, known: Mapping[Path, tuple[object, ...]]) -> bool:
    """Return True if a file does not exist or has not changed since this program wrote it.

    `known` contains the SHA-256 of each version that this program wrote, keyed by path.
    """
    if not is_file(path):
        return True
    return path in known and cached_sha256(path) in known[path]


def write_export_files(export: Export, tell: Tell = ignore_progress) -> str:
    """Correct the clip, write the chosen files, and return a sentence about the result.

    `tell` is called with the progress of the tracking filter. Raises OSError if writing fails, and
    TwistError if another program has written one of the files in the meantime.
    """
    choice, clip, state = export.choice, export.clip, export.state
    refined = accepted_motion(clip, export.chains, state, tell=tell)
    forget_cached_hashes(export_file_paths(choice))
    check_targets(choice, clip, export.ours, export.own)
    jumps = write_clip(clip, refined, choice.path)
    _take_note(export, choice.path)
    if choice.session:
        write_session(clip, state, replay_path(choice.path))
        _take_note(export, replay_path(choice.path))
    if choice.report:
        own = (choice.path, replay_path(choice.path))
        files = {
            p.name: export.ours[p]
            for p in own
            if p in export.ours and p in export_file_paths(choice)
        }
        name = companion_file_prefix(choice.path)
        report = Report(
            clip,
            export.chains,
            state,
            refined,
            name,
            files,
            export.by,
            analysis=export.analysis,
            written=choice.path,
        )
        # Write no pictures, to be fast; `twistcore report` draws them.
        for file in write_clip_report(choice.path.parent, report):
            _take_note(export, file)
    return _result(export, refined, jumps)


def _take_note(export: Export, path: Path) -> None:
    if is_file(path):
        export.ours[path] = cached_sha256(path)


def _result(export: Export, refined: Motion, jumps: Sequence[ChannelJump]) -> str:
    name = export.choice.path.name
    stale = ""
    if export.changed:
        stale = f" {export.changed} " + tr("The version that is open in this window was exported.")
    change = compare_motions(export.clip.motion, refined)
    if not change.joints:
        why = export.left_out or tr("No correction was accepted.")
        return (
            tr("{name} was written as an exact copy of the source clip. {why}", name=name, why=why)
            + stale
        )
    largest = max(j.max_degrees for j in change.joints)
    joints = len({j.joint for j in change.joints})
    message = plural(
        "{name} was written: {n} joint changed by up to {largest:.1f}° in {frames}. "
        "{moved} All other bytes are unchanged.",
        "{name} was written: {n} joints changed by up to {largest:.1f}° in {frames}. "
        "{moved} All other bytes are unchanged.",
        joints,
        name=name,
        frames=plural("{n} frame", "{n} frames", change.frames),
        largest=largest,
        moved=_moved(change),
    )
    steps = ""
    if jumps:
        steps = plural(
            "{n} step of more than 180° remains in the rotation channels: {first}.",
            "{n} steps of more than 180° remain in the rotation channels. The first one: {first}.",
            len(jumps),
            first=translate_core_sentence(str(jumps[0])),
        )
    return " ".join(filter(None, (message, export.left_out, steps))) + stale


def _moved(change: Difference) -> str:
    """Return a sentence that states how far joints moved, relative to the figure's height."""
    rest, still = change.rest_of_height, change.rest_of_height < _STILL
    if not change.moved and still:
        return tr("No joint moved.")
    if not change.moved:
        return tr("No joint moved by more than {rest:.0e} of the figure's height.", rest=rest)
    *before, last = (
        tr("{joint} by up to {percent:.1f} %", joint=m.joint, percent=100.0 * m.of_height)
        for m in change.moved
    )
    names = last
    if before:
        names = tr("{before} and {last}", before=", ".join(before), last=last)
    if len(before) > 2:  # many joints have moved: tracking may move the whole figure
        most = 100.0 * max(m.of_height for m in change.moved)
        count = len(change.moved)
        names = tr("{count} joints by up to {percent:.1f} %", count=count, percent=most)
    if still:
        return tr(
            "These joints moved (as a share of the figure's height): {names}. No other joint "
            "moved.",
            names=names,
        )
    return tr(
        "These joints moved (as a share of the figure's height): {names}. No other joint "
        "moved by more than {rest:.0e}.",
        names=names,
        rest=rest,
    )


def uncorrected_warning(document: Document) -> str:
    """Return a sentence about accepted intervals that cannot be corrected, or ''."""
    assert document.data is not None
    motion = document.data.motion
    accepted = document.review.state.chosen()
    stuck = "; ".join(
        f"{translate_core_sentence(c.label)} ({', '.join(joints)})"
        for c in document.data.chains_and_limbs
        if (joints := joints_lacking_channels(motion, c, accepted))
    )
    if not stuck:
        return ""
    return tr(
        "These chains were not corrected, because some of their joints lack rotation "
        "channels: {chains}.",
        chains=stuck,
    )
