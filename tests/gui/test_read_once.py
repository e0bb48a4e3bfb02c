"""Files that are there already: each is read once, and long ones in a thread."""

import hashlib
import threading

import pytest

from inspector.session.export_files import ExportChoice
from inspector.widgets.background import wait_for_tasks
from inspector.window.export_dialog import ExportDialog
from tests.gui.windows import act, export, open_clip
from twistcore.files import marks as file_marks
from twistcore.review import Decision


@pytest.fixture
def reads(monkeypatch):
    """Files that are hashed, each with the thread that does so."""
    done = []
    digest = hashlib.file_digest

    def noted(file, how):
        done.append((file.name.rpartition("/")[2], threading.current_thread()))
        return digest(file, how)

    monkeypatch.setattr(hashlib, "file_digest", noted)
    return done


@pytest.fixture
def exported(qtbot, window, clip, reads):
    """The walk in the window, exported by an earlier run."""
    open_clip(qtbot, window, clip)
    export(window, ExportChoice(clip.with_name("walk_refined.bvh")))
    window.document.exported.clear()
    file_marks.forget_cached_hashes(tuple(file_marks._marks))
    reads.clear()
    return window


@pytest.fixture
def all_are_long(monkeypatch):
    monkeypatch.setattr(file_marks, "_LONG", 0)


def dialog_of(window):
    return window.findChild(ExportDialog)


def test_a_file_is_hashed_once_however_much_is_typed(exported, reads):
    act(exported, "export_dialog")
    dialog = dialog_of(exported)
    once = sorted(name for name, _ in reads)
    assert len(once) == len(set(once)) == 5
    name = dialog.path.text()
    for typed in (name[:-5], name[:-4], name, name[:-4], name):
        dialog.path.setText(typed)
    dialog.report.toggle()
    dialog.report.toggle()
    assert sorted(name for name, _ in reads) == once
    assert dialog.replaces.text().count("written by this program") == 6
    out = exported.document.data.clip.path.with_name("walk_refined.bvh")
    out.write_bytes(out.read_bytes() + b"\n")
    dialog.path.setText(name[:-4])
    dialog.path.setText(name)
    assert (
        "walk_refined.bvh (not written by this program, or changed later)" in dialog.replaces.text()
    )
    assert len(reads) == 6
    dialog.reject()


@pytest.mark.thorough
def test_long_files_are_read_in_a_thread_and_said_to_be(qtbot, exported, reads, all_are_long):
    act(exported, "export_dialog")
    dialog = dialog_of(exported)
    assert "Checking" in dialog.replaces.text()
    assert not dialog.do_it.isEnabled()
    qtbot.waitUntil(dialog.do_it.isEnabled)
    assert dialog.replaces.text().count("written by this program") == 6
    assert {where for _, where in reads}.isdisjoint({threading.main_thread()})
    dialog.reject()


@pytest.mark.thorough
def test_an_export_at_once_waits_until_long_files_were_read(qtbot, exported, reads, all_are_long):
    with qtbot.waitSignal(exported.exporter.written, timeout=20_000):
        act(exported, "export_at_once")
    assert {where for _, where in reads}.isdisjoint({threading.main_thread()})


@pytest.mark.thorough
def test_at_once_pressed_twice_exports_once_and_as_the_review_is_then(
    qtbot, exported, all_are_long, monkeypatch
):
    started = []
    monkeypatch.setattr(exported.exporter, "start", started.append)
    act(exported, "export_at_once")
    assert exported.bar.label.text()
    act(exported, "export_at_once")
    assert wait_for_tasks(10_000)
    qtbot.waitUntil(lambda: bool(started))
    qtbot.wait(50)
    assert len(started) == 1

    target = started[0].path
    target.write_bytes(b"not ours")  # now something is in the way
    act(exported, "export_at_once")
    document = exported.document
    undecided = next(j for j in document.intervals if j.decision == Decision.UNDECIDED)
    document.decide(Decision.REJECTED, [undecided.id])
    qtbot.waitUntil(lambda: any(d.isVisible() for d in exported.findChildren(ExportDialog)))
    (dialog,) = [d for d in exported.findChildren(ExportDialog) if d.isVisible()]
    assert "1 rejected" in dialog.count.text()
    dialog.reject()


@pytest.mark.thorough
def test_an_export_at_once_is_not_of_a_clip_that_is_opened_meanwhile(
    qtbot, exported, all_are_long, monkeypatch
):
    started = []
    monkeypatch.setattr(exported.exporter, "start", started.append)
    act(exported, "export_at_once")
    exported.document.opened.emit()
    assert wait_for_tasks(10_000)
    qtbot.wait(1)  # what the thread has said is heard
    assert started == []
    assert dialog_of(exported) is None or not dialog_of(exported).isVisible()


@pytest.mark.thorough
def test_a_long_clip_that_changed_is_read_in_a_thread(qtbot, exported, reads, all_are_long):
    clip = exported.document.data.clip.path
    clip.write_bytes(clip.read_bytes() + b"\n")
    exported.document.recovery.check_lock_and_clip()
    assert not exported.bar.asks
    qtbot.waitUntil(lambda: exported.bar.asks)
    assert exported.bar.label.text()
    assert [name for name, _ in reads] == [clip.name]
    assert reads[0][1] is not threading.main_thread()
