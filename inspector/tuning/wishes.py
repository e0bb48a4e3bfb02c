"""What a person wants of a suggested τ: settings, remembered from one run to the next."""

from __future__ import annotations

import math
from collections.abc import Mapping

from PySide6.QtCore import QObject, Signal

from inspector.session.settings import Settings
from twistcore.tuning import SharedTau, TauCurve, shared_tau


class Wishes(QObject):
    """The price of a false alarm, the smallest errors looked for, how many draws of errors."""

    changed = Signal()

    def __init__(self, settings: Settings, parent: QObject) -> None:
        super().__init__(parent)
        self._settings = settings

    @property
    def points(self) -> float:
        """Points of FSR that one false alarm a clip or minute may cost."""
        return self._settings.alarm_points

    @property
    def smallest_degrees(self) -> float:
        """Errors below are not looked for."""
        return self._settings.smallest_error

    @property
    def draws(self) -> int:
        """Of errors, for every chain and protocol."""
        return self._settings.error_draws

    def wish(
        self,
        *,
        points: float | None = None,
        smallest_degrees: float | None = None,
        draws: int | None = None,
    ) -> None:
        """Want something else; what is not named stays."""
        settings = self._settings
        before = self.points, self.smallest_degrees, self.draws
        settings.alarm_points = self.points if points is None else points
        if smallest_degrees is not None:
            settings.smallest_error = smallest_degrees
        settings.error_draws = self.draws if draws is None else draws
        if before != (self.points, self.smallest_degrees, self.draws):
            self.changed.emit()

    def suggested(self, curve: TauCurve) -> float:
        """τ in radians that a curve speaks for."""
        return curve.suggested(*self._terms)

    def shared(self, curves: Mapping[str, TauCurve]) -> SharedTau | None:
        """Whether one τ does for all chains."""
        return shared_tau(curves, *self._terms)

    @property
    def _terms(self) -> tuple[float, float]:
        return self.points / 100.0, math.radians(self.smallest_degrees)
