"""What a correction changes, and all that it does not."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import examples
from tests.twistcore.test_chain import FAMILIES, limbs, rig
from twistcore.analysis.correction.twist_removal import children_off_axis, refine, remove_twist
from twistcore.detection import Interval
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.clip import changed_rotations, create_file_patch_for_motion
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, twist_angle, wrap

WALK = read_bvh(ASSETS / "walk.bvh")
CHAINS = find_chains(WALK.motion)


def offsets_of(chain_index, start, length, degrees):
    offset = np.zeros(WALK.motion.frames)
    offset[start : start + length] = np.radians(degrees)
    return {CHAINS[chain_index].name: offset}


some_offsets = st.builds(
    offsets_of,
    st.integers(0, len(CHAINS) - 1),
    st.integers(0, 320),
    st.integers(1, 20),
    st.floats(-180, 180).filter(lambda d: abs(d) > 0.01),
)


@settings(max_examples=examples(40))
@given(some_offsets)
def test_only_the_parents_twist_changes(offsets):
    (name,) = offsets
    chain = next(c for c in CHAINS if c.name == name)
    motion, refined = WALK.motion, remove_twist(WALK.motion, CHAINS, offsets)
    before, after = forward_kinematics(motion), forward_kinematics(refined)
    assert np.abs(before[1] - after[1]).max() <= 1e-9 * motion.skeleton.height
    others = [j for j in range(len(motion.skeleton)) if j != chain.parent]
    assert geodesic_angle(before[0][:, others], after[0][:, others]).max() < 1e-7
    for m, sign in ((motion, 0.0), (refined, 1.0)):
        turned = wrap(
            twist_angle(m.rotations[:, chain.parent], chain.axis)
            - twist_angle(motion.rotations[:, chain.parent], chain.axis)
        )
        assert np.abs(wrap(turned + sign * offsets[name])).max() < 1e-9
    touched = {chain.parent, *motion.skeleton.children[chain.parent]}
    changed = changed_rotations(WALK, refined)
    assert set(np.flatnonzero(changed.any(axis=0))) == touched
    assert not changed[offsets[name] == 0.0].any()


@settings(max_examples=examples(25))
@given(some_offsets, some_offsets)
def test_corrections_commute_and_cancel(one, other):
    first = remove_twist(remove_twist(WALK.motion, CHAINS, one), CHAINS, other)
    second = remove_twist(remove_twist(WALK.motion, CHAINS, other), CHAINS, one)
    assert geodesic_angle(first.rotations, second.rotations).max() < 1e-7
    back = {name: -offset for name, offset in one.items()}
    undone = remove_twist(remove_twist(WALK.motion, CHAINS, one), CHAINS, back)
    assert geodesic_angle(undone.rotations, WALK.motion.rotations).max() < 1e-7


def test_overlapping_intervals_add(walk):
    intervals = [
        Interval("LeftArm", 10, 20, np.full(10, 0.3)),
        Interval("LeftArm", 15, 25, np.full(10, 0.4)),
    ]
    refined = refine(walk.motion, CHAINS, intervals)
    chain = next(c for c in CHAINS if c.name == "LeftArm")
    turned = wrap(
        twist_angle(walk.motion.rotations[:, chain.parent], chain.axis)
        - twist_angle(refined.rotations[:, chain.parent], chain.axis)
    )
    np.testing.assert_allclose(turned[[9, 10, 15, 19, 20, 24, 25]], [0, 0.3, 0.7, 0.7, 0.4, 0.4, 0])


def test_an_export_changes_the_tokens_of_one_interval_and_no_other(sample):
    """The proof that nothing else changed: token by token, with every byte between them."""
    motion = sample.motion
    chains = find_chains(motion)
    chain = next(c for c in chains if c.name == "RightLeg")
    start, stop = 40, 52
    interval = Interval(chain.name, start, stop, np.full(stop - start, 1.2))
    refined = refine(motion, chains, [interval])
    data = create_file_patch_for_motion(sample, refined).data
    again = parse_bvh(data)
    old, new = sample.token_spans, again.token_spans
    assert len(old[0]) == len(new[0])
    joints = (chain.parent, *motion.skeleton.children[chain.parent])
    allowed = {
        t * sample.values.shape[1] + column
        for t in range(start, stop)
        for joint in joints
        for column in sample.channels[joint].rotation
    }
    changed = {
        k
        for k in range(len(old[0]))
        if sample.data[old[0][k] : old[1][k]] != data[new[0][k] : new[1][k]]
    }
    assert changed
    assert changed <= allowed
    gaps_old = [sample.data[e:s] for e, s in zip(old[1][:-1], old[0][1:], strict=True)]
    gaps_new = [data[e:s] for e, s in zip(new[1][:-1], new[0][1:], strict=True)]
    assert gaps_old == gaps_new
    assert sample.data[: old[0][0]] == data[: new[0][0]]
    assert sample.data[old[1][-1] :] == data[new[1][-1] :]
    moved = forward_kinematics(motion)[1] - forward_kinematics(again.motion)[1]
    assert np.abs(moved).max() <= 1e-6 * motion.skeleton.height


def with_twist_bones():
    body = limbs(*FAMILIES["Character Creator"])
    body["CC_Base_L_ForearmTwist01"] = "CC_Base_L_Forearm"
    body["CC_Base_L_ElbowShareBone"] = "CC_Base_L_Forearm"
    return rig(
        body, {"CC_Base_L_ForearmTwist01": (0, 0.5, 0), "CC_Base_L_ElbowShareBone": (0.1, 0, 0)}
    )


def test_twist_bone_siblings_do_not_spin():
    clip = with_twist_bones()
    chains = find_chains(clip.motion)
    offsets = {"CC_Base_L_Forearm": np.array([0.0, 1.5])}
    refined = remove_twist(clip.motion, chains, offsets)
    before, after = forward_kinematics(clip.motion), forward_kinematics(refined)
    for name in ("CC_Base_L_ForearmTwist01", "CC_Base_L_ElbowShareBone", "CC_Base_L_Hand"):
        j = clip.motion.skeleton.index(name)
        assert geodesic_angle(before[0][:, j], after[0][:, j]).max() < 1e-7
    twist = clip.motion.skeleton.index("CC_Base_L_ForearmTwist01")
    np.testing.assert_allclose(before[1][:, twist], after[1][:, twist], atol=1e-12)


def test_a_sibling_beside_the_axis_is_named():
    clip = with_twist_bones()
    chain = next(c for c in find_chains(clip.motion) if c.name == "CC_Base_L_Forearm")
    assert children_off_axis(clip.motion, chain) == {"CC_Base_L_ElbowShareBone": pytest.approx(0.1)}


def test_a_joint_that_cannot_take_a_rotation_is_left_alone():
    clip = rig(limbs(*FAMILIES["MotionBuilder"]), channels={"LeftForeArm": 1})
    chains = find_chains(clip.motion)
    refined = remove_twist(clip.motion, chains, {"LeftArm": np.array([0.0, 1.0])})
    np.testing.assert_array_equal(refined.rotations, clip.motion.rotations)


def test_a_bone_whose_place_varies_a_little_keeps_every_position():
    """Position channels on the child that wander by less than the 1° detection passes over."""
    motion = WALK.motion
    child = motion.skeleton.index("LeftForeArm")
    wander = np.random.default_rng(0).normal(0.0, 0.02, (motion.frames, 1, 3))
    positions = np.concatenate([motion.positions, motion.skeleton.offsets[child] + wander], axis=1)
    moving = replace(motion, positioned=(*motion.positioned, child), positions=positions)
    chains = find_chains(moving)
    chain = next(c for c in chains if c.name == "LeftArm")
    assert chain.axis.ndim == 1
    refined = remove_twist(moving, chains, {"LeftArm": np.full(motion.frames, 1.5)})
    before, after = forward_kinematics(moving)[1], forward_kinematics(refined)[1]
    assert np.abs(before - after).max() <= 1e-9 * motion.skeleton.height
