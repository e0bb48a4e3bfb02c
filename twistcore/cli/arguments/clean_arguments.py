"""Define the arguments of `twistcore clean`."""

from __future__ import annotations

import argparse

from twistcore.cli.arguments.argument_types import (
    parse_clip_input_path,
    parse_frame_rate,
    parse_positive_number,
)
from twistcore.cli.arguments.common_arguments import add_json, add_output, deferred_command

NAMINGS = ("cmu", "smpl")  # known sets of joint names for `--rename`


def add_clean(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `twistcore clean` to a parser."""
    parser.add_argument(
        "clip",
        type=parse_clip_input_path,
        metavar="CLIP",
        help="the clip; '-' reads a BVH from standard input",
    )
    add_output(parser, "BVH to write; '-' is standard output")
    parser.add_argument(
        "--unroll",
        action="store_true",
        help="where angles jump although the rotation does not, replace them by equivalent angles",
    )
    parser.add_argument(
        "--order",
        type=_order,
        action="append",
        metavar="ORDER",
        help="rotation order of all joints, such as ZXY, or of one joint, such as Hips=YXZ; "
        "repeatable (default: unchanged)",
    )
    parser.add_argument(
        "--channels",
        choices=("3",),
        help="remove the position channels of joints below the root, which must stay at their "
        "OFFSET (default: all are kept)",
    )
    parser.add_argument(
        "--keep-moving",
        action="store_true",
        help="with --channels: keep the position channels of joints that move, instead of "
        "stopping with an error",
    )
    parser.add_argument(
        "--scale",
        type=_factor,
        metavar="FACTOR",
        help="multiply offsets and positions, such as by 0.01 for cm to m (default: 1)",
    )
    parser.add_argument(
        "--up",
        type=str.upper,
        choices=("Y", "Z"),
        help="upward axis of the written clip; offsets, positions and axes are converted, and "
        "the figure does not turn (default: unchanged)",
    )
    parser.add_argument(
        "--rename",
        metavar="MAP",
        help="new joint names: a JSON object or a CSV file with old and new names, or one of "
        f"the naming schemes {' and '.join(NAMINGS)} (default: unchanged)",
    )
    parser.add_argument(
        "--fps",
        type=parse_frame_rate,
        metavar="HZ",
        help="resample to this frame rate; in other commands, --fps corrects the rate of the "
        "file (default: unchanged)",
    )
    add_json(parser)
    parser.set_defaults(run=deferred_command("clean_command", "clean_command"))


def _order(text: str) -> tuple[str, str]:
    """Return a joint and its rotation order. The joint is '' if the order is for all joints."""
    joint, _, order = text.rpartition("=")
    if sorted(order.upper()) != ["X", "Y", "Z"]:
        raise argparse.ArgumentTypeError(
            f"expected the three axes in any order, such as ZXY or Hips=ZXY, found {text!r}"
        )
    return joint, order.upper()


def _factor(text: str) -> float:
    """Convert a string to a scale factor from 1e-6 to 1e6, so that lengths do not lose digits."""
    if not 1e-6 <= (value := parse_positive_number(text)) <= 1e6:
        raise argparse.ArgumentTypeError(f"expected a factor from 1e-6 to 1e6, found {text!r}")
    return value
