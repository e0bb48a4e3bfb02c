"""Films in which a slider of the teaching tab moves from one value to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inspector.language import tr
from inspector.teaching.taught_frame import TaughtFrame


@dataclass(frozen=True)
class Swept:
    """A slider of the teaching tab that a film can move.

    Attributes
    ----------
    words
        The name of the slider.
    unit
        '°' for an angle, '%' for a share, or '' for the stage of the animation: at stage 0 the bone
        is at rest, at 1 it has swung, and at 2 it has swung and twisted.
    low, high
        The range of the slider.
    decimals
        The number of decimals.
    """

    words: str
    unit: str
    low: float
    high: float
    decimals: int = 0


SWEPT = {
    "twist": Swept(tr("Twist of the parent"), "°", -180.0, 180.0),
    "swing": Swept(tr("Swing α"), "°", 0.0, 180.0),
    "bend": Swept(tr("Bend"), "°", 0.0, 180.0),
    "nudge": Swept(tr("Nudge"), "°", -3.0, 3.0, 1),
    "applied": Swept(tr("Apply: share of the offset removed"), "%", 0.0, 100.0),
    "stage": Swept(tr("Show the stages: a, swing, then twist"), "", 0.0, 2.0, 1),
}


@dataclass(frozen=True)
class Sweep:
    """The movement of a slider in a film.

    Attributes
    ----------
    slider
        A key of SWEPT.
    first, last
        The values at the beginning and at the end.
    seconds
        The duration of the movement in each direction.
    and_back
        True if the slider also moves back.
    """

    slider: str
    first: float
    last: float
    seconds: float = 4.0
    and_back: bool = True

    def values(self, fps: float) -> list[float]:
        """Return the value of the slider in each image of a film, from `first` to `last`.

        If `and_back` is True, the values then move back, without repeating either end.
        """
        count = max(2, round(self.seconds * fps))
        there: list[float] = np.linspace(self.first, self.last, count).tolist()
        return there + there[-2:0:-1] if self.and_back else there

    def show(self, taught: TaughtFrame, value: float) -> None:
        """Set the teaching tab's slider to a value. Other sliders stay unchanged."""
        if self.slider == "stage":
            taught.set_stage(value)
        elif self.slider == "applied":
            taught.alter(applied=0.01 * value)
        else:
            taught.alter(**{self.slider: float(np.radians(value))})
