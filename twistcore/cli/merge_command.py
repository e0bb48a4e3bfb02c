"""Run `twistcore merge`, which merges several batch folders into one folder."""

from __future__ import annotations

import argparse

from twistcore.batch.merging import merge
from twistcore.cli.output import count_of, problem, remark


def merge_command(arguments: argparse.Namespace) -> int:
    """Merge batch folders, and print the failed clips, the problems and the clip counts.

    Returns the exit code: 0 if all clips have a result and all files were copied, and 1 if not.
    """
    merged = merge(arguments.folders, arguments.output)
    for sentence in (*merged.failed, *merged.problems):
        problem(sentence)
    if merged.waiting:
        problem(f"{count_of(merged.waiting, 'clip')} not processed yet")
    counts = f"{count_of(merged.done, 'clip')} done, {len(merged.failed)} failed"
    remark(f"{arguments.output}: {counts}, from {count_of(len(arguments.folders), 'folder')}")
    return int(bool(merged.failed or merged.problems or merged.waiting))
