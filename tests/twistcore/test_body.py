"""The limbs of bodies: by names, by what is known of a limb, by shape."""

import random
from dataclasses import replace

import numpy as np
import pytest

from benchmarks._rig_families import RIGS
from benchmarks._rigs import rigged
from tests.conftest import ASSETS
from twistcore.errors import FormatError
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.body import find_body
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.skeleton.rig import AS_FOUND, Rig, read_rig, rig_from_json, rig_to_json, write_rig

WALK = read_bvh(ASSETS / "walk.bvh").motion


def renamed(motion, **names):
    """The motion with joints of other names; with no names given, under random syllables."""
    skeleton = motion.skeleton
    if not names:
        rng = random.Random(5)
        syllables = ["".join(rng.choice("bdkmptz") + rng.choice("aeiou")) for _ in skeleton.names]
        names = {
            n: f"{s}{'qxwv'[k % 4]}{k}"
            for k, (n, s) in enumerate(zip(skeleton.names, syllables, strict=True))
        }
    return replace(
        motion, skeleton=replace(skeleton, names=tuple(names.get(n, n) for n in skeleton.names))
    )


def pairs(motion):
    return {(c.parent, c.child) for c in find_chains(motion)}


def told(motion):
    """Label and parent's name of each chain."""
    return [(f"{c.side} {c.segment}", c.name) for c in find_chains(motion)]


def test_a_body_whose_names_say_nothing_has_all_its_limbs_by_shape():
    unnamed = renamed(WALK)
    assert pairs(unnamed) >= pairs(WALK)
    named = {(x.parent, x.child, x.end) for x in find_limbs(WALK, find_chains(WALK))}
    found = {(x.parent, x.child, x.end) for x in find_limbs(unnamed, find_chains(unnamed))}
    assert found == named
    assert all(line.by_shape for line in find_body(unnamed).lines)
    assert find_body(unnamed).missing == ()


@pytest.mark.parametrize("hand", ["LeftPaddle", "xyz", "LeftHand_zzz"])
def test_an_unknown_hand_takes_no_limb_away(hand):
    found = told(renamed(WALK, LeftHand=hand))
    assert found == told(WALK)


@pytest.mark.parametrize("sides", [("Left",), ("Left", "Right")])
def test_a_hand_that_is_called_a_finger_moves_no_bone_of_an_unknown_arm(sides):
    new = {"Shoulder": "Bubu", "Arm": "Lala", "ForeArm": "Kiki", "Hand": "FingerPlate"}
    odd = renamed(WALK, **{s + old: s[0] + word for s in sides for old, word in new.items()})
    assert [label for label, _ in told(odd)] == [label for label, _ in told(WALK)]
    assert pairs(odd) == pairs(WALK)


def test_an_arm_without_any_known_name_is_found_opposite_to_the_other():
    joints = ("LeftShoulder", "LeftArm", "LeftForeArm", "LeftHand")
    odd = renamed(WALK, **dict(zip(joints, ("qa", "qe", "qi", "qo"), strict=True)))
    assert [label for label, _ in told(odd)] == [label for label, _ in told(WALK)]
    assert pairs(odd) == pairs(WALK)
    assert [(x.side, x.kind) for x in find_body(odd).lines if x.by_shape] == [("Left", "arm")]


def test_both_arms_without_known_names_are_told_apart_by_their_place():
    joints = [s + j for s in ("Left", "Right") for j in ("Shoulder", "Arm", "ForeArm", "Hand")]
    odd = renamed(WALK, **{name: f"zu{'abcdefgh'[k]}x" for k, name in enumerate(joints)})
    assert told(odd)[0] == ("Left Shoulder", "zuax")
    assert pairs(odd) == pairs(WALK)


def without(motion, *gone):
    """The motion without joints and all that hangs on them."""
    skeleton, out = motion.skeleton, set()
    for j, name in enumerate(skeleton.names):
        if name in gone or int(skeleton.parents[j]) in out:
            out.add(j)
    keep = [j for j in range(len(skeleton)) if j not in out]
    new = {j: k for k, j in enumerate(keep)} | {-1: -1}
    ends = tuple((new[j], end) for j, end in skeleton.ends if j in new)
    ends += tuple(
        (new[int(skeleton.parents[skeleton.index(n)])], tuple(skeleton.offsets[skeleton.index(n)]))
        for n in gone
    )
    cut = replace(
        skeleton,
        names=tuple(skeleton.names[j] for j in keep),
        parents=np.array([new[int(skeleton.parents[j])] for j in keep]),
        offsets=skeleton.offsets[keep],
        ends=ends,
        rotatable=None,
    )
    return replace(motion, skeleton=cut, rotations=motion.rotations[:, keep])


def test_an_arm_that_ends_in_an_end_site_has_the_chains_above_and_names_the_rest():
    handless = without(WALK, "LeftHand")
    left = [c for c in find_chains(handless) if c.side == "Left" and "Leg" not in c.segment]
    assert [(c.segment, c.name) for c in left] == [("Shoulder", "LeftShoulder"), ("Arm", "LeftArm")]
    bone = WALK.skeleton.offsets[WALK.skeleton.index("LeftHand")]
    np.testing.assert_allclose(left[1].arm, bone / np.linalg.norm(bone))
    assert [(u.limb, u.side, u.kind) for u in find_body(handless).missing] == [
        ("left forearm", "Left", "arm")
    ]


def test_limbs_that_are_not_there_are_named():
    armless = without(WALK, "LeftShoulder", "RightShoulder")
    assert [u.limb for u in find_body(armless).missing] == ["left arm", "right arm"]
    assert [label for label, _ in told(armless)] == [
        "Left UpLeg", "Left Leg", "Right UpLeg", "Right Leg",
    ]  # fmt: skip


def test_joints_told_apart_by_numbers_are_joints_where_they_bend():
    names = {
        "LeftArm": "L_Arm1", "LeftForeArm": "L_Arm2", "LeftHand": "L_Hand",
        "RightUpLeg": "Bone_R_Leg01", "RightLeg": "Bone_R_Leg02", "RightFoot": "Bone_R_Foot01",
    }  # fmt: skip
    found = find_body(renamed(WALK, **names))
    bones = {
        b.segment: b
        for x in found.lines
        for b in x.bones
        if (x.side, x.kind) in (("Left", "arm"), ("Right", "leg"))
    }
    wanted = find_body(WALK)
    same = {
        b.segment: b
        for x in wanted.lines
        for b in x.bones
        if (x.side, x.kind) in (("Left", "arm"), ("Right", "leg"))
    }
    assert bones == same


def test_a_second_hand_elsewhere_does_not_take_the_arm_away():
    skeleton = WALK.skeleton
    more = replace(
        skeleton,
        names=(*skeleton.names, "Prop:LeftWrist"),
        parents=np.append(skeleton.parents, 0),
        offsets=np.vstack([skeleton.offsets, [0.0, 1.0, 0.0]]),
        rotatable=None,
    )
    still = np.zeros((WALK.frames, 1, 4))
    still[..., 0] = 1.0
    motion = replace(WALK, skeleton=more, rotations=np.concatenate([WALK.rotations, still], axis=1))
    assert told(motion) == told(WALK)


# -- what a person takes joints for ----------------------------------------------------------------


NONSENSE = {"LeftForeArm": "xa", "LeftHand": "xe", "LeftArm": "xi", "LeftShoulder": "xo"}


def test_a_person_names_joints_and_the_limb_is_what_they_say():
    motion = renamed(WALK, **NONSENSE)
    own = AS_FOUND.with_names({"xe": "left hand"})
    assert [(c.side, c.segment, c.name) for c in own.chains(motion)][:3] == [
        ("Left", "Shoulder", "xo"), ("Left", "Arm", "xi"), ("Left", "ForeArm", "xa"),
    ]  # fmt: skip
    shifted = AS_FOUND.with_names({"LeftForeArm": "helper"})
    assert [c.name for c in shifted.chains(WALK) if (c.side, c.segment) == ("Left", "ForeArm")] == [
        "LeftArm", "LeftForeArm",
    ]  # fmt: skip
    pinned = AS_FOUND.with_names({"LeftForeArm": "left arm"})
    segments = [(c.segment, c.name) for c in pinned.chains(WALK) if c.name == "LeftForeArm"]
    assert segments == [("Arm", "LeftForeArm")]
    other = AS_FOUND.with_names({"LeftHand": "other"})
    assert "LeftForeArm" not in {c.name for c in other.chains(WALK)}
    with pytest.raises(FormatError, match="'hand'"):
        AS_FOUND.with_names({"LeftHand": "hand"})


def test_names_of_a_rig_are_written_and_read_again(tmp_path):
    own = Rig(names={"xe": "left hand", 'a "b" \x7f': "helper"})
    assert rig_from_json(rig_to_json(own)) == own
    write_rig(tmp_path / "rig.toml", own, WALK.skeleton, "walk.bvh")
    assert read_rig(tmp_path / "rig.toml") == own
    assert bool(own)
    assert own.summary() == "2 named"


def test_a_leg_by_shape_ends_in_its_foot_and_knows_its_pieces():
    """Final Fantasy's legs have unknown names and its arms known ones."""
    rigs = {r.name: r for r in RIGS}
    motion = rigged(WALK, replace(rigs["Final Fantasy XIV"], share=0.5))
    names = motion.skeleton.names
    left = [c for c in find_chains(motion) if c.side == "Left" and c.segment in ("UpLeg", "Leg")]
    assert [(c.segment, c.name, names[c.child]) for c in left] == [
        ("UpLeg", "j_asi_a_l", "j_asi_b_l"),
        ("Leg", "j_asi_b_l", "j_asi_c_l"),
        ("Leg", "j_asi_c_l", "j_asi_d_l"),
    ]
    assert names[left[-1].grandchild] == "j_asi_e_l"


def test_of_a_wrist_next_to_the_hand_the_one_with_fingers_is_the_hand():
    rigs = {r.name: r for r in RIGS}
    motion = rigged(WALK, rigs["Source engine (ValveBiped)"])
    hands = [motion.skeleton.names[c.child] for c in find_chains(motion) if c.segment == "ForeArm"]
    assert hands == ["ValveBiped.Bip01_L_Hand", "ValveBiped.Bip01_R_Hand"]


def test_a_leg_of_which_only_the_hip_joint_is_known_is_examined_whole():
    names = {"LeftUpLeg": "bako", "LeftLeg": "timu", "LeftFoot": "pezo", "LeftToeBase": "kadu"}
    assert pairs(renamed(WALK, **names)) >= pairs(WALK)
