"""The branch of Euler angles that is written is the shortest there is."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.twistcore.strategies import orders, quaternions
from twistcore.bvh.euler_branch import _cheapest_path, angle_jumps, continuous_angles
from twistcore.rotation import (
    euler_from_quaternion,
    geodesic_angle,
    quaternion_from_euler,
    wrap,
)

TURNS = 2 * np.pi * np.arange(-3, 4)


def length(path):
    return np.abs(np.diff(path, axis=0)).sum()


def shortest(solutions, before, after):
    """By trying every branch, and every turn of every channel."""
    best = np.inf
    for branch in itertools.product((0, 1), repeat=len(solutions)):
        chosen = solutions[np.arange(len(solutions)), list(branch)]
        total = 0.0
        for c in range(3):
            cost = np.abs(chosen[0, c] + TURNS - before[c])
            for a, b in itertools.pairwise(chosen[:, c]):
                step = np.abs((b + TURNS)[None, :] - (a + TURNS)[:, None])
                cost = (cost[:, None] + step).min(axis=0)
            total += (cost + np.abs(after[c] - chosen[-1, c] - TURNS)).min()
        best = min(best, total)
    return best


edges = st.tuples(*[st.floats(-3.0, 3.0)] * 3)
SQUARES = [[0.0, 0.0, 1.0, 1.0], [0.5, 0.0, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.75, 0.0, -1.0]]


@settings(max_examples=120, deadline=None)
@given(
    orders,
    st.lists(quaternions, min_size=1, max_size=4),
    edges,
    edges,
    st.tuples(*[st.integers(-1, 1)] * 3),
)
# Steps of just half a turn: either way is the shortest.
@example(
    "ZYX",
    [np.array(q) / np.linalg.norm(q) for q in SQUARES],
    (2.0, -1.5702653289460513, 0.0),
    (-2, -1, 0),
    (0, 0, 0),
)
def test_no_way_between_the_fixed_edges_is_shorter(order, run, before, after, turns):
    q = np.array(run)
    before, after = np.array(before, float), np.array(after) + 2 * np.pi * np.array(turns)
    first = euler_from_quaternion(order, q)
    if np.abs(np.cos(first[:, 1])).min() < 1e-3:
        return
    second = np.stack([first[:, 0] + np.pi, np.pi - first[:, 1], first[:, 2] + np.pi], axis=1)
    found = continuous_angles(order, q, np.zeros(len(q)), before, after)
    assert geodesic_angle(quaternion_from_euler(order, found), q).max() < 1e-6
    least = shortest(np.stack([first, second], axis=1), before, after)
    assert length(np.vstack([before, found, after])) <= least + 1e-6


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 8), st.booleans(), st.booleans(), st.integers(0, 2**32))
def test_no_branch_has_shorter_steps(n, with_before, with_after, seed):
    rng = np.random.default_rng(seed)
    solutions = rng.uniform(-4.0, 4.0, (n, 2, 3))
    edges = [rng.uniform(-4.0, 4.0, (k, 3)) for k in (int(with_before), int(with_after))]

    def total(branch):
        path = np.vstack([edges[0], solutions[np.arange(n), list(branch)], edges[1]])
        return np.abs(wrap(np.diff(path, axis=0))).sum()

    found = _cheapest_path(solutions, *(edge[0] if len(edge) else None for edge in edges))
    assert total(found) <= min(map(total, itertools.product((0, 1), repeat=n))) + 1e-9


def test_a_jump_that_must_stay_is_reported():
    """Both edges a turn apart and a constant pose between: one step has to take the turn."""
    q = np.tile([1.0, 0.0, 0.0, 0.0], (5, 1))
    before, after = np.zeros(3), np.array([0.0, 0.0, 2 * np.pi])
    found = continuous_angles("ZYX", q, np.zeros(5), before, after)
    steps = np.diff(np.vstack([before, found, after]), axis=0)
    ((row, channel),) = angle_jumps(found, before, after)
    assert channel == 2
    assert steps[row, channel] == pytest.approx(2 * np.pi)
    steps[row, channel] = 0.0
    np.testing.assert_allclose(steps, 0.0, atol=1e-12)  # and none but that


def test_a_long_run_with_a_turn_left_over_is_quick():
    t = np.linspace(0, 2 * np.pi, 3000)
    angles = np.stack([t, 0.3 * np.sin(t), 0 * t], axis=1)
    q = quaternion_from_euler("ZYX", angles)
    found = continuous_angles("ZYX", q, np.zeros(len(q)), np.zeros(3), np.zeros(3))
    assert len(angle_jumps(found, np.zeros(3), np.zeros(3))) == 1
