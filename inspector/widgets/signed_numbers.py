"""Format numbers as text, with a typographic minus sign and without a sign for zero."""

from __future__ import annotations

import math

from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox

from twistcore.detection import Kind

_MINUS = "−"


def format_signed_number(value: float, digits: int = 1) -> str:
    """Return a number as text with its sign, such as '+12.0' or '−0.3', but '0.0' for zero."""
    text = format_number(value, digits)
    return f"+{text}" if text[0] != _MINUS and float(text) else text


def format_number(value: float, digits: int = 1) -> str:
    """Return a number as text, such as '12.0', '−0.3' or '0.0', but never '−0.0'."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}".replace("-", _MINUS)


def interval_angle_text(kind: Kind, radians: float) -> str:
    """Return the angle of an interval as text, such as '+12.0°', or '±8.0°' for noise.

    Returns '–' if intervals of this kind have no angle.
    """
    if not (sign := kind.info.sign):
        return "–"
    degrees = math.degrees(radians)
    return f"±{format_number(degrees)}°" if sign == "±" else f"{format_signed_number(degrees)}°"


class SignedBox(QDoubleSpinBox):
    """A number field that shows a typographic minus sign and also accepts a hyphen."""

    def textFromValue(self, value: float) -> str:
        """Return the text that the field shows for a value."""
        return format_number(value, self.decimals())

    def valueFromText(self, text: str) -> float:
        """Convert the text that the user has typed to a number."""
        return super().valueFromText(text.replace(_MINUS, "-"))

    def validate(self, text: str, place: int) -> tuple[QValidator.State, str, int]:
        """Return whether a text is a number, the beginning of a number, or neither."""
        checked = super().validate(text.replace(_MINUS, "-"), place)
        assert isinstance(checked, tuple)
        return checked[0], text, checked[2]  # keep the text as typed, with its minus sign
