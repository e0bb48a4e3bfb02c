"""Explain why the detector found nothing at a frame of the open clip."""

from __future__ import annotations

from collections.abc import Iterator

from inspector.language import translate_core_sentence
from inspector.session.document import Document
from twistcore.analysis.clip_analysis import Detection
from twistcore.analysis.why_not import (
    Reason,
    Why,
    peaks_above_tau_outside_intervals,
    why_frame_bounds_no_interval,
    why_peaks_lack_interval,
)

NEAR = 3  # frames; a peak within this distance of the playhead is explained


def review_as_detection(document: Document) -> Detection | None:
    """Return the review's intervals and τ as a detection.

    Returns None if no clip is open or the review's detector is not ready yet, and also in an
    exercise, because an explanation would reveal the answer.
    """
    if document.data is None or document.data.blind or not document.chain:
        return None
    state = document.review.state
    if document.method != state.method:
        return None
    intervals = tuple(j.interval for j in state.intervals)
    return Detection(document.data.analysis, state.method, state.tau, intervals)


def peak_near(document: Document, frame: int, reach: float = NEAR) -> int | None:
    """Return the nearest frame outside all intervals where the strength peaks above τ, or None.

    `reach` is the largest distance from `frame`, in frames.
    """
    if (found := review_as_detection(document)) is None or document.chain not in found.tau:
        return None
    peaks = peaks_above_tau_outside_intervals(found, document.chain)
    nearest = min(peaks, key=lambda t: abs(t - frame), default=None)
    return nearest if nearest is not None and abs(nearest - frame) <= reach else None


def reason_here(document: Document, frame: int) -> Reason | None:
    """Return the reason why the detector found nothing at a frame of the selected chain.

    Returns None if nothing can be explained, for example if no clip is open.
    """
    if (found := review_as_detection(document)) is None or document.chain not in found.tau:
        return None
    return why_frame_bounds_no_interval(found, document.chain, frame, first=document.first_frame)


def reason_near(document: Document, frame: int) -> Reason | None:
    """Return the reason why the detector found nothing at a frame or at a nearby peak.

    The reason refers to the frame itself if the frame is in an interval or its strength is above τ,
    and to the nearest peak if not. Returns None if there is no peak nearby.
    """
    if (reason := reason_here(document, frame)) is None:
        return None
    if reason.why == Why.INTERVAL or reason.strength >= reason.tau:
        return reason
    near = peak_near(document, frame)
    return None if near is None else reason_here(document, near)


def reason_sentence(document: Document, reason: Reason) -> str:
    """Return the reason as a sentence that begins with the chain's name."""
    label = translate_core_sentence(document.find_chain(reason.chain).label)
    return f"{label}: {translate_core_sentence(reason.text)}"


def reasons_at_unexplained_peaks(document: Document) -> Iterator[Reason]:
    """Yield, chain by chain, a reason for each strength peak above τ outside all intervals."""
    if (found := review_as_detection(document)) is not None:
        for chain in found.chains_and_limbs:
            yield from why_peaks_lack_interval(found, chain.name, first=document.first_frame)
