"""A clip under correction is what the corrected motion is, however it is asked."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.corrected import Corrected
from twistcore.analysis.correction.twist_removal import refine, remove_twist
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.limb import limb_middle_and_end_positions
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, wrap
from twistcore.skeleton.signals import twist_signals

MOTION = read_bvh(ASSETS / "walk.bvh").motion.sliced(0, 60)
FLIP = replace(
    new_constant_offset_interval("RightUpLeg-RightFoot", 20, 30, 0.8), kind=Kind.LIMB_FLIP
)
SHARED = [
    new_constant_offset_interval("LeftShoulder", 10, 30, 0.5),
    new_constant_offset_interval("LeftArm", 20, 40, -0.7),
    new_constant_offset_interval("LeftArm", 35, 50, 0.2),
    new_constant_offset_interval("LeftForeArm", 0, 5, 1.0),
    new_constant_offset_interval("RightUpLeg", 50, 60, 3.0),
    new_constant_offset_interval("RightLeg", 1, 3, 0.4),
]


@pytest.fixture(scope="module")
def analysis():
    return analyse(MOTION)


@pytest.fixture(scope="module")
def swinging():
    """The walk with a left elbow that position channels move about its place by some 20°."""
    elbow = MOTION.skeleton.index("LeftForeArm")
    bone = MOTION.skeleton.offsets[elbow]
    at = 0.3 * np.sin(np.arange(60.0) / 7.0)
    aside = at[:, None] * np.roll(bone, 1)
    positions = np.concatenate([MOTION.positions, (bone + aside)[:, None]], axis=1)
    return analyse(replace(MOTION, positioned=(*MOTION.positioned, elbow), positions=positions))


@pytest.mark.parametrize(
    "chosen",
    [SHARED, SHARED[:1], [*SHARED, FLIP], [replace(FLIP, carried=True)], []],
    ids=["many", "one", "with a flip", "carried", "none"],
)
def test_angles_poses_and_ways_are_those_of_the_corrected_motion(analysis, chosen):
    check_all(analysis, chosen)


def test_so_they_are_where_a_bone_s_direction_varies(swinging):
    axes = {c.name: (c.axis.ndim, c.arm.ndim) for c in swinging.chains}
    assert [axes[n] for n in ("LeftShoulder", "LeftArm", "LeftForeArm")] == [(1, 2), (2, 1), (1, 1)]
    check_all(swinging, SHARED)
    check_all(swinging, [SHARED[1]])
    check_all(swinging, [SHARED[3]])


def check_all(analysis, chosen):
    corrected = Corrected(analysis)
    corrected.take(chosen)
    refined = refine(analysis.motion, analysis.chains_and_limbs, chosen)
    for chain in analysis.chains:
        predicted, true = corrected.angles(chain), twist_signals(refined, chain)
        for name in ("theta_p", "theta_c", "dtheta_p", "dtheta_c"):
            off = wrap(getattr(predicted, name) - getattr(true, name))
            assert np.abs(off).max() < 1e-7, (chain.name, name)
        assert predicted.dtheta_p[0] == predicted.dtheta_c[0] == 0.0
    rotations, positions = forward_kinematics(refined)
    for frame in (0, 2, 22, 37, 59):
        turned, there = corrected.pose(frame)
        assert geodesic_angle(turned, rotations[frame]).max() < 1e-7
        np.testing.assert_allclose(there, positions[frame], atol=1e-9)
    joints = np.array([3, 7])
    np.testing.assert_allclose(
        corrected.joint_paths(joints, 15, 45), positions[15:45, joints], atol=1e-9
    )


def test_while_tau_is_dragged_no_motion_is_corrected_for_an_angle(analysis, monkeypatch):
    """Every chain of the walk has the closed form; a flip at one of its joints has none."""
    corrected = Corrected(analysis)
    corrected.take([*SHARED, FLIP])
    anew = []

    def counted(motion, *rest):
        anew.append(motion)
        return remove_twist(motion, *rest)

    monkeypatch.setattr("twistcore.analysis.correction.twist_removal.remove_twist", counted)
    flipped = [c for c in analysis.chains if c.name in ("RightUpLeg", "RightLeg")]
    for chain in analysis.chains:
        corrected.angles(chain)
    assert len(anew) == len(flipped)
    corrected.take(SHARED)
    for chain in analysis.chains:
        corrected.angles(chain)
    assert len(anew) == len(flipped)


def test_the_swivel_is_that_of_the_corrected_motion(analysis):
    chosen = [*SHARED, FLIP]
    corrected = Corrected(analysis)
    corrected.take(chosen)
    refined = refine(MOTION, analysis.chains_and_limbs, chosen)
    for limb in analysis.limbs:
        true = analysis.flips.limbs[limb.name].swivel.angle_at(
            *limb_middle_and_end_positions(refined, limb)
        )
        off = wrap(corrected.swivel(limb) - true)[1:]  # in the T-pose the arms are straight
        assert np.abs(off).max() < 1e-7, limb.name


def test_what_is_taken_is_all_that_is_taken(analysis):
    corrected = Corrected(analysis)
    assert not corrected.offset("LeftArm").any()
    assert not corrected.carried(FLIP.chain).any()
    corrected.take([*SHARED, replace(FLIP, carried=True)])
    arm = np.zeros(60)
    arm[20:40] -= 0.7
    arm[35:50] += 0.2
    np.testing.assert_allclose(corrected.offset("LeftArm"), arm)
    kept = corrected.offset("LeftArm")
    flip = np.where((np.arange(60) >= 20) & (np.arange(60) < 30), 0.8, 0.0)
    np.testing.assert_allclose(corrected.carried(FLIP.chain), flip)
    corrected.take([*SHARED[1:], FLIP])
    assert corrected.offset("LeftArm") is kept  # sums that stay the same stand
    assert not corrected.offset("LeftShoulder").any()
    assert not corrected.carried(FLIP.chain).any()
    np.testing.assert_allclose(corrected.offset(FLIP.chain), flip)
    corrected.take(SHARED[1:2])
    arm[35:50] -= 0.2
    np.testing.assert_allclose(corrected.offset("LeftArm"), arm, atol=1e-15)
    other = replace(
        new_constant_offset_interval("LeftUpLeg-LeftFoot", 5, 9, -0.4),
        kind=Kind.LIMB_FLIP,
        carried=True,
    )
    corrected.take([other, replace(FLIP, carried=True)])
    np.testing.assert_allclose(corrected.carried(FLIP.chain), flip)
    np.testing.assert_allclose(corrected.carried(other.chain)[5:9], -0.4)
    corrected.take([])
    assert not corrected.offset("LeftArm").any()
    with pytest.raises(ValueError, match="read-only"):
        corrected.offset("LeftArm")[0] = 1.0


def test_what_an_export_cannot_write_is_not_shown():
    skeleton = MOTION.skeleton
    rotatable = np.ones(len(skeleton), dtype=bool)
    rotatable[[skeleton.index("LeftForeArm"), skeleton.index("RightFoot")]] = False
    motion = replace(MOTION, skeleton=replace(skeleton, rotatable=rotatable))
    corrected = Corrected(analyse(motion))
    corrected.take([*SHARED, FLIP])
    assert not corrected.offset("LeftArm").any()
    assert not corrected.offset("LeftForeArm").any()
    assert not corrected.offset(FLIP.chain).any()
    assert corrected.offset("LeftShoulder").any()
    corrected.take([replace(FLIP, carried=True)])
    assert corrected.offset(FLIP.chain).any()


def test_the_pose_of_a_frame_is_computed_once_until_the_corrections_change(analysis, monkeypatch):
    chosen = [
        new_constant_offset_interval("LeftArm", 10, 20, 0.5),
        new_constant_offset_interval("RightLeg", 10, 20, -0.5),
    ]
    corrected, frame = Corrected(analysis), 12
    corrected.take(chosen)
    first = corrected.pose(frame)
    parts = []
    part = corrected._part
    monkeypatch.setattr(corrected, "_part", lambda *ends: parts.append(ends) or part(*ends))
    assert corrected.pose(frame) is first
    with pytest.raises(ValueError, match="read-only"):
        first[0][0] = 0.0
    corrected.take(chosen[1:])
    assert not np.array_equal(corrected.pose(frame)[0], first[0])
    corrected.take(chosen)
    np.testing.assert_array_equal(corrected.pose(frame)[0], first[0])
