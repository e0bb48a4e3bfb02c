"""Choose between a text and its shorter forms, so that a narrow window shows whole words."""

from __future__ import annotations

from collections.abc import Callable, Sequence


def form_that_fits(forms: Sequence[str], width_of: Callable[[str], int], width: int) -> str:
    """Return the first of several forms of a text that fits into `width` pixels, or the last.

    `width_of` returns the width of a text in pixels.
    """
    return next((form for form in forms if width_of(form) <= width), forms[-1])
