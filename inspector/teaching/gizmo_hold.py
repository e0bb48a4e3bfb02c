"""Drag the gizmo with the mouse to edit the displayed frame."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QCoreApplication, QEvent, QObject, QPointF, QRectF, Qt
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
)
from PySide6.QtWidgets import QToolTip, QWidget

from inspector.language import tr
from inspector.teaching.gizmo_handles import DIAL, Handles, SwingDrag, TwistDrag, W, handle_at
from inspector.teaching.symbols import MARKS, symbol_family_colour
from inspector.teaching.taught_frame import TaughtFrame, degree_text
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import Theme, figures_font
from twistcore.analysis.decomposition import WhatIf
from twistcore.skeleton.rotation import Array, wrap

_LEFT = Qt.MouseButton.LeftButton
KEY = Qt.KeyboardModifier.ControlModifier  # window managers do not intercept a drag with Ctrl
_TIPS = {
    W: tr("Drag w to swing the bone. Esc cancels."),
    DIAL: tr(
        "Drag the dial to twist the parent. Hold Ctrl to let the child counter-twist. Esc cancels."
    ),
}
# Radius of a handle in pixels; the key is True for the handle under the mouse
_KNOBS = {False: 5.0, True: 8.0}
_BESIDE = QPointF(18.0, -22.0)  # distance in pixels of the number from the mouse


class Hold(QObject):
    """Handles mouse events on the gizmo, and passes all other events to the camera."""

    def __init__(self, viewport: Viewport, taught: TaughtFrame) -> None:
        super().__init__(viewport)
        self._taught = taught
        self.knobs = Knobs(viewport)
        self._watched: QObject | None = None
        self.places: Handles | None = None
        self.under = ""  # the handle that is under the mouse or being dragged, or ''
        self._drag: SwingDrag | TwistDrag | None = None
        self._before = WhatIf()
        self._at = QPointF()
        for elsewhere in (taught.document.chain_changed, taught.document.opened):
            elsewhere.connect(self._drop)

    @property
    def held(self) -> bool:
        """True while a handle is being dragged."""
        return self._drag is not None

    @property
    def _view(self) -> Viewport:
        view = self.parent()
        assert isinstance(view, Viewport)
        return view

    # -- called by the gizmo ------------------------------------------------------------------

    def show_places(self, places: Handles) -> None:
        """Set the positions of the handles in world coordinates, and start watching the mouse."""
        self.places = places
        if self._watched is None:
            self._watched = self._view.view
            assert self._watched is not None
            # The filter that was installed last is called first
            self._watched.installEventFilter(self)
        self._draw()

    def leave(self) -> None:
        """Stop watching the mouse, because the gizmo was removed."""
        self._drop()
        if self._watched is not None:
            self._watched.removeEventFilter(self)
        self._watched = self.places = None
        self.knobs.hide()

    # -- mouse and keys -----------------------------------------------------------------------

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle the view's mouse events and, during a drag, also keys and loss of focus."""
        if isinstance(event, QKeyEvent):
            return self.held and self._key(event)
        if event.type() == QEvent.Type.WindowDeactivate and self.held:
            self._drop()  # the release of the button may go to another window
        if watched is not self._watched:
            return False
        if event.type() in (QEvent.Type.Enter, QEvent.Type.Leave) and not self.held:
            self._hover("")
            self._draw(inside=event.type() == QEvent.Type.Enter)
            return False
        return isinstance(event, QMouseEvent) and self._mouse(event)

    def _mouse(self, event: QMouseEvent) -> bool:
        kind, at = event.type(), event.position()
        if self.held and kind == QEvent.Type.MouseMove and not event.buttons() & _LEFT:
            self._drop()  # the release of the button was lost
        if self.held:
            if kind == QEvent.Type.MouseMove:
                self._at = at
                self._move(event.modifiers())
            elif kind == QEvent.Type.MouseButtonRelease and event.button() == _LEFT:
                self._let_go()
                self._hover(self._found(at))
            event.accept()
            return True
        if kind == QEvent.Type.MouseMove and not event.buttons():
            self._hover(self._found(at), at)
        elif kind in (QEvent.Type.MouseButtonPress, QEvent.Type.MouseButtonDblClick):
            shift = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
            left = event.button() == _LEFT
            self._hover(self._found(at) if left and not shift else "")
            if self.under:
                self._take(at)
        else:
            return False
        if self.under:
            event.accept()
        return bool(self.under)

    def _key(self, event: QKeyEvent) -> bool:
        """Handle a key during a drag, and return True if the event needs no further handling.

        Esc cancels the drag. While Ctrl is pressed, the counter-twist is added.
        """
        escape, press = event.key() == Qt.Key.Key_Escape, event.type() == QEvent.Type.KeyPress
        if escape:
            event.accept()
            if press:
                self._drop()
                self._taught.set_what_if(self._before)
        elif event.key() == Qt.Key.Key_Control and event.type() != QEvent.Type.ShortcutOverride:
            self._move(KEY if press else Qt.KeyboardModifier.NoModifier)
        return escape

    # -- dragging -----------------------------------------------------------------------------

    def _found(self, at: QPointF) -> str:
        """Return the name of the handle at a point of the view, or '' if there is none.

        The result is also '' while the rotation is animated.
        """
        camera, places, stage = self._view.camera, self.places, self._taught.stage
        if camera is None or places is None or (stage is not None and stage < 2.0):
            return ""
        size, pixel = self._pixel(at)
        return handle_at(places, camera, size, pixel) if pixel[0] >= 0.0 else ""

    def _take(self, at: QPointF) -> None:
        camera, places = self._view.camera, self.places
        assert camera is not None
        assert places is not None
        size, pixel = self._pixel(at)
        self._before, self._at = self._taught.what_if, at
        kind = SwingDrag if self.under == W else TwistDrag
        self._drag = kind(places, camera, size, pixel)
        self._taught.set_stage(None)
        QToolTip.hideText()
        app = QCoreApplication.instance()
        assert app is not None
        app.installEventFilter(self)
        self._draw()

    def _move(self, keys: Qt.KeyboardModifier) -> None:
        """Edit the displayed frame so that the dragged handle follows the mouse."""
        camera, places = self._view.camera, self.places
        if camera is None or places is None:
            self._let_go()
            return
        self._taught.set_stage(None)  # this also stops the animation
        size, pixel = self._pixel(self._at)
        if isinstance(self._drag, SwingDrag):
            way = places.own(self._drag.way(places, camera, size, pixel))
            x, y, z = way.tolist()
            self._taught.alter(toward=(x, y, z), swing=None, nudge=0.0)
        elif isinstance(self._drag, TwistDrag):
            twist = self._before.twist + self._drag.turn(places, camera, size, pixel)
            counter = bool(keys & KEY) or self._before.counter
            self._taught.alter(twist=float(wrap(twist)), counter=counter)
        self._draw()

    def _let_go(self) -> None:
        if self._drag is not None:
            self._drag = None
            app = QCoreApplication.instance()
            assert app is not None
            app.removeEventFilter(self)
            self._draw()

    def _drop(self) -> None:
        """End the drag, and keep the changed frame."""
        self._let_go()
        self._hover("")

    def _hover(self, under: str, at: QPointF | None = None) -> None:
        """Highlight the handle under the mouse by its cursor, a larger knob and a tool tip.

        `under` is the name of this handle, or '' if there is none.
        """
        view = self._view.view
        if under == self.under or view is None:
            return
        self.under = under
        if not under:
            view.unsetCursor()
            QToolTip.hideText()
        else:
            view.setCursor(Qt.CursorShape.OpenHandCursor)
            if at is not None:
                QToolTip.showText(view.mapToGlobal(at.toPoint()), _TIPS[under], view)
        self._draw()

    def _pixel(self, at: QPointF) -> tuple[tuple[int, int], Array]:
        """Return the size of the gizmo's image, and the image pixel at a point of the view."""
        size = self._view.picture_size()
        return size, np.array([at.x() - (self._view.width() - size[0]), at.y()])

    # -- drawing ------------------------------------------------------------------------------

    def _draw(self, *, inside: bool | None = None) -> None:
        camera, places, view = self._view.camera, self.places, self._view
        seen = view.underMouse() if inside is None else inside
        d = self._taught.quantities
        if camera is None or places is None or d is None or not (self.held or seen):
            self.knobs.hide()
            return
        if self.held and view.view is not None:
            view.view.setCursor(Qt.CursorShape.ClosedHandCursor)
        words = ""
        if self.held:
            if self.under == W:
                words = f"α {degree_text(d.alpha).removeprefix('+')}"
            else:
                words = f"θp {degree_text(d.theta_p) if d.swing_is_one else tr('undefined')}"
            if self.under == DIAL and self._taught.what_if.counter:
                words += tr(", child counter-twists")
        size = view.picture_size()
        corner = np.array([view.width() - size[0], 0.0])
        at = np.stack([places.tip, places.hand_tip])
        spots, ring = (camera.project(p, *size)[0] + corner for p in (at, places.ring))
        self.knobs.show_handles(view.theme, spots, ring, self.under, self._at, words)


class Knobs(QWidget):
    """The knobs of the handles, drawn over the 3D view. The knob under the mouse is larger."""

    def __init__(self, viewport: QWidget) -> None:
        super().__init__(viewport)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.words = ""
        self.hide()

    def show_handles(
        self, theme: Theme, spots: Array, ring: Array, under: str, at: QPointF, words: str
    ) -> None:
        """Show the knobs of w and of the dial, the edge of the dial, and a text near the mouse.

        Parameters
        ----------
        theme
            The colours.
        spots
            The pixels of both knobs, (2, 2).
        ring
            The pixels of the dial's edge, (n, 2).
        under
            The name of the handle under the mouse, or ''.
        at
            The position of the mouse.
        words
            The text, or ''.
        """
        view = self.parentWidget()
        assert view is not None
        if self.geometry() != view.rect():
            self.setGeometry(view.rect())
        self._theme, self._spots, self._ring = theme, spots, ring
        self._under, self._at, self.words = under, at, words
        self.show()
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the edge of the dial and both knobs in the colours of their symbols."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        inks = {k: QColor(symbol_family_colour(MARKS[k].family, self._theme)) for k in (W, DIAL)}
        if self._under == DIAL:
            wide = QColor(inks[DIAL])
            wide.setAlpha(110)
            painter.setPen(QPen(wide, 8.0))
            painter.drawPolyline(QPolygonF([QPointF(*p) for p in self._ring.tolist()]))
        for (name, ink), spot in zip(inks.items(), self._spots.tolist(), strict=True):
            painter.setPen(QPen(QColor(self._theme.surface), 2.0))
            painter.setBrush(ink)
            radius = _KNOBS[name == self._under]
            painter.drawEllipse(QPointF(*spot), radius, radius)
        if self.words:
            self._write(painter)

    def _write(self, painter: QPainter) -> None:
        """Draw the text near the mouse, at a position where it fits into the view."""
        painter.setFont(figures_font(self.font().pointSizeF()))
        size = QFontMetricsF(painter.font()).size(0, self.words)
        box = QRectF(self._at + _BESIDE, size).adjusted(-6.0, -3.0, 6.0, 3.0)
        box.moveRight(min(box.right(), self.width() - 4.0))
        box.moveTop(max(box.top(), 4.0))
        painter.setPen(QColor(self._theme.line))
        painter.setBrush(QColor(self._theme.raised))
        painter.drawRoundedRect(box, 4.0, 4.0)
        painter.setPen(QColor(self._theme.text))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, self.words)
