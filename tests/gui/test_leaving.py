"""Leaving a clip or the program: what cannot be saved is seen, what is saved needs no word."""

import shutil
from pathlib import Path

import pytest
from PySide6.QtWidgets import QMessageBox

from inspector.session import keeper
from inspector.session.export_files import ExportChoice
from inspector.session.session_files import session_path
from inspector.window import saving
from tests.gui.folders import two_takes
from tests.gui.windows import close_and_answer, export, open_clip
from twistcore.review import Decision

pytestmark = pytest.mark.thorough

Button = QMessageBox.StandardButton


@pytest.fixture
def decided(qtbot, window, clip):
    """The window with a decision about the walk."""
    open_clip(qtbot, window, clip)
    window.document.decide(Decision.ACCEPTED, [window.document.intervals[0].id])
    return window


@pytest.fixture
def other(clip):
    """Another clip beside it."""
    return Path(shutil.copy(clip, clip.with_name("other.bvh")))


@pytest.fixture
def full_disk(monkeypatch):
    """No session can be written; the journal is on disk."""

    def refuse(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(keeper, "write_session_with_backup", refuse)
        yield patch


def test_what_was_not_saved_when_a_clip_was_left_is_read_in_the_next(
    qtbot, decided, other, full_disk
):
    with qtbot.waitSignal(decided.document.opened, timeout=20_000):
        decided.open_path(other)
    qtbot.waitUntil(lambda: "No space left" in decided.bar.label.text())
    assert "Your decisions are kept in the journal" in decided.bar.label.text()
    assert decided.bar.isVisible()
    assert decided.bar.property("wrong")


def test_it_takes_nothing_away_that_the_next_one_has_to_say(qtbot, decided, clip, full_disk):
    broken = clip.with_name("broken.bvh")
    broken.write_bytes(b"HIERARCHY\nROOT")
    with qtbot.waitSignal(decided.document.opener.over, timeout=20_000):
        decided.open_path(broken)
    qtbot.waitUntil(lambda: "No space left" in decided.bar.label.text())
    assert "broken.bvh" in decided.bar.label.text()


def test_what_was_saved_needs_no_word(qtbot, decided, other):
    mine = decided.document.data.clip.path
    with qtbot.waitSignal(decided.document.opened, timeout=20_000):
        decided.open_path(other)
    qtbot.wait(1)
    assert session_path(mine).exists()
    assert not decided.bar.property("wrong")
    decided.document.decide(Decision.ACCEPTED, [decided.document.intervals[0].id])
    assert close_and_answer(decided, Button.Cancel) == ""
    assert not decided.isVisible()
    assert session_path(other).exists()


def test_it_is_read_beside_the_offer_to_go_back_to_the_last_clip(
    qtbot, show_window, tmp_path, full_disk
):
    window = two_takes(qtbot, show_window, tmp_path)
    window.document.accept_undecided()
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        export(window, ExportChoice(tmp_path / "out.bvh"))
    qtbot.waitUntil(lambda: "Next clip" in window.bar.label.text())
    assert "No space left" in window.bar.label.text()
    assert window.bar.buttons()


def test_closing_says_what_cannot_be_saved_and_may_be_given_up(decided, full_disk):
    told = close_and_answer(decided, Button.Cancel)
    assert "No space left" in told
    assert "in the journal" in told
    assert decided.isVisible()
    journal = decided.document.keeper.journal.path
    assert close_and_answer(decided, Button.Close) == told
    assert not decided.isVisible()
    assert journal.exists()


def test_what_comes_with_the_program_is_left_without_a_word(decided, clip, monkeypatch):
    monkeypatch.setattr(saving, "ASSETS", clip.parent)
    assert close_and_answer(decided, Button.Cancel) == ""
    assert not decided.isVisible()
    assert not session_path(clip).exists()
    assert list(clip.parent.glob("*.journal")), "what was decided is kept"
