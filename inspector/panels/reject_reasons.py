"""Why an interval is rejected: reasons to choose from, the same in files whatever the language."""

from __future__ import annotations

from inspector.language import tr

# As files have them, and as a person reads them.
_REASONS = {
    "natural motion": tr("natural motion"),
    "fast but real": tr("fast but real"),
    "other joint is wrong": tr("other joint is wrong"),
    "edges are wrong": tr("edges are wrong"),
}
_IN_FILES = {told: kept for kept, told in _REASONS.items()}
REASONS = tuple(_REASONS)


def told_reason(reason: str) -> str:
    """A reason as a person reads it; one of a person's own is as it was written."""
    return _REASONS.get(reason, reason)


def kept_reason(told: str) -> str:
    """A reason that was read or written, as it is kept."""
    return _IN_FILES.get(told, told)
