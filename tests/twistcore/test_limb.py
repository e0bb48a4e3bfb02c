"""Limbs of three joints, by names and without them."""

import numpy as np

from tests.conftest import ASSETS
from tests.twistcore.test_chain import rig
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains, make_chain
from twistcore.skeleton.limb import (
    as_limb,
    bone_lengths,
    find_limbs,
    joint_path,
    limb_middle_and_end_positions,
    path_end_position,
)
from twistcore.skeleton.motion import Motion, Skeleton, forward_kinematics
from twistcore.skeleton.rotation import normalise, rotate

WALK = read_bvh(ASSETS / "walk.bvh").motion


def limbs_of(motion):
    return find_limbs(motion, find_chains(motion))


def test_arms_and_legs_of_a_named_body():
    limbs = limbs_of(WALK)
    assert [(x.label, x.name) for x in limbs] == [
        ("Left arm", "LeftArm-LeftHand"),
        ("Left leg", "LeftUpLeg-LeftFoot"),
        ("Right arm", "RightArm-RightHand"),
        ("Right leg", "RightUpLeg-RightFoot"),
    ]
    leg = limbs[1]
    assert leg.changed_joints(WALK.skeleton) == (leg.parent, leg.end)


def test_where_the_knee_and_the_ankle_are_from_the_hip():
    in_room, positions = forward_kinematics(WALK)
    for limb in limbs_of(WALK):
        to_child, to_end = limb_middle_and_end_positions(WALK, limb)
        for place, joint in ((to_child, limb.child), (to_end, limb.end)):
            way = positions[:, joint] - positions[:, limb.parent]
            assert np.allclose(np.linalg.norm(place, axis=1), np.linalg.norm(way, axis=1))
        assert np.allclose(
            np.einsum("ti,ti->t", to_child, to_end),
            np.einsum(
                "ti,ti->t",
                positions[:, limb.child] - positions[:, limb.parent],
                positions[:, limb.end] - positions[:, limb.parent],
            ),
        )
    assert in_room.shape[1] == len(WALK.skeleton)


def spider(lower):
    """Two lines of five joints from a body, under names that say nothing."""
    parents = {"body": None}
    offsets = {}
    for side, x in (("u", 1), ("w", -1)):
        above = "body"
        for k in range(5):
            parents[f"{side}{k}"] = above
            above = f"{side}{k}"
        offsets |= {f"{side}0": (x, 0, 0), f"{side}1": (x, 1, 0), f"{side}2": (x, 3, 0)}
        offsets |= {f"{side}3": (x, lower, 0), f"{side}4": (x, 1, 0)}
    return rig(parents, offsets).motion


def test_without_names_the_two_longest_bones_of_each_line():
    motion = spider(4)
    limbs = limbs_of(motion)
    assert [x.name for x in limbs] == ["u1-u3", "w1-w3"]
    assert [x.label for x in limbs] == ["u1-u3", "w1-w3"]
    assert joint_path(motion.skeleton, limbs[0].parent, limbs[0].end) == (
        motion.skeleton.index("u2"),
        motion.skeleton.index("u3"),
    )


def test_a_stump_has_no_knee():
    """Beside a bone of 20 one of 3 is none, nor is the next one beside it."""
    assert [x.name for x in limbs_of(spider(20))] == ["u0-u2", "w0-w2"]


def test_what_a_limb_and_its_joints_are_called():
    limbs = limbs_of(WALK)
    assert [(x.middle_word, x.end_word) for x in limbs] == [("elbow", "hand"), ("knee", "foot")] * 2
    assert limbs[0].list_label == "Left arm · limb"
    unknown = limbs_of(spider(4))[0]
    assert (unknown.middle_word, unknown.end_word) == ("middle joint", "end")
    leg = limbs[1]
    assert repr(leg) == f"<Limb LeftUpLeg-LeftFoot: joints {leg.parent} → {leg.child} → {leg.end}>"
    assert leg.changed_joints(WALK.skeleton, carried=True) == (leg.parent,)


def test_bones_and_the_way_along_joints():
    motion = spider(4)
    limb = limbs_of(motion)[0]
    assert bone_lengths(motion, limb) == (np.linalg.norm((1, 3, 0)), np.linalg.norm((1, 4, 0)))
    np.testing.assert_allclose(path_end_position(motion, (limb.child, limb.end)), [(2, 7, 0)] * 2)
    np.testing.assert_allclose(path_end_position(motion, (limb.end,)), [(1, 4, 0)] * 2)


def test_a_limb_of_bones_in_pieces_and_with_positions():
    """Three joints between hip and knee, two between knee and ankle; the knee is moved about."""
    rng = np.random.default_rng(6)
    frames, names = 5, tuple("ahbcdkefz")
    skeleton = Skeleton(names, np.arange(-1, 8), rng.normal(size=(9, 3)))
    rotations = normalise(rng.normal(size=(frames, 9, 4)))
    moved = rng.normal(size=(frames, 1, 3))
    motion = Motion(skeleton, rotations, (5,), moved, 0.1)
    limb = as_limb(motion, make_chain(motion, 1, 5, 8))
    assert (limb.name, joint_path(skeleton, 1, 5)) == ("h-z", (2, 3, 4, 5))
    turned, positions = forward_kinematics(motion)
    for place, joint in zip(limb_middle_and_end_positions(motion, limb), (5, 8), strict=True):
        in_room = rotate(turned[:, 0], place)
        np.testing.assert_allclose(in_room, positions[:, joint] - positions[:, 1], atol=1e-12)
    still = path_end_position(motion, (6, 7, 8))
    assert still.shape == (frames, 3)
    lengths = np.linalg.norm(skeleton.offsets, axis=1)
    upper = lengths[2:5].sum() + np.linalg.norm(moved[:, 0], axis=1).mean()
    np.testing.assert_allclose(bone_lengths(motion, limb), (upper, lengths[6:].sum()))
