"""One frame's quantities: equal to those of the whole clip, and what altering a frame does."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.decomposition import WhatIf, decompose, frame_motion_with_user_changes
from twistcore.detection import Interval
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decision, Judged
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    rotate,
    wrap,
)
from twistcore.skeleton.signals import twist_signals
from twistcore.study.exercise import hide_exercise_errors, score_review_of_hidden_errors

EXACT = 1e-9
TURN = np.radians(70.0)


@pytest.fixture(scope="module")
def clip():
    return read_bvh(ASSETS / "dance.bvh")


@pytest.fixture(scope="module", params=["LeftForeArm", "RightArm", "RightUpLeg"])
def chain(request, clip):
    return next(c for c in find_chains(clip.motion) if c.name == request.param)


def test_angles_are_those_of_the_whole_clip(sample):
    motion = sample.motion
    for chain in find_chains(motion):
        whole = twist_signals(motion, chain)
        for frame in (0, 1, 50, 206, motion.frames - 1):
            one = decompose(motion, chain, frame)
            pairs = [
                (one.theta_p, whole.theta_p),
                (one.dtheta_p, whole.dtheta_p),
                (one.dtheta_c, whole.dtheta_c),
                (one.strength, whole.strength),
                (one.swing_reliability, whole.swing_reliability),
                (one.azimuth_reliability, whole.azimuth_reliability),
            ]
            for mine, theirs in pairs:
                assert mine == pytest.approx(theirs[frame], abs=1e-12)


def test_swing_is_built_from_axis_and_angle_as_in_the_paper(clip, chain):
    for frame in range(0, clip.motion.frames, 40):
        d = decompose(clip.motion, chain, frame)
        built = np.array([np.cos(d.alpha / 2), *(np.sin(d.alpha / 2) * d.n)])  # Eq. 6
        assert built == pytest.approx(d.swing, abs=1e-8)
        assert multiply(d.swing, d.twist) == pytest.approx(d.q, abs=EXACT)  # Eq. 2
        assert rotate(d.swing, d.a) == pytest.approx(d.w, abs=EXACT)
        if d.alpha > 1e-3:
            cross = np.cross(d.a, d.w)
            assert cross / np.linalg.norm(cross) == pytest.approx(d.n, abs=1e-6)  # Eq. 4


def test_a_pure_twist_leaves_swing_and_azimuth(clip, chain):
    still = decompose(clip.motion, chain, 100)
    turned = decompose(clip.motion, chain, 100, WhatIf(twist=0.4))
    assert turned.w == pytest.approx(still.w, abs=EXACT)
    assert turned.swing == pytest.approx(still.swing, abs=EXACT)
    assert turned.dtheta_p - still.dtheta_p == pytest.approx(0.4)
    assert turned.dtheta_c == pytest.approx(still.dtheta_c)


def test_a_counter_twist_is_an_error_and_leaves_everything_below_in_place(clip, chain):
    still = decompose(clip.motion, chain, 100)
    wrong = decompose(clip.motion, chain, 100, WhatIf(twist=TURN, counter=True))
    assert wrong.dtheta_p - still.dtheta_p == pytest.approx(TURN)
    assert wrong.dtheta_c - still.dtheta_c == pytest.approx(-TURN)
    assert wrong.strength > 0.5 * TURN
    before = forward_kinematics(clip.motion.sliced(100, 101))
    after = forward_kinematics(
        frame_motion_with_user_changes(clip.motion, chain, 100, WhatIf(twist=TURN, counter=True))
    )
    assert after[1] == pytest.approx(before[1], abs=1e-9)
    others = [j for j in range(len(clip.motion.skeleton)) if j != chain.parent]
    assert geodesic_angle(after[0], before[0])[0, others].max() < 1e-6


def test_the_ideal_child_goes_along_and_the_real_one_is_left_behind(clip, chain):
    wrong = decompose(clip.motion, chain, 100, WhatIf(twist=TURN, counter=True))
    turn = quaternion_from_axis_angle(wrong.a, wrong.dtheta_c)
    assert rotate(turn, wrong.v_ideal) == pytest.approx(wrong.v, abs=EXACT)
    flat = wrong.v_ideal - (wrong.v_ideal @ wrong.a) * wrong.a
    # Its azimuth is that of the frame before.
    assert np.cross(flat, wrong.across_before) == pytest.approx(np.zeros(3), abs=1e-6)
    assert flat @ wrong.across_before > 0.0


def test_swing_and_bend_are_set_and_the_twist_stays(clip, chain):
    still = decompose(clip.motion, chain, 100)
    moved = decompose(clip.motion, chain, 100, WhatIf(swing=2.0, bend=0.5))
    assert moved.alpha == pytest.approx(2.0)
    assert moved.bend == pytest.approx(0.5)
    assert moved.theta_p == pytest.approx(still.theta_p, abs=1e-7)
    assert moved.dtheta_c == pytest.approx(still.dtheta_c, abs=1e-7)


def test_both_singularities_are_met_and_nothing_is_nan(clip, chain):
    there = decompose(clip.motion, chain, 100, WhatIf(swing=np.pi, bend=0.0))
    assert there.swing_reliability == pytest.approx(0.0, abs=1e-12)
    assert there.azimuth_reliability == pytest.approx(0.0, abs=1e-12)
    for value in vars(there).values():
        assert np.isfinite(value).all()
    # Beside them a degree sideways is worth a large angle; far from them next to nothing.
    near, tipped = (
        decompose(
            clip.motion,
            chain,
            100,
            WhatIf(swing=np.radians(179.0), bend=np.radians(1.0), nudge=np.radians(x)),
        )
        for x in (0.0, 1.0)
    )
    assert abs(tipped.theta_p - near.theta_p) > np.radians(60.0)
    assert abs(tipped.dtheta_c - near.dtheta_c) > np.radians(40.0)
    assert geodesic_angle(near.q, tipped.q) == pytest.approx(np.radians(1.0), abs=1e-6)
    far = [
        decompose(clip.motion, chain, 100, WhatIf(swing=0.5, bend=1.5, nudge=np.radians(x)))
        for x in (0.0, 1.0)
    ]
    assert abs(far[0].theta_p - far[1].theta_p) < np.radians(2.0)


def test_the_bone_is_pointed_and_its_twist_stays(clip, chain):
    still = decompose(clip.motion, chain, 100)
    w = np.array([0.48, -0.6, 0.64])
    moved = decompose(clip.motion, chain, 100, WhatIf(toward=tuple(w)))
    assert moved.w == pytest.approx(w, abs=EXACT)
    assert moved.twist == pytest.approx(still.twist, abs=EXACT)
    further = decompose(clip.motion, chain, 100, WhatIf(toward=tuple(w), swing=0.3))
    assert further.alpha == pytest.approx(0.3)
    assert further.n == pytest.approx(moved.n, abs=1e-8)
    for way in (still.a, -still.a):
        there = decompose(clip.motion, chain, 100, WhatIf(toward=tuple(way)))
        assert there.w == pytest.approx(way, abs=EXACT)


def test_taking_an_offset_off_takes_a_counter_twist_back(clip, chain):
    frame = 100
    wrong = WhatIf(twist=TURN, counter=True)
    still = decompose(clip.motion, chain, frame)
    dirty = frame_motion_with_user_changes(clip.motion, chain, frame, wrong)
    for share in (0.5, 1.0):
        applied = replace(wrong, applied=share)
        d = decompose(clip.motion, chain, frame, applied, offset=TURN)
        assert wrap(d.theta_p - still.theta_p) == pytest.approx((1.0 - share) * TURN)
        right = frame_motion_with_user_changes(clip.motion, chain, frame, applied, offset=TURN)
        places = forward_kinematics(right)[1] - forward_kinematics(dirty)[1]
        assert np.abs(places).max() < 1e-9
    assert right.rotations[0] == pytest.approx(
        clip.motion.rotations[frame]
        * np.sign(np.sum(right.rotations[0] * clip.motion.rotations[frame], axis=1))[:, None],
        abs=1e-12,
    )


def test_a_stage_is_part_of_the_swing_then_part_of_the_twist(clip, chain):
    whole = decompose(clip.motion, chain, 100)
    for stage, swing, twist in ((0, 0, 0), (0.4, 0.4, 0), (1, 1, 0), (1.25, 1, 0.25), (2, 1, 1)):
        d = decompose(clip.motion, chain, 100, stage=stage)
        assert d.alpha == pytest.approx(swing * whole.alpha, abs=1e-7)
        assert d.theta_p == pytest.approx(twist * whole.theta_p, abs=EXACT)
        if swing > 0.0:
            assert d.n == pytest.approx(whole.n, abs=1e-7)
    assert d.q == pytest.approx(whole.q, abs=EXACT)
    # The children are carried: their own rotations are as they were.
    part = frame_motion_with_user_changes(clip.motion, chain, 100, WhatIf(), stage=0.5)
    others = np.arange(len(clip.motion.skeleton)) != chain.parent
    still = clip.motion.rotations[100, others]
    assert part.rotations[0, others] == pytest.approx(still, abs=1e-15)


def test_altering_a_frame_touches_no_other(clip, chain):
    kept = clip.motion.rotations.copy()
    decompose(clip.motion, chain, 100, WhatIf(twist=1.0, counter=True, swing=1.0, nudge=0.1))
    assert np.array_equal(kept, clip.motion.rotations)


def judged(number, chain, start, stop, decision):
    return Judged(number, Interval(chain, start, stop, np.full(stop - start, 1.0)), decision)


def test_hidden_errors_depend_on_the_seed_alone(clip):
    chains = find_chains(clip.motion)
    one, errors = hide_exercise_errors(clip.motion, chains, 7)
    same, again = hide_exercise_errors(clip.motion, chains, 7)
    other, _ = hide_exercise_errors(clip.motion, chains, 8)
    assert np.array_equal(one.rotations, same.rotations)
    assert not np.array_equal(one.rotations, other.rotations)
    assert [(e.chain, e.start, e.stop) for e in errors] == [
        (e.chain, e.start, e.stop) for e in again
    ]
    assert len({e.chain for e in errors}) == 2
    assert len(errors) >= 4


def test_every_kind_of_verdict_is_counted(clip):
    chains = find_chains(clip.motion)
    _, errors = hide_exercise_errors(clip.motion, chains, 7)
    found, overlooked, denied, *rest = errors
    free = next(c.name for c in chains if c.name not in {e.chain for e in errors})
    yes, no = Decision.ACCEPTED, Decision.REJECTED
    review = [
        judged(1, found.chain, found.start, found.stop, yes),
        judged(2, denied.chain, denied.start, denied.stop, no),
        judged(3, free, 10, 20, yes),
        judged(4, free, 40, 50, no),
        judged(5, free, 60, 70, Decision.UNDECIDED),
    ]
    result = score_review_of_hidden_errors(errors, review)
    assert result.hits == (found,)
    assert set(result.misses) == {overlooked, denied, *rest}
    assert [i.start for i in result.false_accepted] == [10]
    assert [i.start for i in result.false_rejected] == [denied.start]
    assert (result.false_verdicts, result.left) == (2, 1)
    # The same frames in another chain are no hit.
    assert not score_review_of_hidden_errors(
        [found], [judged(1, free, found.start, found.stop, yes)]
    ).hits
