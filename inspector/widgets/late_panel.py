"""A panel that is built only when it is first needed, so that the program starts faster."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar, cast

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFrame, QScrollArea, QWidget


class SeenPanel(Protocol):
    """A panel that updates its content only while it is visible."""

    def set_seen(self, seen: bool) -> None:
        """Tell the panel whether it is visible. It updates its content only while it is visible."""


Panel = TypeVar("Panel", bound=SeenPanel)


class LatePanel(QScrollArea, Generic[Panel]):
    """A scroll area for a panel that is built when it is first visible or used.

    The scroll area exists from the start, so that the dock has a position, a tab and a menu entry.
    """

    made = Signal(QWidget)  # with the panel, when it is built

    def __init__(self, build: Callable[[], Panel]) -> None:
        """Create the empty scroll area. `build` is a function that returns the panel, a QWidget."""
        super().__init__(widgetResizable=True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self._make = build
        self._panel: Panel | None = None

    @property
    def built(self) -> bool:
        """True if the panel exists."""
        return self._panel is not None

    def build(self) -> Panel:
        """Return the panel. If it does not exist yet, it is built first."""
        if self._panel is None:
            self._panel = self._make()
            self.setWidget(cast("QWidget", self._panel))
            self.made.emit(self._panel)
        return self._panel

    def set_seen(self, seen: bool) -> None:
        """Tell the panel whether it is visible. The panel is built when it is first visible.

        The dock calls this method, because Qt does not hide a panel behind a different tab.
        """
        if seen or self.built:
            self.build().set_seen(seen)
