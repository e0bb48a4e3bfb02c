"""A translucent cover that dims a widget. The widget remains readable and usable."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from inspector.widgets.theme import Colours, Theme

_OPACITY = 0.45
_FOLLOWED = (QEvent.Type.Resize, QEvent.Type.Enter, QEvent.Type.Leave)


class Veil(QWidget):
    """A cover over a widget. It ignores the mouse, and is hidden while the mouse is over it.

    A hidden cover takes no time to paint. A visible cover is painted by Qt only where the widget
    below is painted.
    """

    def __init__(self, covered: QWidget, colours: Colours) -> None:
        super().__init__(covered)
        self._on = False
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        colours.follow(self._colour)
        self.hide()

    def _colour(self, theme: Theme) -> None:
        self._paper = QColor(theme.window)
        self._paper.setAlphaF(_OPACITY)
        self.update()

    def cover(self, on: bool) -> None:
        """Dim the widget, or show it normally if `on` is False."""
        covered = self.parentWidget()
        if on != self._on and covered is not None:
            self._on = on
            if on:
                covered.installEventFilter(self)
            else:
                covered.removeEventFilter(self)
            self._follow(covered)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Adapt the cover when the widget is resized or the mouse enters or leaves it.

        All events are passed on.
        """
        if event.type() in _FOLLOWED and isinstance(watched, QWidget):
            self._follow(watched)
        return False

    def _follow(self, covered: QWidget) -> None:
        self.setGeometry(covered.rect())
        self.setVisible(self._on and not covered.underMouse())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the part of the cover that must be repainted."""
        QPainter(self).fillRect(event.rect(), self._paper)
