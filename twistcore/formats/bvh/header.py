"""Parse the HIERARCHY section of a BVH file."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field

import numpy as np

from twistcore.errors import BvhError
from twistcore.formats.bvh.channels import JointChannels
from twistcore.formats.bvh.numbers import LARGEST, decimal_value
from twistcore.formats.clip import ClipWarning, shorten_warning_list
from twistcore.skeleton.motion import Skeleton

_AXES = {"x": 0, "y": 1, "z": 2}
# Real files have at most 9 per joint; a damaged number must not exhaust the memory.
_MOST_CHANNELS = 64


@dataclass
class _Joint:
    name: str
    parent: int
    line: int
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    channels: list[str] = field(default_factory=list)
    placed: bool = False


_WORD = re.compile(r"[{}]|[^\s{}]+", re.ASCII)
_REST = re.compile(r"[^{\r\n]*")
# The number of digits is limited, because words may have any length.
_DECIMAL_COMMA = re.compile(r"[+-]?[0-9]{0,20},[0-9]{1,20}(?:[eE][+-]?[0-9]{1,4})?")
_LINE_END = re.compile(r"\r\n|\r|\n")


class HeaderWords:
    """A reader for the words of the header.

    Line numbers are computed only when they are needed.
    """

    def __init__(self, path: str, text: str) -> None:
        self.path = path
        self._text = text
        self._at = self._end = 0
        self._counted, self._line = 0, 1  # an offset in the text and the number of its line

    @property
    def span(self) -> tuple[int, int]:
        """Start and end of the last word in the text, in characters."""
        return self._at, self._end

    def line(self) -> int:
        """Return the line number of the last word, counted from 1."""
        if self._at > self._counted:
            ends = _LINE_END.finditer(self._text, self._counted, self._at)
            self._counted, self._line = self._at, self._line + sum(1 for _ in ends)
        return self._line

    def fail(self, expected: str) -> BvhError:
        """Return an error at the last word. `expected` is the message."""
        line_start = max(self._text.rfind(end, 0, self._at) for end in "\r\n") + 1
        return BvhError(self.path, expected, line=self.line(), column=self._at - line_start + 1)

    def next(self) -> str | None:
        """Return the next word, with braces as separate words, or None at the end."""
        found = _WORD.search(self._text, self._end)
        if found is None:
            self._at = self._end = len(self._text.rstrip())
            return None
        self._at, self._end = found.span()
        return found.group()

    def rest_of_line(self) -> str:
        """Return the rest of the line up to an opening brace, because names may contain spaces."""
        found = _REST.match(self._text, self._end)
        assert found is not None
        self._end = found.end()
        return found.group().strip()

    def number(self, what: str) -> float:
        """Return the next word as a number. Raises BvhError if it is not a number.

        `what` names the number in the message.
        """
        word = self.next()
        value = decimal_value((word or "").encode("utf-8", "surrogateescape"))
        if not abs(value) < LARGEST:
            bound = "" if math.isnan(value) else f" below {LARGEST:g}"
            expected = f"expected a number{bound} for {what}, found {quoted_word(word)}"
            raise self.fail(bad_number_message(expected, word))
        return value


def quoted_word(word: str | None) -> str:
    """Return a word in quotes, escaped and shortened, for a message."""
    return "the end of the file" if word is None else ascii(word[:40])


def has_decimal_comma(word: str | None) -> bool:
    """Return True if a word is a number with a decimal comma."""
    return word is not None and _DECIMAL_COMMA.fullmatch(word) is not None


def bad_number_message(expected: str, word: str | None) -> str:
    """Return the message for a word that is not a number.

    The message is `expected`, unless the word has a decimal comma.
    """
    if has_decimal_comma(word):
        return (
            f"expected a decimal point, found a comma in {quoted_word(word)}: replace the commas "
            "in "
            "all numbers"
        )
    return expected


def parse_header(
    path: str, text: str, warnings: list[ClipWarning]
) -> tuple[Skeleton, tuple[JointChannels, ...]]:
    """Parse the text before MOTION into the skeleton and the channels of each joint.

    Assumptions are appended to `warnings`. Raises BvhError if the text is invalid.
    """
    words = HeaderWords(path, text)
    word = words.next()
    if word is None or word.upper() != "HIERARCHY":
        raise words.fail(f"expected HIERARCHY, found {quoted_word(word)}")
    joints: list[_Joint] = []
    ends: list[tuple[int, tuple[float, float, float]]] = []
    stack: list[int | None] = []  # joints that are open, None for an End Site
    while (word := words.next()) is not None:
        key = word.upper()
        if key in ("ROOT", "JOINT"):
            line, name = words.line(), words.rest_of_line()
            parent = stack[-1] if stack else -1
            if parent is None:
                raise words.fail("expected '}' before another joint: an End Site has no children")
            joints.append(_Joint(name, parent, line))
            stack.append(len(joints) - 1)
            _expect_brace(words, f"joint {quoted_word(name)}")
        elif key == "END":
            words.rest_of_line()
            if not stack or stack[-1] is None:
                raise words.fail("expected End Site only inside a joint")
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
                joint = joints[stack[-1]]
                if joint.placed:
                    text = f"{quoted_word(joint.name)} has a second OFFSET; the last one is used."
                    warnings.append(ClipWarning(text, words.line()))
                joint.offset, joint.placed = offset, True
        elif key == "CHANNELS":
            _read_channels(words, joints, stack, warnings)
        elif key == "}":
            if not stack:
                raise words.fail("expected ROOT or MOTION, found '}' without a matching '{'")
            _check_placed(joints, stack.pop(), warnings)
        else:
            raise words.fail(
                "expected ROOT, JOINT, End Site, OFFSET, CHANNELS, '}' or MOTION, "
                f"found {quoted_word(word)}"
            )
    if stack:
        raise words.fail(f"expected {len(stack)} more '}}' before MOTION")
    warnings[:] = shorten_warning_list(warnings)
    if not joints:
        raise words.fail("expected at least one ROOT")
    return _assemble(joints, ends, warnings)


def _check_placed(joints: list[_Joint], closed: int | None, warnings: list[ClipWarning]) -> None:
    """Add a warning if the joint whose block has just ended has no OFFSET.

    `closed` is the joint's index, or None for the block of an End Site.
    """
    if closed is None or joints[closed].placed:
        return
    joint = joints[closed]
    text = f"{quoted_word(joint.name)} has no OFFSET; it is placed at its parent (0 0 0)."
    warnings.append(ClipWarning(text, joint.line))


def _expect_brace(words: HeaderWords, what: str) -> None:
    word = words.next()
    if word != "{":
        raise words.fail(f"expected '{{' after {what}, found {quoted_word(word)}")


def _read_channels(
    words: HeaderWords, joints: list[_Joint], stack: list[int | None], warnings: list[ClipWarning]
) -> None:
    if not stack or stack[-1] is None:
        raise words.fail("expected CHANNELS only inside a joint")
    joint = joints[stack[-1]]
    if joint.channels:
        text = f"{quoted_word(joint.name)} has CHANNELS twice; both are read, one after the other."
        warnings.append(ClipWarning(text, words.line()))
    count = words.number("CHANNELS")
    if count != int(count) or not 0 <= count <= _MOST_CHANNELS:
        raise words.fail(f"expected a number of channels from 0 to {_MOST_CHANNELS}")
    for _ in range(int(count)):
        word = words.next()
        kind = (word or "").lower()
        if kind[:1] not in _AXES or kind[1:] not in ("rotation", "position"):
            raise words.fail(
                f"expected a channel such as Xrotation or Yposition, found {quoted_word(word)}"
            )
        joint.channels.append(kind)


def _assemble(
    joints: list[_Joint],
    ends: list[tuple[int, tuple[float, float, float]]],
    warnings: list[ClipWarning],
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
        names=_unique([j.name for j in joints], warnings),
        parents=np.array([j.parent for j in joints], dtype=np.int64),
        offsets=np.array([j.offset for j in joints], dtype=np.float64),
        ends=tuple(ends),
        rotatable=np.array([layout.rotatable for layout in layouts]),
    )
    return skeleton, tuple(layouts)


def _unique(names: list[str], warnings: list[ClipWarning]) -> tuple[str, ...]:
    """Return the names, with a repeated name changed to 'name #2' and so on."""
    seen: dict[str, int] = {}
    taken = set(names)
    out = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        number, shown_name = seen[name], name
        while number > 1 and (shown_name := f"{name} #{number}") in taken:
            number += 1
        seen[name] = number
        taken.add(shown_name)
        out.append(shown_name)
    repeated = [name for name, count in seen.items() if count > 1]
    if repeated:
        count = "1 name is used" if len(repeated) == 1 else f"{len(repeated)} names are used"
        text = f"{count} more than once, for example {quoted_word(repeated[0])}; "
        warnings.append(ClipWarning(text + "further joints with the same name are numbered."))
    return tuple(out)
