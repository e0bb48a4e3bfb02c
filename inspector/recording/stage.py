"""Off-screen copies of the views, from which films and pictures are made.

The user can continue to work in the window while a film is made, and a film can have any size.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from PySide6.QtCore import QCoreApplication, QEvent, QPoint, QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPalette, QRegion
from PySide6.QtWidgets import QLabel, QWidget

from inspector.language import tr
from inspector.recording.choice import SCREEN_DPI, USUAL_POINTS, Contents, Paper, RecordChoice, Shot
from inspector.recording.page_layout import natural_height, part_rectangles
from inspector.recording.sheet import Sheet
from inspector.recording.view_picture import view_picture
from inspector.teaching.equations import Equations
from inspector.teaching.gizmo_drawing import GizmoGuest
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.what_if_values import what_if_angles
from inspector.timeline.timeline import Timeline
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import LIGHT, Colours
from inspector.widgets.typeset import Typesetter

WHITE = replace(LIGHT, window="#ffffff", raised="#ffffff")  # no grey on white paper
_TYPE = 9.0  # points of the legend and the equations, if the numbers in plots have USUAL_POINTS
_STAR = tr("* Corrected here: the paper prints this equation differently.")
_NOTHING = QSizeF(1.0, 1.0)


@dataclass(frozen=True)
class Shown:
    """The parts of the window that are copied to a stage."""

    taught: TaughtFrame
    viewport: Viewport
    timeline: Timeline
    typesetter: Typesetter


class Stage(QWidget):
    """Off-screen copies of the views, with a copy of the document.

    The layout is in units that may differ from the pixels of the picture. Text and lines therefore
    have the same size on paper at any resolution.
    """

    def __init__(self, shown: Shown, choice: RecordChoice) -> None:
        """Copy the views in their current state."""
        super().__init__()
        self._choice, self._film = choice, choice.film
        paper = choice.paper if not self._film else Paper()
        self._units = SCREEN_DPI / paper.dpi * USUAL_POINTS / paper.points  # units per pixel
        self.theme = WHITE if paper.white else shown.viewport.theme
        # Colours of its own, because the program's colours may change.
        self._colours = Colours(self.theme, self)
        self.setAttribute(Qt.WidgetAttribute.WA_DontShowOnScreen)
        self._dress()
        self.document = shown.taught.document.snapshot(self)
        self.taught = self._mirrored(shown.taught)
        self.viewport: Viewport | None = None
        self.timeline: Timeline | None = None
        self.equations: Equations | None = None
        self._wanted = _NOTHING
        self._make(shown, choice.contents)
        self._place(choice)
        self.show()
        if self.timeline is not None:
            self.timeline.refresh()
            self.timeline.look_like(shown.timeline)

    # -- making -------------------------------------------------------------------------------

    def _mirrored(self, taught: TaughtFrame) -> TaughtFrame:
        """Return a copy of the teaching tab's state, active if the slider or equations need it."""
        mirrored = TaughtFrame(self.document, self)
        needed = self._choice.sweep is not None or self._choice.contents.equations
        mirrored.active = taught.active or needed
        mirrored.what_if, mirrored.lit, mirrored.stage = taught.what_if, taught.lit, taught.stage
        mirrored.rows = taught.rows
        return mirrored

    def _dress(self) -> None:
        """Apply the stage's theme to plain widgets, which use the program's theme by default."""
        theme, palette, role = self.theme, self.palette(), QPalette.ColorRole
        for of, colour in (
            (role.Window, theme.surface),
            (role.WindowText, theme.text),
            (role.Text, theme.text),
        ):
            palette.setColor(of, QColor(colour))
        self.setPalette(palette)
        if not self._film:
            font = self.font()
            font.setPointSizeF(_TYPE)
            self.setFont(font)

    def _make(self, shown: Shown, contents: Contents) -> None:
        if contents.view:
            self.viewport = Viewport(self.document, self._colours)
            self.viewport.setParent(self)
            self.viewport.look_like(shown.viewport)
            if self.taught.active:
                guest = GizmoGuest(self.viewport, self.taught, shown.typesetter)
                self.viewport.invite(guest)
        if contents.curves:
            self.timeline = Timeline(self.document, self._colours)
            self.timeline.setParent(self)
            self._colours.use(self.theme)  # again, because setting a parent resets the colours
            self.timeline.plots_button.hide()
            if not self._film:
                self.timeline.become_figure()
        if contents.equations:
            self.equations = Equations(self.taught, shown.typesetter, self._colours)
            self.equations.setParent(self)
            self._set_up(self.equations)

    def _set_up(self, equations: Equations) -> None:
        """Resize the equations to fit their rows, and disable the buttons of their headings."""
        self._ink(equations)
        equations.refresh()
        equations.show_only(self.taught.rows or None)
        equations.show_lit(self.taught.lit)
        for head in equations.heads:
            head.setEnabled(False)
        equations.conventions.setText(f"{equations.conventions.text()} {_STAR}")
        layout = equations.layout()
        assert layout is not None
        heads = [head.sizeHint().width() for head in equations.heads if not head.isHidden()]
        wide = max(equations.whole_width, *heads)  # in the teaching tab, they may be cut off
        self._wanted = QSizeF(wide, layout.totalHeightForWidth(wide))
        equations.resize(self._wanted.toSize())

    def _ink(self, equations: Equations) -> None:
        """Apply the stage's text colours, because the program's style sheet may override them."""
        for part in equations.findChildren(QWidget):
            ink = self.theme.soft if part.objectName() == "soft" else self.theme.text
            if isinstance(part, QLabel) and part.styleSheet():
                part.setStyleSheet(f"{part.styleSheet()}; color: {ink}")
                continue
            part.setObjectName("")
            palette = self.palette()
            palette.setColor(QPalette.ColorRole.WindowText, QColor(ink))
            palette.setColor(QPalette.ColorRole.PlaceholderText, QColor(self.theme.soft))
            part.setPalette(palette)

    def _place(self, choice: RecordChoice) -> None:
        wide, high = (self._units * side for side in choice.size)
        curves = 0.0
        if not high:
            if self.timeline is not None:
                curves = self.timeline.height_for(wide)
            high = curves + natural_height(wide, choice.contents, self._wanted)
        # Films need even numbers of pixels, and so do the halves of a split view.
        self.resize(max(2, round(wide) // 2 * 2), max(2, round(high) // 2 * 2))
        page = QSizeF(self.size())
        self._boxes = part_rectangles(page, choice.contents, self._wanted, curves)
        for key, widget in (("view", self.viewport), ("curves", self.timeline)):
            if widget is not None:
                widget.setGeometry(self._boxes[key].toRect())

    # -- showing ------------------------------------------------------------------------------

    @property
    def size_in_pixels(self) -> QSize:
        """The size of the picture in pixels."""
        if self._film:
            return self.size()
        wide, high = self._choice.size
        return QSize(wide, high or round(self.height() * wide / self.width()))

    def show_shot(self, shot: Shot) -> None:
        """Show one image of a film: go to its frame, and set the moving slider if there is one."""
        self.document.go_to(shot.frame)
        if self._choice.sweep is not None and shot.value is not None:
            self._choice.sweep.show(self.taught, shot.value)
        if self.viewport is not None:
            self.viewport.refresh()
        if self.equations is not None:
            self.equations.refresh()
        # No event loop runs between images, so process the events that Qt would process next: the
        # label of the frame may have grown, and a new plot in the grid becomes visible only then.
        if self.timeline is not None:
            self.timeline.refresh()
            self.timeline.show_what_if(what_if_angles(self.taught))
            for pane in self.timeline.panes.values():
                QCoreApplication.sendPostedEvents(pane)
        QCoreApplication.sendPostedEvents(None, QEvent.Type.LayoutRequest)
        if self.timeline is not None and not self._film:
            self.timeline.fit_titles()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.LayoutRequest)

    def picture(self) -> QImage:
        """Return the stage as an image with one pixel per unit."""
        image = QImage(self.size(), QImage.Format.Format_RGB32)
        painter = QPainter(image)
        self._paint(painter)
        if self.viewport is not None:
            painter.drawImage(self._boxes["view"], self.viewport.grab().toImage())
        painter.end()
        return image

    def sheet(self) -> Sheet:
        """Return the stage as vector lines and text. Only the 3D figure is an image."""
        sheet = Sheet(self.width(), self.height(), self.logicalDpiX())
        painter = QPainter(sheet)
        self._paint(painter)
        if self.viewport is not None:
            box, pixels = self._boxes["view"], self.size_in_pixels.width() / self.width()
            if self.viewport.view is not None:
                painter.drawImage(box, view_picture(self.viewport, (box.size() * pixels).toSize()))
            for child in self.viewport.children():
                if isinstance(child, QWidget) and child.isVisible() and child != self.viewport.view:
                    _render(child, painter, box.topLeft() + child.pos())
        painter.end()
        return sheet

    def _paint(self, painter: QPainter) -> None:
        """Paint everything except the 3D figure."""
        painter.fillRect(self.rect(), QColor(self.theme.surface))
        if self.timeline is not None:
            box = self._boxes["curves"]
            if box.top() and not self._choice.paper.white:
                rule = QRectF(0.0, box.top() - 2.0, box.width(), 2.0)
                painter.fillRect(rule, QColor(self.theme.line))
            _render(self.timeline, painter, box.topLeft())
        if self.equations is not None:
            box = self._boxes["equations"]
            painter.translate(box.topLeft())
            self.equations.paint_into(painter, box.size())
            painter.translate(-box.topLeft())

    def close_views(self) -> None:
        """Close the stage and the copies of the views."""
        if self.viewport is not None:
            self.viewport.close()
        self.close()
        self.deleteLater()


def _render(widget: QWidget, painter: QPainter, at: QPointF) -> None:
    """Paint a widget and its children with the painter of another device."""
    painter.save()
    painter.translate(at)
    widget.render(painter, QPoint(), QRegion(), QWidget.RenderFlag.DrawChildren)
    painter.restore()
