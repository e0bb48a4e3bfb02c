"""Jumps of a limb and its swivel, beside plain ones that go frame by frame."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.detection.limb_flips.jumps import (
    median_around,
    natural_departure_scale,
    rotations_minus_nearby_median,
    sharp_jumps,
    soft_jumps,
)
from twistcore.detection.limb_flips.swivel import _usual_side, compute_limb_swivel
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.angles import vector_angles_about_axis
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs, joint_path, limb_middle_and_end_positions
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle, wrap

DEGREE = math.pi / 180.0
WALK = read_bvh(ASSETS / "walk.bvh").motion
LIMBS = find_limbs(WALK, find_chains(WALK))


def turns_of(seed, frames=70, jumps=0.15, unrest=4.0):
    """Turns a frame: unrest and some that are larger, in degrees a frame; radians."""
    rng = np.random.default_rng(seed)
    turns = unrest * rng.standard_normal(frames)
    at = rng.random(frames) < jumps
    turns[at] += rng.uniform(-200.0, 200.0, at.sum())
    turns[0] = 0.0
    return wrap(np.radians(turns))


def plain_around(values):
    out = []
    for t in range(len(values)):
        near = [values[i] for i in range(t - 4, t + 5) if i != t and 0 < i < len(values)]
        out.append(float(np.median(near)) if near else 0.0)
    return np.array(out)


@pytest.mark.parametrize("frames", [1, 2, 3, 6, 9, 10, 40])
def test_around_is_the_median_of_four_frames_on_either_side(frames):
    values = turns_of(frames, frames) + 0.3
    np.testing.assert_allclose(median_around(values), plain_around(values), atol=1e-12)
    np.testing.assert_allclose(
        rotations_minus_nearby_median(values), wrap(values - plain_around(values)), atol=1e-12
    )
    assert (
        np.abs(rotations_minus_nearby_median(np.array([0.0, 3.0, -3.0, 3.0, 3.0, 3.0]))).max()
        <= np.pi
    )


@pytest.mark.parametrize(("fps", "frames"), [(10.0, 60), (30.0, 9), (120.0, 60), (240.0, 30)])
def test_the_scale_of_a_limb_is_that_of_its_departures_around(fps, frames):
    rng = np.random.default_rng(frames)
    departures = np.radians(rng.uniform(0.1, 9.0, frames)) * rng.choice([-1.0, 1.0], frames)
    departures[: frames // 2] *= 0.05
    height = rng.uniform(0.0, 0.5, frames)
    half = max(4, round(0.2 * fps))
    for t, value in enumerate(natural_departure_scale(departures, height, fps, np.arange(frames))):
        near = []
        for i in range(t - half, t + half + 1):
            mirrored = i % (2 * frames)  # at its ends the clip goes back
            near.append(abs(departures[min(mirrored, 2 * frames - 1 - mirrored)]))
        least = max(1.0 * DEGREE, 0.006 / max(height[t], 0.04))
        assert value == pytest.approx(max(1.4826 * np.median(near), least), abs=1e-12)


def test_a_limb_that_is_nearly_straight_is_turned_further_by_the_same_unrest():
    still = np.zeros(9)
    height = np.array([0.0, 0.03, 0.04, 0.05, 0.1, 0.3, 0.34, 0.35, 1.0])
    found = natural_departure_scale(still, height, 120.0, np.arange(9))
    expected = [0.15, 0.15, 0.15, 0.12, 0.06, 0.02, 0.006 / 0.34, DEGREE, DEGREE]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("tau", [20.0, 55.0, 120.0])
def test_sharp_jumps_lead_from_tau_on_and_else_may_be_partners(tau):
    rng = np.random.default_rng(7)
    departures = np.radians(rng.uniform(-180.0, 180.0, 80))
    departures[:3] = tau * DEGREE, -tau * DEGREE, 24.9 * DEGREE
    scales = np.radians(rng.uniform(1.0, 30.0, 80))
    scales[3:5] = 2.0 * DEGREE
    departures[3:6] = 25.0 * DEGREE, -24.9 * DEGREE, 32.0 * DEGREE
    scales[5] = 8.0 * DEGREE
    steps = rng.random(80)
    wanted = []
    for t, size in enumerate(np.abs(departures)):
        if size >= tau * DEGREE or (size >= 25.0 * DEGREE and size >= 4.0 * scales[t]):
            wanted.append(
                (t, t + 1, departures[t], scales[t], steps[t], True, size >= tau * DEGREE)
            )
    found = sharp_jumps(departures, scales.__getitem__, steps.__getitem__, tau * DEGREE)
    assert [(j.start, j.stop, j.turn, j.scale, j.step, j.sharp, j.leads) for j in found] == wanted
    assert 10 < len(wanted) < 80


def plain_soft(turns, sharp, fps):
    wanted = set()
    for pace in (1200.0, 600.0, 300.0):
        fast = [abs(t) > pace * DEGREE / fps and not s for t, s in zip(turns, sharp, strict=True)]
        for a in range(len(turns)):
            for b in range(a + 2, len(turns) + 1):
                own = turns[a:b]
                one_way = all(fast[a:b]) and len(set(np.sign(own))) == 1
                longer = [i for i in (a - 1, b) if 0 <= i < len(turns)]
                whole = not any(fast[i] and np.sign(turns[i]) == np.sign(own[0]) for i in longer)
                size = abs(own.sum()) / DEGREE
                if one_way and whole and b - a <= 0.15 * fps and 75.0 <= size <= 190.0:
                    wanted.add((a, b))
    return sorted(wanted)


@pytest.mark.parametrize("fps", [60.0, 120.0])
@parametrize("seed", range(6), quick=2)
def test_soft_jumps_are_runs_of_fast_turns_that_together_turn_the_limb_round(fps, seed):
    rng = np.random.default_rng(seed)
    turns = np.zeros(160)
    for start in range(0, 160, 20):
        length = int(rng.integers(1, 20))
        turns[start : start + length] = rng.choice([-1, 1]) * rng.uniform(60, 210) / length
    turns = np.radians(turns + rng.uniform(-3.0, 3.0, 160))
    sharp = rng.random(160) < 0.01
    if seed == 0:
        turns[-8:], turns[:8] = 12.0 * DEGREE, -12.0 * DEGREE
    found = soft_jumps(turns, sharp, fps)
    assert [(j.start, j.stop) for j in found] == plain_soft(turns, sharp, fps)
    for j in found:
        assert j.turns == tuple(turns[j.start : j.stop])
        assert (j.scale, j.step, j.sharp, j.leads) == (0.0, 0.0, False, False)


@pytest.mark.parametrize(
    ("degrees", "frames", "found"),
    [(74.9, 6, 0), (75.1, 6, 1), (189.9, 12, 1), (190.1, 12, 0), (150.0, 18, 1), (150.0, 19, 0),
     (120.0, 2, 1), (120.0, 1, 0)],
)  # fmt: skip
def test_how_far_and_how_long_a_soft_jump_is(degrees, frames, found):
    turns = np.zeros(60)
    turns[20 : 20 + frames] = degrees * DEGREE / frames
    assert len(soft_jumps(turns, np.zeros(60, dtype=bool), 120.0)) == found


# The swivel


def motion_of(seed, kind):
    """Frames of a walk in which every joint wavers; a leg that is straight, folded or twisted."""
    rng = np.random.default_rng(seed)
    motion = WALK.sliced(20, 50)
    noise = rng.standard_normal((30, len(motion.skeleton), 3)) * {"wild": 0.6}.get(kind, 0.05)
    size = np.linalg.norm(noise, axis=-1)
    q = multiply(motion.rotations, quaternion_from_axis_angle(noise / size[..., None], size))
    for limb in LIMBS:
        if kind == "straight":
            q[rng.random(30) < 0.6, limb.child] = (1.0, 0.0, 0.0, 0.0)
        if kind == "flips":
            along = np.broadcast_to(limb.axis, (30, 3))
            q[:, limb.parent] = multiply(
                q[:, limb.parent],
                quaternion_from_axis_angle(along, rng.choice([0.0, 0.0, 2.5, -0.9], 30)),
            )
        if kind == "folded":
            across = np.cross(limb.axis, [0.3, 0.5, 0.81])
            across /= np.linalg.norm(across)
            fold = quaternion_from_axis_angle(
                np.broadcast_to(across, (30, 3)), rng.choice([3.0, 3.1, np.pi], 30)
            )
            q[:, limb.child] = fold
    return motion.with_rotations(q)


def plain_twist(rotation, axis):
    x, y, z, w = rotation.as_quat()
    return float(wrap(np.array(2.0 * math.atan2(np.dot([x, y, z], axis), w))))


def plain_way(a, b):
    """The shortest rotation that takes a to b."""
    axis = np.cross(a, b)
    size = np.linalg.norm(axis)
    if size < 1e-12:
        return Rotation.identity()
    return Rotation.from_rotvec(axis / size * math.atan2(size, a @ b))


def between(axis, a, b):
    return math.atan2(np.cross(a, b) @ axis, a @ b)


def rotation(q):
    return Rotation.from_quat(np.roll(q, -1))


@pytest.mark.parametrize("kind", ["walk", "wild", "straight", "flips", "folded"])
@pytest.mark.parametrize("name", ["Left arm", "Right leg"])
def test_the_swivel_is_what_places_and_rotations_in_the_room_say(kind, name):
    motion = motion_of(len(kind), kind)
    limb = next(n for n in LIMBS if n.label == name)
    turned, at = forward_kinematics(motion)
    above = int(motion.skeleton.parents[limb.parent])
    last = joint_path(motion.skeleton, limb.parent, limb.end)[-2]
    to_child, to_end = at[:, limb.child] - at[:, limb.parent], at[:, limb.end] - at[:, limb.parent]
    norm = np.linalg.norm
    length = norm(to_child, axis=1).mean() + norm(to_end - to_child, axis=1).mean()
    found = compute_limb_swivel(motion, limb)
    line = to_end / norm(to_end, axis=1)[:, None]
    aside = to_child - (to_child * line).sum(axis=1)[:, None] * line
    height = norm(aside, axis=1) / length
    lined = norm(to_end, axis=1) > 0.02 * length
    np.testing.assert_allclose(found.height, height, atol=1e-9)
    np.testing.assert_allclose(found.line, line, atol=1e-8)
    np.testing.assert_allclose(
        np.abs((found.end * turned[:, limb.end]).sum(axis=1)), 1.0, atol=1e-9
    )
    back = [rotation(q).inv() for q in turned[:, above]]
    own = [(r.apply(v), r.apply(w)) for r, v, w in zip(back, line, aside, strict=True)]
    for t, (v, w) in enumerate(own):
        phi = between(v, found.side - (found.side @ v) * v, w) if lined[t] else 0.0
        if height[t] > 1e-6:
            assert found.angle[t] == pytest.approx(phi, abs=1e-7)
        if height[t] < 1e-10 or not lined[t]:
            assert found.angle[t] == 0.0
    carried = np.array([r.apply(v) for r, v in zip(back, to_end, strict=True)])
    in_room = np.array(
        [rotation(q).apply(v) for q, v in zip(turned[:, above], carried, strict=True)]
    )
    assert found.step[0] == found.jump[0] == 0.0
    np.testing.assert_allclose(
        found.step[1:], norm(np.diff(in_room, axis=0), axis=1) / length, atol=1e-9
    )

    def agreed(s, t):
        """The turn from frame s to frame t, and whether two witnesses say so."""
        way = plain_way(line[s], line[t])
        upper, lower = (
            plain_twist(rotation(turned[t, j]) * rotation(turned[s, j]).inv() * way.inv(), line[t])
            for j in (limb.parent, last)
        )
        if min(height[t], height[s]) > 0.03:
            judge = between(line[t], way.apply(aside[s]), aside[t])
            off = min((wrap(np.array(v - judge)) for v in (upper, lower)), key=abs)
        else:
            judge = lower
            off = wrap(np.array(upper - judge))
        if abs(off) < 40.0 * DEGREE:
            return wrap(np.array(judge + 0.5 * off)), True
        return min((upper, judge), key=abs), False

    turns = [agreed(t - 1, t) for t in range(1, motion.frames)]
    wanted = np.array([0.0, *(turn for turn, _ in turns)])
    for t in range(2, motion.frames):
        whole, alike = agreed(t - 2, t)
        one, other = wanted[t - 1], wanted[t]
        split = not (turns[t - 2][1] and turns[t - 1][1])
        if alike and abs(whole) > np.pi / 2 and split and max(abs(one), abs(other)) < np.pi / 2:
            wanted[t] = wrap(np.array(whole - one))
    for t in range(1, motion.frames):
        if not (lined[t] and lined[t - 1]):
            assert found.jump[t] == 0.0
        elif t < 2 or lined[t - 2]:
            assert wrap(found.jump[t] - wanted[t]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("kind", ["walk", "wild", "flips"])
def test_the_usual_side_is_that_of_most_frames_weighed_by_height(kind):
    motion = motion_of(3, kind)
    for limb in LIMBS:
        to_child, to_end = limb_middle_and_end_positions(motion, limb)
        line = to_end / np.linalg.norm(to_end, axis=1)[:, None]
        aside = to_child - (to_child * line).sum(axis=1)[:, None] * line
        weighed = aside / np.linalg.norm(aside, axis=1).max()
        side = np.median(weighed, axis=0)
        for _ in range(5):
            agree = [w for w, v in zip(weighed, line, strict=True) if w @ (side - v @ side * v) > 0]
            if not agree:
                break
            side = np.mean(agree, axis=0)
        swivel = compute_limb_swivel(motion, limb)
        np.testing.assert_allclose(swivel.side, side, atol=1e-9)
        other = swivel.angle_at(2.0 * to_child[:5], 3.0 * to_end[:5])
        np.testing.assert_allclose(other, swivel.angle[:5], atol=1e-9)


@pytest.mark.parametrize(("share", "lined"), [(1.0, False), (0.97, False), (0.95, True)])
def test_a_limb_that_is_folded_up_has_no_line_and_does_not_jump(share, lined):
    """Its end lies on its first joint, or nearer to it than a fiftieth of its length."""
    limb = next(n for n in LIMBS if n.label == "Left leg")
    motion = motion_of(1, "walk")
    offsets = motion.skeleton.offsets.copy()
    first, second = offsets[limb.child], offsets[limb.end]
    second *= share * np.linalg.norm(first) / np.linalg.norm(second)
    q = motion.rotations.copy()
    folded = [5, 6, 7, 15]
    size = np.linalg.norm(first)
    back = plain_way(second / (share * size), -first / size).as_quat()
    q[folded, limb.child] = np.roll(back, 1)
    motion = replace(motion, skeleton=replace(motion.skeleton, offsets=offsets), rotations=q)
    found = compute_limb_swivel(motion, limb)
    if lined:
        assert found.jump[[5, 8, 15, 16]].all()
        return
    assert not found.angle[folded].any()
    assert not found.jump[[0, 5, 6, 7, 8, 15, 16]].any()
    assert found.jump[[1, 2, 3, 4, 9, 14, 17]].all()
    assert np.isfinite(found.jump).all()


def test_a_limb_that_is_at_either_side_alike_has_no_usual_one():
    line = np.broadcast_to([0.0, 0.0, 1.0], (4, 3))
    aside = 0.1 * np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    np.testing.assert_array_equal(_usual_side(line, aside, np.full(4, 0.1)), np.zeros(3))


def test_the_angle_about_an_axis_has_a_sign():
    axis, a = np.array([[0.0, 0.0, 1.0]]), np.array([[2.0, 0.0, 0.0]])
    for phi in (-3.0, -0.4, 0.0, 1.0, 2.0):
        b = np.array([[np.cos(phi), np.sin(phi), 0.0]])
        assert vector_angles_about_axis(axis, a, b) == pytest.approx(phi)
        assert vector_angles_about_axis(-axis, a, b) == pytest.approx(-phi)
