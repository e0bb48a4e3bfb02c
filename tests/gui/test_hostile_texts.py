"""The whole window with texts that somebody wrote to be obeyed: all are seen, none is.

Some of the texts are tried; all of them with TWIST_INSPECTOR_TEXTS=all.
"""

import ctypes
import os
import re
import sys
import time
from pathlib import Path

import pyqtgraph as pg
import pytest
from PySide6.QtCore import QAbstractListModel, Qt
from PySide6.QtGui import QAction, QImage, QTextDocument
from PySide6.QtWidgets import (
    QApplication,
    QGraphicsTextItem,
    QLabel,
    QTabWidget,
    QTextEdit,
)

from inspector.language import tr, use_language
from inspector.widgets.labels import (
    bold,
    escape_menu_text,
    escape_tool_tip_text,
    plain_text,
    plain_to_rich_text,
)
from tests.gui.pictures import INJECTED
from tests.gui.said_texts import Said
from tests.gui.windows import act, open_clip
from tests.hostile_texts import as_file_name, hostile_clip, hostile_texts, shares
from tests.tiers import parametrize
from twistcore.files.encoding import escape_control_characters
from twistcore.review import Annotate
from twistcore.tuning import Tuned, write_profile

OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069]")
DIALOGS = ("export_dialog", "record_dialog", "add_chain", "accept_confident", "reject_for")


class Trap:
    """A picture that nothing may open; the kernel tells."""

    def __init__(self, path):
        self.path = path
        picture = QImage(8, 8, QImage.Format.Format_RGB32)
        picture.fill(Qt.GlobalColor.red)
        assert picture.save(str(path))
        self._told = -1
        if sys.platform == "linux":
            system = ctypes.CDLL(None)
            self._told = system.inotify_init1(os.O_NONBLOCK)
            assert system.inotify_add_watch(self._told, os.fsencode(path), 0x20) >= 0  # IN_OPEN

    @property
    def opened(self):
        try:
            return self._told >= 0 and bool(os.read(self._told, 65536))
        except BlockingIOError:
            return False


@pytest.fixture
def trap(tmp_path, qapp):
    trap = Trap(tmp_path / "trap.png")
    assert not trap.opened
    yield trap
    assert not trap.opened


def test_the_trap_tells(tmp_path, qapp):
    trap = Trap(tmp_path / "trap.png")
    document = QTextDocument()
    document.setHtml(f'<img src="file://{trap.path}"><s>x</s>')
    document.size()
    assert not trap._told >= 0 or trap.opened
    assert obeyed_html(f'<img src="file://{tmp_path}/none.png">')


class NoFiles(QTextDocument):
    def loadResource(self, _kind, _name):  # noqa: N802  (Qt's name)
        return None


def obeyed_html(rich):
    """What of the hostile texts has been taken for HTML."""
    document = NoFiles()
    document.setHtml(rich)
    return obeyed_in(document)


def obeyed_in(document):
    found, block = [], document.begin()
    while block.isValid():
        parts = block.begin()
        while not parts.atEnd():
            looks = parts.fragment().charFormat()
            if looks.fontStrikeOut() or looks.isAnchor() or looks.isImageFormat():
                found.append(parts.fragment().text())
            parts += 1
        block = block.next()
    return found


class Looked(Said):
    """Every text of the window is seen as it is written, wherever it is."""

    def __init__(self):
        super().__init__()
        self.wrong, self.places = {}, set()

    def take(self, where, *texts):
        super().take(where, *texts)
        for text in filter(None, texts):
            self.places.add(where.split(", ", 1)[-1])
            if OBEYED.search(text):
                self.wrong.setdefault(f"{where}: steers", text[:200])

    def _look_at(self, where, widget):
        super()._look_at(where, widget)
        place = f"{where}, {type(widget).__module__}.{type(widget).__name__}"
        if isinstance(widget, QLabel) and widget.text():
            rich = widget.textFormat() == Qt.TextFormat.RichText
            if rich or (
                widget.textFormat() == Qt.TextFormat.AutoText and Qt.mightBeRichText(widget.text())
            ):
                self._html(place, widget.text())
        self._tip(f"{place}, tip", widget.toolTip())
        if isinstance(widget, QTextEdit):
            self._found(place, obeyed_in(widget.document()))
        if isinstance(widget, pg.GraphicsView):
            for item in widget.scene().items():
                if isinstance(item, QGraphicsTextItem):
                    self._found(place, obeyed_in(item.document()))
                if callable(getattr(item, "toolTip", None)):
                    self._tip(place, item.toolTip())

    def _look_at_table(self, place, table):
        super()._look_at_table(place, table)
        model = table.model()
        for row in range(min(model.rowCount(), 40)):
            for column in range(
                1 if isinstance(model, QAbstractListModel) else model.columnCount()
            ):
                tip = model.index(row, column).data(Qt.ItemDataRole.ToolTipRole)
                self._tip(f"{place}, item", tip if isinstance(tip, str) else "")

    def look(self, where, top):
        super().look(where, top)
        for action in top.findChildren(QAction):
            self._tip(f"{where}, action {action.objectName()}", action.toolTip())

    def _tip(self, place, tip):
        if tip and Qt.mightBeRichText(tip):
            self._html(place, tip)

    def _html(self, place, text):
        self._found(place, obeyed_html(text))

    def _found(self, place, found):
        if found:
            self.wrong.setdefault(f"{place}: HTML", " | ".join(found)[:200])


def through_the_window(qtbot, window, look):
    """Every interval, chain, panel, tab and dialog."""
    do = window.actions_by_id
    for k in range(len(window.document.intervals)):
        act(window, "next_interval")
        if k % 2:
            act(window, "accept")
        look.look(f"interval {k}", window)
    for dock in window.docks.values():
        dock.show()
        dock.raise_()
        qtbot.wait(100)
        look.look(f"dock {dock.objectName()}", dock)
        for tabs in dock.findChildren(QTabWidget):
            for k in range(tabs.count()):
                tabs.setCurrentIndex(k)
                qtbot.wait(50)
                look.look(f"dock {dock.objectName()}, tab {k}", tabs)
    for chain in window.document.data.chains[:6]:
        window.document.select_chain(chain.name)
        qtbot.wait(20)
        look.look("chain", window)
    for name in DIALOGS:
        before = set(QApplication.topLevelWidgets())
        do[name].trigger()
        qtbot.wait(100)
        for top in set(QApplication.topLevelWidgets()) - before:
            if top.isVisible():
                look.take(name, top.windowTitle())
                look.look(name, top)
                top.close()
    for text in ("undo", "redo"):
        look.take(text, do[text].text())


@pytest.mark.thorough
@pytest.mark.parametrize("begin", shares())
def test_nothing_that_is_written_is_obeyed(qtbot, window, tmp_path, trap, begin):
    texts = hostile_texts(str(trap.path))
    folder = tmp_path / as_file_name(texts[begin])
    folder.mkdir()
    clip = folder / f"{as_file_name(texts[(begin + 1) % len(texts)])}.bvh"
    names = hostile_clip(Path(INJECTED), clip, begin, str(trap.path))
    window.document.reviewer = texts[(begin + 2) % len(texts)]
    open_clip(qtbot, window, clip)
    for k, judged in enumerate(window.document.intervals):
        text = texts[(begin + k) % len(texts)]
        window.document.do(Annotate(judged.id, f"{text}\nmore", text))
    written = [(j.note, j.reason) for j in window.document.intervals]
    look = Looked()
    look.look("opened", window)
    through_the_window(qtbot, window, look)
    assert [(j.note, j.reason) for j in window.document.intervals] == written
    name = texts[(begin + 3) % len(texts)]
    profile = folder / f"{as_file_name(name, 180)}.toml"
    chains = window.document.data.chains
    write_profile(profile, {c.name: Tuned(3.0, 1.5, 0, 0) for c in chains}, name, "consistency")
    window.tuning_actions.compare_with([profile])
    look.look("profile", window)
    bad = folder / f"{as_file_name(name, 180)}x.bvh"
    bad.write_bytes(b"HIERARCHY " + name.encode("utf-8", "surrogateescape"))
    window.open_path(bad)
    qtbot.waitUntil(lambda: not window.document.opener.busy)
    qtbot.wait(50)
    look.look("a message", window)
    window.bar.ask(tr("{clip} has unsaved decisions.", clip=name), [(escape_menu_text(name), int)])
    look.look("a question", window)
    window.bar.clear()
    window.open_path(folder)
    qtbot.waitUntil(lambda: bool(window.queue.ordered) and not window.queue.running)
    qtbot.wait(50)
    look.look("folder", window)
    assert "\n".join(f"{where}: {text!r}" for where, text in look.wrong.items()) == ""
    assert len(look.places) > 50
    seen = "\n".join(look.texts).replace("\u2060", "")
    met = [
        n
        for n in names
        if escape_control_characters(n)[:30] in seen or plain_to_rich_text(n)[:30] in seen
    ]
    assert len(met) > 20, "hostile texts were not met"
    print(f"{len(look.texts)} texts at {len(look.places)} places")


def test_a_note_longer_than_its_line_is_kept(opened):
    """Ten million letters, of which a line of text takes 32,767; all of it would take minutes."""
    act(opened, "next_interval")
    judged = opened.document.interval

    def noted(letters):
        opened.document.do(Annotate(judged.id, "n" * letters, ""))
        began = time.process_time()
        for name in ("next_interval", "previous_interval", "accept"):
            act(opened, name)
        note = next(j.note for j in opened.document.intervals if j.id == judged.id)
        assert len(note) == letters
        act(opened, "undo")
        return time.process_time() - began

    few, many = noted(10**5), noted(10**7)
    assert many < 30.0 * few


@parametrize("text", hostile_texts("/hostile-trap"), quick=16)
def test_each_way_to_show_a_text_shows_it(qapp, text):
    """As a tool tip, in rich text, in a menu, in a sentence."""
    tip = escape_tool_tip_text(text)
    assert not Qt.mightBeRichText(tip)
    if not OBEYED.search(text) and not any("\ud800" <= c <= "\udfff" for c in text):
        shown = tip.replace("\u2060", "")
        assert shown == text or (shown[-1] == "…" and text.startswith(shown[:-1]))
        words = plain_text(bold(text))
        assert words.split() == text.split() or text.startswith(words[:-1])
    assert escape_menu_text(text).replace("&&", "").count("&") == 0
    for language in ("en", "de"):
        use_language(language)
        told = tr("{clip} has unsaved decisions.", clip=text)
        use_language("en")
        assert not OBEYED.search(told.replace("\t", ""))
        assert obeyed_html(bold(told)) == []
