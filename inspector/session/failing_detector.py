"""A detector that is not installed here, or fails on the clip: what is used and said then."""

from __future__ import annotations

from inspector.language import of_core, tr
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import DETECTORS, Interval
from twistcore.errors import TwistError
from twistcore.review import ReviewState
from twistcore.review.reasons import redetected_intervals


def reasons_of(analysis: ClipAnalysis, state: ReviewState) -> tuple[Interval, ...]:
    """What a review's detector finds at its τ; where it fails, it is not used any more."""
    try:
        return redetected_intervals(analysis, state)
    except TwistError as error:
        analysis.give_up(state.method, str(error))
        return redetected_intervals(analysis, state)


def not_usable(analysis: ClipAnalysis, method: str) -> str:
    """What is to be known of a review whose detector is missing or fails; '' where it works."""
    if why := analysis.failure(method):
        return tr(
            "The detector that found this review's intervals fails on the clip: {why}. They can be "
            "judged and exported, while their τ stays until another detector is chosen.",
            why=of_core(why),
        )
    if DETECTORS.usable(method) == method:
        return ""
    return tr(
        "This review's intervals were found by the detector '{name}', which is not installed here: "
        "they can be judged and exported, while their τ stays until another detector is chosen.",
        name=method,
    )


def another_used(analysis: ClipAnalysis, method: str) -> str:
    """What is to be known of a clip that was not searched by the detector that was to do so."""
    if why := analysis.failure(method):
        return tr(
            "{clip} was searched by another detector than it was to be, at its own τ: {why}.",
            clip=analysis.name,
            why=of_core(why),
        )
    return tr(
        "The detector '{name}', which {clip} was to be searched with, is not installed here: "
        "another one was used, at its own τ.",
        name=method,
        clip=analysis.name,
    )
