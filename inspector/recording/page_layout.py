"""Arrange figure, curves and equations in a picture or a film."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSizeF

from inspector.recording.choice import Contents

WIDE = 620.0  # if the page is at least this wide, the equations are next to the figure
_CURVES_SHARE = 0.42  # share of the page's height for the curves below a figure
# Height divided by width of the figure, in a wide page and in a narrow page
_VIEW_SHAPE = {True: 0.46, False: 0.72}
_GAP = 2.0


def part_rectangles(
    page: QSizeF, contents: Contents, wanted: QSizeF, curves: float = 0.0
) -> dict[str, QRectF]:
    """Return the rectangles of 'view', 'curves' and 'equations' on a page.

    Parameters
    ----------
    page
        The size of the page.
    contents
        The parts to arrange.
    wanted
        The natural size of the equations. They may become smaller, but not larger, and their aspect
        ratio does not change.
    curves
        The height of the curves below a figure, or 0 for the default share of the page.
    """
    wide, high = page.width(), page.height()
    beside = contents.view and contents.equations and wide >= WIDE
    if contents.equations and not beside:
        others = contents.view or contents.curves
        room = _fitted(wanted, wide, 0.5 * high if others else high)
        top = high - room.height() if others else 0.0
        out = {"equations": QRectF(QPointF(0.0, top), room)}
        rest = Contents(contents.view, contents.curves, equations=False)
        return out | (part_rectangles(QSizeF(wide, top), rest, wanted, curves) if others else {})
    out, left = {}, wide
    top = round(high - (curves or _CURVES_SHARE * high)) if contents.curves else high
    if not contents.view:
        top = 0.0
    if beside:
        room = _fitted(wanted, 0.5 * wide, top)
        left = float(int(wide - room.width()))
        out["equations"] = QRectF(QPointF(left, 0.5 * (top - room.height())), room)
    if contents.view:
        out["view"] = QRectF(0.0, 0.0, left, top)
    if contents.curves:
        start = top + _GAP if top else 0.0
        out["curves"] = QRectF(0.0, start, wide, high - start)
    return out


def natural_height(width: float, contents: Contents, wanted: QSizeF) -> float:
    """Return the height that the figure and the equations need on a page of this width.

    On a wide page, the equations are next to the figure; on a narrow page, they are below it.
    """
    wide = width >= WIDE
    view = _VIEW_SHAPE[wide] * width if contents.view else 0.0
    if not contents.equations:
        return view
    beside = wide and contents.view
    room = _fitted(wanted, 0.5 * width if beside else width, wanted.height()).height()
    return max(view, room) if beside else view + room


def _fitted(wanted: QSizeF, wide: float, high: float) -> QSizeF:
    """Return the size `wanted`, reduced if necessary to fit into `wide` × `high`.

    The aspect ratio does not change.
    """
    return wanted * min(1.0, wide / wanted.width(), high / wanted.height())
