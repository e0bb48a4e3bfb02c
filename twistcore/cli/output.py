"""Print results, notes and problems, and check that no output replaces an input.

This module imports neither numpy nor scipy. All printed text is escaped by :func:`terminal_text`.
"""

from __future__ import annotations

import contextlib
import json
import os
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field
from pathlib import Path
from typing import IO, Any

from twistcore.errors import TwistError
from twistcore.files.atomic import is_stream, resolve_write_path, same_file
from twistcore.files.encoding import (
    escape_control_characters,
    escape_json_control_characters,
    json_text,
)
from twistcore.work.frozen import dataclass
from twistcore.work.progress import TellName, show_clip_progress_bar, silent_clip_progress

_BOLD, _YELLOW, _RED = "1", "33", "31"


@dataclass(frozen=True)
class Voice:
    """The verbosity of the output.

    Parameters
    ----------
    quiet
        True to print only results and errors.
    verbose
        True to print the duration of each step as well.
    document
        True if a JSON document is printed on standard output instead of remarks.
    known
        Problems and notes that are not printed again.
    listed
        All problems and notes so far.
    """

    quiet: bool = False
    verbose: bool = False
    document: bool = False
    known: frozenset[str] = frozenset()
    listed: set[str] = field(default_factory=set)


_USUAL = Voice()
_voices = [_USUAL]  # the last one is used, by all threads, since other threads report progress


@contextlib.contextmanager
def use_output_voice(voice: Voice) -> Iterator[None]:
    """Use `voice` for all output within the context."""
    _voices.append(voice)
    try:
        yield
    finally:
        _voices.pop()


def is_quiet() -> bool:
    """Return True if only results and errors should be printed."""
    return _voices[-1].quiet


def terminal_text(text: object) -> str:
    r"""Return an object's text for a terminal, with control characters escaped, such as `\x1b`."""
    return escape_control_characters(text)


# -- lines of text ---------------------------------------------------------------------------------


def print_result(text: str = "", *, head: bool = False) -> None:
    """Print a line of the result on standard output. Set `head` to True for a heading."""
    _line(text, sys.stdout, _BOLD if head else "")


def print_result_lines(text: str) -> None:
    """Print a result of several lines on standard output."""
    for line in text.removesuffix("\n").split("\n"):
        print_result(line)


def print_remark(text: str) -> None:
    """Print on standard output what the command has done, unless --quiet or --json is given."""
    if not (is_quiet() or _voices[-1].document):
        _line(text, sys.stdout)


def print_progress(text: str) -> None:
    """Print a line about progress on standard error, unless --quiet is given."""
    if not is_quiet():
        _line(text, sys.stderr)


def print_note(text: object) -> None:
    """Print a note on standard error, unless --quiet is given or the voice lists it as known."""
    if _is_new(text) and not is_quiet():
        _line(text, sys.stderr, _YELLOW)


def print_problem(text: object) -> None:
    """Print a problem on standard error, unless the voice lists it as known."""
    if _is_new(text):
        _line(text, sys.stderr, _RED)


def _is_new(text: object) -> bool:
    voice = _voices[-1]
    voice.listed.add(str(text))
    return str(text) not in voice.known


@contextlib.contextmanager
def print_step_duration(text: str) -> Iterator[None]:
    """Print on standard error how long the context took, if --verbose is given."""
    begin = time.perf_counter()
    yield
    if _voices[-1].verbose:
        _line(f"{text}: {time.perf_counter() - begin:.2f} s", sys.stderr)


@contextlib.contextmanager
def clip_progress_printer(total: int, done: int = 0) -> Iterator[TellName]:
    """Yield a function that prints the progress, to call with the name of each finished clip.

    `total` is the number of clips, and `done` is the number of clips already finished. With
    --quiet, the function prints nothing.
    """
    with silent_clip_progress(total) if is_quiet() else show_clip_progress_bar(total, done) as tell:
        yield lambda name: tell(terminal_text(name))


def _line(text: object, stream: IO[str], colour: str = "") -> None:
    line = terminal_text(text)
    print(f"\x1b[{colour}m{line}\x1b[0m" if colour and _colours(stream) else line, file=stream)
    if stream is sys.stderr:
        stream.flush()


def _colours(stream: IO[str]) -> bool:
    """Return True for a terminal with colours, unless NO_COLOR disables them (no-color.org)."""
    if os.environ.get("NO_COLOR") or os.environ.get("TERM") == "dumb":
        return False
    knows = os.name == "posix" or bool(os.environ.get("WT_SESSION") or os.environ.get("TERM"))
    return knows and stream.isatty()


# -- documents, problems, files --------------------------------------------------------------------


def print_json(document: dict[str, Any]) -> None:
    """Print a JSON document on standard output. Raises ValueError if a number is not finite."""
    text = json_text(document)
    if (sys.stdout.encoding or "utf-8").lower() != "utf-8":
        text = json.dumps(json.loads(text), indent=1)  # other characters are escaped
    print("\n".join(map(escape_json_control_characters, text.split("\n"))))


def report_problems(problems: Sequence[str], done: int) -> int:
    """Print the problems and return the exit code.

    The code is 0 without problems, 1 with problems, and 2 if `done`, the number of processed clips,
    is 0.
    """
    for sentence in problems:
        print_problem(sentence)
    return int(bool(problems)) if done else 2


def count_with_noun(number: int, what: str, several: str = "") -> str:
    """Return a count with its noun, such as '1 clip' or '2 clips'.

    `several` is the plural if it does not end in 's'.
    """
    return f"{number} {what if number == 1 else several or f'{what}s'}"


def refuse_overwrite(outputs: Sequence[Path], sources: Iterable[Path]) -> None:
    """Raise TwistError if an output would replace an input or another output, or has no folder.

    Links are followed. Raises OSError if an output cannot be written.
    """
    for k, output in enumerate(outputs):
        end = resolve_write_path(output)
        if any(same_file(output, source) for source in sources):
            raise TwistError(
                f"{output} is an input of this command; choose another file to write to"
            )
        if any(
            end == resolve_write_path(other) or same_file(output, other) for other in outputs[:k]
        ):
            raise TwistError(f"{output} is given for two outputs; choose different files")
        if not is_stream(output) and not end.parent.is_dir():
            raise TwistError(
                f"{output}: the folder of this file does not exist; create it, or choose "
                "another folder"
            )
