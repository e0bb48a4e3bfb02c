"""Count the intervals that a detector lists at a given τ."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import Analysis, Interval, Kind
from twistcore.review.model import Span
from twistcore.skeleton.rotation import Array
from twistcore.tuning.cleaning import Verdicts
from twistcore.work.frozen import dataclass


@dataclass(frozen=True, eq=False)
class ListCounts:
    """Interval counts of one chain at one τ, or arrays of shape (n,) for n values of τ.

    Parameters
    ----------
    listed
        Number of listed counter-twists of any confidence.
    automatic
        Number of listed counter-twists that are corrected automatically.
    rejected
        Number of listed counter-twists that a person rejected, which are false alarms.
    """

    listed: Array | float
    automatic: Array | float
    rejected: Array | float

    def __add__(self, other: ListCounts) -> ListCounts:
        return ListCounts(
            self.listed + other.listed,
            self.automatic + other.automatic,
            self.rejected + other.rejected,
        )


def count_counter_twists_at_tau(
    detector: Analysis,
    chain: str,
    tau: float,
    verdicts: Verdicts,
    left_out: Sequence[Span] = (),
) -> ListCounts:
    """Count the counter-twists that `detect --tau` lists for a chain at `tau` radians.

    Intervals that overlap the half-open spans `left_out` do not count. An interval counts as
    rejected if it shares more frames with a rejected interval than with any accepted one.
    """
    found = [
        i
        for i in detector.intervals(chain, tau)
        if i.kind == Kind.COUNTER_TWIST
        and not any(i.start < stop and start < i.stop for start, stop in left_out)
    ]
    natural = [(start, stop) for name, start, stop in verdicts.natural if name == chain]
    errors = [(e.start, e.stop) for e in verdicts.errors if e.chain == chain]
    rejected = sum(_most_shared(i, natural) > _most_shared(i, errors) for i in found)
    return ListCounts(len(found), len(automatic_corrections(found)), rejected)


def _most_shared(interval: Interval, spans: Iterable[Span]) -> int:
    """Return the largest number of frames that an interval shares with one of the spans."""
    shared = (min(interval.stop, b) - max(interval.start, a) for a, b in spans)
    return max((n for n in shared if n > 0), default=0)
