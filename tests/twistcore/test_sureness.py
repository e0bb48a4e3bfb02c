"""What is sure enough to be corrected: jumps beyond τ, silent joints that are answered."""

import numpy as np
import pytest

from tests.twistcore.test_soft_errors import (
    FPS,
    SHAPES,
    clip,
    erring,
    found_in,
    low_passed,
    surprise_of,
)
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection.consistency.confidence import counter_twist_confidence
from twistcore.detection.consistency.detector import _by_itself, _limbs, find_jumps
from twistcore.detection.soft_errors import Known, search_soft_errors
from twistcore.detection.soft_errors.silent_joints import _of_two_chains
from twistcore.detection.soft_errors.soft_error import SoftError, mark_error_if_unsure
from twistcore.detection.soft_errors.softened_level import linear_unit_ramp, softened_level_curves
from twistcore.skeleton.chain import find_chains

RNG = np.random.default_rng(5)
FRAMES = 300
NOWHERE = np.zeros(FRAMES, dtype=bool)


def natural(amount=2.0):
    """Increments of an even motion, radians."""
    t = np.arange(FRAMES) / 30.0
    return np.radians(amount) * (np.sin(t) + 0.4 * np.sin(2.7 * t + 1.0))


def sureness(own, other, offset, start=120):
    """Whether an error that silent C shows would be corrected unasked."""
    error = SoftError(0, start, offset, 200.0, 1e-3)
    return not mark_error_if_unsure(error, other, own, NOWHERE, -1, last=False).unsure


def test_what_p_turns_back_is_an_error_and_what_it_knows_nothing_of_is_none():
    level = np.zeros(FRAMES)
    level[100:160] = low_passed(np.full(60, np.radians(12.0)), 4.0)[40:100]
    steps = np.diff(level, prepend=0.0)
    assert sureness(-steps, natural(0.3) + steps, level[100:160], 100)
    assert not sureness(-steps, natural(0.3), level[100:160], 100)


def test_a_gap_over_which_p_was_held_is_answered_at_its_borders():
    held, own = natural(), np.zeros(FRAMES)
    own[120:150], held[120:150] = held[120:150], 0.0
    assert sureness(own, held, -np.cumsum(own[120:150]))


def test_a_jump_beyond_tau_is_surer_than_one_that_only_a_lower_one_shows():
    motion = clip("walk.bvh", "rich")
    sure = {}
    for size in (1.2, 8.0):
        _, dirty = erring(motion, "LeftArm", 150, np.full(12, np.radians(size)))
        found = ClipAnalysis(dirty, find_chains(dirty)).by().intervals("LeftArm", np.radians(0.5))
        (near,) = [i for i in found if 149 <= i.start <= 151]
        sure[size] = near.confidence
    assert sure[1.2] < 0.5 < sure[8.0]


def test_reaching_tau_is_worth_more_than_a_number_of_nats():
    low, high = (counter_twist_confidence(8.0, 0.5, 2.0, 15, beyond_tau=b) for b in (False, True))
    assert low < 0.5 < 0.9 < high


def test_a_silent_joint_makes_exact_what_jumps_told_about_right():
    # Low-passed at 15 Hz, so small that what jumps leave of it is less than is asked for.
    motion = clip("walk.bvh")
    full, dirty = erring(motion, "LeftShoulder", 120, low_passed(np.full(14, -0.16), 15.0))
    _, total = found_in(dirty)
    np.testing.assert_allclose(total["LeftShoulder"], full, atol=np.radians(0.1))


@pytest.mark.thorough
def test_what_a_straight_limb_tells_no_soft_error_moves():
    motion = clip("walk.bvh", "rich")
    _, dirty = erring(motion, "LeftArm", 150, SHAPES["ramp of 16"])
    surprise, rows = surprise_of(dirty)
    row = rows["LeftArm"]
    told = np.full(20, np.radians(4.0))
    for firm in (False, True):
        known = [Known(row, 160, told, firm=firm)]
        searched = search_soft_errors(surprise.limbs, FPS, surprise.cut, known)
        assert any(f.row == row for f in searched.found) is not firm
        assert searched.replaced == ([] if firm else known)


def test_sizes_are_those_that_leave_least_whatever_else_is_there():
    motion = clip("walk.bvh", "rich")
    low, high = 130, 220
    shape = softened_level_curves(np.array([[1.0, 30.0, 60.0, 8.0]]), linear_unit_ramp, high - low)
    offset = np.radians(50.0) * shape[0]
    offset[20:26] += np.radians(90.0)  # and a glitch that is none of the level's
    _, dirty = erring(motion, "LeftArm", low, offset)
    surprise, rows = surprise_of(dirty)
    bad = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    bad[:, low:high] = True
    surprise.measure(bad)
    stretch = surprise.local_departures(rows["LeftArm"], low, high - low)
    (size,) = stretch.sizes(stretch.departures(shape))
    assert abs(np.degrees(size) - 50.0) < 2.5


@pytest.mark.parametrize("name", ["LeftUpLeg", "LeftLeg"])
def test_of_two_chains_that_share_a_silent_knee_the_one_whose_other_joint_answers(name):
    motion = clip("walk.bvh")
    offset = np.radians(-79.0) + np.radians(RNG.standard_normal(18))
    _, dirty = erring(motion, name, 150, offset)
    surprise, rows = surprise_of(dirty, name)
    thigh, shin = rows["LeftUpLeg"], rows["LeftLeg"]
    own = offset if name == "LeftLeg" else -offset  # what the knee turns
    told = [SoftError(thigh, 150, -own, 200.0, 1e-3), SoftError(shin, 150, own, 200.0, 1e-3)]
    for best in told:
        found = _of_two_chains(surprise, {thigh: -1, shin: 1}, best, told)
        assert found.row == rows[name]


def test_a_straight_limb_is_judged_without_the_images_of_jumps_beside_it():
    motion = clip("walk.bvh")
    chains = [c for c in find_chains(motion) if c.name in ("LeftArm", "LeftForeArm")]
    _, dirty = erring(motion, "LeftForeArm", 150, np.full(14, np.radians(70.0)))
    seen = []
    for m in (motion, dirty):
        limbs, cut = _limbs([chains], m), np.arange(m.frames) == 0
        jumps = find_jumps(limbs, m.fps, cut, [(0, m.frames)], lambda _: None)
        own = [j.counter.y[j.row] for j in jumps]
        seen.append((own[0], np.array(_by_itself(limbs, jumps, 0))))
    (y, _), (y_with_image, by_itself) = seen
    assert np.abs(y_with_image - y).max() > 0.5
    np.testing.assert_allclose(by_itself, seen[0][1], atol=np.radians(0.2))
