"""Straight spells and the errors in them, beside plain ones that go frame by frame."""

import math

import numpy as np
import pytest

from tests.tiers import parametrize
from twistcore.detection.straight_limbs.straight_claims import _is_nearer_hinge, _Jumping
from twistcore.detection.straight_limbs.straight_course import (
    error_course,
    twist_increment_change_scale,
)
from twistcore.detection.straight_limbs.straight_spells import (
    Bend,
    Spell,
    _over_windows,
    find_straight_limb_twist_errors,
    find_straight_ranges,
    limb_bend_per_frame,
    twist_transition_window_frames,
    unexplained_opposite_rotation,
)
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle, wrap
from twistcore.skeleton.runs import runs_of_true

DEGREE = math.pi / 180.0
FRAMES = 160
RATES = [30.0, 60.0, 120.0]


def signals(seed, fps, unrest=0.05):
    """Increments of P and C, radians: even motion, unrest, and counter-turns of some frames."""
    rng = np.random.default_rng(seed)
    t = np.arange(FRAMES) / fps
    x = np.radians(60.0) / fps * np.sin(2.0 * t + seed)
    y = np.radians(45.0) / fps * np.cos(1.3 * t + seed)
    x += unrest * DEGREE * rng.standard_normal(FRAMES)
    y += unrest * DEGREE * rng.standard_normal(FRAMES)
    for _ in range(4):
        start, length = rng.integers(2, FRAMES - 20), int(rng.integers(1, 12))
        turn = rng.uniform(-50.0, 50.0) * DEGREE / length
        x[start : start + length] += turn
        y[start : start + length] -= turn * rng.choice([1.0, 1.0, 0.5, 0.2])
    return x, y


def spell_of(seed):
    rng = np.random.default_rng(seed + 50)
    low, high = int(rng.choice([0, 5])), int(rng.choice([FRAMES, FRAMES - 9]))
    start = int(rng.choice([low, low + 3, 40]))
    stop = int(rng.choice([high, high - 2, 100]))
    return Spell(start, stop, low, high)


# The course of an error


def plain_course(increments, scales, start, stop, low, high, fps):
    """δ by dense least squares, row by row."""
    n = stop - start
    rows, given = [], []

    def row(frames, factors, value):
        own = np.zeros(n)
        for frame, factor in zip(frames, factors, strict=True):
            if start <= frame < stop:
                own[frame - start] += factor
        rows.append(own)
        given.append(value)

    for signal, scale, sign in zip(increments, scales, (1.0, -1.0), strict=True):
        for t in range(low + 2, high):  # x(t) − x(t−1) is what δ bends by, less what P does
            if start - 1 <= t <= stop:
                factors = np.array([1.0, -2.0, 1.0]) * sign / scale
                row((t - 2, t - 1, t), factors, (signal[t] - signal[t - 1]) / scale)
        rest = scale * 0.25 * fps
        for t in range(low + 1, high):
            if start <= t <= stop:
                row((t - 1, t), np.array([-1.0, 1.0]) * sign / rest, signal[t] / rest)
    rows, given = np.array(rows), np.array(given)
    normal, right = rows.T @ rows + 1e-9 * np.eye(n), rows.T @ given
    step = 12.0 * DEGREE / fps
    changes = np.eye(n + 1, n) - np.eye(n + 1, n, -1)  # from 0 to the first, …, to 0
    free = np.array([start > low] + [True] * (n - 1) + [stop < high], dtype=float)
    weight, delta = free * 0.05 / step**2, np.zeros(n)
    for _ in range(12):
        now = np.linalg.solve(normal + changes.T @ (weight[:, None] * changes), right)
        if np.abs(now - delta).max() < 1e-5:
            return now
        delta = now
        weight = free * 0.1 / ((changes @ delta) ** 2 + step**2)
    return delta


@parametrize("fps", RATES, quick=2)
@parametrize("seed", range(6), quick=2)
def test_the_course_is_that_of_the_dense_least_squares(seed, fps):
    increments, s = signals(seed, fps), spell_of(seed)
    scales = (
        twist_increment_change_scale(increments[0]),
        1.7 * twist_increment_change_scale(increments[1]),
    )
    found = error_course(increments, scales, s.start, s.stop, s.low, s.high, fps)
    wanted = plain_course(increments, scales, s.start, s.stop, s.low, s.high, fps)
    np.testing.assert_allclose(found, wanted, atol=2e-6)
    assert np.abs(wanted).max() > 3.0 * DEGREE


@pytest.mark.parametrize("n", [1, 2, 3])
def test_a_course_of_few_frames(n):
    increments = signals(0, 120.0)
    scales = (
        twist_increment_change_scale(increments[0]),
        twist_increment_change_scale(increments[1]),
    )
    found = error_course(increments, scales, 40, 40 + n, 0, FRAMES, 120.0)
    wanted = plain_course(increments, scales, 40, 40 + n, 0, FRAMES, 120.0)
    np.testing.assert_allclose(found, wanted, atol=1e-7)


def test_the_scale_of_increments_is_the_median_of_their_changes():
    x = signals(1, 120.0)[0]
    changes = [abs(x[t] - x[t - 1]) for t in range(3, FRAMES)]
    assert twist_increment_change_scale(x) == pytest.approx(1.4826 * np.median(changes))
    least = 0.02 * DEGREE
    assert (
        twist_increment_change_scale(1e-4 * x)
        == twist_increment_change_scale(x[:3])
        == twist_increment_change_scale(x[:1])
        == pytest.approx(least)
    )
    assert twist_increment_change_scale(np.array([0.0, 9.0, 0.0, 1.0])) == pytest.approx(1.4826)


# Bends


def leg(seed, frames=90, hinge=True):
    """Rotations of C, its line and its arm, of a limb that bends by 0 to 80 degrees."""
    rng = np.random.default_rng(seed)
    axis, arm, across = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    arm = axis + 0.3 * arm
    arm /= np.linalg.norm(arm)
    angle = np.radians(40.0 * (1.0 - np.cos(np.arange(frames) / 9.0)))
    q = quaternion_from_axis_angle(np.broadcast_to(across, (frames, 3)), angle)
    wander = 0.9 if not hinge else 0.01
    twist = quaternion_from_axis_angle(
        np.broadcast_to(axis, (frames, 3)), wander * rng.standard_normal(frames)
    )
    return multiply(twist, q), axis, arm


def plain_azimuth(q, axis, arm):
    """Bend of a bone, and its direction about the line from any one of these."""
    w, v = q[0], q[1:]
    turned = arm + 2.0 * np.cross(v, np.cross(v, arm) + w * arm)
    across = turned - (turned @ axis) * axis
    bend = math.atan2(np.linalg.norm(across), turned @ axis)
    first = np.cross(axis, [0.6, 0.0, 0.8])
    return bend, math.atan2(across @ np.cross(axis, first), across @ first)


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_a_bend_is_that_of_the_bone_and_its_azimuth_off_the_bent_limbs(seed, moving):
    q, axis, arm = leg(seed)
    axes = np.broadcast_to(axis, (len(q), 3)) if moving else axis
    bend = limb_bend_per_frame(q, axes, arm, 120.0)
    plain = np.array([plain_azimuth(own, axis, arm) for own in q])
    np.testing.assert_allclose(bend.angle, plain[:, 0], atol=1e-9)
    bent = plain[:, 0] > 30.0 * DEGREE
    np.testing.assert_array_equal(bend.bent, bent)
    turn = np.exp(1j * (bend.azimuth - plain[:, 1]))
    far = plain[:, 0] > 1e-3
    np.testing.assert_allclose(turn[far], turn[far][0], atol=1e-6)  # from one direction, all
    assert np.median(bend.azimuth[bent]) == pytest.approx(0.0, abs=1e-9)
    assert np.abs(bend.azimuth).max() <= np.pi
    assert bend.spread == pytest.approx(np.quantile(np.abs(bend.azimuth[bent]), 0.75))
    loose = limb_bend_per_frame(*leg(seed, hinge=False), 120.0)
    assert loose.azimuth is None
    assert loose.spread > 2.0 * DEGREE


@pytest.mark.parametrize(("fps", "frames", "told"), [(120.0, 11, False), (120.0, 12, True),
    (30.0, 2, False), (30.0, 3, True), (5.0, 1, False), (5.0, 2, True)])  # fmt: skip
def test_a_limb_bent_for_less_than_a_tenth_of_a_second_tells_nothing(fps, frames, told):
    angle = np.full(40, 0.1)
    angle[5 : 5 + frames] = 0.6
    q = quaternion_from_axis_angle(np.broadcast_to(np.eye(3)[0], (40, 3)), angle)
    bend = limb_bend_per_frame(q, np.eye(3)[1], np.eye(3)[1], fps)
    assert (bend.azimuth is not None) == told
    np.testing.assert_allclose(bend.angle, angle, atol=1e-9)


def bend_made(seed, frames=60):
    rng = np.random.default_rng(seed)
    angle = np.radians(rng.uniform(0.0, 60.0, frames))
    angle[:4] = np.radians([0.4, 0.6, 0.0, 29.9])
    azimuth = wrap(rng.uniform(-1.2, 1.2, frames) + np.where(rng.random(frames) < 0.3, np.pi, 0))
    return Bend(angle, azimuth, 0.01)


@pytest.mark.parametrize("share", [1.0, 1.6, 0.7])
@pytest.mark.parametrize("seed", range(5))
def test_nearer_to_the_hinge_is_what_bones_off_their_line_say(seed, share):
    bend, rng = bend_made(seed), np.random.default_rng(seed)
    said = set()
    for _ in range(30):
        start = int(rng.integers(0, 40))
        frames = slice(start, start + int(rng.integers(1, 20)))
        offset = rng.uniform(-1.5, 1.5) * rng.uniform(0.7, 1.0, frames.stop - start)
        where = rng.random(len(offset)) < 0.7
        for counts in (None, where):
            off = back = 0.0
            for k, t in enumerate(range(frames.start, frames.stop)):
                if bend.angle[t] < 0.5 * DEGREE or (counts is not None and not counts[k]):
                    continue
                weight = math.sin(bend.angle[t]) ** 2
                ways = [abs(float(wrap(np.array(bend.azimuth[t] + o)))) for o in (0.0, offset[k])]
                if bend.angle[t] <= 30.0 * DEGREE:  # straight: backward is as well
                    ways = [min(v, math.pi - v) for v in ways]
                off, back = off + weight * ways[0], back + weight * ways[1]
            wanted = None if counts is not None and not counts.any() else back < share * off
            assert bend.nearer(frames, offset, counts, share) == wanted
            said.add(wanted)
    assert {True, False} <= said
    assert Bend(bend.angle, None).nearer(slice(0, 3), np.zeros(3)) is None


def test_an_interval_is_gainsaid_by_the_bent_frames_alone():
    bend = Bend(np.radians([10.0, 10.0, 50.0, 50.0, 10.0]), np.array([-1.0, -1.0, 1.0, 1.0, 0.0]))
    for start, size, said in ((0, 1.0, None), (1, 1.0, False), (1, -1.0, True), (2, -0.5, True)):
        assert _is_nearer_hinge(_Jumping(start, np.full(2, size), ()), bend) is said


# Spells


def plain_over(signal, spell, fps):
    """Of each window the sum, and that less the pace of half a window on either side."""
    window = max(2, round(0.13 * fps))
    half, out = window // 2, []
    for begin in range(max(spell.start - window, spell.low), min(spell.stop, spell.high - window)):
        inside = sum(signal[begin + 1 : begin + 1 + window])
        beside = [*range(begin + 1 - half, begin + 1)]
        beside += range(begin + 1 + window, begin + 1 + window + half)
        pace = [signal[min(max(t, spell.low + 1), spell.high - 1)] for t in beside]
        out.append((inside, inside - np.mean(pace) * window))
    return np.array(out).reshape(-1, 2).T


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("seed", range(6))
def test_windows_at_the_ends_of_a_segment_go_on_at_its_outermost_pace(seed, fps):
    signal, spell = signals(seed, fps)[0] + 0.1, spell_of(seed)
    short = Spell(3, 12, 3, 14)
    for some in (spell, short, Spell(0, FRAMES, 0, FRAMES), Spell(5, 25, 5, FRAMES - 9)):
        for one, other in zip(
            _over_windows(signal, some, fps), plain_over(signal, some, fps), strict=True
        ):
            np.testing.assert_allclose(one, other, atol=1e-12)


def against(turn, answer):
    return min(abs(turn), abs(answer)) if turn * answer < 0.0 else 0.0


def is_mirrored(turn, answer):
    large = max(abs(turn), abs(answer))
    return against(turn, answer) >= max(8.0 * DEGREE, 0.35 * large)


def plain_turns(increments, spell, fps):
    (x, beyond_x), (y, beyond_y) = (plain_over(v, spell, fps) for v in increments)
    out = []
    for plain, beyond in zip(zip(x, y, strict=True), zip(beyond_x, beyond_y, strict=True),
                             strict=True):  # fmt: skip
        rather = against(*beyond) > against(*plain) and not is_mirrored(*plain)
        out.append(beyond if rather else plain)
    return out


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("seed", range(10))
def test_spells_are_those_beside_a_bent_limb_in_which_both_joints_counter_turn(seed, fps):
    increments = signals(seed, fps)
    rng = np.random.default_rng(seed)
    bent = rng.random(FRAMES // 20).repeat(20) < 0.3
    low, high = (0, FRAMES) if seed % 2 else (7, 140)
    bend = Bend(np.where(bent, 0.6, 0.1), None)
    wanted, t = [], low
    while t < high:
        stop = t
        while stop < high and not bent[stop]:
            stop += 1
        if stop > t:
            spell = Spell(t, stop, low, high)
            closed = (t > low) + (stop < high)
            assert spell.closed == closed
            turns = plain_turns(increments, spell, fps)
            if closed and any(is_mirrored(*both) for both in turns):
                wanted.append(spell)
        t = stop + 1
    assert find_straight_ranges(increments, bend, low, high, fps) == wanted
    straight = Bend(np.full(FRAMES, 0.1), None)
    assert find_straight_ranges(increments, straight, low, high, fps) == []


def test_windows_of_a_transition_and_runs():
    assert [twist_transition_window_frames(fps) for fps in (5.0, 24.0, 30.0, 60.0, 120.0)] == [
        2,
        3,
        4,
        8,
        16,
    ]
    assert Spell(40, 60, 0, 100).windows(16) == slice(24, 60)
    assert Spell(10, 95, 0, 100).windows(16) == slice(0, 84)
    assert Spell(2, 6, 0, 8).windows(16) == slice(0, 0)
    assert Spell(22, 30, 20, 100).windows(16) == slice(20, 30)
    assert runs_of_true(np.array([1, 0, 1, 1, 0, 0, 1], dtype=bool)) == [(0, 1), (2, 4), (6, 7)]
    assert runs_of_true(np.zeros(3, dtype=bool)) == []


def plain_errors(increments, delta, spell, fps):
    window = max(2, round(0.13 * fps))
    first = max(spell.start - window, spell.low)
    turns = plain_turns(increments, spell, fps)
    clear = {}
    for k, (turn, answer) in enumerate(turns):
        change = delta[first + k + window] - delta[first + k]
        least = max(0.5 * min(abs(turn), abs(answer)), 6.0 * DEGREE)
        if is_mirrored(turn, answer) and change * np.sign(turn) >= least:
            clear[first + k] = change
    parts, t = [], 0
    for t in np.flatnonzero(np.abs(delta) > 0.5 * DEGREE).tolist():
        if parts and t + 1 - parts[-1][1] - 1 < max(0.1 * fps, 1e-9):
            parts[-1][1] = t + 1
        else:
            parts.append([t, t + 1])
    short, found = round(0.015 * fps), []
    for start, stop in parts:
        own = {b: c for b, c in clear.items() if start - window <= b < stop}
        if not own:
            continue
        best = max(own, key=lambda b: (abs(own[b]), -b))
        sudden = max(
            abs(delta[t + short] - delta[t]) for t in range(best, best + window - short + 1)
        )
        if sudden <= 0.7 * abs(own[best]):
            turn = turns[best - first]
            peak = best + 1 + window // 2
            found.append((start, stop, peak, turn, abs(own[best])))
    return found


def softly(seed, fps, spell):
    """Errors in a spell with soft and sudden ends, and increments that show them."""
    rng = np.random.default_rng(seed)
    delta = np.zeros(FRAMES)
    x, y = signals(seed, fps, 0.02)
    x *= 0.3
    y *= 0.3
    t = spell.start
    while t < spell.stop:
        length = int(rng.integers(1, 45))
        size = rng.choice([0.0, 0.4, 4.0, 7.0, 20.0, -30.0]) * DEGREE
        rise = int(rng.choice([1, 2, 6, 14]))
        level = np.full(length, size)
        level[:rise] *= (np.arange(rise) + 1.0)[:length] / rise
        delta[t : min(t + length, spell.stop)] = level[: spell.stop - t]
        t += length + int(rng.choice([1, 3, 14]))
    steps = np.diff(delta, prepend=0.0)
    return (x + steps, y - steps * rng.choice([1.0, 0.5, 0.3])), delta


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("seed", range(14))
def test_errors_in_a_spell_begin_or_end_with_a_transition_of_both_joints(seed, fps):
    spell = spell_of(seed)
    increments, delta = softly(seed, fps, spell)
    found = find_straight_limb_twist_errors(increments, delta, spell, fps)
    wanted = plain_errors(increments, delta, spell, fps)
    assert [(e.start, e.stop, e.peak) for e in found] == [w[:3] for w in wanted]
    for error, (start, stop, _, turns, strength) in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(error.offset, delta[start:stop])
        assert error.turns == pytest.approx(turns)
        assert error.strength == pytest.approx(strength)
        assert error.closed == spell.closed


@pytest.mark.parametrize("fps", RATES)
@pytest.mark.parametrize("seed", range(5))
def test_what_is_left_over_is_weighed_by_the_quieter_signal(seed, fps):
    increments, spell = signals(seed, fps), spell_of(seed)
    delta = np.zeros(FRAMES)
    delta[spell.start : spell.stop] = 0.3
    scales = 0.002, 0.003
    steps = np.diff(delta, prepend=delta[0])
    turn = plain_over(wrap(increments[0] - steps), spell, fps)[1]
    answer = plain_over(wrap(increments[1] + steps), spell, fps)[1]
    both = [
        (a / 0.002**2 - b / 0.003**2) / (1.0 / 0.002**2 + 1.0 / 0.003**2)
        for a, b in zip(turn, answer, strict=True)
    ]
    assert unexplained_opposite_rotation(increments, scales, delta, spell, fps) == pytest.approx(
        np.abs(both).max()
    )
    assert unexplained_opposite_rotation(increments, scales, delta, Spell(3, 4, 3, 5), fps) == 0.0
