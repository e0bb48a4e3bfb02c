"""What an exercise hides: the figure shows which side of a jump is wrong, the curves do not."""

from itertools import pairwise

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import wrap
from twistcore.skeleton.signals import twist_signals
from twistcore.study.exercise import exercise_intervals_between_errors, hide_exercise_errors
from twistcore.synthesis import InjectedError, inject


@pytest.fixture(scope="module")
def clip():
    return read_bvh(ASSETS / "dance.bvh")


@pytest.mark.parametrize("seed", range(1, 21))
def test_errors_and_natural_stretches_cover_the_clip_by_turns(clip, seed):
    _, errors = hide_exercise_errors(clip.motion, find_chains(clip.motion), seed)
    natural = exercise_intervals_between_errors(errors, clip.motion.frames)
    for chain in {e.chain for e in errors}:
        both = [(i, True) for i in errors] + [(i, False) for i in natural]
        own = sorted((i.start, i.stop, wrong) for i, wrong in both if i.chain == chain)
        assert (own[0][0], own[-1][1]) == (0, clip.motion.frames)
        assert all(a[1] == b[0] and a[2] != b[2] for a, b in pairwise(own))
        assert len(own) in (5, 7)
        assert min(stop - start for start, stop, _ in own) >= 6


def increments(motion, chain):
    s = twist_signals(motion, chain)
    return np.array([s.dtheta_p, s.dtheta_c])


@pytest.mark.parametrize("seed", range(1, 9))
def test_the_curves_of_an_exercise_are_those_of_its_opposite(clip, seed):
    """The natural stretches as errors of the opposite angle would give the same curves."""
    chains = find_chains(clip.motion)
    dirty, errors = hide_exercise_errors(clip.motion, chains, seed)
    natural = exercise_intervals_between_errors(errors, clip.motion.frames)
    swapped = [InjectedError(i.chain, i.start, i.stop, i.offset) for i in natural]
    opposite = inject(clip.motion, chains, swapped)
    for chain in (c for c in chains if c.name in {e.chain for e in errors}):
        apart = wrap(increments(dirty, chain) - increments(opposite, chain))
        np.testing.assert_allclose(apart, 0.0, atol=1e-6)


def strongest_jump(motion, chain, interval):
    """The larger counter-movement at the two ends of an interval, as the paper measures it."""
    p, c = increments(motion, chain)
    m = np.where(p * c < 0.0, np.minimum(np.abs(p), np.abs(c)), 0.0)
    ends = [t for t in (interval.start, interval.stop) if 0 < t < motion.frames]
    return max(m[t] for t in ends)


def liveliest(motion, chain, interval):
    """How much both angles move inside an interval, without its ends."""
    return float(np.abs(increments(motion, chain)[:, interval.start + 1 : interval.stop]).mean())


def shortest(_, __, interval):
    return -(interval.stop - interval.start)


def first_upward(motion, chain, interval):
    """The sign with which the parent jumps at the start, or comes back at the stop."""
    p, _ = increments(motion, chain)
    at, sign = (interval.start, 1.0) if interval.start else (interval.stop, -1.0)
    return sign * float(p[at])


def at_an_end_of_the_clip(motion, _, interval):
    return float(interval.start == 0 or interval.stop == motion.frames)


RULES = strongest_jump, liveliest, shortest, first_upward, at_an_end_of_the_clip


@parametrize("rule", RULES)
def test_a_rule_over_the_curves_is_right_no_more_often_than_by_chance(rule):
    """Of the intervals of a chain, it accepts the half with the largest values."""
    right = {}
    for name in ("walk.bvh", "dance.bvh"):
        motion = read_bvh(ASSETS / name).motion
        chains = find_chains(motion)
        for seed in range(1, 61):
            dirty, errors = hide_exercise_errors(motion, chains, seed)
            listed = [*errors, *exercise_intervals_between_errors(errors, motion.frames)]
            for chain in (c for c in chains if c.name in {e.chain for e in errors}):
                own = [i for i in listed if i.chain == chain.name]
                values = np.array([rule(dirty, chain, i) for i in own])
                said = values > np.median(values)
                truth = np.array([i in errors for i in own])
                right.setdefault(seed, []).append(float((said == truth).mean()))
    shares = [np.mean(own) for own in right.values()]  # clips with the same seed are alike
    assert abs(np.mean(shares) - 0.5) < 3.0 * np.std(shares) / np.sqrt(len(shares)) < 0.2


def test_a_clip_too_short_for_two_jumps_hides_nothing(clip):
    motion = clip.motion.sliced(0, 17)
    assert hide_exercise_errors(motion, find_chains(motion), 1)[1] == ()
    assert exercise_intervals_between_errors((), 17) == ()
