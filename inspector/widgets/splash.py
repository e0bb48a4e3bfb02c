"""The splash screen, which is visible while the program starts."""

from __future__ import annotations

import time

from PySide6.QtCore import QEventLoop, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QGuiApplication, QPainter, QPixmap
from PySide6.QtWidgets import QApplication, QLabel, QWidget

from inspector.language import tr
from inspector.widgets.icons import program_icon
from inspector.widgets.theme import Theme

_SIZE = (340, 120)  # pixels
_ICON, _LEFT = 64, 24  # pixels: the size of the icon, and the space left of it
_NAME_POINTS = 15.0
_PATIENCE_S, _STEP_S = 0.5, 0.005  # longest wait for a visible window, and time between checks


class Splash(QLabel):
    """A splash screen that shows the program's icon and name and never gets the focus.

    It is not a QSplashScreen, because that class would wait a second for the desktop.
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        kind = Qt.WindowType.SplashScreen | Qt.WindowType.FramelessWindowHint
        self.setWindowFlags(kind | Qt.WindowType.WindowDoesNotAcceptFocus)
        self.setAttribute(Qt.WidgetAttribute.WA_ShowWithoutActivating)
        self.setAccessibleName(tr("Starting …"))
        self.setPixmap(_card(theme))
        self.resize(*_SIZE)
        middle = QGuiApplication.primaryScreen().availableGeometry().center()
        self.move(middle - self.rect().center())

    def show_at_once(self) -> None:
        """Show and paint the splash screen immediately, even if no event loop is running yet."""
        self.show()
        _wait_until_exposed(self)

    def finish(self, window: QWidget) -> None:
        """Close the splash screen as soon as the window is visible."""
        if self.isVisible():
            _wait_until_exposed(window)
        self.close()
        self.deleteLater()


def _wait_until_exposed(widget: QWidget) -> None:
    end = time.monotonic() + _PATIENCE_S
    while time.monotonic() < end:
        QApplication.processEvents(QEventLoop.ProcessEventsFlag.ExcludeUserInputEvents)
        if (handle := widget.windowHandle()) is not None and handle.isExposed():
            break
        time.sleep(_STEP_S)
    QApplication.processEvents(QEventLoop.ProcessEventsFlag.ExcludeUserInputEvents)


def _card(theme: Theme) -> QPixmap:
    wide, high = _SIZE
    scale = QGuiApplication.primaryScreen().devicePixelRatio()
    card = QPixmap(round(wide * scale), round(high * scale))
    card.setDevicePixelRatio(scale)
    card.fill(QColor(theme.surface))
    painter = QPainter(card)
    painter.setPen(QColor(theme.line))
    painter.drawRect(QRectF(0.5, 0.5, wide - 1.0, high - 1.0))
    icon = program_icon().pixmap(_ICON)
    painter.drawPixmap(_LEFT, (high - _ICON) // 2, _ICON, _ICON, icon)
    name = QFont(QApplication.font())
    name.setPointSizeF(_NAME_POINTS)
    name.setWeight(QFont.Weight.DemiBold)
    left = 2 * _LEFT + _ICON
    for font, colour, text, top, flag in (
        (name, theme.text, "Twist Inspector", 0, Qt.AlignmentFlag.AlignBottom),
        (QApplication.font(), theme.soft, tr("Starting …"), high // 2, Qt.AlignmentFlag.AlignTop),
    ):
        painter.setFont(font)
        painter.setPen(QColor(colour))
        painter.drawText(left, top, wide - left - 8, high // 2, flag, text)
    painter.end()
    return card
