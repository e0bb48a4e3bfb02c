"""What a τ costs, how well that is known, and which frames count."""

import math
from functools import reduce
from operator import add

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import numbers
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import detect
from twistcore.formats.bvh import read_bvh
from twistcore.review.left_out import joined_spans
from twistcore.tuning import (
    GRID,
    DrawnErrors,
    TauCurve,
    Verdicts,
    injected_tau_curve,
    prepare_clip_tuning,
    shared_tau,
    total_tuning_cost,
)
from twistcore.tuning.drawn_errors import poisson_confidence_interval

TAU = np.radians([1.0, 2.0, 4.0, 8.0])


def errors(sizes, repaired, frames=10, kind=0):
    """Errors of so many frames each, by size in degrees; repaired: 0…1 at every τ, a row each."""
    n = len(sizes)
    rows = frames * np.array(repaired, float)
    whole = np.full(n, float(frames))
    return DrawnErrors(np.radians(sizes), whole, np.full(n, kind), np.arange(n), rows)


def curve(drawn, alarms=(0, 0, 0, 0), noise=0.01, minutes=1.0):
    repaired = drawn.repaired.sum(axis=0)
    return TauCurve(
        TAU, repaired, int(drawn.frames.sum()), np.array(alarms, float), minutes, (noise,), drawn
    )


@pytest.fixture(scope="module")
def walk_tuning():
    clip = read_bvh(ASSETS / "walk.bvh")
    return {
        m: prepare_clip_tuning(clip.motion, clip.name, method=m) for m in ("consistency", "paper")
    }


@pytest.mark.parametrize("method", ["consistency", "paper"])
def test_a_large_tau_has_its_own_fsr(walk_tuning, method):
    c = walk_tuning[method].curve("LeftForeArm")
    at_30, at_80, at_180 = (c.at(math.radians(d))[0] for d in (30.0, 80.0, 180.0))
    assert at_180 == 0.0
    assert 0.0 < at_80 < at_30 - 0.1
    # Of P0, uniform to 180°, errors of less than τ are passed over; of H6, all.
    large = c.drawn.of(c.drawn.kind == 0)
    passed = large.frames[large.size < math.radians(80.0)].sum()
    assert at_80 == pytest.approx((large.frames.sum() - passed) / c.errors, abs=0.12)


def test_the_papers_tau_is_suggested_down_to_the_clips_noise_not_to_its_usual_one(walk_tuning):
    ours, paper = (walk_tuning[m].curve("LeftForeArm") for m in ("consistency", "paper"))
    assert np.degrees([ours.automatic, paper.automatic]) == pytest.approx([1.5, 5.0])
    assert paper.floor == ours.floor == ours.automatic
    assert ours.floor <= paper.suggested() < math.radians(3.0)
    # Small errors are found there that 5° passes over.
    assert paper.at(paper.suggested())[0] > paper.at(paper.automatic)[0] + 0.02
    assert (paper + paper).automatic == paper.automatic


def test_a_tau_on_the_grid_has_what_was_measured_and_between_lies_between(walk_tuning):
    c = walk_tuning["paper"].curve("LeftForeArm")
    for k in (0, 1, 20, len(GRID) - 2, len(GRID) - 1):
        assert c.at(float(GRID[k])) == pytest.approx((c.fsr[k], c.alarms[k]))
    k = int(np.flatnonzero(np.diff(c.fsr[-10:]))[-1]) + len(GRID) - 10
    assert np.degrees(GRID[k]) >= 30.0
    middle = c.at(math.sqrt(GRID[k] * GRID[k + 1]))[0]
    assert middle == pytest.approx(0.5 * (c.fsr[k] + c.fsr[k + 1]))
    assert middle != c.fsr[k]
    assert c.at(1e-6) == pytest.approx((c.fsr[0], c.alarms[0]))
    assert np.degrees(GRID[[0, -1]]) == pytest.approx([0.1, 180.0])


@parametrize("method", ["paper", "consistency"])
def test_the_band_holds_what_many_draws_bring(walk_tuning, method):
    """Of 20 sets of three seeds each, nearly all have the FSR of all 60 within their band."""
    tuning = walk_tuning[method]
    chain = tuning.clean.chain("LeftForeArm")
    parts = [
        injected_tau_curve(
            tuning.clean, chain, name="w", method=method, seeds=range(3 * k, 3 * k + 3)
        )
        for k in range(20)
    ]
    whole = reduce(add, parts)
    places = [int(np.argmin(np.abs(GRID - math.radians(d)))) for d in (2.0, 5.5, 10.0, 45.0)]
    inside = [c.band[0][k] <= whole.fsr[k] <= c.band[1][k] for c in parts for k in places]
    assert np.mean(inside) >= 0.9
    # And it says more the more there is.
    wide = np.mean([c.band[1][places] - c.band[0][places] for c in parts])
    assert np.mean(whole.band[1][places] - whole.band[0][places]) < 0.4 * wide
    assert wide < 0.45


def test_that_all_were_repaired_proves_less_the_fewer_there_were():
    few, many = (curve(errors([20.0] * n, [[1, 1, 1, 1]] * n)) for n in (4, 40))
    for c in (few, many):
        cost = c.cost(TAU[1])
        assert cost.fsr == cost.high == 1.0
    assert few.cost(TAU[1]).low == pytest.approx(4 / (4 + 1.96**2))
    assert many.cost(TAU[1]).low == pytest.approx(40 / (40 + 1.96**2))


def test_errors_of_a_draw_that_fare_alike_are_worth_fewer():
    rows = [[1, 1, 1, 1]] * 10 + [[0, 0, 0, 0]] * 10
    apart = errors([20.0] * 20, rows)
    alike = DrawnErrors(apart.size, apart.frames, apart.kind, np.arange(20) // 5, apart.repaired)
    assert np.ptp(alike.band, axis=0)[0] > 1.3 * np.ptp(apart.band, axis=0)[0]


def test_one_draw_or_none_is_no_trouble():
    one = errors([20.0, 30.0], [[1, 1, 0, 0], [1, 0, 0, 0]])
    one = DrawnErrors(one.size, one.frames, one.kind, np.zeros(2, int), one.repaired)
    cost = curve(one).cost(TAU[1])
    assert cost.fsr == pytest.approx(0.5)
    assert cost.low < cost.fsr < cost.high
    none = TauCurve(TAU, np.zeros(4), 0, np.zeros(4), 1.0, (0.02,))
    cost = none.cost(TAU[0])
    assert math.isnan(cost.fsr)
    assert math.isnan(cost.low)
    assert math.isnan(cost.high)
    assert none.suggested() >= 0.02
    assert np.isnan(none.band).all()


def test_chains_at_their_own_tau_add_by_their_frames():
    a = curve(errors([20.0], [[1, 1, 1, 0]], frames=30), alarms=(3, 2, 0, 0))
    b = curve(errors([20.0], [[1, 0, 0, 0]], frames=10), alarms=(1, 1, 1, 1))
    cost = total_tuning_cost([(a, TAU[2]), (b, TAU[1])])
    assert (cost.fsr, cost.alarms, cost.minutes) == pytest.approx((0.75, 1.0, 1.0))  # of one minute
    assert 0.0 < cost.low < 0.75 < cost.high < 1.0
    unknown = TauCurve(TAU, np.ones(4), 10, np.zeros(4), 1.0, (0.01,))
    assert math.isnan(total_tuning_cost([(a, TAU[0]), (unknown, TAU[0])]).low)


def test_a_clip_in_which_nothing_was_drawn_hides_no_other():
    c = curve(errors([3.0, 20.0], [[1, 1, 0, 0], [1, 1, 1, 0]]))
    empty = TauCurve(TAU, np.zeros(4), 0, np.zeros(4), 0.01, (0.01,))
    for both in (c + empty, empty + c):
        wanted = math.radians(10.0)
        assert both.suggested(smallest=wanted) == c.suggested(smallest=wanted)
        np.testing.assert_array_equal(both.band, c.band)
    assert (empty + empty).drawn is None
    cost = total_tuning_cost([(c, TAU[0]), (empty, TAU[0])])
    assert (cost.low, cost.high) == (c.cost(TAU[0]).low, c.cost(TAU[0]).high)


def test_rare_events_are_known_by_their_count():
    assert poisson_confidence_interval(0) == pytest.approx(
        (0.0, 3.689), abs=1e-3
    )  # tables of Garwood
    assert poisson_confidence_interval(10) == pytest.approx((4.795, 18.39), abs=1e-2)
    cost = curve(errors([20.0], [[1, 1, 1, 1]]), minutes=2.0).cost(TAU[0])
    assert cost.rate_band == pytest.approx((0.0, 3.689 / 2.0), abs=1e-3)


def test_the_price_of_an_alarm_and_the_smallest_errors_are_a_persons():
    # Three alarms at 1°, one at 2°; the error of 3° is lost from 4° on, that of 20° never.
    rows = [[1, 1, 0, 0]] + 9 * [[1, 1, 1, 1]]
    c = curve(errors([3.0, *[20.0] * 9], rows), alarms=(3, 1, 0, 0))
    assert np.degrees(c.suggested()) == pytest.approx(2.0)
    assert np.degrees(c.suggested(price=0.2)) == pytest.approx(4.0)
    assert np.degrees(c.suggested(price=0.0)) == pytest.approx(2.0)
    # Who does not look for errors below 5° loses nothing by 4°.
    assert np.degrees(c.suggested(smallest=math.radians(5.0))) == pytest.approx(4.0)
    assert np.degrees(c.suggested(price=0.0, smallest=math.radians(1.0))) == pytest.approx(1.0)


@parametrize("method", ["consistency", "paper"])
def test_in_frames_left_out_nothing_counts(dirty_walk, method):
    """What a person called natural is a false alarm, unless it lies in what is left out."""
    motion = dirty_walk.motion
    found = detect(motion)[0]
    verdicts = Verdicts(natural=((found.chain, found.start, found.stop),))
    span = found.start - 40, found.start + 1

    def measured(*left_out):
        tuning = prepare_clip_tuning(
            motion, "w", seeds=(0, 1), method=method, verdicts=verdicts, left_out=left_out
        )
        return tuning, tuning.curve(found.chain)

    (_, whole), (tuning, part) = measured(), measured(span)
    assert whole.alarms[10] == part.alarms[10] + 1
    assert 0 < part.errors < whole.errors
    assert part.minutes == pytest.approx(whole.minutes - 41 * motion.frame_time / 60.0)
    assert tuning.left_out == (span,)
    assert math.isnan(measured((0, motion.frames))[1].cost(0.1).fsr)


def test_blends_at_the_ends_and_a_persons_spans_are_told_together(walk):
    held = walk.motion.with_rotations(
        np.concatenate([walk.motion.rotations[:1]] * 20 + [walk.motion.rotations[20:]])
    )
    tuning = prepare_clip_tuning(held, "w", left_out=[(100, 120), (110, 130)])
    assert tuning.first > 1
    assert tuning.left_out == ((0, tuning.first), (100, 130))
    assert tuning.clean.motion.frames == held.frames - tuning.first
    # The person's frames are those of the clip as it was given.
    c = tuning.curve("LeftForeArm")
    assert c.minutes == pytest.approx((held.frames - tuning.first - 30) * held.frame_time / 60.0)


def test_spans_that_meet_are_one():
    assert joined_spans([(5, 9), (0, 2), (8, 12), (12, 13)]) == ((0, 2), (5, 13))


def test_whether_one_tau_does_for_all_is_said_in_words():
    alike = curve(errors([20.0] * 4, [[1, 1, 0.9, 0]] * 4))
    noisy = curve(errors([20.0] * 4, [[1, 1, 1, 0]] * 4), noise=float(TAU[2]))
    alarmed = curve(errors([20.0] * 4, [[1, 1, 1, 0]] * 4), alarms=(9, 9, 0, 0))
    slight = curve(errors([20.0] * 4, [[1, 1, 1, 0]] * 4), alarms=(0.1, 0.1, 0, 0))
    curves = {"a": alike, "b": alike, "c": slight}
    assert numbers(shared_tau(curves).words({})) == [2, 3, 2, 1]
    found = shared_tau({**curves, "d": alike, "n": noisy, "Arm": alarmed})
    assert (found.best, found.served, list(found.apart)) == (("a", "b", "d"), ("c",), ["n", "Arm"])
    words = found.words({"Arm": "Left arm"})
    assert numbers(words) == [3, 6, 2, 1, 4, 4, 4, 9, 2, 0]
    assert "Left arm 4.00°" in words
    small = curve(errors([20.0] * 4, [[1, 0, 0, 0]] * 4))
    alarmed_below = curve(errors([20.0] * 4, [[1, 1, 0.9, 0]] * 4), alarms=(9, 0, 0, 0))
    served = shared_tau({"a": alarmed_below, "b": alarmed_below, "s": small}).words({})
    assert numbers(served)[-4:] == [1, 100, 0, 2]
    # The τ that does for most, also where others have more chains for their best.
    easy = curve(errors([20.0] * 4, [[1, 1, 1, 0]] * 4))
    assert numbers(shared_tau({"a": easy, "b": easy, "n": noisy}).words({})) == [1, 3, 4, 2]
    assert shared_tau({}) is None
