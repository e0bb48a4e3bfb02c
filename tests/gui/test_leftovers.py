"""What earlier runs left is counted and offered at the start, the window free meanwhile."""

import shutil
import threading

import pytest
from PySide6.QtCore import Qt

from inspector.session import leftovers
from inspector.session.settings import Settings
from inspector.widgets.background import wait_for_tasks
from tests.gui.windows import close_window, open_clip
from twistcore.review import Decision, LeaveOut

pytestmark = pytest.mark.thorough


@pytest.fixture
def left(qtbot, show_window, clip):
    """A clip with a journal of two decisions that was left by a crash."""
    window = show_window()
    open_clip(qtbot, window, clip)
    document = window.document
    document.decide(Decision.ACCEPTED, [j.id for j in document.intervals[:2]])
    journal = document.keeper.journal.path
    data = journal.read_bytes()
    document.keeper.journal.give_up()
    document.review.mark_saved()
    document.close_clip()
    journal.write_bytes(data)
    return clip


@pytest.fixture
def gate(monkeypatch):
    """Journals are counted only once it is set; `gate.where` is the thread that does so."""
    gate = threading.Event()
    count = leftovers.decisions_in

    def held(journal):
        gate.where = threading.current_thread()
        assert gate.wait(10.0)
        return count(journal)

    monkeypatch.setattr(leftovers, "decisions_in", held)
    yield gate
    gate.set()


def test_a_journal_is_counted_while_the_window_is_free(qtbot, show_window, left, gate):
    window = show_window(Settings(turn_ms=0, recent=[str(left)]))
    window.files.offer_unsaved()
    qtbot.waitUntil(lambda: hasattr(gate, "where"))
    assert gate.where is not threading.main_thread()
    gate.set()
    qtbot.waitUntil(lambda: window.bar.asks)
    assert "2 decisions" in window.bar.label.text()


def test_who_has_opened_a_clip_meanwhile_is_not_asked_about_others(qtbot, show_window, left, gate):
    window = show_window(Settings(turn_ms=0, recent=[str(left)]))
    window.files.offer_unsaved()
    qtbot.waitUntil(lambda: hasattr(gate, "where"))
    open_clip(qtbot, window, shutil.copy(left, left.with_name("other.bvh")))
    gate.set()
    assert wait_for_tasks(10_000)
    qtbot.wait(1)  # what the thread has said is heard
    assert not window.bar.asks


@pytest.fixture
def left_out(qtbot, show_window, clip):
    """A clip with a journal in which frames were left out of tuning and nothing else was done."""
    window = show_window()
    open_clip(qtbot, window, clip)
    assert window.document.do(LeaveOut(((20, 40),)))
    journal = window.document.keeper.journal.path
    data = journal.read_bytes()
    close_window(qtbot, window)
    journal.write_bytes(data)
    return clip, journal


def press_answer(qtbot, window, text):
    answer = next(b for b in window.bar.buttons() if b.text() == text)
    qtbot.mouseClick(answer, Qt.MouseButton.LeftButton)


def test_frames_that_were_left_out_come_along_beside_what_was_done_since(
    qtbot, show_window, left_out
):
    window = show_window()
    open_clip(qtbot, window, left_out[0])
    document = window.document
    document.decide(Decision.ACCEPTED, [document.intervals[0].id])
    assert document.do(LeaveOut(((30, 50), (100, 110))))
    press_answer(qtbot, window, "Restore")
    assert document.review.state.left_out == ((20, 50), (100, 110))
    assert document.keeper.leftovers == []


def test_frames_left_out_of_another_version_stay_in_their_journal(qtbot, show_window, left_out):
    clip, journal = left_out
    text = clip.read_bytes()
    clip.write_bytes(text.replace(b"Frame Time:", b"Frame Time: "))
    data = journal.read_bytes()
    window = show_window()
    open_clip(qtbot, window, clip)
    press_answer(qtbot, window, "Carry over decisions")
    assert window.document.review.state.left_out == ()
    assert window.bar.label.text()
    assert data in [p.read_bytes() for p in clip.parent.iterdir()]
