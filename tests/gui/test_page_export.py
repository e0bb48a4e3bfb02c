"""Exporting a lesson as a web page from the menu: asked which and where, told what was written."""

from pathlib import Path

import pytest
from PySide6.QtWidgets import QFileDialog, QLineEdit

from inspector.bundled import LESSONS
from inspector.lessons.lesson_file import read_lesson
from tests.gui.windows import act


def answer(qtbot, window, path):
    """Type a path into the file dialog that is open; what it proposed."""
    qtbot.waitUntil(lambda: window.findChild(QFileDialog) is not None)
    dialog = window.findChild(QFileDialog)
    name = dialog.findChild(QLineEdit)
    proposed = Path(dialog.directory().path()) / name.text()
    name.setText(str(path))
    dialog.accept()
    qtbot.waitUntil(lambda: window.findChild(QFileDialog) is not dialog)
    return proposed


def test_the_lesson_that_is_on_is_written(qtbot, at_forearm, tmp_path):
    said = []
    at_forearm.document.message.connect(lambda *told: said.append(told))
    at_forearm.lesson_actions.play(LESSONS / "3-1-definition.md")
    qtbot.waitUntil(lambda: at_forearm.lesson_actions.player.at == 0, timeout=20_000)
    said.clear()
    act(at_forearm, "export_page")
    page = tmp_path / "mine.html"
    assert answer(qtbot, at_forearm, page) == Path.home() / "3-1-definition.html"
    qtbot.waitUntil(lambda: bool(said), timeout=30_000)
    assert said == [(f"The page {page} was written ({page.stat().st_size / 1e6:.1f} MB). "
                     "Open it in any browser.", False)]  # fmt: skip
    assert "3.1" in page.read_text("utf-8")
    assert at_forearm.lesson_actions.player.at == 0  # the lesson goes on


@pytest.mark.thorough
def test_without_one_a_file_is_asked_for_and_what_is_wrong_is_told(qtbot, at_forearm, tmp_path):
    said = []
    at_forearm.document.message.connect(lambda *told: said.append(told))
    wrong = tmp_path / "wrong.md"
    wrong.write_text("# No front matter\n", encoding="utf-8")
    act(at_forearm, "export_page")
    answer(qtbot, at_forearm, wrong)
    qtbot.waitUntil(lambda: bool(said))
    assert "'---'" in said[0][0]
    assert said[0][1]
    said.clear()
    own = tmp_path / "own.md"
    own.write_text((LESSONS / "3-1-definition.md").read_text("utf-8"), encoding="utf-8")
    act(at_forearm, "export_page")
    answer(qtbot, at_forearm, own)
    assert answer(qtbot, at_forearm, tmp_path / "own.html") == tmp_path / "own.html"
    qtbot.waitUntil(lambda: bool(said), timeout=30_000)
    assert (tmp_path / "own.html").exists()
    said.clear()
    lesson = read_lesson(own)
    at_forearm.lesson_actions.page_export.write(lesson, tmp_path / "gone" / "page.html")
    qtbot.waitUntil(lambda: bool(said), timeout=30_000)
    assert said[0][0].startswith("The page was not written. ")
    assert said[0][1]
