"""The words of `twistcore batch`, without loading what carries it out."""

from __future__ import annotations

import argparse
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    kinds,
    mebibytes,
    positive,
    rate,
    share,
    target,
    tau_degrees,
    workers,
)
from twistcore.cli.arguments.common_arguments import add_method, deferred

BATCH = "batch"

_ABOUT = """\
Look at many clips, each by itself: one that crashes, hangs or takes too much memory is listed, and
the others go on. OUTDIR keeps what became of each in manifest.sqlite. The same command again does
only what is new: other bytes, other options or another version; a run that was stopped or killed
goes on.
"""
_EXITS = """\
Exit code: 0 done; 1 finished, but a clip could not be processed, a word named no clip, with
--refine an interval could not be corrected, or a rule of --fail-if is broken; all listed; 2 wrong
words, or no clip that could be read; 130 stopped by Ctrl+C.
"""


def add_batch(parser: argparse.ArgumentParser) -> None:
    """Put them into a parser."""
    parser.description, parser.epilog = _ABOUT, _EXITS
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument(
        "paths",
        nargs="*",
        metavar="PATH",
        help="clip, folder with all below, quoted pattern (** goes over folders), URL, @FILE with "
        "one of these a line, or '-' for such a list on standard input",
    )
    parser.add_argument(
        "--from", dest="lists", action="append", default=[], metavar="FILE", help="as @FILE"
    )
    parser.add_argument(
        "-o", "--output", required=True, metavar="OUTDIR", help="folder of the results, or its URL"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=workers, metavar="N", help="processes; default all cores")
    where.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster, tcp://HOST:PORT")
    where.add_argument(
        "--local-cluster", type=workers, metavar="N", help="start a Dask cluster of N workers here"
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on: what the command does in any case"
    )
    parser.add_argument("--shard", type=shard, default=(1, 1), metavar="I/N", help="one of N parts")
    parser.add_argument(
        "--time-limit",
        type=positive,
        metavar="SECONDS",
        help="of processor time that a clip may take; default 300 and 60 more for every megabyte",
    )
    parser.add_argument(
        "--memory-limit",
        type=mebibytes,
        metavar="MIB",
        help="a clip may take beyond 12 times its size; default 1430, 256 at least",
    )
    _detection(parser)
    parser.add_argument("--refine", action="store_true", help="also write corrected clips")
    parser.add_argument(
        "--min-confidence", type=share, metavar="X", help="of what is corrected, as of refine"
    )
    parser.add_argument(
        "--include-open", action="store_true", help="also correct intervals that are open"
    )
    parser.add_argument("--report", action="store_true", help="write OUTDIR/report/index.html")
    for name, what in (
        ("jsonl", "a JSON document a line"),
        ("parquet", "a table"),
        ("csv", "a table"),
        ("junit", "JUnit XML for CI"),
    ):
        parser.add_argument(f"--{name}", type=target, metavar="FILE", help=f"results: {what}")
    parser.add_argument(
        "--fail-if",
        action="append",
        default=[],
        metavar="RULE",
        help="exit 1 where a rule holds, as 'severity>5' (again for more; docs/gates.md)",
    )
    parser.set_defaults(run=deferred("batch_command", "batch_command"))


def shard(text: str) -> tuple[int, int]:
    """'2/5' as (2, 5)."""
    index, slash, number = text.partition("/")
    if not (slash and index.isdecimal() and number.isdecimal() and 1 <= int(index) <= int(number)):
        raise argparse.ArgumentTypeError(f"expected I/N with 1 ≤ I ≤ N, as 2/5, found {text!r}")
    return int(index), int(number)


def _detection(parser: argparse.ArgumentParser) -> None:
    group = parser.add_argument_group("as of detect")
    add_method(group)
    group.add_argument("--tau", type=tau_degrees, metavar="auto|DEG")
    group.add_argument("--profile", type=Path, metavar="FILE")
    group.add_argument("--kinds", type=kinds, metavar="LIST")
    group.add_argument("--fps", type=rate)
    group.add_argument("--chain", action="append", metavar="NAME")
    group.add_argument("--person", action="append", metavar="NAME")
    group.add_argument("--rig", type=Path, metavar="FILE")
    group.add_argument("--joint-names", type=Path, metavar="FILE")
