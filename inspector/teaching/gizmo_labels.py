"""The labels of the gizmo: symbols over the 3D view, typeset like the equations."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import (
    QColor,
    QFont,
    QPaintEngine,
    QPainter,
    QPainterPath,
    QPaintEvent,
    QPen,
    QPixmap,
    QRegion,
)
from PySide6.QtWidgets import QWidget

from inspector.teaching.gizmo_shapes import Mark
from inspector.teaching.symbols import MARKS, symbol_family_colour
from inspector.viewport.camera import OrbitCamera
from inspector.viewport.lights import background
from inspector.widgets.theme import Theme
from inspector.widgets.typeset import EM, Formula, Typesetter
from twistcore.skeleton.rotation import Array

_SIZE = 1.25  # size of a label relative to the font's height
_WORDS = 0.62  # height of words relative to a symbol
_APART = 4.0  # pixels between two labels
_HALO = 2.5  # pixels around the letters of a label
_MOST = 256  # number of cached images; the names of joints differ between rigs
_GAP = 15.0  # pixels from a point to the middle of its label


class Labels(QWidget):
    """Typeset symbols over the 3D view, each near the part of the gizmo that it names."""

    def __init__(self, viewport: QWidget, typesetter: Typesetter) -> None:
        super().__init__(viewport)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self._typesetter = typesetter
        self._placed: list[tuple[Formula, QRectF, str, bool]] = []
        self._pixmaps: dict[tuple[object, ...], QPixmap] = {}
        self.hide()

    def show_marks(
        self,
        marks: list[Mark],
        camera: OrbitCamera,
        picture: QRectF,
        theme: Theme,
        lit: frozenset[str],
        covered: QRectF,
    ) -> None:
        """Place the labels over an image. Overlaps are avoided if there is enough room.

        `covered` is the area of the image that the legend covers. Labels that would extend beyond
        the image are omitted.
        """
        view = self.parentWidget()
        assert view is not None
        if self.geometry() != view.rect():
            self.setGeometry(view.rect())
        self._paper = QColor(*background(theme).round().astype(int).tolist())
        self._scale = _SIZE * self.fontMetrics().height() / EM
        before = self._region()
        self._placed = []
        if not marks or not self._typesetter.done:
            self.hide()
            return
        size = (round(picture.width()), round(picture.height()))
        at, _ = camera.project(np.stack([m.at for m in marks]), *size)
        away, _ = camera.project(np.stack([m.away for m in marks]), *size)
        corner = np.array([picture.left(), picture.top()])
        for mark, here, other in zip(marks, at, away, strict=True):
            formula = self._typesetter.formula(MARKS[mark.symbol].tex)
            if mark.words:
                formula = _written(mark.words, self.font().family())
            if formula is None:
                continue
            way = here - other
            long = float(np.hypot(*way))
            way = way / long if long > 1.0 else np.array([0.7071, -0.7071])
            box = self._free(here + corner, way, formula, picture, covered)
            if box is None:
                continue
            bright = not lit or mark.symbol in lit or (mark.symbol == "real" and "v" in lit)
            ink = symbol_family_colour(MARKS[mark.symbol].family, theme)
            self._placed.append((formula, box, ink, bright))
        self.show()
        self.update(before + self._region())

    def _free(
        self, at: Array, way: Array, formula: Formula, picture: QRectF, covered: QRectF
    ) -> QRectF | None:
        """Return the rectangle near a point that overlaps other labels the least.

        The rectangle is preferably in the direction `way` from the point. It is inside the image
        and not covered by the legend. If there is no such rectangle, return None.
        """
        wide = formula.box.width() * self._scale
        high = formula.box.height() * self._scale
        wanted = np.arctan2(way[1], way[0])
        image = picture.adjusted(_HALO, _HALO, -_HALO, -_HALO)
        best, least = None, np.inf
        for gap in (_GAP, 1.8 * _GAP, 2.6 * _GAP):
            for turn in (0.0, 0.6, -0.6, 1.2, -1.2, 2.0, -2.0, 3.1):
                angle = wanted + turn
                x = at[0] + (gap + 0.3 * wide) * np.cos(angle) - 0.5 * wide
                y = at[1] + gap * np.sin(angle) - 0.5 * high
                box = QRectF(x, y, wide, high)
                room = box.adjusted(-_APART, -_APART, _APART, _APART)
                if not image.contains(box) or room.intersects(covered):
                    continue
                common = [room.intersected(other) for _, other, _, _ in self._placed]
                overlap = sum(shared.width() * shared.height() for shared in common)
                if overlap < least:
                    best, least = box, overlap
                if not overlap:
                    return best
        return best

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw every label at its position."""
        painter = QPainter(self)
        engine = painter.paintEngine()
        printed = engine is not None and engine.type() == QPaintEngine.Type.User
        for formula, box, ink, bright in self._placed:
            if printed:  # outlines, for vector graphics
                painter.save()
                painter.translate(box.topLeft())
                self._draw(painter, formula, ink, bright)
                painter.restore()
            else:
                corner = box.topLeft() - QPointF(_HALO, _HALO)
                painter.drawPixmap(corner, self._drawn(formula, ink, bright))

    def _draw(self, painter: QPainter, formula: Formula, ink: str, bright: bool) -> None:
        """Draw a label with a halo in the background colour."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.scale(self._scale, self._scale)
        painter.translate(-formula.box.topLeft())
        painter.setOpacity(1.0 if bright else 0.3)
        halo = QPen(self._paper, 2.0 * _HALO / self._scale)
        halo.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.strokePath(formula.path, halo)
        painter.fillPath(formula.path, QColor(ink))

    def _drawn(self, formula: Formula, ink: str, bright: bool) -> QPixmap:
        """Return an image of a label. Images are cached."""
        ratio = self.devicePixelRatioF()
        key = (formula, ink, bright, self._scale, self._paper.rgb(), ratio)
        if key not in self._pixmaps:
            size = formula.box.size() * self._scale + QSizeF(2.0 * _HALO, 2.0 * _HALO)
            pixmap = QPixmap((size * ratio).toSize() + QSize(1, 1))
            pixmap.setDevicePixelRatio(ratio)
            pixmap.fill(Qt.GlobalColor.transparent)
            painter = QPainter(pixmap)
            painter.translate(_HALO, _HALO)
            self._draw(painter, formula, ink, bright)
            painter.end()
            if len(self._pixmaps) >= _MOST:
                self._pixmaps.clear()
            self._pixmaps[key] = pixmap
        return self._pixmaps[key]

    def _region(self) -> QRegion:
        """Return the region of the 3D view that the labels cover."""
        region = QRegion()
        for _, box, _, _ in self._placed:
            region += box.adjusted(-_HALO, -_HALO, _HALO, _HALO).toAlignedRect()
        return region


@lru_cache(maxsize=64)
def _written(words: str, family: str) -> Formula:
    """Return a plain text as a formula that can be drawn like a typeset symbol."""
    font = QFont(family)
    font.setPixelSize(round(_WORDS * EM))
    path = QPainterPath()
    path.addText(0.0, 0.0, font, words)
    return Formula(path, path.boundingRect())
