"""Nothing decided is lost: sessions, settings, and what an earlier run left behind."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import QDir, Qt, QTimer
from PySide6.QtWidgets import QApplication, QMessageBox

from inspector.session.export_files import ExportChoice
from inspector.session.opening import ClipMissingError, analyse_session
from inspector.session.session_files import (
    SESSION_PATTERNS,
    fallback_session_path,
    find_existing_sessions,
    session_path,
)
from inspector.session.settings import Settings, load_settings, save_settings
from tests.conftest import ASSETS
from tests.gui.pictures import INJECTED
from tests.gui.windows import act, close_window, decisions, export, open_clip, press
from tests.twistcore.reviews import CLIP, flip, fresh
from twistcore.review import Decision, Insert, write_session


@pytest.fixture
def path(tmp_path):
    """A copy of the walk: its session and journal lie beside it."""
    return Path(shutil.copy(INJECTED, tmp_path / "walk.bvh"))


def test_a_session_is_saved_and_opened_again(qtbot, window, path, tmp_path):
    open_clip(qtbot, window, path)
    act(window, "next_interval")
    act(window, "accept")
    assert window.isWindowModified()
    press(qtbot, window, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    assert not window.isWindowModified()
    session = tmp_path / "walk.twist.json"
    assert json.loads(session.read_text())["intervals"][0]["decision"] == "accepted"
    open_clip(qtbot, window, INJECTED)
    open_clip(qtbot, window, session)
    assert decisions(window)[0] == Decision.ACCEPTED
    assert window.document.data.clip.path == path


@pytest.mark.parametrize("named", ["", "/", ".", "..", "gone.bvh"])
def test_a_session_of_no_clip_says_so(path, tmp_path, named):
    session = tmp_path / "a.twist.json"
    write_session(CLIP, fresh().state, session)
    document = json.loads(session.read_text()) | {"clip": named}
    session.write_text(json.dumps(document))
    with pytest.raises(ClipMissingError):
        analyse_session(session)


def test_settings_are_kept_and_damage_is_set_aside(tmp_path):
    path = tmp_path / "deep" / "settings.json"
    settings = Settings(theme="dark", reviewer="Ada")
    settings.remember(INJECTED)
    assert save_settings(path, settings) == ""
    assert load_settings(path) == (settings, "")
    path.write_bytes(b'{"recent": [1, 2')
    again, complaint = load_settings(path)
    assert again == Settings()
    assert "was kept as" in complaint
    assert (tmp_path / "deep" / "settings.json.damaged").exists()


@pytest.mark.thorough
def test_a_note_still_being_typed_is_saved(qtbot, window, path, tmp_path):
    open_clip(qtbot, window, path)
    act(window, "next_interval")
    window.detail.note.setFocus()
    qtbot.keyClicks(window.detail.note, "half a wo")
    press(qtbot, window, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    saved = json.loads((tmp_path / "walk.twist.json").read_text())
    assert saved["intervals"][0]["note"] == "half a wo"


def test_a_crash_is_offered_to_be_restored(qtbot, show_window, path, tmp_path):
    first = show_window()
    open_clip(qtbot, first, path)
    act(first, "next_interval")
    act(first, "accept")
    act(first, "accept")
    act(first, "undo")
    journal = tmp_path / "walk.twist.json.journal"
    kept = journal.read_bytes()
    expected = decisions(first)
    close_window(qtbot, first)
    assert not journal.exists()
    journal.write_bytes(kept)  # as a killed program leaves it
    second = show_window()
    open_clip(qtbot, second, path)
    assert "3 steps were kept" in second.bar.label.text()
    restore = next(b for b in second.bar.buttons() if b.text() == "Restore")
    qtbot.mouseClick(restore, Qt.MouseButton.LeftButton)
    assert decisions(second) == expected
    assert second.isWindowModified()
    close_window(qtbot, second)
    assert [p.name for p in tmp_path.iterdir()] == ["walk.bvh"]


@pytest.mark.thorough
def test_of_two_journals_the_newer_is_offered_and_neither_is_lost(qtbot, show_window, path):
    """A folder that could be written, then could not, and now can be again."""
    elsewhere = fallback_session_path(path)
    elsewhere = elsewhere.with_name(elsewhere.name + ".journal")
    beside = path.with_name("walk.twist.json.journal")
    kept = {}
    for journal, steps in ((beside, 1), (elsewhere, 3)):
        window = show_window()
        open_clip(qtbot, window, path)
        for _ in range(steps):
            act(window, "next_interval")
            act(window, "accept")
        kept[journal] = beside.read_bytes()
        close_window(qtbot, window)
    elsewhere.parent.mkdir(parents=True)
    for age, (journal, text) in enumerate(kept.items()):
        journal.write_bytes(text)
        os.utime(journal, (1e9 + age, 1e9 + age))
    window = show_window()
    open_clip(qtbot, window, path)
    assert "3 steps were kept" in window.bar.label.text()
    restore = next(b for b in window.bar.buttons() if b.text() == "Restore")
    qtbot.mouseClick(restore, Qt.MouseButton.LeftButton)
    assert decisions(window).count(Decision.ACCEPTED) == 3
    assert beside.read_bytes() == kept[beside]
    assert "Another review" in window.bar.label.text()


def test_of_two_sessions_the_newer_is_gone_on_with(path):
    both = fallback_session_path(path), session_path(path)
    assert find_existing_sessions(path) == []
    both[0].parent.mkdir(parents=True)
    for newer in (0, 1):
        for k, session in enumerate(both):
            session.write_text("{}")
            os.utime(session, (1e9 + (k == newer), 1e9 + (k == newer)))
        assert find_existing_sessions(path) == [both[newer], both[1 - newer]]


@pytest.mark.thorough
def test_a_second_window_on_a_session_only_looks(qtbot, opened, show_window):
    other = show_window()
    open_clip(qtbot, other, INJECTED)
    assert "another window" in other.bar.label.text()
    act(other, "next_interval")
    act(other, "accept")
    assert Decision.ACCEPTED not in decisions(other)
    assert [b.text() for b in other.bar.buttons()] == ["Take over", "View only"]
    assert not other.files.save_session()
    assert "was not saved" in other.bar.label.text()


@pytest.mark.thorough
def test_a_window_without_the_lock_offers_only_what_it_can_do(qtbot, show_window, path):
    first, second = (show_window(Settings(turn_ms=0, autosave=False)) for _ in range(2))
    open_clip(qtbot, first, path)
    first.document.select_interval(first.document.intervals[0].id)
    first.document.decide(Decision.ACCEPTED)
    open_clip(qtbot, second, path)
    (take,) = [b for b in second.bar.buttons() if b.text() == "Take over"]
    with qtbot.waitSignal(second.document.opened):
        qtbot.mouseClick(take, Qt.MouseButton.LeftButton)
    assert not first.document.keeper.may_change()
    offered = []

    def answer():
        box = QApplication.activeModalWidget()
        offered.extend(b.text().replace("&", "") for b in box.buttons())
        box.button(QMessageBox.StandardButton.Cancel).click()

    QTimer.singleShot(0, answer)
    first.close()
    assert first.isVisible()
    assert sorted(offered) == ["Cancel", "Close without saving", "Save elsewhere…"]
    first.files.leave(lambda: None)
    assert [b.text() for b in first.bar.buttons()] == ["Save elsewhere…", "Leave without saving"]


@pytest.mark.thorough
def test_the_lock_follows_the_session_that_was_written_and_no_other(
    qtbot, window, show_window, path, tmp_path
):
    open_clip(qtbot, window, path)
    act(window, "next_interval")
    act(window, "accept")
    keeper, other = window.document.keeper, tmp_path / "other.twist.json"
    saved, told = keeper.save(tmp_path / "nowhere" / "else.twist.json")
    assert not saved
    assert "not saved" in told
    assert keeper.lock.path == tmp_path / "walk.twist.json.journal.lock"
    assert keeper.save(other) == (True, "")
    second = show_window()
    open_clip(qtbot, second, path)  # it goes on with the session where that was saved last
    assert second.document.data.session == other
    assert second.document.keeper.read_only
    assert not second.document.keeper.save(other)[0]


@pytest.mark.thorough
def test_a_session_beside_the_clip_is_gone_on_with(qtbot, window, path):
    open_clip(qtbot, window, path)
    act(window, "next_interval")
    act(window, "accept")
    window.files.save_session()
    open_clip(qtbot, window, ASSETS / "dance.bvh")
    open_clip(qtbot, window, path)
    assert decisions(window)[0] == Decision.ACCEPTED
    # Another version of the clip: the decisions are offered, not forced.
    path.write_bytes(path.read_bytes().replace(b"\r\n", b"\n"))
    open_clip(qtbot, window, path)
    assert decisions(window)[0] == Decision.UNDECIDED
    carry = next(b for b in window.bar.buttons() if b.text() == "Carry over decisions")
    qtbot.mouseClick(carry, Qt.MouseButton.LeftButton)
    assert decisions(window)[0] == Decision.ACCEPTED


@pytest.mark.thorough
def test_a_damaged_session_beside_the_clip_is_set_aside(qtbot, window, path, tmp_path):
    (tmp_path / "walk.twist.json").write_text('{"schema": "twistcore.session/1"')
    open_clip(qtbot, window, path)
    assert "was renamed to" in window.bar.label.text()
    assert (tmp_path / "walk.twist.json.damaged").exists()
    assert len(window.document.intervals) == 8


@pytest.mark.thorough
def test_a_session_with_flips_opens_as_it_is(qtbot, window, path, tmp_path):
    """One that has flips at no τ of their limbs gets that; nothing in it is replaced."""
    session = tmp_path / "walk.twist.json"
    write_session(CLIP, Insert(flip()).apply(fresh().state), session)
    open_clip(qtbot, window, path)
    assert "new kinds of errors: none found" in window.bar.label.text()
    assert len(window.document.intervals) == 9
    act(window, "next_interval")
    act(window, "accept")
    assert window.files.save_session()
    document = json.loads(session.read_bytes())
    assert document["schema"] == "twistcore.session/3"
    assert [i["kind"] for i in document["intervals"]] == ["counter-twist"] * 8 + ["limb flip"]
    open_clip(qtbot, window, path)
    assert window.bar.label.text() == "Continuing your review from walk.twist.json."


@pytest.mark.thorough
def test_reasons_are_told_of_what_is_opened_again(qtbot, show_window, tmp_path):
    path = Path(shutil.copy(ASSETS / "kick.bvh", tmp_path))
    journal = Path(f"{session_path(path)}.journal")

    def reasons(window):
        told = []
        for judged in window.document.intervals:
            window.document.select_interval(judged.id)
            told.append(window.detail.why.text())
        return told

    window = show_window()
    open_clip(qtbot, window, path)
    fresh_reasons = reasons(window)
    assert any("knee jumps by" in told for told in fresh_reasons)
    assert any("about its own axis" in told for told in fresh_reasons)
    act(window, "accept")
    assert window.files.save_session()
    saved = session_path(path).read_bytes()
    open_clip(qtbot, window, INJECTED)
    open_clip(qtbot, window, path)
    assert reasons(window) == fresh_reasons
    assert not window.isWindowModified()
    assert window.files.save_session()
    assert session_path(path).read_bytes() == saved
    window.document.select_interval(1)
    act(window, "reject")
    kept = journal.read_bytes()
    close_window(qtbot, window)
    journal.write_bytes(kept)  # as a killed program leaves it
    window = show_window()
    open_clip(qtbot, window, path)
    restore = next(b for b in window.bar.buttons() if b.text() == "Restore")
    qtbot.mouseClick(restore, Qt.MouseButton.LeftButton)
    assert Decision.REJECTED in decisions(window)
    assert reasons(window) == fresh_reasons


@pytest.mark.thorough
def test_a_full_disk_is_told_and_nothing_is_lost(qtbot, window, monkeypatch, path, tmp_path):
    open_clip(qtbot, window, path)
    act(window, "next_interval")

    def full(*_args):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", full)
        act(window, "accept")
        assert "journal cannot be written" in window.bar.label.text()
        assert not window.files.save_session()
        export(window, ExportChoice(tmp_path / "out.bvh"))
        assert "No space left" in window.bar.label.text()
    assert not (tmp_path / "out.bvh").exists()
    assert decisions(window)[0] == Decision.ACCEPTED
    assert window.files.save_session()


@pytest.mark.thorough
@pytest.mark.skipif(os.name == "nt", reason="the folder's permissions are POSIX's")
def test_in_a_folder_that_cannot_be_written_a_review_is_kept_elsewhere(path, tmp_path):
    folder, state = tmp_path / "given", tmp_path / "mine"
    folder.mkdir()
    clip = path.rename(folder / path.name)
    script = Path(__file__).with_name("unwritable_review.py")
    words = [sys.executable, str(script), str(clip)]
    if os.geteuid() == 0:  # permissions do not bind root, unless it gives that up
        if shutil.which("setpriv") is None:
            pytest.skip("root writes everywhere")
        words = ["setpriv", "--bounding-set=-dac_override", *words]
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": root, "XDG_STATE_HOME": str(state)}
    pipe = subprocess.PIPE
    with subprocess.Popen(words, env=environment, stdin=pipe, stdout=pipe, text=True) as process:

        def review():
            folder.chmod(0o555)
            process.stdin.write("again\n")
            process.stdin.flush()
            lines = [process.stdout.readline().strip() for _ in range(3)]
            folder.chmod(0o755)
            return lines

        message, verdicts, saved = review()
        assert "is read-only" in message
        assert (verdicts, saved) == ("0", "True")
        message, verdicts, saved = review()
        assert message.startswith("Continuing your review from walk-")
        assert (verdicts, saved) == ("1", "True")
        assert [p.name for p in folder.iterdir()] == [clip.name]
        assert [p.suffixes for p in (state / "twist-inspector").iterdir()] == [[".twist", ".json"]]

        shutil.rmtree(state)
        (folder / "walk.twist.json").write_text('{"schema": "twistcore.session/1"')
        message, verdicts, saved = review()
        assert "could not be renamed" in message
        assert (verdicts, saved) == ("0", "True")


def test_a_lock_is_not_offered_as_a_session():
    offered = ["walk.twist.json", "walk.twist.json.journal", "walk.twist.json.journal-2",
               "walk.twist.json.earlier", "walk_refined.replay.json"]  # fmt: skip
    assert all(QDir.match(SESSION_PATTERNS.split(), name) for name in offered)
    assert not QDir.match(SESSION_PATTERNS.split(), "walk.twist.json.journal.lock")
