"""The program without room on the disk, robbed of its files, or beside another window."""

import contextlib
import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest

from inspector.session.session_files import fallback_session_path
from tests.gui.pictures import INJECTED
from tests.gui.programs import Program, beside
from twistcore.review import read_session, replay_journal

pytestmark = pytest.mark.thorough

# -- no room ----------------------------------------------------------------------------------


@pytest.fixture(params=["tmpfs", "limit"])
def crowded(request, tmp_path):
    """A folder, and functions that leave a program no room there and give it back."""
    folder = tmp_path / "crowded"
    folder.mkdir()
    if request.param == "limit":

        def fill(program):
            journals = folder.glob("**/*.journal")
            program.tell(f"limit {max((p.stat().st_size for p in journals), default=0) + 20}")

        yield folder, fill, lambda program: program.tell("limit none")
        return
    words = ["mount", "-t", "tmpfs", "-o", "size=2m", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(words, check=False).returncode:
        pytest.skip("no small disk may be mounted here: the limit alone is tried")
    stuffing = folder / "stuffing"

    def fill(_program):
        with stuffing.open("wb", buffering=0) as file, contextlib.suppress(OSError):
            while True:
                file.write(bytes(4096))

    try:
        yield folder, fill, lambda _program: stuffing.unlink()
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


@pytest.mark.parametrize("begun", [0, 2])
def test_a_full_disk_loses_nothing_and_says_so_each_time(crowded, begun):
    folder, fill, free = crowded
    clip = Path(shutil.copy(INJECTED, folder / "walk.bvh"))
    program = Program(clip, folder / "state")
    try:
        program.tell(*["accept"] * begun)
        fill(program)
        for step in range(1, 4):
            program.tell(f"note {6000 + step}")  # more than there is left of a block
            assert "journal cannot be written" in program.answer["says"]
            assert (
                f"the last {'step exists' if step == 1 else f'{step} steps exist'}"
                in program.answer["says"].lower()
            )
            assert program.answer["offers"] == ["Try again", "Save elsewhere…"]
            on_disk = [replay_journal(p).steps for p in folder.glob("**/*.journal")]
            assert max(on_disk, default=0) == begun  # never less than there was
        program.tell("save")
        assert "not saved" in program.answer["says"]
        assert "only in this window" in program.answer["says"]
        program.tell("close Save")
        assert program.answer["open"]
        free(program)
        program.tell("accept")
        program.kill()
        program = Program(clip, folder / "state")
        assert f"{begun + 4} steps were kept" in program.answer["says"]
        program.tell("press Restore")
        assert (program.accepted, program.answer["note"]) == (begun + 1, 6003)
    finally:
        program.kill()


def test_restoring_on_a_full_disk_leaves_the_only_copy(crowded):
    folder, fill, free = crowded
    clip = Path(shutil.copy(INJECTED, folder / "walk.bvh"))
    program = Program(clip, folder / "state")
    program.tell("accept", "accept", "accept")
    program.kill()
    (journal,) = folder.glob("*.journal")
    kept = journal.read_bytes()
    program = Program(clip, folder / "state")
    try:
        fill(program)
        program.tell("press Restore")
        assert journal.read_bytes() == kept
        program.tell("note 6000")
        assert journal.read_bytes().startswith(kept)
        assert replay_journal(journal).steps == 3
        free(program)
        program.tell("press Try again")
        assert replay_journal(journal).steps == 4
    finally:
        program.kill()


# -- files that go or come meanwhile ----------------------------------------------------------


@pytest.mark.parametrize("name", ["walk", "take {1} 100%s"])
def test_a_journal_that_is_deleted_is_written_anew(clip, start_here, name):
    clip = clip.rename(clip.with_name(f"{name}.bvh"))
    program = start_here(clip)
    program.tell("accept", "accept")
    journal = clip.with_name(f"{name}.twist.json.journal")
    journal.unlink()
    program.tell("accept")
    assert "was deleted while it was open" in program.answer["says"]
    assert replay_journal(journal).steps == 3
    program.kill()
    program = start_here(clip)
    assert "3 steps were kept" in program.answer["says"]


def test_a_folder_that_is_deleted_has_its_review_kept_elsewhere(
    clip, start_here, tmp_path, monkeypatch
):
    program = start_here(clip)
    program.tell("accept", "accept")
    kept = clip.read_bytes()
    shutil.rmtree(clip.parent)
    program.tell("accept")
    assert str(tmp_path / "state") in program.answer["says"]
    program.kill()
    clip.parent.mkdir()
    clip.write_bytes(kept)
    program = start_here(clip)
    assert "3 steps were kept" in program.answer["says"]
    program.tell("press Restore")
    assert program.accepted == 3
    shutil.rmtree(clip.parent)
    program.tell("save")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    refuge = fallback_session_path(clip)
    assert str(refuge) in program.answer["says"]
    assert len(read_session(refuge).state.chosen()) == 3


def test_decisions_on_a_clip_that_was_replaced_are_offered_after_a_crash(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "accept", "accept")
    program.kill()
    clip.write_bytes(clip.read_bytes().replace(b"\r\n", b"\n"))
    for _ in range(2):
        program = start_here(clip)
        assert "another version of walk.bvh" in program.answer["says"]
        assert program.answer["offers"] == ["Carry over decisions", "Discard"]
        program.kill()
    program = start_here(clip)
    program.tell("press Carry over decisions")
    assert program.accepted == 3
    program.kill()
    program = start_here(clip)
    program.tell("press Restore")
    assert program.accepted == 3
    assert program.answer["says"] == ""


def test_a_clip_that_changes_while_it_is_open_is_noticed(clip, start):
    program = start(clip)  # a process, because it must get the keyboard
    program.tell("accept", "front")
    assert program.answer["says"] == ""
    os.utime(clip)  # touched, not changed
    program.tell("front")
    assert program.answer["says"] == ""
    clip.write_bytes(clip.read_bytes().replace(b"\r\n", b"\n"))
    program.tell("front")
    assert "has changed on disk" in program.answer["says"]
    assert program.answer["offers"] == ["Open the new version", "Keep the open version"]
    program.tell("press Keep the open version", "front")
    assert program.answer["says"] == ""
    program.tell("save")
    assert "belongs to the version of the clip that is open" in program.answer["says"]
    program.tell("front", "export", "state")
    assert "version that is open in this window was exported" in program.answer["says"]


def test_a_session_of_another_version_is_kept_when_this_one_is_saved(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "accept", "save", "close")
    program.end()
    session = clip.with_name("walk.twist.json")
    old = session.read_bytes()
    clip.write_bytes(clip.read_bytes().replace(b"\r\n", b"\n"))
    program = start_here(clip)
    assert program.answer["offers"] == ["Carry over decisions"]
    program.tell("accept", "save")
    assert session.with_name("walk.twist.json.earlier").read_bytes() == old
    assert "another review" in program.answer["says"]
    program.tell("accept", "save")
    assert not session.with_name("walk.twist.json.earlier-2").exists()


# -- locks ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text", ["", "garbage\n", "1\npython3\n{here}\n", "{me}\npython3\n{here}\n"]
)
def test_a_lock_that_nobody_holds_locks_nobody_out(clip, start_here, text):
    """Empty, damaged, or with a process id that is another program's by now."""
    lock = clip.with_name("walk.twist.json.journal.lock")
    lock.write_text(text.format(here=socket.gethostname(), me=os.getpid()))
    program = start_here(clip)
    program.tell("accept", "save")
    assert program.accepted == 1
    assert program.answer["saved"]


def test_a_lock_from_another_computer_is_named_and_can_be_taken_over(clip, start_here):
    lock = clip.with_name("walk.twist.json.journal.lock")
    lock.write_text("4711\nTwist Inspector\nelsewhere\n")
    program = start_here(clip)
    for what in ("4711", "elsewhere", "since"):
        assert what in program.answer["says"]
    assert program.answer["offers"] == ["Take over", "View only"]
    program.tell("press View only", "accept")
    assert program.accepted == 0  # looking decides nothing
    assert program.answer["offers"] == ["Take over", "View only"]
    assert lock.read_text().startswith("4711")
    program.tell("press Take over", "accept", "save")
    assert program.accepted == 1
    assert program.answer["saved"]
    program.tell("close")
    program.end()
    assert beside(clip) == ["walk.twist.json"]


def test_a_window_that_was_robbed_of_its_lock_stops_and_loses_nothing(clip, start, start_here):
    one = start_here(clip)
    one.tell("accept", "accept")
    other = start(clip)
    assert str(os.getpid()) in other.answer["says"]
    other.tell("press Take over")
    assert "2 steps were kept" in other.answer["says"]
    other.tell("press Restore", "accept")
    assert other.accepted == 3
    one.tell("accept")
    assert one.accepted == 2
    assert str(other.process.pid) in one.answer["says"]
    one.tell("close Discard")
    one.end()
    other.tell("accept")
    other.kill()
    last = start_here(clip)
    assert "4 steps were kept" in last.answer["says"]


def test_a_window_that_was_robbed_and_has_not_noticed_harms_nobody(clip, start, start_here):
    one = start_here(clip)
    one.tell("accept", "accept")
    other = start(clip)
    other.tell("press Take over", "press Restore", "accept")
    one.tell("close Discard")  # its own decisions; the other window goes on with a copy
    one.end()
    other.kill()
    assert "3 steps were kept" in start_here(clip).answer["says"]


def test_a_lock_that_is_a_link_leads_nowhere(clip, start_here):
    precious = clip.with_name("precious.txt")
    precious.write_text("precious")
    clip.with_name("walk.twist.json.journal.lock").symlink_to(precious)
    start_here(clip).tell("accept", "save")
    assert precious.read_text() == "precious"
