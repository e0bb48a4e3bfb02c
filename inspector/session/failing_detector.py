"""Use the default detector if a review's detector is not installed or fails on the clip."""

from __future__ import annotations

from inspector.language import tr, translate_core_sentence
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import DETECTORS, Interval
from twistcore.errors import TwistError
from twistcore.review import ReviewState
from twistcore.review.reasons import intervals_detected_at_review_tau


def redetect_or_give_up(analysis: ClipAnalysis, state: ReviewState) -> tuple[Interval, ...]:
    """Return the intervals that the review's detector finds at the review's τ.

    If the detector fails, the default detector replaces it for this clip.
    """
    try:
        return intervals_detected_at_review_tau(analysis, state)
    except TwistError as error:
        analysis.give_up(state.method, str(error))
        return intervals_detected_at_review_tau(analysis, state)


def unusable_detector_message(analysis: ClipAnalysis, method: str) -> str:
    """Return a message if a review's detector is not installed or fails on the clip, or ''."""
    if why := analysis.failure(method):
        return tr(
            "The detector of this review fails on this clip: {why}. You can still judge and "
            "export the intervals. To change τ, choose another detector.",
            why=translate_core_sentence(why),
        )
    if DETECTORS.usable(method) == method:
        return ""
    return tr(
        "The intervals of this review were found by the detector '{name}', which is not "
        "installed. You can still judge and export the intervals. To change τ, choose "
        "another detector.",
        name=method,
    )


def replaced_detector_message(analysis: ClipAnalysis, method: str) -> str:
    """Return a message stating that the default detector has replaced the detector `method`."""
    if why := analysis.failure(method):
        return tr(
            "The default detector was used for {clip}, with its automatic τ, because {why}.",
            clip=analysis.name,
            why=translate_core_sentence(why),
        )
    return tr(
        "The detector '{name}' for {clip} is not installed. Another detector was used, with its "
        "own τ.",
        name=method,
        clip=analysis.name,
    )
