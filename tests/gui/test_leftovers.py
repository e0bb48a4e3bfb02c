"""What earlier runs left is counted and offered at the start, the window free meanwhile."""

import shutil
import threading

import pytest

from inspector.session import leftovers
from inspector.session.settings import Settings
from inspector.widgets.background import wait_for_tasks
from tests.gui.windows import open_clip
from twistcore.review import Decision


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
    assert "2 decisions can be restored" in window.bar.label.text()


def test_who_has_opened_a_clip_meanwhile_is_not_asked_about_others(qtbot, show_window, left, gate):
    window = show_window(Settings(turn_ms=0, recent=[str(left)]))
    window.files.offer_unsaved()
    qtbot.waitUntil(lambda: hasattr(gate, "where"))
    open_clip(qtbot, window, shutil.copy(left, left.with_name("other.bvh")))
    gate.set()
    assert wait_for_tasks(10_000)
    qtbot.wait(1)  # what the thread has said is heard
    assert not window.bar.asks
