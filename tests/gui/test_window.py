"""The whole window with mouse and keys: judge, drag, undo, look."""

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDockWidget

from inspector.panels.history_panel import HistoryPanel
from inspector.panels.position_line import FrameLine
from inspector.session.export_files import ExportChoice
from inspector.session.open_clip import Show
from inspector.session.settings import Settings, load_settings
from inspector.viewport.solid_and_ghost import Style
from inspector.window.action_table import MENUS
from inspector.window.keyboard_page import KeyboardPage, shortcuts_markdown
from inspector.window.palette import CommandPalette
from inspector.window.preferences import Preferences
from tests.gui.pictures import INJECTED
from tests.gui.windows import (
    act,
    close_window,
    decisions,
    export,
    open_clip,
    press,
    wait_until_active,
)
from twistcore.cli import main as twistcore
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision

ONE_WINDOW = True


def test_opening_fills_every_view(opened):
    assert opened.windowTitle().startswith("walk_injected.bvh")
    assert opened.chains.table.model().rowCount() == 14  # ten chains, four limbs
    assert opened.intervals.table.model().rowCount() == 8
    assert opened.signs.decided.text() == "0 of 8 decided"
    assert opened.transport.slider.maximum() == 343


def test_a_review_by_keyboard_then_export_equals_apply(qtbot, opened, tmp_path, capsys):
    press(qtbot, opened, Qt.Key.Key_N)
    first = opened.document.interval
    assert opened.document.frame == first.interval.start
    for key in (Qt.Key.Key_A, Qt.Key.Key_R, Qt.Key.Key_A):
        press(qtbot, opened, key)
    assert decisions(opened)[:3] == [Decision.ACCEPTED, Decision.REJECTED, Decision.ACCEPTED]
    assert opened.document.interval is opened.document.intervals[3]
    press(qtbot, opened, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier)
    assert decisions(opened)[2] == Decision.UNDECIDED
    press(qtbot, opened, Qt.Key.Key_Y, Qt.KeyboardModifier.ControlModifier)
    assert decisions(opened)[2] == Decision.ACCEPTED
    # Edit an edge at the playhead: '[' then export.
    press(qtbot, opened, Qt.Key.Key_N, Qt.KeyboardModifier.ShiftModifier)
    press(qtbot, opened, Qt.Key.Key_Right)
    press(qtbot, opened, Qt.Key.Key_BracketLeft)
    edited = opened.document.interval
    assert edited.edited
    assert edited.interval.start == opened.document.frame
    out = tmp_path / "out.bvh"
    export(opened, ExportChoice(out))
    assert opened.bar.label.text()
    replayed = tmp_path / "replayed.bvh"
    session = tmp_path / "out.replay.json"
    assert twistcore(["apply", str(session), str(INJECTED), "-o", str(replayed)]) == 0
    capsys.readouterr()
    assert replayed.read_bytes() == out.read_bytes()
    changed = read_bvh(out).values != read_bvh(INJECTED).values
    chosen = [j.interval for j in opened.document.intervals if j.decision == Decision.ACCEPTED]
    frames = {t for i in chosen for t in range(i.start, i.stop)}
    assert set(np.flatnonzero(changed.any(axis=1))) <= frames
    assert changed.any()
    assert (tmp_path / "out.report.html").exists()


def test_buttons_of_the_detail_card_judge(qtbot, opened):
    act(opened, "next_interval")
    qtbot.mouseClick(opened.detail.buttons[Decision.ACCEPTED], Qt.MouseButton.LeftButton)
    assert decisions(opened)[0] == Decision.ACCEPTED
    opened.document.select_interval(opened.document.intervals[0].id)
    qtbot.mouseClick(opened.detail.buttons[Decision.UNDECIDED], Qt.MouseButton.LeftButton)
    assert decisions(opened)[0] == Decision.UNDECIDED


def test_exact_numbers_edit_the_interval_and_undo(opened):
    act(opened, "next_interval")
    judged = opened.document.interval
    opened.detail.stop.setValue(judged.interval.stop + 3)
    opened.detail.delta.setValue(45.0)
    now = opened.document.interval.interval
    assert now.stop == judged.interval.stop + 3
    assert np.degrees(now.delta) == pytest.approx(45.0)
    act(opened, "undo")
    act(opened, "undo")
    assert opened.document.interval.interval.stop == judged.interval.stop
    assert opened.detail.stop.value() == judged.interval.stop


@pytest.mark.thorough
def test_several_selected_are_judged_in_one_step(qtbot, opened):
    table = opened.intervals.table
    table.selectAll()
    assert len(opened.intervals.selected_ids()) == 8
    act(opened, "accept")
    assert set(decisions(opened)) == {Decision.ACCEPTED}
    act(opened, "undo")
    assert set(decisions(opened)) == {Decision.UNDECIDED}


@pytest.mark.thorough
def test_the_filter_lists_what_is_left(opened):
    act(opened, "next_interval")
    act(opened, "accept")
    opened.intervals.filter.setCurrentText("Undecided")
    assert opened.intervals.table.model().rowCount() == 7
    opened.intervals.filter.setCurrentText("Accepted")
    assert opened.intervals.table.model().rowCount() == 1


@pytest.mark.thorough
def test_what_is_selected_is_listed_whatever_the_filter(qtbot, opened):
    panel, document = opened.intervals, opened.document
    panel.filter.setCurrentText("Accepted")
    document.go_to(200)
    press(qtbot, opened, Qt.Key.Key_Insert)
    number = document.interval_id
    assert panel.shown_ids() == panel.selected_ids() == (number,)
    act(opened, "accept")
    panel.filter.setCurrentText("Undecided")
    assert document.interval is None
    document.select_interval(number)
    assert len(panel.shown_ids()) == 9
    table = panel.table
    row = next(k for k, other in enumerate(panel.shown_ids()) if other != number)
    centre = table.visualRect(table.model().index(row, 0)).center()
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=centre)
    qtbot.waitUntil(lambda: number not in panel.shown_ids())
    assert panel.selected_ids() == (document.interval_id,)
    act(opened, "tour")
    qtbot.waitUntil(lambda: panel.filter.currentText() == "All", timeout=20_000)
    opened.lesson_actions.leave_guide()
    assert panel.filter.currentText() == "Undecided"


@pytest.mark.thorough
def test_a_chain_row_selects_the_chain(qtbot, opened):
    table = opened.chains.table
    centre = table.visualRect(table.model().index(8, 0)).center()
    qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=centre)
    assert opened.document.chain == opened.document.data.chains[8].name


def test_hand_made_intervals_come_and_go(qtbot, opened):
    opened.document.go_to(200)
    press(qtbot, opened, Qt.Key.Key_Insert)
    assert len(opened.document.intervals) == 9
    assert opened.document.interval.by_hand
    assert opened.document.interval.interval.start <= 200 < opened.document.interval.interval.stop
    press(qtbot, opened, Qt.Key.Key_Delete)
    assert len(opened.document.intervals) == 8
    act(opened, "next_interval")
    press(qtbot, opened, Qt.Key.Key_Delete)
    assert len(opened.document.intervals) == 8
    assert "hand-made" in opened.bar.label.text()


class Clock:
    """The player's, as fast as a test wants."""

    ms = 0

    def start(self):
        self.ms = 0

    def elapsed(self):
        return self.ms


@pytest.mark.thorough
def test_playing_keeps_real_time_and_pauses(qtbot, opened, monkeypatch):
    clock = Clock()
    monkeypatch.setattr(opened.player, "_clock", clock)
    press(qtbot, opened, Qt.Key.Key_Space)
    for clock.ms, frame in ((100, 12), (400, 48)):  # at 120 Hz: frames are dropped, not the time
        qtbot.waitUntil(lambda frame=frame: opened.document.frame == frame)
    press(qtbot, opened, Qt.Key.Key_Space)
    assert not opened.player.playing
    frame = opened.document.frame
    press(qtbot, opened, Qt.Key.Key_Right)
    assert opened.document.frame == frame + 1
    press(qtbot, opened, Qt.Key.Key_Left, Qt.KeyboardModifier.ControlModifier)
    assert opened.document.frame == frame - 9
    press(qtbot, opened, Qt.Key.Key_End)
    assert opened.document.frame == 343


@pytest.mark.thorough
def test_before_after_both(qtbot, opened):
    seen = []
    for _ in range(3):
        press(qtbot, opened, Qt.Key.Key_B)
        seen.append(opened.document.show)
    assert seen == [Show.BEFORE, Show.AFTER, Show.BOTH]


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["light", "dark"])
def test_the_window_draws_in_both_themes(qtbot, opened, name):
    opened.actions_by_id[f"theme_{name}"].trigger()
    act(opened, "next_interval")
    qtbot.wait(200)
    image = opened.grab().toImage()
    centre = opened.viewport.mapTo(opened, QPoint(0, 0))
    colours = {
        image.pixelColor(centre.x() + x, centre.y() + y).rgb()
        for x in range(10, opened.viewport.width() - 10, 7)
        for y in range(40, opened.viewport.height() - 10, 7)
    }
    assert len(colours) > 50  # the 3D view is no blank rectangle
    lightness = image.pixelColor(5, opened.height() - 5).lightness()
    assert (lightness > 128) == (name == "light")


@pytest.mark.thorough
@pytest.mark.usefixtures("new_window")
def test_a_note_stays_with_the_interval_it_was_typed_for(qtbot, opened):
    act(opened, "next_interval")
    first = opened.document.interval_id
    opened.detail.note.setFocus()
    qtbot.keyClicks(opened.detail.note, "bad strap")
    act(opened, "reject")
    assert opened.document.interval_id != first
    judged = opened.document.review.state.find(first)
    assert (judged.decision, judged.note) == (Decision.REJECTED, "bad strap")
    assert all(not j.note for j in opened.document.intervals if j.id != first)


def test_a_key_before_the_picture_decides_nothing(qtbot, opened):
    press(qtbot, opened, Qt.Key.Key_N)
    qtbot.waitUntil(opened.viewport.has_painted_interval)
    for _ in range(3):
        QTest.keyClick(opened, Qt.Key.Key_A)
        QTest.keyClick(opened, Qt.Key.Key_R)
    assert [d for d in decisions(opened) if d != Decision.UNDECIDED] == [Decision.ACCEPTED]
    qtbot.waitUntil(opened.viewport.has_painted_interval)
    QTest.keyClick(opened, Qt.Key.Key_R)
    assert decisions(opened)[:2] == [Decision.ACCEPTED, Decision.REJECTED]


def test_undo_and_redo_say_and_show_what_they_change(qtbot, opened):
    press(qtbot, opened, Qt.Key.Key_N)
    first = opened.document.interval_id
    for _ in range(3):
        press(qtbot, opened, Qt.Key.Key_A)
    for name, word in (("undo", "Undone"), ("undo", "Undone"), ("undo", "Undone")):
        act(opened, name)
        assert opened.statusBar().currentMessage().startswith(word)
    assert opened.document.interval_id == first
    assert opened.document.frame == opened.document.interval.interval.seen_at
    act(opened, "next_interval")
    act(opened, "redo")
    assert opened.document.interval_id == first
    assert opened.statusBar().currentMessage().startswith("Redone")


@pytest.mark.thorough
def test_looks_are_remembered(qtbot, show_window, tmp_path):
    file = tmp_path / "looks.json"
    first = show_window(Settings(turn_ms=0), file)
    assert first.actions_by_id["skin"].isChecked()
    open_clip(qtbot, first, INJECTED)
    act(first, "skin")
    close_window(qtbot, first)
    again = show_window(load_settings(file)[0], file)
    assert not again.actions_by_id["skin"].isChecked()
    assert again.actions_by_id["side_by_side"].isChecked()
    looks = again.viewport.drawing.looks
    assert (looks.style, looks.split) == (Style.WEDGES, True)


@pytest.mark.thorough
def test_letters_are_keys_while_a_spin_box_has_the_focus(qtbot, opened):
    act(opened, "next_interval")
    qtbot.waitUntil(opened.viewport.has_painted_interval)
    opened.detail.start.setFocus()
    qtbot.keyClick(opened.detail.start, Qt.Key.Key_A)
    assert decisions(opened)[0] == Decision.ACCEPTED


@pytest.mark.thorough
def test_going_on_follows_what_is_listed(qtbot, opened):
    opened.intervals.filter.setCurrentText("Undecided")
    act(opened, "next_interval")
    for k in range(3):
        assert opened.document.interval is opened.document.intervals[k]
        act(opened, "accept")
    opened.intervals.filter.setCurrentText("Accepted")
    assert opened.document.interval is None
    act(opened, "reject")
    assert decisions(opened)[:3] == [Decision.ACCEPTED] * 3


@pytest.mark.thorough
def test_edges_at_the_playhead_never_turn_an_interval_over(opened):
    act(opened, "next_interval")
    before = opened.document.interval.interval
    opened.document.go_to(0)
    act(opened, "stop_here")
    opened.document.go_to(343)
    act(opened, "start_here")
    assert opened.document.interval.interval is before
    assert opened.bar.label.text()
    assert opened.document.review.undo_text == ""


def test_keys_can_be_changed_and_conflicts_are_told(qtbot, opened):
    act(opened, "preferences")
    dialog = opened.findChild(Preferences)
    dialog.edits["accept"].setKeySequence(QKeySequence("R"))
    assert "assigned twice" in dialog.conflict.text()
    dialog.edits["accept"].setKeySequence(QKeySequence("X"))
    dialog.first.setCurrentIndex(1)
    dialog.reviewer.setText("Ada")
    dialog.accept()
    act(opened, "next_interval")
    assert opened.detail.start.value() == opened.document.interval.interval.start + 1
    press(qtbot, opened, Qt.Key.Key_X)
    assert decisions(opened)[0] == Decision.ACCEPTED
    assert opened.document.intervals[0].reviewer == "Ada"
    assert opened.settings.keys == {"accept": ["X"]}


@pytest.mark.thorough
def test_the_palette_does_what_is_typed(qtbot, opened):
    act(opened, "command_palette")
    palette = opened.findChild(CommandPalette)
    qtbot.keyClicks(palette.line, "next interval")
    qtbot.keyClick(palette.line, Qt.Key.Key_Return)
    assert opened.document.interval is opened.document.intervals[0]


@pytest.mark.thorough
def test_the_sure_ones_are_accepted_in_one_step(opened):
    opened.review_actions.accept_at_least(0.5)
    assert Decision.ACCEPTED in decisions(opened)
    act(opened, "undo")
    assert set(decisions(opened)) == {Decision.UNDECIDED}
    opened.review_actions.accept_at_least(1.1)
    assert opened.bar.label.text()


def test_another_detector_keeps_what_is_decided_and_undo_brings_its_curve_back(qtbot, opened):
    act(opened, "next_interval")
    act(opened, "accept")
    act(opened, "use_paper")
    qtbot.waitUntil(lambda: opened.document.method == "paper")
    assert decisions(opened)[0] == Decision.ACCEPTED
    act(opened, "undo")
    assert opened.document.method == "consistency"  # at once: its analysis was kept
    assert opened.actions_by_id["use_consistency"].isChecked()


def test_the_history_goes_back_and_forth(qtbot, opened):
    history = opened.findChild(HistoryPanel)
    act(opened, "next_interval")
    act(opened, "accept")
    act(opened, "reject")
    first, second = (j.interval for j in opened.document.intervals[:2])
    assert [history.list.item(k).text() for k in range(3)] == [
        "As opened",
        f"Accept interval · Left ForeArm {first.start}–{first.stop}",
        f"Reject interval · Left ForeArm {second.start}–{second.stop}",
    ]
    opened.document.set_first_frame(1)
    assert history.list.item(1).text().endswith(f" {first.start + 1}–{first.stop + 1}")
    history.list.itemClicked.emit(history.list.item(0))
    assert set(decisions(opened)) == {Decision.UNDECIDED}
    history.list.itemClicked.emit(history.list.item(2))
    assert decisions(opened)[:2] == [Decision.ACCEPTED, Decision.REJECTED]


def test_the_page_of_keys_is_the_table_of_actions():
    page = Path(__file__).parents[2] / "docs" / "shortcuts.md"
    assert page.read_text(encoding="utf-8") == shortcuts_markdown(MENUS)


@pytest.mark.thorough
def test_escape_closes_the_page_of_keys(qtbot, opened):
    def pages():
        return opened.findChildren(KeyboardPage)

    act(opened, "show_shortcuts")
    assert QTest.qWaitForWindowActive(pages()[0], 60_000)
    qtbot.keyClick(pages()[0], Qt.Key.Key_Escape)
    assert not any(page.isVisible() for page in pages())


@pytest.mark.thorough
def test_a_chain_without_its_tick_is_left_out_of_table_and_strip(qtbot, opened):
    model = opened.chains.table.model()
    row = next(k for k, c in enumerate(opened.document.data.chains) if c.name == "RightUpLeg")
    role = Qt.ItemDataRole.CheckStateRole
    model.setData(model.index(row, 0), Qt.CheckState.Unchecked.value, role)
    assert opened.intervals.table.model().rowCount() == 3
    act(opened, "next_interval")
    for _ in range(4):
        assert opened.document.interval.interval.chain == "LeftForeArm"
        act(opened, "next_interval")
    model.setData(model.index(row, 0), Qt.CheckState.Checked.value, role)
    assert opened.intervals.table.model().rowCount() == 8


@pytest.mark.thorough
def test_esc_closes_a_message_unless_something_else_needs_it(qtbot, window):
    """In a window of its own: one that was hidden may not get the keyboard again."""
    open_clip(qtbot, window, INJECTED)

    def said():
        return window.bar.label.text() if window.bar.isVisible() else ""

    def escape(widget):
        qtbot.keyClick(widget, Qt.Key.Key_Escape)
        return said()

    for focus in (window.viewport.view, window.intervals.table, window):
        focus.setFocus()
        window.bar.show_message("Something was done.", False)
        window.bar.show_message("Something went wrong.", True)
        assert escape(focus) == ""
    window.bar.ask("Which one?", [("This", bool), ("That", bool)])
    window.bar.show_message("Something went wrong.", True)
    assert escape(window) == "Which one?"
    assert escape(window) == ""
    window.bar.show_message("Something went wrong.", True)
    act(window, "next_interval")
    wait_until_active(window)
    window.detail.focus_field("note")
    qtbot.waitUntil(window.detail.note.hasFocus)
    assert escape(window.detail.note) == "Something went wrong."
    act(window, "presentation")
    window.bar.show_message("Something went wrong.", True)
    assert escape(window) == "Something went wrong."
    assert not window.actions_by_id["presentation"].isChecked()
    assert escape(window) == ""


def test_a_message_covers_no_feet(qtbot, opened):
    opened.bar.show_message("Something was done.", False)
    bar, view = opened.bar, opened.viewport
    assert bar.parent() is view
    assert 0 < bar.geometry().top() < bar.geometry().bottom() < 0.5 * view.height()
    opened.bar.show_message("A longer text. " * 30, False)
    qtbot.waitUntil(lambda: bar.height() > 3 * bar.fontMetrics().height())
    assert 0 < bar.geometry().top() < bar.geometry().bottom() < 0.5 * view.height()


def test_a_presentation_leaves_figure_and_curves_and_gives_the_window_back(qtbot, opened):
    docks = {d.objectName(): d for d in opened.findChildren(QDockWidget)}
    before = {name: dock.isVisible() for name, dock in docks.items()}
    type_before = opened.timeline.readout.font().pointSizeF()
    opened.statusBar().clearMessage()
    act(opened, "presentation")
    qtbot.wait(50)
    assert [name for name, dock in docks.items() if dock.isVisible()] == ["curves"]
    assert opened.timeline.readout.font().pointSizeF() > 1.5 * type_before
    act(opened, "next_interval")  # keys work on
    assert opened.document.interval is not None
    opened.statusBar().showMessage("Something was done.")
    qtbot.keyClick(opened, Qt.Key.Key_Escape)
    qtbot.wait(50)
    assert not opened.actions_by_id["presentation"].isChecked()
    assert {name: dock.isVisible() for name, dock in docks.items()} == before
    assert opened.timeline.readout.font().pointSizeF() == type_before
    assert opened.statusBar().isVisible()
    (line,) = opened.statusBar().findChildren(FrameLine)
    assert line.isVisible() == (not opened.statusBar().currentMessage())
