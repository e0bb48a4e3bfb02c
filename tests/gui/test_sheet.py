"""What figures of every format are made from: lines, shapes and words on a sheet."""

from xml.etree import ElementTree

import pytest
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFont, QImage, QPainter, QPainterPath, QPen
from PySide6.QtSvg import QSvgRenderer

from inspector.recording.cutting import cut_lines
from inspector.recording.sheet import Sheet
from inspector.recording.svg_file import svg_of

SVG = "{http://www.w3.org/2000/svg}"

pytestmark = pytest.mark.usefixtures("qapp")  # fonts need one


# -- what every format is made from ---------------------------------------------------------------


def on_a_sheet(paint):
    sheet = Sheet(200.0, 100.0, 96)
    painter = QPainter(sheet)
    paint(painter)
    painter.end()
    return sheet.items


def test_a_pen_of_constant_width_keeps_it_in_the_sheets_units():
    def paint(painter):
        pen = QPen(QColor("red"), 1.6)
        pen.setCosmetic(True)
        painter.scale(1.2, 11.0)  # pixels a frame, pixels a root of a degree
        painter.setPen(pen)
        painter.drawLine(QPointF(0.0, 3.0), QPointF(100.0, 3.0))

    (line,) = on_a_sheet(paint)
    assert line.pen.widthF() == 1.6
    assert not line.pen.isCosmetic()
    assert line.path.boundingRect() == QRectF(0.0, 33.0, 120.0, 0.0)


def test_other_pens_are_scaled_with_what_they_draw():
    def paint(painter):
        painter.scale(3.0, 3.0)
        painter.setPen(QPen(QColor("red"), 2.0))
        painter.drawRect(QRectF(1.0, 1.0, 5.0, 5.0))

    (box,) = on_a_sheet(paint)
    assert box.pen.widthF() == pytest.approx(6.0)


def test_a_clip_stays_where_it_was_set():
    def paint(painter):
        painter.translate(50.0, 10.0)
        painter.setClipRect(QRectF(0.0, 0.0, 20.0, 20.0))
        painter.drawLine(2, 5, 10, 5)  # all inside: no clip
        painter.drawLine(0, 5, 90, 5)
        painter.setClipRect(QRectF(5.0, 5.0, 90.0, 5.0), Qt.ClipOperation.IntersectClip)
        painter.translate(500.0, 0.0)
        painter.drawLine(-500, 5, 90, 5)
        painter.setClipping(False)
        painter.drawLine(0, 5, 90, 5)

    inside, cut, twice, free = on_a_sheet(paint)
    assert inside.path.boundingRect() == QRectF(52.0, 15.0, 8.0, 0.0)
    assert cut.path.boundingRect() == QRectF(50.0, 15.0, 20.0, 0.0)
    assert twice.path.boundingRect() == QRectF(55.0, 15.0, 15.0, 0.0)
    assert free.path.boundingRect() == QRectF(550.0, 15.0, 90.0, 0.0)
    assert [line.clip for line in (inside, cut, twice, free)] == [None] * 4


def test_a_line_is_cut_where_it_leaves_and_goes_on_where_it_comes_back():
    points = [(0, 5), (5, 5), (5, 25), (15, 25), (15, 5), (20, 5)]
    path = QPainterPath(QPointF(*points[0]))
    for point in points[1:]:
        path.lineTo(QPointF(*point))
    path.moveTo(0.0, 100.0)
    path.lineTo(20.0, 100.0)
    cut = cut_lines(path, QRectF(0.0, 0.0, 18.0, 20.0))
    places = [cut.elementAt(k) for k in range(cut.elementCount())]
    assert [(e.x, e.y) for e in places] == [(0, 5), (5, 5), (5, 20), (15, 20), (15, 5), (18, 5)]
    assert [k for k, e in enumerate(places) if e.isMoveTo()] == [0, 3]


def test_a_shape_is_cut_and_what_is_round_keeps_its_clip():
    def paint(painter):
        painter.setClipRect(QRectF(0.0, 0.0, 20.0, 20.0))
        painter.fillRect(QRectF(10.0, 10.0, 50.0, 50.0), QColor("red"))
        painter.drawEllipse(QRectF(10.0, 10.0, 50.0, 50.0))

    square, ring = on_a_sheet(paint)
    assert square.path.boundingRect() == QRectF(10.0, 10.0, 10.0, 10.0)
    assert square.clip is None
    assert ring.clip.boundingRect() == QRectF(0.0, 0.0, 20.0, 20.0)


def test_a_ground_below_another_is_left_out_and_no_line_is():
    def paint(painter):
        painter.fillRect(QRectF(0.0, 0.0, 50.0, 50.0), QColor("black"))
        painter.fillRect(QRectF(0.0, 0.0, 50.0, 50.0), QColor("white"))
        painter.drawLine(0, 0, 10, 10)
        painter.fillRect(QRectF(0.0, 0.0, 50.0, 50.0), QColor(255, 255, 255, 100))

    ground, line, veil = on_a_sheet(paint)
    assert ground.ink == QColor("white")
    assert line.pen is not None
    assert veil.ink.alpha() == 100


def test_stripes_are_lines_inside_their_shape():
    def paint(painter):
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(Qt.BrushStyle.BDiagPattern)
        painter.drawRect(QRectF(10.0, 10.0, 40.0, 30.0))

    (stripes,) = on_a_sheet(paint)
    assert stripes.pen.widthF() == 1.0
    assert stripes.clip is None
    box = QRectF(10.0, 10.0, 40.0, 30.0)
    assert box.contains(stripes.path.boundingRect())
    assert stripes.path.boundingRect().width() > 35.0


def test_opacity_goes_into_the_ink_and_letters_know_their_place():
    def paint(painter):
        painter.setOpacity(0.5)
        painter.translate(20.0, 40.0)
        painter.rotate(-90.0)
        painter.setFont(QFont("DejaVu Sans", 10))
        painter.setPen(QColor("red"))
        painter.drawText(QPointF(0.0, 0.0), "tall")

    (words,) = on_a_sheet(paint)
    assert words.text == "tall"
    assert words.ink.alphaF() == pytest.approx(0.5, abs=0.01)
    box = words.outline().boundingRect()
    assert box.height() > 1.5 * box.width()
    assert box.bottom() <= 40.5


def test_pictures_are_placed_and_cut_out():
    image = QImage(40, 20, QImage.Format.Format_RGB32)

    def paint(painter):
        painter.scale(2.0, 2.0)
        painter.drawImage(QRectF(10.0, 5.0, 20.0, 10.0), image, QRectF(0.0, 0.0, 20.0, 10.0))

    (picture,) = on_a_sheet(paint)
    assert picture.box == QRectF(20.0, 10.0, 40.0, 20.0)
    assert picture.image.size() == QSize(20, 10)


def test_svg_has_the_sheets_own_units_only():
    sheet = Sheet(200.0, 100.0, 96)
    painter = QPainter(sheet)
    painter.scale(2.0, 2.0)
    pen = QPen(QColor("#123456"), 3.0, Qt.PenStyle.CustomDashLine)
    pen.setDashPattern([5.0, 3.0])
    pen.setCosmetic(True)
    painter.setPen(pen)
    painter.drawLine(1, 2, 30, 40)
    painter.setPen(QColor("black"))
    painter.drawText(QPointF(5.0, 20.0), "a < b")
    path = QPainterPath(QPointF(0.0, 0.0))
    path.cubicTo(1.0, 1.0, 2.0, 2.0, 3.0, 1.0)
    painter.fillPath(path, QColor(255, 0, 0, 51))
    painter.end()
    text = svg_of(sheet, "x & y", 52.917, 26.458)
    line, letters, curve = ElementTree.fromstring(text).findall(f"{SVG}path")
    assert line.attrib["d"] == "M2 4 L60 80"
    assert line.attrib["stroke-width"] == "3"
    assert line.attrib["stroke-dasharray"] == "15 9"
    assert letters.attrib["aria-label"] == "a < b"
    assert curve.attrib["d"] == "M0 0 C2 2 4 4 6 2"
    assert (curve.attrib["fill"], curve.attrib["fill-opacity"]) == ("#ff0000", "0.2")
    assert "clip-path" not in line.attrib
    assert b'width="52.92mm"' in text
    assert QSvgRenderer(text).viewBoxF() == QRectF(0.0, 0.0, 200.0, 100.0)


def test_svg_has_no_character_that_xml_forbids():
    sheet = Sheet(200.0, 100.0, 96)
    painter = QPainter(sheet)
    painter.drawText(QPointF(5.0, 20.0), "Fore\x01\x1b\uffffArm")
    painter.end()
    root = ElementTree.fromstring(svg_of(sheet, "x\x01 \udce9", 50.0, 25.0))
    assert root.find(f"{SVG}title").text == "x \\udce9"
    assert root.find(f"{SVG}path").attrib["aria-label"] == "ForeArm"
