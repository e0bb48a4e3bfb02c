"""FIFOs, loops of links and folders where the window expects files: told, never waited for."""

import os
import shutil
import sys

import pytest

from inspector.folder.queued_clip import ClipState
from inspector.session.settings import Settings
from tests.gui.pictures import INJECTED
from tests.gui.windows import open_clip
from twistcore.review import Decision, read_session, replay_journal

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no such files there")

_PATIENCE_MS = 60_000


@pytest.fixture
def odd(tmp_path):
    """A folder with a clip, and what is none under the names of clips, sessions and journals."""
    folder = tmp_path / "odd"
    folder.mkdir()
    shutil.copy(INJECTED, folder / "walk.bvh")
    for end in ("bvh", "npz", "amc", "asf"):
        os.mkfifo(folder / f"fifo.{end}")
        (folder / f"loop.{end}").symlink_to(f"loop.{end}")
        (folder / f"folder.{end}").mkdir()
    for name in ("loop.twist.json.journal", "walk.twist.json", "walk.twist.json.journal"):
        os.mkfifo(folder / name)
    os.mkfifo(folder / "walk.twist.json.journal.lock")
    return folder


@pytest.mark.thorough
def test_the_start_and_a_folder_and_every_entry_are_told(qtbot, show_window, odd):
    entries = sorted(path for path in odd.iterdir() if not path.is_dir())
    window = show_window(Settings(turn_ms=0, recent=[str(path) for path in entries]))
    window.files.offer_unsaved()
    window.open_path(odd)
    qtbot.waitUntil(lambda: bool(window.queue.clips) and not window.queue.running, timeout=60_000)
    states = {clip.path.name: clip for clip in window.queue.ordered}
    loops = [f"loop.{end}" for end in ("amc", "bvh", "npz")]
    assert sorted(states) == [*loops, "walk.bvh"]
    assert states["walk.bvh"].state == ClipState.READY
    assert all("symbolic links" in states[name].reason for name in loops)
    for path in entries:
        if path.name == "walk.bvh":
            continue
        with qtbot.waitSignal(window.document.opener.over, timeout=_PATIENCE_MS):
            window.open_path(path)
        qtbot.waitUntil(lambda path=path: str(path) in window.bar.label.text())


def test_a_review_among_them_is_kept_elsewhere(qtbot, show_window, odd):
    window = show_window(Settings(turn_ms=0))
    before = sorted(path.name for path in odd.iterdir())
    open_clip(qtbot, window, odd / "walk.bvh")
    assert window.bar.label.text()
    window.document.decide(Decision.ACCEPTED, [window.document.intervals[0].id])
    journal = window.document.keeper.journal.path
    assert replay_journal(journal).steps == 1
    assert window.files.save_session()
    assert str(window.document.keeper.session_file) in window.bar.label.text()
    assert len(read_session(window.document.keeper.session_file).state.chosen()) == 1
    assert sorted(path.name for path in odd.iterdir()) == before
