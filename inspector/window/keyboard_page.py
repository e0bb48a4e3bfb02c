"""The page of keys and mouse: a window of its own, and docs/shortcuts.md."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QTextBrowser, QWidget

from inspector.window.actions import Menus, Row

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
    ("Teaching: click a symbol", "light it up in the list, in 3D and in the plots"),
)


def shortcuts_markdown(menus: Menus) -> str:
    """The table of keys and mouse for the help window and docs/shortcuts.md."""
    lines = ["# Keyboard and mouse", ""]
    for name, menu in menus.items():
        if keyed := [row for row in menu if row is not None and row.keys]:
            lines += [f"## {name}", "", "| key | does |", "|---|---|"]
            lines += [f"| {' or '.join(f'`{k}`' for k in r.keys)} | {_does(r)} |" for r in keyed]
            lines.append("")
    lines += ["## Mouse", "", "| where | does |", "|---|---|"]
    lines += [f"| {where} | {does} |" for where, does in _MOUSE]
    return "\n".join(lines) + "\n"


def _does(row: Row) -> str:
    return f"{row.text}: {row.tip}" if row.tip else row.text


class _Page(QTextBrowser):
    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc closes it; other keys of the program go on working while it is in front."""
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            super().keyPressEvent(event)


def show_shortcuts(menus: Menus, window: QWidget) -> None:
    """Keys and mouse in a window of their own."""
    page = _Page(window)
    page.setWindowFlag(Qt.WindowType.Tool)
    page.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    page.setWindowTitle("Keyboard and mouse")
    page.setMarkdown(shortcuts_markdown(menus))
    page.resize(520, 640)
    page.show()
    page.activateWindow()  # so that Esc is meant for it
