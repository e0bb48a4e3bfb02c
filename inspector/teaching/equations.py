"""The equations with their live numbers; a symbol is a button that lights up what it names."""

from __future__ import annotations

import itertools

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QAbstractButton, QGridLayout, QLabel, QSizePolicy, QWidget

from inspector.teaching.symbols import SECTIONS, SYMBOLS, Equation, colour
from inspector.teaching.taught_frame import TaughtFrame
from inspector.widgets.building import RIGHT, hbox, soft
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.theme import Theme, figures_font
from inspector.widgets.typeset import EM, Typesetter
from twistcore.decomposition import Decomposition

_SIZE = 1.04  # of a formula, in heights of the program's font
_PAD = (6, 3)  # pixels beside and above a formula


class _Typeset:
    """What a formula's widget measures and paints."""

    def __init__(self, widget: QWidget, typesetter: Typesetter, tex: str) -> None:
        self._widget, self._typesetter, self._tex = widget, typesetter, tex

    @property
    def _scale(self) -> float:
        return _SIZE * self._widget.fontMetrics().height() / EM

    def size(self) -> QSize:
        """As large as the formula; every one has room for a fraction."""
        formula = self._typesetter.formula(self._tex)
        width = formula.box.width() * self._scale if formula else 20.0
        high = round(1.7 * self._widget.fontMetrics().height())
        return QSize(round(width) + 2 * _PAD[0], high)

    def paint(self, painter: QPainter, ink: QColor) -> None:
        """On the common baseline, from the left."""
        formula = self._typesetter.formula(self._tex)
        if formula is None:
            return
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(_PAD[0], 0.64 * self._widget.height())
        painter.scale(self._scale, self._scale)
        painter.translate(-formula.box.left(), 0.0)
        painter.fillPath(formula.path, ink)
        painter.restore()


class SymbolButton(QAbstractButton):
    """A symbol to click."""

    def __init__(self, symbol: str, typesetter: Typesetter) -> None:
        super().__init__()
        self.symbol = symbol
        self._formula = _Typeset(self, typesetter, SYMBOLS[symbol].tex)
        self._ink = self._paper = "#000000"
        self.setCheckable(True)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)  # painted anew under the mouse
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        words = SYMBOLS[symbol].words
        self.setToolTip(f"{words[0].upper()}{words[1:]}. Click to light it up.")
        self.setAccessibleName(words)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        self._ink = colour(SYMBOLS[self.symbol].family, theme)
        self._paper = theme.surface
        self.update()

    def sizeHint(self) -> QSize:
        """The formula's."""
        return self._formula.size()

    def paintEvent(self, event: QPaintEvent) -> None:
        """A pill, filled when lit."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(self.rect()).adjusted(1.0, 1.5, -1.0, -1.5)
        ink, paper = QColor(self._ink), QColor(self._paper)
        if self.isChecked() or self.underMouse() or self.hasFocus():
            painter.setPen(QPen(ink, 1.4 if self.isChecked() or self.hasFocus() else 0.8))
            painter.setBrush(ink if self.isChecked() else paper)
            painter.drawRoundedRect(box, 6.0, 6.0)
        self._formula.paint(painter, paper if self.isChecked() else ink)


class RightSide(QWidget):
    """= and what a symbol is."""

    def __init__(self, tex: str, typesetter: Typesetter) -> None:
        super().__init__()
        self._formula = _Typeset(self, typesetter, tex)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """The formula's."""
        return self._formula.size()

    def paintEvent(self, event: QPaintEvent) -> None:
        """The formula, in the colour of text."""
        self._formula.paint(QPainter(self), self.palette().color(QPalette.ColorRole.WindowText))


class Equations(QWidget):
    """All rows; a click on a symbol is told, and lit when the taught frame says so."""

    clicked = Signal(str)

    def __init__(self, taught: TaughtFrame, typesetter: Typesetter) -> None:
        super().__init__()
        self._taught = taught
        self.values: dict[str, QLabel] = {}
        self.buttons: dict[str, SymbolButton] = {}
        self._rights: list[RightSide] = []
        grid = QGridLayout(self)
        grid.setContentsMargins(4, 2, 6, 6)
        grid.setHorizontalSpacing(2)
        grid.setVerticalSpacing(0)
        row = 0
        for title, equations in SECTIONS.items():
            head = soft(QLabel(title))
            head.setStyleSheet("font-weight: 600")
            head.setContentsMargins(4, 6, 0, 2)
            grid.addWidget(head, row, 0, 1, 4)
            row += 1
            for equation in equations:
                self._add(grid, row, equation, typesetter)
                row += 1
        grid.setColumnStretch(2, 1)
        grid.setRowStretch(row, 1)
        typesetter.ready.connect(self._measured)

    def _add(self, grid: QGridLayout, row: int, equation: Equation, typesetter: Typesetter) -> None:
        button = SymbolButton(equation.symbol, typesetter)
        button.clicked.connect(lambda _=False, s=equation.symbol: self.clicked.emit(s))
        right = RightSide(equation.right, typesetter)
        selectable = Qt.TextInteractionFlag.TextSelectableByMouse
        value = SteadyLabel(alignment=RIGHT, textInteractionFlags=selectable)
        value.setFont(figures_font(9.0))
        star = "*" if equation.corrected else ""
        text = f"({equation.number}){star}" if equation.number else ""
        number = soft(QLabel(text, alignment=RIGHT))
        number.setContentsMargins(6, 0, 0, 0)
        if equation.corrected:
            number.setToolTip(f"Equation {equation.number} is {equation.corrected}.")
        equals = QLabel("" if equation.right.startswith("<") else "=")
        # In one cell: the widest formula and the widest number are not of one row.
        both = hbox(right, None, value, spacing=4)
        grid.addWidget(button, row, 0, Qt.AlignmentFlag.AlignRight)
        grid.addWidget(equals, row, 1)
        grid.addLayout(both, row, 2)
        grid.addWidget(number, row, 3)
        self.values[equation.symbol] = value
        self.buttons[equation.symbol] = button
        self._rights.append(right)

    def set_theme(self, theme: Theme) -> None:
        """Other colours."""
        for button in self.buttons.values():
            button.set_theme(theme)

    def show_numbers(self, quantities: Decomposition | None) -> None:
        """Every row's value, or none."""
        for equation in itertools.chain(*SECTIONS.values()):
            text = equation.value(quantities) if quantities is not None else ""
            self.values[equation.symbol].setText(text)

    def show_lit(self, symbol: str) -> None:
        """Mark the lit symbol."""
        for name, button in self.buttons.items():
            button.setChecked(name == symbol)

    def _measured(self) -> None:
        for widget in (*self.buttons.values(), *self._rights):
            widget.updateGeometry()
            widget.update()
