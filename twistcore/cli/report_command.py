"""Run `twistcore report`, which writes the report on a session or on a batch folder."""

from __future__ import annotations

import argparse
from pathlib import Path

from twistcore.cli.clip_inputs import print_clip_notes
from twistcore.cli.output import (
    clip_progress_printer,
    count_with_noun,
    print_remark,
    report_problems,
)
from twistcore.errors import TwistError
from twistcore.files.ordinary import path_exists
from twistcore.formats.reading import companion_file_prefix, read_clip
from twistcore.report.clip_report import check_report_replaceable, write_clip_report
from twistcore.report.document import Report
from twistcore.report.folder_report import write_folder_report
from twistcore.review import read_session
from twistcore.review.replay import accepted_motion, session_chains


def report_command(arguments: argparse.Namespace) -> int:
    """Write the report and return the exit code, which is 1 if a clip can no longer be read."""
    if path_exists(arguments.output) and not arguments.output.is_dir():
        raise TwistError(f"{arguments.output} is a file; choose a folder for the report")
    if arguments.what.is_dir():
        if arguments.clip:
            raise TwistError(
                f"--clip selects a clip of a session, but {arguments.what} is a folder; "
                "leave --clip out"
            )
        return _of_folder(arguments)
    return _of_session(arguments)


def _of_folder(arguments: argparse.Namespace) -> int:
    written = write_folder_report(
        arguments.what,
        arguments.output,
        workers=arguments.workers,
        pictures=not arguments.no_pictures,
        play=arguments.play,
        most_pages=arguments.pages,
        counter=clip_progress_printer,
    )
    print_remark(f"{written.index}: {count_with_noun(written.pages, 'page')} of clips")
    return report_problems(written.problems, done=1)


def _of_session(arguments: argparse.Namespace) -> int:
    session = read_session(arguments.what)
    clip = read_clip(arguments.clip or Path(session.clip), fps=session.fps)
    print_clip_notes(clip.path, clip)
    chains = session_chains(session, clip)
    name = companion_file_prefix(clip.path)
    check_report_replaceable(arguments.output, name, clip)
    refined = accepted_motion(clip, chains, session.state)
    made = Report(clip, chains, session.state, refined, name)
    drawn = not arguments.no_pictures
    page, *_ = write_clip_report(arguments.output, made, pictures=drawn, play=drawn)
    print_remark(f"{page}: {len(session.state.intervals)} intervals")
    return 0
