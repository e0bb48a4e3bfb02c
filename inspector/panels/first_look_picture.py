"""A picture of a clip that has been read and is being analysed, drawn over the start page."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QLineF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QWidget

from inspector.language import plural, tr
from inspector.session.first_look import FirstLook
from inspector.widgets.theme import Colours, Theme
from twistcore.skeleton.rotation import Array

_FILLS = 0.8  # share of the room that the figure fills
_TEXT = 64.0  # pixels below the figure, for two lines of text
_BONE = 3.0  # pixels: width of a bone


class FirstLookPicture(QWidget):
    """A stick figure with a description of the clip. It is hidden if there is no clip to show."""

    def __init__(self, parent: QWidget, colours: Colours) -> None:
        super().__init__(parent)
        self.look: FirstLook | None = None
        self.hide()
        colours.follow(self._colour)

    def _colour(self, theme: Theme) -> None:
        self._theme = theme
        self.update()

    def show_look(self, look: FirstLook) -> None:
        """Show a clip in place of the page below."""
        self.look = look
        parent = self.parentWidget()
        assert parent is not None
        self.setGeometry(parent.rect())
        self.raise_()
        self.show()
        self.update()

    def end(self) -> None:
        """Show the page below again."""
        self.look = None
        self.hide()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the figure, and below it the name of the clip and the work in progress."""
        if self.look is None:
            return
        painter, look = QPainter(self), self.look
        painter.fillRect(self.rect(), QColor(self._theme.surface))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pen = QPen(QColor(self._theme.soft), _BONE)
        pen.setCapStyle(Qt.PenCapStyle.RoundCap)
        painter.setPen(pen)
        room = QRectF(self.rect()).adjusted(0.0, 0.0, 0.0, -_TEXT)
        painter.drawLines(
            [QLineF(*a, *b) for a, b in fit_bones_to_rectangle(look.bones, room).tolist()]
        )
        place = QRectF(0.0, room.bottom(), room.width(), _TEXT)
        painter.setPen(QColor(self._theme.text))
        top = Qt.AlignmentFlag.AlignHCenter | Qt.AlignmentFlag.AlignTop
        painter.drawText(place, top, f"{description(look)}\n{tr('Searching for errors …')}")


def description(look: FirstLook) -> str:
    """Return the name and the size of a clip, such as 'walk.bvh: 344 frames at 120 fps'."""
    return plural(
        "{name}: 1 frame", "{name}: {n:,d} frames at {fps:g} fps",
        look.frames, name=look.name, fps=round(look.fps, 2),
    )  # fmt: skip


def fit_bones_to_rectangle(bones: Array, room: QRectF) -> Array:
    """Return the ends of bones in pixels, (bones, 2, 2), so that the figure is centred in a room.

    In `bones`, the second coordinate points up; in the result, it points down.
    """
    points = bones.reshape(-1, 2)
    if not len(points):
        return bones
    low, high = points.min(axis=0), points.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    scale = _FILLS * min(room.width() / size[0], room.height() / size[1])
    middle = np.array([room.center().x(), room.center().y()])
    out: Array = middle + (bones - 0.5 * (low + high)) * np.array([scale, -scale])
    return out
