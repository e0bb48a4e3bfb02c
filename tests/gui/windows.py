"""What tests of the whole window do with it."""

from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QMessageBox


def wait_until_active(window):
    """On the screen and with the keyboard: keys sent before are lost."""
    window.activateWindow()
    assert QTest.qWaitForWindowActive(window, 60_000)


def open_clip(qtbot, window, path):
    """Open a clip or session and wait until it is there."""
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        window.open_path(Path(path))
    qtbot.wait(50)


def resize(qtbot, window, size):
    window.resize(*size)
    qtbot.waitUntil(lambda: (window.width(), window.height()) == size)
    qtbot.wait(50)


def close_window(qtbot, window):
    """Close it with nothing asked about decisions that are not saved."""
    window.lesson_actions.leave_guide()
    if window.document.data is not None:
        window.document.review.mark_saved()
    window.close()
    qtbot.wait(20)


def close_and_answer(window, wanted):
    """What a box says that is answered so while the window closes, '' for none."""
    told = []

    def answer():
        box = QApplication.activeModalWidget()
        if isinstance(box, QMessageBox):
            told.append(box.text())
            box.button(wanted).click()

    QTimer.singleShot(0, answer)
    window.close()
    QApplication.processEvents()
    return "".join(told)


def press(qtbot, window, key, modifier=Qt.KeyboardModifier.NoModifier):
    """Press a key once the selected interval is painted: a person looks first.

    Then wait until the errors of a group are shown, if the key is a decision on a group.
    """
    if hasattr(window, "viewport"):
        qtbot.waitUntil(window.viewport.has_painted_interval)
    qtbot.keyClick(window, key, modifier)
    qtbot.wait(5)
    if hasattr(window, "review_actions"):
        qtbot.waitUntil(lambda: not window.review_actions.look_through.running)


def act(window, name):
    """Do what an action does."""
    window.actions_by_id[name].trigger()


def decisions(window):
    return [j.decision for j in window.document.intervals]


def export(window, choice):
    """Export and wait until it is written, or refused."""
    window.files.export(choice)
    window.exporter.finish()
