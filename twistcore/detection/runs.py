"""Frames that follow one another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Runs of True as [start, stop); (frames,) → by start."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return list(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True))
