"""The journal of a review: what is decided is on disk, whatever becomes of the program."""

import json
from contextlib import closing

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from tests.twistcore.reviews import CLIP, commands, fresh, signing
from twistcore.errors import FormatError
from twistcore.review import Annotate, Decide, Decision, Journal, replay_journal, session_bytes
from twistcore.review.journal import session_journal_entry


@settings(max_examples=examples(25))
@given(st.data())
def test_a_journal_cut_anywhere_gives_back_every_whole_command(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("journal") / "walk.twist.journal"
    review = fresh()
    states = [session_bytes(CLIP, review.state)]
    with closing(Journal(path, CLIP, review.state)) as journal:
        for _ in range(data.draw(st.integers(1, 6))):
            step = data.draw(st.sampled_from(["do", "do", "do", "undo", "redo"]))
            if step == "do":
                command = data.draw(st.one_of(commands(review.state), signing(review.state)))
                review.do(command)
                journal.do(command)
            else:
                (review.undo if step == "undo" else review.redo)()
                journal.append({step: True})
            states.append(session_bytes(CLIP, review.state))
    whole = path.read_bytes()
    assert session_bytes(CLIP, replay_journal(path).review.state) == states[-1]
    head = whole.index(b"\n") + 1
    cut = data.draw(st.integers(head, len(whole)))
    path.write_bytes(whole[:cut])
    back = replay_journal(path)
    assert back.entries == whole[:cut].count(b"\n") - 1
    assert back.damaged == 0
    assert session_bytes(CLIP, back.review.state) == states[back.entries]


def test_a_journal_is_gone_on_with_where_it_was_cut(tmp_path):
    path = tmp_path / "j"
    review = fresh()
    with closing(Journal(path, CLIP, review.state, steps=3)) as journal:
        for judged in review.state.intervals[:2]:
            journal.do(Decide((judged.id,), Decision.ACCEPTED, "me", "now"))
    whole = path.read_bytes()
    with pytest.raises(FileExistsError):
        Journal(path, CLIP, review.state)
    path.write_bytes(whole + b'{"do": "Deci')
    back = replay_journal(path)
    assert (back.entries, back.steps, back.damaged) == (2, 5, 0)
    with closing(Journal.resume(back)) as journal:
        assert path.read_bytes() == whole
        third = back.review.state.intervals[2]
        journal.do(Decide((third.id,), Decision.REJECTED, "me", "now"))
    assert path.read_bytes().startswith(whole)
    assert replay_journal(path).steps == 6
    assert not back.review.saved  # whatever it began with, no session file has it


def test_what_a_full_disk_refuses_goes_before_the_next_entry(tmp_path, monkeypatch):
    path = tmp_path / "j"
    review = fresh()
    first, second, third, *_ = review.state.intervals
    with closing(Journal(path, CLIP, review.state)) as journal:
        journal.do(Decide((first.id,), Decision.ACCEPTED))
        good = path.read_bytes()
        with monkeypatch.context() as patch:
            patch.setattr("os.fsync", lambda _: (_ for _ in ()).throw(OSError(28, "full")))
            for judged in (second, third):
                with pytest.raises(OSError, match="full"):
                    journal.do(Decide((judged.id,), Decision.ACCEPTED))
                assert path.read_bytes() == good
        assert journal.waiting == 2
        journal.write_waiting()
        assert journal.waiting == 0
    assert replay_journal(path).steps == 3


def test_a_journal_that_took_another_s_place_is_not_deleted(tmp_path):
    path = tmp_path / "j"
    journal = Journal(path, CLIP, fresh().state)
    assert journal.is_there()
    path.unlink()
    path.write_bytes(b"another window's")
    assert not journal.is_there()
    journal.discard()
    assert path.read_bytes() == b"another window's"


def test_a_journal_damaged_in_the_middle_keeps_what_stands_before(tmp_path):
    path = tmp_path / "j"
    review = fresh()
    journal = Journal(path, CLIP, review.state)
    for judged in review.state.intervals[:4]:
        journal.do(Decide((judged.id,), Decision.ACCEPTED, "me", "now"))
    journal.close()
    lines = path.read_bytes().split(b"\n")
    lines[3] = lines[3][:10] + b"\x00\xff" + lines[3][12:]
    path.write_bytes(b"\n".join(lines))
    back = replay_journal(path)
    assert (back.entries, back.damaged) == (2, 2)
    accepted = [j for j in back.review.state.intervals if j.decision == Decision.ACCEPTED]
    assert len(accepted) == 2
    damaged = path.read_bytes()
    Journal.resume(back).close()
    assert replay_journal(path).damaged == 0
    assert path.with_name("j.damaged").read_bytes() == damaged
    path.write_bytes(b"nonsense\n")
    with pytest.raises(FormatError, match="journal"):
        replay_journal(path)


def test_a_journal_that_begins_with_frames_behind_the_last_is_damaged(tmp_path):
    path = tmp_path / "j"
    Journal(path, CLIP, fresh().state).close()
    head = json.loads(path.read_bytes())
    head["session"]["intervals"][0]["stop"] = CLIP.motion.frames + 1
    path.write_text(json.dumps(head) + "\n")
    replay_journal(path)  # without its clip nothing is known of its frames
    with pytest.raises(FormatError, match="the first line is damaged"):
        replay_journal(path, CLIP)


def test_an_entry_of_a_later_version_ends_the_replay_and_is_kept_beside(tmp_path):
    path = tmp_path / "j"
    a, b, *_ = fresh().state.intervals
    with closing(Journal(path, CLIP, fresh().state)) as journal:
        journal.do(Decide((a.id,), Decision.ACCEPTED, "me", "now"))
        journal.append({"do": "Reconsider", "ids": [a.id]})
        journal.do(Decide((b.id,), Decision.ACCEPTED, "me", "now"))
    whole = path.read_bytes()
    back = replay_journal(path)
    assert (back.entries, back.damaged) == (1, 2)
    assert back.review.state.find(a.id).decision == Decision.ACCEPTED
    Journal.resume(back).close()
    assert path.with_name("j.damaged").read_bytes() == whole
    assert replay_journal(path).damaged == 0


def test_a_journal_s_whole_state_takes_the_place_of_what_came_before(tmp_path):
    path = tmp_path / "j"
    review, other = fresh(), fresh()
    a, b, *_ = review.state.intervals
    other.do(Decide((b.id,), Decision.ACCEPTED, "Bob", "now"))
    with closing(Journal(path, CLIP, review.state)) as journal:
        journal.do(Decide((a.id,), Decision.REJECTED, "Ada", "then"))
        journal.append(session_journal_entry(CLIP, other.state))
        journal.do(Annotate(a.id, "seen", ""))
    other.do(Annotate(a.id, "seen", ""))
    back = replay_journal(path).review
    assert session_bytes(CLIP, back.state) == session_bytes(CLIP, other.state)
    back.undo()
    assert back.state.find(b.id).decision == Decision.ACCEPTED
    assert not back.saved
