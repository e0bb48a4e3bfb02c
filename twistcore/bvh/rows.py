"""Which lines make up which frame."""

from __future__ import annotations

import re
from collections import Counter

import numpy as np

from twistcore.bvh.numbers import Numbers
from twistcore.errors import BvhError

_LINE = re.compile(rb"\r\n|\r|\n")


def check_rows(name: str, data: bytes, start: int, numbers: Numbers, columns: int) -> None:
    """Raise BvhError where a frame does not begin a line; the last row may be incomplete.

    A frame may be wrapped over lines, but no line may hold parts of two: a number would be missing
    before, and everything behind it would move into the wrong channel.
    """
    total = len(numbers.values)
    heads = np.arange(columns, total, columns)
    at = np.searchsorted(numbers.lines, heads)
    fits = at < len(numbers.lines)
    fits[fits] = numbers.lines[at[fits]] == heads[fits]
    if total >= columns and fits.all():
        return
    # Only now are the lines looked at one by one.
    first = 1 + sum(1 for _ in _LINE.finditer(data, 0, start))
    counts = [(first + k, len(line.split())) for k, line in enumerate(_LINE.split(data[start:]))]
    counts = [(line, count) for line, count in counts if count]
    if not counts:
        line = first + 1
        raise BvhError(name, f"expected {columns} numbers a frame, found no row", line=line)
    line, count, expected = _wrong_line(counts, columns)
    raise BvhError(name, f"expected {expected} numbers in this row, found {count}", line=line)


def _wrong_line(counts: list[tuple[int, int]], columns: int) -> tuple[int, int, int]:
    """(line, its numbers, the numbers expected) of the row that is really short or long."""
    usual = Counter(count for _, count in counts).most_common(1)[0][0]
    if usual == columns or columns % usual or len(counts) == 1:
        wrong = next(((n, c) for n, c in counts if c != columns), counts[0])
        return (*wrong, columns)
    # Wrapped: the first frame shows how.
    pattern: list[int] = []
    for line, count in counts:
        if sum(pattern) + count > columns:
            return line, count, columns - sum(pattern)
        pattern.append(count)
        if sum(pattern) == columns:
            break
    for k, (line, count) in enumerate(counts):
        if count != pattern[k % len(pattern)]:
            return line, count, pattern[k % len(pattern)]
    return (*counts[-1], columns)
