"""A step of the whole body belongs to no chain: what a person reads, filters and hides."""

import json
from dataclasses import replace

import numpy as np
import pytest

from inspector.language import use_language
from inspector.panels.interval_columns import PLACE
from inspector.panels.interval_filter import FILTERS, OF_CHAIN
from inspector.panels.interval_rows import GroupRow
from inspector.reviewers.comparison_panel import DifferencesModel
from inspector.session.settings import Settings
from inspector.viewport import frame_drawing
from tests.conftest import ASSETS
from tests.gui.windows import act, open_clip
from tests.twistcore.test_all_joints import stepping
from twistcore.detection import Kind
from twistcore.detection.error_label import error_label
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import Decide, Decision, Insert, session_bytes
from twistcore.skeleton.limb import Limb
from twistcore.synthesis import InjectedError, inject

ONE_WINDOW = True
LABEL = "Whole body"
FIRST = "LeftShoulder"  # the chain that a file names


@pytest.fixture
def window(qtbot, window_for_clips, tmp_path):
    """The walk with a step of the body at frame 150, and an error of the first chain before it."""
    error = InjectedError(FIRST, 60, 80, np.full(20, np.radians(40.0)))
    path = tmp_path / "step.bvh"
    write_clip(read_bvh(ASSETS / "walk.bvh"), inject(stepping(150), [error]), path)
    window = window_for_clips(Settings(turn_ms=0))
    open_clip(qtbot, window, path)
    return window


@pytest.fixture
def step(window):
    (found,) = (j for j in window.document.intervals if j.interval.kind == Kind.BODY_STEP)
    return found


def cells(window, column):
    model = window.intervals.table.model()
    return [model.index(row, PLACE[column]).data() for row in range(model.rowCount())]


def test_the_list_the_card_the_view_and_the_history_say_whole_body(qtbot, window, step):
    document = window.document
    assert step.interval.chain == FIRST
    assert (LABEL, cells(window, "chain").count(LABEL)) == (cells(window, "chain")[0], 1)
    assert cells(window, "joints")[0] == ""
    row = window.intervals._model.row_for(window.intervals._thing(0))
    assert row.tips[0].startswith(f"{LABEL}, body step")
    assert row.spoken[0] == LABEL
    document.select_interval(step.id, jump=True)
    qtbot.waitUntil(lambda: LABEL in window.viewport.overlays.legend.text().replace("&nbsp;", " "))
    assert LABEL in window.detail.title.toolTip()
    assert "Shoulder" not in window.detail.title.toolTip()
    document.decide(Decision.ACCEPTED, [step.id])
    assert window.history.list.item(1).text() == f"Accept interval · {LABEL} 150–151"


def test_a_group_of_it_says_whole_body(window, step):
    group = GroupRow("the whole body jumps", "", (step, step), False)
    row = window.intervals._model.describe(group)
    assert row.texts[PLACE["chain"]] == f"▸ {LABEL} (2)"
    about, first, *_ = row.tips[0].split("\n")
    assert about.startswith(f"{LABEL} (2)")
    assert LABEL in first


def test_a_search_finds_it_by_its_label_and_not_by_a_chain(window, step):
    panel = window.intervals
    for words, found in (("whole body", True), ("shoulder", False), (FIRST, False)):
        panel.search.setText(words)
        assert (step.id in panel.shown_ids()) == found, words
    panel.search.clear()


def test_it_is_listed_with_every_chain_and_hidden_with_all(window, step):
    document, panel = window.document, window.intervals
    other = document.data.chains[-1].name
    panel.filter.setCurrentIndex(list(FILTERS).index(OF_CHAIN))
    for chain in (FIRST, other):
        document.select_chain(chain)
        assert step.id in panel.shown_ids()
        assert {document.found(k).interval.chain for k in panel.shown_ids()} <= {chain, FIRST}
    panel.filter.setCurrentIndex(0)
    for chain in document.data.chains_and_limbs:
        assert step.id in panel.shown_ids()
        document.set_hidden(chain.name, True)
    assert step.id not in panel.shown_ids()


def with_errors_of_another_chain(document):
    """Two errors made by hand in the forearm, one before the step and one after it."""
    for start in (50, 200):
        document.do(Insert(new_constant_offset_interval("LeftForeArm", start, start + 20, 0.4)))
    return [j for j in document.intervals if j.interval.chain == "LeftForeArm"]


def test_it_does_not_change_the_selected_chain(qtbot, window, step):
    document, panel = window.document, window.intervals
    other, _ = with_errors_of_another_chain(document)
    document.select_interval(other.id, jump=True)
    chain = document.chain
    document.select_interval(step.id, jump=True)
    assert document.chain == chain != FIRST
    qtbot.waitUntil(lambda: LABEL in window.viewport.overlays.legend.text().replace("&nbsp;", " "))
    qtbot.waitUntil(lambda: step in window.timeline.scenery.intervals)
    starts = [j.interval.start for j in window.timeline.scenery.intervals]
    assert starts == [50, 150, 200]
    document.select_chain(FIRST)
    document.select_chain(chain)
    assert document.interval == step
    document.select_interval(other.id)
    document.select_chain(FIRST)
    assert document.interval is None
    document.select_interval(other.id)
    panel.filter.setCurrentIndex(list(FILTERS).index(OF_CHAIN))
    try:
        listed = set(panel.shown_ids())
        assert step.id in listed
        seen = []
        for _ in listed:
            window.review_actions.step_interval(+1)
            seen.append(document.interval_id)
            assert document.chain == chain
            assert set(panel.shown_ids()) == listed
            document.do(Decide((document.interval_id,), Decision.ACCEPTED))
        assert step.id in seen
    finally:
        panel.filter.setCurrentIndex(0)


def test_with_a_limb_the_view_says_the_same_about_it(qtbot, window, step, monkeypatch):
    document, legend = window.document, window.viewport.overlays.legend
    limb = next(c for c in document.data.chains_and_limbs if isinstance(c, Limb))
    document.select_interval(step.id, jump=True)
    qtbot.waitUntil(lambda: LABEL in legend.text().replace("&nbsp;", " "))
    text = legend.text()
    document.select_chain(limb.name)
    assert document.interval == step
    window.viewport.refresh()
    monkeypatch.setattr(type(window.viewport.scene), "circled", False)  # as if it were straight
    assert window.viewport.drawing.legend(window.viewport.scene, window.colours.theme) == text
    monkeypatch.setattr(frame_drawing, "_SHORT", -1.0)  # the bones from the hips have no length
    assert frame_drawing.pictured_chain(document).name == step.interval.joint == "Hips"


def test_from_the_beginning_it_is_the_first_as_in_the_table(window, step):
    document = window.document
    other, _ = with_errors_of_another_chain(document)
    assert window.intervals.shown_ids()[0] == step.id
    document.set_order("chain")
    document.select_interval(None)
    document.select_chain(FIRST)
    document.go_to(0)
    document.step_interval(+1)
    assert document.interval == step
    document.select_interval(None)
    document.go_to(100)  # after an error of the chain
    document.step_interval(+1)
    assert document.interval == other


def test_the_table_of_chains_does_not_count_it(window):
    own = sum(
        j.interval.chain == FIRST and j.interval.kind != Kind.BODY_STEP
        for j in window.document.intervals
    )
    (row,) = (t for t in window.chains._model.things if t.chain == FIRST)
    assert row.found == own > 0


def test_verdicts_by_chain_say_whole_body(qtbot, window, step):
    document, page = window.document, window.tuning.kinds
    document.decide(Decision.ACCEPTED, [step.id])
    act(window, "show_tuning")
    window.tuning.tabs.setCurrentWidget(page)
    page.groups.setCurrentIndex(1)
    qtbot.waitUntil(lambda: LABEL in page.counts(), timeout=30_000)
    assert page.counts()[LABEL].score.errors == 1


def test_a_comparison_says_whole_body(window, step):
    model = DifferencesModel(window.document, window.colours)
    assert model.label(step.interval) == LABEL
    assert model.label(replace(step.interval, chain="Tail")) == LABEL
    assert model.label(replace(step.interval, chain="Tail", kind=Kind.COUNTER_TWIST)) == "Tail"
    assert window.history._label(replace(step.interval, chain="Tail")) == LABEL


def test_of_several_people_its_label_names_the_person(window, step):
    chain = replace(window.document.find_chain(FIRST), person="B")
    assert error_label(step.interval, chain) == f"B · {LABEL}"
    assert error_label(step.interval, chain, listed=True) == f"B · {LABEL}"


def test_a_session_names_the_chain(window, step):
    document = window.document
    kept = json.loads(session_bytes(document.data.clip, document.review.state))["intervals"]
    (entry,) = (e for e in kept if e["kind"] == "body step")
    assert entry["chain"] == FIRST
    assert LABEL not in json.dumps(kept)


def test_in_german(window):
    use_language("de")
    try:
        window.document.chains_changed.emit()
        window.intervals._model.redraw()
        assert cells(window, "chain")[0] == "Ganzer Körper"
    finally:
        use_language("en")
        window.intervals._model.redraw()
