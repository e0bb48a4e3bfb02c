"""What the whole window says in a language: `said_texts.py CODE CLIP`, as JSON.

`texts`: by every text that is seen or heard, where it was met first; `unnamed`: likewise by widgets
that the keyboard reaches, and plots, for which a screen reader has no name. Every dock, tab and
dialog is opened.
"""

import json
import sys
from pathlib import Path

import pyqtgraph as pg
from PySide6.QtCore import QAbstractListModel, Qt
from PySide6.QtGui import QAccessible, QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDialog,
    QDockWidget,
    QGroupBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QMenu,
    QTabWidget,
    QTextEdit,
    QWidget,
)

from inspector.app import make_application
from inspector.session.settings import Settings
from tests.gui.waiting import wait

_ROWS = 12  # of a table: those below say the same of others
_DIALOGS = (
    "export_dialog", "preferences", "record_dialog", "show_shortcuts", "command_palette",
    "add_chain", "accept_confident", "reject_for", "why_quaternions",
)  # fmt: skip


class Said:
    """Texts with the place where each was met first."""

    def __init__(self):
        self.texts: dict[str, str] = {}
        self.unnamed: dict[str, str] = {}

    def take(self, where: str, *texts: str | None) -> None:
        for text in texts:
            if text and text.strip():
                self.texts.setdefault(text, where)

    def look(self, where: str, top: QWidget) -> None:
        """At everything in a window that is in sight or comes with it."""
        wait(50)
        for widget in [top, *top.findChildren(QWidget)]:
            self._look_at(where, widget)
        for action in top.findChildren(QAction):
            self.take(f"{where}, action {action.objectName()}", action.text(), action.toolTip(),
                      action.statusTip(), action.iconText())  # fmt: skip

    def _look_at(self, where: str, widget: QWidget) -> None:
        place = f"{where}, {path_of(widget)}"
        self.take(place, widget.toolTip(), widget.statusTip(), widget.accessibleName(),
                  widget.accessibleDescription(), widget.whatsThis())  # fmt: skip
        if isinstance(widget, QLabel | QAbstractButton):
            self.take(place, widget.text())
        elif isinstance(widget, QComboBox):
            self.take(place, *(widget.itemText(k) for k in range(widget.count())))
        elif isinstance(widget, QLineEdit):
            self.take(place, widget.placeholderText())
        elif isinstance(widget, QAbstractSpinBox):
            self.take(place, widget.specialValueText(), *_around(widget))
        elif isinstance(widget, QDialog | QDockWidget):
            self.take(place, widget.windowTitle())
        elif isinstance(widget, QGroupBox | QMenu):
            self.take(place, widget.title())
        elif isinstance(widget, QTabWidget):
            for k in range(widget.count()):
                self.take(place, widget.tabText(k), widget.tabToolTip(k))
        elif isinstance(widget, pg.GraphicsView):
            self._look_at_plots(place, widget)
        elif isinstance(widget, QTextEdit):
            self.take(place, *widget.toPlainText().split("\n"))
        elif isinstance(widget, QAbstractItemView) and not isinstance(widget, QHeaderView):
            self._look_at_table(place, widget)
        if _is_reached(widget) and not _name_of(widget):
            self.unnamed.setdefault(path_of(widget), where)

    def _look_at_table(self, place: str, table: QAbstractItemView) -> None:
        model, role = table.model(), Qt.ItemDataRole
        columns = 1 if isinstance(model, QAbstractListModel) else model.columnCount()
        for column in range(columns):
            for what in (role.DisplayRole, role.ToolTipRole, role.AccessibleTextRole):
                head = model.headerData(column, Qt.Orientation.Horizontal, what)
                if isinstance(head, str) and not head.isdigit():
                    self.take(place, head)
                for row in range(min(model.rowCount(), _ROWS)):
                    cell = model.index(row, column).data(what)
                    if isinstance(cell, str):
                        self.take(place, cell)

    def _look_at_plots(self, place: str, view: pg.GraphicsView) -> None:
        for item in view.scene().items():
            for name in ("toPlainText", "text", "labelString", "toolTip"):
                text = getattr(item, name, None)
                if callable(text) and isinstance(said := text(), str):
                    self.take(f"{place}, {type(item).__name__}", said)


def path_of(widget: QWidget) -> str:
    """The widget's kind, and the rooms of the program that it stands in."""
    names = [f"{type(widget).__module__}.{type(widget).__name__}"]
    above = widget.parentWidget()
    while above is not None:
        if type(above).__module__.startswith("inspector"):
            names.append(type(above).__module__.removeprefix("inspector."))
        above = above.parentWidget()
    return " in ".join(names[:3])


def _around(box: QAbstractSpinBox) -> tuple[str, ...]:
    return tuple(getattr(box, part)() for part in ("prefix", "suffix") if hasattr(box, part))


def _is_reached(widget: QWidget) -> bool:
    """Whether the tab key or a click gives it the keyboard, itself and not what is in it; plots."""
    if not widget.isVisible() or widget.visibleRegion().isEmpty() or widget.focusProxy():
        return False
    parts = QAbstractSpinBox | QComboBox | QAbstractItemView
    if isinstance(widget.parentWidget(), parts) or isinstance(widget, QMenu):
        return False
    return widget.focusPolicy() != Qt.FocusPolicy.NoFocus or isinstance(widget, pg.GraphicsView)


def _name_of(widget: QWidget) -> str:
    known = QAccessible.queryAccessibleInterface(widget)
    return known.text(QAccessible.Text.Name) if known is not None else ""


def main() -> None:
    language, clip = sys.argv[1:3]
    make_application(language)
    from inspector.window.main_window import MainWindow  # in its language from here on

    window, said = MainWindow(Settings(turn_ms=0, reviewer_asked=True), None), Said()
    window.resize(1440, 900)
    window.show()
    assert QTest.qWaitForWindowExposed(window, 60_000)
    said.look("empty", window)
    window.open_path(Path(clip))
    _wait(lambda: window.document.data is not None)
    do = window.actions_by_id
    do["next_interval"].trigger()
    said.look("interval", window)
    do["accept"].trigger()
    do["why_not"].trigger()
    said.look("accepted", window)
    for dock in window.docks.values():
        dock.show()
        dock.raise_()
        _settle(window, dock)
        said.look(f"dock {dock.objectName()}", dock)
        for tabs in dock.findChildren(QTabWidget):
            for k in range(tabs.count()):
                tabs.setCurrentIndex(k)
                said.look(f"dock {dock.objectName()}, tab {k}", tabs)
    for name in _DIALOGS:
        before = set(QApplication.topLevelWidgets())
        do[name].trigger()
        wait(200)
        opened = [w for w in QApplication.topLevelWidgets() if w not in before and w.isVisible()]
        assert opened, f"{name} opens nothing"
        for top in opened:
            said.take(name, top.windowTitle())
            said.look(name, top)
            top.close()
    do["exercise"].trigger()
    said.look("exercise", window)
    window.lesson_actions.leave_guide()
    window.document.review.mark_saved()
    window.close()
    print(json.dumps({"texts": said.texts, "unnamed": said.unnamed}))


def _settle(window, dock: QDockWidget) -> None:
    if dock.objectName() == "teaching":
        _wait(lambda: window.teaching.typesetter.done)
    elif dock.objectName() == "tuning":
        _wait(lambda: len(window.tuning.costs.curves) == len(window.tuning.costs.names))
    elif dock.objectName() == "quality":
        _wait(lambda: window.quality.evidence.known is not None)
    wait(100)


def _wait(ready) -> None:
    while not ready():
        wait(20)


if __name__ == "__main__":  # worker processes import this module again
    main()
