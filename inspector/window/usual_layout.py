"""How the window is laid out at first, and again when a person wants that."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow

_LEFT, _RIGHT, _CURVES = 350, 545, 330  # pixels, where there is room
_SHARES = 0.25, 0.38, 0.35  # of the window's width, width and height, where there is less


class UsualLayout:
    """Docks in their places, the 3D view with a third of the window's width or more."""

    def __init__(self, window: QMainWindow, docks: Mapping[str, QDockWidget]) -> None:
        """`docks`: by their object names, where they belong."""
        self._window, self._docks = window, docks
        self._usual = window.saveState()

    def fit(self) -> None:
        """The sizes that go with the size of the window."""
        window, docks = self._window, self._docks
        wide, high = window.width(), window.height()
        left, right, curves = (
            min(most, round(share * all_of_it))
            for most, share, all_of_it in zip(
                (_LEFT, _RIGHT, _CURVES), _SHARES, (wide, wide, high), strict=True
            )
        )
        across, upright = Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        window.resizeDocks([docks["chains"], docks["intervals"]], [left, right], across)
        window.resizeDocks([docks["curves"]], [curves], upright)

    def reset(self) -> None:
        """Every panel in its place, shown or not, as in the first window."""
        self._window.restoreState(self._usual)
        self._docks["intervals"].raise_()
        self.fit()
