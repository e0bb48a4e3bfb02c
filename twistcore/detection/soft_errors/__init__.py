"""Find soft errors, which begin and end gradually, at any time scale [Method]."""

from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.soft_intervals import (
    Known,
    search_soft_errors,
    soft_interval,
    soft_search_budget,
    unsearched_frames_sentences,
)

__all__ = [
    "Known",
    "SoftError",
    "search_soft_errors",
    "soft_interval",
    "soft_search_budget",
    "unsearched_frames_sentences",
]
