"""Choose between a text and its shorter forms, so that a narrow window shows whole words."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtGui import QFontMetrics


def form_that_fits(forms: Sequence[str], letters: QFontMetrics, width: int) -> str:
    """Return the first of several forms of a text that fits into `width` pixels, or the last."""
    return next((form for form in forms if letters.horizontalAdvance(form) <= width), forms[-1])
