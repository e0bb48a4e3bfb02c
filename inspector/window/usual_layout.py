"""How the window is laid out at first, and again when a person wants that."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow

# Chains, intervals, curves: pixels where there is room, else shares of the window's size.
_MOST = 350, 545, 330
_SHARES = 0.25, 0.38, 0.35
_LEEWAY = 3  # pixels that a layout may round by


class UsualLayout:
    """Docks in their places, the 3D view with a third of the window's width or more."""

    def __init__(self, window: QMainWindow, docks: Mapping[str, QDockWidget]) -> None:
        """`docks`: by their object names, where they belong."""
        self._window, self._docks = window, docks
        self._usual = window.saveState()
        self._fitted: tuple[int, ...] = ()

    def fit(self) -> None:
        """The sizes that go with the size of the window."""
        window, docks = self._window, self._docks
        wide, high = window.width(), window.height()
        sizes = zip(_MOST, _SHARES, (wide, wide, high), strict=True)
        left, right, curves = self._fitted = tuple(min(m, round(s * all_)) for m, s, all_ in sizes)
        across, upright = Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        window.resizeDocks([docks["chains"], docks["intervals"]], [left, right], across)
        window.resizeDocks([docks["curves"]], [curves], upright)

    def follow(self) -> None:
        """The window has another size: so have its panels, unless a person gave them theirs."""
        docks = self._docks
        now = docks["chains"].width(), docks["intervals"].width(), docks["curves"].height()
        if self._fitted and all(
            abs(a - b) <= _LEEWAY for a, b in zip(now, self._fitted, strict=True)
        ):
            self.fit()

    def reset(self) -> None:
        """Every panel in its place, shown or not, as in the first window."""
        self._window.restoreState(self._usual)
        self._docks["intervals"].raise_()
        self.fit()
