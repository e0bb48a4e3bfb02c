"""Run `twistcore diff`, which compares two clips, folders of clips, sessions or reports."""

from __future__ import annotations

import argparse
from pathlib import Path

from twistcore.cli.clip_inputs import clip_name_for_messages, print_clip_notes, read_clip_or_stdin
from twistcore.cli.diff_sessions import diff_sessions
from twistcore.cli.folder_commands import diff_folders
from twistcore.cli.output import count_with_noun, print_json, print_result, terminal_text
from twistcore.errors import ClipMismatchError, TwistError
from twistcore.export.compare import compare_motions, difference_to_json
from twistcore.report.report_difference import compare_report_files, is_clip_report_json


def diff_command(arguments: argparse.Namespace) -> int:
    """Print the differences and return the exit code.

    Raises TwistError if the two arguments are of different types.
    """
    documents = [path for path in (arguments.a, arguments.b) if _is_document(path)]
    reports = any(map(is_clip_report_json, documents))
    if len(documents) == 1 and not reports:
        raise TwistError(f"expected two sessions, but only {documents[0]} is a session")
    if arguments.merge and (reports or not documents):
        raise TwistError("--merge needs two sessions")
    if reports:
        return _diff_reports(arguments)
    if documents:
        return diff_sessions(arguments)
    if arguments.a.is_dir() or arguments.b.is_dir():
        return diff_folders(arguments)
    return _diff_clips(arguments)


def _is_document(path: Path) -> bool:
    return ".json" in path.suffixes and not path.is_dir()  # including NAME.twist.json.earlier


def _diff_clips(arguments: argparse.Namespace) -> int:
    names = clip_name_for_messages(arguments.a), clip_name_for_messages(arguments.b)
    if names == ("-", "-"):
        raise TwistError("- (standard input) can be given only once")
    a, b = read_clip_or_stdin(arguments.a), read_clip_or_stdin(arguments.b)
    for name, clip in zip(names, (a, b), strict=True):
        print_clip_notes(name, clip)
    try:
        difference = compare_motions(a.motion, b.motion)
    except ClipMismatchError as error:
        raise ClipMismatchError(f"{', '.join(names)}: {error}") from None
    if arguments.json:
        print_json(difference_to_json(difference, *names))
        return 0
    width = max([24, *(len(terminal_text(j.joint)) for j in difference.joints)])
    if difference.joints:
        print_result(f"{'joint':<{width}} {'start':>7} – {'stop':<7} rotation differs", head=True)
    for j in difference.joints:
        name = f"{terminal_text(j.joint):<{width}}"
        print_result(f"{name} {j.start:>7} – {j.stop:<7} up to {j.max_degrees:8.3f}°")
    for m in difference.moved:
        frames = count_with_noun(m.frames, "frame")
        print_result(
            f"{m.joint} moves by up to {m.of_height:.2g} of the figure's height in {frames}"
        )
    print_result(
        "rotations differ in "
        f"{count_with_noun(len({j.joint for j in difference.joints}), 'joint')} and "
        f"{count_with_noun(difference.frames, 'frame')}; joints move by at most "
        f"{difference.max_position_of_height:.2g} of the figure's height"
    )
    return 0


def _diff_reports(arguments: argparse.Namespace) -> int:
    found = compare_report_files(arguments.a, arguments.b)
    if arguments.json:
        print_json(found)
        return 0
    for i in found["changes"]:
        decisions = " → ".join(filter(None, (i["before"], i["after"])))
        print_result(
            f"{i['change']:<20} {i['chain']} {i['start']} – {i['stop']}: {i['kind']}, {decisions}"
        )
    print_result(
        f"{count_with_noun(len(found['changes']), 'difference')}; {found['same']} intervals are "
        "the same"
    )
    return 0
