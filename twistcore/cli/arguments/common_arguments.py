"""Words that several commands have, and what carries a command out, loaded when it is called."""

from __future__ import annotations

import argparse
import gc
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    KINDS,
    clip_target,
    kinds,
    rate,
    readable,
    tau,
    workers,
)
from twistcore.detection.registry import DEFAULT_METHOD, DETECTORS


def deferred(module: str, name: str) -> Callable[[argparse.Namespace], int]:
    """A function of a module of this folder's parent, which loads numpy and scipy when called."""

    def run(arguments: argparse.Namespace) -> int:
        carry_out = getattr(import_module(f"twistcore.cli.{module}"), name)
        if not gc.isenabled():  # as the command's own process begins
            gc.freeze()  # modules stay to the end: no need to search them for garbage each time
            gc.enable()
        return int(carry_out(arguments))

    return run


def add_clip(parser: argparse.ArgumentParser) -> None:
    """One clip that something else is made of."""
    parser.add_argument("clip", type=Path, metavar="CLIP")


def add_clips(parser: argparse.ArgumentParser) -> None:
    """Clips that are only read."""
    parser.add_argument(
        "clips",
        type=readable,
        nargs="+",
        metavar="CLIP",
        help="one or more; '-': a BVH on standard input",
    )


def add_fps(parser: argparse.ArgumentParser) -> None:
    """The rate."""
    parser.add_argument("--fps", type=rate, metavar="HZ", help="instead of the file's rate")


def add_output(parser: argparse.ArgumentParser) -> None:
    """The clip to write."""
    parser.add_argument(
        "-o",
        "--output",
        type=clip_target,
        required=True,
        metavar="OUT",
        help="'-': standard output",
    )


def add_workers(parser: argparse.ArgumentParser) -> None:
    """Processes over folders."""
    parser.add_argument(
        "--workers",
        type=workers,
        metavar="N",
        help="processes, where it is folders; default all cores",
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """A document in place of text."""
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def add_chains(parser: argparse.ArgumentParser) -> None:
    """Which chains."""
    add_rig(parser)
    parser.add_argument(
        "--chain",
        action="append",
        metavar="NAME",
        help="only this chain, with the limb that it begins, or this limb (again for more)",
    )
    add_people(parser)


def add_people(parser: argparse.ArgumentParser) -> None:
    """Which people, of a clip of several."""
    parser.add_argument(
        "--person",
        action="append",
        metavar="NAME",
        help="only this person's chains, of several in a clip (again for more)",
    )


def add_rig(parser: argparse.ArgumentParser) -> None:
    """Chains otherwise than found."""
    parser.add_argument(
        "--rig", type=Path, metavar="FILE", help="chains added and removed, TOML (docs/formats.md)"
    )
    parser.add_argument(
        "--joint-names",
        type=Path,
        metavar="FILE",
        help="words for joints besides the program's, TOML (docs/joint-names.md)",
    )


def add_method(
    parser: argparse._ActionsContainer, default: str | None = DEFAULT_METHOD, help: str = ""
) -> None:
    """Which detector: one by its name, or of a file."""
    group = parser.add_mutually_exclusive_group()
    # Set afterwards: the names of packages' detectors are sought where help lists them.
    method = group.add_argument("--method", default=default, help=help or None)
    method.choices = DETECTORS
    add_detector_file(group)


def add_detector_file(parser: argparse._ActionsContainer) -> None:
    """A detector that is in no package."""
    parser.add_argument(
        "--detector",
        metavar="FILE.py:CLASS",
        help="a detector of your own (docs/detectors.md)",
    )


def add_detection(parser: argparse.ArgumentParser) -> None:
    """What `detect` looks for, and how."""
    add_method(parser)
    parser.add_argument(
        "--tau", type=tau, default=None, metavar="auto|DEG", help="of all chains; limbs keep auto"
    )
    parser.add_argument(
        "--profile",
        type=Path,
        metavar="FILE",
        help="τ per joint or limb, TOML; --tau is for joints it does not name",
    )
    parser.add_argument(
        "--kinds",
        type=kinds,
        metavar="LIST",
        help=f"of errors to look for: {', '.join(KINDS)}; default all",
    )
    add_fps(parser)
    add_chains(parser)


def add_voice(parser: argparse.ArgumentParser) -> None:
    """How much is said."""
    voice = parser.add_mutually_exclusive_group()
    voice.add_argument("-q", "--quiet", action="store_true", help="only results and errors")
    voice.add_argument(
        "-v", "--verbose", action="store_true", help="also each step and its time, on stderr"
    )
