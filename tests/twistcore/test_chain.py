"""Chains by name families and by topology."""

from dataclasses import replace

import numpy as np
import pytest

from tests.messages import names_in_one_line
from twistcore.formats.bvh import parse_bvh
from twistcore.skeleton.chain import SEGMENTS, find_chains, make_chain, uncorrectable_joints
from twistcore.skeleton.motion import Motion, Skeleton


def rig(parents, offsets=None, channels=3):
    """A BVH of joints {name: parent name}; the first is the root; two frames at rest."""
    names = list(parents)
    offsets = offsets or {}

    def block(name, indent):
        pad = "  " * indent
        key = "ROOT" if parents[name] is None else "JOINT"
        offset = " ".join(map(str, offsets.get(name, (0, 1, 0))))
        rotation = ["Zrotation", "Xrotation", "Yrotation"]
        count = channels if isinstance(channels, int) else channels.get(name, 3)
        lines = [f"{pad}{key} {name}", pad + "{", f"{pad}OFFSET {offset}"]
        lines.append(f"{pad}CHANNELS {count} {' '.join(rotation[:count])}")
        children = [n for n in names if parents[n] == name]
        for child in children:
            lines += block(child, indent + 1)
        if not children:
            lines += [f"{pad}End Site", pad + "{", f"{pad}OFFSET 0 1 0", pad + "}"]
        return [*lines, pad + "}"]

    total = sum(channels if isinstance(channels, int) else channels.get(n, 3) for n in names)
    row = " ".join(["0"] * total)
    text = "\n".join(["HIERARCHY", *block(names[0], 0), "MOTION", "Frames: 2", "Frame Time: 0.01"])
    return parse_bvh(f"{text}\n{row}\n{row}\n".encode())


def limbs(shoulder, arm, forearm, hand, thigh, shin, foot, toe):
    """A whole-body hierarchy; each name is made for a side by the function given."""
    out = {"hip": None, "spine": "hip", "chest": "spine"}
    for side in "lr":
        above = "chest"
        for make in (shoulder, arm, forearm, hand):
            out[make(side)] = above
            above = make(side)
        above = "hip"
        for make in (thigh, shin, foot, toe):
            out[make(side)] = above
            above = make(side)
    return out


def word(left, right, text):
    return lambda side: text.replace("*", left if side == "l" else right)


FAMILIES = {
    "MotionBuilder": [word("Left", "Right", f"*{n}") for n in
        ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")],
    "Mixamo": [word("Left", "Right", f"mixamorig:*{n}") for n in
        ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")],
    "Poser": [word("l", "r", f"*{n}") for n in
        ("Collar", "Shldr", "ForeArm", "Hand", "Thigh", "Shin", "Foot", "Toe")],
    "Character Creator": [word("L", "R", f"CC_Base_*_{n}") for n in
        ("Clavicle", "Upperarm", "Forearm", "Hand", "Thigh", "Calf", "Foot", "ToeBase")],
    "Unreal": [word("l", "r", f"{n}_*") for n in
        ("clavicle", "upperarm", "lowerarm", "hand", "thigh", "calf", "foot", "ball")],
    "SMPL": [word("L", "R", f"*_{n}") for n in
        ("Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Foot")],
    "wrists": [word("Left", "Right", f"*{n}") for n in
        ("Collar", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Toe")],
    "Xsens": [word("Left", "Right", f"*{n}") for n in
        ("Shoulder", "UpperArm", "ForeArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "Toe")],
    "Rokoko, Perception Neuron, LAFAN": [word("Left", "Right", f"*{n}") for n in
        ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "Toe")],
    "suffix _jnt": [word("L", "R", f"*_{n}_jnt") for n in
        ("shoulder", "upArm", "lowArm", "hand", "upLeg", "lowLeg", "foot", "toe")],
    "3ds Max Biped": [word("L", "R", f"Bip01 * {n}") for n in
        ("Clavicle", "UpperArm", "Forearm", "Hand", "Thigh", "Calf", "Foot", "Toe0")],
    "VRM": [word("L", "R", f"J_Bip_*_{n}") for n in
        ("Shoulder", "UpperArm", "LowerArm", "Hand", "UpperLeg", "LowerLeg", "Foot", "ToeBase")],
    "Rigify": [word("L", "R", f"DEF-{n}.*") for n in
        ("shoulder", "upper_arm", "forearm", "hand", "thigh", "shin", "foot", "toe")],
    "a performer's prefix": [word("Left", "Right", f"Anna_*{n}") for n in
        ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")],
    "Kinect": [word("Left", "Right", f"{n}*") for n in
        ("Clavicle", "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle", "Foot")],
    "MVN lower case": [word("left", "right", f"*_{n}") for n in
        ("collar", "shoulder", "elbow", "wrist", "hip", "knee", "ankle", "foot")],
}  # fmt: skip


@pytest.mark.parametrize("family", FAMILIES)
def test_the_ten_limb_chains_of_a_name_family(family):
    makers = FAMILIES[family]
    chains = find_chains(rig(limbs(*makers)).motion)
    shoulder, arm, forearm, _, thigh, shin, _, _ = makers
    expected = [
        (side, segment, make(side[0].lower()))
        for side in ("Left", "Right")
        for segment, make in zip(SEGMENTS, (shoulder, arm, forearm, thigh, shin), strict=True)
    ]
    assert [(c.side, c.segment, c.name) for c in chains] == expected


def test_the_hand_uses_its_own_z_axis(walk):
    chains = {c.name: c for c in find_chains(walk.motion)}
    np.testing.assert_array_equal(chains["LeftForeArm"].arm, [0.0, 0.0, 1.0])
    assert chains["LeftForeArm"].grandchild == -1


def test_a_hand_whose_z_is_the_bone_takes_the_axis_least_parallel():
    makers = FAMILIES["MotionBuilder"]
    along_z = {"LeftHand": (0, 0.1, 2), "RightHand": (0.1, 0, 2)}
    chains = {c.name: c for c in find_chains(rig(limbs(*makers), along_z).motion)}
    np.testing.assert_array_equal(chains["LeftForeArm"].arm, [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(chains["RightForeArm"].arm, [0.0, 1.0, 0.0])


def test_a_bone_without_length_is_no_chain():
    makers = FAMILIES["MotionBuilder"]
    chains = find_chains(rig(limbs(*makers), {"LeftLeg": (0, 0, 0)}).motion)
    assert "LeftUpLeg" not in {c.name for c in chains}
    assert len(chains) == 9


def test_unknown_names_are_found_by_topology():
    body = {"a": None, "b": "a", "c": "a"}
    for limb, root in (("d", "b"), ("e", "b"), ("f", "c"), ("g", "c")):
        above = root
        for k in range(4):
            body[f"{limb}{k}"] = above
            above = f"{limb}{k}"
    chains = find_chains(rig(body).motion)
    assert {c.name for c in chains} == {f"{limb}{k}" for limb in "defg" for k in (0, 1, 2)}


def test_a_skeleton_with_no_chain_is_no_error():
    assert find_chains(rig({"a": None, "b": "a"}).motion) == ()


def test_a_joint_without_three_rotation_channels_is_named():
    makers = FAMILIES["MotionBuilder"]
    clip = rig(limbs(*makers), channels={"LeftForeArm": 1})
    chains = {c.name: c for c in find_chains(clip.motion)}
    assert uncorrectable_joints(clip.motion, chains["LeftArm"]) == ("LeftForeArm",)
    assert uncorrectable_joints(clip.motion, chains["LeftForeArm"]) == ("LeftForeArm",)
    assert uncorrectable_joints(clip.motion, chains["RightArm"]) == ()


def makehuman():
    """MakeHuman splits arms and legs into two pieces each."""
    body = {"root": None, "spine01": "root"}
    for side in "LR":
        above = "spine01"
        for name in ("clavicle", "shoulder01", "upperarm01", "upperarm02", "lowerarm01",
                     "lowerarm02", "wrist", "finger1-1", "finger1-2", "finger1-3"):  # fmt: skip
            body[f"{name}.{side}"] = above
            above = f"{name}.{side}"
        above = "root"
        for name in ("pelvis", "upperleg01", "upperleg02", "lowerleg01", "lowerleg02", "foot",
                     "toe1-1"):  # fmt: skip
            body[f"{name}.{side}"] = above
            above = f"{name}.{side}"
    return body


def test_every_piece_of_a_bone_has_a_chain_with_the_joint_that_hangs_on_it():
    motion = rig(makehuman()).motion
    names = (*motion.skeleton.names, "-")
    left = [c for c in find_chains(motion) if c.side == "Left"]
    assert [(c.label, names[c.child], names[c.grandchild], c.pieces, c.ends) for c in left] == [
        ("Left Shoulder", "upperarm01.L", "upperarm02.L", 1, True),
        ("Left Arm · upperarm01.L", "upperarm02.L", "-", 2, False),
        ("Left Arm · upperarm02.L", "lowerarm01.L", "lowerarm02.L", 2, True),
        ("Left ForeArm · lowerarm01.L", "lowerarm02.L", "-", 2, False),
        ("Left ForeArm · lowerarm02.L", "wrist.L", "-", 2, True),
        ("Left UpLeg · upperleg01.L", "upperleg02.L", "-", 2, False),
        ("Left UpLeg · upperleg02.L", "lowerleg01.L", "lowerleg02.L", 2, True),
        ("Left Leg · lowerleg01.L", "lowerleg02.L", "-", 2, False),
        ("Left Leg · lowerleg02.L", "foot.L", "toe1-1.L", 2, True),
    ]
    assert all(motion.skeleton.parents[c.child] == c.parent for c in find_chains(motion))


def test_a_quadruped_with_unknown_names_has_its_four_legs():
    body = {"q0": None, "spineA": "q0", "spineB": "spineA", "neckA": "spineB", "headA": "neckA"}
    for leg, root in (("fa", "spineB"), ("fb", "spineB"), ("ha", "q0"), ("hb", "q0")):
        above = root
        for k in range(4):
            body[f"{leg}{k}x"] = above
            above = f"{leg}{k}x"
    names = {c.name for c in find_chains(rig(body).motion)}
    assert names >= {f"{leg}{k}x" for leg in ("fa", "fb", "ha", "hb") for k in (0, 1)}
    assert not names & {"q0", "spineA", "spineB"}


def test_a_face_has_no_limbs():
    face = {"head": None, "jaw": "head"}
    for line in ("tongue", "levator", "oris"):
        above = "jaw"
        for k in range(5):
            face[f"{line}0{k}"] = above
            above = f"{line}0{k}"
    assert find_chains(rig(face).motion) == ()


def test_fingers_are_no_limbs():
    makers = FAMILIES["MotionBuilder"]
    body = limbs(*makers)
    for finger in ("Thumb", "Index", "Middle"):
        above = "LeftHand"
        for k in range(1, 5):
            body[f"LeftHand{finger}{k}"] = above
            above = f"LeftHand{finger}{k}"
    chains = find_chains(rig(body).motion)
    assert len(chains) == 10
    assert not any("Hand" in c.name for c in chains)


@pytest.mark.parametrize("stray", ["0 0 0", "-0.000001 0 0.000001", "0.000183 0.000151 -0.000187"])
def test_positions_next_to_zero_are_no_bone(stray):
    """Blender's rigs write the shift from OFFSET into position channels, to six decimals."""
    turn, shift = "Xrotation Yrotation Zrotation", "Xposition Yposition Zposition"
    joints = {"LeftArm": "0 4 0", "LeftForeArm": "1.2 0 -1.3", "LeftHand": "0.6 -0.8 -0.6"}
    header = "".join(
        f"{'JOINT' if k else 'ROOT'} {name} {{ OFFSET {offset} CHANNELS 6 {shift} {turn}\n"
        for k, (name, offset) in enumerate(joints.items())
    )
    row = " ".join(f"{where} 0 0 0" for where in ("0 4 0", stray, stray))
    text = f"HIERARCHY\n{header}}} }} }}\nMOTION\nFrames: 2\nFrame Time: .01\n{row}\n{row}\n"
    chains = {c.name: c for c in find_chains(parse_bvh(text.encode()).motion)}
    assert set(chains) == {"LeftArm", "LeftForeArm"}
    for name, offset in (("LeftArm", (1.2, 0, -1.3)), ("LeftForeArm", (0.6, -0.8, -0.6))):
        np.testing.assert_allclose(chains[name].axis, offset / np.linalg.norm(offset))
        assert "OFFSET" in " ".join(chains[name].warnings)


def test_how_a_chain_is_told_and_cut():
    makers = FAMILIES["MotionBuilder"]
    chains = {c.name: c for c in find_chains(rig(limbs(*makers)).motion)}
    arm, forearm = chains["LeftArm"], chains["LeftForeArm"]
    assert (arm.label, arm.list_label) == ("Left Arm", "Left Arm")
    assert replace(arm, segment="").label == "LeftArm"
    assert repr(arm) == f"<Chain LeftArm: joints {arm.parent} → {arm.child} → {arm.grandchild}>"
    assert repr(forearm) == f"<Chain LeftForeArm: joints {forearm.parent} → {forearm.child}>"
    assert repr(replace(arm, parent=0)).startswith("<Chain LeftArm: joints 0 → ")
    varying = replace(arm, axis=np.arange(15.0).reshape(5, 3))
    part = varying.sliced(1, 3)
    np.testing.assert_array_equal(part.axis, varying.axis[1:3])
    np.testing.assert_array_equal(part.arm, arm.arm)
    part = replace(arm, arm=varying.axis).sliced(1, 3)
    np.testing.assert_array_equal(part.axis, arm.axis)
    np.testing.assert_array_equal(part.arm, varying.axis[1:3])


def test_a_foot_without_toes_points_where_its_end_site_does():
    def arm(end, segment="Leg"):
        skeleton = Skeleton(
            ("a", "b"), np.array([-1, 0]), np.array([[0.0, 9, 0], [0, -5, 0]]), ends=((1, end),)
        )
        motion = Motion(skeleton, np.ones((2, 2, 4)) / 2.0, (), np.zeros((2, 0, 3)), 0.1)
        chain = make_chain(motion, 0, 1, segment=segment)
        assert (chain.grandchild, chain.warnings) == (-1, ())
        np.testing.assert_allclose(chain.axis, [0.0, -1.0, 0.0])
        return chain.arm.tolist()

    assert arm((0.0, 0.0, -3.0)) == [0.0, 0.0, -1.0]
    assert arm((3.0, 0.0, 4.0)) == [0.6, 0.0, 0.8]
    assert arm((0.0, 0.0, 1e-7)) == [0.0, 0.0, 1.0]  # next to nothing
    assert arm((3.0, 0.0, 4.0), "ForeArm") == [0.0, 0.0, 1.0]  # a hand's own Z


def test_a_rig_of_few_limbs_has_the_chains_of_those():
    makers = FAMILIES["MotionBuilder"]
    whole = limbs(*makers)

    def segments(*gone):
        body = {n: p for n, p in whole.items() if not n.startswith(gone)}
        return [(c.side, c.segment) for c in find_chains(rig(body).motion)]

    arms = [("Left", s) for s in ("Shoulder", "Arm", "ForeArm")]
    legs = [(side, s) for side in ("Left", "Right") for s in ("UpLeg", "Leg")]
    right_arm = tuple(f"Right{n}" for n in ("Shoulder", "Arm", "ForeArm", "Hand"))
    both = (*right_arm, *(n.replace("Right", "Left") for n in right_arm))
    assert segments(*both) == legs
    assert [s for s in segments(*right_arm) if s[0] == "Left"][:3] == arms
    assert [s for s in segments(*right_arm) if s in legs] == legs
    lone = {"LeftShoulder": None, "LeftArm": "LeftShoulder", "LeftForeArm": "LeftArm"}
    chains = find_chains(rig({**lone, "LeftHand": "LeftForeArm"}).motion)
    assert [(c.name, c.side, c.segment) for c in chains] == [
        (f"Left{s}", "Left", s) for s in ("Shoulder", "Arm", "ForeArm")
    ]


def test_a_bone_that_is_moved_about_has_a_direction_a_frame_or_their_mean():
    def chain(spread):
        place = np.array([[0.0, -5, 0], [spread, -5, 0], [-spread, -5, 0]])
        skeleton = Skeleton(("a", "b", "c"), np.array([-1, 0, 1]), np.full((3, 3), 4.0))
        motion = Motion(skeleton, np.ones((3, 3, 4)) / 2.0, (1,), place[:, None], 0.1)
        return make_chain(motion, 0, 1, 2), place

    little, _ = chain(0.08)  # less than 1°
    np.testing.assert_allclose(little.axis, [0.0, -1.0, 0.0])
    assert little.warnings == ()
    much, place = chain(0.1)
    np.testing.assert_allclose(much.axis, place / np.linalg.norm(place, axis=1)[:, None])
    [warning] = much.warnings
    assert names_in_one_line(warning, "b: ", "1°")
    np.testing.assert_allclose(much.arm, np.full(3, 3**-0.5))
    skeleton = Skeleton(("a", "b"), np.array([-1, 0]), np.array([[0.0, 9, 0], [0, 0, 0]]))
    place = np.array([[[0.0, -5, 0]], [[0.0, 0, 0]]])  # no length in one frame
    motion = Motion(skeleton, np.ones((2, 2, 4)) / 2.0, (1,), place, 0.1)
    assert make_chain(motion, 0, 1) is None


# -- rigs that say where a limb begins and ends ----------------------------------------------------


def line(text, above=None):
    """{name: parent} of joints that hang from each other, the first from `above`."""
    out = {}
    for name in text.split():
        out[name] = above
        above = name
    return out


def both(text, above):
    """A line on either side; * stands for the side."""
    return {**line(text.replace("*", "Left"), above), **line(text.replace("*", "Right"), above)}


def told(parents, side="Left", **more):
    """'segment: parent child grandchild' of each chain of a side."""
    clip = rig(parents, **more)
    names = (*clip.motion.skeleton.names, "-")
    return [
        f"{c.segment}: {names[c.parent]} {names[c.child]} {names[c.grandchild]}"
        for c in find_chains(clip.motion)
        if c.side == side
    ]


ARM = "*Clavicle *UpperArm *LowerArm *Hand"


def test_a_joint_above_both_hands_is_no_shoulder():
    short = "*UpperArm *LowerArm *Hand"
    expected = ["Arm: LeftUpperArm LeftLowerArm LeftHand", "ForeArm: LeftLowerArm LeftHand -"]
    assert told({**line("hip chest"), **both(short, "chest")}) == expected
    assert told({**line("hip chest"), **both("*LowerArm *Hand", "chest")}) == expected[1:]
    assert told({"chest": None, **both(short, "chest")}) == expected
    clavicle = "Shoulder: LeftClavicle LeftUpperArm LeftLowerArm"
    assert told({**line("hip chest"), **both(ARM, "chest")}) == [clavicle, *expected]


def test_a_joint_above_both_feet_is_no_thigh():
    legs = both("*Shin *Foot *Toe", "hip")
    expected = ["Leg: LeftShin LeftFoot LeftToe"]
    assert told({"hip": None, **legs}) == expected
    assert told({"hip": None, **line("chest", "hip"), **both(ARM, "chest"), **legs})[3:] == expected
    assert told({**line("root hip"), **both("*Thigh *Shin *Foot *Toe", "hip")}) == [
        "UpLeg: LeftThigh LeftShin LeftFoot",
        *expected,
    ]


def test_of_one_hand_alone_nothing_tells_where_the_trunk_ends():
    arm = line("LeftUpperArm LeftLowerArm LeftHand", "chest")
    legs = both("*Thigh *Shin *Foot", "hip")
    body = {**line("hip chest"), **arm, **legs}
    assert told(body)[0] == "Shoulder: chest LeftUpperArm LeftLowerArm"
    assert told(body)[3:] == ["UpLeg: LeftThigh LeftShin LeftFoot", "Leg: LeftShin LeftFoot -"]
    assert [text[:5] for text in told(body, "Right")] == ["UpLeg", "Leg: "]
    arms = both("*UpperArm *LowerArm *Hand", "hip")
    one_leg = {"hip": None, **line("RightShin RightFoot", "hip"), **arms}
    assert told(one_leg, "Right")[2:] == ["Leg: RightShin RightFoot -"]


def test_arms_and_legs_that_end_early_have_fewer_chains():
    root = {"hip": None}
    assert told({**root, **both("*LowerArm *Hand *Finger1 *Finger2", "hip")}) == [
        "ForeArm: LeftLowerArm LeftHand -"
    ]
    assert told({**line("LeftShin LeftFoot"), **line("RightFoot", "LeftShin")}) == []
    assert told(line("LeftShin LeftFoot LeftToe")) == ["Leg: LeftShin LeftFoot LeftToe"]


def test_the_toe_is_the_nearest_of_the_foot_s_own_side():
    leg = "*Thigh *Shin *Foot"
    body = {"hip": None, **both(leg, "hip")}

    def toe(*below):
        extra = {}
        for text in below:
            extra |= line(text, "LeftFoot")
        return told({**body, **extra})[1].split()[-1]

    assert toe() == "-"
    assert toe("LeftHeel", "LeftInstep") == "-"
    assert toe("LeftToeA LeftToeB") == "LeftToeA"
    assert toe("LeftToeA", "LeftToeB") == "LeftToeA"
    assert toe("LeftHeel LeftToeTip", "LeftToeBase") == "LeftToeBase"
    assert toe("LeftBall LeftToe") == "LeftBall"
    assert toe("LeftHeel LeftInstep LeftForefoot") == "LeftForefoot"
    assert toe("RightToe", "LeftToe") == "LeftToe"
    assert toe("MidToe") == "-"


def test_the_hand_is_the_first_word_for_it_and_the_whole_word():
    arm = {"hip": None, **both(ARM, "hip")}
    handle = {"hip": None, **line("LeftHandle", "hip"), **both(ARM, "hip")}
    assert told(handle) == told(arm)
    wrist = {"hip": None, **both("*Clavicle *UpperArm *LowerArm *Wrist *Hand", "hip")}
    assert told(wrist)[2] == "ForeArm: LeftLowerArm LeftWrist -"
    ankle = {"hip": None, **both("*Thigh *Shin *Ankle *Foot *Toe", "hip")}
    assert told(ankle)[1] == "Leg: LeftShin LeftAnkle LeftFoot"
    twice = {"hip": None, **line("LeftXa LeftHand", "hip"), **line("LeftXo Left_Hand", "hip")}
    assert told(twice)[-1] == "ForeArm: LeftXa LeftHand -"


def test_a_bone_in_pieces_may_begin_at_the_root():
    """In a clip at rest a joint called as the one above, by another number, is a piece of it."""
    assert told(line("LeftArm01 LeftArm02 LeftLower LeftHand")) == [
        "Arm: LeftArm01 LeftArm02 -",
        "Arm: LeftArm02 LeftLower LeftHand",
        "ForeArm: LeftLower LeftHand -",
    ]
    assert told(line("LeftArm Left_Arm LeftLower LeftHand"))[0].startswith("Shoulder: LeftArm L")
    assert told(line("LeftArm RightArm2 LeftLower LeftHand"))[0].startswith("Shoulder: LeftArm R")
    three = told(line("LeftArm1 LeftArm2 LeftArm3 LeftLower LeftHand"))
    assert [text.split()[:2] for text in three[:3]] == [["Arm:", f"LeftArm{k}"] for k in (1, 2, 3)]
    assert told(line("LeftArm LeftArmTwist LeftLower LeftHand"))[1].startswith("Arm: LeftArmTwist")


# -- topology --------------------------------------------------------------------------------------


def found(parents, offsets=None):
    """'parent child grandchild' of each chain, of which the names say nothing."""
    clip = rig(parents, offsets)
    names = (*clip.motion.skeleton.names, "-")
    chains = find_chains(clip.motion)
    assert {(c.side, c.segment) for c in chains} <= {("", "")}
    return [" ".join(names[j] for j in (c.parent, c.child, c.grandchild)) for c in chains]


def test_a_lone_line_is_a_limb_below_its_root():
    assert found(line("r a b c")) == ["a b c", "b c -"]
    assert found(line("r a b c d")) == ["a b c", "b c d", "c d -"]
    assert found(line("r a b")) == []


def test_a_joint_that_two_lines_of_two_bones_leave_is_of_the_trunk_and_all_above_it():
    trunk = line("r s t")
    pairs = {**trunk, **line("a b c", "t"), **line("u v w", "t")}
    assert found(pairs) == ["a b c", "b c -", "u v w", "v w -"]
    one_short = {**trunk, **line("a b c", "t"), **line("u v", "t")}
    assert found(one_short) == ["s t a", "t a b", "a b c", "b c -"]
    three = {**trunk, **line("a b c", "t"), **line("u v w", "t"), **line("k l m", "r")}
    assert found(three) == ["a b c", "b c -", "u v w", "v w -", "k l m", "l m -"]


def test_a_chain_follows_the_longest_line_and_the_first_of_equals():
    stem = line("r a b")
    assert found({**stem, **line("c", "b"), **line("d", "b")}) == ["a b c", "b c -"]
    assert found({**stem, **line("c", "b"), **line("d e", "b")}) == ["a b d", "b d e", "d e -"]
    assert found({**stem, **line("d e", "b"), **line("c", "b")}) == ["a b d", "b d e", "d e -"]
    assert found({**stem, **line("c d", "b"), **line("e f", "a")}, {"f": (0, 0, 0)}) == [
        "a b c", "b c d", "c d -"
    ]  # fmt: skip


def test_what_hangs_beside_a_limb_is_none():
    """A twig whose last bone has no length makes no branching, and begins no chain."""
    twig = {**line("r a b c d"), **line("u v w", "a")}
    assert found(twig) == ["b c d", "c d -", "u v w", "v w -"]
    assert found(twig, {"w": (0, 0, 0)}) == ["a b c", "b c d", "c d -"]


def test_what_hangs_on_a_hand_or_on_something_carried_is_no_limb():
    body = {**line("r a b c"), **line("Weapon x y z", "r")}
    assert found(body) == ["a b c", "b c -"]
    assert found(line("Prop x y z")) == []
    assert found({**line("r a b Finger x y z")}) == []
