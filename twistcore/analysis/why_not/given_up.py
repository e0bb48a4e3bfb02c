"""Find intervals between jumps that were dropped in favour of soft (gradual) errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from twistcore.analysis.why_not.reason import AskedFrame, Reason, Why, format_signed_degrees
from twistcore.detection import Interval
from twistcore.detection.consistency.chain_analysis import ChainAnalysis, ConsistencyAnalysis
from twistcore.skeleton.chain import Chain

BESIDE = 1  # maximum number of frames between an interval's edge and a jump that belongs to it


@dataclass(frozen=True, eq=False)
class SoftErrors:
    """The soft (gradual) errors near a frame, and the intervals that they replaced.

    Attributes
    ----------
    place
        The frame for which a reason is requested.
    analysis
        The analysis of all chains.
    chains
        All chains that were analysed.
    """

    place: AskedFrame
    analysis: ConsistencyAnalysis
    chains: Sequence[Chain]

    def dropped(self) -> Iterator[Interval]:
        """Yield the intervals between two jumps above τ that a soft error has replaced."""
        own = self.analysis.chains[self.place.chain.name]
        return (i for i in own.between_edges(self.place.tau) if own.is_replaced(i))

    def with_edge_in(self, start: int, stop: int) -> Interval | None:
        """Return the first dropped interval with an edge in or next to [start, stop), or None."""
        near = range(start - BESIDE, stop + BESIDE)
        return next((i for i in self.dropped() if i.start in near or i.stop in near), None)

    def better_explanation(
        self, given: Interval | None, numbers: Mapping[str, Any], what: str = "it"
    ) -> Reason:
        """Return the reason that a soft error explains the frames better than a dropped interval.

        Parameters
        ----------
        given
            The dropped interval, or None if it is unknown.
        numbers
            Numbers to store in the reason, keyed by name.
        what
            Subject of the sentence: the jump that would have been an edge of the interval.
        """
        place, found = self.place, list(self._soft_errors())
        low, high = (given.start, given.stop) if given else (place.frame, place.frame)
        would_be = f"{what} would be an edge of {place.named(given) if given else 'an interval'}"
        if not found:
            because = f"{would_be}, but a soft error explains the frames better"
            return place.reason(Why.OTHER, because, **numbers)
        _, interval, chain = min(
            ((max(i.start - high, low - i.stop, 0), i, c) for i, c in found), key=lambda s: s[0]
        )
        if chain.name == place.chain.name:
            because = (
                f"{would_be}, but this explains the frames less well than {place.named(interval)}"
            )
            return place.reason(Why.OTHER, because, **numbers)
        because = f"{would_be}, but {place.error(interval, chain)} explains the frames better"
        return place.reason(Why.IMAGE, because, of=chain.name, **numbers)

    def _soft_errors(self) -> Iterator[tuple[Interval, Chain]]:
        """Yield soft errors above τ with their chains, first those of the frame's own chain."""
        chain = self.place.chain
        joints = {chain.parent, chain.child}
        near = [c for c in self.chains if joints & {c.parent, c.child}]
        for c in sorted(near, key=lambda c: c.name != chain.name):
            for s in self.analysis.chains[c.name].fixed:
                if s.strength >= self.place.tau:
                    yield s.interval, c


def soft_error_below_tau(place: AskedFrame, own: ChainAnalysis) -> Reason | None:
    """Return the reason if a soft error below τ has its peak at the frame, or None."""
    for s in own.fixed:
        if s.peak == place.frame and s.strength == place.strength:
            span = place.span(s.interval.start, s.interval.stop)
            because = f"the whole error in {span} is only {format_signed_degrees(s.interval.shown)}"
            return place.reason(Why.BELOW, because, start=s.interval.start, stop=s.interval.stop)
    return None
