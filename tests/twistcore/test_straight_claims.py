"""Errors of a straight spell: which are told, and how."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.twistcore.test_straight_spells import DEGREE, FRAMES, bend_made, signals
from twistcore.detection.limbs import Limbs
from twistcore.detection.straight_limbs.straight_claims import (
    StraightLimb,
    _error_of,
    _Jumping,
    _without,
    remove_twist_errors,
)
from twistcore.detection.straight_limbs.straight_intervals import (
    straight_confidence,
    straight_limb_interval,
)
from twistcore.detection.straight_limbs.straight_spells import Bend, Spell, StraightError
from twistcore.skeleton.rotation import multiply, wrap

# Errors of a spell


def a_spell(size=30.0, rise=10, fps=120.0):
    """A soft error of a straight spell, the increments that show it, and its hinge."""
    spell = Spell(50, 110, 4, 155)
    delta = np.zeros(FRAMES)
    delta[54:106] = size * DEGREE
    delta[54 : 54 + rise] *= np.arange(1, rise + 1) / (rise + 1)
    delta[106 - rise : 106] *= np.arange(rise, 0, -1) / (rise + 1)
    steps = np.diff(delta, prepend=0.0)
    t = np.arange(FRAMES) / fps
    natural = 0.01 * np.sin(3.0 * t) / fps
    angle = np.where((np.arange(FRAMES) >= 50) & (np.arange(FRAMES) < 110), 0.2, 0.9)
    bend = Bend(angle, wrap(-delta), 0.1 * DEGREE)
    return spell, delta, (natural + steps, 0.5 * natural - steps), bend


SCALES = 0.02 * DEGREE, 0.02 * DEGREE


def errors_of(made, jumping=(), **bends):
    spell, _, increments, bend = made
    return _error_of(increments, SCALES, jumping, replace(bend, **bends), spell, 120.0)


def test_an_error_of_a_spell_is_told_in_the_clips_frames():
    made = a_spell()
    (error,) = errors_of(made)
    total = np.zeros(FRAMES)
    total[error.start : error.stop] = error.offset
    np.testing.assert_allclose(total, made[1], atol=1.0 * DEGREE)
    begins, ends = (range(t - 8, t + 9) for t in (59, 101))
    assert error.peak in begins or error.peak in ends
    assert errors_of(a_spell(80.0)) == []  # would turn the hinge around
    assert errors_of(a_spell(-30.0))[0].offset.min() < -29.0 * DEGREE


def test_an_error_must_be_clear_of_the_hinges_play_and_bring_it_nearer():
    made = a_spell()
    (error,) = errors_of(made)
    largest = float(np.abs(error.offset).max())
    assert errors_of(made, spread=0.0999 * largest)
    assert errors_of(made, spread=0.1001 * largest) == []
    away = made[3].azimuth
    assert errors_of(made, azimuth=np.zeros(FRAMES)) == []
    assert errors_of(made, azimuth=-away) == []
    assert errors_of(made, azimuth=0.4 * away)  # nearly as far on the other side
    assert errors_of(made, azimuth=0.36 * away) == []


def test_jumps_that_leave_as_little_stand_against_an_error():
    made = a_spell(rise=4)
    exact = _Jumping(54, made[1][54:106], ())
    assert errors_of(made, [exact]) == []
    assert errors_of(made, [_Jumping(54, 0.5 * exact.offset, ())])
    halves = [_Jumping(54, 0.5 * exact.offset, ()), _Jumping(54, 0.5 * exact.offset, ())]
    assert errors_of(made, halves) == []
    nearly = exact.offset * (1.0 - 1.2 / 30.0)  # 1.2 degrees of a turn are left
    assert errors_of(made, [_Jumping(54, nearly, ())]) == []
    less = exact.offset * (1.0 - 3.5 / 30.0)
    assert errors_of(made, [_Jumping(54, less, ())])
    elsewhere = _Jumping(10, exact.offset[:20], ())
    assert errors_of(made, [elsewhere])


def test_increments_without_known_errors():
    increments = signals(3, 120.0)
    known = [_Jumping(20, np.full(5, 0.4), ()), _Jumping(22, np.linspace(0.1, 0.9, 40), ())]
    level = np.zeros(FRAMES)
    level[20:25] += 0.4
    level[22:62] += np.linspace(0.1, 0.9, 40)
    x, y = _without(increments, known)
    for t in range(1, FRAMES):
        step = level[t] - level[t - 1]
        assert wrap(np.array(x[t] - increments[0][t] + step)) == pytest.approx(0.0, abs=1e-12)
        assert wrap(np.array(y[t] - increments[1][t] - step)) == pytest.approx(0.0, abs=1e-12)
    assert (x[0], y[0]) == (increments[0][0], increments[1][0])
    assert (
        max(np.abs(v).max() for v in _without((increments[0] + 3.0, increments[1]), known)) < 3.15
    )


def test_errors_are_taken_out_of_all_limbs_that_have_them():
    rng = np.random.default_rng(2)
    joints = rng.standard_normal((4, 2, 9, 4))
    joints /= np.linalg.norm(joints, axis=-1, keepdims=True)
    axes = rng.standard_normal((3, 2, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    offsets = {1: rng.uniform(-1.0, 1.0, 9), 4: rng.uniform(-1.0, 1.0, 9)}
    found = remove_twist_errors(Limbs(joints, axes), offsets)
    wanted = joints.copy()
    for row, offset in offsets.items():
        chain, limb = row // 2, row % 2
        for t in range(9):
            half = 0.5 * offset[t]
            turn = np.array([np.cos(half), *(np.sin(half) * axes[chain, limb])])
            back = turn * [1.0, -1.0, -1.0, -1.0]
            wanted[chain, limb, t] = multiply(wanted[chain, limb, t], back)
            wanted[chain + 1, limb, t] = multiply(turn, wanted[chain + 1, limb, t])
    np.testing.assert_allclose(found.joints, wanted, atol=1e-12)
    assert found.axes is axes


def error(start=5, size=0.5, turns=(0.5, -0.3), closed=2):
    return StraightError(start, np.full(4, size), start + 1, turns, abs(size), closed)


def test_errors_add_up_to_an_offset():
    limb = StraightLimb((error(2), error(4, 0.25)), np.zeros(12, dtype=bool), bend_made(0))
    np.testing.assert_allclose(limb.offset, [0, 0, 0.5, 0.5, 0.75, 0.75, 0.25, 0.25, 0, 0, 0, 0])


def test_confidence_grows_with_strength_and_with_how_alike_both_turns_are():
    one = error(turns=(0.4, -0.3), size=16.0 * DEGREE)
    score = math.log(2.0) + 3.0 * 0.75
    assert straight_confidence(one) == pytest.approx(1.0 / (1.0 + math.exp(-score)))
    found = straight_limb_interval("LeftLeg", one)
    assert (found.chain, found.start, found.stop) == ("LeftLeg", 5, 9)
    assert found.confidence == straight_confidence(one)
    assert {k: v for k, v in found.evidence.items() if k != "follows"} == {
        "bent_sides": 2, "transition": 6,
        "transition_x_deg": pytest.approx(0.4 / DEGREE),
        "transition_y_deg": pytest.approx(-0.3 / DEGREE),
        "transition_deg": pytest.approx(16.0),
    }  # fmt: skip
