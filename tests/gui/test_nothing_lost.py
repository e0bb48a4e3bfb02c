"""The program killed, damaged or on another clip meanwhile: every decision is there again."""

import hashlib
import json
import os
import shutil
from pathlib import Path

import pytest

from tests.gui.programs import beside
from twistcore.review import read_session

pytestmark = pytest.mark.thorough

# -- kill, restore, kill ----------------------------------------------------------------------


def test_restored_and_killed_again_it_is_offered_again(clip, start, start_here):
    first = start(clip)
    first.tell("accept", "accept", "accept")
    first.kill()
    for _ in range(3):
        program = start_here(clip)
        assert "3 steps" in program.answer["says"]
        assert program.answer["offers"] == ["Restore", "Discard"]
        program.tell("press Restore")
        assert program.accepted == 3
        assert not program.answer["saved"]
        program.kill()
    program = start_here(clip)
    program.tell("press Restore", "accept", "undo", "undo")
    assert program.accepted == 2
    program.kill()
    last = start_here(clip)
    assert "6 steps" in last.answer["says"]
    last.tell("press Restore")
    assert last.accepted == 2
    last.tell("save")
    assert last.answer["saved"]
    assert beside(clip) == ["walk.twist.json", "walk.twist.json.journal.lock"]


def test_an_undo_of_what_was_saved_survives_a_restore_that_is_closed(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "accept", "save", "undo")
    program.kill()
    program = start_here(clip)
    program.tell("press Restore")
    assert program.accepted == 1
    assert not program.answer["saved"]  # the session on disk says otherwise
    program.tell("close Save")
    program.end()
    assert start_here(clip).accepted == 1


def test_a_bar_that_was_ignored_asks_again_and_no_leftover_hides_another(clip, start_here):
    first = start_here(clip)
    first.tell("accept", "accept", "accept")
    first.kill()
    second = start_here(clip)
    assert second.answer["offers"] == ["Restore", "Discard"]
    second.tell("accept 3")  # not answered; the fourth is judged instead
    assert second.accepted == 1
    second.kill()
    names = [n for n in beside(clip) if not n.endswith(".lock")]
    assert names == ["walk.twist.json.journal", "walk.twist.json.journal-2"]
    third = start_here(clip)
    assert "1 step" in third.answer["says"]
    third.tell("press Restore")
    assert third.accepted == 1
    assert "Another review" in third.answer["says"]
    assert "3 steps" in third.answer["says"]
    third.tell("press Add decisions")
    assert third.accepted == 4
    third.kill()
    last = start_here(clip)
    last.tell("press Restore")
    assert last.accepted == 4
    assert last.answer["says"] == ""


def test_restoring_beside_decisions_made_since_adds_to_them(clip, start_here):
    first = start_here(clip)
    first.tell("accept", "accept")
    first.kill()
    second = start_here(clip)
    second.tell("accept 4", "press Restore")
    assert second.accepted == 3
    second.tell("undo")
    assert second.accepted == 1


# -- names that are not UTF-8 -----------------------------------------------------------------


@pytest.mark.skipif(os.name == "nt", reason="names are text there")
def test_a_joint_and_a_path_in_other_bytes_than_utf_8(clip, start_here, capfd):
    folder = Path(os.fsdecode(os.fsencode(clip.parent) + b"/\xfcbung"))
    folder.mkdir()
    other = folder / os.fsdecode(b"w\xe4lk.bvh")
    text = clip.read_bytes()
    other.write_bytes(text.replace(b"LeftForeArm", b"Unterarm \xfc"))
    program = start_here(other)
    program.tell("accept", "accept", "accept")
    assert program.answer["says"] == ""
    (journal,) = [p for p in folder.iterdir() if p.name.endswith(".journal")]
    assert b"Unterarm \\udcfc" in journal.read_bytes()
    program.kill()
    program = start_here(other)
    program.tell("press Restore")
    assert program.accepted == 3
    program.tell("close Save")
    program.end()
    (session,) = folder.glob("*.twist.json")
    assert json.loads(session.read_bytes().decode())["intervals"][0]["decision"] == "accepted"
    assert read_session(session).state.intervals[0].interval.chain == "Unterarm \udcfc"
    assert start_here(other).accepted == 3
    assert "Traceback" not in capfd.readouterr().err


# -- another clip meanwhile -------------------------------------------------------------------


def test_a_note_stays_with_the_clip_it_was_typed_for(clip, start_here):
    other = Path(shutil.copy(clip, clip.with_name("other.bvh")))
    program = start_here(other)
    program.tell("note 40", "save", "close")
    program.end()
    program = start_here(clip)
    program.tell("select", "open other.bvh")
    assert (program.answer["note"], program.answer["saved"]) == (40, True)
    program.tell("select", "open walk.bvh")
    assert (program.answer["note"], program.answer["saved"]) == (0, True)


def test_a_tour_that_was_left_before_it_began_ends_no_review(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "tour_and_leave", "accept", "save")
    assert program.answer["saved"]
    assert len(read_session(clip.with_name("walk.twist.json")).state.chosen()) == 2


def test_what_another_window_saves_during_a_tour_is_kept(clip, start, start_here):
    one = start_here(clip)
    one.tell("accept", "save", "tour")
    other = start(clip)
    other.tell("accept", "accept", "accept", "save", "close")
    other.end()
    saved = clip.with_name("walk.twist.json").read_bytes()
    one.tell("leave", "accept 6", "save")
    assert "walk.twist.json.earlier" in one.answer["says"]
    assert clip.with_name("walk.twist.json.earlier").read_bytes() == saved


def test_a_question_does_not_outlive_its_clip(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "accept")
    program.kill()
    program = start_here(clip)
    program.tell("tour")
    assert program.answer["offers"] == []
    program.tell("leave")
    assert program.answer["offers"] == ["Restore", "Discard"]


# -- damage -----------------------------------------------------------------------------------


def test_an_entry_that_is_damaged_costs_none_before_it_and_is_kept(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "accept", "accept")
    program.kill()
    journal = clip.with_name("walk.twist.json.journal")
    lines = journal.read_bytes().splitlines(keepends=True)
    lines[2] = lines[2].replace(b'"accepted"', b'"acceptXd"')
    journal.write_bytes(b"".join(lines))
    damaged = journal.read_bytes()
    program = start_here(clip)
    assert ": 2. " in program.answer["says"]
    assert "1 step" in program.answer["says"]
    program.tell("press Restore")
    assert program.accepted == 1
    assert journal.with_name("walk.twist.json.journal.damaged").read_bytes() == damaged


@pytest.mark.parametrize(
    "damage",
    [
        ("note", 7),
        ("method", "tarot"),
        ("stop", 10_000),
        ("chain", "Tail"),
    ],
    ids=lambda d: d[0],
)
def test_a_damaged_session_stops_no_start(clip, start_here, damage):
    program = start_here(clip)
    program.tell("accept", "save", "close")
    program.end()
    session = clip.with_name("walk.twist.json")
    document = json.loads(session.read_bytes())
    key, value = damage
    (document if key in document else document["intervals"][0])[key] = value
    session.write_text(json.dumps(document))
    program = start_here(clip)
    program.tell("accept 7", "save", "select")
    assert program.answer["saved"]
    assert program.answer["open"]


def test_a_session_that_cannot_be_read_stops_no_start(clip, start_here):
    clip.with_name("walk.twist.json").mkdir()
    program = start_here(clip)
    assert program.answer["says"]
    program.tell("accept", "save")
    assert program.answer["saved"]
    assert "twist-inspector" in program.answer["says"]  # the folder it is kept in


def test_a_replay_that_is_opened_takes_no_unanswered_review_away(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "export", "accept", "accept", "accept")
    program.kill()
    program = start_here(clip.with_name("walk_refined.replay.json"))
    assert not program.answer["saved"]
    program.tell("close Discard")
    program.end()
    assert "3 steps" in start_here(clip).answer["says"]


# -- exports ----------------------------------------------------------------------------------


def test_an_export_has_a_session_of_its_own(clip, start_here):
    program = start_here(clip)
    program.tell("accept", "export", "close")  # the session went with it
    program.end()
    out, replay = (clip.with_name(f"walk_refined.{end}") for end in ("bvh", "replay.json"))
    kept = hashlib.sha256(replay.read_bytes()).digest()
    program = start_here(out)
    program.tell("accept", "save", "close")
    program.end()
    review = clip.with_name("walk_refined.twist.json")
    reviewed = review.read_bytes()
    assert hashlib.sha256(replay.read_bytes()).digest() == kept
    program = start_here(clip)
    program.tell("accept", "accept", "export replace")
    assert program.answer["says"]
    assert review.read_bytes() == reviewed
    assert hashlib.sha256(replay.read_bytes()).digest() != kept
    program.tell("close")
    program.end()
    program = start_here(replay)
    assert program.accepted == 3
    program.tell("accept", "save")
    assert len(read_session(replay).state.chosen()) == 3
    assert len(read_session(clip.with_name("walk.twist.json")).state.chosen()) == 4
