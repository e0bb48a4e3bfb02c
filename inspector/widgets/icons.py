"""The program's icons: drawings in lines, in the colours of the theme."""

from __future__ import annotations

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

from inspector.bundled import ICONS
from inspector.widgets.theme import Theme

SIDE = 18  # pixels of a screen of scale 1
_SCALES = (1.0, 2.0)  # of screens


def has_icon(name: str) -> bool:
    """Whether there is a drawing of this name: an action's id, or a word."""
    return (ICONS / f"{name}.svg").is_file()


def icon(name: str, theme: Theme) -> QIcon:
    """The drawing in the colour of text; where nothing can be pressed in a paler one."""
    drawing = (ICONS / f"{name}.svg").read_text("utf-8")
    made = QIcon()
    for mode, colour in ((QIcon.Mode.Normal, theme.text), (QIcon.Mode.Disabled, theme.faint)):
        renderer = QSvgRenderer(drawing.replace("#000", colour).encode())
        for scale in _SCALES:
            picture = QPixmap(round(SIDE * scale), round(SIDE * scale))
            picture.setDevicePixelRatio(scale)
            picture.fill(Qt.GlobalColor.transparent)
            painter = QPainter(picture)
            renderer.render(painter, QRectF(0, 0, SIDE, SIDE))
            painter.end()
            made.addPixmap(picture, mode)
    return made
