"""Numbers as a person reads them: a real minus sign, and no sign before a zero."""

from __future__ import annotations

import math

from PySide6.QtGui import QValidator
from PySide6.QtWidgets import QDoubleSpinBox

from twistcore.detection import Kind

_MINUS = "−"


def signed(value: float, digits: int = 1) -> str:
    """With its sign, '+' too: '+12.0', '−0.3', but '0.0'."""
    text = plain(value, digits)
    return f"+{text}" if text[0] != _MINUS and float(text) else text


def plain(value: float, digits: int = 1) -> str:
    """With a minus sign where it is below zero as it is rounded: '12.0', '−0.3', '0.0'."""
    return f"{round(float(value), digits) + 0.0:.{digits}f}".replace("-", _MINUS)


def angle_of(kind: Kind, radians: float) -> str:
    """The angle of an interval in a list: '+12.0°', '±8.0°' of noise, '–' of frozen frames."""
    if not (sign := kind.info.sign):
        return "–"
    degrees = math.degrees(radians)
    return f"±{plain(degrees)}°" if sign == "±" else f"{signed(degrees)}°"


class SignedBox(QDoubleSpinBox):
    """A box that shows its number so; either minus can be typed."""

    def textFromValue(self, value: float) -> str:
        """What stands in the box."""
        return plain(value, self.decimals())

    def valueFromText(self, text: str) -> float:
        """What was typed."""
        return super().valueFromText(text.replace(_MINUS, "-"))

    def validate(self, text: str, place: int) -> tuple[QValidator.State, str, int]:
        """Whether that is a number, or may become one."""
        said = super().validate(text.replace(_MINUS, "-"), place)
        assert isinstance(said, tuple)
        return said[0], text, said[2]  # the text as it is, with its own minus
