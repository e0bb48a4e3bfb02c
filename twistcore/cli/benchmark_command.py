"""Run `twistcore benchmark`, which compares detectors and other methods on a folder of clips."""

from __future__ import annotations

import argparse
import hashlib
import json
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import platformdirs

from twistcore.cli.output import (
    clip_progress_printer,
    print_problem,
    print_result_lines,
    refuse_overwrite,
    report_problems,
)
from twistcore.detection import DETECTORS
from twistcore.errors import TwistError
from twistcore.files.atomic import is_stream, write_atomically
from twistcore.files.encoding import encode_utf8, json_bytes
from twistcore.files.ordinary import real_path, user_folder_or_uncreatable_path
from twistcore.study.benchmark.baselines import BASELINES
from twistcore.study.benchmark.clip_run import BenchmarkSettings
from twistcore.study.benchmark.hinge import HINGE
from twistcore.study.benchmark.markdown import benchmark_to_markdown
from twistcore.study.benchmark.passes import benchmark_method_names
from twistcore.study.benchmark.runner import find_benchmark_clips, run_benchmark
from twistcore.study.benchmark.tables import benchmark_rows, benchmark_to_json, rows_to_csv
from twistcore.synthesis import parse_protocol


def benchmark_command(arguments: argparse.Namespace) -> int:
    """Print the tables and write the files. Return 1 if some clips failed, 2 if all failed."""
    settings = BenchmarkSettings(
        protocols=_protocols(arguments.protocol or ["P0"]),
        methods=_methods(_named(arguments)),
        seeds=tuple(range(arguments.seed, arguments.seed + arguments.seeds)),
    )
    folder: Path = arguments.folder
    clips = find_benchmark_clips(folder)
    refuse_overwrite([t for t in (arguments.json, arguments.csv) if t], clips.values())
    summary = run_benchmark(
        clips,
        settings,
        workers=arguments.workers or os.cpu_count() or 1,
        partial=unfinished_benchmark_path(folder, arguments.json, settings),
        resume=arguments.resume,
        counter=clip_progress_printer,
    )
    source = real_path(folder).name
    print_result_lines(benchmark_to_markdown(summary, settings, source))
    if arguments.json:
        document = benchmark_to_json(summary, settings, source)
        write_atomically(arguments.json, json_bytes(document))
    if arguments.csv:
        write_atomically(arguments.csv, encode_utf8(rows_to_csv(benchmark_rows(summary, settings))))
    code = report_problems([sentence for _, sentence in summary.problems], summary.clips)
    if summary.missing:
        print_problem(
            f"stopped: {summary.missing} of {len(clips)} clips are left; continue with --resume"
        )
        return 130
    return code


def unfinished_benchmark_path(
    folder: Path, json_file: Path | None, settings: BenchmarkSettings
) -> Path:
    """Return the path for the results of an unfinished run, next to the JSON file or in a cache."""
    if json_file and not is_stream(json_file):
        return json_file.with_name(f"{json_file.name}.partial.jsonl")
    words = json.dumps([str(real_path(folder)), settings.to_json()])
    name = hashlib.sha256(words.encode()).hexdigest()[:16]
    folder = user_folder_or_uncreatable_path(
        partial(platformdirs.user_cache_path, "twist-inspector")
    )
    return folder / "benchmark" / f"{name}.jsonl"


def _protocols(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the protocols without duplicates. 'P0-all' is another name of 'P0'.

    Raises TwistError for an unknown protocol.
    """
    plain = ["P0" if name == "P0-all" else name for name in _split(names)]
    return tuple(dict.fromkeys(parse_protocol(name).name for name in plain))


def _named(arguments: argparse.Namespace) -> list[str]:
    """Return the methods named by --methods ('all' by default) and the detector of --detector."""
    named = list(arguments.methods or ["all"])
    return [*named, arguments.method] if arguments.detector else named


def _methods(names: Sequence[str]) -> tuple[str, ...]:
    """Return the chosen methods in the order of the table. Raises TwistError for an unknown name.

    `names` may contain 'all', 'detectors' and 'baselines' for groups of methods.
    """
    known = benchmark_method_names()
    groups = {"all": known, "detectors": DETECTORS.ready(), "baselines": (HINGE, *BASELINES)}
    chosen: set[str] = set()
    for name in _split(names):
        if name not in groups and name not in known:
            raise TwistError(
                f"--methods: unknown method {name!r}; expected one of "
                f"{', '.join((*known, *groups))}"
            )
        chosen.update(groups.get(name, (name,)))
    return tuple(m for m in known if m in chosen)


def _split(names: Sequence[str]) -> list[str]:
    return [part for name in names for part in name.split(",") if part]
