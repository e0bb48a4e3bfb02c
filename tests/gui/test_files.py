"""Opening and exporting through the window, and what may go wrong with either."""

import json
import os
import shutil
import stat
import threading
import time
from itertools import cycle
from pathlib import Path

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication

from inspector.session import clip_opener
from inspector.session.export_files import ExportChoice
from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, export, open_clip, press, wait_until_active
from twistcore.detection import Kind
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision

ONE_WINDOW = True


def test_nothing_accepted_exports_the_same_bytes(opened, tmp_path):
    export(opened, ExportChoice(tmp_path / "same.bvh", session=False, report=False))
    assert (tmp_path / "same.bvh").read_bytes() == INJECTED.read_bytes()
    assert [p.name for p in tmp_path.iterdir() if p.suffix == ".bvh"] == ["same.bvh"]


def test_a_file_is_opened_by_dropping_it(qtbot, window):
    mime = QMimeData()
    mime.setUrls([QUrl.fromLocalFile(str(ASSETS / "dance.bvh"))])
    actions, button = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    plain = Qt.KeyboardModifier.NoModifier
    enter = QDragEnterEvent(QPoint(50, 50), actions, mime, button, plain)
    QApplication.sendEvent(window, enter)
    assert enter.isAccepted()
    with qtbot.waitSignal(window.document.opened, timeout=10_000):
        drop = QDropEvent(QPointF(50, 50), actions, mime, button, plain)
        QApplication.sendEvent(window, drop)
    assert window.document.data.clip.name == "dance.bvh"


BAD = {
    "empty.bvh": b"",
    "picture.bvh": b"\x89PNG\r\n\x1a\n0000",
    "cut.bvh": INJECTED.read_bytes()[:1500],
    "damaged.twist.json": b'{"schema": "twistcore.session/1"',
    "other.json": b"[]",
}


@pytest.mark.thorough
@pytest.mark.parametrize("name", [*BAD, "missing.bvh"])
def test_what_cannot_be_opened_is_one_sentence_and_the_clip_stays(qtbot, opened, tmp_path, name):
    path = tmp_path / "in" / name
    path.parent.mkdir()
    if name in BAD:
        path.write_bytes(BAD[name])
    with qtbot.waitSignal(opened.document.message, timeout=10_000) as told:
        opened.open_path(path)
    assert told.args[1] is True
    assert name in told.args[0]
    assert "\n" not in told.args[0]
    assert opened.bar.isVisible()
    assert opened.document.data.clip.name == "walk_injected.bvh"
    assert [p.name for p in path.parent.iterdir()] == ([name] if name in BAD else [])


@pytest.fixture
def endless(monkeypatch):
    """Opening takes until it is cancelled; the names of clips whose opening has ended."""
    ended = []

    def analyse(path, _profile, tell, _seen):
        try:
            for percent in cycle(range(100)):
                tell(percent / 100.0)
                time.sleep(0.002)
        finally:
            ended.append(path.name)

    monkeypatch.setattr(clip_opener, "analyse_file", analyse)
    monkeypatch.setattr(clip_opener, "_WONDER_S", 0.05)
    return ended


@pytest.mark.thorough
def test_escape_cancels_what_is_being_opened(qtbot, opened, endless):
    action = opened.actions_by_id["cancel_opening"]
    assert not action.isEnabled()
    opened.open_path(Path("endless.bvh"))
    qtbot.waitUntil(lambda: "%" in opened.statusBar().currentMessage())
    assert " endless.bvh " in opened.statusBar().currentMessage()
    assert action.isEnabled()
    press(qtbot, opened, Qt.Key.Key_Escape)
    assert opened.statusBar().currentMessage() == ""
    assert not action.isEnabled()
    qtbot.waitUntil(lambda: endless == ["endless.bvh"])
    assert opened.document.data.clip.name == "walk_injected.bvh"
    press(qtbot, opened, Qt.Key.Key_N)
    press(qtbot, opened, Qt.Key.Key_A)
    assert opened.document.review.undo_text, "the clip can be judged again"


@pytest.mark.thorough
def test_another_clip_cancels_what_is_being_opened(qtbot, window, endless):
    window.open_path(Path("one.bvh"))
    window.open_path(Path("two.bvh"))
    qtbot.waitUntil(lambda: endless == ["one.bvh"])
    window.close()
    qtbot.waitUntil(lambda: endless == ["one.bvh", "two.bvh"])


@pytest.mark.thorough
def test_a_cut_motion_opens_with_a_note(qtbot, window, tmp_path):
    path = tmp_path / "cut.bvh"
    path.write_bytes(INJECTED.read_bytes()[:100_000])
    open_clip(qtbot, window, path)
    assert 0 < window.document.frames < 344
    assert f"{344 - window.document.frames} are missing" in window.bar.label.text()
    assert window.bar.property("wrong"), "it stays until it is closed"


STICK = b"""HIERARCHY
ROOT a
{
OFFSET 0 0 0
CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT b
{
OFFSET 0 1 0
CHANNELS 1 Zrotation
End Site
{
OFFSET 0 1 0
}
}
}
MOTION
Frames: 3
Frame Time: 0.01
0 0 0 0 0 0 0
0 0 0 1 2 3 9
0 0 0 1 2 3 9
"""


@pytest.mark.thorough
def test_a_skeleton_without_a_chain_opens_and_says_so(qtbot, window, tmp_path):
    path = tmp_path / "stick.bvh"
    path.write_bytes(STICK)
    open_clip(qtbot, window, path)
    assert window.bar.label.text()
    for action in window.actions_by_id.values():
        if action.objectName() in ("next_interval", "accept", "focus_chain", "insert_interval",
                                   "start_here", "zoom_to_interval", "toggle_play"):  # fmt: skip
            action.trigger()
    qtbot.wait(50)
    window.player.pause()
    export(window, ExportChoice(tmp_path / "out.bvh"))
    assert (tmp_path / "out.bvh").read_bytes() == STICK


@pytest.mark.thorough
def test_a_joint_without_three_rotations_is_shown_but_not_written(qtbot, window, tmp_path):
    text = INJECTED.read_bytes()
    head, _, rows = text.partition(b"MOTION")
    # Take two of LeftHand's three rotation channels away, in the header and in every row.
    at = head.index(b"CHANNELS 3", head.index(b"JOINT LeftHand\r\n"))
    head = head[:at] + head[at:].replace(
        b"CHANNELS 3 Zrotation Yrotation Xrotation", b"CHANNELS 1 Zrotation", 1
    )
    clip = read_bvh(INJECTED)
    column = clip.channels[clip.motion.skeleton.index("LeftHand")].rotation
    lines = rows.splitlines()
    body = [b" ".join(t for k, t in enumerate(r.split()) if k not in column[1:]) for r in lines[3:]]
    path = tmp_path / "one.bvh"
    path.write_bytes(head + b"MOTION\n" + b"\n".join([*lines[1:3], *body]) + b"\n")
    open_clip(qtbot, window, path)
    # A stretch of the forearm that the hand follows needs no turn of the hand.
    twists = [j.id for j in window.document.intervals if j.interval.kind == Kind.COUNTER_TWIST]
    window.document.decide(Decision.ACCEPTED, twists)
    export(window, ExportChoice(tmp_path / "out.bvh"))
    before, after = read_bvh(path), read_bvh(tmp_path / "out.bvh")
    changed = (before.values != after.values).any(axis=0)
    hand = before.channels[before.motion.skeleton.index("LeftHand")].rotation
    forearm = before.channels[before.motion.skeleton.index("LeftForeArm")].rotation
    assert not changed[list(hand + forearm)].any()
    assert changed.any()


@pytest.mark.thorough
def test_the_source_is_never_overwritten(qtbot, window, tmp_path):
    path = tmp_path / "walk.bvh"
    shutil.copy(INJECTED, path)
    open_clip(qtbot, window, path)
    export(window, ExportChoice(path))
    assert window.bar.label.text()
    assert path.read_bytes() == INJECTED.read_bytes()


@pytest.mark.thorough
def test_a_source_that_has_gone_is_not_written_anew(qtbot, window, tmp_path):
    path = Path(shutil.copy(INJECTED, tmp_path / "walk.bvh"))
    open_clip(qtbot, window, path)
    path.unlink()
    export(window, ExportChoice(path, replace=True))
    assert window.bar.label.text()
    assert not path.exists()


def test_an_export_replaces_its_own_file_and_no_other(opened, tmp_path):
    out = tmp_path / "out.bvh"
    export(opened, ExportChoice(out))
    act(opened, "next_interval")
    act(opened, "accept")
    export(opened, ExportChoice(out))  # as it was written: no question
    assert "out.bvh" in opened.bar.label.text()
    out.write_bytes(b"somebody else's by now")
    export(opened, ExportChoice(out))
    assert "out.bvh" in opened.bar.label.text()
    assert out.read_bytes() == b"somebody else's by now"
    export(opened, ExportChoice(out, replace=True))
    assert read_bvh(out).motion.frames == 344


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["out.replay.json", "out.intervals.csv"])
def test_what_lies_beside_an_export_is_replaced_only_if_it_is_ours(opened, tmp_path, name):
    (tmp_path / name).write_text("mine")
    export(opened, ExportChoice(tmp_path / "out.bvh", replace=True))
    assert name in opened.bar.label.text()
    assert [p.name for p in tmp_path.iterdir() if p.is_file()] == [name]
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["../out.bvh", "/etc/passwd", "", ".", "a\0b", "out.bvh"])
def test_a_strangers_list_of_files_makes_nothing_ours(opened, tmp_path, name):
    out, listing = tmp_path / "out.bvh", tmp_path / "out.report.json"
    out.write_text("mine")
    marks = {name: ["not", "a", "text"]}
    listing.write_text(json.dumps({"schema": "twistcore.report/1", "files": marks}))
    export(opened, ExportChoice(out))
    assert "out.bvh" in opened.bar.label.text()
    assert out.read_text() == "mine"


@pytest.mark.thorough
def test_an_export_never_touches_a_review_of_itself(opened, tmp_path):
    review = tmp_path / "out.twist.json"
    review.write_text("a review of out.bvh")
    export(opened, ExportChoice(tmp_path / "out.bvh"))
    assert "out.bvh" in opened.bar.label.text()
    assert review.read_text() == "a review of out.bvh"


@pytest.mark.thorough
@pytest.mark.skipif(os.name == "nt", reason="links and FIFOs as POSIX has them")
def test_an_export_follows_a_link_and_writes_into_a_fifo(opened, tmp_path):
    real, link, fifo = tmp_path / "real.bvh", tmp_path / "link.bvh", tmp_path / "fifo.bvh"
    link.symlink_to(real)
    export(opened, ExportChoice(link))
    assert link.is_symlink()
    assert read_bvh(real).motion.frames == 344
    os.mkfifo(fifo)
    read = []
    reader = threading.Thread(target=lambda: read.append(fifo.read_bytes()))
    reader.start()
    export(opened, ExportChoice(fifo, session=False, report=False))
    reader.join(10.0)
    assert read == [real.read_bytes()]
    assert stat.S_ISFIFO(fifo.stat().st_mode)


@pytest.mark.thorough
def test_a_tick_to_replace_is_for_the_file_it_was_given_for(opened, tmp_path):
    one, other = tmp_path / "one.bvh", tmp_path / "other.bvh"
    for path in (one, other):
        path.write_text("there")
    act(opened, "export_dialog")
    dialog = opened.findChild(ExportDialog)
    dialog.path.setText(str(one))
    dialog.replace.setChecked(True)
    dialog.path.setText(str(other))
    assert not dialog.choice().replace
    dialog.reject()


@pytest.mark.thorough
def test_an_export_into_nowhere_is_told(opened, tmp_path):
    export(opened, ExportChoice(tmp_path / "no" / "where.bvh"))
    assert opened.bar.isVisible()
    assert opened.bar.label.text()


def test_the_export_dialog_says_what_will_happen(qtbot, opened, tmp_path):
    act(opened, "next_interval")
    act(opened, "accept")
    act(opened, "export_dialog")
    dialog = opened.findChild(ExportDialog)
    wait_until_active(dialog)
    dialog.path.setText(str(tmp_path / "by_dialog.bvh"))
    assert dialog.undecided.text().startswith("Also correct 7 undecided")
    dialog.accept()
    assert opened.exporter.finish()
    assert (tmp_path / "by_dialog.bvh").exists()


@pytest.mark.thorough
def test_the_export_dialog_says_what_is_in_the_way(opened, tmp_path):
    """A foreign clip is replaced when that is ticked, a foreign report never."""
    dialog = ExportDialog(opened.document, opened)
    dialog.show()
    dialog.path.setText(str(tmp_path / "new.bvh"))
    assert ".bvh" not in dialog.replaces.text()
    assert dialog.do_it.isEnabled()
    (tmp_path / "there.bvh").write_text("mine")
    dialog.path.setText(str(tmp_path / "there.bvh"))
    assert dialog.replaces.text().startswith("there.bvh (")
    assert not dialog.do_it.isEnabled()
    assert dialog.obstacle.text()
    dialog.replace.setChecked(True)
    assert dialog.do_it.isEnabled()
    (tmp_path / "there.intervals.csv").write_text("mine")
    dialog.report.setChecked(False)
    dialog.report.setChecked(True)
    dialog.replace.setChecked(True)
    assert not dialog.do_it.isEnabled()
    assert "there.intervals.csv" in dialog.obstacle.text()
    dialog.report.setChecked(False)
    dialog.replace.setChecked(True)
    assert dialog.do_it.isEnabled()
    export(opened, ExportChoice(tmp_path / "own.bvh"))
    opened.document.exported.clear()  # as another run would
    dialog.report.setChecked(True)
    dialog.path.setText(str(tmp_path / "own.bvh"))
    lines = dialog.replaces.text().splitlines()
    assert len(lines) == 6
    assert dialog.do_it.isEnabled()
    dialog.close()
