"""Read a lesson from a Markdown file.

Each page of a lesson has a text, a task and the place in a clip that the page shows.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from inspector.bundled import ASSETS
from inspector.language import tr, translate_core_sentence
from inspector.lessons.lesson_conditions import Condition, is_task_already_met, read_conditions
from inspector.lessons.lesson_place import FIELDS
from inspector.lessons.lesson_place import LessonPlace as LessonPlace
from twistcore.errors import FormatError, TwistError
from twistcore.files.document_values import format_value_for_message, read_bytes_limited
from twistcore.files.ordinary import is_file

FENCE = "```lesson"
KEYS = ("clip", *FIELDS, "done")  # keys in the settings of a page
_HEAD = ("title", "clip")
_MOST_BYTES = 10_000_000  # files written by this program have a few kilobytes
_PAIR = re.compile(r"([a-z-]+)\s*:\s*(\S.*)")


@dataclass(frozen=True)
class LessonPage:
    """A page of a lesson.

    Attributes
    ----------
    body
        The text, as Markdown with TeX between $…$.
    task
        The task, or ''.
    place
        The place in a clip that the page shows.
    done
        The conditions that must be met to complete the task.
    at
        The line number of the page's heading, from 1.
    lines
        The line numbers of the page's settings, keyed by setting.
    """

    title: str
    body: str
    task: str
    place: LessonPlace
    done: tuple[Condition, ...] = ()
    at: int = field(default=0, compare=False)
    lines: Mapping[str, int] = field(default_factory=dict, compare=False)

    def line(self, key: str) -> int:
        """Return the line number of a setting.

        For a setting inherited from an earlier page, this is the line number of the page's heading.
        """
        return self.lines.get(key, self.at)


@dataclass(frozen=True)
class LessonFile:
    """A lesson that was read from a file."""

    title: str
    path: Path
    pages: tuple[LessonPage, ...]


def read_lesson(path: Path) -> LessonFile:
    """Read a lesson. Raises FormatError with the file, the line and a description of valid text."""
    try:
        text = read_bytes_limited(path, _MOST_BYTES).decode("utf-8-sig")
    except (TwistError, UnicodeDecodeError) as error:
        why = tr("expected a lesson as UTF-8 text ({error})", error=translate_core_sentence(error))
        raise FormatError(f"{path}: {why}") from None
    lines = text.splitlines()
    head, first = _front_matter(path, lines)
    title, clip = head["title"][1], _clip(path, *head["clip"])
    starts = _headings(lines, first)
    if not starts:
        raise _error(path, first + 1, tr("a page, which begins with a line '# Heading'"))
    for k in range(first, starts[0]):
        if lines[k].strip():
            expected = tr("a page, which begins with a line '# Heading'")
            raise _error(path, k + 1, expected, lines[k])
    pages: list[LessonPage] = []
    for start, stop in zip(starts, [*starts[1:], len(lines)], strict=True):
        before = pages[-1].place if pages else LessonPlace(clip)
        pages.append(_page(path, lines, start, stop, before))
    return LessonFile(title, path, tuple(pages))


def _front_matter(path: Path, lines: list[str]) -> tuple[dict[str, tuple[int, str]], int]:
    """Return the settings at the top of the file, and the index of the line after them.

    The settings are a dict of key → (line number, value).
    """
    if not lines or lines[0].strip() != "---":
        expected = tr("a lesson that begins with '---', 'title: …' and 'clip: …'")
        raise _error(path, 1, expected, lines[0] if lines else "")
    stop = next((k for k in range(1, len(lines)) if lines[k].strip() == "---"), None)
    if stop is None:
        expected = tr("a line '---' after the title and the clip, but the file ends before it")
        raise _error(path, len(lines), expected)
    head = _pairs(path, lines, 1, stop, _HEAD)
    for key in _HEAD:
        if key not in head:
            raise _error(path, stop + 1, tr("a line '{key}: …' above this one", key=key))
    return head, stop + 1


def _headings(lines: list[str], first: int) -> list[int]:
    """Return the indices of lines that are headings, from line `first` on.

    Lines with '#' inside code fences are not headings.
    """
    out, fenced = [], False
    for k in range(first, len(lines)):
        if lines[k].startswith("```"):
            fenced = not fenced
        elif lines[k].startswith("# ") and not fenced:
            out.append(k)
    return out


def _page(path: Path, lines: list[str], start: int, stop: int, before: LessonPlace) -> LessonPage:
    """Read a page from the lines [start, stop), which begin with its heading.

    `before` is the place of the previous page, from which the page inherits settings.
    """
    opened = [k for k in range(start, stop) if lines[k].strip() == FENCE]
    if len(opened) > 1:
        raise _error(
            path,
            opened[1] + 1,
            tr("only one block of settings per page, but this is the second one"),
        )
    text = lines[start + 1 : stop]
    settings: dict[str, tuple[int, str]] = {}
    if opened:
        at = opened[0]
        closed = next((k for k in range(at + 1, stop) if lines[k].strip() == "```"), None)
        if closed is None:
            raise _error(
                path,
                at + 1,
                tr("a line '```' at the end of the settings block that begins here"),
            )
        settings = _pairs(path, lines, at + 1, closed, KEYS)
        text = lines[start + 1 : at] + lines[closed + 1 : stop]
    # A page inherits the place of the previous page, but not the page's list of symbols and
    # highlight.
    place = LessonPlace(before.clip, before.frame, before.chain, before.camera)
    done: tuple[Condition, ...] = ()
    for key, (line, value) in settings.items():
        try:
            if key == "done":
                done = read_conditions(value)
            elif key == "clip":
                place = replace(place, clip=_clip(path, line, value))
            else:
                place = replace(place, **FIELDS[key](value))
        except ValueError as error:
            raise _error(path, line, str(error), value) from None
    if is_task_already_met(done, place):
        line, value = settings["done"]
        raise _error(path, line, tr("a task that is not already done when the page opens"), value)
    body, task = body_and_task(text)
    stands = {key: line for key, (line, _) in settings.items()}
    return LessonPage(lines[start][2:].strip(), body, task, place, done, start + 1, stands)


def body_and_task(lines: list[str]) -> tuple[str, str]:
    """Return the text of a page, and its task as a single line.

    The task is the block quote at the end of the page.
    """
    text = "\n".join(lines).strip().split("\n")
    at = len(text)
    while at > 0 and text[at - 1].startswith(">"):
        at -= 1
    task = " ".join(line.removeprefix(">").strip() for line in text[at:])
    return "\n".join(text[:at]).strip(), task.strip()


def _pairs(
    path: Path, lines: list[str], start: int, stop: int, known: tuple[str, ...]
) -> dict[str, tuple[int, str]]:
    """Return lines of the form 'key: value' as a dict of key → (line number, value).

    Line numbers are counted from 1. `known` contains the allowed keys.
    """
    out: dict[str, tuple[int, str]] = {}
    for k in range(start, stop):
        line = lines[k].strip()
        if not line:
            continue
        pair = _PAIR.fullmatch(line)
        if pair is None or pair[1] not in known:
            expected = tr("'key: value', where the key is one of {known}", known=", ".join(known))
            raise _error(path, k + 1, expected, line)
        if pair[1] in out:
            raise _error(path, k + 1, tr("{key!r} only once", key=pair[1]), line)
        out[pair[1]] = (k + 1, pair[2].strip())
    return out


def _clip(path: Path, line: int, name: str) -> Path:
    """Return the path of a clip in the lesson's folder or, if it is not there, a bundled clip.

    `path` is the file of the lesson.
    """
    if Path(name).name != name or "\\" in name:
        raise _error(path, line, tr("the name of a BVH file, without a folder"), name)
    for folder in (path.parent, ASSETS):
        if is_file(clip := folder / name) and clip.suffix.lower() == ".bvh":
            return clip
    raise _error(path, line, tr("a BVH file in the lesson's folder or a bundled sample"), name)


def _error(path: Path, line: int, expected: str, found: str = "") -> FormatError:
    fields = {"file": path, "line": line, "expected": expected}
    if not found.strip():
        return FormatError(tr("{file}, line {line}: expected {expected}", **fields))
    own = format_value_for_message(found.strip())
    return FormatError(
        tr("{file}, line {line}: expected {expected}, found {found}", **fields, found=own)
    )
