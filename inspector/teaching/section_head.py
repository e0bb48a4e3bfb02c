"""The heading of a section in the teaching tab. A click on it folds the section."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QKeySequence, QPainter, QPaintEvent, QPalette, QPolygonF
from PySide6.QtWidgets import QAbstractButton, QSizePolicy

from inspector.language import tr
from inspector.widgets.labels import escape_tool_tip_text
from inspector.widgets.text_forms import form_that_fits

_ARROW = 8.0  # pixels, including a margin
_GAP = 6.0


class SectionHead(QAbstractButton):
    """A button with bold text and an arrow. It is checked while its section is unfolded."""

    def __init__(self, text: str, *, folded: bool = False) -> None:
        super().__init__()
        self.setCheckable(True)
        self.setChecked(not folded)
        self.setCursor(Qt.CursorShape.PointingHandCursor)
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        font = self.font()
        font.setBold(True)
        self.setFont(font)
        self._short = ""
        self.set_text(text)

    @property
    def folded(self) -> bool:
        """True if the section is folded."""
        return not self.isChecked()

    def set_text(self, text: str, short: str = "") -> None:
        """Set the text, the tool tip and the accessible name.

        `short` is shown instead of the text if the text does not fit.
        """
        self._short = short
        if text != self.text():
            self.setText(text)
            self.setShortcut(QKeySequence())  # an '&' in a joint's name must not create a mnemonic
            self.setToolTip(
                escape_tool_tip_text(tr("{what}. Click to expand or collapse.", what=text))
            )
            self.setAccessibleName(text)

    @property
    def least_width(self) -> int:
        """The width, in pixels, that the shortest form of the text needs."""
        shortest = self._short or self.text()
        return self.fontMetrics().horizontalAdvance(shortest) + round(4.0 + _ARROW + _GAP)

    def sizeHint(self) -> QSize:
        """Return the preferred size, with the height of one line."""
        letters = self.fontMetrics()
        return QSize(letters.horizontalAdvance(self.text()) + 22, letters.height() + 2)

    def minimumSizeHint(self) -> QSize:
        """Return a size without a minimum width."""
        return QSize(0, self.sizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the text, which is shortened if necessary, and an arrow if folding is possible."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        role = QPalette.ColorRole
        ink = self.palette().color(role.WindowText if self.underMouse() else role.PlaceholderText)
        painter.setBrush(ink)
        painter.setPen(Qt.PenStyle.NoPen)
        left = 4.0
        if self.isEnabled():
            middle = QPointF(left + _ARROW / 2.0, self.height() / 2.0)
            corners = ((-3.0, -4.0), (3.0, 0.0), (-3.0, 4.0))
            if not self.folded:
                corners = ((-4.0, -3.0), (4.0, -3.0), (0.0, 3.0))
            painter.drawPolygon(QPolygonF([middle + QPointF(*corner) for corner in corners]))
            left += _ARROW + _GAP
        painter.setPen(self.palette().color(role.Highlight) if self.hasFocus() else ink)
        room = self.rect().adjusted(round(left), 0, 0, 0)
        end = Qt.TextElideMode.ElideRight
        forms, letters = (self.text(), self._short or self.text()), self.fontMetrics()
        text = letters.elidedText(
            form_that_fits(forms, letters.horizontalAdvance, room.width()), end, room.width()
        )
        painter.drawText(room, Qt.AlignmentFlag.AlignVCenter, text)
        painter.end()
