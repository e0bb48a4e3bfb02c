"""Measure how crowded the parts of an image are, to find free places for labels."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRect

from twistcore.skeleton.rotation import Array

_CELL = 6  # size of a cell in pixels


class Crowding:
    """A grid over an image. Each cell has the total weight of the objects that cover it."""

    def __init__(self, width: int, height: int) -> None:
        self._shape = width // _CELL + 1, height // _CELL + 1
        self._cells = np.zeros(self._shape)
        self._sums: Array | None = None

    def add(self, pixels: Array, weight: float = 1.0) -> None:
        """Add pixels (n, 2) with a weight. Pixels outside the image are ignored."""
        at = np.floor(pixels / _CELL).astype(np.int64)
        x, y = at[((at >= 0) & (at < self._shape)).all(axis=1)].T
        count = self._cells.size
        found = np.bincount(x * self._shape[1] + y, minlength=count)
        self._cells += weight * found.reshape(self._shape)
        self._sums = None

    def add_box(self, box: QRect, weight: float) -> None:
        """Add `weight` to each cell of a box."""
        x, y = max(box.left(), 0) // _CELL, max(box.top(), 0) // _CELL
        self._cells[x : box.right() // _CELL + 1, y : box.bottom() // _CELL + 1] += weight
        self._sums = None

    def within(self, low: Array, high: Array) -> Array:
        """Return the total weight in each box, (n,).

        `low` and `high` are the corners of the boxes in pixels, (n, 2) each.
        """
        if self._sums is None:
            self._sums = np.zeros((self._shape[0] + 1, self._shape[1] + 1))
            self._sums[1:, 1:] = self._cells.cumsum(axis=0).cumsum(axis=1)
        left, top = np.clip(np.floor(low / _CELL), 0, self._shape).astype(np.int64).T
        right, bottom = np.clip(np.ceil(high / _CELL), 0, self._shape).astype(np.int64).T
        sums = self._sums
        strips = sums[right, bottom] - sums[left, bottom] - sums[right, top]
        weight: Array = strips + sums[left, top]
        return weight
