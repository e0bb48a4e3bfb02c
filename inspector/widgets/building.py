"""Build rows, columns and small widgets for the panels."""

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

# A part of a layout: a widget, a layout or a text; a widget or layout with its stretch factor; the
# size of a space in pixels; or None for a space that stretches.
Part = QWidget | QLayout | str | tuple[QWidget | QLayout, int] | int | None


def hbox(
    *parts: Part,
    owner: QWidget | None = None,
    margins: _Margins | None = None,
    spacing: int | None = None,
) -> QHBoxLayout:
    """Return a layout that arranges parts from left to right.

    Parameters
    ----------
    parts
        The parts: widgets, layouts, strings and spaces, as in `Part`.
    owner
        The widget in which the layout is installed, or None.
    margins, spacing
        Sizes in pixels. None uses the defaults of Qt's style.
    """
    box = QHBoxLayout() if owner is None else QHBoxLayout(owner)
    return _filled(box, parts, margins, spacing)


def vbox(
    *parts: Part,
    owner: QWidget | None = None,
    margins: _Margins | None = None,
    spacing: int | None = None,
) -> QVBoxLayout:
    """Return a layout that arranges parts from top to bottom. For the parameters, see `hbox`."""
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
    """A widget that shows its parts side by side or, if it is too narrow, one below the other."""

    def __init__(self, *parts: QLayout, spacing: int) -> None:
        super().__init__()
        self._parts = parts
        self._box = hbox(*parts, owner=self, margins=(0, 0, 0, 0), spacing=spacing)

    def minimumSizeHint(self) -> QSize:
        """Return the width of the widest part as the minimum width."""
        wide = max(part.minimumSize().width() for part in self._parts)
        return QSize(wide, super().minimumSizeHint().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Arrange the parts for the new width."""
        super().resizeEvent(event)
        self._arrange()

    def event(self, event: QEvent) -> bool:
        """Arrange the parts again if the text of a part has changed."""
        if event.type() == QEvent.Type.LayoutRequest:
            self._arrange()
        return super().event(event)

    @property
    def row_width(self) -> int:
        """The width, in pixels, that is needed to show all parts side by side."""
        gaps = self._box.spacing() * (len(self._parts) - 1)
        return sum(part.minimumSize().width() for part in self._parts) + gaps

    def _arrange(self) -> None:
        directions = QBoxLayout.Direction.LeftToRight, QBoxLayout.Direction.TopToBottom
        direction = directions[self.row_width > self.width()]
        if self._box.direction() != direction:
            self._box.setDirection(direction)


def use_secondary_text_colour(label: _Label) -> _Label:
    """Set the colour of a label to the theme's secondary text colour, and return the label."""
    label.setObjectName("soft")
    return label


def hint(text: str = "") -> QLabel:
    """Return a centred label with a hint for an empty panel."""
    return use_secondary_text_colour(
        QLabel(text, alignment=Qt.AlignmentFlag.AlignCenter, wordWrap=True)
    )


def tool_button(text: str, tip: str, *, flat: bool = True) -> QToolButton:
    """Return a small button with a word or a symbol and a tool tip.

    If `flat` is True, the frame of the button is visible only while the mouse is over it. The
    symbol is a character, because the black icons of Qt's style are invisible in a dark window.
    For a symbol, screen readers read the tool tip.
    """
    button = QToolButton(autoRaise=flat)
    button.setText(text)
    button.setToolTip(tip)
    if not any(map(str.isalnum, text)):
        button.setAccessibleName(tip)
    return button


def action_button(action: QAction, short: str = "") -> QToolButton:
    """Return a button for an action.

    `short` is a shorter text for the button, if the rest is clear from the context.
    """
    if short:
        action.setIconText(short)
    button = QToolButton()
    button.setDefaultAction(action)
    return button


def scrolled(content: QWidget) -> QScrollArea:
    """Return a scroll area whose content fills it, but is never smaller than its minimum size."""
    area = QScrollArea(widgetResizable=True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setWidget(content)
    return area


def bring_to_front(widget: QWidget) -> None:
    """Show a widget in front of others. If it is a tab of a dock, select the tab."""
    widget.show()
    widget.raise_()
