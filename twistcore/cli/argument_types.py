"""What the command line takes where a word stands for a value: checked, refused in one line."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from twistcore.atomic import STANDARD_OUTPUT

if TYPE_CHECKING:
    from twistcore.detection import Kind

_LEAST_MIB = 256  # with less numpy cannot be loaded, or a short clip not be analysed


class Parser(argparse.ArgumentParser):
    """One line where the words are wrong, without the usage."""

    def error(self, message: str) -> NoReturn:
        """End the program with the message."""
        self.exit(2, f"{self.prog}: {message}\n")


def target(text: str) -> Path:
    """A file to write, '-' for standard output; a file of that name is './-'."""
    return STANDARD_OUTPUT if text == "-" else Path(text)


def folder(text: str) -> Path:
    """A folder to write into."""
    if text == "-":
        raise argparse.ArgumentTypeError("expected a folder; one called '-' is './-'")
    return Path(text)


def tau(text: str) -> float | None:
    """'auto' as None, or degrees above 0 as radians."""
    return None if text == "auto" else math.radians(positive(text))


def kinds(text: str) -> frozenset[Kind]:
    """Kinds of errors, comma separated, with '-' or ' ' inside, or 'all'."""
    from twistcore.analysis import ALL_KINDS  # numpy, which not every command needs
    from twistcore.detection import Kind

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
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number from 0, found {text!r}")
    return int(text)


def positive(text: str) -> float:
    """A finite number above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise argparse.ArgumentTypeError(f"expected a number above 0, found {text!r}")
    return value


def mebibytes(text: str) -> float:
    """So many that Python and its libraries have room."""
    if (value := positive(text)) < _LEAST_MIB:
        raise argparse.ArgumentTypeError(f"expected at least {_LEAST_MIB} MiB, found {text!r}")
    return value


def number(text: str) -> float:
    """Any number."""
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected a number, found {text!r}") from None


def not_negative(text: str) -> float:
    """0, or a finite number above 0."""
    return 0.0 if text == "0" else positive(text)


def count(text: str) -> int:
    """A whole number above 0."""
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"expected a whole number above 0, found {text!r}")
    return int(text)
