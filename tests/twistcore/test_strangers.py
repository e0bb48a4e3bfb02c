"""Rigs and names that strangers' captures have: the right joint is found, and corrected.

Each is made from a walk of CMU's, with errors put in.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from benchmarks._rig_families import RIGS
from benchmarks._rigs import rigged
from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine, remove_twist
from twistcore.batch.clip_result import process_clip
from twistcore.batch.parameters import Parameters
from twistcore.cli import main
from twistcore.detection import Kind
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.bvh.compose import bvh_text
from twistcore.skeleton.chain import make_chain
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
)
from twistcore.tuning.clip_curves import prepare_clip_tuning

WALK = read_bvh(ASSETS / "walk.bvh").motion
BY_NAME = {rig.name: rig for rig in RIGS}
# Joint by CMU's name, frames [start, stop), degrees.
FIVE = (
    ("LeftArm", 60, 75, 50.0),
    ("RightUpLeg", 120, 132, -35.0),
    ("RightForeArm", 200, 214, 70.0),
    ("LeftLeg", 260, 268, 25.0),
    ("RightArm", 320, 340, -15.0),
)
BONES = {"Arm": "ForeArm", "UpLeg": "Leg", "ForeArm": "Hand", "Leg": "Foot"}


def twisted(motion, parent, child, start, stop, degrees):
    """The motion with a joint turned about its bone in some frames, and its children back."""
    names = motion.skeleton.names
    chain = make_chain(motion, names.index(parent), names.index(child))
    offset = np.zeros(motion.frames)
    offset[start:stop] = np.radians(-degrees)
    return remove_twist(motion, [chain], {chain.name: offset})


def with_five():
    motion = WALK
    for joint, start, stop, degrees in FIVE:
        side, bone = ("Left", joint[4:]) if joint.startswith("Left") else ("Right", joint[5:])
        motion = twisted(motion, joint, side + BONES[bone], start, stop, degrees)
    return motion


DIRTY = with_five()


def renamed(motion, name):
    skeleton = motion.skeleton
    return replace(motion, skeleton=replace(skeleton, names=tuple(map(name, skeleton.names))))


def numbered(pattern, hand, foot, toe, collar):
    """Names of joints told apart by numbers; pattern: of {part}, {s} and {n} from 1."""

    def name(joint):
        for side in ("Left", "Right"):
            if joint.startswith(side):
                part, s = joint.removeprefix(side), side[0]
                known = {"Arm": ("Arm", 1), "ForeArm": ("Arm", 2)}
                known |= {"UpLeg": ("Leg", 1), "Leg": ("Leg", 2)}
                if part in known:
                    limb, n = known[part]
                    return pattern.format(part=limb, small=limb.lower(), s=s, n=n, zero=n - 1)
                tips = {"Hand": hand, "Foot": foot, "ToeBase": toe, "Shoulder": collar}
                return tips[part].format(s=s) if part in tips else joint
        return joint

    return name


def instead(**words):
    """Names in which some of CMU's words are others."""

    def name(joint):
        for side in ("Left", "Right"):
            if joint.removeprefix(side) in words and joint.startswith(side):
                return words[joint.removeprefix(side)].format(side=side, s=side[0])
        return joint

    return name


LIMB_NAMES = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
NAMES = {
    "Leg1, Leg2": numbered("{s}_{part}{n}", "{s}_Hand", "{s}_Foot", "{s}_Toe", "{s}_Clavicle"),
    "3ds Max": numbered("Bone_{s}_{part}0{n}", "Bone_{s}_Hand01", "Bone_{s}_Foot01",
        "Bone_{s}_Foot02", "Bone_{s}_Clav"),
    "mGear": numbered("{small}_{s}0_{zero}_jnt", "hand_{s}0_0_jnt", "foot_{s}0_0_jnt",
        "foot_{s}0_1_jnt", "shoulder_{s}0_0_jnt"),
    "a palm": instead(Hand="{side}Palm"),
    "_anim": instead(Hand="{side}Hand_anim"),
    "Rot": instead(Hand="{side}HandRot"),
    "a heel": instead(Foot="{side}Heel", ToeBase="{side}FootToe"),
    "in the middle": instead(**{n: n[0].lower() + "_{s}_" + n + "_hi" for n in LIMB_NAMES}),
}  # fmt: skip


def corrected(motion):
    found = analyse(motion).detect()
    return refine(motion, found.chains_and_limbs, automatic_corrections(found)), found


def farthest(one, other):
    """The largest angle between the rotations of two motions, degrees."""
    return np.degrees(geodesic_angle(one.rotations, other.rotations).max())


@parametrize("family", NAMES, quick=2)
def test_five_errors_are_found_and_corrected_whatever_the_joints_are_called(family):
    motion = renamed(DIRTY, NAMES[family])
    refined, found = corrected(motion)
    assert len(found.chains) == 10
    assert {(c.side, bool(c.segment)) for c in found.chains} == {("Left", True), ("Right", True)}
    labels = {c.name: c.label.replace(" ", "") for c in found.chains}
    places = {(labels[i.chain], i.start, i.stop) for i in found}
    assert places == {(joint, start, stop) for joint, start, stop, _ in FIVE}
    assert farthest(refined, WALK) < 0.01
    assert found.analysis.unexamined == ()


def test_positions_on_all_joints_and_offsets_of_zero_change_nothing():
    motion = DIRTY
    joints = range(len(motion.skeleton))
    places = np.stack(
        [np.broadcast_to(motion.translation(j), (motion.frames, 3)) for j in joints], 1
    )
    six = replace(motion, positioned=tuple(joints), positions=places)
    text = bvh_text(six)
    lines = [
        "OFFSET 0 0 0" if line.split()[:1] == ["OFFSET"] else line for line in text.split("\n")
    ]
    for written in (text, "\n".join(lines)):
        read = parse_bvh(written.encode()).motion
        found = analyse(read).detect()
        assert {(i.chain, i.start, i.stop) for i in found} == {place[:3] for place in FIVE}
        assert {(c.side, c.segment) for c in found.chains} == {
            (c.side, c.segment) for c in analyse(WALK).chains
        }
        assert read.skeleton.height == pytest.approx(WALK.skeleton.height, rel=0.2)


IN_CHAIN = {  # rig, P, C, and the label of the find
    "MakeHuman, arm": ("MakeHuman", "upperarm02.L", "lowerarm01.L", "Left Arm"),
    "MakeHuman, thigh": ("MakeHuman", "upperleg02.L", "lowerleg01.L", "Left UpLeg"),
    "Qualisys": ("Qualisys", "LeftForeArmRoll", "LeftHand", "Left ForeArm"),
    "MMD": ("MMD", "左手捩", "左手首", "Left ForeArm"),
    "Advanced Skeleton": ("Maya Advanced Skeleton", "HipPart1_L", "Knee_L", "Left UpLeg"),
    "Unity": ("Unity _tw", "LeftUpperArm_tw", "LeftLowerArm", "Left Arm"),
    "between the pieces": ("Daz Genesis 3/8", "lShldrBend", "lShldrTwist", "Left Arm"),
}


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
@parametrize("case", IN_CHAIN, quick=4)
def test_of_a_bone_in_pieces_the_piece_that_c_hangs_on_is_corrected(case, share):
    name, parent, child, label = IN_CHAIN[case]
    clean = rigged(WALK, replace(BY_NAME[name], share=share))
    refined, found = corrected(twisted(clean, parent, child, 150, 165, 60.0))
    assert [(i.chain, i.start, i.stop) for i in found] == [(parent, 150, 165)]
    chain = found.analysis.chain(parent)
    assert chain.label == f"{label} · {parent}"
    assert clean.skeleton.names[chain.child] == child
    assert farthest(refined, clean) < 0.2


# -- helpers ---------------------------------------------------------------------------------------

UNREAL = rigged(WALK, BY_NAME["Unreal 5"])


def rolled(motion, joint, degrees):
    """The motion with a joint turned about the bone of its parent by degrees, (frames,)."""
    skeleton = motion.skeleton
    j = skeleton.index(joint)
    siblings = skeleton.children[int(skeleton.parents[j])]
    axis = normalise(max(skeleton.offsets[list(siblings)], key=np.linalg.norm))
    rotations = motion.rotations.copy()
    turn = quaternion_from_axis_angle(axis, np.radians(degrees))
    rotations[:, j] = normalise(multiply(turn, rotations[:, j]))
    return motion.with_rotations(rotations)


def test_a_helper_that_pops_alone_is_found_and_can_be_put_back():
    degrees = np.zeros(UNREAL.frames)
    degrees[150:165] = 90.0
    popped = rolled(UNREAL, "upperarm_twist_01_l", degrees)
    found = analyse(popped).detect()
    (only,) = found
    assert (only.chain, only.kind, only.start, only.stop) == (
        "upperarm_twist_01_l", Kind.HELPER_ROLL, 150, 165,
    )  # fmt: skip
    assert only.confidence is None
    assert found.analysis.chain(only.chain).label == "Left Arm · upperarm_twist_01_l"
    assert automatic_corrections(found, include_open=True) == ()  # never by itself
    back = refine(popped, found.chains_and_limbs, found)
    j = UNREAL.skeleton.index("upperarm_twist_01_l")
    assert np.degrees(geodesic_angle(back.rotations, UNREAL.rotations)[:, j].max()) < 4.0
    others = np.arange(len(UNREAL.skeleton)) != j
    np.testing.assert_array_equal(back.rotations[:, others], popped.rotations[:, others])


def flipping_helper():
    """A walk on Unreal's rig with a twist bone of the left forearm that flips every 20 frames."""
    sign = np.where(np.arange(UNREAL.frames) // 20 % 2, 90.0, -90.0)
    return rolled(UNREAL, "lowerarm_twist_01_l", sign)


def test_a_driver_that_flips_is_found_at_its_helper():
    found = analyse(flipping_helper()).detect()
    assert {i.chain for i in found} == {"lowerarm_twist_01_l"}
    assert {i.kind for i in found} == {Kind.HELPER_ROLL}
    borders = {t for i in found for t in (i.start, i.stop)}
    assert borders >= set(range(40, 320, 20))


def test_one_tau_for_all_chains_is_not_that_of_helpers():
    found = analyse(UNREAL).detect(tau_degrees=3.0)
    assert found.tau["upperarm_l"] == pytest.approx(np.radians(3.0))
    assert found.tau["upperarm_twist_01_l"] > np.radians(10.0)


def test_nor_is_it_that_of_helpers_with_a_profile(tmp_path, capsys):
    clip, profile = tmp_path / "unreal.bvh", tmp_path / "profile.toml"
    clip.write_bytes(bvh_text(UNREAL).encode())
    profile.write_text("[upperarm_r]\ntau_deg = 7.0\n[nobody]\ntau_deg = 9.0\n")
    main(["detect", str(clip), "--tau", "3", "--profile", str(profile), "--json"])
    detected = json.loads(capsys.readouterr().out)["tau_deg"]
    radians = {"upperarm_r": np.radians(7.0), "nobody": np.radians(9.0)}
    _, document, _ = process_clip(clip, Parameters(tau_deg=3.0, profile_rad=radians))
    for tau in (detected, document["tau_deg"]):
        assert tau["upperarm_l"] == pytest.approx(3.0)
        assert tau["upperarm_r"] == pytest.approx(7.0)
        assert tau["upperarm_twist_01_l"] > 10.0


def test_tuning_leaves_helpers_out():
    tuned = prepare_clip_tuning(UNREAL.sliced(0, 120), "walk", seeds=(0,))
    assert len(tuned.names) == 10
    assert tuned.curve("upperarm_l").minutes > 0.0


def test_an_error_of_the_limb_is_none_of_its_helpers():
    """A helper keeps its place in the room, as all children of a twisted joint do."""
    twist = twisted(UNREAL, "upperarm_l", "lowerarm_l", 150, 165, 60.0)
    found = analyse(twist).detect()
    assert [(i.chain, i.kind) for i in found] == [("upperarm_l", Kind.COUNTER_TWIST)]
    refined = refine(twist, found.chains_and_limbs, automatic_corrections(found))
    assert farthest(refined, UNREAL) < 0.01


def test_a_helper_that_follows_a_turning_hand_is_no_error():
    """A flick of the hand by 60° in a frame takes its twist bones along."""
    names = UNREAL.skeleton.names
    motion, hand = UNREAL, names.index("hand_l")
    axis = normalise(UNREAL.skeleton.offsets[hand])
    rotations = motion.rotations.copy()
    for joint, share in (
        ("hand_l", 1.0),
        ("lowerarm_twist_01_l", 0.8),
        ("lowerarm_twist_02_l", 0.5),
    ):
        angle = np.zeros(motion.frames)
        angle[150:] = np.radians(60.0 * share)
        j = names.index(joint)
        turn = quaternion_from_axis_angle(axis, angle)
        rotations[:, j] = normalise(multiply(turn, rotations[:, j]))
    found = analyse(motion.with_rotations(rotations)).detect()
    assert not [i for i in found if i.kind == Kind.HELPER_ROLL]
