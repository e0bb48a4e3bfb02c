"""The estimated precision of automatic corrections, and the order in which verdicts help most."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import twistcore as tc
from tests.conftest import ASSETS
from twistcore.detection import Kind
from twistcore.review import Decision, start_review
from twistcore.tuning.stated_precision import (
    ENOUGH_STATED,
    automatic_corrections_with_confidence,
    estimate_unjudged_precision,
    representative_judging_order,
    verdicts_on_automatic_corrections,
)


@given(st.lists(st.floats(0.5, 1.0), max_size=200))
def test_the_order_names_every_correction_once(confidence):
    assert sorted(representative_judging_order(np.array(confidence))) == list(
        range(len(confidence))
    )


@pytest.mark.parametrize("count", [30, 64, 137])
def test_the_first_verdicts_are_spread_over_all_confidences(count):
    confidence = np.random.default_rng(3).uniform(0.5, 1.0, count)
    rank = np.argsort(np.argsort(confidence))
    for asked in (8, 16):
        places = np.sort(rank[representative_judging_order(confidence)[:asked]])
        gaps = np.diff([-1, *places, count])
        assert gaps.max() <= 2 * count / asked + 1


def test_too_few_verdicts_or_nothing_left_give_no_precision():
    confidence = np.full(ENOUGH_STATED + 5, 0.8)
    verdicts = [True] * (ENOUGH_STATED - 1) + [None] * 6
    assert estimate_unjudged_precision(confidence, verdicts) is None
    assert estimate_unjudged_precision(confidence, [True] * len(confidence)) is None
    verdicts[-1] = False
    found = estimate_unjudged_precision(confidence, verdicts)
    assert (found.verdicts, found.left) == (ENOUGH_STATED, 5)
    assert found.low < found.share < found.high


def test_the_informative_order_does_not_flatter():
    """Large errors are more often real, so that the worst first promise too much or too little."""
    rng = np.random.default_rng(5)
    off = {"informative": [], "worst": []}
    inside = []
    for _ in range(60):
        confidence = rng.uniform(0.5, 1.0, 100)
        size = rng.uniform(0.0, 1.0, 100)
        real = rng.random(100) < 0.3 * confidence + 0.6 * size
        orders = representative_judging_order(confidence), np.argsort(-size)
        for name, order in zip(off, orders, strict=True):
            asked = set(order[:ENOUGH_STATED])
            said = [bool(real[k]) if k in asked else None for k in range(100)]
            found = estimate_unjudged_precision(confidence, said)
            rest = np.mean([real[k] for k in range(100) if k not in asked])
            off[name].append(found.share - rest)
            if name == "informative":
                inside.append(found.low <= rest <= found.high)
    assert np.abs(off["informative"]).mean() < 0.7 * np.abs(off["worst"]).mean()
    assert np.mean(inside) > 0.8


def test_only_a_persons_own_verdicts_count():
    analysis = tc.analyse(tc.read_clip(ASSETS / "walk_injected.bvh"))
    found = analysis.detect()
    corrections = automatic_corrections_with_confidence(found)
    assert len(corrections) == len(found.to_correct()[1])
    state = start_review(found.method, dict(found.tau), found.intervals, dict(found.tau))
    assert set(verdicts_on_automatic_corrections(corrections, state)) == {None}
    said = [
        replace(state.intervals[0], decision=Decision.ACCEPTED, reviewer="A"),
        replace(state.intervals[1], decision=Decision.REJECTED, reviewer="A"),
        replace(state.intervals[2], decision=Decision.ACCEPTED, reviewer="A", in_bulk=True),
        *state.intervals[3:],
    ]
    verdicts = verdicts_on_automatic_corrections(corrections, state.with_intervals(said))
    by_frames = {(c.chain, c.start): v for c, v in zip(corrections, verdicts, strict=True)}
    first, second, third = (j.interval for j in said[:3])
    assert by_frames[first.chain, first.start] is True
    assert by_frames[second.chain, second.start] is False
    assert by_frames[third.chain, third.start] is None


def test_a_verdict_on_another_kind_of_error_does_not_count():
    found = tc.analyse(tc.read_clip(ASSETS / "walk_injected.bvh")).detect()
    corrections = automatic_corrections_with_confidence(found)
    state = start_review(found.method, dict(found.tau), found.intervals, dict(found.tau))
    jumps = [
        replace(
            judged,
            interval=replace(judged.interval, kind=Kind.LONE_JUMP),
            decision=Decision.REJECTED,
            reviewer="A",
        )
        for judged in state.intervals
    ]
    assert set(verdicts_on_automatic_corrections(corrections, state.with_intervals(jumps))) == {
        None
    }
