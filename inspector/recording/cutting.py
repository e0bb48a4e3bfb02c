"""Cut lines at the edges of a rectangle, because some SVG readers ignore clip paths."""

from __future__ import annotations

from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtGui import QPainterPath

_CORNERS = 5  # points of a rectangle's outline; the last one repeats the first
_LINE = QPainterPath.ElementType.LineToElement
_CURVE = QPainterPath.ElementType.CurveToElement


def upright_rectangle(path: QPainterPath) -> QRectF | None:
    """Return the rectangle that a path describes, or None if the path is not a rectangle.

    The edges of the rectangle must be parallel to the axes.
    """
    box = path.boundingRect()
    places = [path.elementAt(k) for k in range(path.elementCount())]
    edges = {box.left(), box.right()}, {box.top(), box.bottom()}
    level = all(place.x in edges[0] and place.y in edges[1] for place in places)
    return box if len(places) == _CORNERS and level else None


def is_straight(path: QPainterPath) -> bool:
    """Return True if a path consists only of straight lines."""
    return all(path.elementAt(k).type != _CURVE for k in range(path.elementCount()))


def cut_lines(path: QPainterPath, box: QRectF) -> QPainterPath:
    """Return the part of a path inside a box. The path must consist of straight lines."""
    out, here, end = QPainterPath(), QPointF(), None
    for k in range(path.elementCount()):
        element = path.elementAt(k)
        there = QPointF(element.x, element.y)
        if element.type == _LINE and (part := _inside(QLineF(here, there), box)) is not None:
            if end != part.p1():
                out.moveTo(part.p1())
            out.lineTo(part.p2())
            end = part.p2()
        elif element.type != _LINE:
            end = None
        here = there
    return out


def _inside(line: QLineF, box: QRectF) -> QLineF | None:
    """Return the part of a line inside a box, or None if the line is outside."""
    first, last = 0.0, 1.0
    for start, step, low, high in (
        (line.x1(), line.dx(), box.left(), box.right()),
        (line.y1(), line.dy(), box.top(), box.bottom()),
    ):
        if step == 0.0:
            if not low <= start <= high:
                return None
            continue
        ends = sorted(((low - start) / step, (high - start) / step))
        first, last = max(first, ends[0]), min(last, ends[1])
    if first > last:
        return None
    # Ends inside the box are used unchanged, so that connected lines stay connected.
    begin = line.pointAt(first) if first > 0.0 else line.p1()
    return QLineF(begin, line.pointAt(last) if last < 1.0 else line.p2())
