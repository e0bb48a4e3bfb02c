"""A clock that was set back: files from the future, and what is done last is still the last."""

import os
import shutil
import time

import pytest

from inspector.session.session_files import (
    fallback_session_path,
    find_existing_sessions,
    session_path,
)
from tests.gui.windows import close_window, open_clip
from twistcore.batch.clip_task import file_change_signature
from twistcore.review import Decision, read_session

DAY_S = 86_400


@pytest.fixture
def later():
    """Sets files to a day from now, as they are once a clock was set back."""
    moment = time.time() + DAY_S

    def put(*paths):
        for path in paths:
            os.utime(path, (moment, moment))

    return put


def decided(window, count):
    ids = [judged.id for judged in window.document.intervals[:count]]
    window.document.decide(Decision.ACCEPTED, ids)


@pytest.mark.thorough
def test_the_session_that_was_saved_last_is_the_latest(qtbot, show_window, clip, later):
    window = show_window()
    open_clip(qtbot, window, clip)
    decided(window, 1)
    assert window.files.save_session()
    away = fallback_session_path(clip)
    away.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(session_path(clip), away)
    later(away, clip)
    session_path(clip).unlink()
    open_clip(qtbot, window, clip)
    assert window.document.keeper.session_file == away
    decided(window, 3)
    assert window.document.keeper.save(session_path(clip))[0]
    assert find_existing_sessions(clip) == [session_path(clip), away]
    open_clip(qtbot, window, clip)
    assert window.document.keeper.session_file == session_path(clip)
    assert len(window.document.review.state.chosen()) == 3
    assert len(read_session(away).state.chosen()) == 1


@pytest.mark.thorough
def test_what_earlier_runs_left_is_offered_whatever_its_time(qtbot, show_window, clip, later):
    window = show_window()
    open_clip(qtbot, window, clip)
    decided(window, 2)
    journal = window.document.keeper.journal.path
    data = journal.read_bytes()
    decided(window, 3)
    assert window.files.save_session()
    close_window(qtbot, window)
    journal.write_bytes(data)
    later(journal, clip, session_path(clip))
    window = show_window()
    open_clip(qtbot, window, clip)
    (restore, _) = window.bar.buttons()
    assert restore.text() == "Restore"
    restore.click()
    qtbot.waitUntil(lambda: len(window.document.review.state.chosen()) == 2)
    assert window.files.save_session()
    open_clip(qtbot, window, clip)
    assert len(window.document.review.state.chosen()) == 2
    assert not window.bar.asks


def test_a_file_from_the_future_is_never_taken_for_settled(clip, later):
    later(clip)
    assert not file_change_signature(clip)[1]
