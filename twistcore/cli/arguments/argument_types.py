"""What the command line takes where a word stands for a value: checked, refused in one line."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from twistcore.cli.output import terminal_text
from twistcore.detection.kind import Kind
from twistcore.files.atomic import STANDARD_OUTPUT
from twistcore.formats.suffixes import CLIP_SUFFIXES, not_written

KINDS = tuple(kind.replace(" ", "-") for kind in Kind)  # of errors, as --kinds has them
STANDARD_INPUT = Path("/dev/stdin")  # by this name also on systems that have no such file

_LEAST_MIB = 256  # with less numpy cannot be loaded, or a short clip not be analysed
_MOST = 1_000_000  # of what is counted: beyond, a slip of the finger
_MOST_WORKERS = 1024
_LEAST_RATE, _MOST_RATE = 1.0, 10_000.0  # frames a second: those that a file may have


class Parser(argparse.ArgumentParser):
    """One line where the words are wrong, without the usage.

    late: completes the help by what loads slowly, when help is asked for.
    """

    late: Callable[[argparse.ArgumentParser], None] | None = None

    def error(self, message: str) -> NoReturn:
        """End the program with the message."""
        self.exit(2, f"{terminal_text(f'{self.prog}: {message}')}\n")

    def format_help(self) -> str:
        """The help, completed."""
        if self.late is not None:
            self.late(self)
        return super().format_help()


def target(text: str) -> Path:
    """A file to write, '-' for standard output; a file of that name is './-'."""
    return STANDARD_OUTPUT if text == "-" else Path(text)


def clip_target(text: str) -> Path:
    """The same for a clip, or a folder of clips; not a file of a format that is not written."""
    path = target(text)
    refused = not_written(path, " or ".join(CLIP_SUFFIXES))
    if refused and not path.is_dir():
        raise argparse.ArgumentTypeError(f"{text}: {refused}")
    return path


def readable(text: str) -> Path:
    """A clip to read, '-' for standard input; a file of that name is './-'."""
    return STANDARD_INPUT if text == "-" else Path(text)


def folder(text: str) -> Path:
    """A folder to write into."""
    if text == "-":
        raise argparse.ArgumentTypeError("expected a folder; one called '-' is './-'")
    return Path(text)


def tau(text: str) -> float | None:
    """'auto' as None, or degrees above 0 and up to 180 as radians."""
    found = tau_degrees(text)
    return None if found is None else math.radians(found)


def tau_degrees(text: str) -> float | None:
    """'auto' as None, or degrees above 0 and up to 180."""
    if text == "auto":
        return None
    value = _number_in(text)
    if not 0.0 < value <= 180.0:
        raise argparse.ArgumentTypeError(
            f"expected auto or degrees above 0 and up to 180, found {text!r}"
        )
    return value


def degrees(text: str) -> float:
    """Degrees above 0 and up to 180."""
    value = _number_in(text)
    if not 0.0 < value <= 180.0:
        raise argparse.ArgumentTypeError(f"expected degrees above 0 and up to 180, found {text!r}")
    return value


def kinds(text: str) -> frozenset[Kind]:
    """Kinds of errors, comma separated, with '-' or ' ' inside, or 'all'."""
    from twistcore.analysis.clip_analysis import ALL_KINDS  # numpy, which not every command needs

    known = {kind.value.replace(" ", "-"): frozenset({kind}) for kind in Kind} | {"all": ALL_KINDS}
    found: frozenset[Kind] = frozenset()
    for word in text.split(","):
        key = "-".join(word.lower().replace("-", " ").split())
        if key not in known:
            raise argparse.ArgumentTypeError(f"expected {' or '.join(known)}, found {word!r}")
        found |= known[key]
    return found


def seed(text: str) -> int:
    """A whole number from 0."""
    if not (text.isdecimal() and len(text) <= 18):
        raise argparse.ArgumentTypeError(
            f"expected a whole number from 0 of at most 18 digits, found {text[:40]!r}"
        )
    return int(text)


def positive(text: str) -> float:
    """A finite number above 0."""
    value = _number_in(text)
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"expected a number above 0, found {text!r}")
    return value


def rate(text: str) -> float:
    """Frames a second that can be meant."""
    value = _number_in(text)
    if not _LEAST_RATE <= value <= _MOST_RATE:
        raise argparse.ArgumentTypeError(
            f"expected {_LEAST_RATE:g} to {_MOST_RATE:g} frames a second, found {text!r}"
        )
    return value


def share(text: str) -> float:
    """A number from 0 to 1."""
    value = _number_in(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"expected a number from 0 to 1, found {text!r}")
    return value


def mebibytes(text: str) -> float:
    """So many that Python and its libraries have room."""
    if (value := positive(text)) < _LEAST_MIB:
        raise argparse.ArgumentTypeError(f"expected at least {_LEAST_MIB} MiB, found {text!r}")
    return value


def number(text: str) -> float:
    """Any finite number."""
    if not math.isfinite(value := _number_in(text)):
        raise argparse.ArgumentTypeError(f"expected a number, found {text!r}")
    return value


def not_negative(text: str) -> float:
    """0, or a finite number above 0."""
    value = _number_in(text)
    if not (math.isfinite(value) and value >= 0.0):
        raise argparse.ArgumentTypeError(f"expected a number from 0, found {text!r}")
    return value


def count(text: str) -> int:
    """A whole number above 0."""
    return _whole(text, 1, _MOST)


def limit(text: str) -> int:
    """A whole number from 0: how many are let through."""
    return _whole(text, 0, _MOST)


def workers(text: str) -> int:
    """A number of processes."""
    return _whole(text, 1, _MOST_WORKERS)


def _whole(text: str, least: int, most: int) -> int:
    if not (text.isdecimal() and len(text) <= 18 and least <= int(text) <= most):
        what = "a whole number above 0" if least else "a whole number from 0"
        up_to = f" and up to {most:,}" if text.isdecimal() and text.strip("0") else ""
        raise argparse.ArgumentTypeError(f"expected {what}{up_to}, found {text[:40]!r}")
    return int(text)


def _number_in(text: str) -> float:
    """What a text says as a number, nan where it says none."""
    try:
        return float(text)
    except ValueError:
        return math.nan
