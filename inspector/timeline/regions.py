"""Compute the pixel regions of intervals once for all plots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QBrush, QColor, QFont, QPainter, QPainterPath, QPen

from inspector.widgets.theme import Theme, blend_colour_over_paper
from twistcore.review import Decision, Judged
from twistcore.skeleton.rotation import Array

_CROWDED = 4  # with fewer pixels per region, borders and symbols are omitted
_GLYPH_ROOM = 11  # pixels that a symbol needs
LEAST = 8  # minimum width of a region in pixels, so that the mouse can grab it
_GLYPHS = {Decision.ACCEPTED: "✓", Decision.REJECTED: "✗", Decision.UNDECIDED: "?"}
_BORDERS = {
    Decision.ACCEPTED: Qt.PenStyle.SolidLine,
    Decision.REJECTED: Qt.PenStyle.DotLine,
    Decision.UNDECIDED: Qt.PenStyle.DashLine,
}

_Spans = list[list[int]]  # pairs of a left and a right pixel


@dataclass(frozen=True)
class _Group:
    """The regions of all intervals with the same decision.

    Attributes
    ----------
    covered
        The union of the regions.
    each
        The regions one by one, or an empty list if there are too many to draw.
    """

    decision: Decision
    selected: bool
    covered: _Spans
    each: _Spans  # empty if there are too many to draw


class Regions:
    """The pixel regions of the intervals in a range of frames, for plots of any height.

    Parameters
    ----------
    seen
        The intervals in the range of frames.
    selected
        The id of the interval to emphasise, or None.
    first, last
        The range of frames.
    width
        The width of the plot in pixels.
    """

    def __init__(
        self, seen: Sequence[Judged], selected: int | None, first: float, last: float, width: int
    ) -> None:
        self._width = width
        crowded = len(seen) * _CROWDED > width
        self._groups: list[_Group] = []
        for strong in (False, True):
            for decision in Decision:
                chosen = [
                    j for j in seen if j.decision == decision and (j.id == selected) == strong
                ]
                if chosen:
                    each = _places(chosen, first, last, width)
                    covered = _united(each, width)
                    hidden = crowded and not strong
                    self._groups.append(_Group(decision, strong, covered, [] if hidden else each))
        self._height = 0
        self._shapes: list[tuple[_Group, list[QRect], QPainterPath]] = []

    def paint(self, painter: QPainter, theme: Theme, height: int, glyphs: QFont | None) -> None:
        """Paint the fills and borders and, if `glyphs` is a font, the symbols of decisions."""
        painter.setClipRect(QRect(0, 0, self._width, height))
        for group, rects, lines in self._shapes_of(height):
            _paint_group(painter, theme, group, rects, lines, self._width, height)
            if glyphs is not None:
                painter.setFont(glyphs)
                for left, right in group.each:
                    if right - left >= _GLYPH_ROOM:
                        box = QRect(left, 0, right - left, painter.fontMetrics().height())
                        sign = _GLYPHS[group.decision]
                        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, sign)

    def _shapes_of(self, height: int) -> list[tuple[_Group, list[QRect], QPainterPath]]:
        """Return the fills and borders for a plot of the given height or less.

        The shapes are computed for the highest plot. Lower plots clip them.
        """
        if height > self._height:
            self._height = height
            self._shapes = [
                (
                    group,
                    [QRect(left, 0, right - left, height) for left, right in group.covered],
                    _uprights(_inside(group.each, self._width), height),
                )
                for group in self._groups
            ]
        return self._shapes


def _paint_group(
    painter: QPainter,
    theme: Theme,
    group: _Group,
    rects: list[QRect],
    lines: QPainterPath,
    width: int,
    height: int,
) -> None:
    name = getattr(theme, str(group.decision))
    rejected = group.decision == Decision.REJECTED
    strong = group.selected
    share = (46 if strong else 14) if rejected else (68 if strong else 34)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(blend_colour_over_paper(name, theme.surface, share))
    painter.drawRects(rects)
    if rejected and group.each:
        stripes = blend_colour_over_paper(name, theme.surface, 150 if strong else 90)
        painter.setBrush(QBrush(stripes, Qt.BrushStyle.BDiagPattern))
        painter.drawRects(rects)
    pen = QPen(QColor(name), 2.0 if strong else 1.0, _BORDERS[group.decision])
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawPath(lines)
    if strong:
        for x in _inside(group.each, width):
            painter.fillRect(QRect(x - 2, height // 2 - 9, 5, 18), QColor(name))


def _places(regions: Sequence[Judged], first: float, last: float, width: int) -> _Spans:
    """Return the left and right pixel of each region, clipped to the view.

    Without this clipping, painting would be slow, because Qt would clip at fractions of pixels.
    """
    frames = np.array([(j.interval.start, j.interval.stop) for j in regions]) - 0.5
    if len(regions) * 2 * LEAST < width:  # if there are many regions, do not widen them
        frames = widen_narrow_spans(frames, (last - first) / max(width, 1))
    places = np.rint((frames - first) / (last - first) * width).astype(np.int64)
    places[:, 1] = np.maximum(places[:, 1], places[:, 0] + 2)
    pairs: _Spans = np.clip(places, 0, width).tolist()
    return pairs


def widen_narrow_spans(spans: Array, pixel: float) -> Array:
    """Return spans of frames, (n, 2), widened to at least LEAST pixels.

    `pixel` is the number of frames per pixel.
    """
    spare = 0.5 * np.maximum(LEAST * pixel - (spans[:, 1] - spans[:, 0]), 0.0)
    return np.stack([spans[:, 0] - spare, spans[:, 1] + spare], axis=1)


def _inside(places: _Spans, width: int) -> list[int]:
    """Return the borders of the regions that are inside the view, in pixels."""
    return [x for pair in places for x in pair if 0 < x < width - 1]


def _uprights(at: Sequence[int], height: int) -> QPainterPath:
    """Return vertical lines at the pixels `at` as a single path, which is fast to paint."""
    x = np.repeat(np.array(at, dtype=np.float64), 2)
    path: QPainterPath = pg.arrayToQPath(x, np.tile([0.0, float(height)], len(at)), connect="pairs")
    return path


def _united(places: _Spans, width: int) -> _Spans:
    """Return the union of the regions as pixel spans."""
    steps = np.zeros(width + 2, dtype=np.int64)
    starts, ends = np.array(places).T
    np.add.at(steps, starts, 1)
    np.add.at(steps, ends, -1)
    covered = np.concatenate([[False], np.cumsum(steps)[:-1] > 0, [False]])
    spans: _Spans = np.flatnonzero(np.diff(covered)).reshape(-1, 2).tolist()
    return spans
