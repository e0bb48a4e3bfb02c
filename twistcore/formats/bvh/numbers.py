"""The numbers of the motion, block by block, to the bits of float().

Blocks of plain numbers are read by :mod:`plain_numbers <twistcore.formats.bvh.plain_numbers>`,
those with exponents, plus signs or many digits by numpy's own reader, and what neither can read
one by one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.bvh.plain_numbers import plain_numbers
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, nobody

_BLOCK = 1 << 18  # bytes at a time: what stays in a core's own cache
_SAMPLE = 1 << 14  # bytes that tell how dense the numbers stand
LARGEST = 1e100  # a length beyond has no square; sums and products of lower ones stay finite
_SPACES = bytes.maketrans(b"\t\n\v\f\r", b"     ")
# No digit can be taken in two ways: a long number that ends in a letter is refused at once.
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_BLANK = re.compile(rb"[\x00-\x20]")
_TOKEN = re.compile(rb"[^ \t\n\v\f\r]+")
_Bytes = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Numbers:
    """values: every number in reading order; lines: how many had been read at each line break."""

    values: Array
    lines: NDArray[np.int64]


class BadNumberError(ValueError):
    """A token that is no number below LARGEST: its offset in the text and the token."""

    def __init__(self, offset: int, token: bytes) -> None:
        super().__init__(offset, token)  # as given: an exception is pickled as its arguments
        self.offset, self.token = offset, token


def decimal_value(token: bytes) -> float:
    """A decimal number's value; NaN for what float() would also take: 1_000, inf, other digits."""
    return float(token) if _NUMBER.fullmatch(token) else np.nan


def read_numbers(data: bytes, start: int, tell: Tell | None = None) -> Numbers:
    """The numbers of data[start:] between white space; raises BadNumberError for the first other.

    Read in blocks, so that little memory is needed beside the values; tell: after each.
    """
    tell = tell or nobody
    buffer = np.frombuffer(data, dtype=np.uint8)
    # Memory of up to this size is kept by glibc once that much was freed: else every block would
    # need fresh pages, which cost a fifth of the time.
    np.empty(16 * _BLOCK, dtype=np.uint8)
    spans = list(_spans(data, start, len(data)))
    values, lines, filled = np.empty(_guess(data, spans)), [], 0
    for a, b in spans:
        found = _read_block(buffer[a:b]) or _exact(data, a, b)
        stop = filled + len(found.values)
        if stop > len(values):
            values = np.concatenate([values[:filled], np.empty(stop + stop // 8 - filled)])
        values[filled:stop] = found.values
        lines.append(found.lines + filled)
        filled = stop
        tell((b - start) / (len(data) - start))
    # The room guessed too much was never touched and so costs no memory.
    return Numbers(values[:filled], np.concatenate(lines) if lines else np.zeros(0, np.int64))


def _spans(data: bytes, start: int, end: int) -> Iterator[tuple[int, int]]:
    """Blocks of data[start:end] that end in white space, the last one wherever the text ends."""
    while start < end:
        found = _BLANK.search(data, start + _BLOCK - 1, end)
        stop = found.end() if found else end
        yield start, stop
        start = stop


def _guess(data: bytes, spans: list[tuple[int, int]]) -> int:
    """Somewhat more numbers than there will be, from the first block's density."""
    if not spans:
        return 0
    a, b = spans[0]
    b = min(b, a + _SAMPLE)
    density = (len(data[a:b].split()) + 16) / (b - a)
    return int(1.05 * density * (len(data) - a)) + 16


def _line_counts(block: _Bytes, marks: NDArray[np.intp]) -> NDArray[np.int64]:
    """How many of the ascending offsets lie before each line break."""
    broken = block == 10
    if (returns := block == 13).any():
        broken |= returns
    breaks = np.flatnonzero(broken)
    counts: NDArray[np.int64] = np.searchsorted(marks, breaks).astype(np.int64)
    return counts


def _read_block(block: _Bytes) -> Numbers | None:
    """The numbers of a block; None where something is no number."""
    if (plain := plain_numbers(block)) is not None:
        values, marks = plain
    else:
        text = block.tobytes().translate(_SPACES)
        if text.translate(None, b" 0123456789.+-eE"):
            return None
        blank = block <= 32
        marks = np.flatnonzero(blank[1:] > blank[:-1])
        try:  # as one line: it wants as many numbers in each
            values = np.loadtxt([text.decode()], comments=None, ndmin=1)
        except ValueError:
            return None
        if not (np.abs(values) < LARGEST).all():
            return None
    return Numbers(values, _line_counts(block, marks))


def _exact(data: bytes, start: int, stop: int) -> Numbers:
    """Every token by float(); says which is the first that is no number."""
    values, marks = [], []
    for found in _TOKEN.finditer(data, start, stop):
        token = found.group()
        value = decimal_value(token)
        if not abs(value) < LARGEST:
            raise BadNumberError(found.start(), token)
        values.append(value)
        marks.append(found.start() - start)
    block = np.frombuffer(data, dtype=np.uint8)[start:stop]
    return Numbers(
        np.array(values, dtype=np.float64), _line_counts(block, np.array(marks, dtype=np.intp))
    )
