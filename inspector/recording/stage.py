"""What is filmed: 3D view and curves on a stage of their own, off the screen.

So the window stays free while a film is made, and the film has its own size.
"""

from __future__ import annotations

from PySide6.QtCore import QBuffer, QIODevice, QRect, QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPalette
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QFrame, QWidget

from inspector.teaching.gizmo_drawing import GizmoGuest
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.what_if_values import plotted
from inspector.timeline.timeline import Timeline
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import vbox
from inspector.widgets.typeset import Typesetter

_SHARE = 58  # percent of the height for the 3D view where there are curves


class Stage(QWidget):
    """A copy of the views with a copy of the document: nothing of it shows in the window."""

    def __init__(
        self,
        taught: TaughtFrame,
        viewport: Viewport,
        typesetter: Typesetter,
        size: QSize,
        *,
        curves: bool,
    ) -> None:
        """As the window shows the clip now; of `size`, with the curves or without."""
        super().__init__()
        theme = viewport.theme
        self.setAttribute(Qt.WidgetAttribute.WA_DontShowOnScreen)
        self.document = taught.document.snapshot(self)
        self.viewport = Viewport(self.document, theme)
        self.viewport.look_like(viewport)
        self._taught = mirrored = TaughtFrame(self.document, self)
        if taught.active:
            mirrored.active, mirrored.what_if, mirrored.lit = True, taught.what_if, taught.lit
            mirrored.stage = taught.stage
            self.viewport.invite(GizmoGuest(self.viewport, mirrored, typesetter))
        layout = vbox((self.viewport, _SHARE), owner=self, margins=(0, 0, 0, 0), spacing=0)
        self.timeline: Timeline | None = None
        if curves:
            rule = QFrame()
            rule.setFixedHeight(2)
            rule.setStyleSheet(f"background: {theme.line}")
            self.timeline = Timeline(self.document, theme)
            self.timeline.plots_button.hide()
            layout.addWidget(rule)
            layout.addWidget(self.timeline, 100 - _SHARE)
        palette = self.palette()
        palette.setColor(QPalette.ColorRole.Window, QColor(theme.surface))
        self.setPalette(palette)
        # Films want even numbers of pixels, and so do the halves of a split view.
        self.resize(size.width() // 2 * 2, size.height() // 2 * 2)
        self.show()

    def show_frame(self, frame: int) -> None:
        """Set the frame and draw what it changes."""
        self.document.go_to(frame)
        self.viewport.refresh()
        if self.timeline is not None:
            self.timeline.refresh()
            self.timeline.show_what_if(plotted(self._taught))
            if (head := self.timeline.layout()) is not None:
                head.activate()  # the readout has grown, and no event loop runs in between

    def picture(self) -> QImage:
        """What is on the stage, as large as it is, whatever the screen's pixel ratio."""
        image = self.grab().toImage()
        if image.size() != self.size():
            image = image.scaled(
                self.size(),
                Qt.AspectRatioMode.IgnoreAspectRatio,
                Qt.TransformationMode.SmoothTransformation,
            )
            image.setDevicePixelRatio(1.0)
        return image

    def png(self) -> bytes:
        """The picture as a file."""
        buffer = QBuffer()
        self.picture().save(buffer, "PNG")  # type: ignore[call-overload]  # its stub wants bytes
        return bytes(buffer.data().data())

    def svg(self, title: str) -> bytes:
        """Curves as lines and letters over the 3D view as a picture."""
        buffer = QBuffer()
        buffer.open(QIODevice.OpenModeFlag.WriteOnly)
        generator = QSvgGenerator()
        generator.setOutputDevice(buffer)
        generator.setSize(self.size())
        generator.setViewBox(QRect(0, 0, self.width(), self.height()))
        generator.setTitle(title)
        painter = QPainter(generator)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Window))
        painter.drawImage(self.viewport.geometry(), self.viewport.grab().toImage())
        if self.timeline is not None:
            self.timeline.render(painter, self.timeline.pos())
        painter.end()
        return bytes(buffer.data().data())

    def strike(self) -> None:
        """Take it down."""
        self.viewport.close()
        self.close()
        self.deleteLater()
