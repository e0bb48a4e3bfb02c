"""The timeline: plots of the selected chain on a common time axis, and an overview of the clip."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QColor, QPalette
from PySide6.QtWidgets import QMenu, QToolButton, QWidget

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.chain_curves import ChainCurves
from inspector.timeline.curves import Curves
from inspector.timeline.gestures import Gestures
from inspector.timeline.layers import Scenery
from inspector.timeline.limb_curves import LimbCurves
from inspector.timeline.overview import OverviewStrip
from inspector.timeline.pane import AXIS_WIDTH
from inspector.timeline.pane_grid import PaneGrid
from inspector.timeline.plot import plots
from inspector.timeline.plot_descriptions import PlotDescriptions
from inspector.timeline.tau_line import ChainTauLine
from inspector.timeline.visible_range import VisibleRange
from inspector.timeline.what_if_dots import WhatIfDots
from inspector.widgets.building import hbox, tool_button, vbox
from inspector.widgets.labels import SteadyLabel
from inspector.widgets.later import RedrawRequests
from inspector.widgets.theme import Colours, Theme, figures_font
from twistcore.review import Judged


class Timeline(QWidget):
    """A widget with the plots of the selected chain or limb and the overview of the clip."""

    def __init__(self, document: Document, colours: Colours) -> None:
        super().__init__()
        self.document = document
        self.scenery = Scenery(colours)
        self.visible = VisibleRange(document, self)
        self.visible.changed.connect(self._show_range)
        self.visible.arrived.connect(self._fit_part)
        self._curves: Curves | None = None
        self._applicable: list[str] = []  # keys of the plots that apply to the selection
        self._arriving = False  # True: fit the values to the visible frames at the next refresh
        self._stale = RedrawRequests(self)  # most changes leave the curves of the clip as they are
        self._stale.due.connect(self.refresh)
        self._build(colours)
        colours.follow(self._colour)
        document.opened.connect(self._opened)
        document.chain_changed.connect(self._stale.mark_all)
        document.intervals_changed.connect(self._stale.mark)
        document.method_changed.connect(self._method_changed)
        document.chains_changed.connect(self._method_changed)
        document.numbering_changed.connect(self._renumber)
        document.hidden_changed.connect(self._stale.mark)
        document.tracked_changed.connect(self._stale.mark)
        document.interval_changed.connect(self._interval_changed)
        document.frame_changed.connect(self._frame_changed)
        self._opened()

    # -- building -----------------------------------------------------------------------------

    def _build(self, colours: Colours) -> None:
        self.overview = OverviewStrip(colours, self)
        self.overview.moved.connect(self.document.go_to)
        self.overview.clicked.connect(self._pick)
        self.overview.dropped.connect(self.visible.deselect_hidden)
        self.overview.ranged.connect(self.visible.show)
        self.readout = SteadyLabel(self)
        self.readout.setFont(figures_font(9.0))
        self.readout.setToolTip(tr("Playhead"))
        self.plots_button = tool_button(f"{tr('Plots')} ▾", tr("Choose which plots are shown"))
        self.plots_button.setStyleSheet("QToolButton::menu-indicator { image: none; }")
        self.plots_button.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self._head = hbox(
            (self.overview, 1),
            self.readout,
            self.plots_button,
            margins=(AXIS_WIDTH, 2, 4, 2),
            spacing=8,
        )
        layout = vbox(self._head, owner=self, margins=(0, 0, 0, 0), spacing=0)
        self.plots = plots()
        self.panes = {
            key: plot.pane(self.document, self.scenery, self) for key, plot in self.plots.items()
        }
        mouse = self.document, self.scenery, self.visible, self.refresh, self._repaint, self
        self.gestures = Gestures(*mouse)
        self._tau_pane = next(self.panes[key] for key, plot in self.plots.items() if plot.takes_tau)
        menu = QMenu(self.plots_button)
        self.toggles: dict[str, QAction] = {}
        for key, pane in self.panes.items():
            plot = self.plots[key]
            own = plot.gestures is not Gestures
            pane.view.gestures = plot.gestures(*mouse) if own else self.gestures
            pane.view.sigResized.connect(self._show_range)
            action = QAction(plot.title, menu, checkable=True, checked=plot.at_first)
            action.toggled.connect(lambda on, k=key: self.show_plot(k, shown=on))
            menu.addAction(action)
            self.toggles[key] = action
        self.plots_button.setMenu(menu)
        self.dots = WhatIfDots(self.panes, self.plots, self.scenery)
        self._what_if: Mapping[str, float] = {}
        self.tau_line = ChainTauLine(self.document, self._tau_pane, colours)
        self.tau_line.dropped.connect(self._stale.mark)
        self.grid = PaneGrid(self.panes, self.plots, self)
        self.grid.arranged.connect(self._arranged)
        self.gestures.plots, self.gestures.tau_plot = self._menu_rows, self._tau_pane.key
        layout.addWidget(self.grid, 1)
        self.setMinimumHeight(120)
        titled = {plot.title: self.panes[key] for key, plot in self.plots.items()}
        PlotDescriptions(self.document, titled, self)

    def show_plot(self, key: str, *, shown: bool) -> None:
        """Show or hide a plot, given by its key.

        If the plot does not apply to limbs and a limb is selected, show a message.
        """
        self.grid.show_pane(key, shown=shown)
        if shown and self.document.limb is not None and (hint := self.plots[key].no_limb):
            self.document.message.emit(hint, False)

    def look_like(self, other: Timeline) -> None:
        """Copy the choice of plots, the visible frames and the value ranges of another timeline."""
        for key, toggle in other.toggles.items():
            self.toggles[key].setChecked(toggle.isChecked())
        if other.grid.alone:
            self.grid.enlarge(other.grid.shown[0])
        for key, pane in self.panes.items():
            pane.look_like(other.panes[key])
        self.visible.show(*other.visible.ends)

    def become_figure(self) -> None:
        """Prepare the timeline for use as a figure: hide its controls and fix its layout."""
        for part in (self.overview, self.plots_button):
            part.hide()
        self._head.setAlignment(self.readout, Qt.AlignmentFlag.AlignLeft)
        for scenery in self._sceneries:
            scenery.still = True
        for pane in self.panes.values():
            pane.setCacheMode(pane.CacheModeFlag.CacheNone)  # a cached plot would become a bitmap
            pane.set_scale()  # apply the margins of a figure

    def fit_titles(self) -> None:
        """Reserve space above each plot of a figure for the lines of the longest title.

        The frame number above the plots is also aligned with their left edge, or further left in a
        narrow figure.
        """
        margins = self._head.contentsMargins()
        free = self.width() - margins.right() - self.readout.sizeHint().width()
        margins.setLeft(max(0, min(AXIS_WIDTH, free)))
        self._head.setContentsMargins(margins)
        lines = max(len(self.panes[key].front.title_lines()) for key in self.grid.shown)
        if lines != self.scenery.title_lines:
            for scenery in self._sceneries:
                scenery.title_lines = lines
            for pane in self.panes.values():
                pane.set_scale()

    def height_for(self, width: float) -> float:
        """Return the height, in pixels, that all plots need at a given width in pixels."""
        return self._head.sizeHint().height() + self.grid.height_for(width) + 1.0

    @property
    def _sceneries(self) -> list[Scenery]:
        """The scenery of the timeline and of each pane. Most panes share the timeline's scenery."""
        return [self.scenery, *(pane.scenery for pane in self.panes.values())]

    def _refresh_shown(self) -> None:
        for key in self.grid.shown:
            self.panes[key].refresh()

    def _menu_rows(self, key: str) -> tuple[tuple[str, Callable[[], None]], ...]:
        """Return the menu entries for the plot with this key."""
        alone = tr("All plots") if self.grid.alone else tr("Only this plot")
        fit = tr("Fit height"), self.panes[key].time.fit
        return fit, (alone, partial(self.grid.enlarge, key))

    def fit(self) -> None:
        """Show all values in every plot."""
        for pane in self.panes.values():
            pane.time.fit()

    def _arranged(self) -> None:
        """Update the plots that have become visible, and the plot counts on the 'Plots' button."""
        self._repaint()
        self._refresh_shown()
        seen, wanted = len(self.grid.shown), len(self.grid.chosen)
        hidden = seen < wanted and self.document.data is not None
        some = tr("{seen} of {wanted} plots", seen=seen, wanted=wanted) if hidden else tr("Plots")
        self.plots_button.setText(f"{some} ▾")
        tip = tr("Choose which plots are shown")
        room = tr("Make the panel taller to see the other plots.")
        self.plots_button.setToolTip(tip if self.grid.alone or not hidden else f"{tip}. {room}")

    def _colour(self, theme: Theme) -> None:
        ink, paper = QPalette.ColorRole.WindowText, QPalette.ColorRole.Window
        for widget, role, colour in (
            (self.grid.hint, ink, theme.soft),
            (self.readout, ink, theme.text),
            (self, paper, theme.surface),
        ):
            palette = widget.palette()
            palette.setColor(role, QColor(colour))
            widget.setPalette(palette)
        self.setAutoFillBackground(True)

    def highlight(self, curves: tuple[tuple[str, str], ...]) -> None:
        """Highlight curves, given as pairs (key of a plot, prefix of the curves' names)."""
        wanted = dict(curves)
        for key, pane in self.panes.items():
            pane.highlight(wanted.get(key))

    def show_what_if(self, values: Mapping[str, float]) -> None:
        """Show the angles of an edited frame as dots at the playhead.

        `values` are in radians, keyed by name.
        """
        if values or self._what_if:
            self._what_if = values
            self._show_dots()
            self._show_titles()

    def _show_dots(self) -> None:
        self.dots.show(self._curves, self.document.frame, self._what_if)

    def set_scale(self, scale: float) -> None:
        """Scale the text and lines of the plots. A scale of 1 is the normal size."""
        self.readout.setFont(figures_font(9.0 * scale))
        for scenery in self._sceneries:
            scenery.scale = scale
        for pane in self.panes.values():
            pane.set_scale()
            pane.colour()
        self.grid.arrange()

    # -- following the document ---------------------------------------------------------------

    def _opened(self) -> None:
        self._curves = None  # do not use the curves of the previous clip
        self._method_changed()
        self.visible.show_all()

    def _method_changed(self) -> None:
        for pane in self.panes.values():
            pane.forget()
        self._stale.mark_all()

    def refresh(self) -> None:
        """Apply all pending document changes to the plots."""
        anything, everything = self._stale.take()
        if not anything:
            return
        document, scenery = self.document, self.scenery
        scenery.frames, scenery.frame = document.frames, document.frame
        scenery.selected = document.interval_id
        if everything:
            self._load_chain()
        elif self._curves is not None:
            self._choose_plots(self._curves)
        if self._curves is not None:
            state = document.review.state
            own = (j for j in state.intervals if document.is_of_chain(j.interval))
            scenery.set_intervals(tuple(sorted(own, key=lambda j: j.interval.start)))
            self._curves.follow_review()
            for key in self._applicable:
                self.plots[key].draw(self._curves, self.panes[key])
            degrees = float(np.degrees(state.tau.get(document.chain, 0.0)))
            self.tau_line.show_tau(degrees)
            if not self.tau_line.held:  # do not rescale the plot during a drag
                self._curves.fit_tau(self._tau_pane, degrees)
            self._show_dots()
            self._show_titles()
            self._repaint()
            if everything:
                self._refresh_shown()
            self._show_part(grow=not self._arriving)
        self._arriving = False
        self._show_overview()
        self._show_readout()

    def _load_chain(self) -> None:
        document = self.document
        data = document.data
        self._curves = None
        if data is None or not document.chain:
            self.scenery.set_intervals(())
            self.grid.show_hint(
                tr("This skeleton has no chains, so there is no twist to show.")
                if data is not None
                else tr("Open a clip to see its twist over time.")
            )
            return
        curves = LimbCurves(document) if document.limb is not None else ChainCurves(document)
        self._curves, scenery = curves, self.scenery
        scenery.unreliable = curves.unreliable
        scenery.unreliable_words = curves.unreliable_words
        scenery.unreliable_hint = curves.unreliable_hint
        self._choose_plots(curves)
        for pane in self.panes.values():
            pane.time.forget_zoom()
        for key in self._applicable:
            self.plots[key].draw_clip(curves, self.panes[key])
        self._show_range()

    def _choose_plots(self, curves: Curves) -> None:
        """Show the plots that apply to the selected chain and interval."""
        words = {key: plot.axis(curves) for key, plot in self.plots.items()}
        for key, pane in self.panes.items():
            pane.front.values = words[key]
        blind = self.document.data is not None and self.document.data.blind
        shown = {key for key, plot in self.plots.items() if plot.in_exercise or not blind}
        self._applicable = [key for key, axis in words.items() if axis and key in shown]
        self.grid.show_panes(self._applicable)

    def _show_overview(self) -> None:
        document = self.document
        found = {j.interval.chain for j in document.intervals}
        every = document.data.chains_and_limbs if document.data else ()
        chains = tuple(c.name for c in every if c.name in found or c.name == document.chain)
        self.overview.show_review(
            document.frames,
            chains,
            document.chain,
            tuple(j for j in document.intervals if not document.hides(j.interval)),
            document.interval_id,
        )
        self.overview.show_frame(document.frame)

    def _pick(self, frame: int, judged: Judged | None) -> None:
        """Select the interval that was clicked in the overview; None clears the selection."""
        if judged is not None:
            frame = min(max(frame, judged.interval.start), judged.interval.stop - 1)
        self.document.select_interval(judged.id if judged is not None else None)
        self.document.go_to(frame)

    def _interval_changed(self) -> None:
        self.scenery.selected = self.document.interval_id
        self._stale.mark()
        if judged := self.document.interval:
            self.visible.reach_interval(judged.interval)

    def _frame_changed(self, frame: int) -> None:
        before, self.scenery.frame = self.scenery.frame, frame
        self.overview.show_frame(frame)
        for key in self.grid.shown:
            self.panes[key].move_playhead(before, frame)
        self._show_readout()
        self._show_titles()
        if not self.gestures.dragging:
            self.visible.reach_frame(frame)

    def _repaint(self) -> None:
        """Repaint all visible plots."""
        for key in self.grid.shown:
            self.panes[key].touch()

    def _show_range(self, *_: object) -> None:
        for pane in self.panes.values():
            pane.show_frames(*self.visible.ends)
        self._show_part(grow=True)
        self.overview.show_view(*self.visible.ends)

    def _fit_part(self) -> None:
        """Fit the value ranges to the visible frames at the next refresh.

        At that time, the chain of the selected interval is loaded.
        """
        self._arriving = True
        self._stale.mark()

    def _show_part(self, *, grow: bool) -> None:
        for key in self._applicable:
            if not self.plots[key].takes_tau:
                self.panes[key].show_part(*self.visible.ends, grow=grow)

    def _renumber(self) -> None:
        for pane in self.panes.values():
            pane.count_from(self.document.first_frame)
        self._show_readout()

    def _show_readout(self) -> None:
        document = self.document
        if document.data is None:
            self.readout.setText("")
            return
        step = document.data.motion.frame_time
        first, last = document.first_frame, document.frames - 1
        at = f"{document.frame + first:{len(str(last + first))}d} / {last + first}"
        seconds = f"{document.frame * step:{len(f'{last * step:.3f}')}.3f}"
        self.readout.setText(tr("frame {at} · {seconds} s", at=at, seconds=seconds))

    def _show_titles(self) -> None:
        if self._curves is None:
            return
        for key in self._applicable:
            if title := self.plots[key].describe(self._curves, self.document.frame):
                self.panes[key].show_title([*title, *self.dots.title(key)])
