"""The plot that shows why an interval is listed: the kind's quantity, its limit and its number."""

import math
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtGui import QColor

from inspector.timeline.timeline import Timeline
from inspector.widgets.signed_numbers import format_number
from inspector.widgets.theme import LIGHT, Colours
from tests.gui.pictures import INJECTED
from tests.gui.windows import open_clip
from tests.tiers import parametrize
from tests.twistcore.test_quantities import MOTIONS, WALK
from twistcore import read_clip, write_clip
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import with_offset_of_size
from twistcore.review import Decision

SAMPLE = read_clip("assets/walk.bvh")


@pytest.fixture
def show_timeline(qtbot, open_document, tmp_path_factory):
    """The timeline of the walk with an error of a kind, which is selected."""

    def show(kind, *, width=1280):
        path = tmp_path_factory.mktemp("clip") / "clip.bvh"
        write_clip(SAMPLE, MOTIONS[kind](), path)
        document = open_document(path)
        timeline = Timeline(document, Colours(LIGHT))
        qtbot.addWidget(timeline)
        timeline.resize(width, 700)
        with qtbot.waitExposed(timeline):
            timeline.show()
        select(document, kind)
        return timeline

    return show


def select(document, kind):
    judged = next(j for j in document.intervals if j.interval.kind == kind)
    document.select_interval(judged.id, jump=True)
    return judged


def shown(qtbot, timeline):
    """The plot's quantity, once it is computed."""
    pane = timeline.panes["why"]
    qtbot.waitUntil(lambda: not timeline._stale.pending and pane.quantity is not None)
    return pane.quantity


def words(timeline):
    return "".join(text for text, _ in timeline.panes["why"].front.title)


@parametrize("kind", [kind for kind in MOTIONS if kind != Kind.HELPER_ROLL], quick=2)
def test_it_is_the_first_plot_and_shows_the_number_on_the_card(qtbot, show_timeline, kind):
    timeline = show_timeline(kind)
    quantity, pane = shown(qtbot, timeline), timeline.panes["why"]
    interval = timeline.document.interval.interval
    assert timeline.grid.shown[0] == "why"
    frame, unit = timeline.document.frame, quantity.unit
    value, limit = (
        f"{format_number(curve[frame])}{unit}" for curve in (quantity.values, quantity.limit)
    )
    assert words(timeline) == f"{quantity.label} {value}   limit {limit}"
    if kind in {Kind.SPIKE, Kind.JOINT_JUMP, Kind.BODY_STEP}:
        assert f"{format_number(math.degrees(interval.size))}°" in words(timeline)
    # The dot is at the number, within the interval, and beyond the limit, which is visible.
    ((height, _),) = pane.dot.dots
    assert interval.start <= pane.dot.frame < interval.stop
    sign = np.sign(quantity.size)
    assert sign * height > sign * quantity.limit[pane.dot.frame] or kind == Kind.NOISE_BURST
    low, high = pane.view.viewRange()[1]
    assert low < min(height, quantity.limit[pane.dot.frame], quantity.size)
    assert high > max(height, quantity.limit[pane.dot.frame], quantity.size)
    spot = pane.view.scenePos()
    x = spot.x() + pane.dot.place(pane.dot.frame)
    y = spot.y() + (high - height) / (high - low) * pane.view.height()
    assert pane.grab().toImage().pixelColor(round(x), round(y)) == QColor(LIGHT.before)


def test_it_follows_the_selection(qtbot, show_timeline):
    timeline = show_timeline(Kind.STRETCH)
    document, pane = timeline.document, timeline.panes["why"]
    roll = shown(qtbot, timeline)
    jump = select(document, Kind.LONE_JUMP)
    qtbot.waitUntil(lambda: pane.quantity not in (None, roll))
    assert "per frame" in words(timeline)
    document.go_to(jump.interval.start + 5)
    assert format_number(pane.quantity.values[document.frame]) in words(timeline)
    document.select_interval(None)
    timeline.refresh()
    assert "why" not in timeline.grid.shown
    document.opened.emit()
    assert pane.quantity is None
    assert not len(pane.values["value"][0])


def test_the_number_in_its_title_is_at_the_playhead_when_it_comes_back(qtbot, show_timeline):
    """The playhead also moves while the plot is hidden, for example between undo and redo."""
    timeline = show_timeline(Kind.STRETCH)
    document, quantity = timeline.document, shown(qtbot, timeline)
    stretch = document.interval
    document.select_interval(None)
    timeline.refresh()
    assert "why" not in timeline.grid.shown
    document.go_to(stretch.interval.start - 5)
    document.select_interval(stretch.id)
    timeline.refresh()
    assert f" {format_number(quantity.values[document.frame])}{quantity.unit} " in words(timeline)


def test_an_edited_stretch_shows_its_new_angle(qtbot, show_timeline):
    timeline = show_timeline(Kind.STRETCH)
    document, pane = timeline.document, timeline.panes["why"]
    before = shown(qtbot, timeline)
    judged = document.interval
    document.edit(judged.id, with_offset_of_size(judged.interval, math.radians(150.0)))
    timeline.refresh()
    assert len(pane.values["value"][0]) == document.frames  # it stays until the new one is there
    qtbot.waitUntil(lambda: pane.quantity is not before)
    assert pane.quantity.size == pytest.approx(150.0)
    document.decide(Decision.ACCEPTED)
    document.review.mark_saved()


def test_twist_errors_have_none_and_neither_has_an_exercise(qtbot, open_document, show_timeline):
    timeline = show_timeline(Kind.SPIKE)
    shown(qtbot, timeline)
    document = timeline.document
    document.show_clip(replace(document.data, blind=True))
    select(document, Kind.SPIKE)
    timeline.refresh()
    assert "why" not in timeline.grid.shown
    assert timeline.panes["why"].quantity is None


def test_a_hidden_plot_computes_nothing_until_it_is_shown(qtbot, show_timeline):
    timeline = show_timeline(Kind.SPIKE)
    shown(qtbot, timeline)
    pane = timeline.panes["why"]
    timeline.toggles["why"].setChecked(False)
    pane.forget()
    timeline.document.select_interval(None)
    timeline.refresh()
    select(timeline.document, Kind.SPIKE)
    timeline.refresh()
    qtbot.wait(50)
    assert pane.quantity is None
    timeline.toggles["why"].setChecked(True)
    assert shown(qtbot, timeline).unit == "°"


def test_a_figure_has_it_at_once(show_timeline):
    timeline = show_timeline(Kind.SPIKE)
    timeline.become_figure()
    timeline.panes["why"].forget()
    timeline.document.select_interval(None)
    timeline.refresh()
    select(timeline.document, Kind.SPIKE)
    timeline.refresh()
    assert timeline.panes["why"].quantity is not None


def test_a_quantity_that_fails_says_why_and_the_window_goes_on(qtbot, show_timeline, monkeypatch):
    info = replace(Kind.SPIKE.info, quantity="no.such.module:curve")
    monkeypatch.setattr(Kind.SPIKE, "info", info)
    timeline = show_timeline(Kind.SPIKE)
    qtbot.waitUntil(lambda: "cannot be computed" in words(timeline))
    assert "why" in timeline.grid.shown


def test_the_window_shows_it(qtbot, window, tmp_path):
    path = Path(shutil.copy(INJECTED, tmp_path / "walk.bvh"))
    open_clip(qtbot, window, path)
    window.document.select_interval(window.document.intervals[0].id)
    qtbot.wait(50)
    assert "why" not in window.timeline.grid.shown
    assert WALK.frames == window.document.frames
