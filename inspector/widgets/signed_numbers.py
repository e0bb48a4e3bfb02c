"""Format numbers with a real minus sign, and without a sign before zero."""

from __future__ import annotations

import math

from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox

from twistcore.detection import Kind

_MINUS = "−"


def signed(value: float, digits: int = 1) -> str:
    """Return a number with its sign, such as '+12.0', '−0.3', but '0.0'."""
    text = plain(value, digits)
    return f"+{text}" if text[0] != _MINUS and float(text) else text


def plain(value: float, digits: int = 1) -> str:
    """Return a number as text such as '12.0', '−0.3' or '0.0', never '−0.0'."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}".replace("-", _MINUS)


def angle_of(kind: Kind, radians: float) -> str:
    """Return an interval's angle for a list: '+12.0°', '±8.0°' for noise, or '–' if it has none."""
    if not (sign := kind.info.sign):
        return "–"
    degrees = math.degrees(radians)
    return f"±{plain(degrees)}°" if sign == "±" else f"{signed(degrees)}°"


class SignedBox(QDoubleSpinBox):
    """A number field that shows a real minus sign and accepts a hyphen as well."""

    def textFromValue(self, value: float) -> str:
        """Return the text for a value."""
        return plain(value, self.decimals())

    def valueFromText(self, text: str) -> float:
        """Return the value of a typed text."""
        return super().valueFromText(text.replace(_MINUS, "-"))

    def validate(self, text: str, place: int) -> tuple[QValidator.State, str, int]:
        """Check whether a text is a number or the beginning of one."""
        checked = super().validate(text.replace(_MINUS, "-"), place)
        assert isinstance(checked, tuple)
        return checked[0], text, checked[2]  # keep the text with its minus sign
