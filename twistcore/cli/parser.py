"""Create the parser of the `twistcore` command without importing numpy.

Commands, options and exit codes must stay compatible, since other programs rely on them.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from twistcore.cli.arguments.argument_types import (
    Parser,
    parse_clip_input_path,
    parse_count,
    parse_degrees,
    parse_finite_number,
    parse_frame_rate,
    parse_non_negative_number,
    parse_output_folder,
    parse_output_path,
    parse_seed,
    parse_whole_number_limit,
    parse_worker_count,
)
from twistcore.cli.arguments.batch_arguments import add_batch, add_merge, add_watch_arguments
from twistcore.cli.arguments.clean_arguments import add_clean
from twistcore.cli.arguments.command_help import COMMANDS, PROGRAM, CommandHelp, HelpFormatter
from twistcore.cli.arguments.common_arguments import (
    add_clip,
    add_clips,
    add_commands,
    add_fps,
    add_json,
    add_output,
    add_reference,
    add_seed,
    add_verbosity_options,
    add_workers,
    deferred_command,
)
from twistcore.cli.arguments.detection_arguments import (
    add_chains,
    add_correction_options,
    add_detection,
    add_detector_file,
    add_method,
    add_rig,
)
from twistcore.cli.arguments.quamo_arguments import add_quamo_subcommands
from twistcore.cli.convert_command import add_convert
from twistcore.files.version import __version__

SHELLS = ("bash", "zsh", "fish", "tcsh")  # choices of `completion`
PROGRAMS = ("blender", "maya", "motionbuilder")  # choices of `export --script`


def make_parser(words: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """Return the parser of all commands.

    `words` is a command line. If it is given, only the arguments of its command are added, which is
    faster.
    """
    parser = Parser(prog="twistcore")
    _set_texts(parser, PROGRAM)
    parser.add_argument(
        "--version",
        action="version",
        version=f"twistcore {__version__}",
        help="show the version and exit",
    )
    subparsers = add_commands(parser)
    for name, add_arguments in _COMMANDS.items():
        command = subparsers.add_parser(name, help=COMMANDS[name].summary)
        if words is not None and name not in words:
            continue
        add_arguments(command)
        _set_texts(command, COMMANDS[name])
        for full_name, leaf in command_parsers(command, name):
            _set_texts(leaf, COMMANDS[full_name])
            add_verbosity_options(leaf)
            leaf.set_defaults(command=leaf.prog)
    return parser


def _set_texts(parser: argparse.ArgumentParser, texts: CommandHelp) -> None:
    parser.description, parser.epilog = texts.description, texts.epilog
    parser.formatter_class = HelpFormatter


def command_parsers(
    parser: argparse.ArgumentParser, words: str = ""
) -> Iterator[tuple[str, argparse.ArgumentParser]]:
    """Yield the name (such as 'detect' or 'quamo refine') and the parser of each command.

    `words` is the name of the command that `parser` parses.
    """
    groups = [a for a in parser._actions if isinstance(a, argparse._SubParsersAction)]
    if not groups:
        yield words, parser
    for group in groups:
        for name, below in group.choices.items():
            yield from command_parsers(below, f"{words} {name}".strip())


def _info(info: Parser) -> None:
    add_clips(info)
    add_fps(info)
    add_rig(info)
    info.add_argument(
        "--names",
        action="store_true",
        help="also list each joint, the bone that it was recognised as, and why",
    )
    add_reference(info)
    add_json(info)
    info.set_defaults(run=deferred_command("detect_commands", "info_command"))


def _detect(detect: Parser) -> None:
    add_clips(detect)
    add_detection(detect)
    detect.add_argument(
        "--explain",
        action="store_true",
        help="also explain each interval, and each peak above τ that is outside all intervals",
    )
    detect.add_argument(
        "--fail-over",
        type=parse_whole_number_limit,
        metavar="N",
        help="exit with 1 if more than N intervals are found in all clips together; noise bursts "
        "and frozen frames count only with --kinds (default: no limit)",
    )
    add_reference(detect)
    add_json(detect)
    detect.set_defaults(run=deferred_command("detect_commands", "detect_command"))


def _signals(signals: Parser) -> None:
    add_clips(signals)
    add_fps(signals)
    signals.add_argument(
        "--csv",
        type=parse_output_path,
        metavar="FILE",
        help="write a table with one row for each chain and frame (with the clip's name if there "
        "are several clips); '-' is standard output (default: none; --csv or --json is required)",
    )
    add_method(
        signals,
        None,
        "also write the strength that this detector compares with τ (default: none)",
    )
    add_chains(signals)
    add_json(signals)
    signals.set_defaults(run=deferred_command("signals_command", "signals_command"))


def _diff(diff: Parser) -> None:
    for name, which in (("a", "first"), ("b", "second")):
        diff.add_argument(
            name,
            type=parse_clip_input_path,
            metavar=name.upper(),
            help=f"the {which} clip, folder, session or NAME.report.json; '-' reads a BVH from "
            "standard input",
        )
    diff.add_argument(
        "--merge",
        type=parse_output_path,
        metavar="OUT",
        help="write a session with the decisions on which two sessions agree; all other intervals "
        "are undecided, with both decisions in their notes (default: none)",
    )
    add_json(diff)
    add_workers(diff, "number of parallel processes for folders")
    diff.set_defaults(run=deferred_command("diff_command", "diff_command"))


def _refine(refine: Parser) -> None:
    refine.add_argument(
        "clip",
        type=parse_clip_input_path,
        metavar="CLIP",
        help="the clip to correct; '-' reads a BVH from standard input",
    )
    add_output(refine)
    add_detection(refine)
    add_correction_options(refine)
    refine.add_argument(
        "--report",
        type=parse_output_folder,
        metavar="DIR",
        help="also write a report into this folder (default: none)",
    )
    refine.add_argument(
        "--session",
        type=parse_output_path,
        metavar="FILE",
        help="also write the corrections as a session, such as walk.twist.json, for `apply`, "
        "`export`, `report` and the window (default: none)",
    )
    add_json(refine)
    refine.set_defaults(run=deferred_command("correct_commands", "refine_command"))


def _apply(apply: Parser) -> None:
    apply.add_argument(
        "session",
        type=Path,
        metavar="SESSION|FOLDER",
        help="the session (NAME.twist.json or NAME.replay.json), or a folder of sessions",
    )
    apply.add_argument(
        "clip",
        type=Path,
        metavar="CLIP|FOLDER",
        help="the clip of the session, or the folder of the clips",
    )
    add_output(apply, "clip or folder to write; '-' is standard output")
    add_workers(apply, "number of parallel processes for folders")
    add_json(apply)
    apply.set_defaults(run=deferred_command("correct_commands", "apply_command"))


def _report(report: Parser) -> None:
    report.add_argument(
        "what",
        type=Path,
        metavar="SESSION|OUTDIR",
        help="a session, or the OUTDIR of `twistcore batch`",
    )
    add_output(report, "folder for the pages", parse_output_folder, "DIR")
    report.add_argument(
        "--clip",
        type=Path,
        metavar="CLIP",
        help="the clip of the session (default: the path in the session)",
    )
    report.add_argument(
        "--workers",
        type=parse_worker_count,
        default=1,
        metavar="N",
        help="number of processes (default: %(default)s)",
    )
    report.add_argument(
        "--pages",
        type=parse_count,
        metavar="N",
        help="write pages for only the N worst clips (default: all clips)",
    )
    report.add_argument(
        "--play",
        action="store_true",
        help="also play the intervals on the pages of a batch folder, which adds up to 3 MB to "
        "each page (the page of a session always plays them)",
    )
    report.add_argument(
        "--no-pictures",
        action="store_true",
        help="leave out the 3D pictures and the animated figure",
    )
    report.set_defaults(run=deferred_command("report_command", "report_command"))


def _inject(inject: Parser) -> None:
    add_clip(inject, "the BVH into which errors are injected")
    add_output(inject)
    inject.add_argument(
        "--truth",
        type=parse_output_path,
        required=True,
        metavar="TRUTH.json",
        help="file for the list of injected errors, for `twistcore evaluate`",
    )
    inject.add_argument(
        "--seed",
        type=parse_seed,
        required=True,
        metavar="N",
        help="seed of the random numbers; the same seed gives the same errors",
    )
    inject.add_argument("--protocol", default="P0", metavar="NAME", help=_PROTOCOL)
    inject.late = _with_protocols
    add_json(inject)
    inject.set_defaults(run=deferred_command("study_commands", "inject_command"))


def _evaluate(evaluate: Parser) -> None:
    for name, help_text in (
        ("--truth", "files with the injected errors, as written by `twistcore inject --truth`"),
        ("--clean", "clips before the injection"),
        ("--refined", "clips after the refinement"),
    ):
        evaluate.add_argument(
            name, type=Path, required=True, nargs="+", metavar="FILE", help=help_text
        )
    add_json(evaluate)
    evaluate.set_defaults(run=deferred_command("study_commands", "evaluate_command"))


def _tune(tune: Parser) -> None:
    tune.add_argument(
        "source",
        type=Path,
        metavar="FOLDER|CLIP",
        help="a folder of clips, or a clip; with --verdicts, a folder of clips and their sessions",
    )
    add_output(tune, "profile to write; '-' is standard output", parse_output_path, "PROFILE.toml")
    add_method(tune)
    add_rig(tune)
    tune.add_argument(
        "--seeds",
        type=parse_whole_number_limit,
        metavar="N",
        help="number of random draws of errors for each clip; cannot be combined with "
        "--verdicts (default: 3)",
    )
    tune.add_argument(
        "--verdicts",
        action="store_true",
        help="learn from the decisions in the sessions next to the clips, not from injected errors",
    )
    tune.add_argument(
        "--sessions",
        action="store_true",
        help="read chains, decisions and excluded frames from the sessions next to the clips",
    )
    tune.add_argument(
        "--both", action="store_true", help="print the results of all detectors, for comparison"
    )
    tune.add_argument(
        "--performer",
        metavar="NAME",
        help="with --verdicts: use only clips of this performer (default: everyone)",
    )
    tune.add_argument(
        "--alarm-price",
        type=parse_non_negative_number,
        metavar="SHARE",
        help="share of the errors that may be missed to avoid one false alarm per clip "
        "(default: 0.05)",
    )
    tune.add_argument(
        "--smallest",
        type=parse_degrees,
        metavar="DEGREES",
        help="size of the smallest errors to look for (default: 2)",
    )
    tune.add_argument(
        "--workers",
        type=parse_worker_count,
        default=os.cpu_count() or 1,
        metavar="N",
        help="number of processes (default: one for each core)",
    )
    add_json(tune)
    tune.set_defaults(run=deferred_command("tune_command", "tune_command"))


def _benchmark(benchmark: Parser) -> None:
    benchmark.add_argument("folder", type=Path, metavar="FOLDER", help="folder of clean clips")
    benchmark.add_argument(
        "--protocol",
        action="extend",
        nargs="+",
        metavar="NAME",
        help="protocols for drawing errors, as listed by `twistcore inject --help` (default: P0)",
    )
    benchmark.add_argument(
        "--methods",
        action="extend",
        nargs="+",
        metavar="NAME",
        help="methods to compare, or 'detectors', 'baselines' or 'all' (default: all)",
    )
    add_detector_file(benchmark)
    benchmark.add_argument(
        "--seeds",
        type=parse_count,
        default=3,
        metavar="N",
        help="number of random draws of errors for each clip and protocol (default: %(default)s)",
    )
    add_seed(benchmark, 1)
    add_workers(benchmark)
    benchmark.add_argument("--resume", action="store_true", help="continue an interrupted run")
    benchmark.add_argument(
        "--json",
        type=parse_output_path,
        metavar="FILE",
        help="also write the results into a JSON file (default: none)",
    )
    benchmark.add_argument(
        "--csv",
        type=parse_output_path,
        metavar="FILE",
        help="also write the results into a CSV table (default: none)",
    )
    benchmark.set_defaults(run=deferred_command("benchmark_command", "benchmark_command"))


def _with_protocols(inject: argparse.ArgumentParser) -> None:
    """Add the list of protocols to the help of `inject` when the help is printed."""
    from twistcore.synthesis import PROTOCOLS  # numpy

    texts = "; ".join(f"{name}: {p.text}" for name, p in PROTOCOLS.items()).replace("%", "%%")
    action = next(a for a in inject._actions if a.dest == "protocol")
    action.help = f"{_PROTOCOL}: {texts}"


def _export(parser: Parser) -> None:
    parser.add_argument(
        "session",
        type=Path,
        metavar="SESSION",
        help="the session, NAME.twist.json or NAME.replay.json",
    )
    add_clip(parser, "the clip of the session")
    parser.add_argument(
        "--script",
        choices=PROGRAMS,
        required=True,
        help="program that the script is for",
    )
    add_output(parser, "script to write; '-' is standard output", parse_output_path, "FILE.py")
    parser.add_argument(
        "--namespace",
        metavar="NAME",
        help="namespace of the joints in the scene; '' removes the namespace of the clip "
        "(default: as in the clip)",
    )
    parser.add_argument(
        "--take",
        metavar="NAME",
        help="take (in Blender: action) for the keys (default: the current one)",
    )
    parser.add_argument(
        "--fps",
        type=parse_frame_rate,
        metavar="HZ",
        help="frame rate of the scene (default: the clip's)",
    )
    parser.add_argument(
        "--start",
        type=parse_finite_number,
        metavar="N",
        help="frame of the scene at which the clip begins (default: 0, in Blender 1)",
    )
    parser.add_argument(
        "--dry-run",
        action="store_true",
        help="write a script that only lists the keys that it would set",
    )
    parser.set_defaults(run=deferred_command("export_command", "export_command"))


def _completion(parser: Parser) -> None:
    parser.add_argument("shell", choices=SHELLS, help="the shell")
    parser.set_defaults(run=deferred_command("completion", "completion_command"))


def _help(parser: Parser) -> None:
    parser.add_argument(
        "words", nargs="*", metavar="COMMAND", help="command to explain (default: the program)"
    )
    parser.set_defaults(run=_help_command)


def _help_command(arguments: argparse.Namespace) -> int:
    words = [*arguments.words, "--help"]
    make_parser(words).parse_args(words)  # prints the help and ends the program
    return 0


_PROTOCOL = "protocol for drawing errors, or several joined with '+' (default: %(default)s)"

# In the order in which --help lists them.
_COMMANDS: Mapping[str, Callable[[Parser], None]] = {
    "info": _info,
    "detect": _detect,
    "signals": _signals,
    "diff": _diff,
    "refine": _refine,
    "apply": _apply,
    "report": _report,
    "inject": _inject,
    "evaluate": _evaluate,
    "tune": _tune,
    "benchmark": _benchmark,
    "batch": add_batch,
    "watch": add_watch_arguments,
    "merge": add_merge,
    "quamo": add_quamo_subcommands,
    "export": _export,
    "convert": add_convert,
    "clean": add_clean,
    "completion": _completion,
    "help": _help,
}
