"""Define the arguments that several commands share, and import a command only when it runs.

Commands are imported late because importing numpy and scipy is slow.
"""

from __future__ import annotations

import argparse
import gc
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    Parser,
    parse_clip_input_path,
    parse_clip_output_path,
    parse_frame_rate,
    parse_seed,
    parse_worker_count,
)


def deferred_command(module: str, name: str) -> Callable[[argparse.Namespace], int]:
    """Return a function that imports a module of twistcore.cli and runs a command in it.

    `module` and `name` are the names of the module and of the command's function.
    """

    def run(arguments: argparse.Namespace) -> int:
        carry_out = getattr(import_module(f"twistcore.cli.{module}"), name)
        if getattr(arguments, "alone", False):  # `main` has disabled the collection
            gc.freeze()  # exclude the modules from garbage collection, since they stay loaded
            gc.enable()
        return int(carry_out(arguments))

    return run


def add_commands(parser: argparse.ArgumentParser) -> argparse._SubParsersAction[Parser]:
    """Add subcommands to a parser. Without a subcommand, the program prints the help."""

    def print_help(_: argparse.Namespace) -> int:
        parser.print_help()
        return 0

    parser.set_defaults(run=print_help, command=parser.prog, quiet=False, verbose=False)
    return parser.add_subparsers(prog=parser.prog, metavar="COMMAND", parser_class=Parser)


def add_clip(parser: argparse.ArgumentParser, what: str = "the clip to read") -> None:
    """Add the argument for the one clip that a command processes."""
    parser.add_argument("clip", type=Path, metavar="CLIP", help=what)


def add_clips(parser: argparse.ArgumentParser) -> None:
    """Add the argument for one or more clips that a command only reads."""
    parser.add_argument(
        "clips",
        type=parse_clip_input_path,
        nargs="+",
        metavar="CLIP",
        help="one or more clips; '-' reads a BVH from standard input",
    )


def add_reference(parser: argparse._ActionsContainer) -> None:
    """Add the option --reference, another take of the same skeleton for comparison."""
    parser.add_argument(
        "--reference",
        type=Path,
        metavar="CLIP",
        help="another take with the same skeleton; bones that differ from it by more than 30° in "
        "every frame are noted (default: none)",
    )


def add_fps(parser: argparse._ActionsContainer) -> None:
    """Add the option --fps, a frame rate to use instead of the file's."""
    parser.add_argument(
        "--fps",
        type=parse_frame_rate,
        metavar="HZ",
        help="frame rate to use instead of the file's (default: the file's)",
    )


def add_output(
    parser: argparse.ArgumentParser,
    what: str = "clip to write; '-' is standard output",
    parse: Callable[[str], object] = parse_clip_output_path,
    metavar: str = "OUT",
) -> None:
    """Add the option -o for the clip, file or folder to write."""
    parser.add_argument("-o", "--output", type=parse, required=True, metavar=metavar, help=what)


def add_workers(parser: argparse._ActionsContainer, what: str = "number of processes") -> None:
    """Add the option --workers, the number of processes to use."""
    what = f"{what} (default: one for each core)"
    parser.add_argument("--workers", type=parse_worker_count, metavar="N", help=what)


def add_seed(parser: argparse.ArgumentParser, default: int, what: str = "the first seed") -> None:
    """Add the option --seed for random numbers."""
    what = f"{what} (default: %(default)s)"
    parser.add_argument("--seed", type=parse_seed, default=default, metavar="N", help=what)


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add the option --json, which prints a JSON document instead of text."""
    parser.add_argument(
        "--json",
        action="store_true",
        help="print one JSON document instead of text (docs/formats.md)",
    )


def add_verbosity_options(parser: argparse.ArgumentParser) -> None:
    """Add the options --quiet and --verbose."""
    voice = parser.add_mutually_exclusive_group()
    voice.add_argument("-q", "--quiet", action="store_true", help="print only results and errors")
    voice.add_argument(
        "-v",
        "--verbose",
        action="store_true",
        help="also print each step and its duration on standard error",
    )
