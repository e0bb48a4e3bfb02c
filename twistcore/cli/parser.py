"""The words of the `twistcore` command, which are a contract."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable
from pathlib import Path

from twistcore.analysis import ALL_KINDS
from twistcore.cli import correct_commands, detect_commands, study_commands, tune_command
from twistcore.cli.argument_types import (
    Parser,
    count,
    folder,
    kinds,
    not_negative,
    number,
    positive,
    seed,
    target,
    tau,
)
from twistcore.cli.batch_arguments import BATCH, add_batch
from twistcore.cli.convert_command import add_convert
from twistcore.cli.export_command import add_export
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Kind
from twistcore.refinement import SURE_ENOUGH
from twistcore.synthesis import PROTOCOLS
from twistcore.version import __version__


def make_parser() -> argparse.ArgumentParser:
    """All commands."""
    parser = Parser(
        prog="twistcore", description="Find and remove axial twist errors in motion capture."
    )
    parser.add_argument("--version", action="version", version=f"twistcore {__version__}")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=Parser)

    info = subparsers.add_parser("info", help="what is in a clip")
    _clip(info)
    _fps(info)
    _rig(info)
    _json(info)
    info.set_defaults(run=detect_commands.info)

    detect = subparsers.add_parser("detect", help="find the intervals of errors")
    _clip(detect)
    _detection(detect)
    detect.add_argument("--explain", action="store_true", help="say why each interval was found")
    detect.add_argument(
        "--fail-over", type=int, metavar="N", help="exit 1 if more than N intervals are found"
    )
    _json(detect)
    detect.set_defaults(run=detect_commands.detect)

    signals = subparsers.add_parser("signals", help="θp, θc, their increments and m(t) as CSV")
    _clip(signals)
    _fps(signals)
    signals.add_argument("--csv", type=target, required=True, metavar="FILE")
    _chains(signals)
    signals.set_defaults(run=detect_commands.signals)

    refine = subparsers.add_parser("refine", help="write a corrected clip")
    _clip(refine)
    _output(refine)
    _detection(refine)
    refine.add_argument(
        "--min-confidence",
        type=float,
        metavar="X",
        help=f"correct what has at least this; default {SURE_ENOUGH:g}, 0: whatever is closed",
    )
    refine.add_argument(
        "--include-open", action="store_true", help="also correct intervals that are open"
    )
    refine.add_argument("--report", type=folder, metavar="DIR", help="also write a report")
    refine.set_defaults(run=correct_commands.refine)

    apply = subparsers.add_parser("apply", help="write what sessions have accepted")
    apply.add_argument("session", type=Path, metavar="SESSION|FOLDER")
    apply.add_argument("clip", type=Path, metavar="CLIP|FOLDER")
    _output(apply)
    _workers(apply)
    apply.set_defaults(run=correct_commands.apply)

    report = subparsers.add_parser("report", help="pages of a review, or of a batch folder")
    report.add_argument("what", type=Path, metavar="SESSION|OUTDIR")
    report.add_argument(
        "-o", "--output", type=folder, required=True, metavar="DIR", help="where the pages go"
    )
    report.add_argument(
        "--clip", type=Path, metavar="CLIP", help="of the session; default: where it was"
    )
    report.add_argument(
        "--workers", type=count, default=1, metavar="N", help="processes; default 1"
    )
    report.add_argument(
        "--pages", type=count, metavar="N", help="of the N worst clips only; default all"
    )
    report.add_argument("--no-pictures", action="store_true", help="do without pictures of figures")
    report.set_defaults(run=_report)

    inject = subparsers.add_parser("inject", help="put known twist errors into a clip")
    _clip(inject)
    _output(inject)
    inject.add_argument("--truth", type=target, required=True, metavar="TRUTH.json")
    inject.add_argument("--seed", type=seed, required=True, metavar="N")
    inject.add_argument(
        "--protocol",
        default="P0",
        metavar="NAME",
        help="; ".join(f"{k}: {p.text}" for k, p in PROTOCOLS.items()).replace("%", "%%")
        + "; joined by '+'",
    )
    inject.set_defaults(run=study_commands.inject_errors)

    evaluate = subparsers.add_parser("evaluate", help="measure a refinement against the truth")
    for name, help_text in (
        ("--truth", "what was injected"),
        ("--clean", "the clip before injection"),
        ("--refined", "the clip after refinement"),
    ):
        evaluate.add_argument(
            name, type=Path, required=True, nargs="+", metavar="FILE", help=help_text
        )
    _json(evaluate)
    evaluate.set_defaults(run=study_commands.evaluate)

    tune = subparsers.add_parser("tune", help="τ per joint, from injected errors or verdicts")
    tune.add_argument("source", type=Path, metavar="FOLDER|CLIP")
    tune.add_argument("-o", "--output", type=target, required=True, metavar="PROFILE.toml")
    tune.add_argument("--method", choices=sorted(DETECTORS), default=DEFAULT_METHOD)
    _rig(tune)
    tune.add_argument("--seeds", type=int, metavar="N", help="default 3; not with --verdicts")
    tune.add_argument(
        "--verdicts", action="store_true", help="from the sessions beside a folder's clips"
    )
    tune.add_argument(
        "--sessions",
        action="store_true",
        help="chains, verdicts and frames left out of the sessions beside the clips",
    )
    tune.add_argument("--both", action="store_true", help="print both detectors side by side")
    tune.add_argument("--performer", metavar="NAME", help="with --verdicts: only this one's clips")
    tune.add_argument(
        "--alarm-price",
        type=not_negative,
        metavar="SHARE",
        help="of the errors that one false alarm a clip may cost; default 0.05",
    )
    tune.add_argument(
        "--smallest", type=positive, metavar="DEGREES", help="of errors looked for; default 2"
    )
    tune.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N")
    tune.set_defaults(run=tune_command.tune)

    benchmark = subparsers.add_parser("benchmark", help="compare methods on errors put into clips")
    benchmark.add_argument("folder", type=Path, metavar="FOLDER")
    benchmark.add_argument(
        "--protocol", action="extend", nargs="+", metavar="NAME", help="as of inject; default P0"
    )
    benchmark.add_argument(
        "--methods", action="extend", nargs="+", metavar="NAME", help="default all"
    )
    benchmark.add_argument("--seeds", type=count, default=3, metavar="N", help="how many")
    benchmark.add_argument("--seed", type=int, default=1, metavar="N", help="the first seed")
    benchmark.add_argument("--workers", type=count, metavar="N", help="default all cores")
    benchmark.add_argument("--resume", action="store_true", help="continue an unfinished run")
    benchmark.add_argument("--json", type=target, metavar="FILE")
    benchmark.add_argument("--csv", type=target, metavar="FILE")
    benchmark.set_defaults(run=_benchmark)

    batch = subparsers.add_parser(BATCH, help="many clips into a folder of results")
    add_batch(batch)

    _quamo(subparsers.add_parser("quamo", help="tracking of jittery motion, after review"))

    diff = subparsers.add_parser("diff", help="what differs between two clips or folders")
    diff.add_argument("a", type=Path, metavar="A")
    diff.add_argument("b", type=Path, metavar="B")
    _json(diff)
    _workers(diff)
    diff.set_defaults(run=correct_commands.diff)

    add_export(subparsers)
    add_convert(subparsers)
    return parser


def _quamo(parser: argparse.ArgumentParser) -> None:
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=Parser)

    refine = subparsers.add_parser("refine", help="track or smooth a clip and write it")
    _clip(refine)
    _output(refine)
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
    _fps(refine)
    refine.add_argument("--unit", type=positive, metavar="METRES", help="of one unit of the clip")
    refine.add_argument("--template", type=Path, metavar="BVH", help="lengths for a file of poses")
    refine.add_argument(
        "--up", choices=("y", "z", "-y"), help="of a file of poses (--up=-y); default: as it stands"
    )
    refine.add_argument("--person", metavar="ID", help="whom to take from a file of poses")
    refine.set_defaults(run=_quamo_command("refine"))

    noise = subparsers.add_parser("noise", help="put synthetic noise into a clip")
    _clip(noise)
    _output(noise)
    noise.add_argument("--level", choices=("A", "B"), default="A")
    noise.add_argument("--systematic", action="store_true", help="half of the bias stands still")
    noise.add_argument("--bursts", type=not_negative, default=0.0, metavar="X", help="a minute")
    noise.add_argument("--seed", type=seed, default=0, metavar="N")
    noise.add_argument("--unit", type=positive, metavar="METRES", help="of one unit of the clip")
    _json(noise)
    noise.set_defaults(run=_quamo_command("noise"))

    for name, what in (
        ("evaluate", "learned and hand gains beside baselines on held-out subjects"),
        ("ablation", "steps of the method, representations, integration"),
    ):
        study = subparsers.add_parser(name, help=what)
        study.add_argument("folder", type=Path, metavar="FOLDER")
        study.add_argument("--weights", type=Path, metavar="DIR", help="default: as shipped")
        study.add_argument("--seeds", type=count, default=3, metavar="N", help="how many")
        study.add_argument("--seed", type=seed, default=0, metavar="N", help="the first seed")
        _json(study)
        study.set_defaults(run=_quamo_command(name))

    train = subparsers.add_parser("train", help="train the networks (PyTorch)")
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
    train.set_defaults(run=_quamo_command("train"))


# -- commands whose libraries load slowly: imported when they are called ---------------------------


def _benchmark(arguments: argparse.Namespace) -> int:
    from twistcore.cli.benchmark_command import benchmark  # scipy.signal

    return benchmark(arguments)


def _report(arguments: argparse.Namespace) -> int:
    from twistcore.cli.report_command import report  # many rooms at once

    return report(arguments)


def _quamo_command(name: str) -> Callable[[argparse.Namespace], int]:
    def run(arguments: argparse.Namespace) -> int:
        if name == "refine":
            from twistcore.cli.quamo_commands import refine  # scipy.linalg

            return refine(arguments)
        from twistcore.cli import quamo_study_commands  # scipy.ndimage

        return int(getattr(quamo_study_commands, name)(arguments))

    return run


# -- words that several commands have --------------------------------------------------------------


def _clip(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("clip", type=Path, metavar="CLIP")


def _fps(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--fps", type=positive, default=None, help="instead of the file's rate")


def _output(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", "--output", type=target, required=True, metavar="OUT", help="'-': standard output"
    )


def _workers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--workers",
        type=count,
        metavar="N",
        help="processes, where it is folders; default all cores",
    )


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def _chains(parser: argparse.ArgumentParser) -> None:
    _rig(parser)
    parser.add_argument(
        "--chain",
        action="append",
        metavar="NAME",
        help="only this chain, with the limb that it begins, or this limb (again for more)",
    )


def _rig(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--rig", type=Path, metavar="FILE", help="chains added and removed, TOML (docs/formats.md)"
    )


def _detection(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--method", choices=sorted(DETECTORS), default=DEFAULT_METHOD)
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
        default=ALL_KINDS,
        metavar="LIST",
        help=f"of errors to look for: {', '.join(k.replace(' ', '-') for k in Kind)}; default all",
    )
    _fps(parser)
    _chains(parser)
