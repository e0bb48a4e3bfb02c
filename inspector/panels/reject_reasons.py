"""The usual reasons for a rejection, in English for files and in the user's language."""

from __future__ import annotations

from inspector.language import tr

# Text in files: text in the chosen language.
_REASONS = {
    "natural motion": tr("natural motion"),
    "fast but real": tr("fast but real"),
    "other joint is wrong": tr("the other joint is wrong"),
    "edges are wrong": tr("the start or end is wrong"),
}
_IN_FILES = {shown: kept for kept, shown in _REASONS.items()}
REASONS = tuple(_REASONS)


def translate_reject_reason(reason: str) -> str:
    """Return a reason in the user's language. A reason that the user typed is not translated."""
    return _REASONS.get(reason, reason)


def reject_reason_in_english(shown: str) -> str:
    """Return the English text of a selected reason, for files. A typed reason is unchanged."""
    return _IN_FILES.get(shown, shown)
