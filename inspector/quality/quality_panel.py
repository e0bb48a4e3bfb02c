"""The quality tab: a table of the joints' measures, and tracking of the selected joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from PySide6.QtCore import QItemSelection, QItemSelectionModel, Qt, QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHeaderView, QSplitter, QStackedLayout, QTabWidget, QWidget

from inspector.language import plural, tr
from inspector.quality.evidence import MEASURES, QualityEvidence, quality_measure_by_frame
from inspector.quality.joint_table import JointsModel
from inspector.quality.track_page import TrackPage
from inspector.quality.tracked_clip import Tracked
from inspector.session.document import Document
from inspector.widgets.building import hint, vbox
from inspector.widgets.labels import Caption, bold, coloured_rich_text, plain_text
from inspector.widgets.later import RedrawRequests
from inspector.widgets.tables import RowTable
from inspector.widgets.theme import Colours
from inspector.widgets.traces import Trace, TracePlot
from twistcore.detection import Interval
from twistcore.quamo.clip_smoothing import settings_to_smooth_noise_bursts

_SAMPLE, _PAIR = "00000", "0.00 → 0.00"  # the longest texts of a column
_PAD = 12  # pixels around these texts
# Index in MEASURES of the jumps of the numbers in the file, which tracking does not change
_WRITTEN = 1
_EMPTY = tr("Open a clip to see the jitter, jumps and speed of its joints, and any foot sliding.")


_REST_MS = 400  # pause of the playhead after which screen readers get the numbers


class QualityPanel(QWidget):
    """The panel of the quality tab, with quality measures of all joints and a tracking page."""

    def __init__(
        self, document: Document, colours: Colours, actions: Mapping[str, QAction], tracked: Tracked
    ) -> None:
        super().__init__()
        self._document, self._actions, self._colours = document, actions, colours
        self.evidence = QualityEvidence(document, self)
        self.tracked = tracked
        self.measure = 0
        self._picked = False  # True if the user has selected rows; if not, all joints are tracked
        self._pending: tuple[str, ...] = ()  # joints to select as soon as their rows exist
        self._stale = RedrawRequests(self)
        self._stale.due.connect(self.refresh)
        self._rest = QTimer(self, singleShot=True, interval=_REST_MS)
        self._rest.timeout.connect(self._describe)
        self._build(colours)
        self.evidence.changed.connect(self._values_changed)
        self.tracked.changed.connect(self._stale.mark)
        for signal in (document.intervals_changed, document.numbering_changed):
            signal.connect(self._stale.mark)
        document.frame_changed.connect(self._move)
        document.chain_changed.connect(self._follow_chain)
        document.opened.connect(self._forget_pending)
        colours.changed.connect(self._stale.mark)
        self._stale.mark()

    def _build(self, colours: Colours) -> None:
        self.hint = hint(_EMPTY)
        self._pages = QStackedLayout(self)
        self._pages.addWidget(self.hint)
        content = QWidget()
        self._pages.addWidget(content)
        self.figure_words = Caption(soft=True)
        self.model = JointsModel(self._document, self.evidence, colours)
        self.table = RowTable(self.model, several=True, room=5)
        self.table.setAccessibleName(tr("Joints and their measurements"))
        self.table.setSortingEnabled(True)
        self.table.sortByColumn(1, Qt.SortOrder.DescendingOrder)
        self.table.setMinimumHeight(60)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        self._fit_columns()
        header.sortIndicatorChanged.connect(self._sorted)
        self.table.selectionModel().selectionChanged.connect(self._select)
        self.table.selectionModel().currentChanged.connect(self._stale.mark)
        self.curve_words = Caption()
        self.plot = TracePlot(colours)
        self.plot.setAccessibleName(tr("Selected measure of the joint over time"))
        self.plot.setToolTip(tr("Click to go to the frame"))
        self.plot.asked.connect(self._document.go_to)
        over_time = QWidget()
        vbox(self.curve_words, (self.plot, 1), owner=over_time, margins=(0, 0, 0, 0), spacing=2)
        self.page = TrackPage(self._document, self.tracked, colours, self._actions)
        self.page.all_asked.connect(lambda: self.choose(*self.model.rows))
        split = QSplitter(Qt.Orientation.Vertical, childrenCollapsible=False)
        for place, (part, stretch) in enumerate(((self.table, 3), (over_time, 2))):
            split.addWidget(part)
            split.setStretchFactor(place, stretch)
        self.tabs = QTabWidget(documentMode=True)
        self.tabs.setAccessibleName(tr("Quality pages"))
        self.tabs.addTab(split, tr("Joints"))
        self.tabs.addTab(self.page, tr("Track with QuaMo"))
        vbox((self.tabs, 1), self.figure_words, owner=content, margins=(8, 2, 8, 6), spacing=4)

    def set_seen(self, seen: bool) -> None:
        """Start computing measures because the tab is visible, or stop if `seen` is False."""
        self.evidence.watch(seen)
        if seen:
            self._stale.mark()

    def stop(self) -> None:
        """Stop all computations, because the window is closing."""
        self.evidence.watch(False)
        self.evidence.stop()

    # -- the selection ------------------------------------------------------------------------

    @property
    def joint(self) -> int | None:
        """The index of the joint whose curve is drawn.

        None if no row or the row of the figure's position is selected.
        """
        index = self.table.currentIndex()
        number = self.model.things[index.row()].number if index.isValid() else None
        return None if number == len(self.model.names) else number

    @property
    def chosen(self) -> tuple[str, ...]:
        """The names of the rows to track, in the order of the skeleton.

        These are the selected rows or, if the user has not selected any, all rows. The row of the
        figure's position comes last.
        """
        if not self._picked:
            return tuple(self.model.rows)
        rows = self.table.selectionModel().selectedRows()
        chosen = sorted(self.model.things[r.row()].number for r in rows)
        return tuple(self.model.rows[j] for j in chosen)

    def choose(self, *names: str) -> None:
        """Select rows by name, and draw the curve of the first one."""
        numbers = [self.model.rows.index(name) for name in names]
        rows = [row for n in numbers if (row := self.model.row_of(n)) is not None]
        if not rows:
            return
        picked = QItemSelection()
        for row in rows:
            picked.select(self.model.index(row, 0), self.model.index(row, 0))
        flags = QItemSelectionModel.SelectionFlag
        self.table.setCurrentIndex(self.model.index(rows[0], 0))
        self.table.selectionModel().select(picked, flags.ClearAndSelect | flags.Rows)

    def _select(self) -> None:
        self._picked = True
        self._stale.mark()

    def track_burst(self, interval: Interval) -> None:
        """Smooth the joints of a noise burst, but only in the frames of the burst.

        Bursts that were smoothed earlier stay smoothed.
        """
        if (data := self._document.data) is None:
            return
        known = self._document.review.state.tracking
        if (tracking := settings_to_smooth_noise_bursts(data.motion, interval, known)) is not None:
            self.page.ask_for(tracking)

    def show_tracking(self) -> None:
        """Show the page for tracking joints."""
        self.tabs.setCurrentWidget(self.page)

    def show_joints(self, names: Sequence[str], *, track: bool) -> None:
        """Select joints as soon as the table lists them.

        If `track` is True, also show the tracking page; if not, show the joints page.
        """
        self.tabs.setCurrentIndex(self.tabs.indexOf(self.page) if track else 0)
        self._pending = tuple(names)
        self._select_pending()

    def _select_pending(self) -> bool:
        """Select the joints that `show_joints` could not select yet.

        Returns False if there are no such joints or if the table does not list them yet.
        """
        pending = tuple(name for name in self._pending if name in self.model.rows)
        if not pending or self.evidence.known is None or not self.model.rowCount():
            return False
        self._pending = ()
        self.choose(*pending)
        return True

    def _forget_pending(self) -> None:
        self._pending = ()

    def track(self) -> None:
        """Track the selected joints with the settings on the tracking page."""
        if self._actions["track_joints"].isEnabled():
            self.tabs.setCurrentWidget(self.page)
            self.page.ask(self.chosen, self.model.place)

    # -- following ----------------------------------------------------------------------------

    def _values_changed(self) -> None:
        """Show new quality measures or the measures of a new clip, and select the worst joint."""
        self.model.reset()
        if not self._select_pending() and self.model.rowCount():
            self.table.setCurrentIndex(self.model.index(0, 0))
            self._picked = False
        self._stale.mark()

    def _follow_chain(self) -> None:
        """Select the parent joint of the selected chain."""
        if self.model.rowCount() and self._document.chain:
            parent = self._document.find_chain(self._document.chain).parent
            picked = self._picked
            self.choose(self.model.names[parent])
            self._picked = picked

    def _fit_columns(self) -> None:
        """Make the columns as narrow as their headings, so that the joints' names have room."""
        advance, table = self.table.fontMetrics().horizontalAdvance, self.table
        by = table.horizontalHeader().sortIndicatorSection()
        for column in range(1, len(self.model.heads)):
            longest = _PAIR if column == 1 and self.model.after is not None else _SAMPLE
            width = max(map(advance, (longest, *self.model.heads[column].split("\n"))))
            mark = table.mark_room if column == by else 0
            table.setColumnWidth(column, width + mark + _PAD)

    def _sorted(self, column: int, order: Qt.SortOrder) -> None:
        del order
        self._fit_columns()
        if column > 0:
            self.measure = column - 1
            self._stale.mark()

    def refresh(self) -> None:
        """Update all parts of the tab."""
        self._stale.take()
        known, data = self.evidence.known, self._document.data
        chosen = self.chosen
        tracking = self._document.review.state.tracking if data else None
        self._actions["track_joints"].setEnabled(bool(chosen) and not self.tracked.running)
        picked, result = self._picked, self.tracked.result
        self.model.mark_tracked(
            frozenset(tracking.joints if tracking else ()),
            place=tracking is not None and tracking.place,
            after=result.joints if result and tracking else None,
        )
        self._picked = picked
        self._fit_columns()
        self._pages.setCurrentIndex(1 if known else 0)
        if known is None:
            working = tr("Measuring every joint …")
            self.hint.setText(working if self.evidence.running else _EMPTY)
            return
        self._show_figure()
        self._show_curve()
        name = self.model.names[self.joint] if self.joint is not None else ""
        self.page.refresh(chosen, name, self.model.rows, self.model.place)

    def _show_figure(self) -> None:
        known, result = self.evidence.known, self.tracked.result
        if known is None or known.figure is None:
            self.figure_words.set_text(plural("{n} joint", "{n} joints", len(self.model.names)))
            return
        text = tr(
            "Figure: jitter {jitter:.2f} mm/frame³ at 25 Hz, foot slide {slide:.1f} %",
            jitter=known.figure.jitter,
            slide=known.figure.foot_slide,
        )
        if result is not None and result.quality is not None:
            before, after = result.quality
            text = tr(
                "Figure, corrected {tracked}: jitter {was:.2f} → {now:.2f} mm/frame³ at 25 Hz, "
                "foot slide {slid:.1f} → {slides:.1f} %, deviation {deviation:.1f} mm",
                tracked=coloured_rich_text(tr("→ tracked"), self._colours.theme.tracked),
                was=before.jitter,
                now=after.jitter,
                slid=before.foot_slide,
                slides=after.foot_slide,
                deviation=after.deviation,
            )
        self.figure_words.set_text(text)

    def _show_curve(self) -> None:
        known, joint = self.evidence.known, self.joint
        measure = MEASURES[self.measure]
        if known is None or joint is None:
            self.plot.show_lines(())
            on_place = self.table.currentIndex().isValid()
            self.curve_words.set_text(
                tr("{place} has no measurements.", place=bold(self.model.place))
                if on_place
                else tr("Select a joint.")
            )
            return
        y = known.curve(self.measure, joint)
        frames = len(y)
        # Dots, because a line would not show a foot that is on the ground for one frame.
        line = Trace(np.arange(frames, dtype=float), y, "before", dots=measure.seldom)
        lines = [line]
        if self.model.after is not None and self.measure != _WRITTEN:
            after = quality_measure_by_frame(self.model.after, self.measure, joint)
            lines.append(Trace(line.x, after, "tracked", dots=measure.seldom))
        self.plot.show_lines(lines)
        self.plot.show_level(measure.level)
        self.plot.count_from(self._document.first_frame)
        self.plot.fit(frames)
        self._move(self._document.frame)

    def _move(self, frame: int) -> None:
        """Move the playhead of the plots, and show the values in this frame."""
        self.plot.show_frame(frame)
        self.page.go_to(frame)
        known, joint, measure = self.evidence.known, self.joint, MEASURES[self.measure]
        if known is None or joint is None:
            return
        value = known.curve(self.measure, joint)[frame]
        now = f"{value:.3g} {measure.curve_unit}" if np.isfinite(value) else "–"
        self.curve_words.set_text(f"{bold(self.model.names[joint])} &nbsp;{measure.curve}: {now}")
        self._rest.start()

    def _describe(self) -> None:
        """Set the descriptions of the plots for screen readers to the displayed values."""
        self.plot.setAccessibleDescription(plain_text(self.curve_words.text()))
        self.page.describe()
