"""`twistcore merge`: merge the folders of several batches, such as shards, into one."""

from __future__ import annotations

import argparse

from twistcore.batch.merging import merge
from twistcore.cli.output import count_of, problem, remark


def merge_command(arguments: argparse.Namespace) -> int:
    """Merge the folders, list the clips without a result, and return the exit code."""
    merged = merge(arguments.folders, arguments.output)
    for sentence in (*merged.failed, *merged.problems):
        problem(sentence)
    if merged.waiting:
        problem(f"{count_of(merged.waiting, 'clip')} not processed yet")
    counts = f"{count_of(merged.done, 'clip')} done, {len(merged.failed)} failed"
    remark(f"{arguments.output}: {counts}, from {count_of(len(arguments.folders), 'folder')}")
    return int(bool(merged.failed or merged.problems or merged.waiting))
