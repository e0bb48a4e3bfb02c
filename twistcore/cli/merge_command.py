"""Run `twistcore merge`, which merges several batch folders into one folder."""

from __future__ import annotations

import argparse

from twistcore.batch.merging import merge_batch_folders
from twistcore.cli.output import count_with_noun, print_problem, print_remark


def merge_command(arguments: argparse.Namespace) -> int:
    """Merge batch folders, and print the failed clips, the problems and the clip counts.

    Returns the exit code: 0 if all clips have a result and all files were copied, and 1 if not.
    """
    merged = merge_batch_folders(arguments.folders, arguments.output)
    for sentence in (*merged.failed, *merged.problems):
        print_problem(sentence)
    if merged.waiting:
        print_problem(f"{count_with_noun(merged.waiting, 'clip')} not processed yet")
    counts = f"{count_with_noun(merged.done, 'clip')} done, {len(merged.failed)} failed"
    print_remark(
        f"{arguments.output}: {counts}, from {count_with_noun(len(arguments.folders), 'folder')}"
    )
    return int(bool(merged.failed or merged.problems or merged.waiting))
