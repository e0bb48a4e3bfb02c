"""Read a BVH file as a clip."""

from __future__ import annotations

import codecs
import math
import re
from collections import Counter
from pathlib import Path

import numpy as np

from twistcore.errors import BvhError
from twistcore.files.kinds import BVH, wrong_file_kind_message
from twistcore.files.ordinary import read_file
from twistcore.files.wide_text import WideText, decode_utf16_or_utf32
from twistcore.formats.bvh.clip import BvhClip
from twistcore.formats.bvh.header import (
    bad_number_message,
    has_decimal_comma,
    parse_header,
    quoted_word,
)
from twistcore.formats.bvh.numbers import LARGEST, BadNumberError, Numbers, parse_motion_numbers
from twistcore.formats.clip import LONGEST, SHORTEST, ClipWarning, too_few_numbers_message
from twistcore.formats.suffixes import clip_suffix
from twistcore.work.progress import Tell

_MOTION = re.compile(rb"(?:^|(?<=[\r\n]))[ \t]*MOTION(?=[\s]|$)", re.I)
_FRAMES = re.compile(rb"\s*Frames[ \t]*:?\s*([^\s:]*)", re.I)
_FRAME_TIME = re.compile(
    rb"[^\r\n]*[\r\n]\s*Frame[ \t]*Time[ \t]*:?"
    # The number is on this line, or alone on the next line. If it is missing, the next line is a
    # row.
    rb"(?:[ \t]*(?=[^\s:])|\s*(?=[^\s:]+[ \t]*(?:[\r\n]|\Z))|[ \t]*)([^\s:]*)[^\r\n]*",
    re.I,
)
# A digit can match in only one way, so a long number that ends in a letter is rejected quickly.
_SECONDS = re.compile(rb"(?:[0-9]+(?:\.[0-9]+)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_LINE = re.compile(rb"\r\n|\r|\n")
_ASSUMED_FPS = 30.0


def read_bvh(path: str | Path, *, fps: float | None = None, tell: Tell | None = None) -> BvhClip:
    """Read a BVH file.

    Parameters
    ----------
    path : str or Path
        The file.
    fps : float, optional
        The frame rate, in frames per second, to use instead of the file's.
    tell : callable, optional
        Called repeatedly with the progress, 0…1.

    Returns
    -------
    BvhClip
        The clip, with its channels. Harmless assumptions are listed in its `warnings`.

    Raises
    ------
    BvhError
        If the file is invalid, cannot be read without a guess that would move a joint, or has the
        suffix of another format. This TwistError has the file, line, column and expected text.

    See Also
    --------
    read_clip : Read any format.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_bvh("assets/walk.bvh")
    >>> clip.channels[1].order
    'ZYX'
    """
    path = Path(path)
    if (suffix := clip_suffix(path)) not in ("", ".bvh"):
        raise BvhError(
            str(path), (f"expected a BVH file, the only format that works here, found {suffix}")
        )
    try:
        data = read_file(path)
    except FileNotFoundError:
        raise BvhError(str(path), "expected a BVH file, but the file does not exist") from None
    except IsADirectoryError:
        raise BvhError(str(path), "expected a BVH file, but this is a folder") from None
    except OSError as error:
        raise BvhError(str(path), f"cannot be read ({error.strerror})") from None
    return parse_bvh(data, path, fps=fps, tell=tell)


def parse_bvh(
    data: bytes,
    path: str | Path = "clip.bvh",
    *,
    fps: float | None = None,
    tell: Tell | None = None,
) -> BvhClip:
    """Parse the bytes of a BVH file. See :func:`read_bvh`."""
    path = Path(path)
    name = str(path)
    wide = _wide_text(name, data)
    text = data if wide is None else wide.text
    if not (bare := text.removeprefix(codecs.BOM_UTF8)) or bare.isspace():
        raise BvhError(name, "expected HIERARCHY, but the file is empty", line=1, column=1)
    if instead := wrong_file_kind_message(text, BVH):
        raise BvhError(name, instead)
    found = _MOTION.search(text)
    header = text[: found.start()] if found else text
    words = header.removeprefix(codecs.BOM_UTF8).decode("utf-8", errors="surrogateescape")
    warnings: list[ClipWarning] = []
    if wide is not None:
        warnings.append(
            ClipWarning(
                f"The text is {wide.name} and will be written in the same encoding; many "
                "programs read only UTF-8."
            )
        )
    of_header: list[ClipWarning] = []
    skeleton, channels = parse_header(name, words, of_header)
    if found is None:
        raise BvhError(name, "expected MOTION after the hierarchy", line=_line_of(text, len(text)))
    frames, seconds = _timing(name, text, found.end())
    declared = _declared_frames(name, text, frames)
    frame_time = _frame_time(text, seconds, fps, warnings)
    columns = sum(len(c.rotation) + len(c.position) for c in channels)
    if columns == 0:
        raise BvhError(name, "expected at least one channel in the hierarchy")
    start = seconds.end()
    try:
        numbers = parse_motion_numbers(text, start, tell)
    except BadNumberError as error:
        line, column = _place(text, error.offset)
        word = error.token.decode("utf-8", "replace")
        expected = f"expected a finite number (below {LARGEST:g}), found {quoted_word(word)}"
        raise BvhError(name, bad_number_message(expected, word), line=line, column=column) from None
    _check_rows(name, text, start, numbers, columns)
    rows = len(numbers.values) // columns
    if too_few := too_few_numbers_message(len(skeleton), rows, columns):
        raise BvhError(name, too_few)
    if rows != declared:
        said = _other_count(declared, rows)
        warnings.append(ClipWarning(said, _line_of(text, frames.start(1))))
    if left := len(numbers.values) - rows * columns:
        warnings.append(
            ClipWarning(
                f"The last row is incomplete ({left} of {columns} numbers) and was left out.",
                _line_of(text, len(text.rstrip())),
            )
        )
    return BvhClip(
        path=path,
        data=data,
        text=text,
        wide=wide,
        data_start=start,
        skeleton=skeleton,
        channels=channels,
        values=numbers.values[: rows * columns].reshape(rows, columns),
        frame_time=frame_time,
        # Warnings about the whole clip come first, because not all are shown.
        warnings=(*warnings, *of_header),
        declared_frames=declared,
    )


def bvh_timing_number_spans(data: bytes) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return the spans of the numbers after 'Frames:' and 'Frame Time:' in a valid BVH text.

    A span is a pair of byte offsets, (start, stop).
    """
    found = _MOTION.search(data)
    assert found is not None
    frames, seconds = _timing("", data, found.end())
    return frames.span(1), seconds.span(1)


def _wide_text(name: str, data: bytes) -> WideText | None:
    try:
        return decode_utf16_or_utf32(data)
    except UnicodeDecodeError as error:
        expected = f"expected UTF-32 text, found no character at byte {error.start}"
        raise BvhError(name, expected) from None


def _timing(name: str, data: bytes, start: int) -> tuple[re.Match[bytes], re.Match[bytes]]:
    frames = _FRAMES.match(data, start)
    seconds = _FRAME_TIME.match(data, frames.end()) if frames else None
    if frames is None or seconds is None:
        after = start if frames is None else (_LINE.search(data, frames.end()) or frames).end()
        solid = re.compile(rb"\S").search(data, after)
        line, column = _place(data, solid.start() if solid else len(data))
        wanted = "'Frames:'" if frames is None else "'Frame Time:'"
        expected = f"expected {wanted} after MOTION"
        raise BvhError(name, expected, line=line, column=column)
    return frames, seconds


def _line_of(data: bytes, offset: int) -> int:
    """Return the line number of a byte offset, from 1. CR, LF and CRLF end a line."""
    return len((data[:offset] + b"x").splitlines())


def _place(data: bytes, offset: int) -> tuple[int, int]:
    line_start = max(data.rfind(b"\n", 0, offset), data.rfind(b"\r", 0, offset)) + 1
    return _line_of(data, offset), offset - line_start + 1


def _declared_frames(name: str, data: bytes, frames: re.Match[bytes]) -> int:
    written = frames.group(1)
    if not written.isdigit() or len(written) > 18:
        line, column = _place(data, frames.start(1))
        raise BvhError(name, "expected a whole number after 'Frames:'", line=line, column=column)
    return int(written)


def _other_count(declared: int, rows: int) -> str:
    """Return a warning that the frame count in the header differs from the number of rows."""
    if rows > declared:
        return f"The header declares {declared} frames, but {rows} complete rows were read."
    missing = declared - rows
    return (
        f"The header declares {declared} frames, but {rows} complete rows were read: {missing}"
        " are missing."
    )


def _frame_time(
    data: bytes, found: re.Match[bytes], fps: float | None, warnings: list[ClipWarning]
) -> float:
    if fps is not None:
        return 1.0 / fps
    written = found.group(1)
    word = written.decode("ascii", "replace")
    line = _line_of(data, found.start(1))
    if has_decimal_comma(word):
        written = written.replace(b",", b".")
        text = f"Frame Time {quoted_word(word)} has a decimal comma, which is read as a point."
        warnings.append(ClipWarning(text, line))
    seconds = float(written) if _SECONDS.fullmatch(written) else math.nan
    if SHORTEST <= seconds <= LONGEST:
        return seconds
    text = (
        f"Frame Time {quoted_word(word)} is not usable; {_ASSUMED_FPS:g} frames per second are "
        "assumed."
    )
    if LONGEST < seconds <= 1.0 / SHORTEST:
        rate = _meant_rate(seconds)
        text = (
            f"Frame Time {quoted_word(word)} is {seconds:g} seconds per frame, but 1/{rate:.5g} = "
            f"{1.0 / rate:.3g} was probably meant. For that rate, use "
            f"--fps {rate:.5g} on the command line; without it, {_ASSUMED_FPS:g} frames per second "
            "are assumed."
        )
    warnings.append(ClipWarning(text, line))
    return 1.0 / _ASSUMED_FPS


def _meant_rate(written: float) -> float:
    """Return the frame rate that was probably meant by a Frame Time above one second.

    A whole number or a television rate, such as 29.97, is read as frames per second. Any other
    number is read as milliseconds per frame.
    """
    whole = any(abs(rate - round(rate)) < 0.005 for rate in (written, 1.001 * written))
    return written if whole else 1000.0 / written


# -- rows and lines --------------------------------------------------------------------------------


def _check_rows(name: str, data: bytes, start: int, numbers: Numbers, columns: int) -> None:
    """Raise BvhError unless each frame begins on a new line. The last row may be incomplete.

    A frame may continue on several lines, but no line may contain parts of two frames. If a line
    does, a number is missing before it, and all later numbers are in the wrong channels.
    """
    total = len(numbers.values)
    heads = np.arange(columns, total, columns)
    at = np.searchsorted(numbers.lines, heads)
    fits = at < len(numbers.lines)
    fits[fits] = numbers.lines[at[fits]] == heads[fits]
    if total >= columns and fits.all():
        return
    # This quick check failed, so examine the lines one by one.
    first = 1 + sum(1 for _ in _LINE.finditer(data, 0, start))
    counts = [(first + k, len(line.split())) for k, line in enumerate(_LINE.split(data[start:]))]
    counts = [(line, count) for line, count in counts if count]
    if not counts:
        line = first + 1
        raise BvhError(name, f"expected {columns} numbers per frame, found no rows", line=line)
    line, count, expected = _wrong_line(counts, columns)
    raise BvhError(name, f"expected {expected} numbers in this row, found {count}", line=line)


def _wrong_line(counts: list[tuple[int, int]], columns: int) -> tuple[int, int, int]:
    """Return the first line that has too few or too many motion values.

    The result has the line number, the actual number of values and the expected number. `counts`
    has the line number and the actual number of values of every line.
    """
    usual = Counter(count for _, count in counts).most_common(1)[0][0]
    if usual == columns or columns % usual or len(counts) == 1:
        wrong = next(((n, c) for n, c in counts if c != columns), counts[0])
        return (*wrong, columns)
    # Frames continue on several lines. The lines of the first frame are the pattern.
    pattern: list[int] = []
    left = columns
    for line, count in counts:
        if count > left:
            return line, count, left
        pattern.append(count)
        left -= count
        if not left:
            break
    for k, (line, count) in enumerate(counts):
        if count != pattern[k % len(pattern)]:
            return line, count, pattern[k % len(pattern)]
    return (*counts[-1], columns)
