"""`twistcore batch`."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from twistcore.batch.batch_run import CarryOut, Limits, Summary, run_batch
from twistcore.batch.clip_task import Outcome, Task, process
from twistcore.batch.inputs import find_inputs
from twistcore.batch.manifest import ClipRecord, Manifest
from twistcore.batch.parameters import Parameters
from twistcore.cli.batch_progress import begin
from twistcore.cli.output import refuse_overwrite
from twistcore.errors import TwistError
from twistcore.processes import each

_MIB = 1 << 20


def batch(arguments: argparse.Namespace) -> int:
    """Process the clips, then write and check what was asked for."""
    folder = Path(arguments.output)
    rules = _rules(arguments)
    parameters = _parameters(arguments)
    words = [*arguments.paths, *(f"@{name}" for name in arguments.lists)]
    if not words:
        raise TwistError("expected clips, folders, patterns, URLs or --from FILE")
    inputs = find_inputs(words, without=folder)
    files = _result_files(arguments)
    refuse_overwrite(list(files), [Path(s.path) for s in inputs.sources if "://" not in s.path])
    with _carrying_out(arguments) as carry_out:
        summary = run_batch(
            folder,
            inputs.sources,
            parameters,
            carry_out,
            limits=_limits(arguments),
            part=arguments.shard,
            begin=begin,
        )
    for problem in (*inputs.problems, *summary.failed):
        print(problem, file=sys.stderr)
    broken: list[str] = []
    with Manifest.open(folder) as manifest:
        chosen = {source.path for source in inputs.sources}
        if rules or files or not summary.stopped:
            broken = _results(manifest, chosen, rules, files, arguments)
        _tell(folder, summary)
    if summary.stopped == "stopped":
        return 130
    if summary.stopped or inputs.problems or broken:
        return 1
    good = summary.done + summary.known
    return (1 if good else 2) if summary.failed else 0
