"""Panels that are built when they are first needed: neither before, nor in a different way."""

from __future__ import annotations

import shutil

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLabel,
    QTabBar,
    QWidget,
)

from inspector.session.settings import Settings
from inspector.widgets.canvas import Canvas
from inspector.widgets.late_panel import LatePanel
from inspector.widgets.theme import DARK, LIGHT
from tests.conftest import ASSETS
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, close_window, open_clip
from tests.tiers import parametrize

LATE = ("tuning", "teaching", "quality")


def areas(window):
    return {area.parent().objectName(): area for area in window.findChildren(LatePanel)}


def built(window):
    return {name for name, area in areas(window).items() if area.built}


def looks(panel):
    """What a person can see or hear of a panel."""
    parts = [panel, *panel.findChildren(QWidget)]
    plots = [p.backgroundBrush().color().name() for p in parts if isinstance(p, Canvas)]
    texts = [p.text() for p in parts if isinstance(p, QLabel | QAbstractButton)]
    tabs = [p.tabText(k) for p in parts if isinstance(p, QTabBar) for k in range(p.count())]
    names = [(p.accessibleName(), p.accessibleDescription(), p.toolTip()) for p in parts]
    return plots, texts, tabs, names, [(p.styleSheet(), p.isEnabled()) for p in parts]


def test_neither_a_start_nor_a_clip_builds_them_and_each_is_built_when_it_is_seen(
    qtbot, show_window, tmp_path
):
    window = show_window(Settings(turn_ms=0))
    assert set(areas(window)) == set(LATE)
    assert built(window) == set()
    open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path))
    act(window, "next_interval")
    act(window, "accept")
    act(window, "undo")
    assert built(window) == set()
    for k, name in enumerate(LATE, start=1):
        act(window, f"show_{name}")
        qtbot.waitUntil(lambda k=k: built(window) == set(LATE[:k]))
        assert window.docks[name].widget().widget() is getattr(window, name)
        assert not getattr(window, name).visibleRegion().isEmpty()


def test_a_panel_that_is_used_before_it_is_seen_is_built_in_its_place(show_window):
    window = show_window(Settings(turn_ms=0))
    panel = window.quality
    assert built(window) == {"quality"}
    assert panel is window.quality is window.docks["quality"].widget().widget()
    assert panel.window() is window


def test_fields_of_a_panel_that_is_built_late_follow_the_keys_of_the_review(show_window):
    window = show_window(Settings(turn_ms=0))
    for name in LATE:
        panel = getattr(window, name)
        boxes = [*panel.findChildren(QAbstractSpinBox), *panel.findChildren(QComboBox)]
        assert all(box.focusPolicy() != Qt.FocusPolicy.WheelFocus for box in boxes)
    window.tuning.box.setFocus()
    undo = QKeyEvent(
        QEvent.Type.ShortcutOverride, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier
    )
    QApplication.sendEvent(window.tuning.box, undo)
    assert not undo.isAccepted()  # it is a shortcut of the review, not of the field


def test_a_tab_that_was_in_front_is_built_at_the_next_start(qtbot, show_window):
    before = show_window(Settings(turn_ms=0))
    act(before, "show_quality")
    geometry, layout = before.usual_layout.kept("")
    close_window(qtbot, before)
    window = show_window(Settings(turn_ms=0, geometry=geometry, layout=layout))
    assert built(window) == {"quality"}
    assert not window.quality.visibleRegion().isEmpty()


@parametrize("name", LATE)
def test_a_panel_built_late_is_the_same_as_one_that_was_there_from_the_start(
    qtbot, show_window, tmp_path, name
):
    shown = []
    for early in (True, False):
        window = show_window(Settings(turn_ms=0, theme="light"))
        if early:
            areas(window)[name].build()
        open_clip(qtbot, window, shutil.copy(INJECTED, tmp_path / f"{early}.bvh"))
        window.document.select_chain("LeftForeArm")
        window.document.go_to(90)
        window.program.choose_theme("dark")
        assert (name in built(window)) == early
        act(window, f"show_{name}")
        panel = getattr(window, name)
        if name == "teaching":
            qtbot.waitUntil(lambda panel=panel: panel.typesetter.done, timeout=30_000)
        elif name == "quality":
            qtbot.waitUntil(lambda panel=panel: panel.evidence.known is not None)
            gains = panel.page.gains  # described for screen readers after a pause
            qtbot.waitUntil(lambda gains=gains: gains.accessibleDescription() != "")
        else:
            panel.costs.watch(False)  # the same state of the measurement in both
        qtbot.wait(50)
        actions = {a: (b.isEnabled(), b.text()) for a, b in window.actions_by_id.items()}
        shown.append((looks(panel), actions, window.docks[name].minimumSizeHint()))
        assert DARK.surface in shown[-1][0][0] or name == "teaching"
        assert LIGHT.surface not in str(shown[-1][0])
        close_window(qtbot, window)
    for late, early in zip(shown[1][0], shown[0][0], strict=True):
        assert late == early
    assert shown[1][1:] == shown[0][1:]


def test_actions_of_tracking_follow_the_clip_without_the_panel(qtbot, show_window, tmp_path):
    window = show_window(Settings(turn_ms=0))
    names = "track_joints", "cancel_tracking", "stop_tracking"

    def enabled():
        return tuple(window.actions_by_id[name].isEnabled() for name in names)

    assert enabled() == (False, False, False)
    open_clip(qtbot, window, shutil.copy(ASSETS / "walk.bvh", tmp_path))
    assert enabled() == (True, False, False)
    assert built(window) == set()
    act(window, "track_joints")
    qtbot.waitUntil(lambda: enabled() == (True, False, True))
    window.document.undo()
    qtbot.waitUntil(lambda: enabled() == (True, False, False))


def test_a_presentation_scales_the_panel_that_it_may_show(show_window):
    window = show_window(Settings(turn_ms=0))
    act(window, "presentation")
    scaled = window.teaching.listed.styleSheet()
    act(window, "presentation")
    assert window.teaching.listed.styleSheet() != scaled
