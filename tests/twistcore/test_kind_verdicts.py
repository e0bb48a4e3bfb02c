"""Verdicts counted by kind and by chain: errors, false alarms, missed and undecided ones."""

from dataclasses import replace

import numpy as np
import pytest

import twistcore as tc
from twistcore.detection import Interval, Kind
from twistcore.review import Decision, Judged, ReviewState
from twistcore.review.kind_verdicts import verdicts_with_kinds
from twistcore.tuning.verdict_counts import count_verdicts_by_group

TIME = "2026-01-01T00:00:00+00:00"
ACCEPTED, REJECTED = Decision.ACCEPTED, Decision.REJECTED


@pytest.fixture(scope="module")
def empty():
    review = tc.Review(tc.detect(tc.read_clip("assets/walk.bvh")))
    return review.state.with_intervals(())


def judged(k, decision=Decision.UNDECIDED, kind=Kind.COUNTER_TWIST, chain="LeftArm", **more):
    interval = Interval(chain, 10 * k, 10 * k + 5, np.full(5, 0.5), kind=kind)
    decided = {} if decision == Decision.UNDECIDED else {"decided_at": TIME}
    return Judged(k, interval, decision, **{**decided, **more})


def counts(state: ReviewState, some, group_of=lambda v: v.kind):
    count = count_verdicts_by_group(verdicts_with_kinds(state.with_intervals(some)), group_of)
    return {
        group: (c.score.errors, c.score.found, c.score.alarms, c.undecided)
        for group, c in count.items()
    }


def test_each_decision_counts_where_it_belongs(empty):
    some = [
        judged(0, ACCEPTED),
        judged(1, REJECTED),
        judged(2),
        judged(3, ACCEPTED, by_hand=True),  # the program had missed it
        judged(4, REJECTED, by_hand=True),  # inserted by mistake
        judged(5, ACCEPTED, in_bulk=True),
        judged(6, ACCEPTED, decided_at=""),  # applied automatically
    ]
    assert counts(empty, some) == {Kind.COUNTER_TWIST: (2, 1, 1, 3)}


def test_kinds_and_chains_are_counted_apart(empty):
    some = [
        judged(0, ACCEPTED),
        judged(1, REJECTED, Kind.LIMB_FLIP, "RightUpLeg-RightFoot"),
        judged(2, ACCEPTED, Kind.LONE_JUMP),  # cannot be corrected, but is an error
    ]
    assert counts(empty, some) == {
        Kind.COUNTER_TWIST: (1, 1, 0, 0),
        Kind.LIMB_FLIP: (0, 0, 1, 0),
        Kind.LONE_JUMP: (1, 1, 0, 0),
    }
    by_chain = counts(empty, some, lambda v: v.chain)
    assert by_chain == {"LeftArm": (2, 2, 0, 0), "RightUpLeg-RightFoot": (0, 0, 1, 0)}


def test_precision_and_recall_have_limits(empty):
    some = [judged(k, ACCEPTED if k < 6 else REJECTED) for k in range(8)]
    some.append(judged(8, ACCEPTED, by_hand=True))
    score = count_verdicts_by_group(
        verdicts_with_kinds(empty.with_intervals(some)), lambda v: v.kind
    )[Kind.COUNTER_TWIST].score
    for (share, low, high), expected in ((score.precision, 6 / 8), (score.recall, 6 / 7)):
        assert share == pytest.approx(expected)
        assert low < share < high


def test_recall_is_unknown_if_nobody_inserted_a_missed_error(empty):
    def recall(some):
        return count_verdicts_by_group(
            verdicts_with_kinds(empty.with_intervals(some)), lambda v: v.chain
        )["LeftArm"].recall

    assert np.isnan(recall([judged(0, ACCEPTED), judged(1, REJECTED)]))
    assert recall([judged(0, ACCEPTED), judged(1, ACCEPTED, by_hand=True)]) == 0.5


def test_a_judged_clip_keeps_them(empty):
    from twistcore.analysis.clip_analysis import analyse
    from twistcore.tuning.verdicts_of import judged_clip_from_review

    clip = analyse(tc.read_clip("assets/walk.bvh"))
    state = replace(empty).with_intervals([judged(0, REJECTED, Kind.LIMB_FLIP)])
    assert judged_clip_from_review(clip, state).of_kinds == verdicts_with_kinds(state)
