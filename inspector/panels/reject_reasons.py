"""The usual reasons for a rejection. Files always contain the English text."""

from __future__ import annotations

from inspector.language import tr

# Text in files: text in the chosen language.
_REASONS = {
    "natural motion": tr("natural motion"),
    "fast but real": tr("fast but real"),
    "other joint is wrong": tr("other joint is wrong"),
    "edges are wrong": tr("edges are wrong"),
}
_IN_FILES = {shown: kept for kept, shown in _REASONS.items()}
REASONS = tuple(_REASONS)


def shown_reason(reason: str) -> str:
    """Return a reason in the chosen language. A reason typed by the user is not translated."""
    return _REASONS.get(reason, reason)


def stored_reason(shown: str) -> str:
    """Return the text to write to a file for a reason that was selected or typed."""
    return _IN_FILES.get(shown, shown)
