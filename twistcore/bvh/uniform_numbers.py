"""Numbers that all have the same count of decimals, thousands at a time.

Every byte gets the number formed by the 1, 2 or 4 digits that end there; each decimal point then
picks the pieces before and behind it. No byte is looked at one by one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.rotation import Array

PAD = 16
_POWERS = 10.0 ** np.arange(16)
_SIGNS = np.array([1.0, -1.0])
_Flags = NDArray[np.bool_]


class UniformReader:
    """Reads blocks of up to `size` bytes in memory of its own: fresh pages would cost the most.

    One reader serves one thread. decimals: 3 to 10 (with fewer, two signs would stand too near).
    """

    def __init__(self, decimals: int, size: int) -> None:
        self.decimals = decimals
        size += 2 * PAD
        self._bytes = [np.empty(size, dtype=np.uint8) for _ in range(3)]
        self._flags = [np.empty(size, dtype=np.bool_) for _ in range(7)]
        self._quad = np.empty(size, dtype=np.uint16)

    def __call__(self, block: NDArray[np.uint8]) -> tuple[Array, NDArray[np.intp]] | None:
        """The numbers of a block and where their points stand; None if any is not plain."""
        size = len(block) + 2 * PAD
        if size > len(self._quad):
            return None
        x, one, two = (b[:size] for b in self._bytes)
        blank, point, minus, digit, pair, free, spare = (f[:size] for f in self._flags)
        x[:PAD] = x[-PAD:] = 32
        x[PAD:-PAD] = block
        np.subtract(x, 9, out=one)
        np.less(one, 5, out=blank)  # tab, line feed, vertical tab, form feed, carriage return
        np.logical_or(blank, np.equal(x, 32, out=free), out=blank)
        np.equal(x, 46, out=point)
        np.equal(x, 45, out=minus)
        np.subtract(x, 48, out=one)
        np.less(one, 10, out=digit)
        at = np.flatnonzero(point)
        known = sum(int(np.count_nonzero(f)) for f in (blank, digit, minus)) + len(at)
        np.logical_and(digit[1:], digit[:-1], out=pair[:-1])  # digits at i and i + 1
        if (
            known != size
            or not self._ends_fit(blank, point, free)
            or np.greater(minus[1:], blank[:-1], out=free[1:])[1:].any()
            or not self._digits_follow(pair, point, free, spare)
            or _five_before(digit, pair, point, free)
        ):
            return None
        np.multiply(one, digit.view(np.uint8), out=one)
        # At i: the up to two digits that end at i + 1, then the up to four that end at i + 3.
        np.multiply(one, 10, out=two)
        np.multiply(two[:-1], digit[1:].view(np.uint8), out=two[:-1])
        np.add(two[:-1], one[1:], out=two[:-1])
        quad = self._quad[: size - 2]
        np.multiply(two[:-2], np.uint16(100), out=quad)
        np.multiply(quad, pair[2:].view(np.uint8), out=quad)
        np.add(quad, two[2:], out=quad)
        values = quad.take(at - 4).astype(np.float64)
        for width, offset in _pieces(self.decimals):
            values *= _POWERS[width]
            values += (quad if width == 4 else two if width == 2 else one).take(at + offset)
        values /= _POWERS[self.decimals]
        # At i: a sign within i … i + 4.
        np.logical_or(minus[:-1], minus[1:], out=free[:-1])
        np.logical_or(free[:-3], free[2:-1], out=pair[:-3])
        np.logical_or(pair[:-4], minus[4:], out=pair[:-4])
        values *= _SIGNS.take(pair.view(np.uint8).take(at - 5))
        return values, at - PAD

    def _ends_fit(self, blank: _Flags, point: _Flags, free: _Flags) -> bool:
        """Whether a number ends where its point says that it does, and nowhere else."""
        np.greater(blank[1:], blank[:-1], out=free[1:])
        n = self.decimals + 1
        return not np.logical_xor(point[:-n], free[n:], out=free[n:]).any()

    def _digits_follow(self, pair: _Flags, point: _Flags, *free: _Flags) -> bool:
        """Whether as many digits as there are decimals come behind every point."""
        run, length, room = pair, 2, len(pair)
        while length < self.decimals:
            ahead = min(length, self.decimals - length)
            room -= ahead
            # Never into its own input, of which numpy would first make a copy.
            out = free[0] if run is not free[0] else free[1]
            np.logical_and(run[:room], run[ahead : ahead + room], out=out[:room])
            run, length = out, length + ahead
        room -= 2
        out = free[0] if run is not free[0] else free[1]
        return not np.greater(point[:room], run[1 : room + 1], out=out[:room]).any()


def _five_before(digit: _Flags, pair: _Flags, point: _Flags, free: _Flags) -> bool:
    """Whether a point has five digits before it, one more than are read."""
    np.logical_and(pair[:-4], pair[2:-2], out=free[:-4])
    np.logical_and(free[:-5], digit[4:-1], out=free[:-5])
    return bool(np.logical_and(free[:-5], point[5:], out=free[:-5]).any())


def _pieces(decimals: int) -> list[tuple[int, int]]:
    """(width, offset from the point) of the pieces of 4, 2 and 1 digits of the decimals."""
    out, done = [], 0
    for width in (4, 4, 2, 1):
        if decimals - done >= width:
            out.append((width, done + 1))
            done += width
    return out
