"""Frames that a person leaves out of tuning: nothing in them says anything about τ."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from twistcore.review.commands import Command
from twistcore.review.model import ReviewState, Span


@dataclass(frozen=True)
class LeaveOut(Command):
    """Leave these frames out of tuning, half-open spans, and no others."""

    spans: tuple[Span, ...]

    @property
    def text(self) -> str:
        """What the undo menu says."""
        return "Leave frames out of tuning" if self.spans else "Take all frames into tuning"

    def apply(self, state: ReviewState) -> ReviewState:
        """The state after the command."""
        if any(not 0 <= start < stop for start, stop in self.spans):
            raise ValueError("a span has at least one frame")
        return replace(state, left_out=joined(self.spans))


def joined(spans: Iterable[Span]) -> tuple[Span, ...]:
    """Half-open spans in order, those that meet as one."""
    out: list[Span] = []
    for start, stop in sorted(spans):
        if out and start <= out[-1][1]:
            out[-1] = out[-1][0], max(stop, out[-1][1])
        else:
            out.append((start, stop))
    return tuple(out)


def _is_pair(entry: Any) -> bool:
    return isinstance(entry, list | tuple) and len(entry) == 2


def spans_from_json(entries: Any) -> tuple[Span, ...]:
    """Spans as files list them; TypeError or ValueError where they are damaged."""
    if not (isinstance(entries, list | tuple) and all(map(_is_pair, entries))):
        raise ValueError("left_out, a list of [start, stop],")
    spans = tuple((start, stop) for start, stop in entries)
    for start, stop in spans:
        if not (type(start) is int and type(stop) is int and 0 <= start < stop):
            raise ValueError(f"frames from {start} to {stop}")
    return joined(spans)
