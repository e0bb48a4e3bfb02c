"""Run `twistcore refine` and `twistcore apply`, which write corrected clips."""

from __future__ import annotations

import argparse
import math
import shlex
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from twistcore.analysis.clip_analysis import ClipAnalysis, Detection
from twistcore.analysis.correction.twist_removal import SURE_ENOUGH
from twistcore.cli.arguments.argument_types import STANDARD_INPUT
from twistcore.cli.clip_inputs import (
    clip_name_for_messages,
    detect_with_options,
    read_clip_or_stdin,
    reading_assumption_sentences,
)
from twistcore.cli.decided_sessions import refuse_overwriting_decisions
from twistcore.cli.folder_commands import apply_folder
from twistcore.cli.interval_words import (
    corrected_interval_count_text,
    jump_sentences,
    note_sentences,
    nothing_examined_sentence,
    uncorrectable_counts,
    unexamined_limbs_text,
    unexamined_limbs_to_json,
)
from twistcore.cli.output import (
    count_with_noun,
    print_json,
    print_note,
    print_problem,
    print_remark,
    print_step_duration,
    refuse_overwrite,
)
from twistcore.detection import Interval
from twistcore.errors import TwistError
from twistcore.export.detection_json import detection_tau_degrees, intervals_to_json
from twistcore.files.atomic import is_stream
from twistcore.files.ordinary import path_exists
from twistcore.formats.clip import Clip, check_clip_suffix, write_clip
from twistcore.formats.reading import companion_file_prefix
from twistcore.report.clip_report import (
    check_report_replaceable,
    has_report_on_different_clip,
    write_clip_report,
)
from twistcore.report.document import Report
from twistcore.review import Review, write_session
from twistcore.review.model import SEEN
from twistcore.review.replay import (
    Replay,
    accepted_motion,
    correctable_intervals,
    replay_session,
    uncorrected_and_moved_joint_sentences,
    unknown_error_kind_sentences,
)


def refine_command(arguments: argparse.Namespace) -> int:
    """Write a corrected clip and, if requested, a report and a session. Return the exit code."""
    clip = read_clip_or_stdin(arguments.clip, fps=arguments.fps)
    check_clip_suffix(clip, arguments.output)
    files = arguments.clip, arguments.profile, arguments.rig, arguments.joint_names
    written_files = [path for path in (arguments.output, arguments.session) if path]
    refuse_overwrite(written_files, [path for path in files if path])
    if arguments.session:
        refuse_overwriting_decisions(arguments.session)
    if arguments.report and path_exists(arguments.report) and not arguments.report.is_dir():
        raise TwistError(f"{arguments.report} is a file; choose a folder for the report")
    if arguments.report:
        check_report_replaceable(arguments.report, companion_file_prefix(clip.path), clip)
    found = detect_with_options(arguments, clip)
    chains, review = found.chains_and_limbs, Review.of(found)
    review.accept(arguments.min_confidence, include_open=arguments.include_open)
    applied = review.accepted
    with print_step_duration(f"  {clip.path}: corrected"):
        refined = accepted_motion(clip, chains, review.state)
    with print_step_duration(f"  {arguments.output}: written"):
        jumps = write_clip(clip, refined, arguments.output)
    if arguments.session:
        with print_step_duration(f"  {arguments.session}: session written"):
            write_session(clip, review, arguments.session)
    name = clip_name_for_messages(arguments.clip)
    notes = [*reading_assumption_sentences(name, clip), *note_sentences(name, found)]
    notes += jump_sentences(arguments.output, jumps)
    if arguments.report:
        written = None if is_stream(arguments.output) else arguments.output
        report = Report(
            clip,
            chains,
            review.state,
            refined,
            companion_file_prefix(clip.path),
            analysis=found.analysis,
            written=written,
        )
        if has_report_on_different_clip(arguments.report, companion_file_prefix(clip.path), clip):
            other = f"of another clip {clip.name}"
            notes.append(f"{arguments.report}: note: replaced the report {other}")
        with print_step_duration(f"  {arguments.report}: report written"):
            write_clip_report(arguments.report, report)
    done = correctable_intervals(clip.motion, chains, applied)
    count = corrected_interval_count_text(done, found, "corrected")
    count += _left(name, len(applied), found)
    if not found.not_examined:
        print_remark(
            f"{arguments.output}: {count}{unexamined_limbs_text(found.analysis.unexamined)}"
        )
    if arguments.session:
        session = f"session with {count_with_noun(len(review.state.intervals), 'interval')}"
        print_remark(f"{arguments.session}: {session}, {len(applied)} accepted automatically")
    problems, moved = uncorrected_and_moved_joint_sentences(clip, chains, applied)
    problems += nothing_examined_sentence(name, found)
    notes += moved
    if arguments.json:
        print_json(_refined_to_json(arguments, clip, found, done, notes, problems))
    return _tell(notes, problems)


def apply_command(arguments: argparse.Namespace) -> int:
    """Apply a session, or all sessions in a folder, and return the exit code.

    The written clips are the same as those exported from the window.
    """
    if arguments.session.is_dir() or arguments.clip.is_dir():
        return apply_folder(arguments)
    refuse_overwrite([arguments.output], [arguments.clip, arguments.session])
    replay = replay_session(arguments.session, arguments.clip)
    clip, chains, session = replay.clip, replay.chains, replay.session
    jumps = write_clip(clip, replay.motion, arguments.output)
    analysis = ClipAnalysis(clip.motion, chains, clip.name, session.state.rig)
    blind = () if session.state.intervals else nothing_examined_sentence(arguments.clip, analysis)
    notes = reading_assumption_sentences(arguments.clip, clip) + note_sentences(
        arguments.clip, analysis
    )
    notes += jump_sentences(arguments.output, jumps)
    notes += replay.notes
    chosen, judged = session.state.chosen(), session.state.intervals
    done = correctable_intervals(clip.motion, chains, chosen)
    count = corrected_interval_count_text(done, [j.interval for j in judged], "applied")
    seen = uncorrectable_counts([j.interval for j in judged if j.verdict == SEEN], " seen")
    if not blind:
        print_remark(
            f"{arguments.output}: {count}{seen}{unexamined_limbs_text(analysis.unexamined)}"
        )
    problems, moved = uncorrected_and_moved_joint_sentences(clip, chains, chosen)
    problems += unknown_error_kind_sentences(clip, session.state)
    problems += blind
    notes += moved
    if arguments.json:
        document = _applied_to_json(arguments, replay, done, notes, problems)
        why = analysis.not_examined if blind else None
        print_json(
            document | {"not_examined": why, "unexamined": unexamined_limbs_to_json(analysis)}
        )
    return _tell(notes, problems)


def _left(clip: str, applied: int, found: Iterable[Interval]) -> str:
    """Return text about the intervals in `found` that were not corrected, or ''.

    An example is '; not corrected: 1 spike; judge them with: twist-inspector walk.bvh'. `applied`
    is the number of corrected intervals.
    """
    left = sum(i.repairable for i in found) - applied
    words = (f", {left} left for a person to judge" if left else "") + uncorrectable_counts(found)
    if not words:
        return ""
    window = f"; judge them with: twist-inspector {shlex.quote(clip)}"
    window = "" if clip == clip_name_for_messages(STANDARD_INPUT) else window
    return f"; not corrected: {words.removeprefix(', ')}{window}"


def _least(asked: float | None) -> float:
    return SURE_ENOUGH if asked is None else asked


def _tell(notes: Iterable[str], problems: Collection[str]) -> int:
    """Print problems and notes. Return 1 if there are problems, and 0 if not."""
    for sentence in problems:
        print_problem(sentence)
    for sentence in notes:
        print_note(sentence)
    return int(bool(problems))


def _refined_to_json(
    arguments: argparse.Namespace,
    clip: Clip,
    found: Detection,
    done: Collection[Interval],
    notes: Sequence[str],
    problems: Sequence[str],
) -> dict[str, Any]:
    motion, taken = found.analysis.motion, {_place(i) for i in done}
    intervals = zip(intervals_to_json(found), found, strict=True)
    return {
        "schema": "twistcore.refine/1",
        "clip": clip_name_for_messages(arguments.clip),
        "output": str(arguments.output),
        "report": str(arguments.report) if arguments.report else None,
        "session": str(arguments.session) if arguments.session else None,
        "frames": motion.frames,
        "missing_frames": clip.missing_frames,
        "fps": motion.fps,
        "method": found.method,
        "tau_deg": detection_tau_degrees(found),
        "min_confidence": _least(arguments.min_confidence),
        "include_open": arguments.include_open,
        "repairable": sum(i.repairable for i in found),
        "corrected": len(taken),
        "not_examined": found.not_examined or None,
        "unexamined": unexamined_limbs_to_json(found.analysis),
        "intervals": [entry | {"corrected": _place(i) in taken} for entry, i in intervals],
        "notes": list(notes),
        "problems": list(problems),
    }


def _place(interval: Interval) -> tuple[str, str, int, int]:
    """Return a key that identifies an interval of a clip, even after a review."""
    return interval.chain, interval.kind.value, interval.start, interval.stop


def _applied_to_json(
    arguments: argparse.Namespace,
    replay: Replay,
    done: Collection[Interval],
    notes: Sequence[str],
    problems: Sequence[str],
) -> dict[str, Any]:
    state, taken = replay.session.state, set(done)
    return {
        "schema": "twistcore.apply/1",
        "session": str(arguments.session),
        "clip": str(arguments.clip),
        "output": str(arguments.output),
        "method": state.method,
        "tracked": state.tracking is not None,
        "repairable": sum(j.counts for j in state.intervals),
        "applied": len(taken),
        "intervals": [
            {
                "id": j.id,
                "chain": j.interval.chain,
                "start": j.interval.start,
                "stop": j.interval.stop,
                "delta_deg": math.degrees(j.interval.delta),
                "kind": j.interval.kind.value,
                "decision": str(j.decision),
                "applied": j.interval in taken,
            }
            for j in state.intervals
        ],
        "notes": list(notes),
        "problems": list(problems),
    }
