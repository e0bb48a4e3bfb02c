"""The icons of the program and of its actions, which are line drawings in the theme's colours."""

from __future__ import annotations

from functools import cache

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QIcon, QPainter, QPixmap
from PySide6.QtSvg import QSvgRenderer

from inspector.bundled import ICONS
from inspector.widgets.theme import Theme

SIDE = 18  # pixels at screen scale 1
_SCALES = (1.0, 2.0)  # screen scales for which an icon is drawn
# Pixels; sizes of the program's icon for title bars, task bars and menus
_SIDES = (16, 22, 24, 32, 48, 64, 128, 256)


def has_icon(name: str) -> bool:
    """Return True if there is an icon with this name. An action's icon is named after its id."""
    return (ICONS / f"{name}.svg").is_file()


def program_icon() -> QIcon:
    """Return the icon of the program for title bars, task bars and menus."""
    renderer, made = QSvgRenderer(str(ICONS / "program.svg")), QIcon()
    for side in _SIDES:
        made.addPixmap(_drawn(renderer, side, 1.0))
    return made


def icon(name: str, theme: Theme) -> QIcon:
    """Return an icon in the text colour, with a paler version for disabled buttons."""
    return _painted((ICONS / f"{name}.svg").read_bytes(), theme.text, theme.faint)


@cache
def _painted(drawing: bytes, text: str, faint: str) -> QIcon:
    """Return an icon from an SVG drawing in two colours, for enabled and disabled buttons."""
    made = QIcon()
    for mode, colour in ((QIcon.Mode.Normal, text), (QIcon.Mode.Disabled, faint)):
        renderer = QSvgRenderer(drawing.replace(b"#000", colour.encode()))
        for scale in _SCALES:
            made.addPixmap(_drawn(renderer, SIDE, scale), mode)
    return made


def _drawn(renderer: QSvgRenderer, side: int, scale: float) -> QPixmap:
    """Draw an icon as a square image.

    `side` is the size of the image in pixels at a screen scale of 1, and `scale` is the screen
    scale.
    """
    picture = QPixmap(round(side * scale), round(side * scale))
    picture.setDevicePixelRatio(scale)
    picture.fill(Qt.GlobalColor.transparent)
    painter = QPainter(picture)
    renderer.render(painter, QRectF(0, 0, side, side))
    painter.end()
    return picture
