"""Joints that do not twist: where their level stands, which they are, and whose error they show."""

import math
import statistics
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from twistcore.detection.soft_errors.silent_joints import (
    _answered,
    accumulated_twist_if_silent,
    find_silent_joints,
    silent_joint_error_angles,
    silent_joint_error_ranges,
)

DEGREE = math.pi / 180.0
STILL = 2e-4 * DEGREE
FRAMES = 240


# Where a level stands


def plain_standing(own, other, cuts):
    moving = [abs(v) > 0.05 * DEGREE for v in other]
    still = [abs(v) < STILL for v in own]
    both = [a and b for a, b in zip(moving, still, strict=True)]
    if sum(moving) < 20 or sum(both) < 0.08 * sum(moving):
        return None
    larger, n = len(own) % 8, len(own) // 8
    ends = np.cumsum([0] + [n + 1] * larger + [n] * (8 - larger)).tolist()
    if sum(any(both[a:b]) for a, b in pairwise(ends)) < 4:
        return None
    level, standing = np.cumsum(own).tolist(), 0
    bounds = sorted({0, *cuts, len(level)})
    for a, b in pairwise(bounds):
        part = sorted(level[a:b])
        groups = [[w for w in part[k:] if w <= v + 0.1 * DEGREE] for k, v in enumerate(part)]
        densest = max(groups, key=len)  # the first of equals
        standing += len(densest)
        level[a:b] = [v - statistics.median(densest) for v in level[a:b]]
    return level if standing >= 0.03 * len(level) else None


@pytest.mark.parametrize("cuts", [(), (0,), (0, 50), (0, 50, 51, 170), (90,)])
def test_a_level_stands_where_it_does_for_most_frames(cuts):
    ended = set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        frames = int(rng.integers(40, 200))
        own, other = rng.standard_normal((2, frames)) * DEGREE
        own[rng.random(frames) < rng.choice([0.02, 0.08, 0.2, 0.6])] = 0.0
        own *= rng.choice([1.0, 1e-3, 0.05])
        if seed % 4 == 1:
            own[frames // rng.choice([2, 3, 4]) :] = DEGREE
        if seed % 4 == 2:
            other[int(rng.integers(15, 30)) :] = 0.049 * DEGREE
        cut = np.zeros(frames, dtype=bool)
        at = [c for c in cuts if c < frames]
        cut[at] = True
        found = accumulated_twist_if_silent(own, other, cut)
        wanted = plain_standing(own.tolist(), other.tolist(), at)
        ended.add(wanted is None)
        if wanted is None:
            assert found is None
        else:
            np.testing.assert_allclose(found, wanted, atol=1e-12)
    assert ended == {True, False}


def turns(frames=200, still=0.3, seed=0):
    """A joint that stands still in a share of the frames in which the other one moves."""
    rng = np.random.default_rng(seed)
    own, other = np.zeros(frames), np.full(frames, 0.2 * DEGREE)
    lively = rng.permutation(frames)[: round((1.0 - still) * frames)]
    own[lively] = 1e-3 * DEGREE * rng.choice([-1.0, 1.0], len(lively))
    return own, other


def stands(own, other):
    return accumulated_twist_if_silent(own, other, np.zeros(len(own), dtype=bool)) is not None


def test_a_level_stands_only_beside_a_joint_that_moves():
    own, other = turns()
    assert stands(own, other)
    assert not stands(own, 0.24 * other)
    assert not stands(own, -0.25 * other)  # to the number: it does not move
    assert stands(own, -0.26 * other)
    for many in (19, 20):
        moves = np.zeros(200)
        moves[: 10 * many : 10] = 1.0
        assert stands(0.0 * own, moves) == (many == 20)


@pytest.mark.parametrize(("still", "enough"), [(0.075, False), (0.08, True), (0.085, True)])
def test_a_level_stands_still_in_a_twelfth_of_the_frames_at_least(still, enough):
    own, other = turns(still=still)
    assert stands(own, other) == enough
    assert not stands(own + STILL, other)
    assert stands(np.where(own == 0.0, 0.99 * STILL, own), other) == enough
    assert not stands(np.where(own == 0.0, 1.0 * STILL, own), other)


@pytest.mark.parametrize(("parts", "enough"), [(3, False), (4, True), (8, True)])
def test_a_level_stands_still_in_half_of_the_parts_of_a_clip(parts, enough):
    own, other = np.full(200, 1e-3 * DEGREE), np.full(200, 0.2 * DEGREE)
    own[: 25 * parts] = 0.0
    assert stands(own, other) == enough


@pytest.mark.parametrize(("many", "enough"), [(5, False), (6, True), (7, True)])
def test_a_level_stands_for_three_in_a_hundred_frames(many, enough):
    """Everywhere else it jumps on by more than it may be off."""
    own, other = np.full(200, 0.2 * DEGREE), np.full(200, 0.2 * DEGREE)
    own[1:200:2] *= -1.0 + 1e-6
    own = np.where(np.arange(200) % 12 == 0, 0.0, own)  # it stands still, never at one level
    level = np.arange(200) * 0.5 * DEGREE
    level[::12] = level[1::12]
    level[50 : 50 + many] = 300.0 * DEGREE
    own = np.diff(level, prepend=0.0)
    found = accumulated_twist_if_silent(own, other, np.zeros(200, dtype=bool))
    assert (found is not None) == enough
    if enough:
        np.testing.assert_allclose(found, level - 300.0 * DEGREE, atol=1e-9)


# Runs in which it is off


def plain_runs(level, cuts):
    def between(a, b):
        return not any(a < c <= b for c in cuts)

    runs = []
    for t, v in enumerate(level):
        if abs(v) > 0.1 * DEGREE:
            if runs and runs[-1][-1] == t - 1 and between(t - 1, t):
                runs[-1].append(t)
            else:
                runs.append([t])
    out = []
    for run in runs:
        low = max([c for c in cuts if c <= run[0]], default=0)
        high = min([c for c in cuts if c > run[-1]], default=len(level))
        start, stop = max(run[0] - 2, low), min(run[-1] + 3, high)
        if max(abs(v) for v in level[start:stop]) > 1.5 * DEGREE and high - low >= 8:
            out.append((start, stop))
    return out


@pytest.mark.parametrize("seed", range(30))
def test_frames_in_which_a_level_is_off(seed):
    rng = np.random.default_rng(seed)
    level = np.zeros(120)
    for _ in range(6):
        a, n = int(rng.integers(0, 118)), int(rng.integers(1, 25))
        level[a : a + n] = rng.choice([0.05, 0.11, 1.4, 1.6, -30.0]) * DEGREE
    cuts = sorted({0, *rng.integers(1, 120, 3).tolist(), *rng.integers(60, 70, 2).tolist()})
    if seed % 3 == 0:
        cuts = []
    cut = np.zeros(120, dtype=bool)
    cut[cuts] = True
    found = silent_joint_error_ranges(level, cut)
    assert found == plain_runs(level.tolist(), cuts)
    assert all(type(v) is int for run in found for v in run)


def test_a_level_that_stands_is_never_off():
    nowhere = np.zeros(40, dtype=bool)
    assert silent_joint_error_ranges(np.full(40, 0.1 * DEGREE), nowhere) == []
    level = np.zeros(40)
    level[[0, 20, 39]] = 2.0 * DEGREE
    assert silent_joint_error_ranges(level, nowhere) == [(0, 3), (18, 23), (37, 40)]
    again = level.copy()
    again[22] = -2.0 * DEGREE  # parted by one frame
    assert silent_joint_error_ranges(again, nowhere) == [(0, 3), (18, 23), (20, 25), (37, 40)]
    for many in (7, 8):
        cut = nowhere.copy()
        cut[[15, 15 + many]] = True
        found = silent_joint_error_ranges(level, cut)
        assert found == [(0, 3), *([(18, 15 + many)] if many > 7 else []), (37, 40)]


# Which joints are silent


def read_only(x, y, count=1, cut=None):
    """What is asked of a surprise by those who only look at its increments."""
    rows, frames = x.shape
    cut = np.zeros(frames, dtype=bool) if cut is None else cut
    limbs = SimpleNamespace(count=count, step=0.0)

    def neighbours(row):
        return [r for r in (row - count, row, row + count) if 0 <= r < rows]

    return SimpleNamespace(
        x=x, y=y, rows=rows, frames=frames, cut=cut, limbs=limbs, neighbours=neighbours
    )


def plain_sides(x, y, count):
    rows, still, answered = len(x), {}, set()
    for row in range(rows):
        for side, own, other in ((1, x[row], y[row]), (-1, y[row], x[row])):
            if plain_standing(own.tolist(), other.tolist(), []) is None:
                continue
            still[row, side] = float(np.mean(np.abs(own) < STILL))
            at = np.abs(own) >= STILL
            if np.abs(own + other)[at].sum() <= 1.25 * np.abs(other)[at].sum():
                answered.add((row, side))
    found = {}
    for (row, side), share in still.items():
        mirror = (row - side * count, -side)
        trusted = share >= 0.75 or (row, side) in answered or mirror in answered
        if trusted and share >= still.get((row, -side), 0.0):
            found[row] = side
    for row, side in list(found.items()):
        beside = row - side * count
        if 0 <= beside < rows and beside not in found:
            found[row] = None
    return {r: s for r, s in found.items() if s is not None}


@pytest.mark.parametrize("count", [1, 2])
def test_which_joints_are_silent(count):
    seen = set()
    for seed in range(150):
        rng = np.random.default_rng(seed)
        rows = 3 * count
        x, y = rng.standard_normal((2, rows, 80)) * DEGREE
        for row in range(rows):
            kind = rng.integers(0, 6)
            one, other = (x, y) if rng.random() < 0.5 else (y, x)
            off = rng.random(80) < rng.choice([0.2, 0.3, 0.7])
            if kind < 3:
                one[row] = np.where(off, -1.0 * other[row] if kind else one[row], 0.0)
            if kind == 3:
                x[row, rng.random(80) < 0.5] = 0.0
                y[row, rng.random(80) < 0.6] = 0.0
        found = find_silent_joints(read_only(x, y, count))
        assert found == plain_sides(x, y, count)
        seen.add(tuple(sorted(found.values())))
    assert len(seen) >= 4


@pytest.mark.parametrize(("times", "answered"), [(0.24, True), (0.26, False)])
def test_a_joint_is_answered_where_little_more_is_left_than_the_other_one_turns(times, answered):
    other = np.array([1.0, -2.0, 0.5, 9.0])
    own = np.array([times, -times * 2.0, times * 0.5, 0.0])
    assert _answered(own, other) == answered  # the last frame does not count: it stands still
    assert _answered(-own, other)
    assert _answered(np.array([STILL, 0.0]), np.array([4.0 * STILL, 1.0]))
    assert not _answered(np.array([STILL, 0.0]), np.array([3.9 * STILL, 1.0]))


def test_the_level_of_a_silent_child_is_the_errors_other_side():
    x = np.full((1, 80), 0.3 * DEGREE)
    y = np.zeros((1, 80))
    y[0, 30], y[0, 65] = -0.4, 0.4
    level = np.zeros(80)
    level[30:65] = 0.4
    np.testing.assert_allclose(silent_joint_error_angles(read_only(x, y), 0, -1), level, atol=1e-12)
    np.testing.assert_allclose(silent_joint_error_angles(read_only(y, x), 0, 1), -level, atol=1e-12)
    assert silent_joint_error_angles(read_only(y, x), 0, -1) is None
    assert silent_joint_error_angles(read_only(x, y), 0, 1) is None
    cut = np.zeros(80, dtype=bool)
    cut[32] = True
    found = silent_joint_error_angles(read_only(x, y, cut=cut), 0, -1)
    np.testing.assert_allclose(found[:32], level[:32], atol=1e-12)
    np.testing.assert_allclose(found[32:], level[32:] - 0.4, atol=1e-12)  # mostly there
