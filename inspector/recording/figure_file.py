"""Write pictures as PNG at any resolution, or as SVG or PDF with vector lines and text."""

from __future__ import annotations

from errno import EFBIG

from PySide6.QtCore import QBuffer, QIODevice, QMarginsF, QSize, QSizeF
from PySide6.QtGui import QImage, QPageLayout, QPageSize, QPainter, QPdfWriter

from inspector.language import tr
from inspector.recording.sheet import Sheet
from inspector.recording.svg_file import png_of, svg_of

_MM = 25.4  # millimetres per inch
_LONGEST = 32_767  # maximum width and height in pixels, beyond which Qt paints nothing


def figure_file(sheet: Sheet, suffix: str, title: str, pixels: QSize, dpi: float) -> bytes:
    """Return the bytes of a picture file. Raises OSError if the picture is too large."""
    if suffix == ".png":
        return _png(sheet, pixels, dpi)
    wide, high = (_MM * side / dpi for side in (pixels.width(), pixels.height()))
    if suffix == ".svg":
        return svg_of(sheet, title, wide, high)
    return _pdf(sheet, title, QSizeF(wide, high))


def _png(sheet: Sheet, pixels: QSize, dpi: float) -> bytes:
    image = QImage(pixels, QImage.Format.Format_RGB32)
    if image.isNull() or max(pixels.width(), pixels.height()) > _LONGEST:
        sides = f"{pixels.width():,} × {pixels.height():,}"
        why = tr("a PNG of {sides} pixels is too large; choose SVG or PDF instead", sides=sides)
        raise OSError(EFBIG, why)
    painter = QPainter(image)
    painter.scale(pixels.width() / sheet.box.width(), pixels.height() / sheet.box.height())
    sheet.paint(painter)
    painter.end()
    for set_it in (image.setDotsPerMeterX, image.setDotsPerMeterY):
        set_it(round(1000.0 * dpi / _MM))  # after painting, because this would change the font size
    return png_of(image)


def _pdf(sheet: Sheet, title: str, paper: QSizeF) -> bytes:
    """Return a PDF with embedded fonts and vector lines."""
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    writer = QPdfWriter(buffer)
    writer.setTitle(title)
    writer.setCreator("Twist Inspector")
    writer.setResolution(sheet.density)  # the resolution at which the text was measured
    size = QPageSize(paper, QPageSize.Unit.Millimeter, title, QPageSize.SizeMatchPolicy.ExactMatch)
    whole = QPageLayout(size, QPageLayout.Orientation.Portrait, QMarginsF())
    writer.setPageLayout(whole)
    painter = QPainter(writer)
    wide, high = (side / _MM * sheet.density for side in (paper.width(), paper.height()))
    painter.scale(wide / sheet.box.width(), high / sheet.box.height())
    sheet.paint(painter)
    painter.end()
    return bytes(buffer.data().data())
