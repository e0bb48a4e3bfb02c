"""What is known of one chain: intervals at any threshold, and what is told of each."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from tests.twistcore.counters import ROW, counter_of, seeds
from twistcore.detection.consistency.chain_analysis import ChainAnalysis, FixedInterval
from twistcore.detection.consistency.confidence import counter_twist_confidence
from twistcore.detection.counter_twist.edges import find_interval_edges_and_steps
from twistcore.detection.counter_twist.offsets import interval_twist_errors_over_time
from twistcore.detection.counter_twist.pairing import (
    best_edge_pairs,
    edge_pair_table,
    one_ended_jump_intervals,
    running_counter_rotation_sums,
)
from twistcore.detection.interval import Interval
from twistcore.skeleton.rotation import wrap

FRAMES, FPS = 120, 60.0
SEGMENTS = ((0, 70), (70, FRAMES))


def analysis_of(seed, jumps=0.06):
    counter = counter_of(seed, frames=FRAMES, jumps=jumps)
    edges, step = find_interval_edges_and_steps(counter, ROW)
    sums = running_counter_rotation_sums(counter, ROW, step)
    tables = tuple(edge_pair_table(edges, sums, low, high) for low, high in SEGMENTS)
    return ChainAnalysis("Arm", FPS, counter, ROW, edges, step, tables)


def sums(chain, edges, k):
    at = slice(edges.start[k], edges.stop[k])
    return {
        name: float(getattr(chain.limb, field)[ROW, at].sum())
        for name, field in (
            ("x", "x"), ("y", "y"), ("residual_x", "rx"), ("residual_y", "ry"),
            ("sigma_x", "sigma_x"), ("sigma_y", "sigma_y"),
        )
    }  # fmt: skip


def plain_intervals(chain, tau):
    """Start, stop, what follows, and all that is said of each."""
    for table in chain.tables:
        edges = table.edges
        pairs = best_edge_pairs(table, tau, FPS)
        for n, pair in enumerate(pairs + one_ended_jump_intervals(table, pairs, tau)):
            course = interval_twist_errors_over_time([pair], table, chain.limb, ROW, chain.step)[0]
            at = [k for k in pair[:2] if k >= 0]
            sigma = math.sqrt(sum(edges.sigma[k] ** 2 for k in at))
            told = [sums(chain, edges, k) for k in at]
            both = False
            for s in told:
                x, y = (abs(float(wrap(s[name]))) for name in ("residual_x", "residual_y"))
                both |= min(x, y) >= 0.35 * max(x, y)
            gain = max(pair.gain, edges.gain[at[0]]) if len(at) == 1 else pair.gain
            least = min(abs(edges.jump[k]) for k in at)
            sure = counter_twist_confidence(
                gain,
                abs(course.residual) / sigma,
                math.log(min(abs(edges.jump[k]) / edges.sigma[k] for k in at)),
                len(course.offset),
                beyond_tau=bool(least >= chain.automatic_tau()),
            )
            evidence = {
                "gain": pair.gain,
                "follows": ("its edges", "its events", "every frame")[pair.follows],
                "closing_residual_deg": math.degrees(course.residual),
                "closing_sigma_deg": math.degrees(sigma),
                "child_follows": course.followed,
            }
            of_edges = []
            for k, s in zip(at, told, strict=True):
                jump = float(edges.jump[k])
                apart = abs(float(wrap(s["residual_x"] + s["residual_y"])))
                of_edges.append(
                    {f"{name}_deg": math.degrees(value) for name, value in s.items()}
                    | {
                        "start": edges.start[k],
                        "stop": edges.stop[k],
                        "jump_deg": math.degrees(jump),
                        "sigma_deg": math.degrees(edges.sigma[k]),
                        "gain": edges.gain[k],
                        "agreement": max(0.0, 1.0 - apart / abs(jump)),
                    }
                )
            is_open = n >= len(pairs) or not both
            yield course, is_open, sure, evidence, of_edges


@settings(max_examples=examples(15))
@given(seeds, st.sampled_from([0.5, 2.0, 10.0]))
def test_every_interval_says_what_its_edges_and_its_course_do(seed, tau):
    chain, tau = analysis_of(seed), math.radians(tau)
    wanted = sorted(
        plain_intervals(chain, tau), key=lambda w: (w[0].start, w[0].start + len(w[0].offset))
    )
    for _ in range(2):  # the second time from what it knows
        found = sorted(chain.intervals(tau), key=lambda i: (i.start, i.stop))
        assert len(found) == len(wanted)
        for i, (course, is_open, sure, evidence, edges) in zip(found, wanted, strict=True):
            assert (i.chain, i.start, i.frames) == ("Arm", course.start, len(course.offset))
            np.testing.assert_allclose(i.offset, course.offset, atol=1e-12)
            assert i.open == is_open
            assert i.confidence == pytest.approx(sure, abs=1e-9)
            assert (i.residual, i.followed) == (course.residual, course.followed)
            told = dict(i.evidence)
            for one, other in zip(told.pop("edges"), edges, strict=True):
                assert one == pytest.approx(other, abs=1e-9)
            assert told.pop("follows") == evidence.pop("follows")
            assert told == pytest.approx(evidence)
            evidence["follows"] = i.evidence["follows"]


@settings(max_examples=examples(15))
@given(seeds)
def test_strength_is_that_of_events_and_of_edges_at_their_peaks(seed):
    chain = analysis_of(seed)
    wanted = np.abs(chain.limb.d[ROW]) * chain.limb.event[ROW]
    for k in range(len(chain.edges)):
        at = chain.edges.peak[k]
        wanted[at] = max(wanted[at], abs(chain.edges.jump[k]))
    np.testing.assert_allclose(chain.strength(), wanted)
    stood = chain.with_soft([fixed(10, 20, 3.5, 12), fixed(30, 40, 0.0, 31)], [])
    wanted[12] = max(wanted[12], 3.5)
    np.testing.assert_allclose(stood.strength(), wanted)


def fixed(start, stop, strength, peak):
    return FixedInterval(Interval("Arm", start, stop, np.zeros(stop - start)), strength, peak)


def frames(intervals):
    return [(i.start, i.stop) for i in intervals]


def with_intervals(least=3):
    chain = next(a for a in map(analysis_of, range(99)) if len(a.intervals(0.05)) >= least)
    return chain, chain.intervals(0.05)


def test_what_stands_is_told_from_its_strength_on_among_the_others_by_start():
    chain, usual = with_intervals()
    stood = chain.with_soft([fixed(4, 9, 0.3, 5), fixed(1, 3, 0.2, 2)], [])
    assert frames(stood.intervals(0.05)) == sorted([*frames(usual), (4, 9), (1, 3)])
    higher = frames(stood.intervals(0.2))
    assert (1, 3) in higher
    assert (1, 3) not in frames(stood.intervals(0.2001))
    assert (4, 9) in frames(stood.intervals(0.3))
    assert frames(chain.intervals(0.05)) == frames(usual)


def test_where_soft_errors_stand_for_all_else_the_rest_gives_way():
    chain, usual = with_intervals()
    low, high = usual[1].start, usual[1].stop
    for instead, gone in (
        ((low - 5, low), False),
        ((low - 5, low + 1), True),
        ((high - 1, high + 4), True),
        ((high, high + 4), False),
    ):
        soft = chain.with_soft([], [instead])
        assert soft.is_replaced(usual[1]) is gone
        assert ((low, high) in frames(soft.intervals(0.05))) is not gone
        assert frames(soft.between_edges(0.05)) == frames(usual)
    kept = chain.with_soft([fixed(4, 9, 3.0, 5)], []).with_soft([fixed(50, 60, 3.0, 51)], [])
    assert [s.peak for s in kept.fixed] == [5, 51]
    kept = kept.with_soft([fixed(8, 12, 3.0, 9)], [(8, 12)])
    assert [s.peak for s in kept.fixed] == [51, 9]
    assert kept.replaced == ((8, 12),)


def test_a_turn_of_one_joint_alone_is_open():
    """The smaller sum must be 0.35 of the larger one, at one edge at least."""
    chain, _ = with_intervals()
    for share, is_open in ((0.34, True), (0.36, False)):
        limb = replace(chain.limb, rx=chain.limb.rx, ry=-share * chain.limb.rx)
        other = replace(chain, limb=limb, _known={}, _solved={})
        assert all(i.open for i in other.intervals(0.05)) is is_open


def test_a_jump_that_nothing_explains_is_open_though_both_joints_turn():
    counter = counter_of(4, frames=FRAMES, jumps=0.0)
    for column, turn in ((counter.rx, 0.5), (counter.ry, -0.5), (counter.d, 0.5)):
        column[ROW, 35] = turn
    counter.event[ROW, 35] = True
    edges, step = find_interval_edges_and_steps(counter, ROW)
    sums = running_counter_rotation_sums(counter, ROW, step)
    tables = tuple(edge_pair_table(edges, sums, low, high) for low, high in SEGMENTS)
    chain = ChainAnalysis("Arm", FPS, counter, ROW, edges, step, tables)
    (found,) = chain.intervals(0.1)
    assert (found.start, found.stop, found.open) == (0, 35, True)
    assert found.evidence["edges"][0]["agreement"] > 0.99


def test_the_automatic_threshold_is_that_of_its_own_row():
    for seed in range(5):
        chain = analysis_of(seed)
        louder = replace(chain.limb, sigma=chain.limb.sigma + np.array([[0.3], [0.1]]))
        found = replace(chain, limb=louder).automatic_tau()
        assert found == pytest.approx(6.0 * float(np.median(louder.sigma[ROW])))


# Confidence


def test_confidence_is_a_logistic_map_of_what_is_known():
    def plain(gain, closing, margin, length, beyond):
        score = -3.4892 + 2.9625 * math.log(max(gain, 0.5)) - 0.6089 * min(closing, 6.0)
        score += -1.2179 * min(margin, 5.0) - 0.1997 * math.log(1.0 + length / 30.0)
        return 1.0 / (1.0 + math.exp(-(score + 4.4911 * beyond)))

    rng = np.random.default_rng(4)
    for _ in range(100):
        gain, closing, margin = rng.uniform([0.0, 0.0, 0.0], [30.0, 9.0, 8.0]).tolist()
        length, beyond = int(rng.integers(1, 400)), bool(rng.integers(2))
        found = counter_twist_confidence(gain, closing, margin, length, beyond_tau=beyond)
        assert found == pytest.approx(plain(gain, closing, margin, length, beyond))


@pytest.mark.parametrize(("gain", "score"), [(1e12, 30.0), (0.0, -10.0)])
def test_confidence_of_what_is_beyond_all_measure_is_still_a_number(gain, score):
    found = counter_twist_confidence(gain, 0.0, 5.0 if gain else 9.0, 1, beyond_tau=bool(gain))
    assert 0.0 < found <= 1.0
    if gain:
        assert found == pytest.approx(1.0 / (1.0 + math.exp(-score)), abs=1e-15)
