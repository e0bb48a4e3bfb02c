"""Write a sheet as an SVG that looks the same in all readers.

Apart from images, the SVG contains only paths, all in the same coordinate system. Text is stored as
outlines, so readers do not need the fonts; `aria-label` contains the text.
"""

from __future__ import annotations

import re
from base64 import b64encode
from errno import EFBIG
from html import escape

from PySide6.QtCore import QBuffer, QIODevice, Qt
from PySide6.QtGui import QColor, QImage, QPainterPath, QPen

from inspector.language import tr
from inspector.recording.sheet import Item, Sheet, SheetShape, Words
from twistcore.files.encoding import encode_utf8

_CAPS = {
    Qt.PenCapStyle.FlatCap: "butt",
    Qt.PenCapStyle.SquareCap: "square",
    Qt.PenCapStyle.RoundCap: "round",
}
_JOINS = {
    Qt.PenJoinStyle.MiterJoin: "miter",
    Qt.PenJoinStyle.SvgMiterJoin: "miter",
    Qt.PenJoinStyle.BevelJoin: "bevel",
    Qt.PenJoinStyle.RoundJoin: "round",
}
_NOT_IN_XML = re.compile(r"[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]")
_CURVE = QPainterPath.ElementType.CurveToElement
_MOVE = QPainterPath.ElementType.MoveToElement


def svg_of(sheet: Sheet, title: str, width_mm: float, height_mm: float) -> bytes:
    """Return a sheet as an SVG file whose size on paper is `width_mm` × `height_mm`."""
    clips: dict[str, str] = {}
    body = [_element(item, clips) for item in sheet.items]
    cuts = [f'<clipPath id="{name}"><path d="{d}"/></clipPath>' for d, name in clips.items()]
    box = f"0 0 {_number(sheet.box.width())} {_number(sheet.box.height())}"
    head = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
        f'width="{_number(width_mm)}mm" height="{_number(height_mm)}mm" viewBox="{box}">'
    )
    parts = head, f"<title>{_text(title)}</title>", "<defs>", *cuts, "</defs>", *body, "</svg>\n"
    return encode_utf8("\n".join(parts))


def _element(item: Item, clips: dict[str, str]) -> str:
    cut = ""
    if item.clip is not None:
        name = clips.setdefault(_path(item.clip), f"clip{len(clips)}")
        cut = f' clip-path="url(#{name})"'
    if isinstance(item, SheetShape):
        rule = ' fill-rule="evenodd"' if item.path.fillRule() == Qt.FillRule.OddEvenFill else ""
        ink = _paint("fill", item.ink) + rule if item.ink is not None else ' fill="none"'
        return f'<path d="{_path(item.path)}"{ink}{_stroke(item.pen)}{cut}/>'
    if isinstance(item, Words):
        label = _text(item.text.strip())
        d = _path(item.outline())
        return f'<path aria-label="{label}" d="{d}"{_paint("fill", item.ink)}{cut}/>'
    box = item.box
    places = (("x", box.x()), ("y", box.y()), ("width", box.width()), ("height", box.height()))
    where = " ".join(f'{name}="{_number(value)}"' for name, value in places)
    return (
        f'<image {where} preserveAspectRatio="none"{cut} '
        f'xlink:href="data:image/png;base64,{b64encode(png_of(item.image)).decode()}"/>'
    )


def _text(text: str) -> str:
    """Return a text escaped for XML, without the control characters that XML forbids."""
    return escape(_NOT_IN_XML.sub("", text), quote=True)


def _stroke(pen: QPen | None) -> str:
    if pen is None:
        return ""
    wide = pen.widthF()
    out = f'{_paint("stroke", pen.color())} stroke-width="{_number(wide)}"'
    out += f' stroke-linecap="{_CAPS[pen.capStyle()]}" stroke-linejoin="{_JOINS[pen.joinStyle()]}"'
    if pen.style() != Qt.PenStyle.SolidLine:
        dashes = " ".join(_number(part * wide) for part in pen.dashPattern())
        out += f' stroke-dasharray="{dashes}"'
        if pen.dashOffset():
            out += f' stroke-dashoffset="{_number(pen.dashOffset() * wide)}"'
    return out


def _paint(what: str, colour: QColor) -> str:
    through = f' {what}-opacity="{_number(colour.alphaF())}"' if colour.alpha() < 255 else ""
    return f' {what}="{colour.name()}"{through}'


def _path(path: QPainterPath) -> str:
    """Return a path in SVG syntax: moves, lines and cubic curves."""
    out: list[str] = []
    for k in range(path.elementCount()):
        element = path.elementAt(k)
        kind, place = element.type, f"{_number(element.x)} {_number(element.y)}"
        if kind == _MOVE:
            out.append(f"M{place}")
        elif kind == _CURVE:
            out.append(f"C{place}")
        else:
            out.append(f"L{place}" if kind == QPainterPath.ElementType.LineToElement else place)
    return " ".join(out)


def _number(value: float) -> str:
    """Return a number as text with at most two decimals; 0.01 units are 3 µm on paper."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def png_of(image: QImage) -> bytes:
    """Return an image as a PNG. Raises OSError if it is too large for Qt."""
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    if not image.save(buffer, "PNG"):  # type: ignore[call-overload]  # the stub wants bytes
        raise OSError(EFBIG, tr("the image is too large for a PNG"))
    return bytes(buffer.data().data())
