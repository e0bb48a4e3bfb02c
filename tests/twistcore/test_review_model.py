"""A review's state, commands and history on intervals made here: no clip is read."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from twistcore.detection import Interval, Kind
from twistcore.errors import FormatError
from twistcore.review import (
    Annotate,
    CarryOver,
    Decide,
    Decision,
    Edit,
    Insert,
    LeaveOut,
    Redetect,
    Remove,
    Review,
    Sign,
    start_review,
)
from twistcore.review.commands import ChangeChains, Track
from twistcore.review.left_out import joined, spans_from_json
from twistcore.review.model import (
    Judged,
    ReviewState,
    Tracking,
    as_written,
    carried_over,
    constant,
    following,
    levelled,
    off_line,
    overlapping,
    resized,
)
from twistcore.review.reasons import found_again, with_reasons
from twistcore.review.session import tracking_from_json, tracking_to_json
from twistcore.rig import AS_FOUND, Rig

ARM, LEG = "Arm", "Leg"
JUMP = Kind.LONE_JUMP


def made(chain, start, stop, degrees=10.0, **more):
    return replace(constant(chain, start, stop, np.radians(degrees)), **more)


FOUND = (
    made(LEG, 5, 9, confidence=0.9),
    made(ARM, 50, 60, confidence=0.3),
    made(ARM, 10, 20, confidence=0.5),
    made(ARM, 30, 31, kind=JUMP, residual=1.0, confidence=0.9),
    made(LEG, 40, 44, confidence=0.8, open=True),
)


def review():
    """Ids by chain order and start: Arm 3, 4, 2, Leg 1, 5."""
    return Review(start_review("own", {ARM: 0.1, LEG: 0.2}, FOUND, (ARM, LEG)))


def decided(state):
    return {j.id: j.decision.value for j in state.intervals if j.decision != Decision.UNDECIDED}


def test_a_review_begins_in_the_order_of_chains_and_frames():
    state = review().state
    assert [j.id for j in state.intervals] == [3, 4, 2, 1, 5]
    assert (state.next_id, state.method, dict(state.tau)) == (6, "own", {ARM: 0.1, LEG: 0.2})
    assert [j.id for j in state.of_chain(LEG)] == [1, 5]
    assert repr(state) == "<ReviewState by own: 0 of 5 decided>"
    assert state.find(4).interval.kind == JUMP
    with pytest.raises(KeyError):
        state.find(99)
    # A chain that is in no list comes last.
    other = state.with_intervals([*state.intervals, Judged(9, made("Beyond", 0, 3))], next_id=12)
    assert ([j.id for j in other.intervals][-1], other.next_id) == (9, 12)
    assert state.with_intervals(()).next_id == 6


class Found(tuple):
    """What a review asks a detection for."""

    method, tau = "own", {ARM: 0.1, LEG: 0.2}
    chains_and_limbs = (SimpleNamespace(name=ARM), SimpleNamespace(name=LEG))
    analysis = SimpleNamespace(rig=Rig(remove=("Gone",)))


def test_a_review_of_what_was_detected():
    state, same = Review.of(Found(FOUND)).state, review().state
    assert (state.method, dict(state.tau)) == (same.method, dict(same.tau))
    assert state.rig is Found.analysis.rig
    assert dict(state.chain_order) == {ARM: 0, LEG: 1}
    assert [j.id for j in state.intervals] == [3, 4, 2, 1, 5]


def test_verdicts_as_they_are_told():
    plain, jump = Judged(1, FOUND[0]), Judged(2, FOUND[3])
    accepted = {"decision": Decision.ACCEPTED}
    assert plain.verdict == "undecided"
    assert replace(plain, decision=Decision.REJECTED).verdict == "rejected"
    assert replace(plain, **accepted).verdict == "applied automatically"
    assert replace(plain, reviewer="Ada", **accepted).verdict == "accepted"
    assert replace(plain, decided_at="2026-01-01", **accepted).verdict == "accepted"
    assert replace(jump, reviewer="Ada", **accepted).verdict == "seen"


def test_what_a_person_has_put_work_into_is_kept():
    plain = Judged(1, FOUND[0])
    assert not plain.kept
    for work in ({"by_hand": True}, {"edited": True}, {"note": "x"}, {"reason": "x"}):
        assert replace(plain, **work).kept
    for decision in (Decision.ACCEPTED, Decision.REJECTED):
        assert replace(plain, decision=decision).kept
    assert not replace(plain, reviewer="Ada", supported=False).kept


def test_the_same_frames_of_the_same_kind_unless_rejected():
    done = review()
    assert done.state.same_frames(made(ARM, 10, 20)).id == 3
    for other in (made(ARM, 10, 21), made(ARM, 11, 20), made(LEG, 10, 20)):
        assert done.state.same_frames(other) is None
    assert done.state.same_frames(made(ARM, 10, 20, kind=Kind.LIMB_FLIP)) is None
    done.do(Decide((3,), Decision.REJECTED))
    assert done.state.same_frames(made(ARM, 10, 20)) is None


def test_what_is_taken_out():
    done = review()
    done.do(Decide((1, 4), Decision.ACCEPTED))
    done.do(Decide((2,), Decision.REJECTED))
    assert [(i.chain, i.start) for i in done.accepted] == [(LEG, 5)]
    also_open = done.state.chosen(undecided=True)
    assert [(i.chain, i.start) for i in also_open] == [(ARM, 10), (LEG, 5), (LEG, 40)]


def test_what_may_be_accepted_without_a_look():
    done = review()
    assert done.state.unasked() == (3, 1)  # half sure is sure enough
    assert done.state.unasked(0.6) == (1,)
    assert done.state.unasked(0.6, include_open=True) == (1, 5)
    assert done.state.unasked(confidence=lambda _: 1.0) == (3, 2, 1)
    assert review().accept(0.6) == 1
    assert done.accept(0.6, include_open=True) == 2
    assert decided(done.state) == {1: "accepted", 5: "accepted"}
    assert done.accept(0.6, include_open=True) == 0
    assert done.position == 1
    assert done.accept() == 1
    assert done.history == ("Accept 2 intervals", "Accept interval")


def test_from_one_interval_to_the_next_round_the_end():
    done = review()
    step = done.state.neighbour
    assert [step(k, 1) for k in (3, 4, 2, 1, 5)] == [4, 2, 1, 5, 3]
    assert [step(k, -1) for k in (3, 4, 2, 1, 5)] == [5, 3, 4, 2, 1]
    assert (step(None, 1), step(None, -1)) == (3, 5)
    assert (step(1, 1, order=(5, 1, 77, 2)), step(1, -1, order=(5, 1, 77, 2))) == (2, 5)
    assert step(None, 1, order=(77, 5)) == 5
    done.do(Decide((4, 2), Decision.REJECTED))
    assert done.state.neighbour(3, 1) == 4
    assert done.state.neighbour(3, 1, undecided=True) == 1
    assert done.state.neighbour(4, 1, undecided=True) == 1  # from a decided one, too
    done.do(Decide((1, 3, 5), Decision.ACCEPTED))
    assert done.state.neighbour(None, 1, undecided=True) is None
    assert done.state.neighbour(3, 1, undecided=True) == 3


def test_offsets_are_held_as_files_hold_them():
    written = as_written(made(ARM, 0, 3, 370.0))
    np.testing.assert_allclose(np.degrees(written.offset), 10.0, atol=1e-12)
    fine = replace(FOUND[0], offset=np.radians([1.00000000049, -1e-12, 2.0, 3.0]))
    degrees = np.degrees(as_written(fine).offset)
    np.testing.assert_allclose(degrees, [1.0, 0.0, 2.0, 3.0], rtol=0, atol=1e-13)
    assert math.copysign(1.0, as_written(fine).offset[1]) == 1.0


def test_resized_intervals_keep_their_offsets_and_take_the_nearest():
    ramp = replace(made(ARM, 10, 14), offset=np.array([0.1, 0.2, 0.3, 0.4]))
    wider = resized(ramp, 8, 16)
    assert (wider.start, wider.stop) == (8, 16)
    np.testing.assert_array_equal(wider.offset, [0.1, 0.1, 0.1, 0.2, 0.3, 0.4, 0.4, 0.4])
    np.testing.assert_array_equal(resized(ramp, 11, 13).offset, [0.2, 0.3])


def test_a_level_is_moved_and_a_soft_course_stretched():
    flat = replace(made(ARM, 0, 4), offset=np.array([0.9, 1.0, 1.0, 1.2]))
    moved = levelled(flat, 1.5)
    np.testing.assert_allclose(moved.offset, [1.4, 1.5, 1.5, 1.7])
    over = levelled(flat, math.pi)
    np.testing.assert_allclose(over.offset[:3], [math.pi - 0.1, math.pi, math.pi])
    assert over.offset[3] == pytest.approx(0.2 - math.pi)
    soft = replace(made(ARM, 0, 4), offset=np.array([0.1, 0.5, 1.0, 0.2]))
    np.testing.assert_allclose(levelled(soft, -2.0).offset, [-0.2, -1.0, -2.0, -0.4])


def test_twist_off_the_line_between_its_neighbours():
    theta = np.array([0.0, 0.1, 0.7, 0.8, 0.4, 0.5])
    np.testing.assert_allclose(off_line(theta, 2, 4), [0.5, 0.5])
    np.testing.assert_allclose(off_line(theta, 0, 2), [-0.7, -0.6])  # level at an end
    np.testing.assert_allclose(off_line(theta, 4, 6), [-0.4, -0.3])
    np.testing.assert_allclose(off_line(theta, 0, 6), theta - 0.5)  # all of the clip
    # The shorter way round.
    turned = np.array([3.0, 0.0, -3.0])
    assert off_line(turned, 1, 2) == pytest.approx([math.pi])
    followed = following(made(ARM, 2, 4), theta)
    np.testing.assert_allclose(followed.offset, [0.5, 0.5])
    assert (followed.start, followed.stop) == (2, 4)
    whole = made(ARM, 0, 6)
    assert following(whole, theta) is whole


def test_intervals_that_share_frames_add():
    def judged(k, start, stop, **more):
        chain = more.pop("chain", ARM)
        decision = more.pop("decision", Decision.UNDECIDED)
        return Judged(k, made(chain, start, stop, **more), decision)

    assert overlapping([judged(1, 0, 10), judged(2, 10, 12)]) == frozenset()
    assert overlapping([judged(2, 9, 12), judged(1, 0, 10)]) == {1, 2}
    assert overlapping([judged(1, 0, 10), judged(2, 5, 6), judged(3, 8, 9)]) == {1, 2, 3}
    assert overlapping([judged(1, 0, 10), judged(2, 5, 20), judged(3, 15, 16)]) == {1, 2, 3}
    assert overlapping([judged(1, 0, 10), judged(2, 5, 6, chain=LEG)]) == frozenset()
    assert overlapping([judged(1, 0, 9), judged(2, 5, 6, decision=Decision.REJECTED)]) == set()
    assert overlapping([judged(1, 0, 9), judged(2, 5, 6, kind=JUMP)]) == frozenset()


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
    assert (command.text, Sign((1,), "Ada").text) == ("Sign 3 decisions", "Sign decision")
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
    assert done.undo_text == "Edit interval 3"
    for wrong, said in (
        (replace(made(ARM, 0, 4), start=-1), "at least one frame"),
        (made(ARM, 4, 4), "at least one frame"),
        (made(LEG, 0, 4), "another chain"),
    ):
        with pytest.raises(ValueError, match=said):
            done.do(Edit(3, wrong))
    with pytest.raises(ValueError, match="lone jump"):
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
    assert done.history == ("Set τ of Arm",)
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
    assert done.history == ("Note on interval 3", "New interval", "Remove interval 6")


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
    assert (done.undo_text, done.redo_text) == ("Note on interval 3", "Accept interval")
    assert (done.history, done.position) == (("Note on interval 3", "Accept interval"), 1)
    assert done.state_after_next is last
    done.undo()
    assert done.history == ("Note on interval 3", "Accept interval")
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


def test_reasons_are_told_again_of_what_was_found_alike():
    done = review()
    done.do(Annotate(2, "a"))
    done.do(Insert(made(LEG, 70, 75)))
    done.mark_saved()
    done.undo()
    done.redo()
    why = {"sigma_deg": 1.0}
    found = [replace(i, explain=lambda: why) for i in FOUND[:3]]
    other = replace(made(LEG, 40, 44, kind=Kind.LIMB_FLIP), explain=lambda: why)
    by_hand = replace(made(LEG, 70, 75), explain=lambda: why)
    done.take_reasons([*found, other, by_hand, FOUND[3]])
    told = {j.id: j.interval.evidence for j in done.state.intervals}
    assert told == {1: why, 2: why, 3: why, 4: None, 5: None, 6: None}
    assert (done.saved, done.position) == (True, 2)
    state = done.state
    done.take_reasons([replace(i, explain=dict) for i in FOUND])
    assert done.state.find(1) is state.find(1)  # knows its own
    assert done.state.find(4).interval.evidence == {}
    same = done.state
    assert with_reasons([])(same) is same
    done.undo()
    assert done.state.find(2).interval.evidence == why
    done.mark_unsaved()
    done.take_reasons(found)
    assert not done.saved


@pytest.mark.parametrize("ready", [True, False])
def test_a_detector_that_is_not_ready_is_asked_for_flips_alone(ready):
    asked = []

    def detector(method, kinds):
        asked.append((method, kinds))
        return SimpleNamespace(intervals=lambda name, tau: [(name, tau), name])

    analysis = SimpleNamespace(
        kept=lambda method: method if ready and method == "own" else None,
        detector=detector,
        chains_and_limbs=(SimpleNamespace(name=LEG), SimpleNamespace(name="Beyond")),
    )
    assert found_again(analysis, review().state) == ((LEG, 0.2), LEG)
    assert asked == [("own", frozenset(Kind) if ready else {Kind.LIMB_FLIP})]


def test_at_another_tau_what_was_decided_stands_for_what_is_the_same_or_inside():
    def after(*found, decision=Decision.ACCEPTED):
        done = Review(start_review("own", {ARM: 0.1}, [made(ARM, 100, 110)], (ARM,)))
        if decision:
            done.do(Decide((1,), decision))
        done.do(Redetect({ARM: 0.2}, found))
        return [
            (j.id, j.interval.start, j.interval.stop, j.supported) for j in done.state.intervals
        ]

    kept = (1, 100, 110, True)
    state = Decide((1,), Decision.ACCEPTED).apply(
        start_review("own", {ARM: 0.1}, [made(ARM, 100, 110)], (ARM,))
    )
    again = Redetect({ARM: 0.2}, (made(ARM, 100, 110),)).apply(state)
    assert again.find(1) is state.find(1)  # nobody needs to draw it again
    assert after(made(ARM, 100, 120)) == [kept]  # IoU of one half
    assert after(made(ARM, 100, 121)) == [(1, 100, 110, False), (2, 100, 121, True)]
    assert after(made(ARM, 106, 111)) == [kept]  # 80 % of it lie inside
    assert after(made(ARM, 107, 111)) == [(1, 100, 110, False), (2, 107, 111, True)]
    assert after(made(ARM, 100, 104), made(ARM, 105, 109)) == [kept]
    assert after() == [(1, 100, 110, False)]
    flip = made(ARM, 100, 110, kind=Kind.LIMB_FLIP)
    assert after(flip) == [(1, 100, 110, False), (2, 100, 110, True)]
    # What nobody touched is replaced by what shares most frames with it, or goes.
    assert after(made(ARM, 90, 101), made(ARM, 105, 130), decision=None) == [
        (2, 90, 101, True),
        (1, 105, 130, True),
    ]
    assert after(made(ARM, 110, 120), decision=None) == [(2, 110, 120, True)]
    assert after(decision=None) == []


def test_another_tau_leaves_other_chains_and_names_its_method():
    done = review()
    leg = done.state.of_chain(LEG)
    done.do(Redetect({ARM: 0.3}, (*FOUND[1:4], made(LEG, 0, 3)), method="paper"))
    assert done.state.method == "paper"
    assert dict(done.state.tau) == {ARM: 0.3, LEG: 0.2}
    assert done.state.of_chain(LEG) == leg
    assert [j.id for j in done.state.of_chain(ARM)] == [3, 4, 2]
    done.do(Redetect({ARM: 0.3, LEG: 0.1}, ()))
    assert done.state.method == "paper"
    assert done.history == ("Detect with paper", "Set τ of 2 chains")
    done.do(Insert(made(ARM, 0, 4)))
    done.do(Redetect({ARM: 0.4}, ()))
    assert done.state.intervals[0].supported  # no detector is asked about it


def test_chains_that_go_take_their_intervals_along():
    done = review()
    done.do(ChangeChains(AS_FOUND, {"New": 0.5, ARM: 0.1}, ("New",), (made("New", 0, 3),)))
    state = done.state
    assert list(state.chain_order) == ["New", ARM]
    assert [(j.id, j.interval.chain) for j in state.intervals] == [
        (6, "New"), (3, ARM), (4, ARM), (2, ARM),
    ]  # fmt: skip
    assert dict(state.tau) == {"New": 0.5, ARM: 0.1}
    assert done.undo_text == "Change the chains"
    other = Rig(remove=(LEG,))
    assert ChangeChains(other, {ARM: 0.1}, (), ()).apply(state).rig is other
    assert ChangeChains(AS_FOUND, {}, (), (), "Add a chain").text == "Add a chain"
    with pytest.raises(ValueError, match="no chain 'Gone'"):
        done.do(ChangeChains(AS_FOUND, {ARM: 0.1}, ("Gone",), ()))


def test_tracking_needs_something_to_track():
    done = review()
    done.do(Track(Tracking(("Hand",))))
    done.do(Track(Tracking(("Hand", "Foot"), place=True)))
    assert done.state.tracking.what == "2 joints and the place"
    done.do(Track(Tracking((), place=True)))
    done.do(Track(None))
    assert done.state.tracking is None
    assert done.history == (
        "Track Hand", "Track 2 joints and the place", "Track the place", "Stop tracking",
    )  # fmt: skip
    with pytest.raises(ValueError, match="a joint to track"):
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
    with pytest.raises(FormatError, match="expected kd, which is missing"):
        tracking_from_json({k: v for k, v in early.items() if k != "kd"})
    with pytest.raises(FormatError, match="a list of joints"):
        tracking_from_json({**entry, "joints": []})
    assert tracking_from_json({**entry, "joints": [], "place": True}).place


def test_an_earlier_review_is_matched_by_the_frames_in_common():
    now = review().state
    earlier = (
        Judged(1, made(ARM, 12, 30), Decision.ACCEPTED, reviewer="Ada", note="a"),
        Judged(2, made(ARM, 18, 25), Decision.REJECTED, reviewer="Bo"),
        Judged(3, made(ARM, 55, 70, 30.0), edited=True),
        Judged(4, made(LEG, 80, 90), Decision.REJECTED),
        Judged(5, made(LEG, 60, 70), by_hand=True),
        Judged(6, made("Gone", 5, 9), Decision.ACCEPTED),
        Judged(7, made(LEG, 5, 9)),
    )
    other_clip = carried_over(earlier, now)
    assert [(j.id, j.interval.start, j.decision.value) for j in other_clip.intervals] == [
        (3, 10, "accepted"), (4, 30, "undecided"), (2, 55, "undecided"),
        (1, 5, "undecided"), (5, 40, "undecided"), (6, 60, "undecided"),
    ]  # fmt: skip
    taken = other_clip.find(3)
    assert (taken.reviewer, taken.note, taken.interval.stop) == ("Ada", "a", 20)
    assert other_clip.find(2).edited
    assert (other_clip.find(6).by_hand, other_clip.find(6).supported) == (True, True)
    assert other_clip.next_id == 7
    same = CarryOver(earlier, same_clip=True).apply(now)
    alone = [(j.id, j.interval.start, j.supported) for j in same.intervals if j.id > 5]
    assert alone == [(6, 18, False), (8, 60, True), (7, 80, False)]
    assert same.next_id == 9
    # Once more: nothing comes twice, and what was touched here stays.
    own = Decide((3,), Decision.REJECTED, "Cy").apply(same)
    again = carried_over(earlier, own, same_clip=True)
    assert [j.id for j in again.intervals] == [j.id for j in own.intervals]
    assert again.find(3).reviewer == "Cy"
    texts = (CarryOver(earlier).text, CarryOver(earlier, same_clip=True).text)
    assert texts == ("Carry decisions over", "Add decisions")


def test_of_two_earlier_intervals_with_as_many_frames_in_common_the_first_counts():
    earlier = [Judged(k, made(ARM, a, a + 8), note=str(k)) for k, a in ((1, 5), (3, 17))]
    taken = carried_over(earlier, review().state).find(3)
    assert taken.note == "1"
    # One frame in common is enough, none is not.
    near = [Judged(1, made(ARM, 19, 25), Decision.ACCEPTED), Judged(2, made(ARM, 60, 70), note="x")]
    after = carried_over(near, review().state)
    assert (after.find(3).decision, after.find(2).note) == (Decision.ACCEPTED, "")


def test_what_nobody_says_is_nothing():
    state = ReviewState("own", {})
    assert (state.intervals, state.left_out, state.tracking) == ((), (), None)
    assert (state.next_id, dict(state.chain_order), state.rig) == (1, {}, AS_FOUND)
    assert start_review("own", {}, (), ()).rig == AS_FOUND
    plain = Judged(1, FOUND[0])
    assert (plain.reviewer, plain.decided_at, plain.note, plain.reason) == ("", "", "", "")
    assert (plain.by_hand, plain.edited, plain.supported, plain.in_bulk) == (0, 0, 1, 0)
    assert Tracking(("Hand",)) == Tracking(("Hand",), 600.0, 15.0, 0.0, False, "", True, False)
    assert (Decide((), Decision.ACCEPTED).reviewer, Annotate(1, "a").reason) == ("", "")


def test_frames_left_out_are_joined_where_they_meet():
    assert joined([(5, 8), (0, 2), (2, 3), (6, 7), (7, 9), (10, 11)]) == ((0, 3), (5, 9), (10, 11))
    assert spans_from_json([[0, 1], (1, 2)]) == ((0, 2),)
    for damaged in ([[1, 2, 3]], [[0, 1.0]], [[2, 1]], [[3, 3]], [[-1, 2]], {"a": 1}, ["ab"], 7):
        with pytest.raises(FormatError, match="left_out"):
            spans_from_json(damaged)
    done = review()
    done.do(LeaveOut(((0, 1), (1, 4))))
    assert done.state.left_out == ((0, 4),)
    done.do(LeaveOut(()))
    assert done.history == ("Leave frames out of tuning", "Take all frames into tuning")
    for wrong in ((-1, 3), (4, 4)):
        with pytest.raises(ValueError, match="at least one frame"):
            done.do(LeaveOut((wrong,)))


def test_intervals_of_no_frames_are_nothing():
    assert isinstance(constant(ARM, 3, 3, 0.1), Interval)
    np.testing.assert_array_equal(constant(ARM, 3, 5, 0.1).offset, [0.1, 0.1])
