"""Errors of straight spells beside what jumps explain: which spells, and which jumps stay."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.twistcore.counters import ROW, counter_of
from tests.twistcore.test_straight_limbs import erring, level, straightening, thigh
from tests.twistcore.test_straight_limbs import spells as straight_frames
from twistcore.detection.counter_twist.edges import find_interval_edges_and_steps
from twistcore.detection.counter_twist.offsets import interval_twist_errors_over_time
from twistcore.detection.counter_twist.pairing import (
    best_edge_pairs,
    edge_pair_table,
    running_counter_rotation_sums,
)
from twistcore.detection.straight_limbs.straight_claims import (
    Jumps,
    StraightLimb,
    _error_of,
    _is_nearer_hinge,
    _Jumping,
    _without,
    find_straight_limb_errors,
)
from twistcore.detection.straight_limbs.straight_course import twist_increment_change_scale
from twistcore.detection.straight_limbs.straight_spells import (
    Bend,
    find_straight_ranges,
    limb_bend_per_frame,
)
from twistcore.skeleton.twist_increments import twist_increments

DEGREE = math.pi / 180.0
FRAMES = 120


# Jumps


def jumps_of(seed, tau=2.0):
    counter = counter_of(seed, frames=FRAMES, jumps=0.06)
    edges, step = find_interval_edges_and_steps(counter, ROW)
    sums = running_counter_rotation_sums(counter, ROW, step)
    tables = tuple(edge_pair_table(edges, sums, a, b) for a, b in ((0, 70), (70, FRAMES)))
    return Jumps(counter, ROW, edges, step, tables, tau * DEGREE, 60.0)


def assert_same(table, other):
    assert (table.low, table.high) == (other.low, other.high)
    np.testing.assert_array_equal(table.edges.start, other.edges.start)
    for one, two in zip(table.blocks, other.blocks, strict=True):
        np.testing.assert_array_equal(one.gain, two.gain)
        np.testing.assert_array_equal(one.follows, two.follows)


@pytest.mark.parametrize("seed", range(8))
def test_jumps_are_the_intervals_of_all_segments(seed):
    jumps = jumps_of(seed)
    found, total = jumps.found(), np.zeros(FRAMES)
    wanted = []
    for table in jumps.tables:
        pairs = best_edge_pairs(table, jumps.tau, 60.0)
        courses = interval_twist_errors_over_time(pairs, table, jumps.counter, ROW, jumps.step)
        for pair, own in zip(pairs, courses, strict=True):
            ends = [k for k in (pair.opening, pair.closing) if k >= 0]
            wanted.append((own.start, tuple(int(table.edges.peak[k]) for k in ends), own.offset))
    assert [(j.start, j.peaks) for j in found] == [w[:2] for w in wanted]
    for j, (start, _, offset) in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(j.offset, offset)
        assert j.frames == slice(start, start + len(offset))
        for n, value in enumerate(offset):
            total[start + n] += value
        assert all(type(p) is int for p in j.peaks)
    np.testing.assert_allclose(jumps.offset(), total)


def test_some_intervals_reach_a_border():
    found = [j for seed in range(8) for j in jumps_of(seed).found()]
    assert {len(j.peaks) for j in found} == {1, 2}


@pytest.mark.parametrize("seed", range(4))
def test_jumps_without_edges_are_paired_anew(seed):
    jumps = jumps_of(seed)
    peaks = np.zeros(FRAMES, dtype=bool)
    peaks[[p for j in jumps.found()[::2] for p in j.peaks]] = True
    left = jumps.without(peaks)
    kept = [k for k, p in enumerate(jumps.edges.peak.tolist()) if not peaks[p]]
    assert len(kept) < len(jumps.edges)
    np.testing.assert_array_equal(left.edges.peak, jumps.edges.peak[kept])
    sums = running_counter_rotation_sums(jumps.counter, ROW, jumps.step)
    for table, old in zip(left.tables, jumps.tables, strict=True):
        assert_same(table, edge_pair_table(left.edges, sums, old.low, old.high))
    assert (left.counter, left.row, left.tau, left.fps) == (jumps.counter, ROW, jumps.tau, 60.0)
    assert not any(peaks[p] for j in left.found() for p in j.peaks)


# What an error leaves of them


class Paired:
    """Jumps that are other ones each time that some are left out; notes which those were."""

    def __init__(self, found, asked):
        self._found, self._asked = found, asked

    def without(self, peaks):
        self._asked.append(set(np.flatnonzero(peaks).tolist()))
        return Paired(self._found[1:], self._asked)

    def found(self):
        return self._found[0]


def test_jumps_that_the_bent_limb_gainsays_are_left_out_round_by_round():
    azimuth = np.zeros(FRAMES)
    azimuth[20:30] = -0.5
    bend = Bend(np.full(FRAMES, 1.0), azimuth, 0.01)
    right = _Jumping(20, np.full(10, 0.5), (20, 30))
    wrong = [_Jumping(t, np.full(8, 0.5), (t, t + 8)) for t in (40, 60, 80, 100)]
    straight = Bend(np.full(FRAMES, 0.1), azimuth, 0.01)
    assert [_is_nearer_hinge(j, bend) for j in (right, *wrong)] == [True] + [False] * 4
    assert _is_nearer_hinge(wrong[0], straight) is None
    claimed = np.zeros(FRAMES, dtype=bool)
    claimed[3:6] = True
    limb = StraightLimb((), claimed, bend)
    asked = []
    rounds = [[], [right, wrong[0], wrong[1]], [right, wrong[2]], [right]]
    assert limb.leaves(Paired(rounds, asked)).found() == [right]
    assert asked == [{3, 4, 5}, {3, 4, 5, 40, 48, 60, 68}, {3, 4, 5, 40, 48, 60, 68, 80, 88}]
    asked.clear()
    rounds = [[], [wrong[0]], [wrong[1]], [wrong[2]], [wrong[3]]]
    assert limb.leaves(Paired(rounds, asked)).found() == [wrong[2]]
    assert len(asked) == 3
    asked.clear()
    assert limb.leaves(Paired([[], [right]], asked)).found() == [right]
    assert asked == [{3, 4, 5}]
    asked.clear()
    StraightLimb((), claimed, straight).leaves(Paired([[], wrong], asked))
    assert asked == [{3, 4, 5}]
    assert np.flatnonzero(claimed).tolist() == [3, 4, 5]


# The errors of a limb


FPS = 30.0
CLEAN = straightening(FPS)
SPELLS = straight_frames(CLEAN)


def asked_of(motion, bounds, found=()):
    """Jumps of a motion as a straight limb is asked beside them, and what it is told by itself."""
    chain = thigh(motion)
    joints = motion.rotations[:, chain.parent], motion.rotations[:, chain.child]
    x, y = twist_increments(*joints, chain.axis)
    tables = [SimpleNamespace(low=a, high=b) for a, b in bounds]
    counter = SimpleNamespace(x=np.stack([0.0 * x, x]), y=np.stack([0.0 * y, y]))
    jumps = SimpleNamespace(tables=tables, counter=counter, row=1, found=lambda: list(found))
    return chain, jumps, (x, y)


def plain_limb(motion, bounds, found):
    """Errors by spell, and the frames that they claim."""
    chain, _, increments = asked_of(motion, bounds)
    bend = limb_bend_per_frame(motion.rotations[:, chain.child], chain.axis, chain.arm, FPS)
    said = [(j, _is_nearer_hinge(j, bend)) for j in found]
    certain, unsaid = ([j for j, s in said if s is which] for which in (True, None))
    left = _without(increments, certain)
    scales = twist_increment_change_scale(left[0]), twist_increment_change_scale(left[1])
    errors, claimed = [], set()
    for low, high in bounds:
        for spell in find_straight_ranges(left, bend, low, high, FPS):
            beside = [j for j in unsaid if low <= j.start < high]
            own = _error_of(left, scales, beside, bend, spell, FPS)
            if own:
                errors += own
                claimed |= set(range(max(spell.start - 1, 0), min(spell.stop + 2, motion.frames)))
    return errors, claimed - {p for j in certain for p in j.peaks}


WHOLE = ((0, CLEAN.frames),)
CUT = ((0, SPELLS[1][1] + 6), (SPELLS[1][1] + 6, CLEAN.frames))


def full(frames, size=40.0):
    return level(CLEAN, frames, size * DEGREE, 0.1)


def as_jumps(offset, *peaks, share=1.0):
    at = np.flatnonzero(offset)
    return _Jumping(int(at[0]), share * offset[at[0] : at[-1] + 1], peaks)


ALL = sum(full(s) for s in SPELLS)
BENT = np.zeros(CLEAN.frames)  # an error where the limb is bent
BENT[58:64] = 35.0 * DEGREE
FOUND = {
    "nothing": [],
    "the bent error": [as_jumps(BENT, 58, 64)],
    "the bent error, whose edge lies in a claim": [as_jumps(BENT, SPELLS[0][1], SPELLS[1][0] - 1)],
    "a spell's error": [as_jumps(full(SPELLS[1]), 3)],
    "half of it": [as_jumps(full(SPELLS[1]), 3, share=0.5)],
    "two of them": [as_jumps(full(SPELLS[0]), 3), as_jumps(full(SPELLS[2]), 9)],
    "what the limb gainsays": [as_jumps(np.where(BENT > 0.0, -1.0, 0.0), 60)],
}


@pytest.mark.parametrize("bounds", [WHOLE, CUT], ids=["whole", "cut"])
@pytest.mark.parametrize("found", FOUND)
def test_errors_of_a_limb_are_those_of_its_spells_beside_the_jumps(found, bounds):
    motion = erring(CLEAN, ALL + BENT)
    chain, jumps, course = asked_of(motion, bounds, FOUND[found])
    errors, claimed = plain_limb(motion, bounds, FOUND[found])
    limb = find_straight_limb_errors(motion, chain, jumps, lambda: course)
    explained = {"a spell's error": 1, "two of them": 2}.get(found, 0)
    assert len(limb.errors) == len(errors) == len(SPELLS) - explained
    for one, other in zip(limb.errors, errors, strict=True):
        assert (one.start, one.stop, one.peak, one.closed) == (
            other.start,
            other.stop,
            other.peak,
            other.closed,
        )
        np.testing.assert_array_equal(one.offset, other.offset)
    assert limb.claimed.dtype == bool
    assert set(np.flatnonzero(limb.claimed).tolist()) == claimed
    if found == "the bent error":
        off = np.abs(limb.offset - ALL)
        assert off.max() < 4.0 * DEGREE
        assert len(errors) == len(SPELLS)


def test_a_spells_error_is_claimed_with_a_frame_on_either_side():
    motion = erring(CLEAN, full(SPELLS[1]))
    chain, jumps, course = asked_of(motion, WHOLE)
    limb = find_straight_limb_errors(motion, chain, jumps, lambda: course)
    (spell,) = (
        s
        for s in find_straight_ranges(course, limb.bend, *WHOLE[0], FPS)
        if s.start <= SPELLS[1][0] < s.stop
    )
    at = np.flatnonzero(limb.claimed)
    assert (at[0], at[-1]) == (spell.start - 1, spell.stop + 1)
    assert len(at) == spell.stop - spell.start + 3
    np.testing.assert_allclose(limb.offset, full(SPELLS[1]), atol=2.0 * DEGREE)


def test_errors_are_told_by_what_a_chain_turns_by_itself():
    """As captured a neighbour's error may show; by itself only its own does."""
    motion = erring(CLEAN, full(SPELLS[1]))
    chain, jumps, (x, y) = asked_of(motion, WHOLE)
    clean = asked_of(CLEAN, WHOLE)[2]
    assert find_straight_limb_errors(motion, chain, jumps, lambda: clean) is None
    jumps.counter.x[1], jumps.counter.y[1] = clean
    assert (
        find_straight_limb_errors(motion, chain, jumps, lambda: 1 / 0) is None
    )  # it is not even asked
    jumps.counter.x[1], jumps.counter.y[1] = x, y
    assert len(find_straight_limb_errors(motion, chain, jumps, lambda: (x, y)).errors) == 1


def test_a_chain_without_a_hinge_has_no_errors_of_a_straight_limb():
    motion = erring(CLEAN, ALL)
    chain, jumps, course = asked_of(motion, WHOLE)
    assert find_straight_limb_errors(motion, chain, jumps, lambda: course) is not None
    for grandchild in (-1, 0):
        other = replace(chain, grandchild=grandchild)
        found = find_straight_limb_errors(motion, other, jumps, lambda: course)
        assert (found is None) == (grandchild < 0)
    still = CLEAN.rotations.copy()
    still[:, chain.child] = still[0, chain.child] * 0.0 + [1.0, 0.0, 0.0, 0.0]
    never_bent = CLEAN.with_rotations(still)
    assert find_straight_limb_errors(never_bent, chain, jumps, lambda: course) is None
