"""Real processes, killed, out of room or robbed of their files: every decision is there again."""

import contextlib
import hashlib
import json
import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest

from inspector.session_files import refuge_path
from tests.gui.pictures import INJECTED
from tests.gui.programs import Program
from twistcore.review import read_session, recover


@pytest.fixture
def clip(tmp_path):
    folder = tmp_path / "clips"
    folder.mkdir()
    return Path(shutil.copy(INJECTED, folder / "walk.bvh"))


@pytest.fixture
def start(tmp_path):
    """Starts the program on a clip; kills what is still there at the end."""
    started = []

    def run(clip):
        started.append(Program(clip, tmp_path / "state"))
        return started[-1]

    yield run
    for program in started:
        if program.process.poll() is None:
            program.kill()


def beside(clip):
    return sorted(p.name for p in clip.parent.iterdir() if p != clip)


# -- kill, restore, kill ----------------------------------------------------------------------


def test_restored_and_killed_again_it_is_offered_again(clip, start):
    first = start(clip)
    first.tell("accept", "accept", "accept")
    first.kill()
    for _ in range(3):
        program = start(clip)
        assert "3 steps were kept" in program.answer["says"]
        assert program.answer["offers"] == ["Restore", "Discard"]
        program.tell("press Restore")
        assert program.accepted == 3
        assert not program.answer["saved"]
        program.kill()
    program = start(clip)
    program.tell("press Restore", "accept", "undo", "undo")
    assert program.accepted == 2
    program.kill()
    last = start(clip)
    assert "6 steps were kept" in last.answer["says"]
    last.tell("press Restore")
    assert last.accepted == 2
    last.tell("save")
    assert last.answer["saved"]
    assert beside(clip) == ["walk.twist.json", "walk.twist.json.journal.lock"]


def test_an_undo_of_what_was_saved_survives_a_restore_that_is_closed(clip, start):
    program = start(clip)
    program.tell("accept", "accept", "save", "undo")
    program.kill()
    program = start(clip)
    program.tell("press Restore")
    assert program.accepted == 1
    assert not program.answer["saved"]  # the session on disk says otherwise
    program.tell("close Save")
    program.end()
    assert start(clip).accepted == 1


def test_a_bar_that_was_ignored_asks_again_and_no_leftover_hides_another(clip, start):
    first = start(clip)
    first.tell("accept", "accept", "accept")
    first.kill()
    second = start(clip)
    assert second.answer["offers"] == ["Restore", "Discard"]
    second.tell("accept 3")  # not answered; the fourth is judged instead
    assert second.accepted == 1
    second.kill()
    names = [n for n in beside(clip) if not n.endswith(".lock")]
    assert names == ["walk.twist.json.journal", "walk.twist.json.journal-2"]
    third = start(clip)
    assert "1 step was kept" in third.answer["says"]
    third.tell("press Restore")
    assert third.accepted == 1
    assert "Another review" in third.answer["says"]
    assert "3 steps were kept" in third.answer["says"]
    third.tell("press Add its decisions")
    assert third.accepted == 4
    third.kill()
    last = start(clip)
    last.tell("press Restore")
    assert last.accepted == 4
    assert last.answer["says"] == ""


def test_restoring_beside_decisions_made_since_adds_to_them(clip, start):
    first = start(clip)
    first.tell("accept", "accept")
    first.kill()
    second = start(clip)
    second.tell("accept 4", "press Restore")
    assert second.accepted == 3
    second.tell("undo")
    assert second.accepted == 1


# -- names that are not UTF-8 -----------------------------------------------------------------


@pytest.mark.skipif(os.name == "nt", reason="names are text there")
def test_a_joint_and_a_path_in_other_bytes_than_utf_8(clip, start, capfd):
    folder = Path(os.fsdecode(os.fsencode(clip.parent) + b"/\xfcbung"))
    folder.mkdir()
    other = folder / os.fsdecode(b"w\xe4lk.bvh")
    text = clip.read_bytes()
    other.write_bytes(text.replace(b"LeftForeArm", b"Unterarm \xfc"))
    program = start(other)
    program.tell("accept", "accept", "accept")
    assert program.answer["says"] == ""
    (journal,) = [p for p in folder.iterdir() if p.name.endswith(".journal")]
    assert b"Unterarm \\udcfc" in journal.read_bytes()
    program.kill()
    program = start(other)
    program.tell("press Restore")
    assert program.accepted == 3
    program.tell("close Save")
    program.end()
    (session,) = folder.glob("*.twist.json")
    assert json.loads(session.read_bytes().decode())["intervals"][0]["decision"] == "accepted"
    assert read_session(session).state.intervals[0].interval.chain == "Unterarm \udcfc"
    assert start(other).accepted == 3
    assert "Traceback" not in capfd.readouterr().err


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
                f"the last {'step is' if step == 1 else f'{step} steps are'}"
                in (program.answer["says"])
            )
            assert program.answer["offers"] == ["Try again", "Save elsewhere…"]
            on_disk = [recover(p).steps for p in folder.glob("**/*.journal")]
            assert max(on_disk, default=0) == begun  # never less than there was
        program.tell("save")
        assert "not saved" in program.answer["says"]
        assert "this window only" in program.answer["says"]
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
        assert recover(journal).steps == 3
        free(program)
        program.tell("press Try again")
        assert recover(journal).steps == 4
    finally:
        program.kill()


# -- files that go or come meanwhile ----------------------------------------------------------


def test_a_journal_that_is_deleted_is_written_anew(clip, start):
    program = start(clip)
    program.tell("accept", "accept")
    journal = clip.with_name("walk.twist.json.journal")
    journal.unlink()
    program.tell("accept")
    assert "was deleted while it was open" in program.answer["says"]
    assert recover(journal).steps == 3
    program.kill()
    program = start(clip)
    assert "3 steps were kept" in program.answer["says"]


def test_a_folder_that_is_deleted_has_its_review_kept_elsewhere(clip, start, tmp_path, monkeypatch):
    program = start(clip)
    program.tell("accept", "accept")
    kept = clip.read_bytes()
    shutil.rmtree(clip.parent)
    program.tell("accept")
    assert str(tmp_path / "state") in program.answer["says"]
    program.kill()
    clip.parent.mkdir()
    clip.write_bytes(kept)
    program = start(clip)
    assert "3 steps were kept" in program.answer["says"]
    program.tell("press Restore")
    assert program.accepted == 3
    shutil.rmtree(clip.parent)
    program.tell("save")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    refuge = refuge_path(clip)
    assert str(refuge) in program.answer["says"]
    assert len(read_session(refuge).state.chosen()) == 3


def test_decisions_on_a_clip_that_was_replaced_are_offered_after_a_crash(clip, start):
    program = start(clip)
    program.tell("accept", "accept", "accept")
    program.kill()
    clip.write_bytes(clip.read_bytes().replace(b"\r\n", b"\n"))
    for _ in range(2):
        program = start(clip)
        assert "another version of walk.bvh" in program.answer["says"]
        assert program.answer["offers"] == ["Carry decisions over", "Discard"]
        program.kill()
    program = start(clip)
    program.tell("press Carry decisions over")
    assert program.accepted == 3
    program.kill()
    program = start(clip)
    program.tell("press Restore")
    assert program.accepted == 3
    assert program.answer["says"] == ""


def test_a_clip_that_changes_while_it_is_open_is_noticed(clip, start):
    program = start(clip)
    program.tell("accept", "front")
    assert program.answer["says"] == ""
    os.utime(clip)  # touched, not changed
    program.tell("front")
    assert program.answer["says"] == ""
    clip.write_bytes(clip.read_bytes().replace(b"\r\n", b"\n"))
    program.tell("front")
    assert "has changed on disk" in program.answer["says"]
    assert program.answer["offers"] == ["Open it again", "Keep what is open"]
    program.tell("press Keep what is open", "front")
    assert program.answer["says"] == ""
    program.tell("save")
    assert "belongs to the version that is open" in program.answer["says"]
    program.tell("front", "export", "state")
    assert "This is the version that is open" in program.answer["says"]


def test_a_session_of_another_version_is_kept_when_this_one_is_saved(clip, start):
    program = start(clip)
    program.tell("accept", "accept", "save", "close")
    program.end()
    session = clip.with_name("walk.twist.json")
    old = session.read_bytes()
    clip.write_bytes(clip.read_bytes().replace(b"\r\n", b"\n"))
    program = start(clip)
    assert program.answer["offers"] == ["Carry decisions over"]
    program.tell("accept", "save")
    assert session.with_name("walk.twist.json.earlier").read_bytes() == old
    assert "another review" in program.answer["says"]
    program.tell("accept", "save")
    assert not session.with_name("walk.twist.json.earlier-2").exists()


# -- locks ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text", ["", "garbage\n", "1\npython3\n{here}\n", "{me}\npython3\n{here}\n"]
)
def test_a_lock_that_nobody_holds_locks_nobody_out(clip, start, text):
    """Empty, damaged, or with a process id that is another program's by now."""
    lock = clip.with_name("walk.twist.json.journal.lock")
    lock.write_text(text.format(here=socket.gethostname(), me=os.getpid()))
    program = start(clip)
    program.tell("accept", "save")
    assert program.accepted == 1
    assert program.answer["saved"]


def test_a_lock_from_another_computer_is_named_and_can_be_taken_over(clip, start):
    lock = clip.with_name("walk.twist.json.journal.lock")
    lock.write_text("4711\nTwist Inspector\nelsewhere\n")
    program = start(clip)
    for what in ("4711", "elsewhere", "since"):
        assert what in program.answer["says"]
    assert program.answer["offers"] == ["Take over", "Look only"]
    program.tell("press Look only", "accept")
    assert program.accepted == 0  # looking decides nothing
    assert program.answer["offers"] == ["Take over", "Look only"]
    assert lock.read_text().startswith("4711")
    program.tell("press Take over", "accept", "save")
    assert program.accepted == 1
    assert program.answer["saved"]
    program.tell("close")
    program.end()
    assert beside(clip) == ["walk.twist.json"]


def test_a_window_that_was_robbed_of_its_lock_stops_and_loses_nothing(clip, start):
    one = start(clip)
    one.tell("accept", "accept")
    other = start(clip)
    assert str(one.process.pid) in other.answer["says"]
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
    last = start(clip)
    assert "4 steps were kept" in last.answer["says"]


def test_a_window_that_was_robbed_and_has_not_noticed_harms_nobody(clip, start):
    one = start(clip)
    one.tell("accept", "accept")
    other = start(clip)
    other.tell("press Take over", "press Restore", "accept")
    one.tell("close Discard")  # its own decisions; the other window goes on with a copy
    one.end()
    other.kill()
    assert "3 steps were kept" in start(clip).answer["says"]


def test_a_lock_that_is_a_link_leads_nowhere(clip, start):
    precious = clip.with_name("precious.txt")
    precious.write_text("precious")
    clip.with_name("walk.twist.json.journal.lock").symlink_to(precious)
    start(clip).tell("accept", "save")
    assert precious.read_text() == "precious"


# -- another clip meanwhile -------------------------------------------------------------------


def test_a_note_stays_with_the_clip_it_was_typed_for(clip, start):
    other = Path(shutil.copy(clip, clip.with_name("other.bvh")))
    program = start(other)
    program.tell("note 40", "save", "close")
    program.end()
    program = start(clip)
    program.tell("select", "open other.bvh")
    assert (program.answer["note"], program.answer["saved"]) == (40, True)
    program.tell("select", "open walk.bvh")
    assert (program.answer["note"], program.answer["saved"]) == (0, True)


def test_a_tour_that_was_left_before_it_began_ends_no_review(clip, start):
    program = start(clip)
    program.tell("accept", "tour_and_leave", "accept", "save")
    assert program.answer["saved"]
    assert len(read_session(clip.with_name("walk.twist.json")).state.chosen()) == 2


def test_what_another_window_saves_during_a_tour_is_kept(clip, start):
    one = start(clip)
    one.tell("accept", "save", "tour")
    other = start(clip)
    other.tell("accept", "accept", "accept", "save", "close")
    other.end()
    saved = clip.with_name("walk.twist.json").read_bytes()
    one.tell("leave", "accept 6", "save")
    assert "walk.twist.json.earlier" in one.answer["says"]
    assert clip.with_name("walk.twist.json.earlier").read_bytes() == saved


def test_a_question_does_not_outlive_its_clip(clip, start):
    program = start(clip)
    program.tell("accept", "accept")
    program.kill()
    program = start(clip)
    program.tell("tour")
    assert program.answer["offers"] == []
    program.tell("leave")
    assert program.answer["offers"] == ["Restore", "Discard"]


# -- damage -----------------------------------------------------------------------------------


def test_an_entry_that_is_damaged_costs_none_before_it_and_is_kept(clip, start):
    program = start(clip)
    program.tell("accept", "accept", "accept")
    program.kill()
    journal = clip.with_name("walk.twist.json.journal")
    lines = journal.read_bytes().splitlines(keepends=True)
    lines[2] = lines[2].replace(b'"accepted"', b'"acceptXd"')
    journal.write_bytes(b"".join(lines))
    damaged = journal.read_bytes()
    program = start(clip)
    assert "2 entries are damaged" in program.answer["says"]
    assert "1 step was kept" in program.answer["says"]
    program.tell("press Restore")
    assert program.accepted == 1
    assert journal.with_name("walk.twist.json.journal.damaged").read_bytes() == damaged


@pytest.mark.parametrize(
    "damage",
    [
        ("note", 7),
        ("method", "tarot"),
        ("next_id", 1e999),
        ("stop", 10_000),
        ("chain", "Tail"),
        ("offset_deg", "wide"),
    ],
    ids=lambda d: d[0],
)
def test_a_damaged_session_stops_no_start(clip, start, damage):
    program = start(clip)
    program.tell("accept", "save", "close")
    program.end()
    session = clip.with_name("walk.twist.json")
    document = json.loads(session.read_bytes())
    key, value = damage
    (document if key in document else document["intervals"][0])[key] = value
    session.write_text(json.dumps(document))
    program = start(clip)
    program.tell("accept 7", "save", "select")
    assert program.answer["saved"]
    assert program.process.poll() is None


def test_a_session_that_cannot_be_read_stops_no_start(clip, start):
    clip.with_name("walk.twist.json").mkdir()
    program = start(clip)
    assert "cannot be read" in program.answer["says"]
    program.tell("accept", "save")
    assert program.answer["saved"]
    assert "instead" in program.answer["says"]


def test_a_replay_that_is_opened_takes_no_unanswered_review_away(clip, start):
    program = start(clip)
    program.tell("accept", "accept", "accept", "export")
    program.kill()
    program = start(clip.with_name("walk_refined.replay.json"))
    assert not program.answer["saved"]
    program.tell("close Discard")
    program.end()
    assert "3 steps were kept" in start(clip).answer["says"]


# -- exports ----------------------------------------------------------------------------------


def test_an_export_has_a_session_of_its_own(clip, start):
    program = start(clip)
    program.tell("accept", "export", "close Discard")
    program.end()
    out, replay = (clip.with_name(f"walk_refined.{end}") for end in ("bvh", "replay.json"))
    kept = hashlib.sha256(replay.read_bytes()).digest()
    program = start(out)
    program.tell("accept", "save", "close")
    program.end()
    review = clip.with_name("walk_refined.twist.json")
    reviewed = review.read_bytes()
    assert hashlib.sha256(replay.read_bytes()).digest() == kept
    program = start(clip)
    program.tell("accept", "accept", "export replace")
    assert "changed by up to" in program.answer["says"]
    assert review.read_bytes() == reviewed
    assert hashlib.sha256(replay.read_bytes()).digest() != kept
    program.tell("close Discard")
    program.end()
    program = start(replay)
    assert program.accepted == 2
    program.tell("accept", "save")
    assert len(read_session(replay).state.chosen()) == 2
    assert len(read_session(clip.with_name("walk.twist.json")).state.chosen()) == 3
