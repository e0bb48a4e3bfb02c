"""Numbers of few digits, thousands at a time.

Every byte gets the number formed by the 1, 2 or 4 digits from there on; each number then picks the
pieces before and behind its point. No byte is looked at one by one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array

_PAD = 16
_WIDTHS = (4, 4, 2, 1)  # of the pieces that decimals are read in
_POWERS = 10.0 ** np.arange(1 + sum(_WIDTHS))
_SIGNS = np.array([1.0, -1.0])
_Flags = NDArray[np.bool_]
_Indices = NDArray[np.intp]
_Groups = list[tuple[int, _Indices | slice]]


def plain_numbers(block: NDArray[np.uint8]) -> tuple[Array, _Indices] | None:
    """The numbers of a block of text and where each ends; None if any is not plain.

    Plain is an optional minus, up to 4 digits and, behind a point, 1 to 11: an integer below 2⁵³
    over a power of ten not above 10²², both exact, so that their quotient is correctly rounded.
    """
    x = np.full(len(block) + 2 * _PAD, 32, dtype=np.uint8)
    x[_PAD:-_PAD] = block
    one = x - 48
    digit, point, minus = one < 10, x == 46, x == 45
    blank = (x - 9 < 5) | (x == 32)  # tab, line feed, vertical tab, form feed, carriage return
    if sum(int(np.count_nonzero(f)) for f in (blank, digit, point, minus)) != len(x):
        return None
    end = np.zeros(len(x), dtype=np.bool_)  # the blank directly behind a number
    np.greater(blank[1:], blank[:-1], out=end[1:])
    if (minus[1:] > blank[:-1]).any() or (end[1:] > digit[:-1]).any():
        return None
    found = _uniform_points(point, end) or _points(point, end)
    if found is None:
        return None
    at, ends, groups = found
    pair = digit[1:] & digit[:-1]  # digits at i and i + 1
    quad = pair[1:-2] & pair[3:]  # digits at i + 1 … i + 4
    if (quad & digit[:-4]).take(at - 5).any():
        return None
    one *= digit
    # At i: the up to two digits that end at i + 1, then the up to four that end at i + 3.
    two = one[:-1] * 10 * digit[1:] + one[1:]
    four = two[:-2] * np.uint16(100) * pair[2:] + two[2:]
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
    # At i: a sign at i + 4 or, before up to four digits that end there, at i + 3 … i.
    signed = minus[1:] | minus[:-1] & digit[1:]
    signed = signed[3:] | signed[1:-2] & pair[3:]
    signed |= minus[:-4] & quad
    values *= _SIGNS.take(signed.view(np.uint8).take(at - 5))
    return values, ends - _PAD - 1


def _uniform_points(point: _Flags, end: _Flags) -> tuple[_Indices, _Indices, _Groups] | None:
    """:func:`_points` in a third of the time where all have as many decimals; else None."""
    first = int(point.argmax())
    n = int(end[first:].argmax())
    if not 0 < n <= len(_POWERS) or (point[:-n] ^ end[n:]).any() or end[:n].any():
        return None
    at = np.flatnonzero(point)
    return at, at + n, [(n - 1, slice(None))]


def _points(point: _Flags, end: _Flags) -> tuple[_Indices, _Indices, _Groups] | None:
    """Of all numbers the point, or the end without one, and the end; which have how many decimals.

    None where a number has two points or too many decimals.
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
