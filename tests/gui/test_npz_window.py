"""An .npz of AMASS in the window: dropped, judged, exported, opened again, taught."""

import shutil

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent
from PySide6.QtTest import QTest

from inspector.folder.queued_clip import ClipState
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, open_clip
from tests.messages import names_in_one_line
from tests.twistcore.amass_files import loaded, write_amass
from tests.twistcore.pose_layout_files import write_aist
from twistcore.cli import main as twistcore
from twistcore.export.exported_clips import find_exports_and_their_sources
from twistcore.formats.bvh import read_bvh
from twistcore.formats.npz.body import BODIES
from twistcore.review import Decision

ONE_WINDOW = True


@pytest.fixture
def window(window_for_clips):
    """The program's window: each test opens a clip of its own."""
    return window_for_clips(Settings(turn_ms=0))


@pytest.fixture
def walk(tmp_path):
    """The walk with eight errors as AMASS would have it, its body a template's."""
    return write_amass(tmp_path / "walk_poses.npz", read_bvh(INJECTED).motion, own=False)


@pytest.mark.thorough
def test_it_is_dropped_judged_exported_and_opened_again(qtbot, window, walk, tmp_path, capsys):
    mime = QMimeData()
    mime.setUrls([QUrl.fromLocalFile(str(walk))])
    actions, button = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        plain = Qt.KeyboardModifier.NoModifier
        drop = QDropEvent(QPointF(50, 50), actions, mime, button, plain)
        window.dropEvent(drop)
    document = window.document
    assert len(document.intervals) == 8
    assert window.viewport.scene.up.tolist() == [0.0, 0.0, 1.0]
    act(window, "next_interval")
    first = document.interval.interval
    act(window, "accept")
    act(window, "save_session")
    assert (tmp_path / "walk_poses.npz.twist.json").exists()

    act(window, "export_dialog")
    qtbot.waitUntil(lambda: window.findChild(ExportDialog) is not None)
    dialog = window.findChild(ExportDialog)
    out = tmp_path / "walk_poses_refined.npz"
    assert (dialog.path.text(), dialog.pattern()) == (str(out), "NPZ (*.npz)")
    dialog.path.setText(str(out.with_suffix(".bvh")))
    assert ".npz" in dialog.obstacle.text()
    assert not dialog.do_it.isEnabled()
    dialog.path.setText(str(out))
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    qtbot.waitUntil(out.exists)
    assert window.exporter.finish()
    assert find_exports_and_their_sources([out, walk]) == {out: walk.name}

    before, after = loaded(walk), loaded(out)
    assert [*before] == [*after]
    assert all(before[n].tobytes() == after[n].tobytes() for n in before if n != "poses")
    differ = (before["poses"] != after["poses"]).reshape(-1, 52, 3).any(axis=2)
    chain = next(c for c in document.data.chains if c.name == first.chain)
    wanted = np.zeros_like(differ)
    wanted[first.start : first.stop, list(chain.changed_joints(document.data.motion.skeleton))] = 1
    assert (differ == wanted).all()
    again = tmp_path / "again.npz"
    session = tmp_path / "walk_poses.npz.twist.json"
    assert twistcore(["apply", str(session), str(walk), "-o", str(again)]) == 0
    capsys.readouterr()
    assert again.read_bytes() == out.read_bytes()

    open_clip(qtbot, window, out)
    assert len(document.intervals) == 7
    open_clip(qtbot, window, session)
    assert document.data.clip.name == walk.name
    assert [j.decision for j in document.intervals].count(Decision.ACCEPTED) == 1


def test_an_export_is_told_from_a_clip_by_its_arrays_where_nothing_else_says(walk):
    """Without a session or a report beside it: the same names and sizes, by the usual name."""
    out = walk.with_name("walk_poses_refined.npz")
    out.write_bytes(walk.read_bytes())
    assert find_exports_and_their_sources([out, walk]) == {out: walk.name}
    other = read_bvh(INJECTED).motion.sliced(0, 100)
    write_amass(out, other)
    assert find_exports_and_their_sources([out, walk]) == {}


@pytest.mark.thorough
def test_a_pickle_of_aist_is_judged_and_exported(qtbot, window, tmp_path):
    path = write_aist(tmp_path / "gBR_sBM.pkl", read_bvh(INJECTED).motion)
    open_clip(qtbot, window, path)
    document = window.document
    assert document.intervals
    act(window, "next_interval")
    act(window, "accept")
    act(window, "export_dialog")
    qtbot.waitUntil(lambda: window.findChild(ExportDialog) is not None)
    dialog = window.findChild(ExportDialog)
    out = tmp_path / "gBR_sBM_refined.pkl"
    assert (dialog.path.text(), dialog.pattern()) == (str(out), "PKL (*.pkl)")
    for ending in (".fbx", ".npz"):
        dialog.path.setText(str(out.with_suffix(ending)))
        qtbot.waitUntil(lambda: not dialog.do_it.isEnabled())
        assert ".pkl" in dialog.obstacle.text()
    dialog.path.setText(str(out))
    dialog.session.setChecked(False)
    dialog.report.setChecked(False)
    QTest.keyClick(dialog, Qt.Key.Key_Return)
    qtbot.waitUntil(out.exists)
    assert window.exporter.finish()
    was, now = path.read_bytes(), out.read_bytes()
    assert len(was) == len(now)
    assert was != now
    assert find_exports_and_their_sources([out, path]) == {out: path.name}


@pytest.mark.thorough
def test_what_is_taught_of_a_joint_without_euler_angles(qtbot, window, walk):
    open_clip(qtbot, window, walk)
    window.document.select_chain("left_elbow")
    window.document.go_to(130)
    act(window, "show_teaching")
    qtbot.waitUntil(lambda: window.teaching.typesetter.done, timeout=30_000)
    qtbot.mouseClick(window.teaching.other_forms.head, Qt.MouseButton.LeftButton, pos=QPoint(20, 6))
    values = window.teaching.other_forms.values
    assert values["parent"].text() == values["child"].text()
    assert values["n"].text()


@pytest.mark.thorough
def test_what_is_no_amass_is_one_sentence_and_the_window_stays(qtbot, show_window, tmp_path):
    window = show_window()
    np.savez(tmp_path / "shape.npz", betas=np.zeros(16), gender=np.array("female"))
    with qtbot.waitSignal(window.document.message, timeout=10_000) as told:
        window.open_path(tmp_path / "shape.npz")
    text, wrong = told.args
    assert wrong
    assert names_in_one_line(text, "'poses'", "'trans'", "betas, gender")
    assert window.document.data is None


@pytest.mark.thorough
def test_every_body_s_joint_is_drawn(qtbot, window, tmp_path):
    for joints in BODIES:
        path = write_amass(tmp_path / f"{joints}.npz", read_bvh(INJECTED).motion, joints)
        open_clip(qtbot, window, path)
        assert len(window.document.data.motion.skeleton) == joints


@pytest.mark.thorough
def test_a_folder_queues_it_beside_a_bvh(qtbot, window, walk):
    shutil.copy(INJECTED, walk.parent)
    window.open_path(walk.parent)
    qtbot.waitUntil(lambda: not window.queue.running, timeout=60_000)
    found = {path.name: clip for path, clip in window.queue.clips.items()}
    assert found.keys() == {walk.name, INJECTED.name}
    assert all(clip.state == ClipState.READY for clip in found.values())
