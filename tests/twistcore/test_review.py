"""Decisions, undo, and the session that keeps them."""

import copy
import gc
import json
import pickle
import weakref
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import examples
from tests.twistcore.reviews import CHAINS, CLIP, commands, fresh, redetect, signing
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Interval
from twistcore.detection.interval_offsets import (
    new_constant_offset_interval,
    resized_interval,
    with_offset_making_twist_linear,
    with_offset_of_size,
    with_offset_replaced_by_median,
)
from twistcore.errors import ClipMismatchError, FormatError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.review import (
    Annotate,
    CarryOver,
    Decide,
    Decision,
    Edit,
    Insert,
    Journal,
    Redetect,
    Remove,
    Review,
    Sign,
    read_session,
    replay_journal,
    session_bytes,
    write_session,
)
from twistcore.review.model import overlapping_ids
from twistcore.review.replay import accepted_motion, check_session_fits_clip


def test_nothing_outlives_a_review_that_is_closed():
    analysis = analyse(read_bvh(ASSETS / "walk_injected.bvh"))
    review = Review.of(analysis.detect())
    for tau in (0.2, 0.3, 0.2):
        chain = analysis.chains[2].name
        review.do(Redetect({chain: tau}, analysis.by().intervals(chain, tau)))
    held = weakref.ref(analysis), weakref.ref(review.state.intervals[0].interval)
    assert review.state.intervals[0].interval.evidence  # it knows the analysis
    del analysis, review
    gc.collect()
    assert [ref() for ref in held] == [None, None]


def test_a_written_interval_is_the_same_object_each_time():
    (found, *_) = analyse(CLIP).detect()
    assert found.as_written is found.as_written
    assert "as_written" not in vars(pickle.loads(pickle.dumps(found)))


@settings(max_examples=examples(20))
@given(st.data())
def test_undo_brings_every_state_back_and_redo_does_it_again(data):
    review = fresh()
    states = [review.state]
    for _ in range(data.draw(st.integers(1, 8))):
        review.do(data.draw(commands(review.state)))
        states.append(review.state)
    assert review.position == len(states) - 1
    documents = [session_bytes(CLIP, s) for s in states]
    for expected in reversed(documents[:-1]):
        review.undo()
        assert session_bytes(CLIP, review.state) == expected
    assert review.undo_text == ""
    for expected in documents[1:]:
        review.redo()
        assert session_bytes(CLIP, review.state) == expected
    assert review.redo_text == ""


@settings(max_examples=examples(20))
@given(st.data())
def test_a_name_is_no_step_and_changes_nothing_but_who_decided(data):
    review = fresh()
    for _ in range(data.draw(st.integers(1, 6))):
        review.do(data.draw(commands(review.state)))
    for _ in range(data.draw(st.integers(0, 3))):
        review.undo()

    def walked(twin):
        """All states from the first on, without the names."""
        while twin.undo_text:
            twin.undo()
        states = [session_bytes(CLIP, nameless(twin.state))]
        while twin.redo_text:
            twin.redo()
            states.append(session_bytes(CLIP, nameless(twin.state)))
        return states

    def nameless(state):
        return state.with_intervals(replace(j, reviewer="") for j in state.intervals)

    steps = review.history, review.position
    command = data.draw(signing(review.state))
    expected = session_bytes(CLIP, command.apply(review.state))
    twin = copy.copy(review)
    twin._done, twin._undone = list(review._done), list(review._undone)
    review.do(command)
    assert (review.history, review.position) == steps
    assert session_bytes(CLIP, review.state) == expected
    assert walked(review) == walked(twin)


def test_undo_after_a_name_takes_back_the_decision_and_leaves_the_others_names():
    review = fresh()
    a, b, c = (j.id for j in review.state.intervals[:3])
    review.do(Decide((a,), Decision.ACCEPTED, "", "1"))
    review.mark_saved()
    review.do(Decide((b,), Decision.REJECTED, "", "2"))
    review.do(Decide((c,), Decision.REJECTED, "", "3"))
    review.undo()
    review.do(Sign((a, b), "Ada"))
    assert (review.undo_text, review.redo_text) == ("Reject interval", "Reject interval")
    signed = review.state
    review.redo()
    assert [review.state.find(k).reviewer for k in (a, b, c)] == ["Ada", "Ada", ""]
    review.undo()
    assert review.state is signed
    review.undo()
    assert review.state.find(b).decision == Decision.UNDECIDED
    assert review.state.find(a).reviewer == "Ada"
    assert not review.saved  # without the name, its file is another
    review.undo()
    assert review.state.find(a).decision == Decision.UNDECIDED
    with pytest.raises(KeyError):
        review.do(Sign((999,), "Ada"))


def test_a_rejection_with_its_reason_is_one_step():
    review = fresh()
    one, other, *rest = (j.id for j in review.state.intervals)
    before = review.state
    review.do(Decide((one, other), Decision.REJECTED, "Kim", "then", reason="fast but real"))
    for judged in map(review.state.find, (one, other)):
        said = judged.decision, judged.reason, judged.reviewer, judged.decided_at
        assert said == (Decision.REJECTED, "fast but real", "Kim", "then")
    assert all(review.state.find(k) is before.find(k) for k in rest)
    assert review.history == ("Reject 2 intervals",)
    review.undo()
    assert review.state is before


def test_a_command_that_fails_is_no_step():
    review = fresh()
    before = review.state
    with pytest.raises(KeyError):
        review.do(Decide((999,), Decision.ACCEPTED))
    with pytest.raises(ValueError, match="hand-made"):
        review.do(Remove(before.intervals[0].id))
    assert review.state is before
    assert review.undo_text == ""


def test_a_decided_interval_survives_any_tau():
    review = fresh()
    judged = next(j for j in review.state.intervals if j.interval.chain == "LeftForeArm")
    review.do(Decide((judged.id,), Decision.ACCEPTED, "me", "now"))
    review.do(redetect("LeftForeArm", 179.0))
    kept = review.state.find(judged.id)
    assert (kept.decision, kept.supported) == (Decision.ACCEPTED, False)
    assert len(review.state.of_chain("LeftForeArm")) == 1
    review.do(redetect("LeftForeArm", 5.0))
    back = review.state.find(judged.id)
    assert (back.decision, back.supported) == (Decision.ACCEPTED, True)
    assert len(review.state.of_chain("LeftForeArm")) == 3


def test_an_undecided_interval_keeps_its_id_while_tau_moves():
    review = fresh()
    ids = {j.interval.start: j.id for j in review.state.of_chain("RightUpLeg")}
    review.do(redetect("RightUpLeg", 6.0))
    assert {j.interval.start: j.id for j in review.state.of_chain("RightUpLeg")} == ids


def test_other_chains_keep_what_they_have():
    review = fresh()
    others = [j for j in review.state.intervals if j.interval.chain != "LeftForeArm"]
    review.do(redetect("LeftForeArm", 1.0))
    assert [j for j in review.state.intervals if j.interval.chain != "LeftForeArm"] == others


def test_one_drag_is_one_step_and_two_intervals_never_are():
    review = fresh()
    a, b = (j for j in review.state.intervals[:2])
    for stop in (150, 151, 152):
        review.do(Edit(a.id, resized_interval(a.interval, a.interval.start, stop), drag=1))
    review.do(
        Edit(b.id, resized_interval(b.interval, b.interval.start, b.interval.stop + 1), drag=1)
    )
    review.undo()
    assert review.state.find(a.id).interval.stop == 152
    review.undo()
    assert review.state.find(a.id).interval.stop == a.interval.stop
    assert review.undo_text == ""


def test_resized_keeps_offsets_and_continues_them():
    interval = Interval("c", 10, 13, np.array([0.1, 0.2, 0.3]))
    np.testing.assert_allclose(
        resized_interval(interval, 8, 15).offset, [0.1, 0.1, 0.1, 0.2, 0.3, 0.3, 0.3]
    )
    np.testing.assert_allclose(resized_interval(interval, 11, 12).offset, [0.2])
    assert with_offset_of_size(interval, 1.0).delta == pytest.approx(1.0)


def test_a_session_comes_back_and_replays_to_the_same_bytes(tmp_path):
    review = fresh()
    ids = [j.id for j in review.state.intervals]
    review.do(Decide(tuple(ids[:4]), Decision.ACCEPTED, "Ada", "2026-01-01T00:00:00+00:00"))
    review.do(Decide((ids[4],), Decision.REJECTED, "Ada", "2026-01-01T00:00:01+00:00"))
    review.do(Annotate(ids[4], "a real turn – no error"))
    review.do(
        Edit(
            ids[0],
            with_offset_of_size(review.state.find(ids[0]).interval, 1.234567891234),
        )
    )
    review.do(Insert(new_constant_offset_interval("LeftLeg", 100, 110, -0.7)))
    path = tmp_path / "walk.twist.json"
    write_session(CLIP, review.state, path)
    session = read_session(path)
    check_session_fits_clip(session, CLIP, CHAINS)
    assert session_bytes(CLIP, session.state) == path.read_bytes()

    def exported(state):
        motion = accepted_motion(CLIP, CHAINS, state)
        return create_file_patch_for_motion(CLIP, motion).data

    assert exported(session.state) == exported(review.state)
    assert exported(session.state) != CLIP.data


@pytest.mark.parametrize("offset", [-1e-12, -0.0, 1e-12])
def test_next_to_nothing_is_saved_alike_before_and_after_a_recovery(tmp_path, offset):
    review = fresh()
    traces = np.array([offset, 0.3])
    made = Interval("LeftLeg", 100, 102, traces, residual=offset)
    edited = Interval(review.state.intervals[0].interval.chain, 10, 12, traces, residual=offset)
    with closing(Journal(tmp_path / "j", CLIP, review.state)) as journal:
        for command in (Insert(made), Edit(review.state.intervals[0].id, edited)):
            review.do(command)
            journal.do(command)
    recovered = replay_journal(tmp_path / "j").review.state
    assert session_bytes(CLIP, recovered) == session_bytes(CLIP, review.state)
    write_session(CLIP, recovered, tmp_path / "s")
    saved = (tmp_path / "s").read_bytes()
    assert session_bytes(CLIP, read_session(tmp_path / "s").state) == saved
    assert b"-0.0," not in saved
    older = tmp_path / "older"
    older.write_bytes(saved.replace(b" 0.0,", b" -0.0,"))
    assert older.read_bytes() != saved
    assert session_bytes(CLIP, read_session(older).state) == saved


@pytest.mark.parametrize(
    "damage",
    [
        lambda _: b"{",
        lambda _: b"[]",
        lambda _: b"\xff\xfe",
        lambda d: json.dumps({**json.loads(d), "schema": "other/1"}).encode(),
        lambda d: json.dumps({k: v for k, v in json.loads(d).items() if k != "intervals"}).encode(),
        lambda d: d.replace(b'"undecided"', b'"perhaps"'),
        lambda d: d.replace(b'"stop": 138', b'"stop": 2'),
        lambda d: d.replace(b'"stop": 138', b'"stop": 10000000000000'),
        lambda d: d.replace(b'"next_id": 9', b'"next_id": 1'),
        lambda d: d.replace(b'"fps": 120', b'"fps": 0, "x": 120'),
        lambda d: d.replace(b'"residual_deg": ', b'"offset_deg": NaN, "residual_deg": '),
        lambda d: d.replace(b'"LeftForeArm"', b'["LeftForeArm"]'),
    ],
)
def test_a_damaged_session_is_one_sentence(tmp_path, damage):
    path = tmp_path / "s.json"
    path.write_bytes(damage(session_bytes(CLIP, fresh().state)))
    with pytest.raises(FormatError) as caught:
        read_session(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_session_of_another_clip_is_refused(tmp_path):
    path = tmp_path / "s.json"
    write_session(CLIP, fresh().state, path)
    other = read_bvh(ASSETS / "walk.bvh")
    with pytest.raises(ClipMismatchError, match="another version"):
        check_session_fits_clip(read_session(path), other, CHAINS)
    session = read_session(path)
    with pytest.raises(ClipMismatchError, match="chain"):
        check_session_fits_clip(replace(session, sha256=other.sha256), other, ())


def test_overlapping_intervals_are_named():
    review = fresh()
    first = review.state.intervals[0]
    assert overlapping_ids(review.state.intervals) == frozenset()
    interval = first.interval
    review.do(
        Insert(
            new_constant_offset_interval(interval.chain, interval.stop - 2, interval.stop + 5, 0.1)
        )
    )
    other = review.state.next_id - 1
    assert overlapping_ids(review.state.intervals) == {first.id, other}
    review.do(Decide((other,), Decision.REJECTED))
    assert overlapping_ids(review.state.intervals) == frozenset()


def test_following_takes_a_drift_out():
    theta = np.zeros(100)
    theta[40:60] = np.linspace(0.5, 1.5, 20)
    interval = with_offset_making_twist_linear(
        new_constant_offset_interval("LeftArm", 40, 60, 1.0), theta
    )
    np.testing.assert_allclose(interval.offset, theta[40:60])
    assert np.ptp(with_offset_replaced_by_median(interval).offset) == 0.0
    whole = with_offset_making_twist_linear(
        new_constant_offset_interval("LeftArm", 0, 100, 1.0), theta
    )
    np.testing.assert_allclose(whole.offset, 1.0)


def test_tau_dragged_up_and_back_leaves_everything_as_it_was():
    review = fresh()
    ids = [(j.id, j.interval.start) for j in review.state.intervals]
    for degrees in (10.0, 100.0, 179.0, 50.0, 5.0):
        review.do(redetect("RightUpLeg", degrees, drag=7))
    assert [(j.id, j.interval.start) for j in review.state.intervals] == ids
    review.undo()
    assert review.undo_text == ""


def test_decisions_are_carried_over_to_another_take():
    review, other = fresh(), fresh()
    a, b, *_ = review.state.intervals
    review.do(Decide((a.id,), Decision.ACCEPTED, "Ada", "then"))
    review.do(Annotate(b.id, "look", "motion"))
    review.do(Insert(new_constant_offset_interval("LeftLeg", 10, 20, 0.3)))
    other.do(CarryOver(review.state.intervals))
    state = other.state
    assert (state.find(a.id).decision, state.find(a.id).reviewer) == (Decision.ACCEPTED, "Ada")
    assert (state.find(b.id).note, state.find(b.id).reason) == ("look", "motion")
    assert len(state.intervals) == 9
    assert sum(j.by_hand for j in state.intervals) == 1


def test_carried_over_decisions_never_take_the_place_of_others():
    review, other = fresh(), fresh()
    a, b, c, *_ = review.state.intervals
    review.do(Decide((a.id, b.id), Decision.ACCEPTED, "Ada", "then"))
    review.do(Edit(c.id, resized_interval(c.interval, c.interval.start, c.interval.stop + 2)))
    review.do(Insert(new_constant_offset_interval("LeftLeg", 10, 20, 0.3)))
    other.do(Decide((b.id,), Decision.REJECTED, "Bob", "now"))
    for _ in range(2):  # a second time adds nothing
        other.do(CarryOver(review.state.intervals, same_clip=True))
        state = other.state
        assert state.find(a.id).reviewer == "Ada"
        assert (state.find(b.id).decision, state.find(b.id).reviewer) == (Decision.REJECTED, "Bob")
        assert state.find(c.id).interval.stop == c.interval.stop + 2
        assert state.find(c.id).edited
        assert len(state.intervals) == 9


def test_of_the_same_clip_a_decision_without_its_interval_stays_and_says_so():
    review, other = fresh(), fresh()
    (first, *_) = review.state.of_chain("LeftForeArm")
    review.do(Decide((first.id,), Decision.ACCEPTED, "Ada", "then"))
    other.do(Redetect({"LeftForeArm": 3.0}, ()))
    other.do(CarryOver(review.state.intervals))
    assert other.state.of_chain("LeftForeArm") == ()  # in another take the error may be gone
    other.do(CarryOver(review.state.intervals, same_clip=True))
    (kept,) = other.state.of_chain("LeftForeArm")
    assert (kept.decision, kept.supported) == (Decision.ACCEPTED, False)


def test_a_kept_interval_hides_no_other():
    review = fresh()
    review.do(Redetect({"LeftLeg": 0.1}, (new_constant_offset_interval("LeftLeg", 100, 103, 0.5),)))
    small = review.state.of_chain("LeftLeg")[0]
    review.do(Decide((small.id,), Decision.REJECTED))
    review.do(
        Redetect({"LeftLeg": 0.05}, (new_constant_offset_interval("LeftLeg", 102, 340, 0.5),))
    )
    spans = [(j.interval.start, j.interval.stop) for j in review.state.of_chain("LeftLeg")]
    assert spans == [(100, 103), (102, 340)]


def test_a_kept_interval_stands_for_its_fragments():
    review = fresh()
    review.do(Redetect({"LeftLeg": 0.1}, (new_constant_offset_interval("LeftLeg", 100, 150, 0.5),)))
    whole = review.state.of_chain("LeftLeg")[0]
    review.do(Decide((whole.id,), Decision.ACCEPTED))
    halves = (
        new_constant_offset_interval("LeftLeg", 100, 120, 0.5),
        new_constant_offset_interval("LeftLeg", 120, 150, 0.5),
    )
    review.do(Redetect({"LeftLeg": 0.05}, halves))
    (only,) = review.state.of_chain("LeftLeg")
    assert (only.id, only.supported) == (whole.id, True)


def test_a_decision_is_carried_over_from_the_one_that_shares_most_frames():
    review, other = fresh(), fresh()
    near, far = (
        new_constant_offset_interval("LeftLeg", 100, 112, 0.5),
        new_constant_offset_interval("LeftLeg", 112, 150, 0.5),
    )
    review.do(Redetect({"LeftLeg": 0.1}, (near, far)))
    first, second = review.state.of_chain("LeftLeg")
    review.do(Decide((first.id,), Decision.REJECTED, "Ada", "then"))
    review.do(Decide((second.id,), Decision.ACCEPTED, "Bob", "then"))
    other.do(Redetect({"LeftLeg": 0.1}, (new_constant_offset_interval("LeftLeg", 105, 150, 0.5),)))
    other.do(CarryOver(review.state.intervals))
    (found,) = other.state.of_chain("LeftLeg")
    assert (found.decision, found.reviewer) == (Decision.ACCEPTED, "Bob")


def test_what_a_person_made_needs_no_detector_and_what_he_edited_does():
    review = fresh()
    review.do(Redetect({"LeftLeg": 0.1}, (new_constant_offset_interval("LeftLeg", 100, 150, 0.5),)))
    (found,) = review.state.of_chain("LeftLeg")
    review.do(Edit(found.id, resized_interval(found.interval, 100, 140)))
    review.do(Insert(new_constant_offset_interval("LeftLeg", 10, 20, 0.3)))
    review.do(Redetect({"LeftLeg": 3.0}, ()))
    made, edited = review.state.of_chain("LeftLeg")
    assert (made.by_hand, made.supported) == (True, True)
    assert (edited.edited, edited.supported) == (True, False)
    # nor does the detector's word for a neighbour count for the hand-made one
    review.do(Redetect({"LeftLeg": 0.1}, (new_constant_offset_interval("LeftLeg", 98, 142, 0.5),)))
    assert [j.supported for j in review.state.of_chain("LeftLeg")] == [True, True]
