"""The page of keys and mouse: a window of its own, and docs/shortcuts.md."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit, QWidget

from inspector.widgets.building import hbox, vbox
from inspector.widgets.guide_page import MarkdownPage
from inspector.window.actions import Menus, Row

_MARGIN = 12  # pixels around the page
_MOUSE = (
    ("Plots: wheel", "zoom at the cursor"),
    ("Plots: Shift+wheel", "pan"),
    ("Plots: Ctrl+wheel, wheel over the left axis", "zoom the values at the cursor"),
    ("Plots: drag the left axis · double click it", "pan the values · show all values"),
    ("Plots: double click a title", "that plot alone, or all again"),
    ("Plots: drag an edge or the body of an interval", "resize or move it"),
    ("Plots: drag on empty ground", "draw an interval of the selected chain"),
    ("Plots: click · drag the playhead", "select an interval or set the playhead · move it"),
    ("Plots: drag the τ line, double click on the strength", "set τ"),
    ("Tuning: drag the τ line, double click in a plot", "set τ"),
    ("Plots: right button", "menu; it never deletes"),
    ("Overview: click", "select the interval there, else set the playhead"),
    ("Overview: drag the window or its edges · beside it", "pan or zoom · move the playhead"),
    ("3D: drag · Shift+drag · wheel", "orbit · pan · zoom"),
    ("3D: click a bone", "select its chain; again: its whole arm or leg"),
    ("Teaching: drag w in 3D · its dial · with Ctrl", "swing · twist · the child counters"),
    ("Teaching: click a symbol", "light it up in the list, in 3D and in the plots"),
)


def shortcuts_markdown(menus: Menus, wanted: str = "") -> str:
    """The table of keys and mouse for the help window and docs/shortcuts.md.

    wanted: only what has all of these words in its keys, its menu or what it does.
    """
    words = wanted.lower().split()

    def fits(*said: str) -> bool:
        return all(word in " ".join(said).lower() for word in words)

    lines = ["# Keyboard and mouse", ""]
    for name, menu in menus.items():
        keyed = [row for row in menu if row is not None and row.keys]
        if keyed := [row for row in keyed if fits(name, *row.keys, _does(row))]:
            lines += [f"## {name}", "", "| key | does |", "|---|---|"]
            lines += [f"| {' or '.join(f'`{k}`' for k in r.keys)} | {_does(r)} |" for r in keyed]
            lines.append("")
    if mouse := [(where, does) for where, does in _MOUSE if fits("mouse", where, does)]:
        lines += ["## Mouse", "", "| where | does |", "|---|---|"]
        lines += [f"| {where} | {does} |" for where, does in mouse]
    elif len(lines) == 2:
        lines.append("Nothing of that kind.")
    return "\n".join(lines) + "\n"


def _does(row: Row) -> str:
    return f"{row.text}: {row.tip}" if row.tip else row.text


class KeyboardPage(QWidget):
    """Keys and mouse in a window of their own, with a line to search them.

    Esc closes it; keys with Ctrl and the like go on working in the program behind it.
    """

    def __init__(self, menus: Menus, window: QWidget) -> None:
        super().__init__(window, Qt.WindowType.Tool)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle("Keyboard and mouse")
        self._menus = menus
        self.line = QLineEdit(
            placeholderText="Find a key, or what it does", clearButtonEnabled=True
        )
        self.page = MarkdownPage()
        self.page.document().setDocumentMargin(_MARGIN)
        vbox((hbox(self.line, margins=(8, 8, 8, 0))), (self.page, 1), owner=self,
             margins=(0, 0, 0, 0))  # fmt: skip
        self.line.textChanged.connect(self._show)
        self._show("")
        self.resize(520, min(640, self.screen().availableSize().height() - 60))

    def _show(self, wanted: str) -> None:
        _, _, below = shortcuts_markdown(self._menus, wanted).partition("\n")
        self.page.setMarkdown(below)  # the window has the title
        self.page.soften_tables()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc closes it."""
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            super().keyPressEvent(event)


def show_shortcuts(menus: Menus, window: QWidget) -> None:
    """Keys and mouse, ready to be searched."""
    page = KeyboardPage(menus, window)
    page.show()
    page.activateWindow()  # so that Esc is meant for it
    page.line.setFocus()
