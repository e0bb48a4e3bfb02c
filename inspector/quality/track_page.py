"""The tracking page: a warning, the settings for tracking, and the effect on one joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QButtonGroup,
    QDoubleSpinBox,
    QGridLayout,
    QLabel,
    QProgressBar,
    QRadioButton,
    QSizePolicy,
    QStackedWidget,
    QWidget,
)

from inspector.language import plural, tr, tr_as, translate_core_sentence
from inspector.quality.tracked_clip import Tracked
from inspector.session.document import Document
from inspector.widgets.building import (
    Wrapping,
    action_button,
    hbox,
    tool_button,
    use_secondary_text_colour,
    vbox,
)
from inspector.widgets.labels import (
    Caption,
    bold,
    coloured_rich_text,
    escape_tool_tip_text,
    plain_text,
)
from inspector.widgets.theme import Colours, Theme
from inspector.widgets.traces import Trace, TracePlot
from twistcore.quamo import Gains
from twistcore.quamo.clip_tracking import (
    DEMONSTRATION,
    WARNING,
    Traces,
    network_weights_identifier,
    supports_learned_tracking,
)
from twistcore.quamo.response import (
    describe_tracker_lag_and_overshoot,
    steady_tracking_lags,
    tracking_overshoots,
)
from twistcore.quamo.spline import default_spline_cutoff
from twistcore.review import Tracking
from twistcore.skeleton.motion import Skeleton

_GAINS = (("κP", "kp", 1000.0, "/s²"), ("κD", "kd", 30.0, "/s"), ("κA", "ka", 1000.0, ""))
_GAIN_ROLES = ("before", "after", "accepted")
_PARTS = ("P", "D", tr("bias"), tr("acc."))
_CHANGE_ROLES = ("before", "tracked")
_PART_ROLES = ("before", "after", "undecided", "accepted")
_ADVICE = tr(
    "For a file, use the spline, which leaves the least jitter. The tracker (both "
    "ways or causal) is meant for data streams."
)
_LEAST_HIGH = 90  # minimum height of a plot in pixels
_HIGHEST = 10000.0  # largest gain; no frame rate needs more


class TrackPage(QWidget):
    """A page on which the user sets up the tracking of joints and sees the result.

    Its buttons trigger actions of the window.
    """

    all_asked = Signal()

    def __init__(
        self, document: Document, tracked: Tracked, colours: Colours, actions: Mapping[str, QAction]
    ) -> None:
        super().__init__()
        self._document, self._tracked, self._colours = document, tracked, colours
        self._joint = ""
        self._shown: tuple[object, ...] = ()
        self._reviewed_last: Tracking | None = None  # tracking in the review at the last check
        # The latest request from this page, which may be newer
        self._requested: Tracking | None = None
        self._build(actions)
        colours.follow(self._colour)
        self.take_clip()
        document.opened.connect(self.take_clip)
        document.intervals_changed.connect(self._follow_review)
        tracked.progress.connect(lambda share: self.bar.setValue(round(100.0 * share)))

    def _build(self, actions: Mapping[str, QAction]) -> None:
        self.warning = Caption()
        self.boxes: dict[str, QDoubleSpinBox] = {}
        self._usual: dict[str, float] = {}  # default gains for the clip and the direction
        self._reviewed: dict[str, float] = {}  # gains that were set from a review
        self.hand, self.learned = (
            QRadioButton(tr_as("gains", "Manual")),
            QRadioButton(tr_as("gains", "Learned")),
        )
        self.learned.setToolTip(
            tr(
                "Gains from the neural networks, at 25 Hz; only for the 24 joints of the CMU or "
                "SMPL skeleton"
            )
        )
        self.spline = QRadioButton(tr("Spline"))
        self.spline.setToolTip(tr("Smooth the whole clip with a spline, without lag"))
        self.both_ways, self.causal = QRadioButton(tr("Both ways")), QRadioButton(tr("Causal"))
        self.both_ways.setToolTip(
            tr("Track forwards and backwards over the whole clip, without lag")
        )
        ways = (self.spline, self.both_ways, self.causal)
        for several in ((self.hand, self.learned), ways):
            group = QButtonGroup(self)
            for button in several:
                group.addButton(button)
        self.spline.setChecked(True)
        self.advice = use_secondary_text_colour(QLabel(_ADVICE, wordWrap=True))
        self.cutoff = QDoubleSpinBox(minimum=0.1, maximum=_HIGHEST, prefix=tr("cut-off "))
        self.cutoff.setSuffix(" Hz")
        self.cutoff.setToolTip(tr("Motion at this frequency keeps half of its amplitude"))
        self.cutoff.setAccessibleName(tr("Cut-off of the spline in Hz"))
        for symbol, name, _, unit in _GAINS:
            box = QDoubleSpinBox(maximum=_HIGHEST, prefix=f"{symbol} ")
            box.setDecimals(1 if name == "kd" else 0)
            box.setSingleStep(5.0 if name == "kd" else 50.0)
            gain = tr("Gain, set by hand")
            box.setToolTip(f"{gain}{unit and f', 1{unit}'}")
            box.setAccessibleName(f"{gain} {symbol}")
            self.boxes[name] = box
        self._show_usual(Gains())
        self.hand.setChecked(True)
        self.hand.toggled.connect(self._enable)
        for button in ways:
            button.toggled.connect(self._show_usual_of_clip)
            button.toggled.connect(self._enable)
        self.bar = QProgressBar(textVisible=False, minimum=0, maximum=100)
        self.bar.setFixedWidth(60)
        self.buttons = QStackedWidget()
        short = {
            "track_joints": tr("Track"),
            "stop_tracking": tr_as("tracking", "Stop"),
            "cancel_tracking": tr("Cancel"),
        }
        track, stop, cancel = (action_button(actions[name], word) for name, word in short.items())
        for inside in ((track, stop), (self.bar, cancel)):
            side = QWidget()
            hbox(*inside, owner=side, margins=(0, 0, 0, 0), spacing=4)
            self.buttons.addWidget(side)
        self.joints = use_secondary_text_colour(QLabel())
        self.joints.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self.buttons.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.all = tool_button(
            tr_as("joints", "All"), tr("Select every joint and the figure's position"), flat=False
        )
        self.all.clicked.connect(self.all_asked)
        self.done = Caption(soft=True)
        self.done.hide()
        self.change_words = Caption()
        self.change = TracePlot(self._colours)
        self.gain_words, self.part_words = Caption(), Caption()
        self.gains, self.parts = TracePlot(self._colours, " %"), TracePlot(self._colours)
        for plot, name in (
            (self.change, tr("Acceleration of the bone's end before and after tracking, in m/s²")),
            (self.gains, tr("Gains κP, κD and κA over time, as percentages of 1000, 30 and 1000")),
            (self.parts, tr("Components of the tracker's acceleration over time, in rad/s²")),
        ):
            plot.setAccessibleName(name)
            plot.setMinimumHeight(_LEAST_HIGH)
            plot.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Ignored)
            plot.setToolTip(f"{name}. {tr('Click to go to the frame')}")
            plot.asked.connect(self._document.go_to)
        drawn = QWidget()
        self._grid = plots = QGridLayout(drawn)
        plots.setContentsMargins(0, 0, 0, 0)
        plots.setSpacing(2)
        for column, (words, plot) in enumerate(
            ((self.gain_words, self.gains), (self.part_words, self.parts))
        ):
            plots.addWidget(words, 2, column, Qt.AlignmentFlag.AlignBottom)
            plots.addWidget(plot, 3, column)
            plots.setColumnStretch(column, 1)
        plots.addWidget(self.change_words, 0, 0, 1, 2)
        plots.addWidget(self.change, 1, 0, 1, 2)
        plots.setRowStretch(1, 1)
        of_gains = hbox(self.hand, self.learned, None, spacing=4)
        choices = Wrapping(hbox(*ways, None, spacing=4), of_gains, spacing=4)
        boxes = hbox(*self.boxes.values(), self.cutoff, None, spacing=4)
        acting = hbox((self.joints, 1), self.all, self.buttons, spacing=6)
        content = self.warning, self.advice, choices, boxes, acting, self.done, (drawn, 1)
        vbox(*content, owner=self, margins=(0, 4, 0, 0), spacing=3)

    def _colour(self, theme: Theme) -> None:
        self.warning.set_text(
            f"{coloured_rich_text(f'⚠ {translate_core_sentence(WARNING)}', theme.warning)} "
            f"{translate_core_sentence(DEMONSTRATION)}"
        )

    def tracking(self, chosen: Sequence[str], place: str) -> Tracking:
        """Return a request to track some rows of the table with this page's settings.

        `chosen` contains the names of these rows, and `place` is the name of the row for the
        figure's position.
        """
        joints = tuple(name for name in chosen if name != place)
        if self.spline.isChecked():
            place_too, cutoff = len(joints) < len(chosen), self.cutoff.value()
            return Tracking(joints, causal=False, place=place_too, spline=True, cutoff=cutoff)
        plain = Tracking(joints, causal=self.causal.isChecked(), place=len(joints) < len(chosen))
        if self.learned.isChecked():
            return replace(plain, learned=True, weights=network_weights_identifier())
        kp, kd, ka = (self.boxes[name].value() for _, name, _, _ in _GAINS)
        return replace(plain, kp=kp, kd=kd, ka=ka)

    def ask(self, chosen: Sequence[str], place: str) -> None:
        """Track some rows of the table with this page's settings; see `tracking`."""
        self.ask_for(self.tracking(chosen, place))

    def ask_for(self, tracking: Tracking) -> None:
        """Start the requested tracking, and remember the request."""
        self._requested = tracking
        self._tracked.ask(tracking)

    def take_clip(self) -> None:
        """Show the tracking settings from the review of the new clip."""
        data = self._document.data
        self.learned.setEnabled(data is not None and supports_learned_tracking(data.motion))
        self._reviewed_last = self._document.review.state.tracking if data else None
        self._requested = None
        # The value belongs to the previous clip, unless the user has changed it
        for name, value in self._reviewed.items():
            if self.boxes[name].value() == value:
                self.boxes[name].setValue(self._usual[name])
        self._reviewed = {}
        self.spline.setChecked(True)
        self.hand.setChecked(True)
        if data is not None:
            self.cutoff.setValue(default_spline_cutoff(data.motion.frame_time))
        self._show_usual_of_clip()
        self._enable()
        if self._reviewed_last is not None:
            self._show(self._reviewed_last)

    def _follow_review(self) -> None:
        """Show the review's tracking settings after an undo, a redo or a journal's restoration."""
        tracking = self._document.review.state.tracking if self._document.data else None
        if tracking == self._reviewed_last:
            return
        self._reviewed_last = tracking
        requested, self._requested = self._requested, None
        if tracking is not None and tracking is not requested:
            self._show(tracking)

    def _show(self, tracking: Tracking) -> None:
        """Show the settings of a tracking request."""
        if tracking.spline:
            self.spline.setChecked(True)
            if not tracking.bursts:  # bursts have cut-offs of their own
                self.cutoff.setValue(tracking.cutoff)
            return
        (self.causal if tracking.causal else self.both_ways).setChecked(True)
        learned = tracking.learned and self.learned.isEnabled()
        (self.learned if learned else self.hand).setChecked(True)
        if not tracking.learned:
            for name, box in self.boxes.items():
                box.setValue(getattr(tracking, name))
                self._reviewed[name] = box.value()

    def _show_usual_of_clip(self) -> None:
        if (data := self._document.data) is None:
            return
        dt = data.motion.frame_time
        self._show_usual(Gains.by_hand(dt, causal=self.causal.isChecked()))
        self.causal.setToolTip(
            tr(
                "Track frame by frame, without looking ahead. With the default gains, {response}",
                response=translate_core_sentence(_causal_words(dt)),
            )
        )

    def _show_usual(self, gains: Gains) -> None:
        """Show the default gains for the clip, except for gains that the user has changed."""
        for name, box in self.boxes.items():
            before = box.value()
            chosen = before != self._usual.get(name, before)
            box.setValue(float(getattr(gains, name)))
            self._usual[name] = box.value()  # rounded by the field
            if chosen:
                box.setValue(before)

    def _enable(self) -> None:
        spline = self.spline.isChecked()
        for box in self.boxes.values():
            box.setEnabled(self.hand.isChecked())
            box.setVisible(not spline)
        for button in (self.hand, self.learned):
            button.setVisible(not spline)
        self.cutoff.setVisible(spline)
        self._show_plots()

    def _show_plots(self) -> None:
        """Show the plots that have curves, and hide the others."""
        for part in (self.change_words, self.change):
            part.setVisible(self._tracked.result is not None)
        shown = not self.spline.isChecked() or self._traces() is not None
        for part in (self.gain_words, self.part_words, self.gains, self.parts):
            part.setVisible(shown)
        self._grid.setRowStretch(3, int(shown))

    def refresh(self, chosen: Sequence[str], joint: str, rows: Sequence[str], place: str) -> None:
        """Show the selected joints and the result of tracking.

        Parameters
        ----------
        chosen
            The names of the selected rows.
        joint
            The joint whose curves are drawn, if it is tracked.
        rows
            The names of all rows.
        place
            The name of the row for the figure's position.
        """
        self.buttons.setCurrentIndex(1 if self._tracked.asked is not None else 0)
        if self._tracked.asked is None:
            self.bar.setValue(0)
        result = self._tracked.result
        names = result.traces.names if result else ()
        self._joint = joint if joint in names else (names[0] if names else "")
        joints = _listed(chosen, place)
        every = len(chosen) == len(rows)
        listed = (
            tr("All: {joints}", joints=joints) if every else tr("Selected: {joints}", joints=joints)
        )
        text = listed if chosen else tr("Select joints in the table on the Joints page")
        self.joints.setText(text)
        self.joints.setToolTip(escape_tool_tip_text(text))
        self.all.setEnabled(len(chosen) < len(rows))
        self.done.setVisible(result is not None)
        if result is not None:
            tracking = result.wanted.tracking
            done = (*names, place) if tracking.place else names
            rest = tuple(name for name in rows if name not in done)
            if tracking.bursts:
                self.done.set_plain(
                    tr(
                        "Smoothed: {bursts} (cut-off {cutoff:.1f} Hz); other frames unchanged",
                        bursts=translate_core_sentence(tracking.what),
                        cutoff=tracking.cutoff,
                    )
                )
            else:
                self.done.set_plain(_done_words(tracking, done, rest, place))
        state = (result, self._joint, self._colours.theme, self._document.first_frame)
        if state != self._shown:
            self._shown = state
            self._draw()
            self._show_plots()
        self.go_to(self._document.frame)

    def _draw(self) -> None:
        self._draw_change()
        if (traces := self._traces()) is None:
            for plot in (self.gains, self.parts):
                plot.show_lines(())
            return
        k = traces.names.index(self._joint)
        scales = [top for _, _, top, _ in _GAINS]
        gains = [
            Trace(traces.frames, 100.0 * traces.gains[:, k, n] / scales[n], role)
            for n, role in enumerate(_GAIN_ROLES)
        ]
        parts = [Trace(traces.frames, traces.parts[:, k, n], r) for n, r in enumerate(_PART_ROLES)]
        for plot, lines in ((self.gains, gains), (self.parts, parts)):
            plot.show_lines(lines)
            plot.count_from(self._document.first_frame)
            plot.fit(self._document.frames)

    def _draw_change(self) -> None:
        """Plot the acceleration at the end of the joint's bone, before and after tracking."""
        result, frames = self._tracked.result, np.arange(self._document.frames, dtype=np.float64)
        lines = []
        if result is not None and self._joint:
            joint = _moved_by(result.motion.skeleton, self._joint)
            for values, role in zip(result.accelerations, _CHANGE_ROLES, strict=True):
                lines.append(Trace(frames, values[:, joint], role))
        self.change.show_lines(lines)
        self.change.count_from(self._document.first_frame)
        self.change.fit(self._document.frames)

    def _traces(self) -> Traces | None:
        """Return the tracker's internal values, or None if the drawn joint was not tracked."""
        traces = self._tracked.result.traces if self._tracked.result else None
        if traces is None or self._joint not in traces.names or not len(traces.frames):
            return None
        return traces

    def go_to(self, frame: int) -> None:
        """Move the playhead of the plots, and show the values in this frame."""
        for plot in (self.change, self.gains, self.parts):
            plot.show_frame(frame)
        self._show_change(frame)
        if (traces := self._traces()) is None:
            self.gain_words.set_text(tr("Tracker gains"))
            self.part_words.set_text(tr("Components of the tracker's acceleration"))
            return
        # The tracker runs at 25 Hz, so a step applies to all frames since the previous step.
        row = min(int(np.searchsorted(traces.frames, frame)), len(traces.frames) - 1)
        k = traces.names.index(self._joint)
        gains = zip(_GAINS, _GAIN_ROLES, traces.gains[row, k], strict=True)
        self.gain_words.set_text(
            f"{bold(self._joint)} "
            + " ".join(self._key(role, f"{g[0]} {v:.0f}") for g, role, v in gains)
        )
        parts = zip(_PARTS, _PART_ROLES, traces.parts[row, k], strict=True)
        self.part_words.set_text(
            " ".join(self._key(role, f"{name} {v:.0f}") for name, role, v in parts) + " rad/s²"
        )

    def _show_change(self, frame: int) -> None:
        result = self._tracked.result
        if result is None or not self._joint:
            self.change_words.set_text("")
            return
        joint = _moved_by(result.motion.skeleton, self._joint)
        parts = zip((tr("before"), tr("tracked")), result.accelerations, _CHANGE_ROLES, strict=True)
        values = [(f"{word} {_written(a[frame, joint])}", role) for word, a, role in parts]
        self.change_words.set_text(
            f"{bold(self._joint)} {tr('acceleration of the tip')} "
            + " ".join(self._key(role, text) for text, role in values)
            + " m/s²"
        )

    def describe(self) -> None:
        """Set the descriptions of the plots for screen readers to the displayed values."""
        for plot, words in (
            (self.change, self.change_words),
            (self.gains, self.gain_words),
            (self.parts, self.part_words),
        ):
            plot.setAccessibleDescription(plain_text(words.text()))

    def _key(self, role: str, text: str) -> str:
        return coloured_rich_text(f"━ {text}", getattr(self._colours.theme, role))


@lru_cache
def _causal_words(dt: float) -> str:
    """Return a text about the lag and overshoot of a joint after causal tracking.

    `dt` is the frame time in seconds. Results are cached.
    """
    usual = Gains.by_hand(dt)
    return describe_tracker_lag_and_overshoot(
        tr("a joint"), steady_tracking_lags(usual, dt)[0], tracking_overshoots(usual, dt)[0]
    )


def _moved_by(skeleton: Skeleton, name: str) -> int:
    """Return the index of a joint's first child, which moves when the joint rotates.

    If the joint has no child, return its own index.
    """
    joint = skeleton.index(name)
    return next(iter(skeleton.children[joint]), joint)


def _written(value: float) -> str:
    return f"{value:.1f}" if np.isfinite(value) else "–"


def _done_words(tracking: Tracking, done: Sequence[str], rest: Sequence[str], place: str) -> str:
    """Return a sentence about what was tracked, how it was tracked, and what was not tracked.

    `done` and `rest` contain the names of tracked and untracked rows, and `place` is the name of
    the row for the figure's position.
    """
    names, others = _listed(done, place), _listed(rest, place) or tr("nothing")
    if tracking.spline:
        return tr("Smoothed with the spline: {done}; unchanged: {rest}", done=names, rest=others)
    if tracking.causal:
        return tr("Tracked causally: {done}; untracked: {rest}", done=names, rest=others)
    return tr("Tracked both ways: {done}; untracked: {rest}", done=names, rest=others)


def _listed(names: Sequence[str], place: str) -> str:
    """Return the names of the joints as text or, for more than two joints, their number.

    If `place`, the row for the figure's position, is in `names`, it is appended to the text.
    """
    joints = [name for name in names if name != place]
    few = len(joints) <= 2
    parts = joints if few else [plural("{n} joint", "{n} joints", len(joints))]
    return tr(" and ").join([", ".join(parts)] * bool(parts) + [place] * (place in names))
