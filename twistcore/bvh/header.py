"""The HIERARCHY part of a BVH."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from twistcore.bvh.clip import JointChannels
from twistcore.errors import BvhError
from twistcore.motion import Skeleton

_AXES = {"x": 0, "y": 1, "z": 2}


@dataclass
class _Joint:
    name: str
    parent: int
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    channels: list[str] = field(default_factory=list)


class _Words:
    """The words of the header with their place, one line at a time."""

    def __init__(self, path: str, text: str) -> None:
        self.path = path
        self._lines = text.splitlines()
        self.line = 0
        self.column = 1
        self._rest = ""

    def fail(self, expected: str) -> BvhError:
        return BvhError(self.path, expected, line=max(self.line, 1), column=self.column)

    def _advance(self) -> bool:
        while not self._rest.strip():
            if self.line >= len(self._lines):
                return False
            self._rest = self._lines[self.line]
            self.line += 1
        return True

    def next(self) -> str | None:
        """The next word, or None at the end; braces are words of their own."""
        if not self._advance():
            return None
        stripped = self._rest.lstrip()
        self.column = len(self._lines[self.line - 1]) - len(stripped) + 1
        if stripped[0] in "{}":
            word = stripped[0]
        else:
            word = stripped.split(None, 1)[0]
        self._rest = stripped[len(word) :]
        return word

    def rest_of_line(self) -> str:
        """What is left of this line up to an opening brace: names may hold spaces."""
        name, brace, after = self._rest.partition("{")
        self._rest = brace + after
        return name.strip()

    def number(self, what: str) -> float:
        word = self.next()
        try:
            value = float(word or "")
        except ValueError:
            value = math.nan
        if word is None or not math.isfinite(value) or "_" in word:
            raise self.fail(
                f"expected a number for {what}, found {word or 'the end of the file'!r}"
            )
        return value


def parse_header(path: str, text: str) -> tuple[Skeleton, tuple[JointChannels, ...]]:
    """Skeleton and channel layout of the text before MOTION; raises BvhError."""
    words = _Words(path, text)
    word = words.next()
    if word is None or word.upper() != "HIERARCHY":
        raise words.fail(f"expected HIERARCHY, found {(word or 'the end of the file')[:40]!r}")
    joints: list[_Joint] = []
    ends: list[tuple[int, tuple[float, float, float]]] = []
    stack: list[int | None] = []  # None marks an End Site
    while (word := words.next()) is not None:
        key = word.upper()
        if key in ("ROOT", "JOINT"):
            name = words.rest_of_line()
            parent = stack[-1] if stack else -1
            if parent is None:
                raise words.fail("expected '}' before another joint: an End Site has no children")
            joints.append(_Joint(name, parent))
            stack.append(len(joints) - 1)
            _expect_brace(words, f"joint {name!r}")
        elif key == "END":
            words.rest_of_line()
            if not stack or stack[-1] is None:
                raise words.fail("expected a joint around an End Site")
            stack.append(None)
            _expect_brace(words, "End Site")
        elif key == "OFFSET":
            if not stack:
                raise words.fail("expected ROOT before OFFSET")
            offset = (words.number("OFFSET"), words.number("OFFSET"), words.number("OFFSET"))
            if stack[-1] is None:
                owner = stack[-2]
                assert owner is not None
                ends.append((owner, offset))
            else:
                joints[stack[-1]].offset = offset
        elif key == "CHANNELS":
            _read_channels(words, joints, stack)
        elif key == "}":
            if not stack:
                raise words.fail("expected ROOT or MOTION, found '}' without a matching '{'")
            stack.pop()
        else:
            raise words.fail(
                "expected ROOT, JOINT, End Site, OFFSET, CHANNELS, '}' or MOTION, "
                f"found {word[:40]!r}"
            )
    if stack:
        raise words.fail(f"expected {len(stack)} more '}}' before MOTION")
    if not joints:
        raise words.fail("expected at least one ROOT")
    return _assemble(joints, ends)


def _expect_brace(words: _Words, what: str) -> None:
    word = words.next()
    if word != "{":
        raise words.fail(f"expected '{{' after {what}, found {word or 'the end of the file'!r}")


def _read_channels(words: _Words, joints: list[_Joint], stack: list[int | None]) -> None:
    count = words.number("CHANNELS")
    if not stack or stack[-1] is None or count != int(count) or not 0 <= count <= 64:
        raise words.fail("expected CHANNELS with a count inside a joint")
    channels = joints[stack[-1]].channels
    for _ in range(int(count)):
        word = words.next() or "the end of the file"
        kind = word.lower()
        if kind[:1] not in _AXES or kind[1:] not in ("rotation", "position"):
            raise words.fail(
                f"expected a channel such as Xrotation or Yposition, found {word[:40]!r}"
            )
        channels.append(kind)


def _assemble(
    joints: list[_Joint], ends: list[tuple[int, tuple[float, float, float]]]
) -> tuple[Skeleton, tuple[JointChannels, ...]]:
    layouts = []
    column = 0
    for joint in joints:
        order, rotation, position = "", [], []
        for kind in joint.channels:
            if kind.endswith("rotation"):
                order += kind[0].upper()
                rotation.append(column)
            else:
                position.append((_AXES[kind[0]], column))
            column += 1
        layouts.append(JointChannels(order, tuple(rotation), tuple(position)))
    skeleton = Skeleton(
        names=_unique([j.name for j in joints]),
        parents=np.array([j.parent for j in joints], dtype=np.int64),
        offsets=np.array([j.offset for j in joints], dtype=np.float64),
        ends=tuple(ends),
        rotatable=np.array([layout.rotatable for layout in layouts]),
    )
    return skeleton, tuple(layouts)


def _unique(names: list[str]) -> tuple[str, ...]:
    """Names as written; the second of equals is shown as 'name #2'."""
    seen: dict[str, int] = {}
    out = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        out.append(name if seen[name] == 1 else f"{name} #{seen[name]}")
    return tuple(out)
