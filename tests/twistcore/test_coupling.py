"""Chains of one line explained together: the cheapest set, on lines of any length."""

from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from twistcore.analysis.clip_analysis import detect
from twistcore.detection.counter_twist import coupling
from twistcore.detection.counter_twist.coupling import (
    ANOTHER_ACTIVE,
    CHAIN_ACTIVE,
    HINGE,
    JOINT_JUMP,
    remove_neighbour_errors,
)
from twistcore.detection.limbs import Limbs
from twistcore.detection.prediction import FLOOR
from twistcore.detection.robust_cost import CAP, residual_cost
from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import (
    conjugate,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    quaternion_from_euler,
    twist_angle,
    wrap,
)
from twistcore.synthesis import InjectedError, inject

seeds = st.integers(0, 2**32 - 1)


@dataclass(frozen=True)
class Line:
    """The parameters of `remove_neighbour_errors`.

    joints (n + 1, limbs, frames, 4), axes (n, limbs, 3)
    """

    joints: np.ndarray
    axes: np.ndarray
    t: np.ndarray
    signals: np.ndarray
    predicted: np.ndarray
    sigma: np.ndarray

    def explained(self) -> np.ndarray:
        given = self.t, self.signals, self.predicted, self.sigma
        return remove_neighbour_errors(Limbs(self.joints, self.axes), *given)


def small_turns(rng, degrees, *shape):
    angles = np.radians(degrees) * rng.standard_normal((*shape, 1))
    return quaternion_from_axis_angle(normalise(rng.standard_normal((*shape, 3))), angles[..., 0])


def line_of(n: int, seed: int, frames: int = 5, errors: float = 0.3, jumps: float = 0.1) -> Line:
    """Lines of n chains of which every frame has twist errors and joints that jump."""
    rng = np.random.default_rng(seed)
    pose = normalise(rng.standard_normal((n + 1, 2, 1, 4)))
    joints = multiply(pose, small_turns(rng, 2.0, n + 1, 2, frames))
    axes = normalise(rng.standard_normal((n, 2, 3)))
    if rng.random() < 0.3:  # straight limbs: an image looks most like an error
        axes[:], joints = axes[:1], small_turns(rng, 2.0, n + 1, 2, frames)
    calm = Limbs(joints, axes).increments()
    delta = rng.uniform(-np.pi, np.pi, (n, 2, frames)) * (rng.random((n, 2, frames)) < errors)
    for k in range(n):
        turn = quaternion_from_axis_angle(axes[k][:, None], delta[k])
        joints[k] = multiply(joints[k], turn)
        joints[k + 1] = multiply(conjugate(turn), joints[k + 1])
    jump = small_turns(rng, 40.0, n + 1, 2, frames)
    jump[rng.random(jump.shape[:-1]) > jumps] = 1.0, 0.0, 0.0, 0.0
    joints = multiply(joints, jump)
    sigma = FLOOR * np.exp(rng.uniform(0.0, 5.0, calm.shape))
    predicted = wrap(calm + sigma * rng.standard_normal(calm.shape))
    t = (np.arange(2 * frames).reshape(2, -1)[:, 1:]).ravel()
    given = (Limbs(joints, axes).increments(), predicted, sigma)
    return Line(joints, axes, t, *(v.reshape(2, n, -1)[..., t] for v in given))


# The reference: every set of chains


def enumerated(line: Line) -> np.ndarray:
    """What `remove_neighbour_errors` says, from all 2ⁿ sets of chains."""
    n, frames = len(line.axes), len(line.t)
    all_runs = [(i, j) for i in range(n) for j in range(i, n)]
    solved = {(i, j): solved_run(range(i, j + 1), line) for i, j in all_runs}
    idle = joint_costs(line.signals, np.zeros((n, frames)), line)
    best, clean = np.full(frames, np.inf), line.signals.copy()
    for active in sorted(product((False, True), repeat=n), key=sum):
        trial, cost = line.signals.copy(), idle.copy()
        for i, j in runs_of(active):
            trial[0, i + 1 : j + 2] = solved[i, j][0][0, i + 1 : j + 2]
            trial[1, max(i - 1, 0) : j] = solved[i, j][0][1, max(i - 1, 0) : j]
            cost[i : j + 2] = solved[i, j][1][i : j + 2]
        total = CHAIN_ACTIVE * sum(active) + ANOTHER_ACTIVE * max(0, sum(active) - 1)
        total = total + cost.sum(axis=0)
        better = total < best - 1e-9
        best[better], clean[..., better] = total[better], trial[..., better]
    return clean


def runs_of(active):
    """First and last of the neighbours in a row that are true."""
    edges = np.flatnonzero(np.diff([0, *active, 0]))
    return [(int(a), int(b) - 1) for a, b in edges.reshape(-1, 2)]


def solved_run(on, line):
    """Increments (2, n, frames) and costs by joint, in the cheaper order of solution."""
    found = []
    for tip_first in (False, True):
        d = np.zeros(line.signals.shape[1:])
        for sweep in range(4):
            for k in reversed(on) if tip_first else on:
                x, y = without_images(d, on, line)[:, k]
                rx, ry = wrap(x - line.predicted[0, k]), wrap(y - line.predicted[1, k])
                weight = line.sigma[0, k] ** 2 / (line.sigma[:, k] ** 2).sum(axis=0)
                d[k] = wrap(rx - wrap(rx + ry) * weight)
                if sweep == 0 and not tip_first and k + 1 in on:
                    d[k] = rx
                if sweep == 0 and tip_first and k - 1 in on:
                    d[k] = -ry
        trial = without_images(d, on, line)
        found.append((trial, joint_costs(trial, d, line)))
    (root, root_cost), (tip, tip_cost) = found
    better = tip_cost.sum(axis=0) < root_cost.sum(axis=0) - 1e-9
    return np.where(better, tip, root), np.where(better, tip_cost, root_cost)


def without_images(d, on, line):
    """Increments (2, n, frames) where the joints turn back by their chains' errors d."""
    out = line.signals.copy()
    q = line.joints.reshape(len(line.joints), -1, 4)
    before, now, axes = q[:, line.t - 1], q[:, line.t], line.axes[:, line.t // line.joints.shape[2]]
    for k in on:
        turn = quaternion_from_axis_angle(axes[k], d[k])
        if k + 1 < len(axes):
            moved = multiply(conjugate(before[k + 1]), multiply(turn, now[k + 1]))
            out[0, k + 1] = twist_angle(moved, axes[k + 1])
        if k > 0:
            moved = multiply(multiply(now[k], conjugate(turn)), conjugate(before[k]))
            out[1, k - 1] = twist_angle(moved, axes[k - 1])
    return out


def joint_costs(trial, d, line):
    """What is left over costs, (n + 1, frames)."""
    n, frames = d.shape
    rarer = np.maximum(np.log(HINGE / line.sigma), 0.0)
    residual = wrap(trial - line.predicted - np.stack([d, -d]))
    x, y = residual_cost(residual / line.sigma, CAP + rarer)
    cost = np.zeros((n + 1, frames))
    cost[:-1] += x
    cost[1:] += y
    cost[1:-1] = np.minimum(cost[1:-1], JOINT_JUMP + np.minimum(rarer[0, 1:], rarer[1, :-1]))
    return cost


@settings(max_examples=examples(40))
@given(st.integers(1, 6), seeds, st.sampled_from([0.1, 0.3, 0.8]), st.sampled_from([0.0, 0.2]))
def test_the_cheapest_of_all_sets_of_chains_is_found(n, seed, errors, jumps):
    line = line_of(n, seed, errors=errors, jumps=jumps)
    np.testing.assert_allclose(wrap(line.explained() - enumerated(line)), 0.0, atol=1e-6)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_few_chains_are_explained_as_all_sets_say(n):
    """The same at once, for one seed a length."""
    line = line_of(n, 100 + n, frames=20, errors=0.5, jumps=0.2)
    np.testing.assert_allclose(wrap(line.explained() - enumerated(line)), 0.0, atol=1e-6)


@pytest.mark.thorough
def test_the_lines_that_are_compared_have_runs_of_several_chains_and_several_runs():
    """Or the comparison with all sets would say little."""
    changed = [
        (line.explained() != line.signals)[0, :, i]
        for line in (line_of(6, seed) for seed in range(20))
        for i in range(len(line.t))
    ]
    assert sum(len(runs_of(c)) > 1 for c in changed) > 10
    assert sum(any(j > i for i, j in runs_of(c)) for c in changed) > 10


# Long lines


def test_a_joint_costs_less_than_another_chain_with_an_error():
    """Otherwise runs of any length might pay, and the work would not be in proportion."""
    assert JOINT_JUMP + np.log(HINGE / FLOOR) < CHAIN_ACTIVE + ANOTHER_ACTIVE
    assert CAP < JOINT_JUMP


@pytest.mark.parametrize("errors", [0.02, 0.3, 0.9])
def test_a_line_twice_as_long_is_twice_the_work(monkeypatch, errors):
    work = []
    solved = coupling._solved

    def counted(line, first, length, frame):
        work.append(length * len(first))
        return solved(line, first, length, frame)

    monkeypatch.setattr(coupling, "_solved", counted)

    def work_on(n):
        work.clear()
        line_of(n, 3, errors=errors).explained()
        return sum(work)

    short = work_on(100)
    assert short > 0
    assert work_on(400) == pytest.approx(4 * short, rel=0.25)


def test_memory_is_bounded_by_blocks_of_frames_that_change_nothing(monkeypatch):
    line = line_of(6, 5, frames=20)
    whole = line.explained()
    sizes = []
    explained = coupling._explained

    def measured(part):
        sizes.append(len(part.t))
        return explained(part)

    monkeypatch.setattr(coupling, "_explained", measured)
    monkeypatch.setattr(coupling, "_BLOCK", 6 * 7)
    np.testing.assert_array_equal(line.explained(), whole)
    assert max(sizes) == 7
    assert sum(sizes) == len(line.t)


def rig(*lengths: int, frames: int = 300) -> tuple[Motion, tuple[Chain, ...]]:
    """Lines of joints from one root, moving smoothly with a little noise."""
    rng = np.random.default_rng(7)
    parents = [-1]
    for n in lengths:
        parents += [0, *range(len(parents), len(parents) + n - 1)]
    joints = len(parents)
    offsets = rng.normal([0.0, 5.0, 0.0], 1.0, (joints, 3))
    t = np.arange(frames)[:, None, None] / 60.0
    rate, phase = rng.uniform(0.5, 6.0, (joints, 3)), rng.uniform(0.0, 6.0, (joints, 3))
    angles = 0.2 * np.sin(rate * t + phase) + 0.001 * rng.standard_normal((frames, joints, 3))
    skeleton = Skeleton(tuple(f"J{j}" for j in range(joints)), np.array(parents), offsets)
    rotations = quaternion_from_euler("ZXY", angles)
    motion = Motion(skeleton, rotations, (0,), np.zeros((frames, 1, 3)), 1.0 / 60.0)
    return motion, find_chains(motion)


def errors_in(chains) -> list[InjectedError]:
    rng = np.random.default_rng(11)
    return [
        InjectedError(c.name, start, start + 9, np.full(9, rng.choice([-1.0, 1.0]) * delta))
        for c in chains
        for start, delta in ((int(rng.integers(20, 270)), rng.uniform(0.3, 2.5)),)
    ]


@pytest.mark.thorough
def test_every_error_along_a_line_of_60_joints_is_found():
    motion, chains = rig(60)
    assert len(chains) >= 57
    assert not detect(motion, chains)
    errors = errors_in(chains)
    found = detect(inject(motion, chains, errors), chains)
    assert [(i.chain, i.start, i.stop) for i in found] == [
        (e.chain, e.start, e.stop) for e in errors
    ]
    for interval, error in zip(found, errors, strict=True):
        assert np.degrees(np.abs(wrap(interval.offset - error.offset)).max()) < 1.0


@pytest.mark.thorough
def test_lines_of_unequal_length_do_not_know_each_other():
    motion, chains = rig(25, 7, 4, 4)
    dirty = inject(motion, chains, errors_in(chains))
    together = detect(dirty, chains)
    starts = [k for k, c in enumerate(chains) if motion.skeleton.parents[c.parent] == 0]
    lines = [chains[a:b] for a, b in pairwise([*starts, len(chains)])]
    assert len({len(line) for line in lines}) > 2
    alone = [i for line in lines for i in detect(dirty, line)]
    assert len(together) == len(alone) == len(chains)
    for one, other in zip(together, alone, strict=True):
        assert (one.chain, one.start, one.stop) == (other.chain, other.start, other.stop)
        np.testing.assert_array_equal(one.offset, other.offset)
