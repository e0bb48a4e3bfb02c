"""Going through a folder: what is saved by itself, what comes next, where one goes on."""

import shutil
from pathlib import Path

import pytest
from PySide6.QtCore import Qt

from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import ClipState
from inspector.folder.remembered_folders import folder_record
from inspector.panels.reason_palette import ReasonPalette
from inspector.session.settings import Settings
from inspector.window.export_dialog import ExportDialog
from tests.gui.folders import put_errors, two_takes
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, decisions, open_clip
from twistcore.review import Decision


def test_the_window_opens_a_folder_reviews_and_goes_on(qtbot, show_window, tmp_path):
    for k in (2, 5):
        put_errors(tmp_path / f"{k}.bvh", k)
    window = show_window()
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(tmp_path)
    assert window.docks["clips"].isVisible()
    qtbot.waitUntil(lambda: not window.queue.running, timeout=60_000)
    window.document.accept_undecided()
    assert window.files.save_session()
    first = window.document.data.clip.path
    assert window.queue.clips[first].done
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        act(window, "next_clip")
    assert window.document.data.clip.path != first
    window.document.accept_undecided()
    window.files.save_session()
    act(window, "next_clip")
    assert window.bar.label.text()


@pytest.mark.thorough
def test_the_worst_so_far_waits_for_a_tenth_and_a_worse_one_is_offered(
    qtbot, show_window, tmp_path, monkeypatch
):
    monkeypatch.setattr("inspector.window.file_actions._FIRST_MS", 0)
    monkeypatch.setattr(FolderQueue, "_poll_workers", lambda _: None)  # the test says what is known
    for k in range(30):
        shutil.copy(INJECTED, tmp_path / f"{k:02}.bvh")
    window = show_window()
    queue, opened = window.queue, window.document.opened

    def know(name, severity):
        found = {"severity": severity, "intervals": 8}
        queue._put(tmp_path / f"{name}.bvh", state=ClipState.READY, **found)
        queue.changed.emit()

    window.open_path(tmp_path)
    qtbot.waitUntil(lambda: not window.files._first.isActive())
    know("00", 1.0)
    know("01", 3.0)
    assert not window.document.opener.busy, "two of thirty say nothing"
    with qtbot.waitSignal(opened):
        know("02", 2.0)
    assert window.document.data.clip.path.name == "01.bvh"
    qtbot.waitUntil(lambda: "worst clip so far" in window.bar.label.text())
    assert "3 of 30" in window.bar.label.text()
    know("03", 2.5)
    assert window.bar.buttons() == []
    know("04", 9.0)
    (offer,) = window.bar.buttons()
    assert "04.bvh" in offer.text()
    assert "9.0°" in window.bar.label.text()
    with qtbot.waitSignal(opened):
        qtbot.mouseClick(offer, Qt.MouseButton.LeftButton)
    assert window.document.data.clip.path.name == "04.bvh"
    know("05", 5.0)
    assert window.bar.buttons() == []
    table = window.clips.table.model()
    shown = {table.index(row, 0).data(): table.index(row, 1).data() for row in range(30)}
    assert (shown["04"], shown["01"], shown["29"]) == ("9.0°", "3.0°", "")


@pytest.mark.thorough
def test_the_clips_are_shown_only_with_a_folder(qtbot, show_window, clip):
    settings = Settings(turn_ms=0)
    window = show_window(settings)
    clips = window.docks["clips"]
    assert not clips.toggleViewAction().isEnabled()
    with qtbot.waitSignal(window.document.opened):
        window.open_path(clip.parent)
    assert clips.isVisible()
    assert clips.toggleViewAction().isEnabled()
    settings.geometry, settings.layout = window.usual_layout.kept("")
    again = show_window(settings)  # the next day
    assert not again.docks["clips"].isVisible()
    assert again.docks["chains"].isVisible()


@pytest.mark.thorough
def test_the_folder_keeps_its_tau_and_where_one_stopped(qtbot, show_window, tmp_path, monkeypatch):
    monkeypatch.setattr("inspector.window.file_actions._FIRST_MS", 120_000)  # however busy it is
    for k in (2, 5):
        put_errors(tmp_path / f"{k}.bvh", k)
    settings = Settings(turn_ms=0)
    window = show_window(settings)
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(tmp_path)
    assert window.document.data.clip.path.name == "5.bvh"  # the worst
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(tmp_path / "2.bvh")
    window.document.set_tau(0.3)
    act(window, "profile_to_folder")
    assert window.clips.tau.text() == "τ: from 2.bvh"
    tau = dict(window.queue.profile.tau)
    window.document.review.mark_saved()
    second = show_window(settings)
    with qtbot.waitSignal(second.document.opened, timeout=60_000):
        second.open_path(tmp_path)
    assert second.document.data.clip.path.name == "2.bvh"  # where one stopped
    assert (second.queue.profile_name, dict(second.queue.profile.tau)) == ("from 2.bvh", tau)
    act(second, "automatic_folder")
    assert folder_record(settings, tmp_path)["profile"] == ""
    assert second.clips.tau.text().startswith("τ: ")


@pytest.mark.thorough
def test_without_autosave_a_bar_asks_before_a_clip_is_left(qtbot, show_window, clip):
    other = Path(shutil.copy(clip, clip.with_name("other.bvh")))
    window = show_window(Settings(turn_ms=0, autosave=False))
    open_clip(qtbot, window, clip)
    act(window, "next_interval")
    act(window, "accept")
    window.open_path(other)
    assert "walk.bvh" in window.bar.label.text()
    assert window.document.data.clip.path == clip
    answers = {button.text(): button for button in window.bar.buttons()}
    assert (len(answers), "Save" in answers) == (3, True)
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        answers["Save"].click()
    assert clip.with_name("walk.twist.json").exists()
    assert window.document.data.clip.path == other


def test_a_session_is_saved_by_itself(qtbot, show_window, clip, monkeypatch):
    monkeypatch.setattr("inspector.window.saving._AUTOSAVE_MS", 200)
    window = show_window()
    open_clip(qtbot, window, clip)
    act(window, "next_interval")
    act(window, "accept")
    assert not window.document.review.saved
    qtbot.waitUntil(lambda: window.document.review.saved, timeout=5000)
    assert not window.isWindowModified()
    assert clip.with_name("walk.twist.json").exists()
    act(window, "undo")
    assert not window.document.review.saved


@pytest.mark.thorough
def test_an_export_takes_no_clip_away_from_who_has_gone_on(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    document, first = window.document, window.document.data.clip.path

    def export_and(meanwhile):
        window.files.export_dialog(at_once=True)
        assert window.exporter.running
        meanwhile()
        window.exporter.finish()
        qtbot.wait(20)

    act(window, "next_interval")
    export_and(lambda: act(window, "accept"))
    assert not document.opener.busy
    assert document.data.clip.path == first
    window.detail.note.setFocus()
    export_and(lambda: qtbot.keyClicks(window.detail.note, "a or r"))
    assert not document.opener.busy  # letters that come next would judge in the next clip
    window.keys.return_focus()
    export_and(lambda: act(window, "exercise"))
    assert not document.opener.busy
    assert window.guide.isVisible()  # a clip that opened by itself would end it
    window.lesson_actions.leave_guide()
    third = Path(shutil.copy(first, tmp_path / "c.bvh"))
    export_and(lambda: window.open_path(third))
    qtbot.waitUntil(lambda: document.data.clip.path != first, timeout=20_000)
    assert document.data.clip.path == third
    window.open_path(first)
    qtbot.waitUntil(lambda: document.data.clip.path == first, timeout=20_000)
    export_and(window.files.export_dialog)
    assert not document.opener.busy
    dialog = window.findChild(ExportDialog)
    with qtbot.waitSignal(document.opened, timeout=20_000):
        window.open_path(third)
    assert not dialog.isVisible()  # it would export the new clip under the old one's name


@pytest.mark.thorough
def test_an_export_that_leaves_intervals_undecided_says_how_many(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    document = window.document
    left = sum(j.interval.correctable for j in document.intervals)
    assert set(decisions(window)) == {Decision.UNDECIDED}
    with qtbot.waitSignal(document.opened, timeout=60_000):
        window.files.export_dialog(at_once=True)
    qtbot.waitUntil(lambda: f"{left} undecided" in window.bar.label.text(), timeout=20_000)


@pytest.mark.thorough
def test_what_waits_for_a_clip_happens_with_no_other(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    first = window.document.data.clip.path
    following = window.queue.next_after(first)
    following.write_bytes(b"HIERARCHY\nROOT")  # it cannot be opened any more
    window.files.export_dialog(at_once=True)
    window.exporter.finish()
    qtbot.waitUntil(lambda: following.name in window.bar.label.text(), timeout=20_000)
    assert window.findChildren(ExportDialog) == []  # it was never seen, and is gone
    qtbot.waitUntil(lambda: not window.document.opener.busy, timeout=20_000)
    open_clip(qtbot, window, shutil.copy(first, tmp_path / "c.bvh"))
    qtbot.wait(50)
    assert "Next clip" not in window.bar.label.text()


@pytest.mark.thorough
def test_back_is_still_there_where_the_way_back_failed(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    first = window.document.data.clip.path
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        act(window, "next_clip")
    data = first.read_bytes()
    first.unlink()
    act(window, "previous_clip")
    qtbot.waitUntil(lambda: not window.document.opener.busy, timeout=20_000)
    first.write_bytes(data)
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        act(window, "previous_clip")
    assert window.document.data.clip.path == first
    act(window, "previous_clip")
    assert window.bar.label.text()


@pytest.mark.thorough
def test_a_clip_with_decisions_to_restore_is_where_one_stopped(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    worst = window.document.data.clip.path
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        act(window, "next_clip")
    document, stopped_at = window.document, window.document.data.clip.path
    document.decide(Decision.ACCEPTED, [j.id for j in document.intervals])
    assert window.files.save_session()
    document.decide(Decision.REJECTED, [document.intervals[0].id])
    journal = document.keeper.journal.path
    left = journal.read_bytes()
    document.keeper.journal.give_up()
    document.review.mark_saved()
    window.queue.close()
    document.close_clip()
    journal.write_bytes(left)  # as after a crash
    second = show_window(window.settings)
    second.files.offer_unsaved()
    qtbot.waitUntil(lambda: second.bar.asks)
    with qtbot.waitSignal(second.document.opened, timeout=60_000):
        next(b for b in second.bar.buttons() if b.text() == "Open and restore").click()
    assert second.document.data.clip.path == stopped_at != worst
    qtbot.waitUntil(lambda: not second.document.keeper.leftovers, timeout=5000)
    assert second.document.intervals[0].decision == Decision.REJECTED


@pytest.mark.thorough
def test_saving_by_itself_waits_while_a_clip_is_opened(qtbot, show_window, clip, monkeypatch):
    monkeypatch.setattr("inspector.window.saving._AUTOSAVE_MS", 50)
    window = show_window()
    open_clip(qtbot, window, clip)
    opener = type(window.document.opener)
    act(window, "next_interval")
    with monkeypatch.context() as patch:
        act(window, "accept")
        patch.setattr(opener, "busy", property(lambda _: True))
        qtbot.wait(150)
    assert not window.document.review.saved
    qtbot.waitUntil(lambda: window.document.review.saved, timeout=5000)


@pytest.mark.thorough
def test_a_name_given_while_a_clip_is_opened_is_put_to_decisions_later(
    qtbot, show_window, clip, monkeypatch
):
    window = show_window()
    open_clip(qtbot, window, clip)
    act(window, "next_interval")
    act(window, "accept")
    with monkeypatch.context() as patch:
        patch.setattr(type(window.document.opener), "busy", property(lambda _: True))
        window.document.sign("Ada")
    window.document.sign("Ada")
    assert "Ada" in {j.reviewer for j in window.document.intervals}


@pytest.mark.thorough
def test_a_name_is_not_put_to_what_was_applied_automatically(qtbot, show_window, clip):
    document = (window := show_window()).document
    open_clip(qtbot, window, clip)
    document.decide(Decision.ACCEPTED, [j.id for j in document.intervals])
    document.undo()
    assert document.accept_undecided()
    document.sign("Ada")
    accepted = [j for j in document.intervals if j.decision == Decision.ACCEPTED]
    assert accepted
    assert {j.reviewer for j in accepted} == {""}


@pytest.mark.thorough
def test_a_reason_is_not_given_in_another_clip(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    window.document.select_interval(window.document.intervals[0].id, jump=True)
    window.review_actions.reject_for()
    palette = window.findChild(ReasonPalette)
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        act(window, "next_clip")
    assert not palette.isVisible()
