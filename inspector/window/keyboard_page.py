"""The list of keyboard shortcuts and mouse gestures, as a window and for docs/shortcuts.md."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLineEdit, QWidget

from inspector.feature import ActionRow
from inspector.language import tr, tr_as
from inspector.widgets.building import hbox, vbox
from inspector.widgets.guide_page import MarkdownPage
from inspector.window.actions import Menus, key_text, menu_title

_MARGIN = 12  # pixels around the page
_MOUSE = (
    (tr("Plots: wheel"), tr("zoom at the cursor")),
    (tr("Plots: Shift+wheel"), tr("pan")),
    (tr("Plots: Ctrl+wheel, wheel over the left axis"), tr("zoom the values at the cursor")),
    (tr("Plots: drag the left axis · double-click it"), tr("pan the values · show all values")),
    (tr("Plots: double-click a title"), tr("show only that plot, or all plots")),
    (tr("Plots: drag an edge or the body of an interval"), tr("resize or move the interval")),
    (tr("Plots: drag outside the intervals"), tr("draw an interval for the selected chain")),
    (
        tr("Plots: click · drag the playhead"),
        tr("select an interval or set the playhead · move the playhead"),
    ),
    (tr("Plots: drag the τ line, or double-click the strength curve"), tr("set τ")),
    (tr("Tuning: drag the τ line, or double-click in a plot"), tr("set τ")),
    (tr("Plots: Esc during a drag"), tr("cancel the drag")),
    (tr("Plots: right button"), tr("open the menu")),
    (tr("Intervals: click ▸ or ▾"), tr("expand or collapse a group of errors")),
    (tr("Overview: click"), tr("select the interval under the mouse, or set the playhead")),
    (
        tr("Overview: drag the visible range or its edges · drag outside it"),
        tr("pan or zoom · move the playhead"),
    ),
    (tr("3D: drag · Shift+drag · wheel"), tr("orbit · pan · zoom")),
    (tr("3D: click a bone"), tr("select its chain; click again for the whole arm or leg")),
    (
        tr("Teaching: drag w in 3D · the dial · with Ctrl"),
        tr("swing · twist · let the child counter-twist"),
    ),
    (
        tr("Teaching: click a symbol"),
        tr("highlight the symbol in the list, in 3D and in the plots"),
    ),
)


def shortcuts_markdown(menus: Menus, wanted: str = "") -> str:
    """Return a table of keyboard shortcuts and mouse gestures as Markdown.

    `wanted` contains search words. A row is included only if its keys, menu and description
    together contain all of these words.
    """
    words = wanted.lower().split()

    def fits(*texts: str) -> bool:
        return all(word in " ".join(texts).lower() for word in words)

    lines = ["# " + tr("Keyboard and mouse"), ""]
    key, does, place, mouse_title = tr("key"), tr("action"), tr("where"), tr("Mouse")
    for name, menu in menus.items():
        title = menu_title(name).replace("&", "")
        keyed = [row for row in menu if row is not None and row.keys]
        if keyed := [row for row in keyed if fits(title, *_keys(row), _does(row))]:
            lines += [f"## {title}", "", f"| {key} | {does} |", "|---|---|"]
            between = tr_as("one key or another", " or ")
            lines += [
                f"| {between.join(f'`{k}`' for k in _keys(row))} | {_does(row)} |" for row in keyed
            ]
            lines.append("")
    if mouse := [(where, what) for where, what in _MOUSE if fits(mouse_title, where, what)]:
        lines += [f"## {mouse_title}", "", f"| {place} | {does} |", "|---|---|"]
        lines += [f"| {where} | {what} |" for where, what in mouse]
    elif len(lines) == 2:
        lines.append(tr("No key or mouse gesture matches."))
    return "\n".join(lines) + "\n"


def _keys(row: ActionRow[Any]) -> tuple[str, ...]:
    return tuple(key_text(key) for key in row.keys)


def _does(row: ActionRow[Any]) -> str:
    name = row.text.rstrip("…")
    if not row.tip:
        return name
    return f"{name} {row.tip}" if name.endswith("?") else f"{name}: {row.tip}"


class KeyboardPage(QWidget):
    """A window with a search field above a list of keyboard shortcuts and mouse gestures.

    Esc closes the window. The program's Ctrl shortcuts also work in this window.
    """

    def __init__(self, menus: Menus, window: QWidget) -> None:
        super().__init__(window, Qt.WindowType.Tool)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Keyboard and mouse"))
        self._menus = menus
        self.line = QLineEdit(
            placeholderText=tr("Find a key or an action"), clearButtonEnabled=True
        )
        self.line.setAccessibleName(tr("Find a key or an action"))
        self.page = MarkdownPage()
        self.page.setAccessibleName(tr("Keyboard and mouse"))
        self.page.document().setDocumentMargin(_MARGIN)
        vbox((hbox(self.line, margins=(8, 8, 8, 0))), (self.page, 1), owner=self,
             margins=(0, 0, 0, 0))  # fmt: skip
        self.line.textChanged.connect(self._show)
        self._show("")
        self.resize(520, min(640, self.screen().availableSize().height() - 60))

    def _show(self, wanted: str) -> None:
        _, _, below = shortcuts_markdown(self._menus, wanted).partition("\n")
        self.page.setMarkdown(below)  # without the title, which the window already has
        self.page.soften_tables()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Close the window on Esc."""
        if event.key() == Qt.Key.Key_Escape:
            self.close()
        else:
            super().keyPressEvent(event)


def show_shortcuts(menus: Menus, window: QWidget) -> None:
    """Open the keyboard shortcuts window, and focus its search field."""
    page = KeyboardPage(menus, window)
    page.show()
    page.activateWindow()  # so that Esc reaches this window
    page.line.setFocus()
