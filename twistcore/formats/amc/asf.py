"""Read bones, their hierarchy and their axes from Acclaim's skeleton file (ASF).

The reader follows the Acclaim documentation of 1994 (":version 1.10"), as CMU's files do.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from twistcore.errors import AmcError
from twistcore.files.ordinary import read_file
from twistcore.files.wide_text import utf16_or_utf32_message
from twistcore.formats.bvh.channels import JointChannels
from twistcore.formats.bvh.header import quoted_word
from twistcore.formats.bvh.numbers import LARGEST, decimal_value
from twistcore.formats.clip import ClipWarning, shorten_warning_list
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, quaternion_from_euler

ROOT = "root"
_TURNS, _MOVES = ("rx", "ry", "rz"), ("tx", "ty", "tz")
_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
# Keywords that may occur in a bone's description.
_OF_BONE = frozenset(
    ("id", "name", "direction", "length", "axis", "dof", "limits", "bodymass", "cofmass")
)


@dataclass(frozen=True, eq=False)
class Asf:
    """The skeleton in an ASF file, and the layout of its numbers in an AMC file.

    Parameters
    ----------
    path
        The file.
    data
        The file's bytes.
    skeleton
        The skeleton, with a joint at the start of every bone, the root first.
    channels
        Columns of each joint's numbers in a frame. Acclaim's X Y Z are rotations about fixed axes,
        R = R_z · R_y · R_x, so axes and columns are listed in reverse.
    axes
        Rotation C from each bone's own axes to its joint's axes, shape (joints, 4). The local
        rotation is C · R · C⁻¹.
    start
        Offset added to the root's translation, shape (3,).
    radians
        True if angles are in radians, None if the file does not specify the unit.
    warnings
        Harmless assumptions made while reading.
    """

    path: Path
    data: bytes = field(repr=False)
    skeleton: Skeleton
    channels: tuple[JointChannels, ...]
    axes: Array
    start: Array
    radians: bool | None = None
    warnings: tuple[ClipWarning, ...] = ()


@dataclass(frozen=True)
class _Word:
    text: str
    line: int
    column: int


@dataclass
class _Bone:
    name: _Word
    direction: tuple[float, ...] = ()
    length: float | None = None
    axis: tuple[float, ...] = (0.0, 0.0, 0.0)
    order: str = "XYZ"
    dofs: tuple[str, ...] = ()

    @property
    def along(self) -> Array:
        """Return the vector from the bone's start to its end, (3,), in the file's unit."""
        assert self.length is not None
        direction = np.array(self.direction)
        size = float(np.linalg.norm(direction))
        along: Array = direction * (self.length / size) if size else np.zeros(3)
        return along


@dataclass
class _Read:
    """The data that has been read from a skeleton file so far."""

    path: str
    bones: dict[str, _Bone] = field(default_factory=dict)
    parents: dict[str, str] = field(default_factory=dict)
    start: tuple[float, ...] = (0.0, 0.0, 0.0)
    radians: bool | None = None
    warnings: list[ClipWarning] = field(default_factory=list)

    def fail(self, expected: str, word: _Word) -> AmcError:
        return AmcError(self.path, expected, line=word.line, column=word.column)

    def number(self, word: _Word, what: str) -> float:
        value = decimal_value(word.text.encode("utf-8", "surrogateescape"))
        if not abs(value) < LARGEST:
            raise self.fail(f"expected a number for {what}, found {quoted_word(word.text)}", word)
        return value

    def numbers(self, line: Sequence[_Word], count: int) -> tuple[float, ...]:
        """Return the `count` numbers after the first word of a line.

        Raises AmcError if the line has fewer numbers.
        """
        what = line[0].text
        if len(line) <= count:
            found = len(line) - 1
            raise self.fail(f"expected {count} numbers after {what!r}, found {found}", line[-1])
        return tuple(self.number(word, what) for word in line[1 : count + 1])


def read_asf(path: str | Path) -> Asf:
    """Read a skeleton file. Raises AmcError if the file is invalid."""
    path = Path(path)
    try:
        return parse_asf(read_file(path), path)
    except OSError as error:
        raise AmcError(str(path), f"cannot be read ({error.strerror})") from None


def parse_asf(data: bytes, path: str | Path = "skeleton.asf") -> Asf:
    """Parse the bytes of a skeleton file.

    Raises AmcError, with the position and the expected text, if they are invalid.
    """
    path = Path(path)
    if instead := utf16_or_utf32_message(data):
        raise AmcError(str(path), instead)
    read = _Read(str(path))
    sections = list(_sections(data, read))
    named = {head[0].text.lower(): (head, lines) for head, lines in sections}
    for needed in (":root", ":bonedata", ":hierarchy"):
        if needed not in named:
            raise AmcError(str(path), f"expected a section {needed} in the ASF, found none", line=1)
    if ":units" in named:
        _read_units(read, named[":units"][1])
    # The sections need not be in this order, but the unit is needed to read angles.
    _read_root(read, *named[":root"])
    _read_bones(read, *named[":bonedata"])
    _read_hierarchy(read, *named[":hierarchy"])
    return _assembled(read, path, data, named[":hierarchy"][0][0])


def _sections(data: bytes, read: _Read) -> Iterator[tuple[list[_Word], list[list[_Word]]]]:
    """Yield the line of each keyword and the lines below it. Each line is a list of words."""
    if not data or data.isspace():
        raise AmcError(read.path, "expected an ASF, but the file is empty", line=1, column=1)
    head: list[_Word] | None = None
    lines: list[list[_Word]] = []
    for count, raw in enumerate(data.removeprefix(b"\xef\xbb\xbf").splitlines(), 1):
        words = _words(raw, count)
        if not words:
            continue
        if words[0].text.startswith(":"):
            if head is not None:
                yield head, lines
            head, lines = words, []
        elif head is None:
            expected = "expected a keyword of an ASF such as ':version'"
            raise read.fail(f"{expected}, found {quoted_word(words[0].text)}", words[0])
        else:
            lines.append(words)
    if head is not None:
        yield head, lines


def _words(raw: bytes, line: int) -> list[_Word]:
    """Split a line into words with their positions, and ignore a comment, which begins with '#'."""
    text = raw.decode("utf-8", "surrogateescape")
    out, at = [], 0
    for word in text.split():
        if word.startswith("#"):
            break
        at = text.index(word, at)
        out.append(_Word(word, line, at + 1))
        at += len(word)
    return out


def _read_units(read: _Read, lines: list[list[_Word]]) -> None:
    for line in lines:
        if line[0].text.lower() == "angle" and len(line) > 1:
            read.radians = _is_radians(read, line[1])


def _is_radians(read: _Read, word: _Word) -> bool:
    said = word.text.lower()
    if not said.startswith(("deg", "rad")):
        raise read.fail(
            f"expected deg or rad as the unit of angles, found {quoted_word(said)}", word
        )
    return said.startswith("rad")


def _read_root(read: _Read, head: list[_Word], lines: list[list[_Word]]) -> None:
    bone = _Bone(_Word(ROOT, head[0].line, head[0].column), (0.0, 0.0, 0.0), 0.0)
    read.bones[ROOT] = bone
    for line in lines:
        key = line[0].text.lower()
        if key == "order":
            bone.dofs = _dofs(read, line, (*_TURNS, *_MOVES))
        elif key == "axis" and len(line) > 1:
            bone.order = _order(read, line[1])
        elif key == "position":
            read.start = read.numbers(line, 3)
        elif key == "orientation":
            bone.axis = read.numbers(line, 3)
    if not bone.dofs:
        raise read.fail("expected 'order' below :root, with the order of its numbers", head[0])
    if any(read.start):
        text = "The position of the root is not zero; it is added to the root's translation."
        read.warnings.append(ClipWarning(text))
    if any(bone.axis):
        text = "The orientation of the root is not zero; it is used as the root's axes."
        read.warnings.append(ClipWarning(text))


def _order(read: _Read, word: _Word) -> str:
    order = word.text.upper()
    if order not in _ORDERS:
        raise read.fail(
            f"expected an order of axes such as XYZ, found {quoted_word(word.text)}", word
        )
    return order


def _dofs(read: _Read, line: list[_Word], known: tuple[str, ...]) -> tuple[str, ...]:
    """Return the degrees of freedom listed after the first word of a line, in lower case.

    Raises AmcError if one is not in `known` or is repeated.
    """
    out: list[str] = []
    for word in line[1:]:
        dof = word.text.lower()
        if dof not in known or dof in out:
            wanted = "rx, ry or rz" if known == _TURNS else "TX, TY, TZ, RX, RY or RZ"
            raise read.fail(
                f"expected {wanted}, each at most once, found {quoted_word(word.text)}", word
            )
        out.append(dof)
    return tuple(out)


def _read_bones(read: _Read, head: list[_Word], lines: list[list[_Word]]) -> None:
    part: list[list[_Word]] | None = None
    for line in lines:
        key = line[0].text.lower()
        if key == "begin" and part is None:
            part = []
        elif key == "end" and part is not None:
            _read_bone(read, part, line[0])
            part = None
        elif part is not None and key != "begin":
            part.append(line)
        else:
            wanted = "'begin' of a bone" if part is None else "'end' of this bone"
            raise read.fail(f"expected {wanted}, found {quoted_word(line[0].text)}", line[0])
    if part is not None:
        raise read.fail("expected 'end' after the last bone of :bonedata", lines[-1][0])
    if len(read.bones) == 1:
        raise read.fail("expected at least one bone in :bonedata", head[0])


def _read_bone(read: _Read, lines: list[list[_Word]], end: _Word) -> None:
    by_key = {line[0].text.lower(): line for line in lines}
    for line in lines:
        key = line[0].text.lower()
        # Limits may continue on further lines.
        if key not in _OF_BONE and key[:1] not in "(-+.0123456789":
            text = f"The bone property {quoted_word(line[0].text)} is unknown and was ignored."
            read.warnings.append(ClipWarning(text, line[0].line))
    if len(named := by_key.get("name", [])) != 2:
        raise read.fail("expected 'name' and one word for this bone", (named or [end])[0])
    name = named[1]
    if name.text in read.bones:
        raise read.fail(
            (f"expected another name, because {quoted_word(name.text)} is already in use"), name
        )
    bone = read.bones[name.text] = _Bone(name)
    for key in ("direction", "length"):
        if key not in by_key:
            raise read.fail(f"expected {key!r} in the bone {quoted_word(name.text)}", end)
    bone.direction = read.numbers(by_key["direction"], 3)
    (bone.length,) = read.numbers(by_key["length"], 1)
    if bone.length and not any(bone.direction):
        raise read.fail("expected a direction that is not zero", by_key["direction"][0])
    if (axis := by_key.get("axis")) is not None:
        bone.axis = read.numbers(axis, 3)
        if len(axis) < 5:
            raise read.fail("expected an order of axes, such as XYZ, after 'axis'", axis[-1])
        bone.order = _order(read, axis[4])
    if (dofs := by_key.get("dof")) is not None:
        bone.dofs = _dofs(read, dofs, _TURNS)
    if bone.order != "XYZ" and any(bone.axis):
        text = (
            f"The axes of {quoted_word(name.text)} are rotated in the order {bone.order}, as "
            "written in the file."
        )
        read.warnings.append(ClipWarning(text, name.line))


def _read_hierarchy(read: _Read, head: list[_Word], lines: list[list[_Word]]) -> None:
    if [line[0].text.lower() for line in (lines[:1] + lines[1:][-1:])] != ["begin", "end"]:
        raise read.fail("expected 'begin' and 'end' around the hierarchy", head[0])
    for line in lines[1:-1]:
        for word in line:
            if word.text not in read.bones:
                raise read.fail(
                    f"expected the name of a bone in :bonedata, found {quoted_word(word.text)}",
                    word,
                )
        for word in line[1:]:
            if word.text in read.parents or word.text == ROOT:
                raise read.fail(
                    (f"expected only one parent for {quoted_word(word.text)}, found a second one"),
                    word,
                )
            read.parents[word.text] = line[0].text


def _assembled(read: _Read, path: Path, data: bytes, hierarchy: _Word) -> Asf:
    """Return the file's contents as an Asf, with the joints in depth-first order.

    Raises AmcError at the word `hierarchy` if a bone is not connected to the root.
    """
    children: dict[str, list[str]] = {}
    for name, parent in read.parents.items():
        children.setdefault(parent, []).append(name)
    names, waiting = [], [ROOT]
    while waiting:
        names.append(name := waiting.pop())
        waiting += reversed(children.get(name, []))
    there = set(names)
    if left := [name for name in read.bones if name not in there]:
        raise read.fail(
            (f"expected {quoted_word(left[0])} to be connected to the root in :hierarchy"),
            hierarchy,
        )
    bones = [read.bones[name] for name in names]
    at = {name: joint for joint, name in enumerate(names)}
    above = [at[read.parents[name]] if name != ROOT else -1 for name in names]
    layouts, column = [], 0
    for bone in bones:
        layouts.append(_channels(bone.dofs, column))
        column += len(bone.dofs)
    ends = ((j, bone.along.tolist()) for j, bone in enumerate(bones) if names[j] not in children)
    skeleton = Skeleton(
        names=tuple(names),
        parents=np.array(above, dtype=np.int64),
        offsets=np.array([bones[p].along if p >= 0 else read.start for p in above]),
        ends=tuple((joint, (x, y, z)) for joint, (x, y, z) in ends),
        rotatable=np.array([layout.rotatable for layout in layouts]),
    )
    radians = [b.axis if read.radians else tuple(np.radians(b.axis)) for b in bones]
    turned = zip(bones, radians, strict=True)
    axes = [quaternion_from_euler(b.order[::-1], angles[::-1]) for b, angles in turned]
    start, warnings = np.array(read.start), tuple(shorten_warning_list(read.warnings))
    rest = np.array(axes), start, read.radians, warnings
    return Asf(path, data, skeleton, tuple(layouts), *rest)


def _channels(dofs: tuple[str, ...], column: int) -> JointChannels:
    """Return the channels of a bone whose first number is in the given column."""
    turns = [(dof[1].upper(), column + k) for k, dof in enumerate(dofs) if dof in _TURNS][::-1]
    moves = tuple((_MOVES.index(dof), column + k) for k, dof in enumerate(dofs) if dof in _MOVES)
    return JointChannels("".join(a for a, _ in turns), tuple(c for _, c in turns), moves)
