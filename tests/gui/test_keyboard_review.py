"""A whole review by keyboard alone: three clips, sixty intervals, edits, undo, redo, export."""

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QLineEdit

from inspector.window.export_dialog import ExportDialog
from tests.conftest import ASSETS
from tests.gui.windows import act, wait_until_active
from twistcore.cli import main as twistcore
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.review import Decision
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import clip_random_generator, draw_errors, inject

pytestmark = pytest.mark.thorough

CTRL = Qt.KeyboardModifier.ControlModifier


def injected(folder, name):
    """A sample with two to five errors in each of six chains."""
    clip = read_bvh(ASSETS / f"{name}.bvh")
    chains = find_chains(clip.motion)
    errors = draw_errors(clip.motion, chains[::2] + chains[9:], clip_random_generator(3, name))
    dirty = inject(clip.motion, chains, errors)
    path = folder / f"{name}.bvh"
    path.write_bytes(create_file_patch_for_motion(clip, dirty).data)
    return path


def type_into_file_dialog(qtbot, window, path):
    qtbot.waitUntil(lambda: window.findChild(QFileDialog) is not None)
    dialog = window.findChild(QFileDialog)
    wait_until_active(dialog)
    line = dialog.findChild(QLineEdit)
    line.setCompleter(None)  # its list would take the Return
    line.setText(str(path))
    QTest.keyClick(line, Qt.Key.Key_Return)


@pytest.fixture(autouse=True)
def dialogs_of_qt(qapp):
    """Dialogs of the system cannot be typed into from here."""
    QApplication.setAttribute(Qt.ApplicationAttribute.AA_DontUseNativeDialogs)


def test_three_clips_by_keyboard_alone(qtbot, window, tmp_path, capsys):
    total = 0
    window.settings.reviewer_asked = True
    act(window, "group_errors")  # off: one key for each interval

    def key(which, modifier=Qt.KeyboardModifier.NoModifier):
        qtbot.waitUntil(window.viewport.has_painted_interval)
        QTest.keyClick(QApplication.focusWidget() or window, which, modifier)

    for name in ("walk", "dance", "basketball"):
        path = injected(tmp_path, name)
        with qtbot.waitSignal(window.document.opened, timeout=20_000):
            key(Qt.Key.Key_O, CTRL)
            type_into_file_dialog(qtbot, window, path)
        window.activateWindow()  # a window manager does this when a dialog closes
        qtbot.waitUntil(window.isActiveWindow)
        document = window.document
        count = len(document.intervals)
        total += count

        key(Qt.Key.Key_N)
        for k in range(count):
            key(Qt.Key.Key_R if k % 5 == 4 else Qt.Key.Key_A)
        verdicts = [j.decision for j in document.intervals]
        assert verdicts.count(Decision.REJECTED) == count // 5
        assert Decision.UNDECIDED not in verdicts
        for _ in range(2):  # two edges: one frame later each
            key(Qt.Key.Key_N)
            before = document.interval.interval
            key(Qt.Key.Key_Right)
            if document.frame < before.stop:
                key(Qt.Key.Key_BracketLeft)
                assert document.interval.interval.start == before.start + 1
        edited = [j.edited for j in document.intervals]
        key(Qt.Key.Key_Z, CTRL)
        assert [j.edited for j in document.intervals] != edited or not any(edited)
        key(Qt.Key.Key_Y, CTRL)
        assert [j.edited for j in document.intervals] == edited
        key(Qt.Key.Key_S, CTRL)
        key(Qt.Key.Key_E, CTRL)
        qtbot.waitUntil(lambda: window.findChild(ExportDialog) is not None)
        QTest.keyClick(window.findChild(ExportDialog), Qt.Key.Key_Return)
        out, again = tmp_path / f"{name}_refined.bvh", tmp_path / f"{name}_again.bvh"
        qtbot.waitUntil(out.exists)
        assert window.exporter.finish()
        session = tmp_path / f"{name}.twist.json"
        assert twistcore(["apply", str(session), str(path), "-o", str(again)]) == 0
        capsys.readouterr()
        assert again.read_bytes() == out.read_bytes() != path.read_bytes()
        qtbot.waitUntil(lambda: window.findChild(ExportDialog) is None)
        window.activateWindow()
        qtbot.waitUntil(window.isActiveWindow)
    assert total >= 60
