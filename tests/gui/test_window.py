"""The whole window with mouse and keys: open, judge, drag, undo, export, and what may go wrong."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDropEvent
from PySide6.QtWidgets import QApplication, QDockWidget

from inspector.actions import shortcuts_markdown
from inspector.document import Show
from inspector.export import ExportChoice, ExportDialog
from inspector.main_window import MainWindow
from inspector.palette import CommandPalette
from inspector.panels import HistoryPanel
from inspector.preferences import Preferences
from inspector.settings import Settings, load_settings, save_settings
from tests.conftest import ASSETS
from twistcore.bvh import read_bvh
from twistcore.cli import main as twistcore
from twistcore.review import Decision

DIRTY = ASSETS / "walk_injected.bvh"


@pytest.fixture
def window(qtbot, tmp_path):
    window = MainWindow(Settings(theme="light", turn_ms=0), tmp_path / "settings" / "settings.json")
    window.show()
    qtbot.waitExposed(window)
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    yield window
    if window.document.data is not None:
        window.document.review.mark_saved()
    window.close()
    window.deleteLater()
    qtbot.wait(20)


def open_clip(qtbot, window, path):
    with qtbot.waitSignal(window.document.opened, timeout=10_000):
        window.open_path(path)
    qtbot.wait(50)


@pytest.fixture
def opened(qtbot, window):
    open_clip(qtbot, window, DIRTY)
    return window


def export(window, choice):
    window.export(choice)
    window.exporter.finish()


def press(qtbot, window, key, modifier=Qt.KeyboardModifier.NoModifier):
    qtbot.keyClick(window, key, modifier)
    qtbot.wait(5)


def decisions(window):
    return [j.decision for j in window.document.intervals]


def test_opening_fills_every_view(opened):
    assert opened.windowTitle().startswith("walk_injected.bvh")
    assert opened.chains.table.model().rowCount() == 10
    assert opened.intervals.table.model().rowCount() == 8
    assert opened.decided.text() == "0 of 8 decided"
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
    assert "joint moved" in opened.bar.label.text()
    replayed = tmp_path / "replayed.bvh"
    session = tmp_path / "out.twist.json"
    assert twistcore(["apply", str(session), str(DIRTY), "-o", str(replayed)]) == 0
    capsys.readouterr()
    assert replayed.read_bytes() == out.read_bytes()
    changed = read_bvh(out).values != read_bvh(DIRTY).values
    chosen = [j.interval for j in opened.document.intervals if j.decision == Decision.ACCEPTED]
    frames = {t for i in chosen for t in range(i.start, i.stop)}
    assert set(np.flatnonzero(changed.any(axis=1))) <= frames
    assert changed.any()
    assert (tmp_path / "walk_injected.report.html").exists()


def test_nothing_accepted_exports_the_same_bytes(opened, tmp_path):
    export(opened, ExportChoice(tmp_path / "same.bvh", session=False, report=False))
    assert (tmp_path / "same.bvh").read_bytes() == DIRTY.read_bytes()
    assert [p.name for p in tmp_path.iterdir() if p.suffix == ".bvh"] == ["same.bvh"]


def test_buttons_of_the_detail_card_judge(qtbot, opened):
    opened.next_interval()
    qtbot.mouseClick(opened.detail.buttons[Decision.ACCEPTED], Qt.MouseButton.LeftButton)
    assert decisions(opened)[0] == Decision.ACCEPTED
    opened.document.select_interval(opened.document.intervals[0].id)
    qtbot.mouseClick(opened.detail.buttons[Decision.UNDECIDED], Qt.MouseButton.LeftButton)
    assert decisions(opened)[0] == Decision.UNDECIDED


def test_exact_numbers_edit_the_interval_and_undo(opened):
    opened.next_interval()
    judged = opened.document.interval
    opened.detail.stop.setValue(judged.interval.stop + 3)
    opened.detail.delta.setValue(45.0)
    now = opened.document.interval.interval
    assert now.stop == judged.interval.stop + 3
    assert np.degrees(now.delta) == pytest.approx(45.0)
    opened.undo()
    opened.undo()
    assert opened.document.interval.interval.stop == judged.interval.stop
    assert opened.detail.stop.value() == judged.interval.stop


def test_several_selected_are_judged_in_one_step(qtbot, opened):
    table = opened.intervals.table
    table.selectAll()
    assert len(opened.intervals.selected_ids()) == 8
    opened.accept()
    assert set(decisions(opened)) == {Decision.ACCEPTED}
    opened.undo()
    assert set(decisions(opened)) == {Decision.UNDECIDED}


def test_the_filter_lists_what_is_left(opened):
    opened.next_interval()
    opened.accept()
    opened.intervals.filter.setCurrentText("Undecided")
    assert opened.intervals.table.model().rowCount() == 7
    opened.intervals.filter.setCurrentText("Accepted")
    assert opened.intervals.table.model().rowCount() == 1


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
    opened.next_interval()
    press(qtbot, opened, Qt.Key.Key_Delete)
    assert len(opened.document.intervals) == 8
    assert "hand-made" in opened.bar.label.text()


def test_playing_keeps_real_time_and_pauses(qtbot, opened):
    press(qtbot, opened, Qt.Key.Key_Space)
    qtbot.wait(400)
    press(qtbot, opened, Qt.Key.Key_Space)
    # 0.4 s at 120 Hz is 48 frames; a slow machine drops frames but keeps the time.
    assert 24 <= opened.document.frame <= 120
    assert not opened.player.playing
    frame = opened.document.frame
    press(qtbot, opened, Qt.Key.Key_Right)
    assert opened.document.frame == frame + 1
    press(qtbot, opened, Qt.Key.Key_Left, Qt.KeyboardModifier.ControlModifier)
    assert opened.document.frame == frame - 9
    press(qtbot, opened, Qt.Key.Key_End)
    assert opened.document.frame == 343


def test_before_after_both(qtbot, opened):
    seen = []
    for _ in range(3):
        press(qtbot, opened, Qt.Key.Key_B)
        seen.append(opened.document.show)
    assert seen == [Show.BEFORE, Show.AFTER, Show.BOTH]


def test_a_file_is_opened_by_dropping_it(qtbot, window):
    mime = QMimeData()
    mime.setUrls([QUrl.fromLocalFile(str(ASSETS / "dance.bvh"))])
    actions, button = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    plain = Qt.KeyboardModifier.NoModifier
    enter = QDragEnterEvent(QPoint(50, 50), actions, mime, button, plain)
    QApplication.sendEvent(window, enter)
    assert enter.isAccepted()
    with qtbot.waitSignal(window.document.opened, timeout=10_000):
        drop = QDropEvent(QPointF(50, 50), actions, mime, button, plain)
        QApplication.sendEvent(window, drop)
    assert window.document.data.clip.name == "dance.bvh"


BAD = {
    "empty.bvh": b"",
    "picture.bvh": b"\x89PNG\r\n\x1a\n0000",
    "cut.bvh": DIRTY.read_bytes()[:1500],
    "damaged.twist.json": b'{"schema": "twistcore.session/1"',
    "other.json": b"[]",
}


@pytest.mark.parametrize("name", [*BAD, "missing.bvh"])
def test_what_cannot_be_opened_is_one_sentence_and_the_clip_stays(qtbot, opened, tmp_path, name):
    path = tmp_path / "in" / name
    path.parent.mkdir()
    if name in BAD:
        path.write_bytes(BAD[name])
    with qtbot.waitSignal(opened.document.message, timeout=10_000) as told:
        opened.open_path(path)
    assert told.args[1] is True
    assert name in told.args[0]
    assert "\n" not in told.args[0]
    assert opened.bar.isVisible()
    assert opened.document.data.clip.name == "walk_injected.bvh"
    assert [p.name for p in path.parent.iterdir()] == ([name] if name in BAD else [])


def test_a_cut_motion_opens_with_a_note(qtbot, window, tmp_path):
    path = tmp_path / "cut.bvh"
    path.write_bytes(DIRTY.read_bytes()[:100_000])
    open_clip(qtbot, window, path)
    assert 0 < window.document.frames < 344
    assert "344" in window.bar.label.text() or "incomplete" in window.bar.label.text()


STICK = b"""HIERARCHY
ROOT a
{
OFFSET 0 0 0
CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
JOINT b
{
OFFSET 0 1 0
CHANNELS 1 Zrotation
End Site
{
OFFSET 0 1 0
}
}
}
MOTION
Frames: 3
Frame Time: 0.01
0 0 0 0 0 0 0
0 0 0 1 2 3 9
0 0 0 1 2 3 9
"""


def test_a_skeleton_without_a_chain_opens_and_says_so(qtbot, window, tmp_path):
    path = tmp_path / "stick.bvh"
    path.write_bytes(STICK)
    open_clip(qtbot, window, path)
    assert "no chain" in window.bar.label.text()
    for action in window.actions_by_id.values():
        if action.objectName() in ("next_interval", "accept", "focus_chain", "insert_interval",
                                   "start_here", "zoom_to_interval", "toggle_play"):  # fmt: skip
            action.trigger()
    qtbot.wait(50)
    window.player.pause()
    export(window, ExportChoice(tmp_path / "out.bvh"))
    assert (tmp_path / "out.bvh").read_bytes() == STICK


def test_a_joint_without_three_rotations_is_shown_but_not_written(qtbot, window, tmp_path):
    text = DIRTY.read_bytes()
    head, _, rows = text.partition(b"MOTION")
    # Take two of LeftHand's three rotation channels away, in the header and in every row.
    at = head.index(b"CHANNELS 3", head.index(b"JOINT LeftHand\r\n"))
    head = head[:at] + head[at:].replace(
        b"CHANNELS 3 Zrotation Yrotation Xrotation", b"CHANNELS 1 Zrotation", 1
    )
    clip = read_bvh(DIRTY)
    column = clip.channels[clip.motion.skeleton.index("LeftHand")].rotation
    lines = rows.splitlines()
    body = [b" ".join(t for k, t in enumerate(r.split()) if k not in column[1:]) for r in lines[3:]]
    path = tmp_path / "one.bvh"
    path.write_bytes(head + b"MOTION\n" + b"\n".join([*lines[1:3], *body]) + b"\n")
    open_clip(qtbot, window, path)
    window.intervals.table.selectAll()
    window.accept()
    export(window, ExportChoice(tmp_path / "out.bvh"))
    before, after = read_bvh(path), read_bvh(tmp_path / "out.bvh")
    changed = (before.values != after.values).any(axis=0)
    hand = before.channels[before.motion.skeleton.index("LeftHand")].rotation
    forearm = before.channels[before.motion.skeleton.index("LeftForeArm")].rotation
    assert not changed[list(hand + forearm)].any()
    assert changed.any()


def test_the_source_is_never_overwritten(qtbot, window, tmp_path):
    path = tmp_path / "walk.bvh"
    shutil.copy(DIRTY, path)
    open_clip(qtbot, window, path)
    export(window, ExportChoice(path))
    assert "never overwritten" in window.bar.label.text()
    assert path.read_bytes() == DIRTY.read_bytes()


def test_an_export_into_nowhere_is_told(opened, tmp_path):
    export(opened, ExportChoice(tmp_path / "no" / "where.bvh"))
    assert opened.bar.isVisible()
    assert "not written" in opened.bar.label.text()


def test_the_export_dialog_says_what_will_happen(qtbot, opened, tmp_path):
    opened.next_interval()
    opened.accept()
    opened.export_dialog()
    dialog = opened.findChild(ExportDialog)
    qtbot.waitExposed(dialog)
    dialog.path.setText(str(tmp_path / "by_dialog.bvh"))
    assert dialog.undecided.text().startswith("Correct the 7 undecided")
    dialog.accept()
    assert opened.exporter.finish()
    assert (tmp_path / "by_dialog.bvh").exists()


def test_a_session_is_saved_and_opened_again(qtbot, window, tmp_path):
    path = tmp_path / "walk.bvh"
    shutil.copy(DIRTY, path)
    open_clip(qtbot, window, path)
    window.next_interval()
    window.accept()
    assert window.isWindowModified()
    press(qtbot, window, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    assert not window.isWindowModified()
    session = tmp_path / "walk.twist.json"
    assert json.loads(session.read_text())["intervals"][0]["decision"] == "accepted"
    open_clip(qtbot, window, DIRTY)
    open_clip(qtbot, window, session)
    assert decisions(window)[0] == Decision.ACCEPTED
    assert window.document.data.clip.path == path


@pytest.mark.parametrize("name", ["light", "dark"])
def test_the_window_draws_in_both_themes(qtbot, opened, name):
    opened.actions_by_id[f"theme_{name}"].trigger()
    opened.next_interval()
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


def test_settings_are_kept_and_damage_is_set_aside(tmp_path):
    path = tmp_path / "deep" / "settings.json"
    settings = Settings(theme="dark", reviewer="Ada")
    settings.remember(DIRTY)
    assert save_settings(path, settings) == ""
    assert load_settings(path) == (settings, "")
    path.write_bytes(b'{"recent": [1, 2')
    again, complaint = load_settings(path)
    assert again == Settings()
    assert "set aside" in complaint
    assert (tmp_path / "deep" / "settings.json.damaged").exists()


def test_a_note_stays_with_the_interval_it_was_typed_for(qtbot, opened):
    opened.next_interval()
    first = opened.document.interval_id
    opened.detail.note.setFocus()
    qtbot.keyClicks(opened.detail.note, "bad strap")
    opened.actions_by_id["reject"].trigger()
    assert opened.document.interval_id != first
    judged = opened.document.review.state.find(first)
    assert (judged.decision, judged.note) == (Decision.REJECTED, "bad strap")
    assert all(not j.note for j in opened.document.intervals if j.id != first)


def test_a_note_still_being_typed_is_saved(qtbot, window, tmp_path):
    path = tmp_path / "walk.bvh"
    shutil.copy(DIRTY, path)
    open_clip(qtbot, window, path)
    window.next_interval()
    window.detail.note.setFocus()
    qtbot.keyClicks(window.detail.note, "half a wo")
    press(qtbot, window, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    saved = json.loads((tmp_path / "walk.twist.json").read_text())
    assert saved["intervals"][0]["note"] == "half a wo"


def test_letters_are_keys_while_a_spin_box_has_the_focus(qtbot, opened):
    opened.next_interval()
    opened.detail.start.setFocus()
    qtbot.keyClick(opened.detail.start, Qt.Key.Key_A)
    assert decisions(opened)[0] == Decision.ACCEPTED


def test_going_on_follows_what_is_listed(qtbot, opened):
    opened.intervals.filter.setCurrentText("Undecided")
    opened.next_interval()
    for k in range(3):
        assert opened.document.interval is opened.document.intervals[k]
        opened.accept()
    opened.intervals.filter.setCurrentText("Accepted")
    assert opened.document.interval is None
    opened.reject()
    assert decisions(opened)[:3] == [Decision.ACCEPTED] * 3


def test_edges_at_the_playhead_never_turn_an_interval_over(opened):
    opened.next_interval()
    before = opened.document.interval.interval
    opened.document.go_to(0)
    opened.stop_here()
    opened.document.go_to(343)
    opened.start_here()
    assert opened.document.interval.interval is before
    assert "wrong side" in opened.bar.label.text()
    assert opened.document.review.undo_text == ""


def test_a_crash_is_offered_to_be_restored(qtbot, tmp_path):
    path = tmp_path / "walk.bvh"
    shutil.copy(DIRTY, path)
    first = MainWindow(Settings(theme="light"), None)
    open_clip(qtbot, first, path)
    first.next_interval()
    first.accept()
    first.accept()
    first.undo()
    journal = tmp_path / "walk.twist.json.journal"
    kept = journal.read_bytes()
    expected = decisions(first)
    first.document.review.mark_saved()
    first.close()
    assert not journal.exists()
    journal.write_bytes(kept)  # as a killed program leaves it
    second = MainWindow(Settings(theme="light"), None)
    second.show()
    open_clip(qtbot, second, path)
    assert "3 steps were kept" in second.bar.label.text()
    restore = next(b for b in second.bar.buttons() if b.text() == "Restore")
    qtbot.mouseClick(restore, Qt.MouseButton.LeftButton)
    assert decisions(second) == expected
    assert second.isWindowModified()
    second.document.review.mark_saved()
    second.close()
    assert [p.name for p in tmp_path.iterdir()] == ["walk.bvh"]


def test_a_second_window_on_a_session_only_looks(qtbot, opened):
    other = MainWindow(Settings(theme="light"), None)
    open_clip(qtbot, other, DIRTY)
    assert "another window" in other.bar.label.text()
    other.next_interval()
    other.accept()
    assert not other.save_session()
    assert "cannot save" in other.bar.label.text()
    other.document.review.mark_saved()
    other.close()


def test_a_session_beside_the_clip_is_gone_on_with(qtbot, window, tmp_path):
    path = tmp_path / "walk.bvh"
    shutil.copy(DIRTY, path)
    open_clip(qtbot, window, path)
    window.next_interval()
    window.accept()
    window.save_session()
    open_clip(qtbot, window, ASSETS / "dance.bvh")
    open_clip(qtbot, window, path)
    assert decisions(window)[0] == Decision.ACCEPTED
    # Another version of the clip: the decisions are offered, not forced.
    path.write_bytes(path.read_bytes().replace(b"\r\n", b"\n"))
    open_clip(qtbot, window, path)
    assert decisions(window)[0] == Decision.UNDECIDED
    carry = next(b for b in window.bar.buttons() if b.text() == "Carry decisions over")
    qtbot.mouseClick(carry, Qt.MouseButton.LeftButton)
    assert decisions(window)[0] == Decision.ACCEPTED


def test_a_damaged_session_beside_the_clip_is_set_aside(qtbot, window, tmp_path):
    path = tmp_path / "walk.bvh"
    shutil.copy(DIRTY, path)
    (tmp_path / "walk.twist.json").write_text('{"schema": "twistcore.session/1"')
    open_clip(qtbot, window, path)
    assert "set aside" in window.bar.label.text()
    assert (tmp_path / "walk.twist.json.damaged").exists()
    assert len(window.document.intervals) == 8


def test_a_full_disk_is_told_and_nothing_is_lost(qtbot, window, tmp_path, monkeypatch):
    path = tmp_path / "walk.bvh"
    shutil.copy(DIRTY, path)
    open_clip(qtbot, window, path)
    window.next_interval()

    def full(*_args):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", full)
        window.accept()
        assert "journal cannot be written" in window.bar.label.text()
        assert not window.save_session()
        export(window, ExportChoice(tmp_path / "out.bvh"))
        assert "No space left" in window.bar.label.text()
    assert not (tmp_path / "out.bvh").exists()
    assert decisions(window)[0] == Decision.ACCEPTED
    assert window.save_session()


def test_keys_can_be_changed_and_conflicts_are_told(qtbot, opened):
    opened.preferences()
    dialog = opened.findChild(Preferences)
    dialog.set_key("accept", "R")
    assert "Used twice" in dialog.conflict.text()
    dialog.set_key("accept", "X")
    dialog.first.setCurrentIndex(1)
    dialog.reviewer.setText("Ada")
    dialog.accept()
    opened.next_interval()
    assert opened.detail.start.value() == opened.document.interval.interval.start + 1
    press(qtbot, opened, Qt.Key.Key_X)
    assert decisions(opened)[0] == Decision.ACCEPTED
    assert opened.document.intervals[0].reviewer == "Ada"
    assert opened.settings.keys == {"accept": ["X"]}


def test_the_palette_does_what_is_typed(qtbot, opened):
    opened.command_palette()
    palette = opened.findChild(CommandPalette)
    qtbot.keyClicks(palette.line, "next interval")
    qtbot.keyClick(palette.line, Qt.Key.Key_Return)
    assert opened.document.interval is opened.document.intervals[0]


def test_the_sure_ones_are_accepted_in_one_step(opened):
    opened.accept_at_least(0.5)
    assert Decision.ACCEPTED in decisions(opened)
    opened.undo()
    assert set(decisions(opened)) == {Decision.UNDECIDED}
    opened.accept_at_least(1.1)
    assert "No undecided" in opened.bar.label.text()


def test_another_detector_keeps_what_is_decided_and_undo_brings_its_curve_back(opened):
    opened.next_interval()
    opened.accept()
    opened.actions_by_id["use_paper"].trigger()
    assert opened.document.data.method == "paper"
    assert decisions(opened)[0] == Decision.ACCEPTED
    opened.undo()
    assert opened.document.data.method == "consistency"
    assert opened.actions_by_id["use_consistency"].isChecked()


def test_the_history_goes_back_and_forth(qtbot, opened):
    history = opened.findChild(HistoryPanel)
    opened.next_interval()
    opened.accept()
    opened.reject()
    assert [history.list.item(k).text() for k in range(3)] == [
        "As opened",
        "Accept interval",
        "Reject interval",
    ]
    history.list.itemClicked.emit(history.list.item(0))
    assert set(decisions(opened)) == {Decision.UNDECIDED}
    history.list.itemClicked.emit(history.list.item(2))
    assert decisions(opened)[:2] == [Decision.ACCEPTED, Decision.REJECTED]


def test_the_page_of_keys_is_the_table_of_actions():
    page = Path(__file__).parents[2] / "docs" / "shortcuts.md"
    assert page.read_text(encoding="utf-8") == shortcuts_markdown()


def test_a_chain_without_its_tick_is_left_out_of_table_and_strip(qtbot, opened):
    model = opened.chains.table.model()
    row = next(k for k, c in enumerate(opened.document.data.chains) if c.name == "RightUpLeg")
    role = Qt.ItemDataRole.CheckStateRole
    model.setData(model.index(row, 0), Qt.CheckState.Unchecked.value, role)
    assert opened.intervals.table.model().rowCount() == 3
    opened.next_interval()
    for _ in range(4):
        assert opened.document.interval.interval.chain == "LeftForeArm"
        opened.next_interval()
    model.setData(model.index(row, 0), Qt.CheckState.Checked.value, role)
    assert opened.intervals.table.model().rowCount() == 8


def test_a_presentation_leaves_figure_and_curves_and_gives_the_window_back(qtbot, opened):
    docks = {d.objectName(): d for d in opened.findChildren(QDockWidget)}
    before = {name: dock.isVisible() for name, dock in docks.items()}
    type_before = opened.timeline.readout.font().pointSizeF()
    opened.actions_by_id["presentation"].trigger()
    qtbot.wait(50)
    assert [name for name, dock in docks.items() if dock.isVisible()] == ["curves"]
    assert opened.timeline.readout.font().pointSizeF() > 1.5 * type_before
    opened.next_interval()  # keys work on
    assert opened.document.interval is not None
    qtbot.keyClick(opened, Qt.Key.Key_Escape)
    qtbot.wait(50)
    assert not opened.actions_by_id["presentation"].isChecked()
    assert {name: dock.isVisible() for name, dock in docks.items()} == before
    assert opened.timeline.readout.font().pointSizeF() == type_before
    assert opened.statusBar().isVisible()
