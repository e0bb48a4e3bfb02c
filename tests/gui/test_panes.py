"""The panes of the time line: a file in the folder is a pane, and nothing else is to be done."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from inspector.timeline import panes
from inspector.timeline.plot import plots
from inspector.timeline.timeline import Timeline
from inspector.widgets.theme import DARK, Colours
from twistcore.detection.paper import paper_detector_running_offset
from twistcore.skeleton.rotation import wrap

SPEED = """
import numpy as np

from inspector.timeline.pane import CurveStyle
from inspector.timeline.plot import Plot


def draw(curves, pane):
    pane.set_curve("frames", np.arange(len(curves.strength), dtype=float))
    pane.show_values(0.0, float(len(curves.strength)))


plot = Plot(
    key="speed",
    title="Frames so far",
    place=45,
    weight=1,
    priority=0,
    axis=lambda _: "frames",
    draw=draw,
    describe=lambda _, frame: [(f"at {frame}", "text")],
    styles=(CurveStyle("frames", "text"),),
)
"""


@pytest.fixture
def one_more(tmp_path, monkeypatch):
    """A pane of a file in another folder, as if it were in ours."""
    (tmp_path / "speed.py").write_text(SPEED)
    monkeypatch.setattr(panes, "__path__", [*panes.__path__, str(tmp_path)])
    plots.cache_clear()
    yield "speed"
    plots.cache_clear()
    sys.modules.pop(f"{panes.__name__}.speed", None)


def test_panes_are_ordered_by_place():
    assert list(plots()) == ["why", "theta", "delta", "height", "strength", "other", "offset"]
    assert len({plot.priority for plot in plots().values()}) == len(plots())
    assert [key for key, plot in plots().items() if plot.takes_tau] == ["strength"]


def test_a_file_is_a_pane(qtbot, document, one_more):
    timeline = Timeline(document, Colours(DARK))
    qtbot.addWidget(timeline)
    timeline.resize(600, 900)
    timeline.show()
    timeline.refresh()
    keys = list(timeline.panes)
    assert keys[keys.index("strength") + 1] == one_more
    assert one_more in timeline.grid.shown
    pane = timeline.panes[one_more]
    assert len(pane.values["frames"][0]) == document.frames
    assert pane.front.values == "frames"
    assert pane.front.title == [(f"at {document.frame}", "text")]
    assert pane.accessibleName() == "Frames so far"
    assert timeline.toggles[one_more].text() == "Frames so far"
    timeline.toggles[one_more].setChecked(False)
    assert one_more not in timeline.grid.shown


def test_where_room_is_short_the_pane_of_least_priority_goes(qtbot, document, one_more):
    timeline = Timeline(document, Colours(DARK))
    qtbot.addWidget(timeline)
    timeline.resize(300, 150)
    timeline.show()
    timeline.refresh()
    assert timeline.grid.shown == [one_more]


def test_the_papers_offset_is_drawn_next_to_the_removed_one(qtbot, document):
    timeline = Timeline(document, Colours(DARK))
    qtbot.addWidget(timeline)
    timeline.resize(600, 900)
    timeline.show()
    document.select_chain("LeftForeArm")
    timeline.refresh()
    pane, tau = timeline.panes["offset"], document.review.state.tau["LeftForeArm"]
    signals = document.data.signals["LeftForeArm"]
    expected = np.degrees(wrap(paper_detector_running_offset(signals, tau)))
    np.testing.assert_allclose(pane.values["running"][0], expected, atol=1e-9)
    document.set_tau(2.0 * tau)
    timeline.refresh()
    expected = np.degrees(wrap(paper_detector_running_offset(signals, 2.0 * tau)))
    np.testing.assert_allclose(pane.values["running"][0], expected, atol=1e-9)
    assert "paper's offset" in "".join(text for text, _ in pane.front.title)
    # In an exercise it would show where the hidden errors are, as would all other panes but one.
    document.show_clip(replace(document.data, blind=True))
    document.select_chain("LeftForeArm")
    timeline.refresh()
    assert timeline.grid.shown == ["delta"]
