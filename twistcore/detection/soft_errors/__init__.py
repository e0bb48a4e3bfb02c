"""Find soft errors, which begin and end gradually, at any time scale [Method]."""

from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.soft_intervals import (
    Known,
    budget_of,
    search,
    soft_interval,
    unsearched_sentences,
)

__all__ = [
    "Known",
    "SoftError",
    "budget_of",
    "search",
    "soft_interval",
    "unsearched_sentences",
]
