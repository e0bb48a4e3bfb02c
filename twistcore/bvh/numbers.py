"""The numbers of the motion, read as integers and divided by a power of ten.

A decimal of up to 15 digits is an integer below 2⁵³ over a power of ten not above 10²², both exact,
so that their quotient is correctly rounded: the same bits as float(). Everything else goes there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.bvh.uniform_numbers import UniformReader
from twistcore.progress import Tell, nobody
from twistcore.rotation import Array

_BLOCK = 1 << 18  # bytes at a time: what stays in a core's own cache
_SAMPLE = 1 << 14  # bytes that tell how dense the numbers stand
_EXACT = 2**53
LARGEST = 1e100  # a length beyond has no square; sums and products of lower ones stay finite
_POWERS = 10.0 ** np.arange(23)
_NUMBER = re.compile(rb"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
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


def read_numbers(data: bytes, start: int, tell: Tell = nobody) -> Numbers:
    """The numbers of data[start:] between white space; raises BadNumberError for the first other.

    Read in blocks, so that little memory is needed beside the values; tell: after each.
    """
    read = _block_reader(data, start)
    buffer = np.frombuffer(data, dtype=np.uint8)
    spans = list(_spans(data, start, len(data)))
    values, lines, filled = np.empty(_guess(data, spans)), [], 0
    for a, b in spans:
        found = read(buffer[a:b]) or _exact(data, a, b)
        stop = filled + len(found.values)
        if stop > len(values):
            values = np.concatenate([values[:filled], np.empty(stop + stop // 8 - filled)])
        values[filled:stop] = found.values
        lines.append(found.lines + filled)
        filled = stop
        tell((b - start) / (len(data) - start))
    # The room guessed too much was never touched and so costs no memory.
    return Numbers(values[:filled], np.concatenate(lines) if lines else np.zeros(0, np.int64))


def _block_reader(data: bytes, start: int) -> Callable[[_Bytes], Numbers | None]:
    """Reads a block of data[start:]; None where something in it is no number."""
    decimals = _usual_decimals(data, start)
    uniform = UniformReader(decimals, _BLOCK + 64) if decimals else None

    def read(block: _Bytes) -> Numbers | None:
        if uniform is not None and (found := uniform(block)) is not None:
            return Numbers(found[0], _line_counts(block, found[1]))
        return _mixed(block)

    return read


def _usual_decimals(data: bytes, start: int) -> int:
    """Decimals that all tokens near the start have, or 0."""
    tokens = data[start : start + 4096].split()[:-1]
    decimals = {len(token) - 1 - token.rfind(b".") for token in tokens if b"." in token}
    one = decimals.pop() if len(decimals) == 1 else 0
    return one if 3 <= one <= 10 and all(b"." in token for token in tokens) else 0


def _spans(data: bytes, start: int, end: int) -> Iterator[tuple[int, int]]:
    """Blocks of data[start:end] that end in white space, the last one wherever the text ends."""
    while start < end:
        stop = min(start + _BLOCK, end)
        while stop < end and data[stop - 1] > 32:
            stop += 1
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


def _mixed(block: _Bytes) -> Numbers | None:
    """A block of numbers with any count of decimals; None where something is no number.

    The few with an exponent or too many digits are read by float().
    """
    x = np.full(len(block) + 2, 32, dtype=np.uint8)
    x[1:-1] = block
    blank = x <= 32
    end = np.zeros(len(x), dtype=np.bool_)
    np.greater(blank[1:], blank[:-1], out=end[1:])
    odd: dict[int, float] = {}
    exponents = np.flatnonzero((x | 32) == 101)
    ends = np.flatnonzero(end) if len(exponents) else exponents
    for k in np.unique(np.searchsorted(ends, exponents)).tolist():
        token = _token(x, ends, k)
        if not _NUMBER.fullmatch(token):
            return None
        odd[k] = float(token)
        x[ends[k] - len(token) : ends[k]] = 32
        x[ends[k] - 1] = 48  # stands for it among the others
    point, sign = x == 46, (x == 45) | (x == 43)
    digit = (x - np.uint8(48)) < 10
    # A sign stands before its number only, a point beside a digit.
    if (sign[1:] > blank[:-1]).any() or (sign[:-1] & ~(digit | point)[1:]).any():
        return None
    if (point[1:-1] & ~(digit[:-2] | digit[2:])).any():
        return None
    found = _decimals(point, end)
    if found is None:
        return None
    ends, decimals = found
    try:
        integers = np.fromstring(x.tobytes().translate(None, b"."), dtype=np.int64, sep=" ")
    except ValueError:
        return None
    if len(integers) != len(ends):  # numpy reads white space alone as a 0
        return None if len(ends) else Numbers(np.zeros(0), _line_counts(block, ends))
    values = integers / _POWERS.take(np.minimum(decimals, len(_POWERS) - 1))
    if not integers.all():  # the sign of a zero is lost in an integer
        signed = np.searchsorted(ends, np.flatnonzero(x == 45))
        values[signed[integers[signed] == 0]] = -0.0
    for k in np.flatnonzero((np.abs(integers) >= _EXACT) | (decimals >= len(_POWERS))).tolist():
        odd[k] = float(_token(x, ends, k))
    if odd:
        if not all(abs(value) < LARGEST for value in odd.values()):
            return None
        values[list(odd)] = list(odd.values())
    return Numbers(values, _line_counts(block, ends - 2))


def _token(x: _Bytes, ends: NDArray[np.intp], k: int) -> bytes:
    return x[ends[k - 1] if k else 0 : ends[k]].tobytes().split()[-1]


def _decimals(
    point: NDArray[np.bool_], end: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], NDArray[np.intp]] | None:
    """Ends of all tokens, and the bytes between point and end, 0 without; None at a second point.

    A token's point is whatever comes directly before its end among points and ends together.
    """
    events = np.flatnonzero(point | end)
    is_point = point.take(events)
    closing = np.flatnonzero(~is_point)
    ends = events.take(closing)
    before = np.maximum(closing - 1, 0)
    pointed = is_point.take(before)
    if len(closing) + np.count_nonzero(pointed) != len(events):
        return None
    return ends, (ends - events.take(before) - 1) * pointed


def _exact(data: bytes, start: int, stop: int) -> Numbers:
    """Every token by float(); says which is the first that is no number."""
    values, marks = [], []
    for found in _TOKEN.finditer(data, start, stop):
        token = found.group()
        value = float(token) if _NUMBER.fullmatch(token) else np.inf
        if not abs(value) < LARGEST:
            raise BadNumberError(found.start(), token)
        values.append(value)
        marks.append(found.start() - start)
    block = np.frombuffer(data, dtype=np.uint8)[start:stop]
    return Numbers(
        np.array(values, dtype=np.float64), _line_counts(block, np.array(marks, dtype=np.intp))
    )
