"""What commands say and where, and outputs that replace nothing.

Loads neither numpy nor scipy. Everything that is printed goes through :func:`terminal_text`.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import IO, Any

from twistcore.errors import TwistError
from twistcore.files.atomic import destination, is_stream, same_file
from twistcore.files.encoding import json_text, legible, legible_json
from twistcore.work.frozen import dataclass
from twistcore.work.progress import TellName, clip_counter, uncounted

_BOLD, _YELLOW, _RED = "1", "33", "31"


@dataclass(frozen=True)
class Voice:
    """How much is said: quiet leaves results and errors, verbose adds steps and their times.

    document: a JSON document stands for what would be remarked on standard output.
    """

    quiet: bool = False
    verbose: bool = False
    document: bool = False


_USUAL = Voice()
_voices = [_USUAL]  # the last counts; not by thread: progress is told from others, too


@contextlib.contextmanager
def speaking(voice: Voice) -> Iterator[None]:
    """Say so much meanwhile."""
    _voices.append(voice)
    try:
        yield
    finally:
        _voices.pop()


def is_quiet() -> bool:
    """Whether only results and errors are wanted."""
    return _voices[-1].quiet


def terminal_text(text: object) -> str:
    r"""A text as a terminal may have it: what it would obey is escaped, as `\x1b`."""
    return legible(text)


# -- a line each -----------------------------------------------------------------------------------


def say(text: str = "", *, head: bool = False) -> None:
    """A line of the result, on standard output; head: of a table or a section."""
    _line(text, sys.stdout, _BOLD if head else "")


def say_all(text: str) -> None:
    """A result of several lines."""
    for line in text.removesuffix("\n").split("\n"):
        say(line)


def remark(text: str) -> None:
    """What was done, on standard output."""
    if not (is_quiet() or _voices[-1].document):
        _line(text, sys.stdout)


def progress(text: str) -> None:
    """How far it is, on standard error."""
    if not is_quiet():
        _line(text, sys.stderr)


def note(text: object) -> None:
    """What a person should know, on standard error."""
    if not is_quiet():
        _line(text, sys.stderr, _YELLOW)


def problem(text: object) -> None:
    """What could not be done, on standard error."""
    _line(text, sys.stderr, _RED)


@contextlib.contextmanager
def step(text: str) -> Iterator[None]:
    """Say on standard error how long it took, where that is asked for."""
    begin = time.perf_counter()
    yield
    if _voices[-1].verbose:
        _line(f"{text}: {time.perf_counter() - begin:.2f} s", sys.stderr)


@contextlib.contextmanager
def counter(total: int, done: int = 0) -> Iterator[TellName]:
    """To be called with the name of every clip that is through; silent where that is asked for."""
    with uncounted(total) if is_quiet() else clip_counter(total, done) as tell:
        yield lambda name: tell(terminal_text(name))


def _line(text: object, stream: IO[str], colour: str = "") -> None:
    line = terminal_text(text)
    print(f"\x1b[{colour}m{line}\x1b[0m" if colour and _colours(stream) else line, file=stream)
    if stream is sys.stderr:
        stream.flush()


def _colours(stream: IO[str]) -> bool:
    """Whether it is a terminal that knows colours, and nobody asked for none (no-color.org)."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    knows = os.name == "posix" or bool(os.environ.get("WT_SESSION") or os.environ.get("TERM"))
    return knows and stream.isatty()


# -- documents, problems, files --------------------------------------------------------------------


def print_json(document: dict[str, Any]) -> None:
    """Write a JSON document to stdout; ValueError where a number is not finite."""
    text = json_text(document)
    if (sys.stdout.encoding or "utf-8").lower() != "utf-8":
        text = json.dumps(json.loads(text), indent=1)  # what it cannot write, escaped
    print("\n".join(map(legible_json, text.split("\n"))))


def tell_problems(problems: Sequence[str], done: int) -> int:
    """List what could not be processed beside so many that could; the exit code."""
    for sentence in problems:
        problem(sentence)
    return int(bool(problems)) if done else 2


def count_of(number: int, what: str, several: str = "") -> str:
    """'1 clip', '2 clips'; several: the plural that is no 's' behind it."""
    return f"{number} {what if number == 1 else several or f'{what}s'}"


def refuse_overwrite(outputs: Sequence[Path], sources: Iterable[Path]) -> None:
    """Before anything is written: every output has a folder and replaces no input or output.

    Links are followed. Raises TwistError, and OSError for what cannot be written at all.
    """
    for k, output in enumerate(outputs):
        end = destination(output)
        if any(same_file(output, source) for source in sources):
            raise TwistError(f"{output}: expected another file than an input of this command")
        if any(end == destination(other) or same_file(output, other) for other in outputs[:k]):
            raise TwistError(f"{output}: expected different files for different outputs")
        if not is_stream(output) and not end.parent.is_dir():
            raise TwistError(f"{output}: expected an existing folder to write into")
