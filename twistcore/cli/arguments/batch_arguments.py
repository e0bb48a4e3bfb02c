"""Define the arguments of `twistcore batch`, `twistcore watch` and `twistcore merge`."""

from __future__ import annotations

import argparse

from twistcore.cli.arguments.argument_types import (
    parse_mebibytes,
    parse_non_negative_number,
    parse_output_folder,
    parse_output_path,
    parse_positive_number,
    parse_tau_degrees,
    parse_worker_count,
)
from twistcore.cli.arguments.common_arguments import add_output, add_workers, deferred_command
from twistcore.cli.arguments.detection_arguments import add_correction_options, add_detection


def add_batch(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `twistcore batch` to a parser."""
    parser.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="clip, folder with all its subfolders, quoted pattern (** matches subfolders, too), "
        "URL, @FILE with one of these per line, or '-' for such a list on standard input",
    )
    parser.add_argument(
        "--from",
        dest="lists",
        action="append",
        default=[],
        metavar="FILE",
        help="file with one PATH per line, like @FILE; repeatable (default: none)",
    )
    parser.add_argument(
        "-o",
        "--output",
        default="",
        metavar="OUTDIR",
        help="folder for the results, or its URL (default: no folder, which is possible only "
        "with --fail-if or a results file, and without --refine and --report)",
    )
    parser.add_argument(
        "--resume",
        action="store_true",
        help="continue an interrupted run; this is also the default",
    )
    _add_processing(parser)
    parser.set_defaults(run=deferred_command("batch_command", "batch_command"))


def add_watch_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `twistcore watch` to a parser."""
    parser.add_argument(
        "folder",
        type=parse_output_folder,
        metavar="FOLDER",
        help="folder to watch, with all its subfolders",
    )
    add_output(parser, "folder for the results, or its URL", str, "OUTDIR")
    parser.add_argument(
        "--every",
        type=parse_positive_number,
        default=5.0,
        metavar="SECONDS",
        help="time between two checks of the folder; a clip is read when two checks in a row "
        "find it unchanged (default: 5)",
    )
    parser.add_argument(
        "--once",
        action="store_true",
        help="process the clips that are in the folder now, and exit; clips that are still "
        "being written are listed",
    )
    parser.add_argument(
        "--idle",
        type=parse_non_negative_number,
        metavar="SECONDS",
        help="exit when no clip has been added, changed or removed for this long (default: never)",
    )
    _add_processing(parser)
    parser.set_defaults(run=deferred_command("watch_command", "watch_command"))


def add_merge(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `twistcore merge` to a parser."""
    parser.add_argument(
        "folders",
        nargs="+",
        type=parse_output_folder,
        metavar="FOLDER",
        help="OUTDIR of a batch; it is not changed",
    )
    what = "folder for the merged results: a new one, or the OUTDIR of a batch"
    add_output(parser, what, parse_output_folder, "OUTDIR")
    parser.set_defaults(run=deferred_command("merge_command", "merge_command"))


def _add_processing(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group()
    add_workers(where)
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run on this Dask cluster, tls://HOST:PORT (default: on this machine)",
    )
    where.add_argument(
        "--local-cluster",
        type=parse_worker_count,
        metavar="N",
        help="start a Dask cluster of N workers on this machine (default: none)",
    )
    parser.add_argument(
        "--shard",
        type=parse_shard,
        default=(1, 1),
        metavar="I/N",
        help="divide the clips into N parts, and process only part I (default: 1/1)",
    )
    parser.add_argument(
        "--time-limit",
        type=parse_positive_number,
        metavar="SECONDS",
        help="processor time that a clip may take (default: 300, plus 60 for each megabyte)",
    )
    parser.add_argument(
        "--memory-limit",
        type=parse_mebibytes,
        metavar="MIB",
        help="memory that a clip may use in addition to 12 times its size, at least 256 "
        "(default: 1430)",
    )
    add_detection(
        parser.add_argument_group("detection, as in `twistcore detect`"), parse_tau_degrees
    )
    parser.add_argument("--refine", action="store_true", help="also write corrected clips")
    add_correction_options(parser)
    parser.add_argument("--report", action="store_true", help="also write OUTDIR/report/index.html")
    for name, what in (
        ("jsonl", "JSON documents, one per line"),
        ("parquet", "a Parquet table"),
        ("csv", "a CSV table"),
        ("junit", "JUnit XML for CI"),
        ("annotations", "annotations that GitHub shows next to the files; '-' is standard output"),
    ):
        parser.add_argument(
            f"--{name}",
            type=parse_output_path,
            metavar="FILE",
            help=f"write the results as {what} (default: none)",
        )
    parser.add_argument(
        "--fail-if",
        action="append",
        default=[],
        metavar="RULE",
        help="exit with 1 if a rule such as 'severity>5' is broken; repeatable "
        "(docs/gates.md; default: none)",
    )


def parse_shard(text: str) -> tuple[int, int]:
    """Return the index and the number of shards, such as (2, 5) for '2/5'."""
    index, slash, number = text.partition("/")
    if not (slash and index.isdecimal() and number.isdecimal() and 1 <= int(index) <= int(number)):
        raise argparse.ArgumentTypeError(
            f"expected I/N with 1 ≤ I ≤ N, such as 2/5, found {text!r}"
        )
    return int(index), int(number)
