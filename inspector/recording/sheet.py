"""A paint device that stores lines, text and images for output in any format.

Qt's own SVG writer ignores clipping, and for cosmetic pens it writes a property that librsvg and
other programs ignore. Therefore, the sheet converts everything to its own units, including line
widths and clipping.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from PySide6.QtCore import QLine, QLineF, QPointF, QRect, QRectF, Qt
from PySide6.QtGui import (
    QColor,
    QFont,
    QImage,
    QPaintDevice,
    QPaintEngine,
    QPaintEngineState,
    QPainter,
    QPainterPath,
    QPen,
    QPixmap,
    QPolygonF,
    QTextItem,
    QTransform,
)

from inspector.recording.cutting import cut_lines, is_straight, upright_rectangle

_HATCH = 8.0  # units between two stripes, as in Qt's fill patterns

_Box = QRect | QRectF


@dataclass(frozen=True, eq=False)
class SheetShape:
    """A shape in the units of the sheet.

    Attributes
    ----------
    ink
        The colour of the area, or None for no fill.
    pen
        The pen of the outline, or None for no outline.
    clip
        The area to which the shape is clipped, or None.
    smooth
        True to draw smooth edges (anti-aliasing).
    """

    path: QPainterPath
    ink: QColor | None
    pen: QPen | None
    clip: QPainterPath | None
    smooth: bool


@dataclass(frozen=True, eq=False)
class Words:
    """A text on the sheet.

    Attributes
    ----------
    at
        The position, in the text's own coordinates.
    places
        The transformation from these coordinates to the units of the sheet.
    clip
        The area to which the text is clipped, or None.
    """

    text: str
    font: QFont
    at: QPointF
    places: QTransform
    ink: QColor
    clip: QPainterPath | None

    def outline(self) -> QPainterPath:
        """Return the outlines of the text in the units of the sheet."""
        path = QPainterPath()
        path.addText(self.at, self.font, self.text)
        return self.places.map(path)


@dataclass(frozen=True, eq=False)
class SheetPicture:
    """An image in the rectangle `box` of the sheet."""

    image: QImage
    box: QRectF
    clip: QPainterPath | None


Item = SheetShape | Words | SheetPicture


class Sheet(QPaintDevice):
    """A paint device of `width` × `height` units, with `density` units per inch."""

    def __init__(self, width: float, height: float, density: int) -> None:
        super().__init__()
        self.box = QRectF(0.0, 0.0, width, height)
        self.density = density
        self._engine = _Keeper()

    @property
    def items(self) -> Sequence[Item]:
        """All items painted so far, from back to front."""
        return self._engine.items

    def paintEngine(self) -> QPaintEngine:
        """Return the engine that stores everything that is painted on the sheet."""
        return self._engine

    def metric(self, which: QPaintDevice.PaintDeviceMetric) -> int:
        """Return the property of the device that Qt asks for, such as its width."""
        metric = QPaintDevice.PaintDeviceMetric
        inches = {
            metric.PdmWidthMM: self.box.width() / self.density,
            metric.PdmHeightMM: self.box.height() / self.density,
        }
        if which in inches:
            return round(25.4 * inches[which])
        return {
            metric.PdmWidth: math.ceil(self.box.width()),
            metric.PdmHeight: math.ceil(self.box.height()),
            metric.PdmDpiX: self.density,
            metric.PdmDpiY: self.density,
            metric.PdmPhysicalDpiX: self.density,
            metric.PdmPhysicalDpiY: self.density,
            metric.PdmNumColors: 1 << 24,
            metric.PdmDepth: 32,
            metric.PdmDevicePixelRatio: 1,
            metric.PdmDevicePixelRatioScaled: int(QPaintDevice.devicePixelRatioFScale()),
        }.get(which, 0)

    def paint(self, painter: QPainter) -> None:
        """Paint the contents of the sheet with the painter of another device.

        At one unit per pixel, edges are as sharp as in a window; at other scales, they are
        anti-aliased.
        """
        hint = QPainter.RenderHint
        exact = math.isclose(painter.worldTransform().m11(), 1.0, rel_tol=1e-6)
        for item in self.items:
            painter.save()
            if item.clip is not None:
                painter.setClipPath(item.clip)
            if isinstance(item, SheetShape):
                painter.setRenderHint(hint.Antialiasing, item.smooth or not exact)
                painter.setPen(item.pen if item.pen is not None else Qt.PenStyle.NoPen)
                painter.setBrush(item.ink if item.ink is not None else Qt.BrushStyle.NoBrush)
                painter.drawPath(item.path)
            elif isinstance(item, Words):
                painter.setRenderHint(hint.TextAntialiasing)
                painter.setWorldTransform(item.places, True)
                painter.setFont(item.font)
                painter.setPen(item.ink)
                painter.drawText(item.at, item.text)
            else:
                painter.setRenderHints(hint.SmoothPixmapTransform | hint.LosslessImageRendering)
                painter.drawImage(item.box, item.image)
            painter.restore()


class _Keeper(QPaintEngine):
    """A paint engine that stores everything that is drawn, in the units of the sheet."""

    def __init__(self) -> None:
        feature = QPaintEngine.PaintEngineFeature
        super().__init__(
            feature.PainterPaths
            | feature.PrimitiveTransform
            | feature.PixmapTransform
            | feature.PatternBrush
            | feature.AlphaBlend
            | feature.ConstantOpacity
            | feature.Antialiasing
        )
        self.items: list[Item] = []
        self._places = QTransform()
        self._pen, self._brush = QPen(), QPen().brush()
        self._clip: QPainterPath | None = None
        self._opacity, self._smooth = 1.0, False

    # -- called by Qt -------------------------------------------------------------------------

    def begin(self, device: QPaintDevice) -> bool:
        """Accept any painter."""
        return True

    def end(self) -> bool:
        """Report success at the end of painting."""
        return True

    def type(self) -> QPaintEngine.Type:
        """Return the type for custom paint engines."""
        return QPaintEngine.Type.User

    def updateState(self, state: QPaintEngineState) -> None:
        """Store the pen, the brush, the clip and the transformation for the next shapes."""
        dirty, changed = QPaintEngine.DirtyFlag, state.state()
        self._places = QTransform(state.transform())
        self._pen, self._brush = QPen(state.pen()), state.brush()
        self._opacity = state.opacity()
        self._smooth = bool(state.renderHints() & QPainter.RenderHint.Antialiasing)
        if changed & dirty.DirtyClipPath:
            self._cut(state.clipPath(), state.clipOperation())
        elif changed & dirty.DirtyClipRegion:
            path = QPainterPath()
            path.addRegion(state.clipRegion())
            self._cut(path, state.clipOperation())
        elif changed & dirty.DirtyClipEnabled and not state.isClipEnabled():
            self._clip = None

    def drawPath(self, path: QPainterPath) -> None:
        """Store a path with its fill and its outline."""
        self._add(path, self._brush.style() != Qt.BrushStyle.NoBrush)

    def drawPolygon(self, points: Any, mode: Any = None) -> None:
        """Store a polygon or polyline. A polyline is not filled."""
        corners = QPolygonF([QPointF(p) for p in points])
        path = QPainterPath()
        path.addPolygon(corners)
        line = mode == QPaintEngine.PolygonDrawMode.PolylineMode
        if not line:
            path.closeSubpath()
        if mode == QPaintEngine.PolygonDrawMode.WindingMode:
            path.setFillRule(Qt.FillRule.WindingFill)
        self._add(path, not line)

    def drawLines(self, lines: Sequence[QLine | QLineF]) -> None:  # type: ignore[override]
        """Store lines."""
        for line in lines:
            path = QPainterPath(QPointF(line.p1()))
            path.lineTo(QPointF(line.p2()))
            self._add(path, False)

    def drawRects(self, rects: Sequence[QRect | QRectF]) -> None:  # type: ignore[override]
        """Store rectangles."""
        for rect in rects:
            path = QPainterPath()
            path.addRect(QRectF(rect))
            self._forget_below(QRectF(rect))
            self._add(path, True)

    def drawEllipse(self, rect: QRect | QRectF) -> None:
        """Store an ellipse as a path."""
        path = QPainterPath()
        path.addEllipse(QRectF(rect))
        self._add(path, True)

    def drawTextItem(self, at: Any, item: QTextItem) -> None:
        """Store a text."""
        if item.text().strip():
            ink = self._faded(self._pen.color())
            font = _complete_font(item.font())
            words = Words(item.text(), font, QPointF(at), self._places, ink, None)
            box = words.outline().boundingRect()
            clip = self._clip_of(box)
            self.items.append(Words(words.text, words.font, words.at, words.places, ink, clip))

    def drawPixmap(self, box: _Box, pixmap: QPixmap | QImage, part: _Box) -> None:
        """Store a pixmap as an image."""
        self.drawImage(box, pixmap if isinstance(pixmap, QImage) else pixmap.toImage(), part)

    def drawImage(
        self, box: _Box, image: QImage, part: _Box, flags: Qt.ImageConversionFlag | None = None
    ) -> None:
        """Store a part of an image in a box."""
        inside, there = image.copy(QRectF(part).toAlignedRect()), self._places.mapRect(QRectF(box))
        self.items.append(SheetPicture(inside, there, self._clip_of(there)))

    # -- storing ------------------------------------------------------------------------------

    def _add(self, path: QPainterPath, filled: bool) -> None:
        path = self._places.map(path)
        brush, pen = self._brush, self._wide_pen()
        wide = 0.5 * pen.widthF() if pen is not None else 0.0
        clip = self._clip_of(path.boundingRect().adjusted(-wide, -wide, wide, wide))
        if filled and brush.style() != Qt.BrushStyle.NoBrush:
            ink = self._faded(brush.color())
            if brush.style() != Qt.BrushStyle.SolidPattern:
                self._draw_lines(*_stripes(path, ink), path.intersected(clip) if clip else path)
            elif clip is None:
                self.items.append(SheetShape(path, ink, pen, None, self._smooth))
                return
            else:
                self.items.append(SheetShape(path.intersected(clip), ink, None, None, self._smooth))
        if pen is not None:
            self._draw_lines(path, pen, clip)

    def _draw_lines(self, path: QPainterPath, pen: QPen, clip: QPainterPath | None) -> None:
        """Store lines. They are cut at a rectangular clip, because some readers ignore clips."""
        box = upright_rectangle(clip) if clip is not None else None
        if box is not None and is_straight(path):
            path, clip = cut_lines(path, box), None
        if not path.isEmpty():
            self.items.append(SheetShape(path, None, pen, clip, self._smooth))

    def _forget_below(self, rect: QRectF) -> None:
        """Remove the latest shapes if a rectangle covers them, because their edges might show.

        For example, a plot paints its background over the background that Qt has painted.
        """
        solid = self._brush.style() == Qt.BrushStyle.SolidPattern
        if not solid or self._faded(self._brush.color()).alpha() < 255:
            return
        box = self._places.mapRect(rect)
        if self._clip_of(box) is not None:
            return
        while self.items and isinstance(last := self.items[-1], SheetShape):
            if last.pen is not None or not box.contains(last.path.boundingRect()):
                return
            self.items.pop()

    def _wide_pen(self) -> QPen | None:
        """Return the pen with its width in units of the sheet, or None if no line is drawn."""
        if self._pen.style() == Qt.PenStyle.NoPen:
            return None
        pen = QPen(self._pen)
        width = pen.widthF() or 1.0
        if not pen.isCosmetic():
            width *= math.sqrt(abs(self._places.determinant()))
        pen.setCosmetic(False)
        pen.setWidthF(width)
        pen.setColor(self._faded(pen.color()))
        return pen

    def _faded(self, colour: QColor) -> QColor:
        """Return a colour with the painter's opacity applied."""
        faded = QColor(colour)
        faded.setAlphaF(colour.alphaF() * self._opacity)
        return faded

    def _cut(self, path: QPainterPath, how: Qt.ClipOperation) -> None:
        there = self._places.map(path)
        if how == Qt.ClipOperation.NoClip:
            self._clip = None
        elif how == Qt.ClipOperation.ReplaceClip or self._clip is None:
            self._clip = there
        else:
            self._clip = self._clip.intersected(there)

    def _clip_of(self, box: QRectF) -> QPainterPath | None:
        """Return the clip for a shape in this box, or None if the whole box is inside the clip."""
        clip = self._clip
        window = self.systemClip()  # the clip of the painted widget, in whole units
        near = QRectF(window.boundingRect()).adjusted(-1.0, -1.0, 1.0, 1.0)
        if not window.isEmpty() and (window.rectCount() > 1 or not near.contains(box)):
            edges = QPainterPath()
            edges.addRegion(window)
            clip = edges if clip is None else clip.intersected(edges)
        return None if clip is None or _contains(clip, box) else clip


def _contains(clip: QPainterPath, box: QRectF) -> bool:
    """Return True if a box is inside a clip. Unlike Qt's test, this allows coinciding edges."""
    edges = upright_rectangle(clip)
    return edges.contains(box) if edges is not None else clip.contains(box)


def _complete_font(font: QFont) -> QFont:
    """Return a copy of a font with all attributes set, independent of the paint device."""
    whole = QFont(font)
    whole.setFamilies(font.families())
    whole.setStyleHint(font.styleHint())
    whole.setPointSizeF(font.pointSizeF())
    whole.setWeight(font.weight())
    whole.setStyle(font.style())
    return whole


def _stripes(path: QPainterPath, ink: QColor) -> tuple[QPainterPath, QPen]:
    """Return diagonal lines across a shape, as a replacement for Qt's fill patterns."""
    box, lines = path.boundingRect(), QPainterPath()
    count = math.ceil((box.width() + box.height()) / _HATCH)
    first = math.floor((box.left() + box.top()) / _HATCH) * _HATCH
    for k in range(count + 2):
        total = first + k * _HATCH  # x + y of all points of the stripe
        lines.moveTo(total - box.top(), box.top())
        lines.lineTo(total - box.bottom(), box.bottom())
    pen = QPen(ink, 1.0)
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    return lines, pen
