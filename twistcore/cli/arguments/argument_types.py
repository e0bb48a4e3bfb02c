"""Convert and check the values of command-line arguments.

Each function converts the string of an argument, and raises ArgumentTypeError with a one-line
message if the string is invalid.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from twistcore.cli.output import terminal_text
from twistcore.detection.kind import Kind
from twistcore.files.atomic import STANDARD_OUTPUT
from twistcore.formats.suffixes import CLIP_SUFFIXES, unsupported_suffix_message

KINDS = tuple(kind.replace(" ", "-") for kind in Kind)  # kinds of errors, as --kinds spells them
STANDARD_INPUT = Path("/dev/stdin")  # means standard input, even if there is no such file

_LEAST_MIB = 256  # with less memory, numpy cannot be loaded or a short clip cannot be analysed
_MOST = 1_000_000  # a larger count is probably a typing error
_MOST_WORKERS = 1024
_LEAST_RATE, _MOST_RATE = 1.0, 10_000.0  # accepted frames per second


class Parser(argparse.ArgumentParser):
    """An argument parser that reports an error in one line and refers to --help.

    `late` is called before the help is printed, to add the parts that are slow to create.
    """

    late: Callable[[argparse.ArgumentParser], None] | None = None

    def error(self, message: str) -> NoReturn:
        """Print an error message and end the program with exit code 2."""
        end = "" if message.endswith((".", "?")) else "."
        self.exit(2, f"{terminal_text(f'{self.prog}: {message}{end} {self._where_help_is()}')}\n")

    def format_help(self) -> str:
        """Return the help, including the parts that are slow to create."""
        if self.late is not None:
            self.late(self)
        return super().format_help()

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse the arguments, and suggest similar options in the error for an unknown option."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(self._unknown(unknown))
        return found, unknown

    def _unknown(self, words: Sequence[str]) -> str:
        option = next((word.partition("=")[0] for word in words if word.startswith("-")), "")
        if not option:
            return f"expected no more arguments, found {words[0]!r}"
        if self._subparsers is not None:
            return f"expected a command before its options, found {option}"
        known = [word for word in self._option_string_actions if word.startswith("--")]
        return f"unknown option {option}{_did_you_mean(option, known)}"

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        known = [str(choice) for choice in action.choices]
        text = _did_you_mean(str(value), known) or f"; expected one of {', '.join(known)}"
        if isinstance(action, argparse._SubParsersAction):
            raise argparse.ArgumentError(None, f"unknown command {value!r}{text}")
        raise argparse.ArgumentError(action, f"unknown value {value!r}{text}")

    def _where_help_is(self) -> str:
        return f"See `{self.prog} --help`."


def _did_you_mean(word: str, known: Sequence[str]) -> str:
    """Return a question such as '; did you mean detect?', or '' if `known` has no similar word."""
    from difflib import get_close_matches  # slow to load, and seldom needed

    near = get_close_matches(word.lower(), known, cutoff=0.65)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def parse_output_path(text: str) -> Path:
    """Return the path of a file to write. '-' is standard output, and './-' is a file named '-'."""
    return STANDARD_OUTPUT if text == "-" else Path(text)


def parse_clip_output_path(text: str) -> Path:
    """Return the path of a clip, or of a folder of clips, to write. Its format must be writable."""
    path = parse_output_path(text)
    refused = unsupported_suffix_message(path, " or ".join(CLIP_SUFFIXES))
    if refused and not path.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: {refused}")
    return path


def parse_clip_input_path(text: str) -> Path:
    """Return the path of a clip to read. '-' is standard input, and './-' is a file named '-'."""
    return STANDARD_INPUT if text == "-" else Path(text)


def parse_output_folder(text: str) -> Path:
    """Return the path of a folder to write into, which need not exist."""
    if text == "-":
        raise argparse.ArgumentTypeError(
            "expected a folder, found '-'; write './-' for a folder called '-'"
        )
    return Path(text)


def parse_tau(text: str) -> float | None:
    """Convert a string in degrees, above 0 and at most 180, to the threshold τ in radians.

    'auto' is converted to None.
    """
    found = parse_tau_degrees(text)
    return None if found is None else math.radians(found)


def parse_tau_degrees(text: str) -> float | None:
    """Convert a string to the threshold τ in degrees, above 0 and at most 180.

    'auto' is converted to None.
    """
    if text == "auto":
        return None
    value = _number_in(text)
    if not 0.0 < value <= 180.0:
        raise argparse.ArgumentTypeError(
            f"expected 'auto' or an angle in degrees above 0 and up to 180, found {text!r}"
        )
    return value


def parse_degrees(text: str) -> float:
    """Convert a string to an angle in degrees, above 0 and at most 180."""
    value = _number_in(text)
    if not 0.0 < value <= 180.0:
        raise argparse.ArgumentTypeError(
            f"expected an angle in degrees above 0 and up to 180, found {text!r}"
        )
    return value


def parse_error_kinds(text: str) -> frozenset[Kind]:
    """Return the kinds of errors named in a comma-separated list, or all kinds for 'all'.

    The words of a name may be separated by '-' or ' '.
    """
    from twistcore.analysis.clip_analysis import ALL_KINDS  # numpy, which not every command needs

    known = {kind.value.replace(" ", "-"): frozenset({kind}) for kind in Kind} | {"all": ALL_KINDS}
    found: frozenset[Kind] = frozenset()
    for word in text.split(","):
        key = "-".join(word.lower().replace("-", " ").split())
        if key not in known:
            raise argparse.ArgumentTypeError(f"expected {' or '.join(known)}, found {word!r}")
        found |= known[key]
    return found


def parse_seed(text: str) -> int:
    """Convert a string to a whole number of at least 0."""
    if not (text.isdecimal() and len(text) <= 18):
        raise argparse.ArgumentTypeError(
            f"expected a whole number of at least 0 with at most 18 digits, found {text[:40]!r}"
        )
    return int(text)


def parse_positive_number(text: str) -> float:
    """Convert a string to a finite number above 0."""
    value = _number_in(text)
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"expected a number above 0, found {text!r}")
    return value


def parse_frame_rate(text: str) -> float:
    """Convert a string to frames per second, from 1 to 10,000."""
    value = _number_in(text)
    if not _LEAST_RATE <= value <= _MOST_RATE:
        raise argparse.ArgumentTypeError(
            f"expected {_LEAST_RATE:g} to {_MOST_RATE:g} frames per second, found {text!r}"
        )
    return value


def parse_fraction(text: str) -> float:
    """Convert a string to a number from 0 to 1."""
    value = _number_in(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"expected a number from 0 to 1, found {text!r}")
    return value


def parse_mebibytes(text: str) -> float:
    """Convert a string to an amount of memory in MiB, which must be enough for Python and numpy."""
    if (value := parse_positive_number(text)) < _LEAST_MIB:
        raise argparse.ArgumentTypeError(f"expected at least {_LEAST_MIB} MiB, found {text!r}")
    return value


def parse_finite_number(text: str) -> float:
    """Convert a string to a finite number."""
    if not math.isfinite(value := _number_in(text)):
        raise argparse.ArgumentTypeError(f"expected a number, found {text!r}")
    return value


def parse_non_negative_number(text: str) -> float:
    """Convert a string to a finite number of at least 0."""
    value = _number_in(text)
    if not (math.isfinite(value) and value >= 0.0):
        raise argparse.ArgumentTypeError(f"expected a number of at least 0, found {text!r}")
    return value


def parse_count(text: str) -> int:
    """Convert a string to a whole number above 0."""
    return _whole(text, 1, _MOST)


def parse_whole_number_limit(text: str) -> int:
    """Convert a string to a whole number of at least 0, used as a limit."""
    return _whole(text, 0, _MOST)


def parse_worker_count(text: str) -> int:
    """Convert a string to a number of processes, from 1 to 1024."""
    return _whole(text, 1, _MOST_WORKERS)


def _whole(text: str, least: int, most: int) -> int:
    if not (text.isdecimal() and len(text) <= 18 and least <= int(text) <= most):
        what = f"a whole number of at least {least}"
        up_to = f" and at most {most:,}" if text.isdecimal() and text.strip("0") else ""
        raise argparse.ArgumentTypeError(f"expected {what}{up_to}, found {text[:40]!r}")
    return int(text)


def _number_in(text: str) -> float:
    """Return the number in a string, or NaN if the string is not a number."""
    try:
        return float(text)
    except ValueError:
        return math.nan
