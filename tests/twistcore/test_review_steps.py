"""The commands of a review and its history: what each changes, and that it can be undone."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import names_in_one_line, numbers
from tests.twistcore.plain_review import ARM, FOUND, LEG, made, review
from twistcore.errors import FormatError
from twistcore.quamo.tracking_settings import Tracking, tracking_from_json, tracking_to_json
from twistcore.review import (
    Annotate,
    Decide,
    Decision,
    Edit,
    Insert,
    LeaveOut,
    Redetect,
    Remove,
    Sign,
)
from twistcore.review.commands import Track
from twistcore.review.left_out import excluded_spans_from_json, joined_spans, uncovered_parts


def test_decisions_say_who_and_when_and_a_reset_forgets_it():
    done = review()
    done.do(Decide((1, 2), Decision.ACCEPTED, "Ada", "noon", in_bulk=True))
    one = done.state.find(1)
    assert (one.reviewer, one.decided_at, one.in_bulk) == ("Ada", "noon", True)
    assert done.state.find(3).reviewer == ""
    done.do(Decide((1,), Decision.UNDECIDED, "Bo", "later", in_bulk=True))
    one = done.state.find(1)
    assert (one.reviewer, one.decided_at, one.in_bulk) == ("", "", False)
    done.do(Decide((1,), Decision.REJECTED))
    assert not done.state.find(1).in_bulk
    assert done.history == ("Accept 2 intervals", "Reset interval", "Reject interval")
    texts = [Decide((1, 2), d).text for d in (Decision.REJECTED, Decision.UNDECIDED)]
    assert texts == ["Reject 2 intervals", "Reset 2 intervals"]
    assert Decide((1,), Decision.ACCEPTED).text == "Accept interval"
    with pytest.raises(KeyError):
        done.do(Decide((1, 99), Decision.ACCEPTED))
    assert done.position == 3


def test_a_name_is_put_to_what_nobody_has_signed():
    done = review()
    done.do(Decide((1,), Decision.ACCEPTED, "", "1"))
    done.do(Decide((2,), Decision.ACCEPTED, "Bo", "2"))
    command = Sign((1, 2, 3), "Ada")
    assert (command.text, Sign((1,), "Ada").text) == (
        "Add name to 3 decisions",
        "Add name to decision",
    )
    signed = command.apply(done.state)
    assert [signed.find(k).reviewer for k in (1, 2, 3)] == ["Ada", "Bo", ""]
    put = command.signing(done.state)
    assert put(done.state) is put(done.state)
    untouched = review().state
    assert put(untouched) is untouched
    # Decided anew since, at another time: that is another decision.
    again = Decide((1,), Decision.REJECTED, "", "9").apply(done.state)
    assert put(again) is again
    # What somebody has signed by now is not signed anew in a state where nobody had.
    assert Sign((1,), "Cy").signing(signed)(done.state) is done.state
    done.mark_saved()
    done.do(command)
    assert (done.position, done.saved) == (2, False)
    assert done.history == ("Accept interval", "Accept interval")
    done.undo()
    assert done.state.find(1).reviewer == "Ada"
    done.redo()
    assert [done.state.find(k).reviewer for k in (1, 2)] == ["Ada", "Bo"]


def test_edits_stay_in_their_chain_and_have_frames():
    done = review()
    done.do(Edit(3, made(ARM, 70, 75, 370.0)))
    edited = done.state.find(3)
    assert (edited.interval.start, edited.edited) == (70, True)
    np.testing.assert_allclose(np.degrees(edited.interval.offset), 10.0)
    assert [j.id for j in done.state.intervals] == [4, 2, 3, 1, 5]
    done.do(Edit(3, made(ARM, 0, 1)))
    assert numbers(done.undo_text) == [3]
    for wrong, said in (
        (replace(made(ARM, 0, 4), start=-1), "frame"),
        (made(ARM, 4, 4), "frame"),
        (made(LEG, 0, 4), "chain"),
    ):
        with pytest.raises(ValueError, match=said):
            done.do(Edit(3, wrong))
    with pytest.raises(ValueError, match="Insert"):
        done.do(Edit(4, made(ARM, 30, 31)))
    assert done.position == 2


def test_steps_of_one_drag_are_one_step():
    first, same = Edit(3, FOUND[2], drag=7), Edit(3, FOUND[2], drag=7)
    assert same.continues(first)
    for other in (Edit(2, FOUND[1], drag=7), Edit(3, FOUND[2], drag=8), Edit(3, FOUND[2])):
        assert not other.continues(first)
    assert not Edit(3, FOUND[2]).continues(Edit(3, FOUND[2]))
    tau = Redetect({ARM: 0.3}, (), drag=7)
    assert Redetect({ARM: 0.4}, (), drag=7).continues(tau)
    for other in (Redetect({LEG: 0.4}, (), drag=7), Redetect({ARM: 0.4}, (), drag=8), first):
        assert not other.continues(tau)
    assert not tau.continues(first)
    assert not Redetect({ARM: 0.3}, ()).continues(Redetect({ARM: 0.3}, ()))
    assert not Annotate(3, "a").continues(Annotate(3, "b"))

    done = review()
    before = done.state
    done.do(Redetect({ARM: 0.3}, (), drag=7))
    assert [j.interval.chain for j in done.state.intervals] == [LEG, LEG]
    done.do(Redetect({ARM: 0.1}, FOUND[1:4], drag=7))
    [step] = done.history
    assert names_in_one_line(step, "τ", "Arm")
    assert [j.id for j in done.state.intervals] == [3, 4, 2, 1, 5]  # as where the drag began
    assert done.state_before_last is before
    done.undo()
    assert done.state is before


def test_notes_insertions_and_removals():
    done = review()
    done.do(Annotate(3, "odd", "moves so"))
    assert (done.state.find(3).note, done.state.find(3).reason) == ("odd", "moves so")
    done.do(Insert(made(ARM, 0, 4, 370.0)))
    new = done.state.find(6)
    assert (new.by_hand, done.state.next_id, done.state.intervals[0].id) == (True, 7, 6)
    np.testing.assert_allclose(np.degrees(new.interval.offset), 10.0)
    with pytest.raises(ValueError, match="hand-made"):
        done.do(Remove(3))
    done.do(Remove(6))
    assert [j.id for j in done.state.intervals] == [3, 4, 2, 1, 5]
    assert done.state.next_id == 7  # an id is never given twice
    assert [numbers(step) for step in done.history] == [[3], [], [6]]


def test_undone_steps_are_listed_behind_the_done_ones():
    done = review()
    start = done.state
    done.undo()
    done.redo()
    assert (done.position, done.undo_text, done.redo_text, done.saved) == (0, "", "", True)
    assert done.state_after_next is done.state_before_last is start
    done.do(Annotate(3, "a"))
    done.do(Decide((3,), Decision.ACCEPTED))
    last = done.state
    done.undo()
    steps = (done.undo_text, done.redo_text)
    assert numbers(done.undo_text) == [3]
    assert (done.history, done.position) == (steps, 1)
    assert done.state_after_next is last
    done.undo()
    assert done.history == steps
    done.redo()
    done.redo()
    assert done.state is last
    done.undo()
    done.do(Annotate(1, "b"))
    assert done.redo_text == ""
    done.redo()
    assert done.position == 2
    assert repr(done).startswith("<Review, 2 steps: <ReviewState by own")


def test_saved_is_the_state_that_was_written():
    done = review()
    assert done.saved
    done.do(Annotate(3, "a"))
    assert not done.saved
    done.mark_saved()
    assert done.saved
    done.undo()
    assert not done.saved
    done.redo()
    assert done.saved
    done.mark_unsaved()
    assert not done.saved


def test_tracking_needs_something_to_track():
    done = review()
    done.do(Track(Tracking(("Hand",))))
    done.do(Track(Tracking(("Hand", "Foot"), place=True)))
    assert numbers(done.state.tracking.what) == [2]
    done.do(Track(Tracking((), place=True)))
    done.do(Track(None))
    assert done.state.tracking is None
    assert len({*done.history}) == 4
    assert "Hand" in done.history[0]
    with pytest.raises(ValueError, match="joint"):
        done.do(Track(Tracking(())))


def test_tracking_is_written_and_read_back():
    whole = Tracking(("Hand", "Foot"), 1.0, 2.0, 3.0, True, "abc", False, True)
    by_hand = Tracking(("Hand",))
    for tracking in (whole, by_hand):
        assert tracking_from_json(tracking_to_json(tracking)) == tracking
    entry = tracking_to_json(by_hand)
    assert (entry["gains"], tracking_to_json(whole)["gains"]) == ("hand", "learned")
    early = {k: v for k, v in entry.items() if k not in ("causal", "place")}
    assert tracking_from_json(early) == by_hand
    damaged = {
        "causal": 1,
        "place": None,
        "joints": "Hand",
        "gains": "x",
        "ka": math.inf,
        "kp": "k",
    }
    for key, value in damaged.items():
        with pytest.raises(FormatError, match=key):
            tracking_from_json({**entry, key: value})
    with pytest.raises(FormatError, match="kd"):
        tracking_from_json({k: v for k, v in early.items() if k != "kd"})
    with pytest.raises(FormatError, match="joints"):
        tracking_from_json({**entry, "joints": []})
    assert tracking_from_json({**entry, "joints": [], "place": True}).place


def test_frames_left_out_are_joined_where_they_meet():
    assert joined_spans([(5, 8), (0, 2), (2, 3), (6, 7), (7, 9), (10, 11)]) == (
        (0, 3),
        (5, 9),
        (10, 11),
    )
    assert excluded_spans_from_json([[0, 1], (1, 2)]) == ((0, 2),)
    for damaged in ([[1, 2, 3]], [[0, 1.0]], [[2, 1]], [[3, 3]], [[-1, 2]], {"a": 1}, ["ab"], 7):
        with pytest.raises(FormatError, match="left_out"):
            excluded_spans_from_json(damaged)
    done = review()
    done.do(LeaveOut(((0, 1), (1, 4))))
    assert done.state.left_out == ((0, 4),)
    done.do(LeaveOut(()))
    assert len({*done.history}) == 2
    for wrong in ((-1, 3), (4, 4)):
        with pytest.raises(ValueError, match="frame"):
            done.do(LeaveOut((wrong,)))


SPANS = st.lists(st.tuples(st.integers(0, 12), st.integers(1, 5)), max_size=5)


@given(SPANS, SPANS)
def test_what_of_some_spans_is_in_none_of_the_others_by_frames(some, others):
    some, others = ([(a, a + n) for a, n in spans] for spans in (some, others))
    wanted = {f for a, b in some for f in range(a, b)} - {f for a, b in others for f in range(a, b)}
    left = uncovered_parts(some, others)
    assert [f for a, b in left for f in range(a, b)] == sorted(wanted)
