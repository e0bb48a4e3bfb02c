"""The `twistcore` command: words and exit codes are a contract (0 done, 1 partly, 2 refused)."""

from __future__ import annotations

import argparse
import contextlib
import io
import math
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from twistcore.atomic import STANDARD_OUTPUT, is_standard_output
from twistcore.cli import commands
from twistcore.detection import DEFAULT_METHOD, DETECTORS
from twistcore.errors import TwistError
from twistcore.synthesis import DESCRIPTIONS
from twistcore.version import __version__


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code. No traceback reaches a person."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without θ or → is no reason to fail
    arguments = _parser().parse_args(argv)
    try:
        code = _run(arguments)
        sys.stdout.flush()  # a reader that has gone is noticed here, not at the interpreter's end
    except TwistError as error:
        print(" ".join(str(error).splitlines()), file=sys.stderr)
        return 2
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        print(f"{error.filename or 'file'}: {error.strerror}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return 130
    return code


def _run(arguments: argparse.Namespace) -> int:
    """The command; where an output is standard output, what is said goes to standard error."""
    if not any(is_standard_output(v) for v in vars(arguments).values() if isinstance(v, Path)):
        return int(arguments.run(arguments))
    if getattr(arguments, "json", None) is True:
        raise TwistError("--json: expected nothing else on standard output")
    with contextlib.redirect_stdout(sys.stderr):
        return int(arguments.run(arguments))


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="twistcore", description="Find and remove axial twist errors in BVH motion."
    )
    parser.add_argument("--version", action="version", version=f"twistcore {__version__}")
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)

    info = subparsers.add_parser("info", help="what is in a clip")
    _clip(info)
    _json(info)
    info.set_defaults(run=commands.info)

    detect = subparsers.add_parser("detect", help="find the intervals of twist errors")
    _clip(detect)
    _detection(detect)
    detect.add_argument("--explain", action="store_true", help="say why each interval was found")
    detect.add_argument(
        "--fail-over", type=int, metavar="N", help="exit 1 if more than N intervals are found"
    )
    _json(detect)
    detect.set_defaults(run=commands.detect)

    signals = subparsers.add_parser("signals", help="θp, θc, their increments and m(t) as CSV")
    _clip(signals)
    signals.add_argument("--csv", type=_target, required=True, metavar="FILE")
    _chains(signals)
    signals.set_defaults(run=commands.signals)

    refine = subparsers.add_parser("refine", help="write a corrected BVH")
    _clip(refine)
    _output(refine)
    _detection(refine)
    refine.add_argument("--min-confidence", type=float, default=0.0, metavar="X")
    refine.add_argument(
        "--include-open", action="store_true", help="also correct intervals without a second edge"
    )
    refine.add_argument("--report", type=_folder, metavar="DIR", help="also write a report")
    refine.set_defaults(run=commands.refine_clip)

    apply = subparsers.add_parser("apply", help="write what a session has accepted")
    apply.add_argument("session", type=Path, metavar="SESSION")
    _clip(apply)
    _output(apply)
    apply.set_defaults(run=commands.apply)

    inject = subparsers.add_parser("inject", help="put known twist errors into a clip")
    _clip(inject)
    _output(inject)
    inject.add_argument("--truth", type=_target, required=True, metavar="TRUTH.json")
    inject.add_argument("--seed", type=_seed, required=True, metavar="N")
    inject.add_argument(
        "--protocol",
        default="P0",
        metavar="NAME",
        help="; ".join(f"{k}: {v}" for k, v in DESCRIPTIONS.items()) + "; joined by '+'",
    )
    inject.set_defaults(run=commands.inject_errors)

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
    evaluate.set_defaults(run=commands.evaluate)

    tune = subparsers.add_parser("tune", help="τ per joint, from noise and injected errors")
    tune.add_argument("source", type=Path, metavar="FOLDER|CLIP")
    tune.add_argument("-o", "--output", type=_target, required=True, metavar="PROFILE.toml")
    tune.add_argument("--method", choices=sorted(DETECTORS), default=DEFAULT_METHOD)
    tune.add_argument("--seeds", type=int, default=3, metavar="N")
    tune.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N")
    tune.set_defaults(run=commands.tune)

    benchmark = subparsers.add_parser("benchmark", help="compare methods on errors put into clips")
    benchmark.add_argument("folder", type=Path, metavar="FOLDER")
    benchmark.add_argument(
        "--protocol", action="extend", nargs="+", metavar="NAME", help="as of inject; default P0"
    )
    benchmark.add_argument(
        "--methods", action="extend", nargs="+", metavar="NAME", help="default all"
    )
    benchmark.add_argument("--seeds", type=_count, default=3, metavar="N", help="how many")
    benchmark.add_argument("--seed", type=int, default=1, metavar="N", help="the first seed")
    benchmark.add_argument("--workers", type=_count, metavar="N", help="default all cores")
    benchmark.add_argument("--resume", action="store_true", help="continue an unfinished run")
    benchmark.add_argument("--json", type=_target, metavar="FILE")
    benchmark.add_argument("--csv", type=_target, metavar="FILE")
    benchmark.set_defaults(run=_benchmark)

    _quamo(subparsers.add_parser("quamo", help="causal tracking of jittery motion, after review"))

    diff = subparsers.add_parser("diff", help="what differs between two clips")
    diff.add_argument("a", type=Path, metavar="A")
    diff.add_argument("b", type=Path, metavar="B")
    _json(diff)
    diff.set_defaults(run=commands.diff)
    return parser


def _quamo(parser: argparse.ArgumentParser) -> None:
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND", parser_class=_Parser)

    refine = subparsers.add_parser("refine", help="track a clip and write it")
    _clip(refine)
    _output(refine)
    refine.add_argument("--gains", choices=("hand", "learned"), default="hand")
    refine.add_argument("--weights", type=Path, metavar="FILE", help="instead of the shipped ones")
    refine.add_argument(
        "--joints", nargs="+", metavar="NAME", help="only these; default all that can be written"
    )
    refine.add_argument("--root-position", action="store_true", help="also track the root's place")
    for name, what in (("--kp", "κP, 1/s²"), ("--kd", "κD, 1/s"), ("--ka", "κA at 25 Hz, rad/s²")):
        refine.add_argument(name, type=_number, metavar="X", help=f"hand gain {what}")
    refine.add_argument("--fps", type=_positive, default=None, help="instead of the file's rate")
    refine.add_argument("--unit", type=_positive, metavar="METRES", help="of one unit of the clip")
    refine.add_argument("--template", type=Path, metavar="BVH", help="rest offsets for an .npz")
    refine.add_argument("--up", choices=("y", "z"), default="z", help="of an .npz; AMASS: z")
    refine.set_defaults(run=_quamo_command("refine"))

    noise = subparsers.add_parser("noise", help="put synthetic noise into a clip")
    _clip(noise)
    _output(noise)
    noise.add_argument("--level", choices=("A", "B"), default="A")
    noise.add_argument("--systematic", action="store_true", help="half of the bias stands still")
    noise.add_argument("--bursts", type=_not_negative, default=0.0, metavar="X", help="a minute")
    noise.add_argument("--seed", type=_seed, default=0, metavar="N")
    noise.add_argument("--unit", type=_positive, metavar="METRES", help="of one unit of the clip")
    _json(noise)
    noise.set_defaults(run=_quamo_command("noise"))

    for name, what in (
        ("evaluate", "learned and hand gains beside baselines on held-out subjects"),
        ("ablation", "steps of the method, representations, integration"),
    ):
        tables = subparsers.add_parser(name, help=what)
        tables.add_argument("folder", type=Path, metavar="FOLDER")
        tables.add_argument("--weights", type=Path, metavar="DIR", help="default: as shipped")
        tables.add_argument("--seeds", type=_count, default=3, metavar="N", help="how many")
        tables.add_argument("--seed", type=_seed, default=0, metavar="N", help="the first seed")
        _json(tables)
        tables.set_defaults(run=_quamo_command(name))

    train = subparsers.add_parser("train", help="train the networks (PyTorch)")
    train.add_argument("folder", type=Path, metavar="FOLDER")
    train.add_argument("-o", "--output", type=_folder, required=True, metavar="DIR")
    train.add_argument(
        "--hold-out", nargs="+", metavar="SUBJECT", help="one network each; 'none' for all clips"
    )
    train.add_argument("--variant", choices=("pd", "bias", "s3", "full"), default="full")
    train.add_argument("--epochs", type=_count, metavar="N")
    train.add_argument("--width", type=_count, metavar="N", help="units of a hidden layer")
    train.add_argument("--seed", type=_seed, default=0, metavar="N")
    train.add_argument("--compile", action="store_true", help="fuse the step; needs a C++ compiler")
    train.set_defaults(run=_quamo_command("train"))


def _quamo_command(name: str) -> Callable[[argparse.Namespace], int]:
    def run(arguments: argparse.Namespace) -> int:
        from twistcore.cli import quamo_commands as command

        chosen: Callable[[argparse.Namespace], int] = getattr(command, name)
        return chosen(arguments)

    return run


def _benchmark(arguments: argparse.Namespace) -> int:
    from twistcore.cli.benchmark_command import benchmark  # scipy.signal takes a while to load

    return benchmark(arguments)


def _clip(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("clip", type=Path, metavar="CLIP")


def _output(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", "--output", type=_target, required=True, metavar="OUT", help="'-': standard output"
    )


def _target(text: str) -> Path:
    """A file to write, '-' for standard output; a file of that name is './-'."""
    return STANDARD_OUTPUT if text == "-" else Path(text)


def _folder(text: str) -> Path:
    if text == "-":
        raise argparse.ArgumentTypeError("expected a folder; one called '-' is './-'")
    return Path(text)


def _json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON document")


def _chains(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--chain", action="append", metavar="NAME", help="only this chain (again for more)"
    )


def _detection(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--method", choices=sorted(DETECTORS), default=DEFAULT_METHOD)
    parser.add_argument("--tau", type=_tau, default=None, metavar="auto|DEG")
    parser.add_argument(
        "--profile",
        type=Path,
        metavar="FILE",
        help="τ per joint, TOML; --tau is for joints it does not name",
    )
    parser.add_argument("--fps", type=_positive, default=None, help="instead of the file's rate")
    _chains(parser)


def _tau(text: str) -> float | None:
    return None if text == "auto" else math.radians(_positive(text))


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number from 0, found {text!r}")
    return int(text)


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"expected a number above 0, found {text!r}")
    return value


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, found {text!r}") from None


def _not_negative(text: str) -> float:
    return 0.0 if text == "0" else _positive(text)


def _count(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"expected a whole number above 0, found {text!r}")
    return int(text)
