"""The words of the `twistcore` command, which are a contract; numpy is loaded by none of them."""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    Parser,
    count,
    degrees,
    folder,
    limit,
    not_negative,
    number,
    rate,
    readable,
    seed,
    share,
    target,
    workers,
)
from twistcore.cli.arguments.batch_arguments import BATCH, add_batch
from twistcore.cli.arguments.command_examples import epilog
from twistcore.cli.arguments.common_arguments import (
    add_chains,
    add_clip,
    add_clips,
    add_detection,
    add_detector_file,
    add_fps,
    add_json,
    add_method,
    add_output,
    add_rig,
    add_voice,
    add_workers,
    deferred,
)
from twistcore.cli.arguments.quamo_arguments import add_quamo
from twistcore.cli.convert_command import add_convert
from twistcore.files.version import __version__

SHELLS = ("bash", "zsh", "fish", "tcsh")  # that `completion` writes for
PROGRAMS = ("blender", "maya", "motionbuilder")  # that `export --script` writes for


def make_parser(words: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """Return the parser of all commands.

    words: a command line; a command that is not among them gets no arguments, which saves time.
    """
    parser = Parser(
        prog="twistcore", description="Find and remove axial twist errors in motion capture."
    )
    parser.add_argument("--version", action="version", version=f"twistcore {__version__}")
    subparsers = parser.add_subparsers(
        prog=parser.prog, required=True, metavar="COMMAND", parser_class=Parser
    )
    for name, (about, add_arguments) in _COMMANDS.items():
        command = subparsers.add_parser(name, help=about)
        if words is not None and name not in words:
            continue
        add_arguments(command)
        for full_name, leaf in commands_of(command, name):
            leaf.formatter_class = argparse.RawDescriptionHelpFormatter
            examples = epilog(full_name)
            leaf.epilog = f"{leaf.epilog}\n{examples}" if leaf.epilog else examples
            add_voice(leaf)
            leaf.set_defaults(command=leaf.prog)
    return parser


def commands_of(
    parser: argparse.ArgumentParser, words: str = ""
) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Every command with its own parser: 'detect', 'quamo refine'."""
    groups = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    if not groups:
        yield words, parser
    for group in groups:
        for name, below in group.choices.items():
            yield from commands_of(below, f"{words} {name}".strip())


def _info(info: Parser) -> None:
    add_clips(info)
    add_fps(info)
    add_rig(info)
    info.add_argument("--names", action="store_true", help="what each joint was taken for")
    add_json(info)
    info.set_defaults(run=deferred("detect_commands", "info_command"))


def _detect(detect: Parser) -> None:
    add_clips(detect)
    add_detection(detect)
    detect.add_argument("--explain", action="store_true", help="say why each interval was found")
    detect.add_argument(
        "--fail-over",
        type=limit,
        metavar="N",
        help="exit 1 if more than N intervals are found, in all clips together",
    )
    add_json(detect)
    detect.set_defaults(run=deferred("detect_commands", "detect_command"))


def _signals(signals: Parser) -> None:
    add_clips(signals)
    add_fps(signals)
    signals.add_argument(
        "--csv", type=target, metavar="FILE", help="of several clips: with a column of their names"
    )
    add_chains(signals)
    add_json(signals)
    signals.set_defaults(run=deferred("signals_command", "signals_command"))


def _diff(diff: Parser) -> None:
    diff.add_argument("a", type=readable, metavar="A", help="clip or folder; '-': standard input")
    diff.add_argument("b", type=readable, metavar="B", help="clip or folder; '-': standard input")
    add_json(diff)
    add_workers(diff)
    diff.set_defaults(run=deferred("correct_commands", "diff_command"))


def _refine(refine: Parser) -> None:
    refine.add_argument("clip", type=readable, metavar="CLIP", help="'-': a BVH on standard input")
    add_output(refine)
    add_detection(refine)
    refine.add_argument(
        "--min-confidence",
        type=share,
        metavar="X",
        help="correct what has at least this; default 0.5, 0: whatever is closed",
    )
    refine.add_argument(
        "--include-open", action="store_true", help="also correct intervals that are open"
    )
    refine.add_argument("--report", type=folder, metavar="DIR", help="also write a report")
    refine.add_argument(
        "--session",
        type=target,
        metavar="FILE",
        help="also write the corrections as a session, NAME.twist.json, that apply, export, report "
        "and the window read",
    )
    add_json(refine)
    refine.set_defaults(run=deferred("correct_commands", "refine_command"))


def _apply(apply: Parser) -> None:
    apply.add_argument("session", type=Path, metavar="SESSION|FOLDER")
    apply.add_argument("clip", type=Path, metavar="CLIP|FOLDER")
    add_output(apply)
    add_workers(apply)
    add_json(apply)
    apply.set_defaults(run=deferred("correct_commands", "apply_command"))


def _report(report: Parser) -> None:
    report.add_argument("what", type=Path, metavar="SESSION|OUTDIR")
    report.add_argument(
        "-o", "--output", type=folder, required=True, metavar="DIR", help="where the pages go"
    )
    report.add_argument(
        "--clip", type=Path, metavar="CLIP", help="of the session; default: where it was"
    )
    report.add_argument(
        "--workers", type=workers, default=1, metavar="N", help="processes; default 1"
    )
    report.add_argument(
        "--pages", type=count, metavar="N", help="of the N worst clips only; default all"
    )
    report.add_argument("--no-pictures", action="store_true", help="do without pictures of figures")
    report.set_defaults(run=deferred("report_command", "report_command"))


def _inject(inject: Parser) -> None:
    add_clip(inject)
    add_output(inject)
    inject.add_argument("--truth", type=target, required=True, metavar="TRUTH.json")
    inject.add_argument("--seed", type=seed, required=True, metavar="N")
    inject.add_argument("--protocol", default="P0", metavar="NAME", help="joined by '+'")
    inject.late = _with_protocols
    add_json(inject)
    inject.set_defaults(run=deferred("study_commands", "inject_command"))


def _evaluate(evaluate: Parser) -> None:
    for name, help_text in (
        ("--truth", "what was injected"),
        ("--clean", "the clip before injection"),
        ("--refined", "the clip after refinement"),
    ):
        evaluate.add_argument(
            name, type=Path, required=True, nargs="+", metavar="FILE", help=help_text
        )
    add_json(evaluate)
    evaluate.set_defaults(run=deferred("study_commands", "evaluate_command"))


def _tune(tune: Parser) -> None:
    tune.add_argument("source", type=Path, metavar="FOLDER|CLIP")
    tune.add_argument("-o", "--output", type=target, required=True, metavar="PROFILE.toml")
    add_method(tune)
    add_rig(tune)
    tune.add_argument("--seeds", type=limit, metavar="N", help="default 3; not with --verdicts")
    tune.add_argument(
        "--verdicts", action="store_true", help="from the sessions beside a folder's clips"
    )
    tune.add_argument(
        "--sessions",
        action="store_true",
        help="chains, verdicts and frames left out of the sessions beside the clips",
    )
    tune.add_argument("--both", action="store_true", help="print all detectors side by side")
    tune.add_argument("--performer", metavar="NAME", help="with --verdicts: only this one's clips")
    tune.add_argument(
        "--alarm-price",
        type=not_negative,
        metavar="SHARE",
        help="of the errors that one false alarm a clip may cost; default 0.05",
    )
    tune.add_argument(
        "--smallest", type=degrees, metavar="DEGREES", help="of errors looked for; default 2"
    )
    tune.add_argument("--workers", type=workers, default=os.cpu_count() or 1, metavar="N")
    add_json(tune)
    tune.set_defaults(run=deferred("tune_command", "tune_command"))


def _benchmark(benchmark: Parser) -> None:
    benchmark.add_argument("folder", type=Path, metavar="FOLDER")
    benchmark.add_argument(
        "--protocol", action="extend", nargs="+", metavar="NAME", help="as of inject; default P0"
    )
    benchmark.add_argument(
        "--methods", action="extend", nargs="+", metavar="NAME", help="default all"
    )
    add_detector_file(benchmark)
    benchmark.add_argument("--seeds", type=count, default=3, metavar="N", help="how many")
    benchmark.add_argument("--seed", type=seed, default=1, metavar="N", help="the first seed")
    benchmark.add_argument("--workers", type=workers, metavar="N", help="default all cores")
    benchmark.add_argument("--resume", action="store_true", help="continue an unfinished run")
    benchmark.add_argument("--json", type=target, metavar="FILE")
    benchmark.add_argument("--csv", type=target, metavar="FILE")
    benchmark.set_defaults(run=deferred("benchmark_command", "benchmark_command"))


def _with_protocols(inject: argparse.ArgumentParser) -> None:
    """Put what every protocol is into the help."""
    from twistcore.synthesis import PROTOCOLS  # numpy

    texts = "; ".join(f"{name}: {p.text}" for name, p in PROTOCOLS.items()).replace("%", "%%")
    action = next(a for a in inject._actions if a.dest == "protocol")
    action.help = f"{texts}; joined by '+'"


def _export(parser: Parser) -> None:
    parser.add_argument("session", type=Path, metavar="SESSION")
    parser.add_argument("clip", type=Path, metavar="CLIP")
    parser.add_argument(
        "--script",
        choices=PROGRAMS,
        required=True,
        help="a script that keys the accepted intervals on the scene's joints (docs/pipelines.md)",
    )
    parser.add_argument("-o", "--output", type=target, required=True, metavar="FILE.py")
    parser.add_argument(
        "--namespace", metavar="NAME", help="of the scene's joints; '': take off the clip's own"
    )
    parser.add_argument("--take", metavar="NAME", help="in which to key; in Blender the action")
    parser.add_argument("--fps", type=rate, help="the scene's rate; default the clip's")
    parser.add_argument(
        "--start", type=number, help="the scene's frame of frame 0; default 0, in Blender 1"
    )
    parser.add_argument(
        "--dry-run", action="store_true", help="let the script only tell what it would key"
    )
    parser.set_defaults(run=deferred("export_command", "export_command"))


def _completion(parser: Parser) -> None:
    parser.add_argument("shell", choices=SHELLS)
    parser.set_defaults(run=deferred("completion", "completion_command"))


# In the order in which --help lists them: what each is for, and its arguments.
_COMMANDS: Mapping[str, tuple[str, Callable[[Parser], None]]] = {
    "info": ("what is in clips", _info),
    "detect": ("find the intervals of errors", _detect),
    "signals": ("θp, θc, their increments and m(t) as CSV", _signals),
    "diff": ("what differs between two clips or folders", _diff),
    "refine": ("write a corrected clip", _refine),
    "apply": ("write what sessions have accepted", _apply),
    "report": ("pages of a review, or of a batch folder", _report),
    "inject": ("put known twist errors into a clip", _inject),
    "evaluate": ("measure a refinement against the truth", _evaluate),
    "tune": ("τ per joint, from injected errors or verdicts", _tune),
    "benchmark": ("compare methods on errors put into clips", _benchmark),
    BATCH: ("many clips into a folder of results", add_batch),
    "quamo": ("tracking of jittery motion, after review", add_quamo),
    "export": ("keys for the scene that a clip came from", _export),
    "convert": ("FBX or glTF as BVH, by a Blender of your own (docs/pipelines.md)", add_convert),
    "completion": ("print what a shell completes words by", _completion),
}
