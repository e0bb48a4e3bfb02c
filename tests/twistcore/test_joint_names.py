"""What names of joints are understood as."""

import pytest

from tests.conftest import ASSETS
from tests.messages import refused
from tests.twistcore.name_families import FAMILIES
from twistcore.batch.clip_result import process_clip
from twistcore.batch.parameters import Parameters
from twistcore.errors import FormatError, TwistError
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.joint_names import (
    ROLES,
    changed_joint_name_meanings,
    default_vocabulary,
    interpret_names,
    read_joint_vocabulary_file,
    vocabulary_with_user_words,
)
from twistcore.skeleton.joint_vocabulary import parse_builtin_joint_names_file
from twistcore.skeleton.known_words_file import PLACE, joint_vocabulary_source_code

SIDES = ("Left", "Right")
HAND_TWIST = "左手捩"


def roles(*names):
    """The side and the likeliest role of each name, of one skeleton."""
    return [(joint.side, joint.roles[0] if joint.roles else "") for joint in interpret_names(names)]


def written_in(encoding, *names):
    """Names as a BVH of that encoding brings them."""
    return [name.encode(encoding).decode("utf-8", "surrogateescape") for name in names]


def test_there_are_sixty_families_each_with_its_source():
    assert len(FAMILIES) >= 60
    assert len({family.name for family in FAMILIES}) == len(FAMILIES)
    assert all(len(family.entry["source"]) > 10 for family in FAMILIES)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_the_roles_of_a_name_family(family):
    names = list(family.parents())
    found = dict(zip(names, interpret_names(names), strict=True))
    for side, label in enumerate(SIDES):
        for role, pieces in family.limb(side).items():
            first, *others = (found[name] for name in pieces)
            assert (first.side, first.other) == (label, False), pieces
            last = found[pieces[-1]]
            if role not in family.entry.get("from_hierarchy", ()):
                assert any(role in name.roles for name in (first, *others)), (pieces, first)
            assert not last.other
    limb = {name for side in (0, 1) for pieces in family.limb(side).values() for name in pieces}
    for name, parent in family.parents().items():
        joint = found[name]
        if name not in limb and parent is not None and not joint.helper:
            # SMPL's hand hangs on its wrist, toes on toes: the hierarchy decides.
            assert joint.roles[:1] in ((), ("hand",), ("toe",)), joint


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_the_chains_of_a_name_family(family):
    chains = find_chains(family.motion())
    assert [(c.side, c.segment, c.name) for c in chains if c.ends] == family.chains()
    assert len(family.chains()) == 10 - 2 * len(family.entry.get("lacks", {}))


# -- words of a name -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    ["LeftHand", "left_hand", "L_Hand", "hand.L", "Hand_Left", "lHand", "lefthand", "lhand",
     "handleft", "LEFT HAND", "LHand", "A:LeftHand", "|rig|body|LeftHand", "rig:A:hand_l",
     "h_L_Hand_hi", "L_hand_jnt", "Ｌｅｆｔ＿Ｈａｎｄ", "Left\u200fHand", "LeftHand_anim",
     "NPC L Hand [LHnd]", "Hand(L)", "lft-hand", "DEF-hand.L", "LeftHandRot"],
)  # fmt: skip
def test_ways_to_write_a_left_hand(name):
    (joint,) = interpret_names([name])
    assert (joint.side, joint.roles, joint.other, joint.helper) == ("Left", ("hand",), False, False)


def test_numbers_are_kept_apart_from_the_word():
    joints = interpret_names(["arm_L0_0_jnt", "arm_L0_1_jnt", "Arm.L", "Arm.L.001", "Bone_L_Arm02"])
    assert [j.number for j in joints] == ["00", "01", "", "001", "02"]
    assert {j.stem for j in joints} == {"arm"}
    assert [j.number for j in interpret_names(["Bip01 L Toe0", "Bip01 L Foot"])] == ["0", ""]


def test_a_rig_of_its_own_name_is_no_word_of_the_joint():
    assert roles("Anna_LeftArm", "Anna_LeftHand", "Anna_Hips") == [
        ("Left", "arm"), ("Left", "hand"), ("", ""),
    ]  # fmt: skip
    assert roles("LeftArm_Anna", "LeftHand_Anna", "Hips_Anna")[:2] == [
        ("Left", "arm"), ("Left", "hand"),
    ]  # fmt: skip


def test_vertebrae_are_on_no_side():
    assert {joint.side for joint in interpret_names(["L5", "L3", "T12", "R1", "Left"])} == {""}


def test_sides_by_letters_only_where_names_are_mirrored():
    french = ["Cuisse_G", "Jambe_G", "Pied_G", "Bras_G", "AvantBras_G", "Main_G"]
    mirrored = [name.replace("_G", "_D") for name in french]
    assert {side for side, _ in roles(*french, *mirrored)[:6]} == {"Left"}
    assert {side for side, _ in roles(*french, *mirrored)[6:]} == {"Right"}
    assert {side for side, _ in roles(*french)} == {""}
    assert roles("thigh_g", "thigh_d") == [("", "upleg"), ("", "upleg")]


def test_a_language_counts_for_a_skeleton_that_is_named_in_it():
    assert roles("Left_Main") == [("", "")]  # French: hand
    assert roles("LeftPie", "LeftHand") == [("Left", ""), ("Left", "hand")]  # Spanish: foot


@pytest.mark.parametrize(
    ("encoding", "names"),
    [
        ("cp932", ("左肩", "左ひじ", "左手首")),
        ("latin-1", ("Hüfte_L", "Fuß_L", "Hand_L")),
        ("gb18030", ("左肩", "左前臂", "左手")),
        ("cp949", ("왼쪽어깨", "왼쪽팔꿈치", "왼쪽손목")),
        ("cp1251", ("левая_кисть", "левая_голень", "левая_стопа")),
    ],
)
def test_names_in_other_encodings(encoding, names):
    assert roles(*written_in(encoding, *names)) == roles(*names)
    assert all(side == "Left" and role for side, role in roles(*names))


def test_bytes_of_no_encoding_are_no_error():
    (joint,) = interpret_names(["\udcff\udcfe_L"])
    assert joint.roles == ()


# -- what words mean -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    ["upperarm_twist_01_l", "LeftForeArmRoll", "LeftUpperArm_tw", "ShoulderPart1_L", "CalfTwist",
     "CC_Base_L_ElbowShareBone", "LeftForeArmTwist", "lForearmTwist", HAND_TWIST, "lowerarmtwist"],
)  # fmt: skip
def test_helpers(name):
    assert interpret_names([name])[0].helper


@pytest.mark.parametrize("name", ["Controller", "LeftForeArm", "lForearmBend", "左手", "scroll_L"])
def test_no_helpers(name):
    assert not interpret_names([name])[0].helper


def test_a_twist_bone_says_in_which_bone_it_lies():
    assert [j.roles for j in interpret_names(["L_Forearm_Twist", HAND_TWIST])] == [("forearm",)] * 2


@pytest.mark.parametrize(
    "name",
    ["Head", "LeftHandThumb1", "LeftInHandIndex", "lCarpal1", "DEF-f_index.01.L", "prop_hand_r",
     "左親指１", "LeftEye", "skirt_01", "Bip01 L Finger01", "levator02.L", "RightHandPinky3_end"],
)  # fmt: skip
def test_no_part_of_a_limb(name):
    (joint,) = interpret_names([name])
    assert (joint.other, joint.roles) == (True, ())


def test_toes_are_no_fingers():
    assert {role for _, role in roles("L_MidToe1", "lBigToe", "LeftPinkyToe")} == {"toe"}


def test_a_word_for_two_bones_takes_what_no_other_word_says():
    assert roles("L_Collar", "L_Shoulder", "L_Elbow")[1] == ("Left", "arm")
    assert roles("L_Shoulder", "L_UpperArm", "L_Elbow")[0] == ("Left", "shoulder")
    assert roles("L_Ankle", "L_Foot")[1] == ("Left", "toe")
    assert roles("L_Foot", "L_Toe")[0] == ("Left", "foot")
    assert roles("Left leg", "Left knee")[0] == ("Left", "upleg")
    assert roles("L_Clavicle", "L_Shoulder", "L_Arm")[2] == ("Left", "forearm")


def test_a_target_is_no_joint_next_to_the_joint():
    found = roles("hand_l", "ik_hand_l", "ik_hand_root")
    assert found == [("Left", "hand"), ("Left", ""), ("", "")]
    assert interpret_names(["hand_l", "ik_hand_l"])[1].other
    assert roles("ik_hand_l") == [("Left", "hand")]  # where there is nothing else


def test_the_hips_are_no_thigh():
    assert [j.trunk for j in interpret_names(["Hips", "hip", "pelvis_L"])] == [True] * 3
    assert roles("LeftHip", "LeftKnee")[0] == ("Left", "upleg")
    assert roles("LHipJoint", "LeftUpLeg") == [("Left", ""), ("Left", "upleg")]


def test_words_of_the_program_are_known_by_one_name():
    """A word in two lists of a language that exclude each other would be a slip."""
    vocabulary = default_vocabulary()
    for words in (vocabulary.words, *(language.words for language in vocabulary.languages)):
        for word, meaning in words.items():
            assert not (meaning.side and (meaning.roles or meaning.marks)), word
            assert not ("other" in meaning.marks and meaning.roles), word
            assert set(meaning.roles) <= set(ROLES)


def test_the_words_that_are_loaded_are_those_of_the_table():
    """After a change of the table: python -m twistcore.skeleton.known_words_file."""
    assert PLACE.read_text("utf-8") == joint_vocabulary_source_code()
    loaded, read = default_vocabulary(), parse_builtin_joint_names_file()
    assert contents(loaded) == contents(read)
    assert [*map(contents, loaded.languages)] == [*map(contents, read.languages)]


def contents(vocabulary):
    return list(vocabulary.words.items()), vocabulary.pairs, vocabulary.joints


# -- a person's own words --------------------------------------------------------------------------


@pytest.fixture
def own(tmp_path):
    def written(text):
        path = tmp_path / "names.toml"
        path.write_text(text, "utf-8")
        return vocabulary_with_user_words(read_joint_vocabulary_file(path))

    return written


def test_own_words_are_added(own):
    names = ["LeftPfote", "Pfote_R", "LeftHand"]
    vocabulary = own('[mine]\nhand = ["Pfote"]\n')
    assert [j.roles for j in interpret_names(names)] == [(), (), ("hand",)]
    assert [j.roles for j in interpret_names(names, vocabulary)] == [("hand",)] * 3
    assert changed_joint_name_meanings(names, vocabulary) == {
        "LeftPfote": "left hand",
        "Pfote_R": "right hand",
    }


def test_own_words_go_before_those_of_the_program(own):
    vocabulary = own('[mine]\nother = ["hand"]\nhelper = ["slide"]\n')
    joints = interpret_names(["L_Hand", "L_Arm_slide"], vocabulary)
    assert [(j.other, j.helper) for j in joints] == [(True, False), (False, True)]


def test_a_whole_name_may_be_given_as_a_word(own):
    vocabulary = own('[mine]\nhand = ["LeftPfote"]\n')
    joints = interpret_names(["LeftPfote", "RightPfote"], vocabulary)
    assert [(j.side, j.roles) for j in joints] == [("Left", ("hand",)), ("Right", ("hand",))]


def test_single_joints_may_be_named(own):
    vocabulary = own('[joints]\nBone07 = "left hand"\nLeftHand = "other"\n')
    bone, hand = interpret_names(["Bone07", "LeftHand"], vocabulary)
    assert (bone.side, bone.roles, hand.other) == ("Left", ("hand",), True)


@pytest.mark.parametrize(
    ("text", "facts"),
    [
        ('[mine]\nhand = ["a"]\nhands = ["b"]\n', ("line 3", "left, right")),
        ('[mine]\n\nhand = "a"\n', ("line 3", "hand")),
        ('[a]\nhand = ["x"]\n[b]\nhand = [1]\n', ("line 4", "hand")),
        ('[mine.either]\nhand = ["hand", "foot", "nose"]\n', ("line 2", "shoulder, arm")),
        ('[mine]\npairs = [["g"]]\n', ("line 2", "pairs")),
        ('[mine]\nhand = ["--"]\n', ("line 2",)),
        ('hand = ["a"]\n', ("line 1", "hand")),
        ('[joints]\nA = "left nose"\n', ("line 2", "left")),
        ("[mine\n", ("line 1",)),
    ],
)
def test_a_damaged_file_is_reported_with_its_line(own, text, facts):
    with refused(FormatError, "names.toml: ", *facts):
        own(text)


def test_a_file_that_is_not_there(tmp_path):
    with refused(TwistError, "none.toml"):
        read_joint_vocabulary_file(tmp_path / "none.toml")


def test_own_words_count_in_a_batch():
    words = {"ours": {"other": ["hand", "forearm"]}}
    usual, own = Parameters(), Parameters(joint_names=words)
    assert usual.mark != own.mark
    tau = [process_clip(ASSETS / "walk.bvh", p)[1]["tau_deg"] for p in (usual, own)]
    assert "LeftForeArm" in tau[0]
    assert "LeftForeArm" not in tau[1]
    assert "LeftLeg" in tau[1]
