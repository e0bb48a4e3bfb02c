"""The list of equations with their current values.

Each symbol is a button; a click on it highlights the symbol in all views.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from textwrap import wrap

from PySide6.QtCore import QPoint, QRectF, QSize, QSizeF, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFocusEvent,
    QFontInfo,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QRegion,
)
from PySide6.QtWidgets import QAbstractButton, QGridLayout, QLabel, QSizePolicy, QWidget

from inspector.language import tr
from inspector.teaching.equation_table import SECTIONS, Equation
from inspector.teaching.section_head import SectionHead
from inspector.teaching.symbols import SYMBOLS, symbol_family_colour
from inspector.teaching.taught_frame import TaughtFrame
from inspector.widgets.building import RIGHT, Wrapping, hbox, use_secondary_text_colour
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.theme import Colours, figures_font
from inspector.widgets.typeset import EM, Typesetter

_FIGURES = 9.0  # points; font size of the values
_SIZE = 0.97  # size of a formula, relative to the line height
_LINE = 7 / 6  # line height relative to the font size, independent of the font's own line spacing
_ASIDE = 5  # pixels on either side of a formula
_LONGEST = 32  # characters in a line; longer values, such as quaternions, are wrapped
_Row = tuple[float, float]
# The space above and below the baseline of a row, in line heights; some formulas need more.
_ROW = (0.83, 0.31)
_HIGHER_ROWS = {r"\frac": (0.96, 0.54), "^{-1}": (0.89, 0.44)}
_CONVENTIONS = tr(
    "Hamilton, scalar first (w, x, y, z); q = swing · twist; rotations are local; degrees."
)


class _Typeset:
    """Computes the size of a formula in a widget, and draws it."""

    def __init__(self, widget: QWidget, typesetter: Typesetter, tex: str, row: _Row) -> None:
        self._widget, self._typesetter, self._tex = widget, typesetter, tex
        self._above, below = row
        self._high = self._above + below

    @property
    def _line(self) -> float:
        """The line height in pixels."""
        return _LINE * QFontInfo(self._widget.font()).pixelSize()

    @property
    def _scale(self) -> float:
        return _SIZE * self._line / EM

    def size(self) -> QSize:
        """Return the width of the formula and the height of its row, in pixels."""
        formula = self._typesetter.formula(self._tex)
        width = formula.box.width() * self._scale if formula else 20.0
        high = round(self._high * self._line)
        return QSize(round(width) + 2 * _ASIDE, high)

    def paint(self, painter: QPainter, ink: QColor) -> None:
        """Draw the formula at the left edge of the widget, on the baseline of the row."""
        formula = self._typesetter.formula(self._tex)
        if formula is None:
            return
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.translate(_ASIDE, self._above * self._line)
        painter.scale(self._scale, self._scale)
        painter.translate(-formula.box.left(), 0.0)
        painter.fillPath(formula.path, ink)
        painter.restore()


class SymbolButton(QAbstractButton):
    """A button with a typeset symbol. The button is checked while the symbol is highlighted."""

    def __init__(
        self, symbol: str, typesetter: Typesetter, colours: Colours, row: _Row = _ROW
    ) -> None:
        super().__init__()
        self.symbol = symbol
        self._formula = _Typeset(self, typesetter, SYMBOLS[symbol].tex, row)
        self._colours = colours
        self._calm = False
        self._value = ""
        self._ink = self._paper = "#000000"
        self.setCheckable(True)
        self.setAttribute(Qt.WidgetAttribute.WA_Hover)  # repaint when the mouse enters or leaves
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        words = SYMBOLS[symbol].words
        what = f"{words[0].upper()}{words[1:]}"
        self.setToolTip(tr("{what}. Click to highlight it.", what=what))
        self.setAccessibleName(words)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        colours.changed.connect(self._inked)
        self._inked()

    def set_calm(self, *, calm: bool) -> None:
        """Draw the symbol in the normal text colour or, if `calm` is False, in its own colour."""
        if calm != self._calm:
            self._calm = calm
            self._inked()

    def _inked(self) -> None:
        theme, family = self._colours.theme, "bone" if self._calm else SYMBOLS[self.symbol].family
        self._ink, self._paper = symbol_family_colour(family, theme), theme.surface
        self.update()

    def set_spoken(self, value: str) -> None:
        """Set the value that a screen reader reads when the button has the focus."""
        self._value = value
        if self.hasFocus():
            self.setAccessibleDescription(value)

    def focusInEvent(self, event: QFocusEvent) -> None:
        """Let a screen reader read the value when the button gets the focus."""
        self.setAccessibleDescription(self._value)
        super().focusInEvent(event)

    def sizeHint(self) -> QSize:
        """Return the size of the formula."""
        return self._formula.size()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the symbol in a rounded box, which is filled while the symbol is highlighted."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(self.rect()).adjusted(1.0, 0.5, -1.0, -0.5)
        ink, paper = QColor(self._ink), QColor(self._paper)
        if self.isChecked() or self.underMouse() or self.hasFocus():
            painter.setPen(QPen(ink, 1.4 if self.isChecked() or self.hasFocus() else 0.8))
            painter.setBrush(ink if self.isChecked() else paper)
            painter.drawRoundedRect(box, 6.0, 6.0)
        self._formula.paint(painter, paper if self.isChecked() else ink)


class _InRow(QLabel):
    """A label in a row of the list.

    Its height is 0, so that only the formulas determine the row height.
    """

    def sizeHint(self) -> QSize:
        """Return the width of the text and a height of 0."""
        return QSize(super().sizeHint().width(), 0)

    def minimumSizeHint(self) -> QSize:
        """Return the same size as `sizeHint`."""
        return self.sizeHint()


class RightSide(QWidget):
    """A widget with the typeset right-hand side of an equation."""

    def __init__(self, tex: str, typesetter: Typesetter, row: _Row = _ROW) -> None:
        super().__init__()
        self._formula = _Typeset(self, typesetter, tex, row)
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """Return the size of the formula."""
        return self._formula.size()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the formula in the text colour."""
        self._formula.paint(QPainter(self), self.palette().color(QPalette.ColorRole.WindowText))


class Equations(QWidget):
    """The list of all equations, under headings that can be folded.

    `clicked` is emitted with the symbol that the user clicks.
    """

    clicked = Signal(str)

    def __init__(self, taught: TaughtFrame, typesetter: Typesetter, colours: Colours) -> None:
        super().__init__()
        self._taught, self._colours = taught, colours
        self.values: dict[str, QLabel] = {}
        self.buttons: dict[str, SymbolButton] = {}
        self.heads: list[SectionHead] = []
        self._rights: list[RightSide] = []
        self._rows: dict[str, tuple[QWidget, QWidget, Wrapping, QWidget]] = {}
        self._only: frozenset[str] | None = None
        grid = QGridLayout(self)
        grid.setContentsMargins(2, 1, 4, 4)
        grid.setHorizontalSpacing(2)
        grid.setVerticalSpacing(0)
        row = 0
        for section in SECTIONS:
            head = SectionHead(section.title)
            head.toggled.connect(self._arrange)
            self.heads.append(head)
            grid.addWidget(head, row, 0, 1, 4)
            row += 1
            for equation in section.rows:
                self._add(grid, row, equation, typesetter)
                row += 1
        self.conventions = use_secondary_text_colour(QLabel(_CONVENTIONS, wordWrap=True))
        self.conventions.setContentsMargins(4, 4, 0, 0)
        grid.addWidget(self.conventions, row, 0, 1, 4)
        grid.setColumnStretch(2, 1)
        grid.setRowStretch(row + 1, 1)
        typesetter.ready.connect(self._measured)
        taught.rows_changed.connect(lambda: self.show_only(taught.rows or None))
        if taught.rows:
            self.show_only(taught.rows)

    def _add(self, grid: QGridLayout, row: int, equation: Equation, typesetter: Typesetter) -> None:
        line = next((row for part, row in _HIGHER_ROWS.items() if part in equation.right), _ROW)
        button = SymbolButton(equation.symbol, typesetter, self._colours, line)
        button.clicked.connect(lambda _=False, s=equation.symbol: self.clicked.emit(s))
        right = RightSide(equation.right, typesetter, line)
        selectable = Qt.TextInteractionFlag.TextSelectableByMouse
        value = SteadyLabel(alignment=RIGHT, textInteractionFlags=selectable)
        value.setFont(figures_font(_FIGURES))
        star = "*" if equation.corrected else ""
        text = f"({equation.number}){star}" if equation.number else ""
        number = use_secondary_text_colour(_InRow(text, alignment=RIGHT))
        number.setContentsMargins(2, 0, 0, 0)
        if equation.corrected:
            number.setToolTip(
                tr(
                    "In the paper, equation {number} is {printed}.",
                    number=equation.number,
                    printed=equation.corrected,
                )
            )
        equals = _InRow("" if equation.right.startswith("<") else "=")
        # in one cell, because the widest formula and the widest number are in different rows
        both = Wrapping(hbox(right, None), hbox(None, value), spacing=4)
        grid.addWidget(button, row, 0, Qt.AlignmentFlag.AlignRight)
        for column, widget in enumerate((equals, both, number), 1):
            grid.addWidget(widget, row, column)
        self.values[equation.symbol] = value
        self.buttons[equation.symbol] = button
        self._rights.append(right)
        self._rows[equation.symbol] = (button, equals, both, number)

    def set_scale(self, scale: float) -> None:
        """Scale the text of the values; 1 is the normal size.

        The size of the formulas depends on the font of the widget.
        """
        for value in self.values.values():
            value.setFont(figures_font(_FIGURES * scale))

    def refresh(self) -> None:
        """Update the values of all rows and the names of the joints."""
        numbers = self._taught.numbers if self._taught.active else None
        for equation in itertools.chain(*(section.rows for section in SECTIONS)):
            text = equation.value(numbers) if numbers is not None else ""
            self.values[equation.symbol].setText("\n".join(wrap(text, _LONGEST)))
            self.buttons[equation.symbol].set_spoken(text)
        joints = self._taught.joints
        for head, section in zip(self.heads, SECTIONS, strict=True):
            bare = section.bare_title
            head.set_text(section.title.format(**joints) if joints else bare, bare)
        event = numbers is not None and numbers.is_event
        for symbol, button in self.buttons.items():
            if symbol in ("product", "m"):  # small opposite changes are natural
                button.set_calm(calm=not event)

    def show_only(self, symbols: Iterable[str] | None) -> None:
        """Show only the rows of these symbols, even under folded headings. None shows all rows."""
        self._only = None if symbols is None else frozenset(symbols)
        self._arrange()

    def _arrange(self) -> None:
        for head, section in zip(self.heads, SECTIONS, strict=True):
            listed = [self._only is None or e.symbol in self._only for e in section.rows]
            head.setVisible(any(listed))
            head.setEnabled(self._only is None)
            folded = self._only is None and head.folded
            for equation, on in zip(section.rows, listed, strict=True):
                for widget in self._rows[equation.symbol]:
                    widget.setVisible(on and not folded)

    @property
    def whole_width(self) -> int:
        """The smallest width, in pixels, at which every visible row fits into one line."""
        cells = [row[2] for row in self._rows.values() if not row[2].isHidden()]
        least = max((cell.minimumSizeHint().width() for cell in cells), default=0)
        widest = max((cell.row_width for cell in cells), default=0)
        return self.minimumSizeHint().width() + widest - least

    def show_lit(self, symbol: str) -> None:
        """Highlight this symbol instead of any other. If `symbol` is '', highlight none."""
        for name, button in self.buttons.items():
            button.setChecked(name == symbol)

    def paint_into(self, painter: QPainter, size: QSizeF) -> None:
        """Draw the list with vector outlines, scaled to fit into `size`."""
        self.ensurePolished()
        own = self.size() if self.isVisible() else self.sizeHint()
        if not self.isVisible():
            self.resize(own)
        scale = min(size.width() / own.width(), size.height() / own.height())
        painter.save()
        painter.scale(scale, scale)
        self.render(painter, QPoint(), QRegion(), QWidget.RenderFlag.DrawChildren)
        painter.restore()

    def _measured(self) -> None:
        for widget in (*self.buttons.values(), *self._rights):
            widget.updateGeometry()
            widget.update()
