"""A review's state, and what is asked of it."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.messages import numbers
from tests.twistcore.plain_review import ARM, FOUND, JUMP, LEG, decided, made, review
from twistcore.detection import Interval, Kind
from twistcore.detection.interval_offsets import (
    angles_relative_to_adjacent_frames,
    new_constant_offset_interval,
    resized_interval,
    with_offset_making_twist_linear,
    with_offset_of_size,
)
from twistcore.quamo.tracking_settings import Tracking
from twistcore.review import Annotate, Decide, Decision, Review, start_review
from twistcore.review.model import Judged, ReviewState, overlapping_ids
from twistcore.skeleton.rig import AS_FOUND, Rig


def test_a_review_begins_in_the_order_of_chains_and_frames():
    state = review().state
    assert [j.id for j in state.intervals] == [3, 4, 2, 1, 5]
    assert (state.next_id, state.method, dict(state.tau)) == (6, "own", {ARM: 0.1, LEG: 0.2})
    assert [j.id for j in state.of_chain(LEG)] == [1, 5]
    assert numbers(repr(state)) == [0, 5]
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
    assert done.state.automatic_ids() == (3, 1)  # half sure is sure enough
    assert done.state.automatic_ids(0.6) == (1,)
    assert done.state.automatic_ids(0.6, include_open=True) == (1, 5)
    assert done.state.automatic_ids(confidence=lambda _: 1.0) == (3, 2, 1)
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
    written = made(ARM, 0, 3, 370.0).as_written
    np.testing.assert_allclose(np.degrees(written.offset), 10.0, atol=1e-12)
    fine = replace(FOUND[0], offset=np.radians([1.00000000049, -1e-12, 2.0, 3.0]))
    degrees = np.degrees(fine.as_written.offset)
    np.testing.assert_allclose(degrees, [1.0, 0.0, 2.0, 3.0], rtol=0, atol=1e-13)
    assert math.copysign(1.0, fine.as_written.offset[1]) == 1.0


def test_resized_intervals_keep_their_offsets_and_take_the_nearest():
    ramp = replace(made(ARM, 10, 14), offset=np.array([0.1, 0.2, 0.3, 0.4]))
    wider = resized_interval(ramp, 8, 16)
    assert (wider.start, wider.stop) == (8, 16)
    np.testing.assert_array_equal(wider.offset, [0.1, 0.1, 0.1, 0.2, 0.3, 0.4, 0.4, 0.4])
    np.testing.assert_array_equal(resized_interval(ramp, 11, 13).offset, [0.2, 0.3])


def test_a_level_is_moved_and_a_soft_course_stretched():
    flat = replace(made(ARM, 0, 4), offset=np.array([0.9, 1.0, 1.0, 1.2]))
    moved = with_offset_of_size(flat, 1.5)
    np.testing.assert_allclose(moved.offset, [1.4, 1.5, 1.5, 1.7])
    over = with_offset_of_size(flat, math.pi)
    np.testing.assert_allclose(over.offset[:3], [math.pi - 0.1, math.pi, math.pi])
    assert over.offset[3] == pytest.approx(0.2 - math.pi)
    soft = replace(made(ARM, 0, 4), offset=np.array([0.1, 0.5, 1.0, 0.2]))
    np.testing.assert_allclose(with_offset_of_size(soft, -2.0).offset, [-0.2, -1.0, -2.0, -0.4])


def test_twist_off_the_line_between_its_neighbours():
    theta = np.array([0.0, 0.1, 0.7, 0.8, 0.4, 0.5])
    np.testing.assert_allclose(angles_relative_to_adjacent_frames(theta, 2, 4), [0.5, 0.5])
    np.testing.assert_allclose(
        angles_relative_to_adjacent_frames(theta, 0, 2), [-0.7, -0.6]
    )  # level at an end
    np.testing.assert_allclose(angles_relative_to_adjacent_frames(theta, 4, 6), [-0.4, -0.3])
    np.testing.assert_allclose(
        angles_relative_to_adjacent_frames(theta, 0, 6), theta - 0.5
    )  # all of the clip
    # The shorter way round.
    turned = np.array([3.0, 0.0, -3.0])
    assert angles_relative_to_adjacent_frames(turned, 1, 2) == pytest.approx([math.pi])
    followed = with_offset_making_twist_linear(made(ARM, 2, 4), theta)
    np.testing.assert_allclose(followed.offset, [0.5, 0.5])
    assert (followed.start, followed.stop) == (2, 4)
    whole = made(ARM, 0, 6)
    assert with_offset_making_twist_linear(whole, theta) is whole


def test_intervals_that_share_frames_add():
    def judged(k, start, stop, **more):
        chain = more.pop("chain", ARM)
        decision = more.pop("decision", Decision.UNDECIDED)
        return Judged(k, made(chain, start, stop, **more), decision)

    assert overlapping_ids([judged(1, 0, 10), judged(2, 10, 12)]) == frozenset()
    assert overlapping_ids([judged(2, 9, 12), judged(1, 0, 10)]) == {1, 2}
    assert overlapping_ids([judged(1, 0, 10), judged(2, 5, 6), judged(3, 8, 9)]) == {1, 2, 3}
    assert overlapping_ids([judged(1, 0, 10), judged(2, 5, 20), judged(3, 15, 16)]) == {1, 2, 3}
    assert overlapping_ids([judged(1, 0, 10), judged(2, 5, 6, chain=LEG)]) == frozenset()
    assert overlapping_ids([judged(1, 0, 9), judged(2, 5, 6, decision=Decision.REJECTED)]) == set()
    assert overlapping_ids([judged(1, 0, 9), judged(2, 5, 6, kind=JUMP)]) == frozenset()


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


def test_intervals_of_no_frames_are_nothing():
    assert isinstance(new_constant_offset_interval(ARM, 3, 3, 0.1), Interval)
    np.testing.assert_array_equal(new_constant_offset_interval(ARM, 3, 5, 0.1).offset, [0.1, 0.1])
