"""Define the arguments that choose the chains, the detector, τ, and the intervals to correct."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    KINDS,
    parse_error_kinds,
    parse_fraction,
    parse_tau,
)
from twistcore.cli.arguments.common_arguments import add_fps
from twistcore.detection.registry import DEFAULT_METHOD, DETECTORS


def add_chains(parser: argparse._ActionsContainer) -> None:
    """Add the options that choose chains and people."""
    add_rig(parser)
    parser.add_argument(
        "--chain",
        action="append",
        metavar="NAME",
        help="examine only this chain and the limb that begins with it, or only this limb; "
        "`twistcore info` lists the names; case is ignored; repeatable (default: all)",
    )
    parser.add_argument(
        "--person",
        action="append",
        metavar="NAME",
        help="examine only the chains of this person in a clip of several people; repeatable "
        "(default: everyone)",
    )


def add_rig(parser: argparse._ActionsContainer) -> None:
    """Add the options --rig and --joint-names, which add or remove chains and name joints."""
    parser.add_argument(
        "--rig",
        type=Path,
        metavar="FILE",
        help="TOML file of chains to add and remove (docs/formats.md; default: the detected "
        "chains)",
    )
    parser.add_argument(
        "--joint-names",
        type=Path,
        metavar="FILE",
        help="TOML file with names for joints, in addition to the known names "
        "(docs/joint-names.md; default: none)",
    )


def add_method(
    parser: argparse._ActionsContainer,
    default: str | None = DEFAULT_METHOD,
    help: str = "detector that examines the chains (default: %(default)s)",
) -> None:
    """Add the options --method (a detector's name) and --detector (a detector's file)."""
    group = parser.add_mutually_exclusive_group()
    # Setting the choices later avoids a search for detectors in other packages until it is needed.
    group.add_argument("--method", default=default, help=help).choices = DETECTORS
    add_detector_file(group)


def add_detector_file(parser: argparse._ActionsContainer) -> None:
    """Add the option --detector, for a detector in the user's own Python file."""
    parser.add_argument(
        "--detector",
        metavar="FILE.py:CLASS",
        help="use a detector of your own from this file (docs/detectors.md; default: none)",
    )


def add_detection(
    parser: argparse._ActionsContainer, tau_type: Callable[[str], float | None] = parse_tau
) -> None:
    """Add the options for detection. `tau_type` converts the value of --tau."""
    add_method(parser)
    parser.add_argument(
        "--tau",
        type=tau_type,
        metavar="auto|DEG",
        help="threshold τ for all chains, in degrees; limbs always use auto (default: auto, from "
        "the noise of each chain)",
    )
    parser.add_argument(
        "--profile",
        type=Path,
        metavar="FILE",
        help="TOML file with τ for each joint or limb; --tau applies to joints that are not in it "
        "(default: none)",
    )
    parser.add_argument(
        "--kinds",
        type=parse_error_kinds,
        metavar="LIST",
        help=f"comma-separated kinds of errors to look for: {', '.join(KINDS)} (default: all)",
    )
    add_fps(parser)
    add_chains(parser)


def add_correction_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose the intervals to correct."""
    parser.add_argument(
        "--min-confidence",
        type=parse_fraction,
        metavar="X",
        help="minimum confidence of intervals to correct, 0 to 1 (default: 0.5); intervals "
        "without a confidence are corrected by default, but not if a number above 0 is given",
    )
    parser.add_argument(
        "--include-open",
        action="store_true",
        help="also correct open intervals, except kinds that are never corrected automatically",
    )
