"""Define the arguments of `twistcore quamo`."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    parse_count,
    parse_finite_number,
    parse_non_negative_number,
    parse_output_folder,
    parse_positive_number,
)
from twistcore.cli.arguments.command_help import COMMANDS
from twistcore.cli.arguments.common_arguments import (
    add_clip,
    add_commands,
    add_fps,
    add_json,
    add_output,
    add_seed,
    deferred_command,
)


def add_quamo_subcommands(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands of `twistcore quamo` to a parser."""
    subparsers = add_commands(parser)
    for name, add_arguments in _COMMANDS.items():
        add_arguments(subparsers.add_parser(name, help=COMMANDS[f"quamo {name}"].summary))


def _refine(refine: argparse.ArgumentParser) -> None:
    add_clip(refine, "the BVH or pose file to read")
    add_output(refine)
    refine.add_argument(
        "--method",
        choices=("spline", "quamo"),
        help="a smoothing spline, which leaves the least jitter and needs the whole clip, or the "
        "tracker, which can also follow a stream (default: spline, or quamo with an option of the "
        "tracker)",
    )
    refine.add_argument(
        "--where",
        choices=("all", "noisy"),
        default="all",
        help="smooth all frames, or only bursts of noise and leave all other frames unchanged "
        "(default: %(default)s)",
    )
    refine.add_argument(
        "--cutoff",
        type=parse_positive_number,
        metavar="HZ",
        help="cut-off frequency, at which the spline halves the amplitude (default: 4 to 6, "
        "depending on the frame rate; 2.5 in bursts of noise)",
    )
    refine.add_argument(
        "--gains",
        choices=("hand", "learned"),
        help="gains of the tracker: set by hand, or learned by the networks (default: hand)",
    )
    refine.add_argument(
        "--weights",
        type=Path,
        metavar="FILE",
        help="networks for learned gains (default: the included networks)",
    )
    refine.add_argument(
        "--joints",
        nargs="+",
        metavar="NAME",
        help="joints to smooth or track (default: all writable joints)",
    )
    refine.add_argument(
        "--causal",
        action="store_true",
        help="track frame by frame, without using later frames (default: track in both "
        "directions, without lag)",
    )
    refine.add_argument(
        "--root-position",
        action=argparse.BooleanOptionalAction,
        help="also smooth or track the position of the root (default: yes, but with --joints "
        "only if they include the root)",
    )
    for name, what in (("--kp", "κP, 1/s²"), ("--kd", "κD, 1/s"), ("--ka", "κA at 25 Hz, rad/s²")):
        refine.add_argument(
            name,
            type=parse_finite_number,
            metavar="X",
            help=f"gain {what}, set by hand (default: depends on the frame rate and the direction)",
        )
    add_fps(refine)
    _add_unit(refine)
    refine.add_argument(
        "--template",
        type=Path,
        metavar="BVH",
        help="clip with the bone lengths for a pose file (default: the lengths in the file)",
    )
    refine.add_argument(
        "--up",
        choices=("y", "z", "-y"),
        help="upward axis of a pose file, such as --up=-y (default: as in the file)",
    )
    refine.add_argument(
        "--person",
        metavar="ID",
        help="person to read from a pose file (default: the only one)",
    )
    refine.set_defaults(run=deferred_command("quamo_commands", "quamo_refine_command"))


def _add_unit(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--unit",
        type=parse_positive_number,
        metavar="METRES",
        help="length of one unit of the clip (default: CMU's, if the skeleton is like CMU's)",
    )


def _noise(noise: argparse.ArgumentParser) -> None:
    add_clip(noise)
    add_output(noise)
    noise.add_argument(
        "--level",
        choices=("A", "B"),
        default="A",
        help="level of the noise; A is stronger than B (default: %(default)s)",
    )
    noise.add_argument(
        "--systematic", action="store_true", help="keep half of the bias constant over the clip"
    )
    noise.add_argument(
        "--bursts",
        type=parse_non_negative_number,
        default=0.0,
        metavar="X",
        help="bursts of noise per minute (default: %(default)g)",
    )
    add_seed(noise, 0, "seed of the random numbers")
    _add_unit(noise)
    add_json(noise)
    noise.set_defaults(run=deferred_command("quamo_study_commands", "quamo_noise_command"))


def _study(study: argparse.ArgumentParser, *, name: str) -> None:
    study.add_argument(
        "folder", type=Path, metavar="FOLDER", help="folder of CMU clips, named like 05_02.bvh"
    )
    study.add_argument(
        "--weights",
        type=Path,
        metavar="DIR",
        help="folder of networks that were trained without the held-out subjects (default: the "
        "included folder)",
    )
    study.add_argument(
        "--seeds",
        type=parse_count,
        default=3,
        metavar="N",
        help="number of noise draws to average (default: %(default)s)",
    )
    add_seed(study, 0)
    add_json(study)
    study.set_defaults(run=deferred_command("quamo_study_commands", f"quamo_{name}_command"))


def _train(train: argparse.ArgumentParser) -> None:
    train.add_argument(
        "folder", type=Path, metavar="FOLDER", help="folder of CMU clips, named like 05_02.bvh"
    )
    add_output(train, "folder for the weights and checkpoints", parse_output_folder, "DIR")
    train.add_argument(
        "--hold-out",
        nargs="+",
        metavar="SUBJECT",
        help="for each of these subjects, train a network without the subject's clips; 'none' "
        "trains on all clips (default: all held-out subjects and none)",
    )
    train.add_argument(
        "--variant",
        choices=("pd", "bias", "s3", "full"),
        default="full",
        help="variant of the method (default: %(default)s)",
    )
    train.add_argument(
        "--epochs", type=parse_count, metavar="N", help="passes over the clips (default: 60)"
    )
    train.add_argument(
        "--width", type=parse_count, metavar="N", help="units in each hidden layer (default: 128)"
    )
    add_seed(train, 0, "seed of the random numbers")
    train.add_argument(
        "--compile", action="store_true", help="compile the training step (requires a C++ compiler)"
    )
    train.set_defaults(run=deferred_command("quamo_study_commands", "quamo_train_command"))


_COMMANDS: Mapping[str, Callable[[argparse.ArgumentParser], None]] = {
    "refine": _refine,
    "noise": _noise,
    "evaluate": partial(_study, name="evaluate"),
    "ablation": partial(_study, name="ablation"),
    "train": _train,
}
