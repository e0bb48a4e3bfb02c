"""The list of the window's features, and the menus that contain their actions."""

from __future__ import annotations

from typing import Any

from inspector.feature import ActionRow, AnyFeature, DockPanel, MenuRows
from inspector.folder.feature import feature as folder
from inspector.lessons.feature import feature as lessons
from inspector.quality.feature import feature as quality
from inspector.recording.feature import feature as recording
from inspector.reviewers.feature import feature as reviewers
from inspector.teaching.feature import feature as teaching
from inspector.tuning.feature import feature as tuning
from inspector.video.feature import feature as video
from inspector.window.actions import Menus, menu_order
from inspector.window.chains_feature import feature as chains
from inspector.window.review_feature import feature as review

# The window builds the features in this order. Each feature may use the features before it.
FEATURES: tuple[AnyFeature, ...] = (
    chains, review, reviewers, video, folder, tuning, teaching, lessons, quality, recording,
)  # fmt: skip


def insert_feature_rows(own: Menus) -> Menus:
    """Return the window's menus with the rows of all features inserted.

    `own` contains the rows that do not belong to a feature, keyed by menu.
    """
    menus = {name: list(rows) for name, rows in own.items()}
    for rows in (rows for feature in FEATURES for rows in feature.rows):
        _place(rows, menus)
    return {name: tuple(menus[name]) for name in sorted(menus, key=menu_order)}


def _place(rows: MenuRows[Any], menus: dict[str, list[ActionRow[Any] | None]]) -> None:
    menu = menus.setdefault(rows.menu, [])
    ids = [row.id if row is not None else "" for row in menu]
    at = ids.index(rows.after) + 1 if rows.after else len(menu)
    menu[at:at] = rows.rows


def panels() -> list[tuple[AnyFeature, DockPanel[Any]]]:
    """Return the panels of all features in display order, as (feature, panel)."""
    names: list[str] = []
    out: list[tuple[AnyFeature, DockPanel[Any]]] = []
    for feature in FEATURES:
        for panel in feature.panels:
            at = names.index(panel.before) if panel.before else len(names)
            names.insert(at, panel.name)
            out.insert(at, (feature, panel))
    return out
