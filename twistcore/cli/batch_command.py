"""Run `twistcore batch`, which processes many clips and writes the results into a folder."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from twistcore.batch.clip_task import ClipTask, Outcome, run_task
from twistcore.batch.inputs import Inputs, find_input_clips
from twistcore.batch.manifest import ClipRecord, Manifest
from twistcore.batch.parameters import Parameters
from twistcore.batch.remote_folder import synchronised_batch_folder
from twistcore.batch.run import CarryOut, Limits, run_batch
from twistcore.cli.batch_progress import show_batch_progress
from twistcore.cli.output import (
    clip_progress_printer,
    count_with_noun,
    print_note,
    print_problem,
    print_remark,
    refuse_overwrite,
)
from twistcore.detection.registry import DETECTORS
from twistcore.errors import TwistError
from twistcore.work.memory import SPARE
from twistcore.work.processes import map_in_processes

_FILES = ("jsonl", "parquet", "csv", "junit", "annotations")
_MIB = 1 << 20


def batch_command(arguments: argparse.Namespace) -> int:
    """Process the clips, write the result files, check the rules, and return the exit code."""
    if not arguments.output:
        useful = arguments.fail_if or any(getattr(arguments, name) for name in _FILES)
        if arguments.refine or arguments.report or not useful:
            raise TwistError(
                "expected -o OUTDIR; it is optional only with --fail-if or a results file, and "
                "without --refine and --report. See `twistcore batch --help`."
            )
    process_clips = prepare_batch_processing(arguments)
    words = [*arguments.paths, *(f"@{name}" for name in arguments.lists)]
    if not words:
        raise TwistError(
            "expected a clip, folder, pattern, URL or --from FILE. See `twistcore batch --help`."
        )
    code, _ = process_clips(
        find_input_clips(words, without=permanent_local_output_folder(arguments))
    )
    return code


def permanent_local_output_folder(arguments: argparse.Namespace) -> Path | None:
    """Return the folder for the results, or None if it is temporary or at a URL.

    Clips in this folder are not processed.
    """
    output = arguments.output
    return None if not output or "://" in output else Path(output)


def prepare_batch_processing(arguments: argparse.Namespace) -> Callable[..., tuple[int, bool]]:
    """Check the options and rules, and return a function that processes clips with them.

    The returned function takes :class:`Inputs`, and returns the exit code and whether the run ended
    early. With ``all_pages=False``, the report keeps the pages of clips that this run does not
    process.
    """
    return partial(_processed, arguments, _rules(arguments), _parameters(arguments))


def _processed(
    arguments: argparse.Namespace,
    rules: Sequence[Any],
    parameters: Parameters,
    inputs: Inputs,
    *,
    all_pages: bool = True,
) -> tuple[int, bool]:
    sources = {source.path for source in inputs.sources}
    targets = [getattr(arguments, name) for name in _FILES if getattr(arguments, name)]
    if targets:
        local = [Path(source.path) for source in inputs.sources if "://" not in source.path]
        refuse_overwrite(targets, local)
    with synchronised_batch_folder(arguments.output) as folder:
        with _carrying_out(arguments) as carry_out:
            summary = run_batch(
                folder,
                inputs.sources,
                parameters,
                carry_out,
                limits=_limits(arguments),
                part=arguments.shard,
                begin=show_batch_progress,
            )
        for sentence in (*inputs.problems, *summary.failed):
            print_problem(sentence)
        skipped = arguments.refine and _tell_uncorrected(folder, sources)
        blind = _tell_doubts(folder, sources)
        pages = None if all_pages else summary.names
        broken = _written(arguments, folder, sources, rules, pages)
    if summary.stopped:
        left = f"{summary.left} clips are left; run the same command to continue"
        print_problem(f"{summary.stopped}: {left}")
    counts = f"{count_with_noun(summary.done, 'clip')} done, {summary.known} done before"
    counts += f", {len(summary.failed)} failed"
    exports = f"; {_exports(inputs.exports)} skipped" if inputs.exports else ""
    print_remark(f"{f'{arguments.output}: ' if arguments.output else ''}{counts}{exports}")
    if summary.stopped == "stopped":
        return 130, True
    if summary.unreadable and not summary.done + summary.known + summary.left:
        return (1 if summary.unreadable < len(summary.failed) else 2), bool(summary.stopped)
    wrong = summary.failed or summary.stopped or inputs.problems or skipped or broken or blind
    return int(bool(wrong)), bool(summary.stopped)


def _tell_uncorrected(folder: Path, sources: Collection[str]) -> bool:
    """Print the intervals that could not be corrected. Return True if there are any."""
    any_left = False
    with Manifest.open(folder) as manifest:
        for source, name, sentences in manifest.uncorrected():
            if source in sources:
                any_left = True
                for sentence in sentences:
                    print_problem(f"{name}: {sentence}")
    return any_left


def _tell_doubts(folder: Path, sources: Collection[str]) -> bool:
    """Print how many clips could not be examined, were examined only in part, or lack frames.

    Returns True if a clip could not be examined at all.
    """
    with Manifest.open(folder) as manifest:
        found = [one for one in manifest.glances() if one.source in sources]
    if unchecked := [one for one in found if one.unchecked]:
        first = f"{unchecked[0].name}: {unchecked[0].unchecked}"
        print_problem(f"{count_with_noun(len(unchecked), 'clip')} could not be examined: {first}")
    if part := [one for one in found if one.unexamined]:
        first = f"{part[0].name}: {count_with_noun(part[0].unexamined, 'limb')}"
        print_note(f"limbs were not examined in {count_with_noun(len(part), 'clip')}: {first}")
    if cut := [one for one in found if one.missing_frames]:
        first = f"{cut[0].name}: {count_with_noun(cut[0].missing_frames, 'frame')}"
        print_note(
            "frames that the header declares are missing from "
            f"{count_with_noun(len(cut), 'clip')}: {first}"
        )
    return bool(unchecked)


def _exports(count: int) -> str:
    return "1 export of another clip" if count == 1 else f"{count} exports of other clips"


def _written(
    arguments: argparse.Namespace,
    folder: Path,
    sources: Collection[str],
    rules: Sequence[Any],
    pages: Collection[str] | None,
) -> bool:
    """Write the result files and the report, and print broken rules.

    `pages` has the names of the clips whose pages must be written again, None for all. Returns True
    if a rule is broken or the report has problems.
    """
    broken: list[Any] = []
    if rules or any(getattr(arguments, name) for name in _FILES):
        from twistcore.batch.gates import broken_rules as broken_of

        with Manifest.open(folder) as manifest:

            def records() -> Iterator[ClipRecord]:
                return (r for r in manifest.each_record() if r.source in sources)

            broken = broken_of(rules, records())
            _write_files(arguments, records, rules, broken)
    for one in broken:
        print_problem(one)
    if arguments.report:
        return _reported(arguments, folder, broken, pages) or bool(broken)
    return bool(broken)


def _reported(
    arguments: argparse.Namespace,
    folder: Path,
    broken: Sequence[Any],
    pages: Collection[str] | None,
) -> bool:
    """Write the report on the whole batch folder. Return True if there are problems.

    The parameters are those of :func:`_written`.
    """
    write = import_module("twistcore.report.folder_report").write_folder_report
    workers = arguments.workers or os.cpu_count() or 1
    more = {"broken": broken, "counter": clip_progress_printer, "changed": pages}
    report = write(folder, folder / "report", workers=workers, **more)
    for sentence in report.problems:
        print_problem(sentence)
    return bool(report.problems)


def _write_files(
    arguments: argparse.Namespace,
    records: Callable[[], Iterator[ClipRecord]],
    rules: Sequence[Any],
    broken: Sequence[Any],
) -> None:
    from twistcore.batch import result_files

    if arguments.jsonl:
        result_files.write_json_lines(arguments.jsonl, records())
    if arguments.parquet:
        result_files.write_interval_parquet(arguments.parquet, records())
    if arguments.csv:
        result_files.write_clip_table(arguments.csv, records())
    if arguments.junit:
        from twistcore.batch.junit import write_junit

        write_junit(arguments.junit, records(), rules, broken)
    if arguments.annotations:
        from twistcore.batch.annotations import write_annotations

        write_annotations(arguments.annotations, records(), broken)


def _rules(arguments: argparse.Namespace) -> list[Any]:
    if not arguments.fail_if:
        return []
    from twistcore.batch.gates import parse_batch_rule  # numpy, scipy

    return [parse_batch_rule(text) for text in arguments.fail_if]


def _parameters(arguments: argparse.Namespace) -> Parameters:
    """Return the processing parameters that the options specify.

    The parameters contain the contents of files such as the profile, because other machines may not
    have these files.
    """
    profile, rig = None, None
    if arguments.detector and arguments.scheduler:
        raise TwistError(
            "--detector cannot be combined with --scheduler, because the machines of the "
            "cluster do not have the file; install the detector there as a package with an "
            "entry point (docs/detectors.md)"
        )
    if arguments.profile:
        from twistcore.tuning import read_profile

        found = read_profile(arguments.profile)
        if found.method not in ("", arguments.method):
            print_note(
                f"{arguments.profile}: note: tuned for the detector {found.method}, "
                f"but used with {arguments.method}"
            )
        profile = dict(found.tau)
    if arguments.rig:
        from twistcore.skeleton.rig import read_rig, rig_to_json

        rig = rig_to_json(read_rig(arguments.rig))
    words = None
    if arguments.joint_names:
        from twistcore.skeleton.joint_names import read_joint_vocabulary_file

        words = read_joint_vocabulary_file(arguments.joint_names)
    if not arguments.refine and (arguments.include_open or arguments.min_confidence is not None):
        raise TwistError("--min-confidence and --include-open require --refine")
    return Parameters(
        method=arguments.method,
        tau_deg=arguments.tau,
        profile_rad=profile,
        kinds=tuple(sorted(kind.value for kind in arguments.kinds or ())),
        chains=tuple(arguments.chain or ()),
        people=tuple(arguments.person or ()),
        fps=arguments.fps,
        rig=rig,
        joint_names=words,
        refine=arguments.refine,
        min_confidence=arguments.min_confidence,
        include_open=arguments.include_open,
        detector_version=DETECTORS.version(arguments.method),
    )


def _limits(arguments: argparse.Namespace) -> Limits:
    memory = SPARE if arguments.memory_limit is None else round(arguments.memory_limit * _MIB)
    return Limits(arguments.time_limit, memory)


@contextmanager
def _carrying_out(arguments: argparse.Namespace) -> Iterator[CarryOut]:
    """Yield a function that runs tasks, in processes on this machine or on a cluster."""
    if not (arguments.scheduler or arguments.local_cluster):
        yield partial(_in_processes, workers=arguments.workers or os.cpu_count() or 1)
        return
    from twistcore.batch.dask_cluster import open_dask_cluster

    with open_dask_cluster(arguments.scheduler, arguments.local_cluster) as carry_out:
        yield carry_out


def _in_processes(
    tasks: Sequence[ClipTask], seconds: Callable[[ClipTask], float], *, workers: int
) -> Iterator[tuple[ClipTask, Outcome | Exception]]:
    return map_in_processes(run_task, tasks, workers, apart=True, seconds=seconds)
