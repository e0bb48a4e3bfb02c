"""Estimate from a few verdicts how many automatic corrections in a folder correct real errors.

Verdicts on the worst intervals say little about the other intervals, because large detections are
more often real errors. Therefore, :func:`representative_judging_order` spreads the first verdicts
evenly over all confidences. A learned confidence (`learned_confidence.py`), fitted to these
verdicts, then gives the precision of the corrections without a verdict.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection.interval import Interval, Kind
from twistcore.review.model import APPLIED, Decision, ReviewState
from twistcore.skeleton.rotation import Array
from twistcore.tuning.learned_confidence import ConfidenceVerdicts, fit_confidence_to_verdicts
from twistcore.tuning.verdict_curve import wilson_bounds
from twistcore.work.frozen import dataclass

ENOUGH_STATED = 30  # minimum number of verdicts


@dataclass(frozen=True)
class AutomaticCorrection:
    """An interval of frames [start, stop) that is corrected automatically."""

    chain: str
    start: int
    stop: int
    confidence: float
    kind: Kind = Kind.COUNTER_TWIST

    def is_in(self, interval: Interval) -> bool:
        """Return True if `interval` has the same chain and kind, and overlaps this correction."""
        same = (self.chain, self.kind) == (interval.chain, interval.kind)
        return same and self.start < interval.stop and interval.start < self.stop


@dataclass(frozen=True)
class StatedPrecision:
    """The estimated precision of the automatic corrections that have no verdict.

    Attributes
    ----------
    share
        Estimated fraction of the corrections that correct real errors, 0…1.
    low, high
        Limits of the 90 % confidence interval of `share`.
    verdicts
        Number of verdicts used for the estimate.
    left
        Number of automatic corrections without a verdict.
    """

    share: float
    low: float
    high: float
    verdicts: int
    left: int


def automatic_corrections_with_confidence(
    found: Iterable[Interval],
) -> tuple[AutomaticCorrection, ...]:
    """Return the detected intervals that are corrected automatically and have a confidence."""
    return tuple(
        AutomaticCorrection(i.chain, i.start, i.stop, i.confidence, i.kind)
        for i in automatic_corrections(found)
        if i.confidence is not None
    )


def verdicts_on_automatic_corrections(
    corrections: Sequence[AutomaticCorrection], state: ReviewState
) -> tuple[bool | None, ...]:
    """Return a person's verdict on each correction: True if accepted, False if rejected.

    The result is None for a correction without a verdict, such as an interval that was accepted in
    bulk or applied automatically.
    """
    decided = [
        j
        for j in state.intervals
        if j.decision != Decision.UNDECIDED and j.verdict != APPLIED and not j.in_bulk
    ]
    out: list[bool | None] = []
    for one in corrections:
        verdict = next((j for j in decided if one.is_in(j.interval)), None)
        out.append(None if verdict is None else verdict.decision == Decision.ACCEPTED)
    return tuple(out)


def representative_judging_order(confidence: Array) -> list[int]:
    """Return an order for judging corrections in which the first verdicts represent all of them.

    Parameters
    ----------
    confidence : array, shape (n,)
        The confidence of each correction.

    Returns
    -------
    list of int
        Indices of the corrections. The corrections are sorted by confidence and visited in a van
        der Corput sequence, so the first k verdicts are spread evenly over the confidences, for
        any k.
    """
    if not (count := len(confidence)):
        return []
    by_confidence = np.argsort(confidence, kind="stable")
    bits = max(count - 1, 1).bit_length()
    places = (int(f"{k:0{bits}b}"[::-1], 2) * count >> bits for k in range(1 << bits))
    return [int(by_confidence[place]) for place in dict.fromkeys(places)]


def estimate_unjudged_precision(
    confidence: Array, verdicts: Sequence[bool | None]
) -> StatedPrecision | None:
    """Return the estimated precision of the corrections without a verdict.

    Parameters
    ----------
    confidence : array, shape (n,)
        The detector's confidence in each correction.
    verdicts : sequence of n bool or None
        True for an accepted correction, False for a rejected one, None without a verdict.

    Returns
    -------
    StatedPrecision or None
        None if there are fewer than ENOUGH_STATED verdicts, or if every correction has one.
    """
    known = np.array([v is not None for v in verdicts], dtype=bool)
    count, left = int(known.sum()), int((~known).sum())
    if count < ENOUGH_STATED or not left:
        return None
    accepted = np.array([v for v in verdicts if v is not None], dtype=bool)
    adjusted = fit_confidence_to_verdicts(
        ConfidenceVerdicts(confidence[known], accepted, np.zeros(count))
    )
    share = float(adjusted.of(confidence[~known]).mean())
    # Both the judged and the remaining corrections are finite samples of all such corrections.
    size = 1.0 / (1.0 / count + 1.0 / left)
    low, high = wilson_bounds(np.array(share * size), np.array(size))
    return StatedPrecision(share, float(low), float(high), count, left)
