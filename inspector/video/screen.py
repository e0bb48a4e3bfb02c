"""Where the video is seen: a picture that keeps its aspect, or a sentence."""

from __future__ import annotations

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QImage, QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from inspector.language import tr
from inspector.widgets.theme import Colours


class Screen(QWidget):
    """A picture as large as it fits, or a sentence."""

    resized = Signal()

    def __init__(self, colours: Colours, text: str) -> None:
        super().__init__()
        self._colours = colours
        colours.changed.connect(self._colour)
        self.image: QImage | None = None
        self.text = text
        self._tell()
        self.setMinimumSize(160, 90)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def sizeHint(self) -> QSize:
        """Room for a picture of 16:9."""
        return QSize(320, 180)

    def show_image(self, image: QImage | None, text: str = "") -> None:
        """Show a picture, or a sentence where there is none."""
        self.image, self.text = image, text
        self.update()
        self._tell()

    def _tell(self) -> None:
        """To a screen reader: the sentence, or that there is a picture."""
        told = self.text if self.image is None else tr("Picture of the video")
        if told != self.accessibleName():
            self.setAccessibleName(told)

    def pixels(self) -> tuple[int, int]:
        """Width and height in the screen's own pixels."""
        ratio = self.devicePixelRatioF()
        return max(1, round(self.width() * ratio)), max(1, round(self.height() * ratio))

    def picture_rect(self) -> QRectF:
        """Where the picture lies: its aspect kept, in the middle, on whole pixels of the screen."""
        assert self.image is not None
        (across, down), image = self.pixels(), self.image
        scale = min(across / image.width(), down / image.height())  # 1 if it was decoded for this
        width, height = round(scale * image.width()), round(scale * image.height())
        left, top = (across - width) // 2, (down - height) // 2
        ratio = self.devicePixelRatioF()
        return QRectF(left / ratio, top / ratio, width / ratio, height / ratio)

    def _colour(self) -> None:
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """The picture between bars of the theme's colour."""
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
        """Another size asks for other pixels."""
        super().resizeEvent(event)
        self.resized.emit()
