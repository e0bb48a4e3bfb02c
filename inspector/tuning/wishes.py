"""The user's settings that determine the suggested τ."""

from __future__ import annotations

import math
from collections.abc import Mapping

from PySide6.QtCore import QObject, Signal

from inspector.session import settings_checks as checks
from inspector.session.settings import FeatureSetting, Settings
from twistcore.tuning import SharedTau, TauCurve, shared_tau

MOST_DRAWS = 50  # maximum number of draws of random errors, from which the cost of τ is measured
# The points of FSR that a false alarm may cost, the smallest error to find in degrees, and the
# number of draws of random errors.
POINTS = FeatureSetting("alarm_points", 5.0, checks.number_between(0.0, 100.0))
SMALLEST = FeatureSetting("smallest_error", 2.0, checks.number_between(0.1, 180.0))
DRAWS = FeatureSetting("error_draws", 3, checks.whole_between(1, MOST_DRAWS))


class Wishes(QObject):
    """The cost of a false alarm, the smallest error to find, and the number of random draws.

    The values are stored in the program's settings.
    """

    changed = Signal()

    def __init__(self, settings: Settings, parent: QObject) -> None:
        super().__init__(parent)
        self._settings = settings

    @property
    def points(self) -> float:
        """The cost of one false alarm per clip or minute, in percentage points of FSR.

        FSR is the share of errors that are repaired.
        """
        return POINTS.of(self._settings)

    @property
    def smallest_degrees(self) -> float:
        """The smallest error to find, in degrees."""
        return SMALLEST.of(self._settings)

    @property
    def draws(self) -> int:
        """The number of draws of random errors for each chain and protocol."""
        return DRAWS.of(self._settings)

    def wish(
        self,
        *,
        points: float | None = None,
        smallest_degrees: float | None = None,
        draws: int | None = None,
    ) -> None:
        """Change the given settings, and emit `changed` if a value is different."""
        settings = self._settings
        before = self.points, self.smallest_degrees, self.draws
        if points is not None:
            POINTS.put(settings, points)
        if smallest_degrees is not None:
            SMALLEST.put(settings, smallest_degrees)
        if draws is not None:
            DRAWS.put(settings, draws)
        if before != (self.points, self.smallest_degrees, self.draws):
            self.changed.emit()

    def suggested(self, curve: TauCurve, present: float | None = None) -> float:
        """Return the τ, in radians, that is best according to a cost curve.

        If no τ is better than `present`, return `present`.
        """
        return curve.suggested(*self._terms, present=present)

    def plateau(self, curve: TauCurve, tau: float) -> tuple[float, float]:
        """Return the range of τ around `tau` with the same cost, as (low, high) in radians."""
        return curve.plateau(tau, *self._terms)

    def shared(self, curves: Mapping[str, TauCurve]) -> SharedTau | None:
        """Return the suggested common τ for all chains, or None if there is none."""
        return shared_tau(curves, *self._terms)

    @property
    def _terms(self) -> tuple[float, float]:
        return self.points / 100.0, math.radians(self.smallest_degrees)
