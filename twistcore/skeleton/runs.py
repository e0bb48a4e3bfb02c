"""Find runs of consecutive frames in masks, and group overlapping spans of frames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray


class Span(Protocol):
    """An object with a span of frames [start, stop)."""

    @property
    def start(self) -> int:
        """The first frame of the span."""

    @property
    def stop(self) -> int:
        """The frame after the last frame of the span."""


SomeSpan = TypeVar("SomeSpan", bound=Span)


def runs_of_true(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the runs of True in a mask (frames,) as pairs [start, stop), sorted by start."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]])))
    return list(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True))


def group_overlapping_spans(spans: Iterable[SomeSpan], apart: int = 0) -> list[list[SomeSpan]]:
    """Group overlapping spans, which must be sorted by start.

    Spans that are fewer than `apart` frames apart are grouped as well.
    """
    groups: list[list[SomeSpan]] = []
    end = 0
    for span in spans:
        if groups and span.start < end + apart:
            groups[-1].append(span)
            end = max(end, span.stop)
        else:
            groups.append([span])
            end = span.stop
    return groups
