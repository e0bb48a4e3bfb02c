"""Remove the errors that a clip already has before τ is tuned on it.

Existing errors would count as false alarms and hide the errors injected for measuring.
"""

from __future__ import annotations

from collections.abc import Sequence

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction import automatic_corrections, refine
from twistcore.detection import DEFAULT_METHOD, Interval, Kind
from twistcore.skeleton.motion import Motion
from twistcore.work.frozen import dataclass

SURE = 0.9  # confidence from which an interval is an error without a person's verdict
AUDITOR = DEFAULT_METHOD  # for any detector that is tuned, since the paper's has no confidence


@dataclass(frozen=True, eq=False)
class Verdicts:
    """A person's verdicts on a clip.

    Parameters
    ----------
    errors
        Intervals that are wrong.
    natural
        Spans (chain, start, stop), with `stop` exclusive, that are correct motion. A detector that
        finds them raises a false alarm.
    """

    errors: tuple[Interval, ...] = ()
    natural: tuple[tuple[str, int, int], ...] = ()


def cleaned(given: ClipAnalysis, verdicts: Verdicts | None = None) -> Motion:
    """Return the motion without the errors that a person named or the detector is certain of.

    Detections that overlap one of the person's verdicts are ignored.
    """
    verdicts = verdicts or Verdicts()
    judged = [(i.chain, i.start, i.stop) for i in verdicts.errors] + list(verdicts.natural)
    sure = automatic_corrections(given.detect(AUDITOR, kinds=(Kind.COUNTER_TWIST,)), SURE)
    wrong = [*(i for i in sure if not _touches(i, judged)), *verdicts.errors]
    return refine(given.motion, given.chains, wrong) if wrong else given.motion


def _touches(interval: Interval, spans: Sequence[tuple[str, int, int]]) -> bool:
    return any(
        interval.chain == chain and interval.start < stop and start < interval.stop
        for chain, start, stop in spans
    )
