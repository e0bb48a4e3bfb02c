"""Read motion numbers in blocks, with exactly the same values as float().

Blocks of plain numbers are read by :mod:`plain_numbers <twistcore.formats.bvh.plain_numbers>`.
Blocks with exponents, plus signs or many digits are read by numpy. All other blocks are read one
number at a time.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from twistcore.formats.bvh.plain_numbers import parse_plain_numbers
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress

_BLOCK = 1 << 18  # number of bytes read in one step; they fit into the processor's cache
_SAMPLE = 1 << 14  # number of bytes by which the density of numbers is estimated
LARGEST = 1e100  # sums and products of smaller numbers stay finite
_SPACES = bytes.maketrans(b"\t\n\v\f\r", b"     ")
# A digit can match in only one way, so a long number that ends in a letter is rejected quickly.
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_BLANK = re.compile(rb"[\x00-\x20]")
_TOKEN = re.compile(rb"[^ \t\n\v\f\r]+")
_Bytes = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Numbers:
    """Numbers that were read from a text.

    Attributes
    ----------
    values
        The numbers, in reading order.
    lines
        Number of values before each line break.
    """

    values: Array
    lines: NDArray[np.int64]


class BadNumberError(ValueError):
    """Raised if a token in the text is not a number below LARGEST.

    Attributes
    ----------
    offset
        Offset of the token in the text, in bytes.
    token
        The token.
    """

    def __init__(self, offset: int, token: bytes) -> None:
        super().__init__(offset, token)  # pickling keeps only these arguments
        self.offset, self.token = offset, token


def decimal_value(token: bytes) -> float:
    """Return the value of a decimal number, or NaN for any other text.

    Forms that only float() accepts, such as 1_000, also give NaN.
    """
    return float(token) if _NUMBER.fullmatch(token) else np.nan


def parse_motion_numbers(data: bytes, start: int, tell: Tell | None = None) -> Numbers:
    """Read the numbers in data[start:], which are separated by white space.

    The text is read in blocks, so that little memory is needed apart from the values. `tell` is
    called with the progress, 0…1, after each block. Raises BadNumberError if a token is not a
    number.
    """
    tell = tell or ignore_progress
    buffer = np.frombuffer(data, dtype=np.uint8)
    # After a large array was freed, glibc reuses memory for arrays up to its size. Without this,
    # every block would need new pages, which takes a fifth of the time.
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
    # The unused end of the array was never written, so it takes no memory.
    return Numbers(values[:filled], np.concatenate(lines) if lines else np.zeros(0, np.int64))


def _spans(data: bytes, start: int, end: int) -> Iterator[tuple[int, int]]:
    """Yield the spans of blocks in data[start:end]. A block ends after white space or at `end`."""
    while start < end:
        found = _BLANK.search(data, start + _BLOCK - 1, end)
        stop = found.end() if found else end
        yield start, stop
        start = stop


def _guess(data: bytes, spans: list[tuple[int, int]]) -> int:
    """Return a slightly high estimate of the number of values.

    The estimate uses the density of numbers at the beginning of the first block.
    """
    if not spans:
        return 0
    a, b = spans[0]
    b = min(b, a + _SAMPLE)
    density = (len(data[a:b].split()) + 16) / (b - a)
    return int(1.05 * density * (len(data) - a)) + 16


def _line_counts(block: _Bytes, marks: NDArray[np.intp]) -> NDArray[np.int64]:
    """Return how many of the ascending offsets `marks` come before each line break."""
    broken = block == 10
    if (returns := block == 13).any():
        broken |= returns
    breaks = np.flatnonzero(broken)
    counts: NDArray[np.int64] = np.searchsorted(marks, breaks).astype(np.int64)
    return counts


def _read_block(block: _Bytes) -> Numbers | None:
    """Return the numbers of a block, or None if numpy cannot read a token as a number."""
    if (plain := parse_plain_numbers(block)) is not None:
        values, marks = plain
    else:
        text = block.tobytes().translate(_SPACES)
        if text.translate(None, b" 0123456789.+-eE"):
            return None
        blank = block <= 32
        marks = np.flatnonzero(blank[1:] > blank[:-1])
        try:  # loadtxt needs equal numbers of columns in all lines, so the text is one line
            values = np.loadtxt([text.decode()], comments=None, ndmin=1)
        except ValueError:
            return None
        if not (np.abs(values) < LARGEST).all():
            return None
    return Numbers(values, _line_counts(block, marks))


def _exact(data: bytes, start: int, stop: int) -> Numbers:
    """Read each token with float(). Raises BadNumberError if a token is not a number."""
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
