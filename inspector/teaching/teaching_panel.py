"""The teaching tab: equations with their current values, and sliders for what-if values."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, QTimer, Signal
from PySide6.QtGui import QAction, QFontInfo, QResizeEvent
from PySide6.QtWidgets import QApplication, QFrame, QScrollArea, QSizePolicy, QWidget

from inspector.language import tr, translate_core_sentence
from inspector.teaching.equation_table import teaching_tab_formulas
from inspector.teaching.equations import Equations
from inspector.teaching.gizmo_drawing import GizmoGuest
from inspector.teaching.other_forms import OtherForms
from inspector.teaching.symbols import SYMBOLS
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.what_if import WhatIfBox
from inspector.teaching.what_if_values import what_if_angles
from inspector.timeline.timeline import Timeline
from inspector.viewport.frame_drawing import selected_limb
from inspector.viewport.viewport import Viewport
from inspector.widgets.building import action_button, hbox, vbox
from inspector.widgets.labels import Headline, escape_tool_tip_text, plain_to_rich_text
from inspector.widgets.theme import Theme
from inspector.widgets.typeset import Typesetter

_EMPTY = tr("Open a clip and select a chain to see its swing, twist and azimuth here.")
_FEW_ROWS = 110  # pixels; some equations are always visible


class TeachingPanel(QWidget):
    """The panel of the teaching tab. While it is visible, the 3D view shows the gizmo."""

    least_width = Signal(int)  # in pixels, known when the symbols are typeset
    moved_far = Signal()  # a slider was released, so that the limb may be out of view

    def __init__(
        self,
        taught: TaughtFrame,
        viewport: Viewport,
        timeline: Timeline,
        actions: list[QAction],
        typesetter: Typesetter,
    ) -> None:
        """Build the panel, with buttons for `actions` at the top."""
        super().__init__()
        self._taught, self._viewport, self._timeline = taught, viewport, timeline
        self.typesetter = typesetter
        self._size = QFontInfo(QApplication.font()).pixelSize()  # font size in pixels
        self.gizmo = GizmoGuest(viewport, taught, self.typesetter)
        self.title = Headline()
        self.equations = Equations(taught, self.typesetter, viewport.colours)
        self.what_if = WhatIfBox(taught, viewport.colours)
        self._buttons = [action_button(action) for action in actions]
        for button in self._buttons:
            button.setAutoRaise(True)
        self._head = head = hbox((self.title, 1), *self._buttons, margins=(12, 4, 8, 2), spacing=2)
        self.scroll_area = QScrollArea(widgetResizable=True)
        self.scroll_area.setAccessibleName(tr("Equations"))
        self.other_forms = OtherForms(taught, self.typesetter)
        self.listed = QWidget()
        vbox(
            self.equations, self.other_forms, None,
            owner=self.listed, margins=(0, 0, 0, 0), spacing=0,
        )  # fmt: skip
        self.scroll_area.setWidget(self.listed)
        self.listed.installEventFilter(self)
        self.scroll_area.setFrameShape(QFrame.Shape.NoFrame)
        self.scroll_area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        # Without enough room, the equations shrink; sliders and buttons keep their sizes.
        policy = QSizePolicy.Policy
        self.scroll_area.setSizePolicy(policy.Expanding, policy.Ignored)
        self.scroll_area.setMinimumHeight(_FEW_ROWS)
        self._rule = QFrame()
        self._rule.setFixedHeight(1)
        content = head, (self.scroll_area, 1), self._rule, self.what_if
        vbox(*content, owner=self, margins=(0, 0, 0, 0), spacing=0)
        self.equations.clicked.connect(taught.highlight)
        for name in ("swing", "bend"):
            self.what_if.sliders[name].sliderReleased.connect(self.moved_far)
        taught.changed.connect(self.refresh)
        taught.document.chain_changed.connect(self._other_chain)
        taught.document.opened.connect(self._other_chain)
        taught.lit_changed.connect(self._lit)
        taught.document.intervals_changed.connect(self._retitled)
        self.typesetter.ready.connect(self._typeset)
        viewport.colours.follow(self._colour)
        self.equations.show_lit(taught.lit)
        if self.typesetter.done:
            self._typeset()

    def set_scale(self, scale: float) -> None:
        """Scale the text of the equations; 1 is the normal size."""
        self._size = round(QFontInfo(QApplication.font()).pixelSize() * scale)
        self.equations.set_scale(scale)
        self._colour(self._viewport.theme)
        self._typeset()

    def _colour(self, theme: Theme) -> None:
        for part in (self.scroll_area.viewport(), self.listed):
            part.setStyleSheet(f"background: {theme.surface}; font-size: {self._size}px")
        self._rule.setStyleSheet(f"background: {theme.line}")
        self.title.setStyleSheet("font-weight: 600")
        self.refresh()

    def refresh(self) -> None:
        """Update the numbers in the tab, the plots and the gizmo for the current frame."""
        self.equations.refresh()
        self.other_forms.refresh()
        self.what_if.refresh()
        self._timeline.show_what_if(what_if_angles(self._taught))
        self._retitled()
        self._invite()

    def _invite(self) -> None:
        """Show the gizmo in the 3D view if the tab is visible and a chain is selected."""
        if self._taught.active:
            whole = selected_limb(self._taught.document) is not None
            self._viewport.invite(None if whole else self.gizmo)

    def _other_chain(self) -> None:
        if self._taught.active:
            self._viewport.focus_chain()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Hide buttons if the title would not fit."""
        super().resizeEvent(event)
        self._make_room_for_title()

    def _make_room_for_title(self) -> None:
        """Hide buttons from left to right until the title fits. Their actions are in the menu."""
        margins, wraps = self._head.contentsMargins(), self.title.wordWrap()
        room = self.width() - margins.left() - margins.right()
        needed = 0 if wraps else self.title.least_width
        for k, button in enumerate(self._buttons):
            rest = self._buttons[k:]
            taken = sum(b.sizeHint().width() + self._head.spacing() for b in rest)
            button.setVisible(needed + taken <= room)

    def _retitled(self) -> None:
        chain, document = self._taught.chain, self._taught.document
        self.title.setWordWrap(chain is None)  # a sentence, which must be readable to its end
        if chain is None:
            limb = selected_limb(document)
            whole = (
                tr("{limb} is a limb: select a chain", limb=translate_core_sentence(limb.label))
                if limb is not None
                else _EMPTY
            )
            self.title.set_forms(plain_to_rich_text(whole))
            self.title.setToolTip("")
            self._make_room_for_title()
            return
        frame = document.frame + document.first_frame
        label = translate_core_sentence(chain.label)
        title = tr("{chain}, frame {frame}", chain=label, frame=frame)
        self.title.set_forms(plain_to_rich_text(title), plain_to_rich_text(label))
        self.title.setToolTip(escape_tool_tip_text(title))
        self._make_room_for_title()

    def _lit(self) -> None:
        lit = self._taught.lit
        self.equations.show_lit(lit)
        self._timeline.highlight(SYMBOLS[lit].curves if lit and self._taught.active else ())
        self._invite()

    def _typeset(self) -> None:
        self.refresh()
        self.scroll_area.setMinimumWidth(0)
        self._widen()

    def _widen(self) -> None:
        """Widen the tab to fit its widest row. That row may appear later than the others."""
        layout = self.equations.layout()
        assert layout is not None
        layout.activate()
        width = self.listed.minimumSizeHint().width()
        width += self.scroll_area.verticalScrollBar().sizeHint().width()
        if width > self.scroll_area.minimumWidth():
            self.scroll_area.setMinimumWidth(width)
            self.least_width.emit(self.minimumSizeHint().width())

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Make the tab wider when a row appears or a value becomes longer."""
        if event.type() == QEvent.Type.LayoutRequest:
            self._widen()
        return super().eventFilter(watched, event)

    def set_seen(self, seen: bool) -> None:
        """Activate the tab when it becomes visible, or deactivate it if `seen` is False.

        The formulas are typeset when the tab is visible for the first time.
        """
        if seen == self._taught.active:
            return
        self._taught.set_active(seen)
        if seen:
            self.typesetter.start(teaching_tab_formulas())
            self._viewport.focus_chain()
        else:
            self._viewport.invite(None)
            self._timeline.highlight(())
            # When a layout is restored, the tab is hidden and immediately shown again.
            QTimer.singleShot(0, self, self._left)

    def _left(self) -> None:
        """Discard the what-if values if the user has changed to another tab.

        If the window is only minimised, the what-if values are kept.
        """
        if not self._taught.active and not self.window().isMinimized():
            self._taught.reset()
