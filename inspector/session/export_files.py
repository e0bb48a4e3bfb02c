"""Exporting: the corrected clip, and beside it the session and a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from inspector.language import of_core, plural, tr
from inspector.session.document import Document
from inspector.session.session_files import replay_path
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction import stuck_joints
from twistcore.errors import TwistError
from twistcore.export.compare import Difference, compare
from twistcore.export.replay import accepted_motion
from twistcore.files.atomic import same_file
from twistcore.files.marks import file_mark, forget_marks, takes_long
from twistcore.files.ordinary import is_file, is_there, real_path
from twistcore.formats.clip import ChannelJump, Clip, check_ending, write_clip
from twistcore.formats.reading import own_name
from twistcore.report.clip_report import check_report, report_files, report_marks, write_clip_report
from twistcore.report.document import Report
from twistcore.review import ReviewState, read_session, write_session
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.work.progress import Tell, nobody

_STILL = 1e-9  # of the height: what a joint moves less is rounding


@dataclass(frozen=True)
class ExportChoice:
    """What a person asked for."""

    path: Path
    undecided: bool = False
    replace: bool = False
    session: bool = True
    report: bool = True


@dataclass(frozen=True, eq=False)
class Export:
    """What is written, whatever the person does meanwhile.

    left_out: what cannot be corrected; changed: that the clip on disk is another by now, or '';
    ours: SHA-256 of files as this program wrote them, those of this export as they come; own: what
    only the review itself may write; by: who asks for it; analysis: of the clip, for the report.
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
    """Accept what is to be accepted and keep the review as it is now.

    Raises TwistError where the source, or a file that is none of ours, would be overwritten.
    """
    data = document.data
    assert data is not None
    choice = replace(choice, path=data.clip.path.absolute().parent / choice.path)
    own = document.keeper.files
    check_targets(choice, data.clip, document.exported, own)
    if choice.undecided and not document.accept_undecided():
        told = tr("{path}: not written, since nothing can be accepted here.", path=choice.path)
        raise TwistError(told)
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


def files_of(choice: ExportChoice) -> tuple[Path, ...]:
    """Every file that an export writes."""
    path = choice.path
    replay = (replay_path(path),) if choice.session else ()
    report = report_files(path.parent, own_name(path)) if choice.report else ()
    return (path, *replay, *report)


def replaced(choice: ExportChoice, ours: Mapping[Path, str]) -> dict[Path, bool]:
    """Files that are there already where an export writes, and whether this program wrote them so.

    ours: SHA-256 of files as this program wrote them; those of earlier runs are told by the report.
    """
    known = _known(choice, ours)
    listing = report_files(choice.path.parent, own_name(choice.path))[-1]
    there = [path for path in files_of(choice) if is_there(path)]
    return {p: _as_written(p, known) or (p == listing and _lists(p)) for p in there}


def to_look_at(choice: ExportChoice, ours: Mapping[Path, str]) -> tuple[Path, ...]:
    """Long files that :func:`replaced` would read, for a thread to take their `file_mark` first."""
    known = _known(choice, ours)
    return tuple(path for path in files_of(choice) if path in known and takes_long(path))


def _known(choice: ExportChoice, ours: Mapping[Path, str]) -> dict[Path, tuple[object, ...]]:
    """SHA-256 that files have as this program wrote them: this run, or, by the report, another."""
    listing = report_files(choice.path.parent, own_name(choice.path))[-1]
    marks: Mapping[str, tuple[object, ...]] = {}
    with suppress(TwistError):
        marks = report_marks(listing)
    known = {path: marks[path.name] for path in files_of(choice) if path.name in marks}
    return known | {path: (mark,) for path, mark in ours.items()}


def _lists(listing: Path) -> bool:
    try:
        return bool(report_marks(listing))
    except TwistError:
        return False


def check_targets(
    choice: ExportChoice, clip: Clip, ours: Mapping[Path, str], own: frozenset[Path]
) -> None:
    """TwistError where anything would be replaced that is neither ours nor given up.

    ours: SHA-256 of files as this program wrote them: what is there now is compared; own: what only
    the review itself may write. What lies beside the export is replaced only if this program wrote
    it, whatever the person says of the export itself.
    """
    path, replay = choice.path, replay_path(choice.path)
    if real_path(path) == real_path(clip.path) or same_file(path, clip.path):
        told = tr("{path}: choose another name; the source is never overwritten.", path=path)
        raise TwistError(told)
    if path in own or replay in own:
        told = tr("{path}: choose another name; the review itself is kept there.", path=path)
        raise TwistError(told)
    check_ending(clip, path)
    known = _known(choice, ours)
    for file in (path, replay) if choice.session else (path,):
        if not (choice.replace or _as_written(file, known)):
            told = tr("{path}: there is such a file already; choose another name.", path=file)
            raise TwistError(told)
    if choice.session and is_there(replay):
        try:
            read_session(replay)
        except TwistError:
            told = tr(
                "{path}: there is a file that this program did not write; choose another name.",
                path=replay,
            )
            raise TwistError(told) from None
    if choice.report:
        check_report(path.parent, own_name(path))


def _as_written(path: Path, known: Mapping[Path, tuple[object, ...]]) -> bool:
    """Whether nothing is there, what this program wrote there, or what has no bytes to lose."""
    if not is_file(path):
        return True
    return path in known and file_mark(path) in known[path]


def write(export: Export, tell: Tell = nobody) -> str:
    """Correct, track and write everything chosen; returns the sentence that says what was changed.

    tell: called with the share of the tracking that is done. Raises OSError where the disk says no,
    TwistError where a file that is none of ours has come meanwhile.
    """
    choice, clip, state = export.choice, export.clip, export.state
    refined = accepted_motion(clip, export.chains, state, tell=tell)
    forget_marks(files_of(choice))
    check_targets(choice, clip, export.ours, export.own)
    jumps = write_clip(clip, refined, choice.path)
    _take_note(export, choice.path)
    if choice.session:
        write_session(clip, state, replay_path(choice.path))
        _take_note(export, replay_path(choice.path))
    if choice.report:
        own = (choice.path, replay_path(choice.path))
        files = {p.name: export.ours[p] for p in own if p in export.ours and p in files_of(choice)}
        name = own_name(choice.path)
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
        # Without pictures: an export is over at once, and `twistcore report` draws them.
        for file in write_clip_report(choice.path.parent, report):
            _take_note(export, file)
    return _told(export, refined, jumps)


def _take_note(export: Export, path: Path) -> None:
    if is_file(path):
        export.ours[path] = file_mark(path)


def _told(export: Export, refined: Motion, jumps: Sequence[ChannelJump]) -> str:
    name = export.choice.path.name
    stale = ""
    if export.changed:
        stale = f" {export.changed} " + tr("This is the version that is open.")
    change = compare(export.clip.motion, refined)
    if not change.joints:
        why = export.left_out or tr("no correction was accepted.")
        return tr("{name}: written byte for byte as the source; {why}", name=name, why=why) + stale
    largest = max(j.max_degrees for j in change.joints)
    joints = len({j.joint for j in change.joints})
    told = plural(
        "{name}: {frames} of {n} joint changed by up to {largest:.1f}°; {moved}; "
        "every other byte is the source's.",
        "{name}: {frames} of {n} joints changed by up to {largest:.1f}°; {moved}; "
        "every other byte is the source's.",
        joints,
        name=name,
        frames=plural("{n} frame", "{n} frames", change.frames),
        largest=largest,
        moved=_moved(change),
    )
    steps = ""
    if jumps:
        steps = plural(
            "{n} channel step of more than 180° stays: {first}.",
            "{n} channel steps of more than 180° stay: {first}.",
            len(jumps),
            first=of_core(str(jumps[0])),
        )
    return " ".join(filter(None, (told, export.left_out, steps))) + stale


def _moved(change: Difference) -> str:
    """Which joints the correction moved, of the figure's height."""
    rest, still = change.rest_of_height, change.rest_of_height < _STILL
    if not change.moved and still:
        return tr("no joint moved")
    if not change.moved:
        return tr("no joint moved by more than {rest:.0e} of the height", rest=rest)
    *before, last = (
        tr("{joint} by up to {percent:.1f} %", joint=m.joint, percent=100.0 * m.of_height)
        for m in change.moved
    )
    names = last
    if before:
        names = tr("{before} and {last}", before=", ".join(before), last=last)
    if len(before) > 2:  # tracked, a whole figure may
        most = 100.0 * max(m.of_height for m in change.moved)
        count = len(change.moved)
        names = tr("{count} joints by up to {percent:.1f} %", count=count, percent=most)
    if still:
        return tr("moved: {names} of the height; no other joint moves", names=names)
    return tr(
        "moved: {names} of the height; no other joint by more than {rest:.0e} of the height",
        names=names,
        rest=rest,
    )


def uncorrected_warning(document: Document) -> str:
    """A sentence about accepted intervals that cannot be corrected, or ''."""
    assert document.data is not None
    motion = document.data.motion
    accepted = document.review.state.chosen()
    stuck = "; ".join(
        f"{of_core(c.label)} ({', '.join(joints)})"
        for c in document.data.chains_and_limbs
        if (joints := stuck_joints(motion, c, accepted))
    )
    if not stuck:
        return ""
    return tr("Not corrected, for want of three rotation channels: {chains}.", chains=stuck)
