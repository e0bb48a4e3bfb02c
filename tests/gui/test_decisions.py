"""What a decision is: a rejection with its reason one step, and on a group only what was drawn."""

import json
import shutil

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from inspector.panels.reason_palette import ReasonPalette
from inspector.session.session_files import journals, session_path
from inspector.session.settings import Settings
from tests.conftest import ASSETS
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, decisions, open_clip, press, wait_until_active
from twistcore.review import Decision, recover

ONE_WINDOW = True
KEY, CTRL = Qt.Key, Qt.KeyboardModifier.ControlModifier
REASON = "fast but real"  # the second one in the palette


@pytest.fixture
def show(qtbot, window_for_clips, tmp_path):
    """A copy of a clip in the window."""

    def open_copy(path):
        window = window_for_clips(Settings(turn_ms=0, reviewer="Ada"))
        open_clip(qtbot, window, shutil.copy(path, tmp_path / path.name))
        return window

    return open_copy


def reject_for(qtbot, window, key):
    """Press Q, and a key in the palette."""
    wait_until_active(window)
    press(qtbot, window, KEY.Key_Q)
    palette = window.findChildren(ReasonPalette)[-1]
    QTest.keyClick(palette.line, key)
    qtbot.waitUntil(lambda: not palette.isVisible())


def lines(window):
    (journal,) = journals(session_path(window.document.data.clip.path))
    return [json.loads(line) for line in journal.read_text("utf-8").splitlines()[1:]]


def test_a_rejection_with_a_reason_is_undone_by_one_key(qtbot, show):
    window = show(INJECTED)
    document = window.document
    press(qtbot, window, KEY.Key_N)
    first, before = document.interval_id, document.review.state
    reject_for(qtbot, window, KEY.Key_2)
    judged = document.found(first)
    said = judged.decision, judged.reason, judged.reviewer
    assert said == (Decision.REJECTED, REASON, "Ada")
    assert document.interval_id != first  # on to the next one
    assert document.review.history == ("Reject interval",)
    assert [line["do"] for line in lines(window)] == ["RejectFor"]
    press(qtbot, window, KEY.Key_Z, CTRL)
    assert document.review.state is before
    assert document.interval_id == first
    press(qtbot, window, KEY.Key_Y, CTRL)
    assert document.found(first) == judged
    (journal,) = journals(session_path(document.data.clip.path))
    assert recover(journal, document.data.clip).review.state.find(first).reason == REASON


def test_the_reason_of_a_group_is_the_reason_of_all_its_errors(qtbot, show):
    window = show(ASSETS / "kick.bvh")
    document = window.document
    for _ in range(2):
        press(qtbot, window, KEY.Key_N)
    group = window.intervals.selected_ids()
    assert len(group) > 1
    reject_for(qtbot, window, KEY.Key_2)
    rejected = [j for j in document.intervals if j.decision == Decision.REJECTED]
    assert {j.id for j in rejected} == set(group)
    assert {j.reason for j in rejected} == {REASON}
    press(qtbot, window, KEY.Key_Z, CTRL)
    assert set(decisions(window)) == {Decision.UNDECIDED}
    assert {j.reason for j in document.intervals} == {""}


def test_a_new_reason_for_what_is_rejected_is_a_step_and_the_same_one_is_none(qtbot, show):
    window = show(INJECTED)
    document = window.document
    press(qtbot, window, KEY.Key_N)
    first = document.interval_id
    press(qtbot, window, KEY.Key_R)
    for _ in range(2):
        document.select_interval(first, jump=True)
        act(window, "zoom_to_interval")
        reject_for(qtbot, window, KEY.Key_2)
        assert document.found(first).reason == REASON
        assert document.review.position == 2
    press(qtbot, window, KEY.Key_Z, CTRL)
    assert (document.found(first).decision, document.found(first).reason) == ("rejected", "")
