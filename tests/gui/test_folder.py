"""The queue: worst first, bad clips marked and passed over, the window free all the while."""

import shutil
import sys

import pytest
from PySide6.QtCore import QElapsedTimer, QTimer

from inspector.session.queue import ClipState, FolderQueue
from tests.conftest import ASSETS
from tests.gui.windows import act
from twistcore.batch import severity
from twistcore.bvh import changed_rotations, patch_rotations, read_bvh
from twistcore.chain import find_chains
from twistcore.detection import Interval
from twistcore.synthesis import draw_errors, generator, inject


def put_errors(path, chains_hit, seed=1):
    """The walk with errors in a number of chains; returns its true severity."""
    clip = read_bvh(ASSETS / "walk.bvh")
    chains = find_chains(clip.motion)
    errors = draw_errors(clip.motion, chains[:chains_hit], generator(seed, path.name))
    dirty = inject(clip.motion, chains, errors)
    path.write_bytes(patch_rotations(clip, dirty, changed_rotations(clip, dirty)))
    found = [Interval(e.chain, e.start, e.stop, e.offset) for e in errors]
    return severity(found, clip.motion.frames)


@pytest.fixture
def queue(qtbot):
    queue = FolderQueue(workers=2)
    yield queue
    queue.close()
    queue.deleteLater()
    qtbot.wait(20)


def test_the_worst_comes_first_and_the_bad_are_marked(qtbot, queue, tmp_path):
    truth = {f"{k}.bvh": put_errors(tmp_path / f"{k}.bvh", k) for k in (1, 3, 6, 9)}
    shutil.copy(ASSETS / "walk.bvh", tmp_path / "clean.bvh")
    (tmp_path / "broken.bvh").write_bytes(b"HIERARCHY\nROOT")
    (tmp_path / "empty.bvh").write_bytes(b"")
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.open(tmp_path)
    names = [c.path.name for c in queue.ordered]
    assert names[:4] == sorted(truth, key=truth.get, reverse=True)
    assert names[4] == "clean.bvh"
    assert set(names[5:]) == {"broken.bvh", "empty.bvh"}
    for clip in queue.ordered[5:]:
        assert clip.state == ClipState.FAILED
        assert clip.path.name in clip.reason
    for clip in queue.ordered[:4]:
        assert clip.severity == pytest.approx(truth[clip.path.name], rel=0.05)
    assert queue.progress == (7, 7)


def test_a_clip_that_hangs_or_eats_memory_takes_only_itself_down(
    qtbot, queue, tmp_path, monkeypatch
):
    for k in (1, 2, 3):
        put_errors(tmp_path / f"{k}.bvh", k)
    monkeypatch.setattr("inspector.session.queue._PATIENCE_S", 0.0)
    slow = tmp_path / "0_hangs.bvh"
    # A pipe nobody writes to: opening it never returns.
    if sys.platform != "linux":
        pytest.skip("needs named pipes")
    import os

    os.mkfifo(slow)
    monkeypatch.setattr("inspector.session.queue._PATIENCE_S", 3.0)
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.open(tmp_path)
    states = {c.path.name: c for c in queue.ordered}
    assert "too long" in states["0_hangs.bvh"].reason
    assert all(states[f"{k}.bvh"].state == ClipState.READY for k in (1, 2, 3))


def test_a_worker_that_is_killed_is_replaced(qtbot, queue, tmp_path):
    for k in range(1, 7):
        put_errors(tmp_path / f"{k}.bvh", k)
    queue.open(tmp_path)
    qtbot.waitUntil(lambda: any(w.path is not None for w in queue._workers), timeout=10_000)
    victim = queue._workers[0]
    path = victim.path
    victim.process.kill()
    qtbot.waitUntil(lambda: not queue.running, timeout=60_000)
    failed = [c for c in queue.ordered if c.state == ClipState.FAILED]
    assert [c.path for c in failed] == [path]
    assert "memory" in failed[0].reason


def test_new_clips_are_taken_up_and_vanished_ones_marked(qtbot, queue, tmp_path):
    put_errors(tmp_path / "1.bvh", 1)
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.open(tmp_path)
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        put_errors(tmp_path / "2.bvh", 4)
    assert [c.path.name for c in queue.ordered] == ["2.bvh", "1.bvh"]
    (tmp_path / "1.bvh").unlink()
    qtbot.waitUntil(lambda: queue.clips[tmp_path / "1.bvh"].reason != "", timeout=10_000)
    assert "no longer" in queue.clips[tmp_path / "1.bvh"].reason


def test_the_window_opens_a_folder_reviews_and_goes_on(qtbot, show_window, tmp_path):
    for k in (2, 5):
        put_errors(tmp_path / f"{k}.bvh", k)
    window = show_window()
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(tmp_path)
    assert window.docks["clips"].isVisible()
    qtbot.waitUntil(lambda: not window.queue.running, timeout=60_000)
    window.document.accept_undecided()
    assert window.files.save_session()
    first = window.document.data.clip.path
    assert window.queue.clips[first].done
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        act(window, "next_clip")
    assert window.document.data.clip.path != first
    window.document.accept_undecided()
    window.files.save_session()
    act(window, "next_clip")
    assert "No other clip" in window.bar.label.text()


def test_the_window_stays_free_while_clips_are_analysed(qtbot, show_window, tmp_path):
    """Not a timed test of speed: a stall of half a second would mean work in the GUI thread."""
    for k in range(8):
        put_errors(tmp_path / f"{k}.bvh", 1 + k)
    window = show_window()
    longest, clock, timer = [0], QElapsedTimer(), QTimer()

    def tick():
        longest[0] = max(longest[0], clock.restart())

    clock.start()
    timer.timeout.connect(tick)
    timer.start(5)
    with qtbot.waitSignal(window.queue.finished, timeout=60_000):
        window.queue.open(tmp_path)
    timer.stop()
    assert longest[0] < 500
