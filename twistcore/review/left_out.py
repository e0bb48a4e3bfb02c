"""Exclude frames from tuning, so that they have no influence on τ."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from twistcore.files.document_values import read_each, read_frame_span, unexpected_value_error
from twistcore.review.commands import Command
from twistcore.review.model import ReviewState, Span
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class LeaveOut(Command):
    """Set the spans of frames that are excluded from tuning, each as frames [start, stop)."""

    spans: tuple[Span, ...]

    @property
    def text(self) -> str:
        """The command's name in the undo menu."""
        return "Leave frames out of tuning" if self.spans else "Use all frames for tuning"

    def apply(self, state: ReviewState) -> ReviewState:
        """Return the state with these spans, joined where they touch or overlap.

        Raises ValueError if a span is empty.
        """
        if any(not 0 <= start < stop for start, stop in self.spans):
            raise ValueError("a span must have at least one frame")
        return replace(state, left_out=joined_spans(self.spans))


def joined_spans(spans: Iterable[Span]) -> tuple[Span, ...]:
    """Sort spans of frames [start, stop), and join spans that touch or overlap."""
    out: list[Span] = []
    for start, stop in sorted(spans):
        if out and start <= out[-1][1]:
            out[-1] = out[-1][0], max(stop, out[-1][1])
        else:
            out.append((start, stop))
    return tuple(out)


def uncovered_parts(spans: Iterable[Span], others: Iterable[Span]) -> tuple[Span, ...]:
    """Return the parts of `spans` that are not covered by any of `others`, sorted."""
    out: list[Span] = []
    taken = joined_spans(others)
    for start, stop in joined_spans(spans):
        for a, b in taken:
            if start < a < stop:
                out.append((start, a))
            if a < stop and start < b:
                start = b
        if start < stop:
            out.append((start, stop))
    return tuple(out)


def excluded_spans_from_json(entries: Any) -> tuple[Span, ...]:
    """Convert JSON data to the spans that are excluded from tuning. Raises FormatError."""
    return joined_spans(read_each(entries, "left_out", _span))


def _span(entry: Any) -> Span:
    if not (isinstance(entry, list | tuple) and len(entry) == 2):
        raise unexpected_value_error("[start, stop]", "a span", entry)
    return read_frame_span({"start": entry[0], "stop": entry[1]})
