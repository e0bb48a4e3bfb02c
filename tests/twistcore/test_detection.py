"""Signals and the paper's detector, on errors that are known."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import examples
from twistcore.analysis.clip_analysis import detect
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection.detectors.paper import PaperDetector
from twistcore.detection.paper import intervals_of_offset, paper_detector_running_offset
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.angles import circular_median
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import wrap
from twistcore.skeleton.signals import azimuth_increments, counter_rotation, twist_signals
from twistcore.study.evaluation import measure_corrected_clip, summarise_samples
from twistcore.synthesis import (
    InjectedError,
    Truth,
    clip_random_generator,
    draw_errors,
    draw_targets,
    inject,
    read_truth,
)

WALK = read_bvh(ASSETS / "walk.bvh")
CHAINS = find_chains(WALK.motion)


@settings(max_examples=examples(30))
@given(st.integers(0, 9), st.integers(2, 300), st.integers(1, 20), st.floats(-3.1, 3.1))
def test_an_injected_twist_moves_both_signals_by_exactly_its_offset(k, start, length, delta):
    chain = CHAINS[k]
    error = InjectedError(chain.name, start, start + length, np.full(length, delta))
    dirty = inject(WALK.motion, CHAINS, [error])
    clean, now = twist_signals(WALK.motion, chain), twist_signals(dirty, chain)
    offset = np.zeros(WALK.motion.frames)
    offset[start : start + length] = delta
    assert np.abs(wrap(now.theta_p - clean.theta_p - offset)).max() < 1e-6
    bent = clean.azimuth_reliability > 1e-3
    turned = wrap(now.theta_c - clean.theta_c + offset)
    assert np.abs(turned[bent]).max() < 1e-6


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_m_is_the_smaller_of_two_opposite_turns(p, c):
    m = counter_rotation(np.array([p]), np.array([c]))[0]
    assert m == (min(abs(p), abs(c)) if p * c < 0 else 0.0)


def test_azimuth_increment_is_signed_about_the_axis():
    z = np.array([0.0, 0.0, 1.0])
    turns = np.radians([0.0, 30.0, 20.0, 190.0])
    v = np.stack([np.cos(turns), np.sin(turns), np.zeros(4)], axis=1)
    np.testing.assert_allclose(np.degrees(azimuth_increments(v, z)), [0, 30, -10, 170], atol=1e-9)


def test_a_clip_of_one_frame_has_signals_and_no_interval(walk):
    one = walk.motion.sliced(5, 6)
    assert twist_signals(one, CHAINS[0]).theta_p.shape == (1,)
    assert not detect(one, CHAINS)


def test_the_sample_holds_its_known_errors(dirty_walk):
    truth = read_truth(ASSETS / "walk_injected.truth.json")
    found = detect(dirty_walk.motion, CHAINS, "paper")
    assert sorted((i.chain, i.start, i.stop) for i in found) == sorted(
        (e.chain, e.start, e.stop) for e in truth.errors
    )
    for interval in found:
        error = next(
            e for e in truth.errors if (e.chain, e.start) == (interval.chain, interval.start)
        )
        assert abs(np.degrees(interval.delta - np.median(error.offset))) < 1.0


def test_the_papers_success_rate_on_a_walk():
    samples = []
    for seed in range(20):
        rng = clip_random_generator(seed, "walk")
        errors = draw_errors(WALK.motion, draw_targets(CHAINS, rng), rng)
        dirty = inject(WALK.motion, CHAINS, errors)
        refined = refine(dirty, CHAINS, detect(dirty, CHAINS, "paper"))
        truth = Truth("walk", "P0", seed, WALK.motion.frames, WALK.motion.fps, errors)
        samples.append(measure_corrected_clip(truth, WALK.motion, refined, CHAINS))
    table = summarise_samples(samples)
    assert table.overall.frames > 1000
    assert table.overall.fsr_percent >= 95.0
    assert table.overall.mae_before_deg > 60.0
    assert table.overall.mae_after_deg < 9.0


def test_injection_keeps_to_the_protocol():
    for seed in range(20):
        rng = clip_random_generator(seed, "walk")
        targets = draw_targets(CHAINS, rng)
        a, b = targets
        assert not {a.parent, a.child} & {b.parent, b.child}
        errors = draw_errors(WALK.motion, targets, rng)
        for target in targets:
            own = [e for e in errors if e.chain == target.name]
            assert 2 <= len(own) <= 5
            for e, following in pairwise(own):
                assert following.start - e.stop >= 2
            for e in own:
                assert 1 <= e.stop - e.start <= 20
                assert e.start >= 2
                assert e.stop < WALK.motion.frames
                assert 5.0 <= abs(np.degrees(e.offset[0])) <= 180.0


def test_a_seed_gives_the_same_errors_again():
    def draw():
        rng = clip_random_generator(7, "some/where/walk.bvh")
        return [
            (e.chain, e.start, e.stop, e.offset[0]) for e in draw_errors(WALK.motion, CHAINS, rng)
        ]

    assert draw() == draw()
    rng = clip_random_generator(8, "walk.bvh")
    assert draw() != [
        (e.chain, e.start, e.stop, e.offset[0]) for e in draw_errors(WALK.motion, CHAINS, rng)
    ]


def test_intervals_cut_the_running_sum_and_show_what_is_left():
    offset = np.radians([0, 0, 50, 50, 80, 80, 2, 2, 2, -40, -40])
    first, last = intervals_of_offset("c", offset, np.radians(5.0))
    assert (first.start, first.stop, last.start, last.stop) == (2, 6, 9, 11)
    np.testing.assert_allclose(np.degrees(first.offset), [50, 50, 80, 80])
    assert np.degrees(first.residual) == pytest.approx(2.0)
    np.testing.assert_allclose(np.degrees(last.offset), [-42, -42])


def test_an_event_is_exactly_where_the_strength_reaches_tau(dirty_walk):
    analysis = PaperDetector().analyse(dirty_walk.motion, CHAINS)
    for name, signals in analysis.signals.items():
        for tau in np.radians([1.0, 5.0, 20.0]):
            jumps = np.diff(paper_detector_running_offset(signals, tau), prepend=0.0) != 0.0
            np.testing.assert_array_equal(jumps, analysis.strength(name) >= tau)


def test_circular_median_straddles_the_half_turn():
    assert np.degrees(circular_median(np.radians([179.0, -179.0, 179.5]))) == pytest.approx(179.5)
    assert circular_median(np.zeros(0)) == 0.0
