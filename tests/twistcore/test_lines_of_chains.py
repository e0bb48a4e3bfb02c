"""Lines of chains as the detector strings them together, their segments, and their images."""

import itertools
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.detection.consistency.chain_analysis import SMALLEST_TAU, automatic_tau
from twistcore.detection.consistency.detector import (
    _alike,
    _by_itself,
    _fixed_soft,
    _fixed_straight,
    _limbs,
    _lines,
    find_jumps,
)
from twistcore.detection.counter_twist.edges import find_interval_edges_and_steps
from twistcore.detection.cuts import segments_between
from twistcore.detection.detectors.consistency import ConsistencyDetector
from twistcore.detection.limbs import Limbs
from twistcore.detection.soft_errors import SoftError
from twistcore.detection.straight_limbs import StraightError, remove_twist_errors
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import (
    conjugate,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    twist_angle,
)
from twistcore.skeleton.twist_increments import twist_increments

WALK = read_bvh(ASSETS / "walk.bvh").motion.sliced(1, 80)
CHAINS = find_chains(WALK)


def random_limbs(n, count, frames, varying, seed=0):
    rng = np.random.default_rng(seed)
    joints = normalise(rng.standard_normal((n + 1, count, frames, 4)))
    shape = (n, count, frames, 3) if varying else (n, count, 3)
    return Limbs(joints, normalise(rng.standard_normal(shape)))


def axis_of(limbs, k, i):
    return np.broadcast_to(limbs.axes[k, i], (limbs.frames, 3))


# Lines


@pytest.mark.parametrize("seed", range(4))
def test_lines_are_strung_from_the_first_joint_to_the_last_in_any_order(seed):
    order = np.random.default_rng(seed).permutation(len(CHAINS))
    lines = _lines([CHAINS[k] for k in order])
    assert sorted(c.name for line in lines for c in line) == sorted(c.name for c in CHAINS)
    for line in lines:
        assert all(a.child == b.parent for a, b in itertools.pairwise(line))
        assert not any(c.child == line[0].parent for c in CHAINS)
        assert not any(c.parent == line[-1].child for c in CHAINS)


def test_lines_of_a_length_and_kind_go_together():
    arm, leg = (next(c for c in CHAINS if c.segment == s) for s in ("Arm", "UpLeg"))
    moving = replace(leg, axis=np.tile(leg.axis, (WALK.frames, 1)))
    alike = _alike([[arm], [arm, leg], [leg], [moving], [leg, arm], [leg, moving]])
    assert [[len(line) for line in lines] for lines in alike] == [[1, 1], [2, 2], [1], [2]]
    assert alike[2][0][0] is moving


@pytest.mark.parametrize("varying", [False, True])
def test_limbs_have_the_rotations_and_axes_of_their_chains(varying):
    lines = max(_alike(_lines(CHAINS)), key=lambda lines: (len(lines[0]), len(lines)))
    if varying:
        last = lines[-1][-1]
        lines[-1][-1] = replace(last, axis=np.tile(last.axis, (WALK.frames, 1)))
    limbs = _limbs(lines, WALK)
    assert (len(limbs), limbs.count, limbs.frames) == (len(lines[0]), len(lines), WALK.frames)
    assert limbs.axes.ndim == (4 if varying else 3)
    x, y = limbs.increments()
    for i, line in enumerate(lines):
        for k, chain in enumerate(line):
            q_p, q_c = (WALK.rotations[:, j] for j in (chain.parent, chain.child))
            row = k * len(lines) + i
            wanted = twist_increments(q_p, q_c, axis_of(limbs, k, i))
            np.testing.assert_allclose((x[row], y[row]), wanted, atol=1e-12)
            np.testing.assert_array_equal(limbs.joints[k, i], q_p)
            np.testing.assert_array_equal(limbs.joints[k + 1, i], q_c)


def test_increments_are_twists_of_relative_rotations():
    limbs = random_limbs(1, 1, 40, varying=True)
    (x,), (y,) = limbs.increments()
    (q_p,), (q_c,) = limbs.joints
    axis = axis_of(limbs, 0, 0)[1:]
    assert x[0] == y[0] == 0.0
    np.testing.assert_allclose(
        x[1:], twist_angle(multiply(conjugate(q_p[:-1]), q_p[1:]), axis), atol=1e-9
    )
    np.testing.assert_allclose(
        y[1:], twist_angle(multiply(q_c[1:], conjugate(q_c[:-1])), axis), atol=1e-9
    )


# Segments


@pytest.mark.parametrize(
    ("fps", "cuts", "wanted"),
    [
        (120.0, [], [(0, 200)]),
        (120.0, [30, 60], [(0, 30), (30, 60), (60, 200)]),
        (120.0, [29, 60], [(29, 60), (60, 200)]),
        (120.0, [171], [(0, 171)]),
        (120.0, [170], [(0, 170), (170, 200)]),
        (30.0, [8, 9, 17], [(0, 8), (9, 17), (17, 200)]),
        (30.0, [7, 193], [(7, 193)]),
        (4.0, [1, 3, 4], [(1, 3), (4, 200)]),
    ],
)
def test_segments_lie_between_cuts_and_are_not_too_short_to_tell(fps, cuts, wanted):
    cut = np.zeros(200, dtype=bool)
    cut[cuts] = True
    assert list(segments_between(cut, fps)) == wanted


@pytest.mark.parametrize(("frames", "wanted"), [(0, []), (1, []), (2, [(0, 2)]), (5, [(0, 5)])])
def test_a_clip_shorter_than_a_segment_is_one(frames, wanted):
    assert list(segments_between(np.zeros(frames, dtype=bool), 120.0)) == wanted


# Turned joints, images


@pytest.mark.parametrize("varying", [False, True])
def test_children_are_turned_in_the_frame_of_their_parents(varying):
    limbs = random_limbs(3, 2, 30, varying)
    angle = np.linspace(-1.0, 2.0, 7)
    turned = limbs.turned([(1, 4, angle), (4, 20, -angle)])  # chain 0 of limb 1, chain 2 of limb 0
    wanted = limbs.joints.copy()
    for k, i, start, by in ((0, 1, 4, angle), (2, 0, 20, -angle)):
        for n, a in enumerate(by):
            turn = quaternion_from_axis_angle(axis_of(limbs, k, i)[start + n], a)
            wanted[k + 1, i, start + n] = multiply(turn, wanted[k + 1, i, start + n])
    same = np.abs(np.einsum("...c,...c->...", turned.joints, wanted))
    np.testing.assert_allclose(same, 1.0, atol=1e-12)
    np.testing.assert_array_equal(turned.axes, limbs.axes)
    assert not np.array_equal(turned.joints, limbs.joints)


@pytest.mark.parametrize("varying", [False, True])
@pytest.mark.parametrize("length", [1, 2, 3])
def test_images_are_what_neighbours_show_of_an_error_that_is_turned_back(varying, length):
    limbs = random_limbs(3, 2, 12, varying, seed=length)
    rng = np.random.default_rng(1)
    t = np.array([1, 5, 11, 13, 20, 23])
    first = rng.integers(0, 4 - length, len(t))
    down, up = limbs.images(first, length, t)
    angle = rng.uniform(-3.0, 3.0, (length, len(t)))
    x, y = down(angle), up(angle)
    for s in range(length):
        np.testing.assert_allclose(down(angle[s], s), x[s], atol=1e-12)
        np.testing.assert_allclose(up(angle[s], s), y[s], atol=1e-12)
        for n in range(len(t)):
            k, (i, frame) = int(first[n]) + s, divmod(int(t[n]), 12)
            turn = quaternion_from_axis_angle(axis_of(limbs, k, i)[frame], angle[s, n])
            for row, joint, other, here in ((x, k + 1, k + 1, k < 2), (y, k, k - 1, k > 0)):
                if not here:
                    assert row[s, n] == 0.0
                    continue
                before, now = limbs.joints[joint, i, frame - 1], limbs.joints[joint, i, frame]
                axis = axis_of(limbs, other, i)[frame]
                if other > k:
                    moved = multiply(conjugate(before), multiply(turn, now))
                else:
                    moved = multiply(multiply(now, conjugate(turn)), conjugate(before))
                assert row[s, n] == pytest.approx(float(twist_angle(moved, axis)), abs=1e-9)


def test_errors_taken_out_leave_the_increments_of_the_limb_without_them():
    limbs = random_limbs(2, 2, 20, varying=False)
    offset = np.zeros(20)
    offset[5:12] = 0.8
    free = remove_twist_errors(limbs, {1: offset})  # chain 0 of limb 1
    before, after = limbs.increments(), free.increments()
    steps = np.diff(offset, prepend=0.0)
    np.testing.assert_allclose(np.cos(after[0, 1] - before[0, 1] + steps), 1.0, atol=1e-9)
    np.testing.assert_allclose(np.cos(after[1, 1] - before[1, 1] - steps), 1.0, atol=1e-9)
    np.testing.assert_allclose(after[:, [0, 2]], before[:, [0, 2]], atol=1e-12)


@pytest.mark.parametrize("loud", [(), (0,), (3,), (0, 5), (1, 2, 4)])
def test_a_chain_by_itself_is_without_the_images_of_what_jumps_beside_it(loud):
    limbs = random_limbs(3, 2, 15, varying=False)
    x, y = limbs.increments()
    offsets = np.zeros((6, 15))
    offsets[list(loud), 4:9] = 0.5 + np.array(loud)[:, None]
    jumps = [
        SimpleNamespace(counter=SimpleNamespace(x=x, y=y), offset=partial(np.copy, o))
        for o in offsets
    ]
    for row in range(6):
        beside = {r: offsets[r] for r in (row - 2, row + 2) if r in loud}
        wanted = remove_twist_errors(limbs, beside).increments()[:, row]
        np.testing.assert_allclose(_by_itself(limbs, jumps, row), wanted, atol=1e-12)


@pytest.mark.parametrize(
    ("offset", "steepest"),
    [([0.05, 0.4, 0.5], 1), ([-0.4, -0.45, -0.6], 0), ([0.1, 0.2, -0.3, -0.2], 2)],
)
def test_a_soft_error_stands_with_its_largest_offset_where_it_is_steepest(offset, steepest):
    error = SoftError(0, 20, np.array(offset), gain=100.0, sigma=0.01)
    standing = _fixed_soft("Arm", error)
    assert (standing.peak, standing.strength) == (20 + steepest, np.abs(offset).max())
    assert (standing.interval.chain, standing.interval.start) == ("Arm", 20)
    assert standing.interval.frames == len(offset)


@pytest.mark.parametrize(
    ("peak", "stands_at"), [(19, 20), (20, 20), (22, 22), (24, 24), (25, 24), (40, 24)]
)
def test_an_error_of_a_straight_limb_stands_inside_of_its_frames(peak, stands_at):
    error = StraightError(20, np.full(5, 0.4), peak, (0.3, -0.3), strength=0.35, closed=1)
    standing = _fixed_straight("Arm", error)
    assert (standing.peak, standing.strength) == (stands_at, 0.35)
    assert (standing.interval.chain, standing.interval.start, standing.interval.stop) == (
        "Arm", 20, 25
    )  # fmt: skip


# The analysis


def test_progress_is_told_in_shares_of_the_chains_and_never_goes_back():
    told: list[float] = []
    ConsistencyDetector().analyse(WALK, CHAINS, told.append)
    assert told[0] == 0.0
    assert told == sorted(told)
    assert 0.9 < told[-1] <= 1.0


def test_the_automatic_threshold_is_six_sigma_and_at_least_a_degree_and_a_half():
    analysis = ConsistencyDetector().analyse(WALK, CHAINS)
    for name, chain in analysis.chains.items():
        sigma = float(np.median(chain.limb.sigma[chain.row]))
        assert analysis.automatic_tau(name) == max(np.radians(1.5), 6.0 * sigma)
        louder = replace(chain.limb, sigma=chain.limb.sigma + 1.0)
        assert automatic_tau(louder, chain.row) == pytest.approx(6.0 * (sigma + 1.0))
    assert np.radians(1.5) == SMALLEST_TAU


def test_jumps_are_sought_row_by_row_each_at_its_own_threshold():
    limbs = random_limbs(2, 2, 40, varying=False)
    cut = np.zeros(40, dtype=bool)
    cut[[0, 18]] = True
    told: list[float] = []
    found = find_jumps(limbs, 50.0, cut, [(0, 18), (18, 40)], told.append)
    assert told[-1] == 1.0
    assert [j.row for j in found] == [0, 1, 2, 3]
    assert len({j.tau for j in found}) == 4
    for j in found:
        assert j.tau == automatic_tau(j.counter, j.row)
        assert j.fps == 50.0
        assert [(t.low, t.high) for t in j.tables] == [(0, 18), (18, 40)]
        edges, step = find_interval_edges_and_steps(j.counter, j.row)
        np.testing.assert_array_equal(j.edges.jump, edges.jump)
        np.testing.assert_array_equal(j.step, step)


def test_the_step_into_frame_0_is_no_motion():
    cut = ConsistencyDetector().analyse(WALK, CHAINS).cut
    assert np.flatnonzero(cut).tolist() == [0]
