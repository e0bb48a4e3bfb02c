"""Read thousands of short numbers at a time with array operations.

For every byte of the text, the value of the next 1, 2 or 4 digits is computed. Each number is then
the sum of such values before and after its decimal point.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array

_PAD = 16
_WIDTHS = (4, 4, 2, 1)  # numbers of digits that are read together, after the decimal point
_POWERS = 10.0 ** np.arange(1 + sum(_WIDTHS))
_SIGNS = np.array([1.0, -1.0])
_Flags = NDArray[np.bool_]
_Indices = NDArray[np.intp]
_Groups = list[tuple[int, _Indices | slice]]


def parse_plain_numbers(block: NDArray[np.uint8]) -> tuple[Array, _Indices] | None:
    """Return the numbers in a block of text, and the offset of each number's end.

    A plain number has an optional minus sign, up to 4 digits, and 1 to 11 decimals after a point.
    It is computed as the quotient of an integer below 2⁵³ and a power of ten up to 10²². Both are
    exact, so the result is correctly rounded. If any number is not plain, the result is None.
    """
    x = np.full(len(block) + 2 * _PAD, 32, dtype=np.uint8)
    x[_PAD:-_PAD] = block
    one = x - 48
    digit, point, minus = one < 10, x == 46, x == 45
    # Tab, line feed, vertical tab, form feed, carriage return or space.
    blank = (x - 9 < 5) | (x == 32)
    if sum(int(np.count_nonzero(f)) for f in (blank, digit, point, minus)) != len(x):
        return None
    end = np.zeros(len(x), dtype=np.bool_)  # True for the blank directly after a number
    np.greater(blank[1:], blank[:-1], out=end[1:])
    if (minus[1:] > blank[:-1]).any() or (end[1:] > digit[:-1]).any():
        return None
    found = _uniform_points(point, end) or _points(point, end)
    if found is None:
        return None
    at, ends, groups = found
    pair = digit[1:] & digit[:-1]  # True if i and i + 1 are digits
    quad = pair[1:-2] & pair[3:]  # True if i + 1 to i + 4 are digits
    if (quad & digit[:-4]).take(at - 5).any():
        return None
    one *= digit
    # The entry at i is the value of up to two digits that end at i + 1, or of up to four that end
    # at i + 3. The latter need 16 bits, and numpy 1 would multiply in 8.
    two = one[:-1] * 10 * digit[1:] + one[1:]
    four = np.multiply(two[:-2], 100, dtype=np.uint16) * pair[2:] + two[2:]
    values = four.take(at - 4).astype(np.float64)
    for decimals, of in groups:
        part, next_at, left = values[of], at[of] + 1, decimals
        for width, pieces in zip(_WIDTHS, (four, four, two, one), strict=True):
            if left >= width:
                part *= _POWERS[width]
                part += pieces.take(next_at)
                next_at += width
                left -= width
        values[of] = part / _POWERS[decimals]
    # True at i if there is a minus sign at i + 4, or before up to four digits that end there.
    signed = minus[1:] | minus[:-1] & digit[1:]
    signed = signed[3:] | signed[1:-2] & pair[3:]
    signed |= minus[:-4] & quad
    values *= _SIGNS.take(signed.view(np.uint8).take(at - 5))
    return values, ends - _PAD - 1


def _uniform_points(point: _Flags, end: _Flags) -> tuple[_Indices, _Indices, _Groups] | None:
    """Compute the result of :func:`_points` three times as fast, for numbers of equal precision.

    If some numbers have more decimals than others, the result is None.
    """
    first = int(point.argmax())
    n = int(end[first:].argmax())
    if not 0 < n <= len(_POWERS) or (point[:-n] ^ end[n:]).any() or end[:n].any():
        return None
    at = np.flatnonzero(point)
    return at, at + n, [(n - 1, slice(None))]


def _points(point: _Flags, end: _Flags) -> tuple[_Indices, _Indices, _Groups] | None:
    """Return the offsets of each number's point and end, and the numbers grouped by decimal count.

    For a number without a point, both offsets are those of its end. If a number has two points or
    too many decimals, the result is None.
    """
    events = np.flatnonzero(point | end)
    is_point = point.take(events)
    closing = np.flatnonzero(~is_point)
    ends, before = events.take(closing), events.take(closing - 1)
    pointed = is_point.take(closing - 1)
    if len(closing) + np.count_nonzero(pointed) != len(events):
        return None
    at = np.where(pointed, before, ends)
    decimals = ends - at - pointed
    counts = np.bincount(decimals)
    if len(counts) > len(_POWERS):
        return None
    return at, ends, [(int(k), np.flatnonzero(decimals == k)) for k in np.flatnonzero(counts)]
