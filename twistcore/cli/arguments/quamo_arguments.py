"""The words of `twistcore quamo`."""

from __future__ import annotations

import argparse
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    Parser,
    count,
    folder,
    not_negative,
    number,
    positive,
    seed,
)
from twistcore.cli.arguments.common_arguments import (
    add_clip,
    add_fps,
    add_json,
    add_output,
    deferred,
)


def add_quamo(parser: argparse.ArgumentParser) -> None:
    """Put them into a parser."""
    subparsers = parser.add_subparsers(
        prog=parser.prog, required=True, metavar="COMMAND", parser_class=Parser
    )
    _refine(subparsers.add_parser("refine", help="track or smooth a clip and write it"))
    _noise(subparsers.add_parser("noise", help="put synthetic noise into a clip"))
    for name, what in (
        ("evaluate", "learned and hand gains beside baselines on held-out subjects"),
        ("ablation", "steps of the method, representations, integration"),
    ):
        study = subparsers.add_parser(name, help=what)
        study.add_argument("folder", type=Path, metavar="FOLDER")
        study.add_argument("--weights", type=Path, metavar="DIR", help="default: as shipped")
        study.add_argument("--seeds", type=count, default=3, metavar="N", help="how many")
        study.add_argument("--seed", type=seed, default=0, metavar="N", help="the first seed")
        add_json(study)
        study.set_defaults(run=deferred("quamo_study_commands", f"quamo_{name}_command"))
    _train(subparsers.add_parser("train", help="train the networks (PyTorch)"))


def _refine(refine: argparse.ArgumentParser) -> None:
    add_clip(refine)
    add_output(refine)
    refine.add_argument(
        "--method",
        choices=("quamo", "spline"),
        default="quamo",
        help="the tracker, or a smoothing spline: smoother, and sees the whole clip",
    )
    refine.add_argument(
        "--cutoff", type=positive, metavar="HZ", help="of the spline: what keeps half; usual 4 to 6"
    )
    refine.add_argument("--gains", choices=("hand", "learned"), default="hand")
    refine.add_argument("--weights", type=Path, metavar="FILE", help="instead of the shipped ones")
    refine.add_argument(
        "--joints", nargs="+", metavar="NAME", help="only these; default all that can be written"
    )
    refine.add_argument(
        "--causal", action="store_true", help="frame by frame; default both ways, without lag"
    )
    refine.add_argument(
        "--root-position",
        action=argparse.BooleanOptionalAction,
        help="whether to track the root's place; default yes, or if --joints names the root",
    )
    for name, what in (("--kp", "κP, 1/s²"), ("--kd", "κD, 1/s"), ("--ka", "κA at 25 Hz, rad/s²")):
        refine.add_argument(name, type=number, metavar="X", help=f"hand gain {what}")
    add_fps(refine)
    refine.add_argument("--unit", type=positive, metavar="METRES", help="of one unit of the clip")
    refine.add_argument("--template", type=Path, metavar="BVH", help="lengths for a file of poses")
    refine.add_argument(
        "--up", choices=("y", "z", "-y"), help="of a file of poses (--up=-y); default: as it stands"
    )
    refine.add_argument("--person", metavar="ID", help="whom to take from a file of poses")
    refine.set_defaults(run=deferred("quamo_commands", "quamo_refine_command"))


def _noise(noise: argparse.ArgumentParser) -> None:
    add_clip(noise)
    add_output(noise)
    noise.add_argument("--level", choices=("A", "B"), default="A")
    noise.add_argument("--systematic", action="store_true", help="half of the bias stands still")
    noise.add_argument("--bursts", type=not_negative, default=0.0, metavar="X", help="a minute")
    noise.add_argument("--seed", type=seed, default=0, metavar="N")
    noise.add_argument("--unit", type=positive, metavar="METRES", help="of one unit of the clip")
    add_json(noise)
    noise.set_defaults(run=deferred("quamo_study_commands", "quamo_noise_command"))


def _train(train: argparse.ArgumentParser) -> None:
    train.add_argument("folder", type=Path, metavar="FOLDER")
    train.add_argument("-o", "--output", type=folder, required=True, metavar="DIR")
    train.add_argument(
        "--hold-out", nargs="+", metavar="SUBJECT", help="one network each; 'none' for all clips"
    )
    train.add_argument("--variant", choices=("pd", "bias", "s3", "full"), default="full")
    train.add_argument("--epochs", type=count, metavar="N")
    train.add_argument("--width", type=count, metavar="N", help="units of a hidden layer")
    train.add_argument("--seed", type=seed, default=0, metavar="N")
    train.add_argument("--compile", action="store_true", help="fuse the step; needs a C++ compiler")
    train.set_defaults(run=deferred("quamo_study_commands", "quamo_train_command"))
