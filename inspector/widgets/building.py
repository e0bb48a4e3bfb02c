"""Rows, columns and the small widgets that panels are made of, each in one call."""

from __future__ import annotations

from typing import TypeVar

from PySide6.QtCore import QEvent, QSize, Qt
from PySide6.QtGui import QAction, QResizeEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QFrame,
    QHBoxLayout,
    QLabel,
    QLayout,
    QScrollArea,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
_Label = TypeVar("_Label", bound=QLabel)
_Box = TypeVar("_Box", bound=QBoxLayout)
_Margins = tuple[int, int, int, int]  # pixels: left, top, right, bottom

# A widget, a layout, words; one of them with its stretch; so many empty pixels; or the empty room.
Part = QWidget | QLayout | str | tuple[QWidget | QLayout, int] | int | None


def hbox(
    *parts: Part,
    owner: QWidget | None = None,
    margins: _Margins | None = None,
    spacing: int | None = None,
) -> QHBoxLayout:
    """Parts from left to right; without margins or spacing as the style has them.

    owner: the widget that they fill.
    """
    box = QHBoxLayout() if owner is None else QHBoxLayout(owner)
    return _filled(box, parts, margins, spacing)


def vbox(
    *parts: Part,
    owner: QWidget | None = None,
    margins: _Margins | None = None,
    spacing: int | None = None,
) -> QVBoxLayout:
    """Parts from top to bottom, likewise."""
    box = QVBoxLayout() if owner is None else QVBoxLayout(owner)
    return _filled(box, parts, margins, spacing)


def _filled(
    box: _Box, parts: tuple[Part, ...], margins: _Margins | None, spacing: int | None
) -> _Box:
    if margins is not None:
        box.setContentsMargins(*margins)
    if spacing is not None:
        box.setSpacing(spacing)
    for part in parts:
        what, stretch = part if isinstance(part, tuple) else (part, 0)
        if what is None:
            box.addStretch(1)
        elif isinstance(what, int):
            box.addSpacing(what)
        elif isinstance(what, QLayout):
            box.addLayout(what, stretch)
        else:
            box.addWidget(QLabel(what) if isinstance(what, str) else what, stretch)
    return box


class Wrapping(QWidget):
    """Parts beside each other; under each other where there is not the width for all."""

    def __init__(self, *parts: QLayout, spacing: int) -> None:
        super().__init__()
        self._parts = parts
        self._box = hbox(*parts, owner=self, margins=(0, 0, 0, 0), spacing=spacing)

    def minimumSizeHint(self) -> QSize:
        """As wide as the widest part."""
        wide = max(part.minimumSize().width() for part in self._parts)
        return QSize(wide, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Beside each other or not."""
        super().resizeEvent(event)
        self._arrange()

    def event(self, event: QEvent) -> bool:
        """A part that has other words may be wider."""
        if event.type() == QEvent.Type.LayoutRequest:
            self._arrange()
        return super().event(event)

    @property
    def beside(self) -> int:
        """Pixels in which all parts are beside each other."""
        gaps = self._box.spacing() * (len(self._parts) - 1)
        return sum(part.minimumSize().width() for part in self._parts) + gaps

    def _arrange(self) -> None:
        wanted = self.beside
        beside = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        if self._box.direction() != (wanted_direction := beside[wanted > self.width()]):
            self._box.setDirection(wanted_direction)


def soft(label: _Label) -> _Label:
    """The same label, in the theme's colour of secondary text."""
    label.setObjectName("soft")
    return label


def hint(text: str = "") -> QLabel:
    """A soft sentence in the middle of the room, where there is nothing else to show."""
    return soft(QLabel(text, alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True))


def tool_button(text: str, tip: str, *, flat: bool = True) -> QToolButton:
    """A small button with a word or a sign on it; flat: without a frame until the mouse is there.

    A sign, not the style's picture: those are black on a dark window. A screen reader cannot say
    it: it says the tip.
    """
    button = QToolButton(autoRaise=flat)
    button.setText(text)
    button.setToolTip(tip)
    if not any(map(str.isalnum, text)):
        button.setAccessibleName(tip)
    return button


def action_button(action: QAction, short: str = "") -> QToolButton:
    """The button of an action; `short`: the word on it, where it is plain what it is about."""
    if short:
        action.setIconText(short)
    button = QToolButton()
    button.setDefaultAction(action)
    return button


def scrolled(content: QWidget) -> QScrollArea:
    """It keeps its size where there is less room, and scrolls."""
    area = QScrollArea(widgetResizable=True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setWidget(content)
    return area


def bring_to_front(widget: QWidget) -> None:
    """Show it, and before what lies over it: a dock comes before the other tabs of its place."""
    widget.show()
    widget.raise_()
