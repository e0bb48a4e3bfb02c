"""A lesson as one Markdown file: its pages, and where in which clip each of them stands."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from inspector.bundled import ASSETS
from inspector.lessons.lesson_conditions import Condition, read_conditions
from inspector.teaching.symbols import SYMBOLS
from twistcore.decomposition import WhatIf
from twistcore.errors import FormatError

FENCE = "```lesson"
TABS = ("teaching", "intervals")
LOOKS = ("before", "after", "both")
_HEAD = ("title", "clip")
_PAIR = re.compile(r"([a-z-]+)\s*:\s*(\S.*)")


@dataclass(frozen=True)
class Camera:
    """Where the limb is seen from: azimuth 0 is the figure's front, radians.

    zoom: 1 shows the limb as large as the program does itself, 2 twice as large.
    """

    azimuth: float
    elevation: float
    zoom: float


@dataclass(frozen=True)
class Place:
    """What a page shows.

    frame: from 0; chain: '' for none; camera: None where the program chooses it for the limb;
    show: symbols whose rows are listed, () for all; lit: a symbol or ''; stage: as TaughtFrame's;
    tab: one of TABS; look: one of LOOKS; skin: the striped skin instead of bones.
    """

    clip: Path
    frame: int = 0
    chain: str = ""
    camera: Camera | None = None
    show: tuple[str, ...] = ()
    lit: str = ""
    what_if: WhatIf = field(default_factory=WhatIf)
    stage: float | None = None
    tab: str = "teaching"
    look: str = "both"
    skin: bool = False


@dataclass(frozen=True)
class LessonPage:
    """body: Markdown with TeX between $…$; task: what is to be done; done: all that tell it is."""

    title: str
    body: str
    task: str
    place: Place
    done: tuple[Condition, ...] = ()


@dataclass(frozen=True)
class LessonFile:
    """A lesson as it stands in a file."""

    title: str
    path: Path
    pages: tuple[LessonPage, ...]


def read_lesson(path: Path) -> LessonFile:
    """Read a lesson; FormatError with file, line and what was expected."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise FormatError(f"{path}: expected a lesson as UTF-8 text ({error})") from None
    lines = text.splitlines()
    head, first = _front_matter(path, lines)
    title, clip = head["title"][1], _clip(path, *head["clip"])
    starts = _headings(lines, first)
    if not starts:
        raise _error(path, first + 1, "a page, which begins with a line '# Heading'")
    for k in range(first, starts[0]):
        if lines[k].strip():
            raise _error(path, k + 1, "a page, which begins with a line '# Heading'", lines[k])
    pages: list[LessonPage] = []
    for start, stop in zip(starts, [*starts[1:], len(lines)], strict=True):
        before = pages[-1].place if pages else Place(clip)
        pages.append(_page(path, lines, start, stop, before))
    return LessonFile(title, path, tuple(pages))


def _front_matter(path: Path, lines: list[str]) -> tuple[dict[str, tuple[int, str]], int]:
    """Key → (line, value), and the first line after it."""
    if not lines or lines[0].strip() != "---":
        raise _error(path, 1, "'---' and then 'title: …' and 'clip: …'", lines[0] if lines else "")
    stop = next((k for k in range(1, len(lines)) if lines[k].strip() == "---"), None)
    if stop is None:
        raise _error(path, len(lines), "'---' after title and clip, found the end of the file")
    head = _pairs(path, lines, 1, stop, _HEAD)
    for key in _HEAD:
        if key not in head:
            raise _error(path, stop + 1, f"'{key}: …' above this line")
    return head, stop + 1


def _headings(lines: list[str], first: int) -> list[int]:
    """The lines that begin a page; within a fence '#' begins none."""
    out, fenced = [], False
    for k in range(first, len(lines)):
        if lines[k].startswith("```"):
            fenced = not fenced
        elif lines[k].startswith("# ") and not fenced:
            out.append(k)
    return out


def _page(path: Path, lines: list[str], start: int, stop: int, before: Place) -> LessonPage:
    """The page from one heading to the next."""
    opened = [k for k in range(start, stop) if lines[k].strip() == FENCE]
    if len(opened) > 1:
        raise _error(path, opened[1] + 1, "one block of settings a page, found a second")
    text = lines[start + 1 : stop]
    settings: dict[str, tuple[int, str]] = {}
    if opened:
        at = opened[0]
        closed = next((k for k in range(at + 1, stop) if lines[k].strip() == "```"), None)
        if closed is None:
            raise _error(path, at + 1, "'```' after the settings that begin here")
        settings = _pairs(path, lines, at + 1, closed, KEYS)
        text = lines[start + 1 : at] + lines[closed + 1 : stop]
    # Where a page stands goes on to the next, what is looked at there does not.
    place = Place(before.clip, before.frame, before.chain, before.camera)
    done: tuple[Condition, ...] = ()
    for key, (line, value) in settings.items():
        try:
            if key == "done":
                done = read_conditions(value)
            elif key == "clip":
                place = replace(place, clip=_clip(path, line, value))
            else:
                place = replace(place, **_FIELDS[key](value))
        except ValueError as error:
            raise _error(path, line, str(error), value) from None
    body, task = _body_and_task(text)
    return LessonPage(lines[start][2:].strip(), body, task, place, done)


def _body_and_task(lines: list[str]) -> tuple[str, str]:
    """The text, and the quoted paragraph that ends it, in one line."""
    text = "\n".join(lines).strip().split("\n")
    at = len(text)
    while at > 0 and text[at - 1].startswith(">"):
        at -= 1
    task = " ".join(line.removeprefix(">").strip() for line in text[at:])
    return "\n".join(text[:at]).strip(), task.strip()


def _pairs(
    path: Path, lines: list[str], start: int, stop: int, known: tuple[str, ...]
) -> dict[str, tuple[int, str]]:
    """Lines 'key: value' as key → (line from 1, value)."""
    out: dict[str, tuple[int, str]] = {}
    for k in range(start, stop):
        line = lines[k].strip()
        if not line:
            continue
        pair = _PAIR.fullmatch(line)
        if pair is None or pair[1] not in known:
            raise _error(path, k + 1, f"'key: value' with a key of {', '.join(known)}", line)
        if pair[1] in out:
            raise _error(path, k + 1, f"{pair[1]!r} once", line)
        out[pair[1]] = (k + 1, pair[2].strip())
    return out


def _clip(path: Path, line: int, name: str) -> Path:
    """A clip beside the lesson, else one that comes with the program."""
    for folder in (path.parent, ASSETS):
        if (clip := folder / name).is_file() and clip.suffix.lower() == ".bvh":
            return clip
    raise _error(path, line, "a BVH file beside the lesson or one that is bundled", name)


def _error(path: Path, line: int, expected: str, found: str = "") -> FormatError:
    found = f", found {found.strip()!r}" if found.strip() else ""
    return FormatError(f"{path}, line {line}: expected {expected}{found}")


# -- values of the settings ------------------------------------------------------------------------


def _frame(text: str) -> dict[str, Any]:
    if not text.isdecimal():
        raise ValueError("a frame, counted from 0")
    return {"frame": int(text)}


def _camera(text: str) -> dict[str, Any]:
    if text == "limb":
        return {"camera": None}
    numbers = _numbers(text, 3, "'limb', or azimuth and elevation in degrees and a zoom")
    if numbers[2] <= 0.0:
        raise ValueError("a zoom above 0")
    azimuth, elevation = np.radians(numbers[:2])
    return {"camera": Camera(float(azimuth), float(elevation), numbers[2])}


def _symbol(text: str) -> str:
    if text not in SYMBOLS:
        raise ValueError(f"a symbol of {', '.join(SYMBOLS)}")
    return text


def _look(text: str) -> dict[str, Any]:
    words = [word.strip() for word in text.split(",")]
    figures = [word for word in words if word in LOOKS]
    if len(figures) > 1 or any(word not in (*LOOKS, "skin") for word in words):
        raise ValueError(f"one of {', '.join(LOOKS)}, and 'skin' where the skin is shown")
    return {"look": figures[0] if figures else "both", "skin": "skin" in words}


def _tab(text: str) -> dict[str, Any]:
    if text not in TABS:
        raise ValueError(f"one of {', '.join(TABS)}")
    return {"tab": text}


def _what_if(text: str) -> dict[str, Any]:
    altered: dict[str, Any] = {}
    stage: float | None = None
    for part in text.split(","):
        name, _, value = part.strip().partition(" ")
        if name == "stage":
            (stage,) = _numbers(value, 1, "a number from 0 to 2 after 'stage'")
        elif name in _ALTERED:
            altered[name] = _ALTERED[name](value)
        else:
            raise ValueError(f"{', '.join((*_ALTERED, 'stage'))}, each with its value")
    return {"what_if": WhatIf(**altered), "stage": stage}


def _numbers(text: str, count: int, expected: str) -> tuple[float, ...]:
    try:
        numbers = tuple(float(word.rstrip("°")) for word in text.split())
    except ValueError:
        raise ValueError(expected) from None
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ValueError(expected)
    return numbers


def _degrees(text: str) -> float:
    (degrees,) = _numbers(text, 1, "an angle in degrees")
    return float(np.radians(degrees))


def _switch(text: str) -> bool:
    if text:
        raise ValueError("'counter' without a value")
    return True


def _share(text: str) -> float:
    (share,) = _numbers(text, 1, "a share from 0 to 1 after 'applied'")
    if not 0.0 <= share <= 1.0:
        raise ValueError("a share from 0 to 1 after 'applied'")
    return share


def _direction(text: str) -> tuple[float, ...]:
    x, y, z = _numbers(text, 3, "a direction x y z after 'toward'")
    length = float(np.linalg.norm((x, y, z)))
    if length < 1e-9:
        raise ValueError("a direction other than 0 0 0 after 'toward'")
    return (x / length, y / length, z / length)


_ALTERED: Mapping[str, Callable[[str], Any]] = {
    "twist": _degrees,
    "counter": _switch,
    "swing": _degrees,
    "bend": _degrees,
    "nudge": _degrees,
    "toward": _direction,
    "applied": _share,
}

_FIELDS: Mapping[str, Callable[[str], dict[str, Any]]] = {  # of a Place, by the key
    "frame": _frame,
    "chain": lambda name: {"chain": name},
    "camera": _camera,
    "show": lambda text: {"show": tuple(_symbol(s) for s in re.split(r"[,\s]+", text))},
    "lit": lambda text: {"lit": _symbol(text)},
    "what-if": _what_if,
    "tab": _tab,
    "look": _look,
}
KEYS = ("clip", *_FIELDS, "done")  # of the settings of a page
