"""A person's settings for a suggested τ."""

from __future__ import annotations

import math
from collections.abc import Mapping

from PySide6.QtCore import QObject, Signal

from inspector.session.settings import Settings
from twistcore.tuning import SharedTau, TauCurve, shared_tau


class Wishes(QObject):
    """The cost of a false alarm, the smallest error to find, and the number of draws."""

    changed = Signal()

    def __init__(self, settings: Settings, parent: QObject) -> None:
        super().__init__(parent)
        self._settings = settings

    @property
    def points(self) -> float:
        """The cost of one false alarm per clip or minute, in points of FSR."""
        return self._settings.alarm_points

    @property
    def smallest_degrees(self) -> float:
        """The smallest error to find, degrees."""
        return self._settings.smallest_error

    @property
    def draws(self) -> int:
        """The number of draws of errors for every chain and protocol."""
        return self._settings.error_draws

    def wish(
        self,
        *,
        points: float | None = None,
        smallest_degrees: float | None = None,
        draws: int | None = None,
    ) -> None:
        """Change some of the settings."""
        settings = self._settings
        before = self.points, self.smallest_degrees, self.draws
        settings.alarm_points = self.points if points is None else points
        if smallest_degrees is not None:
            settings.smallest_error = smallest_degrees
        settings.error_draws = self.draws if draws is None else draws
        if before != (self.points, self.smallest_degrees, self.draws):
            self.changed.emit()

    def suggested(self, curve: TauCurve) -> float:
        """Return the τ that a curve suggests, radians."""
        return curve.suggested(*self._terms)

    def shared(self, curves: Mapping[str, TauCurve]) -> SharedTau | None:
        """Return the common τ for all chains, or None."""
        return shared_tau(curves, *self._terms)

    @property
    def _terms(self) -> tuple[float, float]:
        return self.points / 100.0, math.radians(self.smallest_degrees)
