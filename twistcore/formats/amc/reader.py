"""Read an AMC file, together with the ASF file in the same folder, as a clip."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import AmcError
from twistcore.files.kinds import AMC, wrong_file_kind_message
from twistcore.files.ordinary import read_file
from twistcore.files.wide_text import utf16_or_utf32_message
from twistcore.formats.amc.asf import Asf, read_asf
from twistcore.formats.amc.clip import AmcClip
from twistcore.formats.bvh.header import quoted_word
from twistcore.formats.bvh.numbers import (
    LARGEST,
    BadNumberError,
    decimal_value,
    parse_motion_numbers,
)
from twistcore.formats.clip import (
    LONGEST,
    SHORTEST,
    ClipWarning,
    shorten_warning_list,
    too_few_numbers_message,
)
from twistcore.skeleton.rotation import Array
from twistcore.work.progress import Tell, ignore_progress

_ASSUMED_FPS = 120.0
_REPORTED = 64  # number of frames between two progress reports
_ASSUMED = (
    "An AMC has no frame rate: 120 frames per second are assumed, as in most CMU trials; "
    "some have 60 (set the rate with --fps on the command line)."
)
_SOLID = re.compile(rb"[^\x00-\x20]+")  # a token, as in token_spans
_CONTROL = bytes(set(range(32)) - set(b"\t\n\v\f\r"))


def read_amc(path: str | Path, *, fps: float | None = None, tell: Tell | None = None) -> AmcClip:
    """Read an AMC file and its skeleton file.

    The skeleton file has the clip's name, or the part of it before an underscore (05.asf for CMU's
    05_02.amc). If there is no such file, the only ASF file in the folder is used.

    Parameters
    ----------
    path
        The file.
    fps
        Frames per second. By default, the file's rate or 120.
    tell
        Called with the progress, 0…1.

    Raises
    ------
    AmcError
        If a file is invalid. The error has the file, line, column and expected text. Harmless
        assumptions are listed in `Clip.warnings` instead.
    """
    path = Path(path)
    try:
        data = read_file(path)
        if instead := wrong_file_kind_message(data, AMC):
            raise AmcError(str(path), instead)
        asf = find_asf(path)
    except FileNotFoundError:
        raise AmcError(str(path), "expected an AMC file, but the file does not exist") from None
    except IsADirectoryError:
        raise AmcError(str(path), "expected an AMC file, but this is a folder") from None
    except OSError as error:
        raise AmcError(str(path), f"cannot be read ({error.strerror})") from None
    return parse_amc(data, read_asf(asf), path, fps=fps, tell=tell)


def find_asf(path: Path) -> Path:
    """Return the path of an AMC file's skeleton file.

    Raises AmcError if the skeleton file is missing or ambiguous.
    """
    candidates = sorted(p for p in path.parent.iterdir() if p.suffix.lower() == ".asf")
    words = path.stem.lower().split("_")
    for count in range(len(words), 0, -1):
        name = "_".join(words[:count])
        for asf in candidates:
            if asf.stem.lower() == name:
                return asf
    if len(candidates) != 1:
        found = f"{len(candidates)} others" if candidates else "none"
        raise AmcError(
            str(path),
            f"expected the clip's skeleton {path.stem}.asf in the same folder, found {found}",
        )
    return candidates[0]


def parse_amc(
    data: bytes,
    asf: Asf,
    path: str | Path = "clip.amc",
    *,
    fps: float | None = None,
    tell: Tell | None = None,
) -> AmcClip:
    """Parse the bytes of an AMC file, given its skeleton. See :func:`read_amc`."""
    path = Path(path)
    if not data or data.isspace():
        raise AmcError(str(path), "expected an AMC, but the file is empty", line=1, column=1)
    if instead := utf16_or_utf32_message(data):
        raise AmcError(str(path), instead)
    rows = _Rows(str(path), data, asf)
    values, places = rows.read(tell or ignore_progress)
    if expected := too_few_numbers_message(len(asf.skeleton), *values.shape):
        raise AmcError(str(path), expected)
    radians = rows.radians if rows.radians is not None else asf.radians
    if radians is None:
        rows.warnings.append(
            ClipWarning("The file does not specify the unit of angles; degrees are assumed.")
        )
    if radians:
        turns = [column for layout in asf.channels for column in layout.rotation]
        values[:, turns] = np.degrees(values[:, turns])
    if fps is None and rows.fps is None:
        rows.warnings.append(ClipWarning(_ASSUMED))
    return AmcClip(
        path=path,
        data=data,
        skeleton=asf.skeleton,
        frame_time=1.0 / (fps or rows.fps or _ASSUMED_FPS),
        warnings=(
            *(_skeleton_warning(asf, w) for w in asf.warnings),
            *shorten_warning_list(rows.warnings),
        ),
        asf=asf,
        values=values,
        places=places,
        radians=bool(radians),
    )


def _skeleton_warning(asf: Asf, warning: ClipWarning) -> ClipWarning:
    """Return the warning, prefixed with the skeleton file's name and the line number."""
    line = "" if warning.line is None else f", line {warning.line}"
    return ClipWarning(f"{asf.path.name}{line}: {warning.text}")


class _Rows:
    """A parser for the frames of an AMC file.

    A frame consists of its number and, in any order, the bones with their numbers.
    """

    def __init__(self, path: str, data: bytes, asf: Asf) -> None:
        self.warnings: list[ClipWarning] = []
        self.fps: float | None = None
        self.radians: bool | None = None
        self._path, self._data, self._asf = path, data, asf
        counts = [len(c.rotation) + len(c.position) for c in asf.channels]
        names = [name.encode("utf-8", "surrogateescape") for name in asf.skeleton.names]
        moving = [(name, count) for name, count in zip(names, counts, strict=True) if count]
        self._bones = {name: (k, count) for k, (name, count) in enumerate(moving)}
        self._number: int | None = None  # number of the current frame
        self._in_order = True
        # Words of each bone in the current frame, empty until read.
        self._frame: list[list[bytes]] = []
        self._first: list[int] = []  # token index of each bone's first number

    def fail(self, expected: str, line: int, word: int = 0) -> AmcError:
        """Return an error with the position of a word. `expected` is its message.

        Lines are counted from 1, words from 0.
        """
        raw = self._data.splitlines()[line - 1]
        starts = [found.start() for found in _SOLID.finditer(raw)] or [0]
        column = starts[word] + 1 if word < len(starts) else len(raw.rstrip()) + 1
        return AmcError(self._path, expected, line=line, column=column)

    def read(self, tell: Tell) -> tuple[Array, NDArray[np.int64]]:
        """Return the numbers in joint order, (frames, columns), and their token indices."""
        # bytes.split treats some control characters as part of a word, unlike token_spans.
        odd = len(self._data) != len(self._data.translate(None, _CONTROL))
        split: Callable[[bytes], list[bytes]] = _SOLID.findall if odd else bytes.split
        words: list[bytes] = []
        places: list[int] = []
        lines = self._data.splitlines()
        token, line = 0, 0
        for line, raw in enumerate(lines, 1):
            own = split(raw)
            cut = len(own)
            if b"#" in raw:
                cut = next((k for k, word in enumerate(own) if word.startswith(b"#")), cut)
            if cut and own[0] in self._bones and self._number is not None:
                self._read_bone(own[:cut], token, line)
            elif cut == 1 and own[0].isdigit() and len(own[0]) < 18:
                self._begin_frame(int(own[0]), line, words, places)
                if not int(own[0]) % _REPORTED:
                    tell(line / len(lines))
            elif cut:
                self._read_keyword(own[:cut], line)
            token += len(own)
        if self._number is None:
            raise self.fail("expected the number of the first frame, found none", max(line, 1))
        self._store_last(words, places)
        if not places:
            raise self.fail("expected at least one complete frame, found none", max(line, 1))
        frames = len(places) // len(self._bones)
        counts = np.array([count for _, count in self._bones.values()])
        firsts = np.array(places, dtype=np.int64).reshape(frames, -1)
        within = np.concatenate([np.arange(count) for count in counts])
        which = np.repeat(firsts, counts, axis=1) + within
        return self._values(words, which).reshape(frames, -1), which

    def _begin_frame(self, number_: int, line: int, words: list[bytes], places: list[int]) -> None:
        """Store the previous frame, if there is one, and begin a new one."""
        if self._number is not None:
            missing = [name for name, (k, _) in self._bones.items() if not self._frame[k]]
            if missing:
                bone = quoted_word(missing[0].decode("utf-8", "replace"))
                raise self.fail(f"expected a line for {bone} in frame {self._number}", line)
            self._store(words, places)
            text = (
                f"Frame {number_} comes after frame {self._number}; the frames are read in "
                "the order of the file."
            )
            if number_ != self._number + 1 and self._in_order:
                self._in_order = False
                self.warnings.append(ClipWarning(text, line))
        self._number = number_
        self._frame = [[] for _ in self._bones]
        self._first = [0] * len(self._bones)

    def _store(self, words: list[bytes], places: list[int]) -> None:
        for own in self._frame:
            words += own
        places += self._first

    def _store_last(self, words: list[bytes], places: list[int]) -> None:
        """Store the last frame if it is complete. If not, add a warning."""
        if all(self._frame):
            self._store(words, places)
            return
        there = sum(bool(own) for own in self._frame)
        text = (
            f"The last frame is incomplete ({there} of {len(self._bones)} bones) and was left out."
        )
        self.warnings.append(ClipWarning(text, len(self._data.splitlines())))

    def _read_bone(self, own: list[bytes], token: int, line: int) -> None:
        place, count = self._bones[own[0]]
        if len(own) != count + 1 or self._frame[place]:
            raise self._bone_error(own, line)
        self._frame[place] = own[1:]
        self._first[place] = token + 1

    def _bone_error(self, own: list[bytes], line: int) -> AmcError:
        _, count = self._bones[own[0]]
        bone = quoted_word(own[0].decode("utf-8", "replace"))
        if len(own) != count + 1:
            numbers = "1 number" if count == 1 else f"{count} numbers"
            expected = f"expected {numbers} for {bone}, found {len(own) - 1}"
            return self.fail(expected, line, min(len(own), count + 1))
        return self.fail(f"expected only one line for {bone} in frame {self._number}", line)

    def _read_keyword(self, own: list[bytes], line: int) -> None:
        """Read a line of keywords in the header. `own` are the words of the line.

        Raises AmcError for any other line.
        """
        if not own[0].startswith(b":") or self._number is not None:
            known = f"a bone of {self._asf.path.name} with degrees of freedom, or a frame number"
            wanted = "the number of the first frame" if self._number is None else known
            found = quoted_word(own[0].decode("utf-8", "replace"))
            raise self.fail(f"expected {wanted}, found {found}", line)
        words = iter(enumerate(own))
        for place, word in words:
            key = word.upper()
            if key in (b":DEGREES", b":RADIANS"):
                self.radians = key == b":RADIANS"
            elif key == b":SAMPLES-PER-SECOND":
                _, rate = next(words, (0, b""))
                fps = decimal_value(rate)
                if not 1.0 / LONGEST <= fps <= 1.0 / SHORTEST:
                    raise self.fail("expected frames per second, such as 120", line, place + 1)
                self.fps = fps
            elif key != b":FULLY-SPECIFIED":
                text = f"{quoted_word(word.decode('utf-8', 'replace'))} is unknown and was ignored."
                self.warnings.append(ClipWarning(text, line))

    def _values(self, words: list[bytes], which: NDArray[np.int64]) -> Array:
        try:
            return parse_motion_numbers(b" ".join(words), 0).values
        except BadNumberError as error:
            at = int(which.ravel()[b" ".join(words)[: error.offset].count(b" ")])
            offset = [found.start() for found in _SOLID.finditer(self._data)][at]
            before = (self._data[:offset] + b"x").splitlines()
            found = quoted_word(error.token.decode("utf-8", "replace"))
            expected = f"expected a finite number (below {LARGEST:g}), found {found}"
            place = len(before), len(before[-1])
            raise AmcError(self._path, expected, line=place[0], column=place[1]) from None
