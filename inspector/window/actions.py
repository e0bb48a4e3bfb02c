"""What menus, keys and help are made of: rows of what a person can do, menu by menu."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from PySide6.QtGui import QAction, QActionGroup, QKeySequence
from PySide6.QtWidgets import QMenu, QMenuBar, QWidget

from inspector.session.settings import Settings


@dataclass(frozen=True)
class Row:
    """One thing a person can do, as it is shown.

    checked: at the start; group: of rows of which exactly one is checked.
    """

    id: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    checked: bool = field(default=False, kw_only=True)
    group: str = field(default="", kw_only=True)
    checkable: ClassVar[bool] = False


Menus = Mapping[str, Sequence[Row | None]]  # by name, in their order; None: a line between rows


def rows(menus: Menus) -> Iterator[Row]:
    """All of them, without the lines."""
    return (row for menu in menus.values() for row in menu if row is not None)


def build_actions(
    menus: Menus, window: QWidget, bar: QMenuBar
) -> tuple[Mapping[str, QAction], Mapping[str, QMenu]]:
    """QActions by id, which do nothing yet and have no keys, and the menus by name."""
    shown = {name: bar.addMenu(f"&{name}") for name in menus}
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
            action.setCheckable(row.checkable or bool(row.group))
            action.setChecked(row.checked)
            if row.group:
                groups.setdefault(row.group, QActionGroup(window)).addAction(action)
            window.addAction(action)
            actions[row.id] = action
    return actions, shown


def apply_keys(menus: Menus, actions: Mapping[str, QAction], settings: Settings) -> None:
    """Give the actions the keys of their rows, or those the person has chosen instead."""
    for row in rows(menus):
        keys = settings.keys.get(row.id, list(row.keys))
        actions[row.id].setShortcuts([QKeySequence(k) for k in keys])
        shown = f" ({keys[0]})" if keys else ""
        actions[row.id].setToolTip(f"{row.tip or row.text}{shown}")
