"""The window's features: where their rows and docks come, and what they may name."""

from __future__ import annotations

import pytest
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QLabel

from inspector.feature import (
    ActionRow,
    ActionSpec,
    Area,
    DockPanel,
    Feature,
    FeatureParts,
    MenuRows,
    Tick,
    Tool,
)
from inspector.window import features
from inspector.window.action_table import MENUS
from inspector.window.actions import rows
from inspector.window.preferences import Preferences
from inspector.window.toolbar import ToolBar


def row(name: str) -> ActionSpec[object]:
    return ActionSpec(name, name.title(), do=lambda _: None)


def ids(menu: tuple[ActionRow[object] | None, ...]) -> list[str | None]:
    return [r.id if r is not None else None for r in menu]


def feature(
    *placed: MenuRows[FeatureParts], panels: tuple[DockPanel[FeatureParts], ...] = ()
) -> Feature[FeatureParts]:
    return Feature("new", lambda _: FeatureParts(), rows=placed, panels=panels)


OWN = {"File": (row("open"), None, row("close")), "Help": (row("about"),)}


def test_rows_come_directly_after_the_one_they_name(monkeypatch):
    new = feature(MenuRows("File", (None, row("first"), row("second")), after="open"))
    monkeypatch.setattr(features, "FEATURES", (new,))
    menus = features.insert_feature_rows(OWN)
    assert ids(menus["File"]) == ["open", None, "first", "second", None, "close"]
    assert ids(OWN["File"]) == ["open", None, "close"]


def test_without_a_place_rows_come_last_and_a_new_menu_before_the_help(monkeypatch):
    new = feature(MenuRows("File", (row("last"),)), MenuRows("Extra", (row("own"),)))
    monkeypatch.setattr(features, "FEATURES", (new,))
    menus = features.insert_feature_rows(OWN)
    assert list(menus) == ["File", "Extra", "Help"]
    assert ids(menus["File"])[-1] == "last"


def test_rows_after_one_that_does_not_exist_are_an_error(monkeypatch):
    monkeypatch.setattr(
        features, "FEATURES", (feature(MenuRows("File", (row("x"),), after="none")),)
    )
    with pytest.raises(ValueError, match="none"):
        features.insert_feature_rows(OWN)


def test_a_panel_comes_directly_before_the_one_it_names(monkeypatch):
    left, content = Area.LeftDockWidgetArea, lambda _: QLabel()
    old = feature(panels=(DockPanel("a", "A", left, content), DockPanel("b", "B", left, content)))
    new = feature(panels=(DockPanel("c", "C", left, content, before="b"),))
    monkeypatch.setattr(features, "FEATURES", (old, new))
    assert [panel.name for _, panel in features.panels()] == ["a", "c", "b"]


def test_every_name_is_given_once():
    every = [r.id for r in rows(MENUS)]
    docks = [panel.name for _, panel in features.panels()]
    names = [f.name for f in features.FEATURES]
    for given in (every, docks, names):
        assert len(given) == len(set(given))


def test_no_two_actions_have_the_same_key():
    """Qt runs neither of two actions with the same key."""
    keys = [key for row in rows(MENUS) for key in row.keys]
    assert sorted(keys) == sorted(set(keys))


def test_preferences_ask_for_the_settings_of_features(qapp, show_window):
    window = show_window()
    ticks = [tick for f in features.FEATURES for tick in f.settings]
    before = {tick.name: window.settings.value(tick.name) for tick in ticks}
    assert {type(value) for value in before.values()} == {bool}
    dialog = Preferences(window.settings, MENUS, [*ticks, Tick("zoom_to_interval", "Z")], window)
    for name in (*before, "zoom_to_interval"):
        dialog.boxes[name].toggle()
    dialog.accept()
    assert all(window.settings.value(name) is not was for name, was in before.items())
    assert window.settings.zoom_to_interval is False


def test_a_row_of_a_feature_declares_its_button(show_window):
    window = show_window()
    new = ActionSpec("new", "New", do=lambda _: None, tool=Tool("Word", 25))
    old = ActionSpec("old", "Old", do=lambda _: None, tool=Tool("First", 21, 1))
    actions = {name: QAction(name, window) for name in ("new", "old", "plain")}
    bar = ToolBar({"File": (new, row("plain"), None, old)}, actions, window.colours)
    assert bar.actions() == [actions["old"], actions["new"]]
    assert actions["new"].iconText() == "Word"
    third = {"third": QAction("third", window)}
    later = ActionSpec("third", "", do=lambda _: None, tool=Tool("Third", 30))
    bar = ToolBar({"File": (later, new)}, actions | third, window.colours)
    assert [a.isSeparator() for a in bar.actions()] == [False, True, False]


def test_parts_of_features_are_attributes_of_the_window(show_window):
    window = show_window()
    for part in window.built.values():
        public = {name: built for name, built in vars(part).items() if not name.startswith("_")}
        assert all(getattr(window, name) is built for name, built in public.items())
