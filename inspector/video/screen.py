"""The widget that shows an image of the video, or a message."""

from __future__ import annotations

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from inspector.language import tr
from inspector.widgets.theme import Colours


class Screen(QWidget):
    """A widget that shows an image as large as possible, or a message."""

    resized = Signal()

    def __init__(self, colours: Colours, text: str) -> None:
        super().__init__()
        self._colours = colours
        colours.changed.connect(self._colour)
        self.image: QImage | None = None
        self.text = text
        self._name_picture()
        self.setMinimumSize(160, 90)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def sizeHint(self) -> QSize:
        """Return the preferred size, with an aspect ratio of 16:9."""
        return QSize(320, 180)

    def show_image(self, image: QImage | None, text: str = "") -> None:
        """Show an image or, if the image is None, a message."""
        self.image, self.text = image, text
        self.update()
        self._name_picture()

    def _name_picture(self) -> None:
        """Set the screen-reader text: the message or, if there is an image, the image's name."""
        name = self.text if self.image is None else tr("Image of the video")
        if name != self.accessibleName():
            self.setAccessibleName(name)

    def pixels(self) -> tuple[int, int]:
        """Return the width and the height of the widget in physical pixels."""
        ratio = self.devicePixelRatioF()
        return max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio))

    def picture_rect(self) -> QRectF:
        """Return the rectangle in which to draw the image.

        It has the aspect ratio of the image, and its edges are on whole pixels.
        """
        assert self.image is not None
        (across, down), image = self.pixels(), self.image
        # The scale is 1 if the image was decoded for this size.
        scale = min(across / image.width(), down / image.height())
        width, height = round(scale * image.width()), round(scale * image.height())
        left, top = (across - width) // 2, (down - height) // 2
        ratio = self.devicePixelRatioF()
        return QRectF(left / ratio, top / ratio, width / ratio, height / ratio)

    def _colour(self) -> None:
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the image or, if there is none, the message."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor(self._colours.theme.surface))
        if self.image is not None:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
            painter.drawImage(self.picture_rect(), self.image)
        else:
            painter.setPen(QColor(self._colours.theme.soft))
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(self.rect().adjusted(12, 12, -12, -12), flags, self.text)
        painter.end()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Emit `resized`, so that the video is decoded for the new size."""
        super().resizeEvent(event)
        self.resized.emit()
