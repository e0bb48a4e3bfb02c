"""Remove the existing errors of a clip before τ is tuned on it.

If they were not removed, the existing errors would count as false alarms and hide injected errors.
"""

from __future__ import annotations

from collections.abc import Sequence

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.detection import DEFAULT_METHOD, Interval, Kind
from twistcore.detection.cuts import count_leading_rest_frames, count_trailing_rest_frames
from twistcore.skeleton.motion import Motion
from twistcore.work.frozen import dataclass

SURE = 0.9  # minimum confidence of an interval that counts as an error without a verdict
AUDITOR = DEFAULT_METHOD  # finds existing errors; the paper's detector gives no confidence


@dataclass(frozen=True, eq=False)
class Verdicts:
    """A person's verdicts on the intervals of a clip.

    Parameters
    ----------
    errors
        The accepted intervals, which are real errors.
    natural
        Spans (chain, start, stop) of rejected intervals, with `stop` exclusive. The motion in these
        spans is correct, so any detection there is a false alarm.
    """

    errors: tuple[Interval, ...] = ()
    natural: tuple[tuple[str, int, int], ...] = ()


def without_known_errors(given: ClipAnalysis, verdicts: Verdicts | None = None) -> Motion:
    """Return the motion with its known errors corrected.

    Known errors are intervals that a person accepted, and detections that are almost certainly
    errors. A detection that overlaps an interval with a verdict is ignored.
    """
    verdicts = verdicts or Verdicts()
    wrong = [*unjudged_certain_errors(given, verdicts), *verdicts.errors]
    return refine(given.motion, given.chains, wrong) if wrong else given.motion


def span_without_rest_pose(motion: Motion) -> tuple[int, int]:
    """Return the frames [start, stop) of the captured motion, without blends from or to a T-pose.

    A single T-pose in frame 0 remains, since it contains no blend.
    """
    first, stop = (
        count_leading_rest_frames(motion),
        motion.frames - count_trailing_rest_frames(motion),
    )
    return first if first > 1 else 0, stop


def unjudged_certain_errors(given: ClipAnalysis, verdicts: Verdicts) -> tuple[Interval, ...]:
    """Return the detections that are almost certainly errors but have no verdict."""
    judged = [(i.chain, i.start, i.stop) for i in verdicts.errors] + list(verdicts.natural)
    sure = automatic_corrections(given.detect(AUDITOR, kinds=(Kind.COUNTER_TWIST,)), SURE)
    return tuple(i for i in sure if not _touches(i, judged))


def _touches(interval: Interval, spans: Sequence[tuple[str, int, int]]) -> bool:
    return any(
        interval.chain == chain and interval.start < stop and start < interval.stop
        for chain, start, stop in spans
    )
