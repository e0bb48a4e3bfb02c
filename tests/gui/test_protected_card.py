"""What the card says of a correction that makes something worse."""

from dataclasses import replace

import numpy as np
import pytest

from inspector.panels.detail_card import explanation
from inspector.panels.protected_words import protected_measures_table, worsened_measures_sentence
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip
from twistcore.analysis.clip_analysis import analyse, detect
from twistcore.analysis.correction.protected_measures import (
    ENDS,
    HINGE,
    NAMES,
    PATH,
    ROLL,
    TURNS,
    UNITS,
    ProtectedMeasure,
)
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision, Review

_GROWN = {
    HINGE: (1.0, 12.0),
    TURNS: (0.0, 2.0),
    ROLL: (3.0, 35.0),
    PATH: (50.0, 60.0),
    ENDS: (0, 3),
}


def measure(name, *, worse=True):
    before, after = _GROWN[name]
    return ProtectedMeasure(name, UNITS[name], before, after, worse, "LeftHand", "wrist")


def test_a_line_says_what_gets_worse_and_nothing_where_nothing_does():
    assert worsened_measures_sentence([measure(name, worse=False) for name in NAMES]) == ""
    line = worsened_measures_sentence([measure(ROLL), measure(TURNS, worse=False), measure(PATH)])
    assert "35°" in line
    assert "20 %" in line
    assert "faster than any body" not in line


def test_the_table_has_every_measure_and_marks_what_is_worse():
    table = protected_measures_table([measure(name, worse=name == HINGE) for name in NAMES]).split(
        "\n"
    )
    assert len(table) == len(NAMES)
    assert [("(worse)" in line) for line in table] == [name == HINGE for name in NAMES]
    assert "1.0 → 12.0°" in table[0]
    assert "0 → 2 frames" in table[1]


def test_a_doubt_is_said_once_and_no_other_side_is_blamed():
    found = detect(read_bvh(ASSETS / "walk_injected.bvh"))
    judged = Review.of(found).state.intervals[0]
    worse = measure(ROLL)
    evidence = {**judged.interval.evidence, "doubts": [worse.doubt, "so what"], "worse": [ROLL]}
    interval = replace(judged.interval, open=True, explain=lambda: evidence)
    printed = explanation(
        replace(judged, interval=interval), found.analysis.chain(interval.chain), 0, [worse]
    )
    assert printed.count(worse.doubt) == 1
    assert "so what" in printed
    assert "Not corrected automatically:" not in printed


def test_a_correction_by_hand_that_makes_something_worse_is_told_and_stays_possible(qtbot, window):
    open_clip(qtbot, window, ASSETS / "walk_injected.bvh")
    act(window, "next_interval")
    document, detail = window.document, window.detail
    assert "makes this worse" not in detail.why.text()
    assert "→" in detail.why.toolTip()
    delta = float(np.degrees(document.interval.interval.shown))
    detail.delta.setValue(-delta)  # twice the error instead of none
    assert detail.why.text()
    assert "(worse)" in detail.why.toolTip()
    own = document.interval_id
    act(window, "accept")
    assert document.found(own).decision == Decision.ACCEPTED
    document.select_interval(own)
    assert detail.why.text()
    act(window, "undo")
    act(window, "undo")
    document.select_interval(own)
    assert "makes this worse" not in detail.why.text()


def test_a_find_that_was_left_open_has_the_reason_in_its_card():
    found = analyse(read_bvh(ASSETS / "walk.bvh"))
    offset = np.full(10, np.radians(35.0))
    judged = Review.of(detect(read_bvh(ASSETS / "walk_injected.bvh"))).state.intervals[0]
    made_up = replace(
        judged.interval, chain="LeftForeArm", start=100, stop=110, offset=offset, explain=None
    )
    left = found.protected(made_up)
    assert left.open
    told = explanation(replace(judged, interval=left), found.chain("LeftForeArm"), 0)
    assert "wrist" in told


@pytest.mark.parametrize("name", NAMES)
def test_every_measure_has_its_doubt(name):
    assert measure(name).doubt
