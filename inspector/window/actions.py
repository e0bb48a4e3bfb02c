"""Menus, keyboard shortcuts and help, built from the table of actions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QWidget

from inspector.feature import ActionRow
from inspector.language import chosen_language, tr, tr_as
from inspector.session.settings import Settings
from inspector.widgets.labels import escape_menu_text

_TITLES = {  # titles of menus; & precedes the letter that opens the menu
    "File": tr_as("menu", "&File"),
    "Edit": tr_as("menu", "&Edit"),
    "Go": tr_as("menu", "&Go"),
    "View": tr_as("menu", "&View"),
    "Chains": tr_as("menu", "&Chains"),
    "Tuning": tr_as("menu", "&Tuning"),
    "Quality": tr_as("menu", "&Quality"),
    "Teach": tr_as("menu", "&Teach"),
    "Help": tr_as("menu", "&Help"),
}


# The rows of each menu, keyed by name; None is a separator
Menus = Mapping[str, Sequence[ActionRow[Any] | None]]


def rows(menus: Menus) -> Iterator[ActionRow[Any]]:
    """Yield the rows of all menus, except separators."""
    return (row for menu in menus.values() for row in menu if row is not None)


def menu_title(name: str) -> str:
    """Return the title of a menu, with & before the letter that opens the menu."""
    return _TITLES.get(name, f"&{name}")


def menu_order(name: str) -> int:
    """Return a sort key for a menu's position. Unknown menus are placed before the Help menu."""
    known = list(_TITLES)
    return 2 * known.index(name) if name in known else 2 * known.index("Help") - 1


def key_text(key: str) -> str:
    """Return a keyboard shortcut in the operating system's notation."""
    return QKeySequence(key).toString(QKeySequence.SequenceFormat.NativeText)


def build_actions(
    menus: Menus, window: QWidget, bar: QMenuBar
) -> tuple[Mapping[str, QAction], Mapping[str, QMenu]]:
    """Create the actions, keyed by id, and the menus, keyed by name.

    The actions have neither shortcuts nor functions yet.
    """
    shown = {name: bar.addMenu(menu_title(name)) for name in menus}
    groups: dict[str, QActionGroup] = {}
    actions: dict[str, QAction] = {}
    for name, menu in menus.items():
        for row in menu:
            if row is None:
                shown[name].addSeparator()
                continue
            action = QAction(row.text, window)
            shown[name].addAction(action)
            action.setObjectName(row.id)
            action.setStatusTip(row.tip)
            action.setAutoRepeat(not row.verdict)
            action.setCheckable(row.checkable or bool(row.group))
            action.setChecked(row.checked)
            if not row.ready:
                action.setEnabled(False)
            if row.group:
                groups.setdefault(row.group, QActionGroup(window)).addAction(action)
            window.addAction(action)
            actions[row.id] = action
    return actions, shown


def apply_keys(menus: Menus, actions: Mapping[str, QAction], settings: Settings) -> None:
    """Assign keyboard shortcuts to the actions: the user's choice or, if none, the default."""
    for row in rows(menus):
        keys = settings.keys.get(row.id, list(row.keys))
        actions[row.id].setShortcuts([QKeySequence(k) for k in keys])
        shown = f" ({key_text(keys[0])})" if keys else ""
        actions[row.id].setToolTip(f"{row.tip or row.text}{shown}")


def enable_available_actions(
    menus: Menus, actions: Mapping[str, QAction], *, is_open: bool, has_figure: bool
) -> None:
    """Enable or disable the actions that need an open clip or a 3D figure."""
    for row in rows(menus):
        if row.needs:
            lacks_figure = row.needs == "figure" and not has_figure
            actions[row.id].setEnabled(is_open and not lacks_figure)


def set_undo_step_name(action: QAction, title: str, step: str) -> None:
    """Add the name of a step to the text of the undo or redo action.

    `title` is the text without the name. If `step` is '', the action is disabled.
    """
    if chosen_language() == "en":  # German nouns keep their capital letter
        step = step[:1].lower() + step[1:]
    step = escape_menu_text(step)
    text = tr("{undo_or_redo} {step}", undo_or_redo=title, step=step) if step else title
    # Each change of an action makes the toolbar compute its layout again.
    if (text, bool(step)) != (action.text(), action.isEnabled()):
        action.setEnabled(bool(step))
        action.setText(text)
        action.setIconText(title)
