"""Define the rigs for `benchmarks.rigs`, with names and hierarchies of public rigs.

The positions of pieces and helpers along a bone, and their shares of the roll, are our choice,
because no two exported files agree on them.
"""

from __future__ import annotations

from benchmarks._rigs import TRUNK, Helper, Rig

SIBLINGS, IN_CHAIN, THREE = "twist bones next to the chain", "in the chain", "three pieces"
BELOW_HAND, STRANGERS = "helpers below the hand", "read from public sources, never tuned on"

_LONG = ("Left", "Right")
_SMALL = ("l", "r")

_UNREAL_LIMBS = (
    "clavicle_{s}",
    "upperarm_{s}",
    "lowerarm_{s}",
    "hand_{s}",
    "thigh_{s}",
    "calf_{s}",
    "foot_{s}",
    "ball_{s}",
)
_UNREAL_TRUNK = ("pelvis", "spine_01", "spine_02", "spine_03", "neck_01", "neck_02", "head")
_UNREAL_TWISTS = (
    Helper("upperarm_twist_01_{s}", "upperarm_{s}", "Arm", undo=1.0),
    Helper("upperarm_twist_02_{s}", "upperarm_{s}", "Arm", 0.5, undo=0.5),
    Helper("lowerarm_twist_02_{s}", "lowerarm_{s}", "ForeArm", 0.4, follow=0.3),
    Helper("lowerarm_twist_01_{s}", "lowerarm_{s}", "ForeArm", 0.8, follow=0.6),
    Helper("thigh_twist_01_{s}", "thigh_{s}", "UpLeg", 0.3, undo=0.5),
    Helper("calf_twist_01_{s}", "calf_{s}", "Leg", 0.7, follow=0.5),
)
_CC4 = "CC_Base_{s}_"
_MOTIONBUILDER_TRUNK = ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Neck1", "Head")
_MOTIONBUILDER_LIMBS = tuple("{s}" + role for role in ("Shoulder", "Arm", "ForeArm", "Hand"))
_MOTIONBUILDER_LIMBS += tuple("{s}" + role for role in ("UpLeg", "Leg", "Foot", "ToeBase"))
_ROLLS = tuple(
    Helper("Leaf{s}" + f"{role}Roll1", "{s}" + role, role, 0.5, undo=undo, follow=follow)
    for role, undo, follow in (
        ("Arm", 0.5, 0.0),
        ("ForeArm", 0.0, 0.5),
        ("UpLeg", 0.5, 0.0),
        ("Leg", 0.0, 0.5),
    )
)

_WITHOUT = (
    Rig("CMU", SIBLINGS, TRUNK, _MOTIONBUILDER_LIMBS, _LONG, as_is=True),
    Rig("Unreal 5", SIBLINGS, _UNREAL_TRUNK, _UNREAL_LIMBS, _SMALL, _UNREAL_TWISTS),
    Rig(
        "MetaHuman",
        SIBLINGS,
        _UNREAL_TRUNK,
        _UNREAL_LIMBS,
        _SMALL,
        (
            Helper("clavicle_out_{s}", "clavicle_{s}", "Shoulder", 0.9, 0.1),
            Helper("clavicle_scap_{s}", "clavicle_{s}", "Shoulder", 0.5, -0.3),
            *_UNREAL_TWISTS,
            Helper("upperarm_correctiveRoot_{s}", "upperarm_{s}", "Arm"),
            Helper("upperarm_bck_{s}", "upperarm_correctiveRoot_{s}", "Arm", 0.2, -0.1),
            Helper("upperarm_fwd_{s}", "upperarm_correctiveRoot_{s}", "Arm", 0.2, 0.1),
            Helper("lowerarm_correctiveRoot_{s}", "lowerarm_{s}", "ForeArm", undo=0.5),
            Helper("lowerarm_in_{s}", "lowerarm_correctiveRoot_{s}", "ForeArm", 0.1, 0.1),
            Helper("lowerarm_out_{s}", "lowerarm_correctiveRoot_{s}", "ForeArm", 0.1, -0.1),
            Helper("wrist_inner_{s}", "hand_{s}", "Hand", 0.2, 0.4),
            Helper("wrist_outer_{s}", "hand_{s}", "Hand", 0.2, -0.4),
            Helper("index_metacarpal_{s}", "hand_{s}", "Hand", 0.4, 0.3),
            Helper("index_01_{s}", "index_metacarpal_{s}", "Hand", 0.6),
        ),
    ),
    Rig(
        "Character Creator 4",
        SIBLINGS,
        (
            "CC_Base_Hip",
            "CC_Base_Waist",
            "CC_Base_Spine01",
            "CC_Base_Spine02",
            "CC_Base_NeckTwist01",
            "CC_Base_NeckTwist02",
            "CC_Base_Head",
        ),
        tuple(
            _CC4 + name
            for name in (
                "Clavicle",
                "Upperarm",
                "Forearm",
                "Hand",
                "Thigh",
                "Calf",
                "Foot",
                "ToeBase",
            )
        ),
        helpers=(
            Helper(_CC4 + "UpperarmTwist01", _CC4 + "Upperarm", "Arm", undo=0.7),
            Helper(_CC4 + "UpperarmTwist02", _CC4 + "UpperarmTwist01", "Arm", 0.5, undo=-0.4),
            Helper(_CC4 + "ForearmTwist01", _CC4 + "Forearm", "ForeArm", follow=0.2),
            Helper(_CC4 + "ForearmTwist02", _CC4 + "ForearmTwist01", "ForeArm", 0.5, follow=0.4),
            Helper(_CC4 + "ElbowShareBone", _CC4 + "Forearm", "ForeArm", undo=0.3),
            Helper(_CC4 + "ThighTwist01", _CC4 + "Thigh", "UpLeg", undo=0.7),
            Helper(_CC4 + "ThighTwist02", _CC4 + "ThighTwist01", "UpLeg", 0.5, undo=-0.4),
            Helper(_CC4 + "CalfTwist01", _CC4 + "Calf", "Leg", follow=0.2),
            Helper(_CC4 + "KneeShareBone", _CC4 + "Calf", "Leg", undo=0.3),
        ),
        pelvis="CC_Base_Pelvis",
    ),
    Rig("HumanIK", SIBLINGS, _MOTIONBUILDER_TRUNK, _MOTIONBUILDER_LIMBS, _LONG, _ROLLS),
    Rig(
        "Biped",
        SIBLINGS,
        tuple(
            "Bip01 " + name
            for name in ("Pelvis", "Spine", "Spine1", "Spine2", "Neck", "Neck1", "Head")
        ),
        tuple(
            "Bip01 {s} " + name
            for name in (
                "Clavicle",
                "UpperArm",
                "Forearm",
                "Hand",
                "Thigh",
                "Calf",
                "Foot",
                "Toe0",
            )
        ),
        helpers=(
            Helper("Bip01 {s}UpArmTwist", "Bip01 {s} UpperArm", "Arm", undo=0.8),
            Helper("Bip01 {s} ForeTwist", "Bip01 {s} Forearm", "ForeArm", 0.3, follow=0.3),
            Helper("Bip01 {s} ForeTwist1", "Bip01 {s} Forearm", "ForeArm", 0.7, follow=0.7),
            Helper("Bip01 {s}ThighTwist", "Bip01 {s} Thigh", "UpLeg", undo=0.8),
            Helper("Bip01 {s}CalfTwist", "Bip01 {s} Calf", "Leg", 0.5, follow=0.5),
        ),
    ),
    Rig(
        "Auto-Rig Pro",
        SIBLINGS,
        ("root.x", "spine_01.x", "spine_02.x", "spine_03.x", "neck.x", "subneck_1.x", "head.x"),
        (
            "shoulder.{s}",
            "arm_stretch.{s}",
            "forearm_stretch.{s}",
            "hand.{s}",
            "thigh_stretch.{s}",
            "leg_stretch.{s}",
            "foot.{s}",
            "toes_01.{s}",
        ),
        _SMALL,
        (
            Helper("arm_twist.{s}", "arm_stretch.{s}", "Arm", undo=1.0),
            Helper("forearm_twist.{s}", "forearm_stretch.{s}", "ForeArm", 0.5, follow=1.0),
            Helper("thigh_twist.{s}", "thigh_stretch.{s}", "UpLeg", undo=1.0),
            Helper("leg_twist.{s}", "leg_stretch.{s}", "Leg", 0.5, follow=1.0),
        ),
    ),
)

_GENESIS = Rig(
    "Daz Genesis 3/8",
    IN_CHAIN,
    ("hip", "abdomenLower", "abdomenUpper", "chestUpper", "neckLower", "neckUpper", "head"),
    (
        "{s}Collar",
        ("{s}ShldrBend", "{s}ShldrTwist"),
        ("{s}ForearmBend", "{s}ForearmTwist"),
        "{s}Hand",
        ("{s}ThighBend", "{s}ThighTwist"),
        "{s}Shin",
        ("{s}Foot", "{s}Metatarsals"),
        "{s}Toe",
    ),
    _SMALL,
    pelvis="pelvis",
)
_RIGIFY_TRUNK = ("DEF-spine", *(f"DEF-spine.00{k}" for k in range(1, 7)))
_MAYA_TRUNK = ("Root_M", "Spine1_M", "Spine2_M", "Chest_M", "Neck_M", "NeckPart1_M", "Head_M")
_RIGIFY_LIMBS = ("upper_arm", "forearm", "thigh", "shin")
_MAYA_LIMBS = ("Shoulder", "Elbow", "Hip", "Knee")


def _rigify(pieces: int) -> tuple[str | tuple[str, ...], ...]:
    arm, forearm, thigh, shin = (
        tuple(f"DEF-{name}.{{s}}" + (f".00{k}" if k else "") for k in range(pieces))
        for name in _RIGIFY_LIMBS
    )
    hand, foot, toe = (f"DEF-{name}.{{s}}" for name in ("hand", "foot", "toe"))
    return "DEF-shoulder.{s}", arm, forearm, hand, thigh, shin, foot, toe


def _maya(pieces: int) -> tuple[str | tuple[str, ...], ...]:
    arm, forearm, thigh, shin = (
        tuple(name + (f"Part{k}" if k else "") + "_{s}" for k in range(pieces))
        for name in _MAYA_LIMBS
    )
    return "Scapula_{s}", arm, forearm, "Wrist_{s}", thigh, shin, "Ankle_{s}", "Toes_{s}"


_CHAINED = (
    _GENESIS,
    Rig(
        "MakeHuman",
        IN_CHAIN,
        ("root", "spine05", "spine04", "spine03", "neck01", "neck02", "head"),
        (
            ("clavicle.{s}", "shoulder01.{s}"),
            ("upperarm01.{s}", "upperarm02.{s}"),
            ("lowerarm01.{s}", "lowerarm02.{s}"),
            "wrist.{s}",
            ("upperleg01.{s}", "upperleg02.{s}"),
            ("lowerleg01.{s}", "lowerleg02.{s}"),
            "foot.{s}",
            "toe1-1.{s}",
        ),
    ),
    Rig("Rigify DEF", IN_CHAIN, _RIGIFY_TRUNK, _rigify(2)),
    Rig(
        "MMD",
        IN_CHAIN,
        ("センター", "下半身", "上半身", "上半身2", "首", "首1", "頭"),
        (
            "{s}肩",
            ("{s}腕", "{s}腕捩"),
            ("{s}ひじ", "{s}手捩"),
            "{s}手首",
            "{s}足",
            "{s}ひざ",
            "{s}足首",
            "{s}つま先",
        ),
        ("左", "右"),
    ),
    Rig(
        "Qualisys",
        IN_CHAIN,
        _MOTIONBUILDER_TRUNK,
        (
            *_MOTIONBUILDER_LIMBS[:2],
            ("{s}ForeArm", "{s}ForeArmRoll"),
            *_MOTIONBUILDER_LIMBS[3:],
        ),
        _LONG,
    ),
    Rig("Maya Advanced Skeleton", IN_CHAIN, _MAYA_TRUNK, _maya(2)),
    Rig(
        "Unity _tw",
        IN_CHAIN,
        ("hips", "spine", "chest", "upperchest", "neck", "neck2", "head"),
        (
            "{s}Shoulder",
            ("{s}UpperArm", "{s}UpperArm_tw"),
            ("{s}LowerArm", "{s}LowerArm_tw"),
            "{s}Hand",
            "{s}UpperLeg",
            "{s}LowerLeg",
            "{s}Foot",
            "{s}Toes",
        ),
        _LONG,
    ),
)

_IN_THREE = (
    Rig("Rigify, three segments", THREE, _RIGIFY_TRUNK, _rigify(3)),
    Rig("Maya, three parts", THREE, _MAYA_TRUNK, _maya(3)),
)


def _fingers(hand: str, *fingers: str, marks: str = "12") -> tuple[Helper, ...]:
    """Return two joints for each finger. The '#' in a name is replaced by one of the `marks`."""
    across = [0.5 - k / max(len(fingers) - 1, 1) for k in range(len(fingers))]
    found = []
    for finger, aside in zip(fingers, across, strict=True):
        first, second = (finger.replace("#", mark) for mark in marks)
        found += [Helper(first, hand, "Hand", 0.8, aside), Helper(second, first, "Hand", 0.5)]
    return tuple(found)


_HELPED = (
    Rig(
        "HumanIK with fingers and props",
        BELOW_HAND,
        _MOTIONBUILDER_TRUNK,
        _MOTIONBUILDER_LIMBS,
        _LONG,
        (
            *_ROLLS,
            Helper("{s}HandProp", "{s}Hand", "Hand", 0.5, 0.5),
            Helper("{s}HandRoll", "{s}Hand", "Hand", 0.1),
            *_fingers("{s}Hand", "{s}HandThumb#", "{s}HandIndex#", "{s}HandMiddle#"),
        ),
    ),
    Rig(
        "Unreal 5 with IK bones and weapons",
        BELOW_HAND,
        _UNREAL_TRUNK,
        _UNREAL_LIMBS,
        _SMALL,
        (
            Helper("ik_hand_root", "pelvis", "Hips"),
            Helper("ik_hand_{s}", "ik_hand_root", "Hips", 1.0, 0.5),
            Helper("ik_foot_root", "pelvis", "Hips"),
            Helper("ik_foot_{s}", "ik_foot_root", "Hips", -1.0, 0.5),
            *_UNREAL_TWISTS,
            Helper("hand_twist_{s}", "hand_{s}", "Hand", 0.1),
            Helper("weapon_{s}", "hand_{s}", "Hand", 0.5, 0.5),
            Helper("hand_{s}_socket", "hand_{s}", "Hand", 0.5, -0.5),
            *_fingers("hand_{s}", "thumb_0#_{s}", "index_0#_{s}", "middle_0#_{s}", "pinky_0#_{s}"),
        ),
    ),
    Rig(
        "Daz Genesis 3/8 with fingers and props",
        BELOW_HAND,
        _GENESIS.trunk,
        _GENESIS.limbs,
        _SMALL,
        (
            Helper("{s}Carpal1", "{s}Hand", "Hand", 0.3, 0.3),
            *_fingers("{s}Carpal1", "{s}Index#"),
            Helper("{s}Carpal2", "{s}Hand", "Hand", 0.3, -0.3),
            *_fingers("{s}Carpal2", "{s}Mid#"),
            *_fingers("{s}Hand", "{s}Thumb#"),
            Helper("{s}HandGrip", "{s}Hand", "Hand", 0.5, 0.5),
        ),
        pelvis="pelvis",
    ),
)

_BIP = "ValveBiped.Bip01_"
_CAT = "CATRig"
_READ = (
    Rig(
        "Fallout 4",
        STRANGERS,
        ("COM", "SPINE1", "SPINE2", "Chest", "Neck", "HEAD"),
        (
            "{s}Arm_Collarbone",
            "{s}Arm_UpperArm",
            ("{s}Arm_ForeArm1", "{s}Arm_ForeArm2", "{s}Arm_ForeArm3"),
            "{s}Arm_Hand",
            "{s}Leg_Thigh",
            "{s}Leg_Calf",
            "{s}Leg_Foot",
            "{s}Leg_Toe1",
        ),
        helpers=(
            Helper("{s}Arm_Collarbone_skin", "{s}Arm_Collarbone", "Shoulder"),
            Helper("{s}Arm_UpperTwist1", "{s}Arm_UpperArm", "Arm", 0.3, undo=0.5),
            Helper("{s}Arm_UpperTwist2", "{s}Arm_UpperTwist1", "Arm", 0.3, undo=0.3),
            Helper("{s}Arm_UpperFat_skin", "{s}Arm_UpperTwist2", "Arm", 0.1, 0.1),
            Helper("{s}Arm_ForeArm1_skin", "{s}Arm_ForeArm1", "ForeArm"),
            Helper("{s}Arm_ForeArm3_skin", "{s}Arm_ForeArm3", "ForeArm"),
            *_fingers("{s}Arm_Hand", *(f"{{s}}Arm_Finger{k}#" for k in range(1, 6))),
            Helper("AnimObject{s}1", "{s}Arm_Hand", "Hand", 0.5, 0.2),
            Helper("{s}Leg_Thigh_skin", "{s}Leg_Thigh", "UpLeg", 0.2),
            Helper("{s}Leg_Thigh_Low_skin", "{s}Leg_Thigh", "UpLeg", 0.6),
            Helper("{s}Leg_Calf_skin", "{s}Leg_Calf", "Leg", 0.2),
            Helper("{s}Leg_Calf_Low_skin", "{s}Leg_Calf", "Leg", 0.6),
        ),
        pelvis="Pelvis",
        source="BadDogSkyrim/PyNifly, PyNifly/niflytools.py, its bones of FO4 with their parents",
    ),
    Rig(
        "Final Fantasy XIV",
        STRANGERS,
        ("j_kosi", "j_sebo_a", "j_sebo_b", "j_sebo_c", "j_kubi", "j_kao"),
        (
            "j_sako_{s}",
            "j_ude_a_{s}",
            ("j_ude_b_{s}", "n_hte_{s}"),
            "j_te_{s}",
            "j_asi_a_{s}",
            ("j_asi_b_{s}", "j_asi_c_{s}"),
            "j_asi_d_{s}",
            "j_asi_e_{s}",
        ),
        _SMALL,
        (
            Helper("n_hkata_{s}", "j_ude_a_{s}", "Arm", undo=0.5),
            Helper("n_hhiji_{s}", "j_ude_b_{s}", "ForeArm", follow=0.3),
            Helper("n_buki_tate_{s}", "n_hte_{s}", "ForeArm", 0.2, 0.2),
            Helper("n_buki_{s}", "j_te_{s}", "Hand", 0.5, 0.5),
            *_fingers("j_te_{s}", "j_oya_#_{s}", "j_hito_#_{s}", "j_naka_#_{s}", marks="ab"),
            Helper("n_hizasoubi_{s}", "j_asi_b_{s}", "Leg", 0.0, 0.1),
            Helper("j_sk_f_a_{s}", "j_kosi", "Hips", -0.5, 0.4),
            Helper("j_sk_f_b_{s}", "j_sk_f_a_{s}", "Hips", -0.8),
            Helper("j_sk_f_c_{s}", "j_sk_f_b_{s}", "Hips", -0.8),
        ),
        source="Aether-Tools/CustomizePlus, CustomizePlus/Core/Data/BoneData.cs",
    ),
    Rig(
        "Source engine (ValveBiped)",
        STRANGERS,
        tuple(_BIP + name for name in ("Pelvis", "Spine", "Spine2", "Spine4", "Neck1", "Head1")),
        tuple(
            _BIP + "{s}_" + name
            for name in (
                "Clavicle",
                "UpperArm",
                "Forearm",
                "Hand",
                "Thigh",
                "Calf",
                "Foot",
                "Toe0",
            )
        ),
        helpers=(
            Helper(_BIP + "{s}_Trapezius", _BIP + "{s}_Clavicle", "Shoulder", 0.9, undo=0.5),
            Helper(_BIP + "{s}_Shoulder", _BIP + "{s}_UpperArm", "Arm", 0.13, undo=0.7),
            Helper(_BIP + "{s}_Bicep", _BIP + "{s}_UpperArm", "Arm", 0.5, 0.08, undo=0.4),
            Helper(_BIP + "{s}_Elbow", _BIP + "{s}_UpperArm", "Arm", 1.0, bend=0.5),
            Helper(_BIP + "{s}_Ulna", _BIP + "{s}_Forearm", "ForeArm", 0.5, follow=0.5),
            Helper(_BIP + "{s}_Wrist", _BIP + "{s}_Forearm", "ForeArm", 1.0, follow=1.0),
            *_fingers(_BIP + "{s}_Hand", *(_BIP + f"{{s}}_Finger{k}#" for k in range(3))),
        ),
        source="GMod PM Proportion Tool, its $definebone lines of Half-Life 2's female skeleton",
    ),
    Rig(
        "Second Life Bento",
        STRANGERS,
        ("mPelvis", "mSpine1", "mTorso", "mChest", "mNeck", "mHead"),
        tuple(
            f"m{name}{{s}}"
            for name in (
                "Collar",
                "Shoulder",
                "Elbow",
                "Wrist",
                "Hip",
                "Knee",
                "Ankle",
                "Foot",
            )
        ),
        _LONG,
        (
            Helper("{s[0]}_CLAVICLE", "mCollar{s}", "Shoulder", 0.3, 0.1),
            Helper("{s[0]}_UPPER_ARM", "mShoulder{s}", "Arm", 0.45, 0.05),
            Helper("{s[0]}_LOWER_ARM", "mElbow{s}", "ForeArm", 0.45),
            Helper("{s[0]}_HAND", "mWrist{s}", "Hand", 0.5, 0.1),
            *_fingers("mWrist{s}", "mHandThumb#{s}", "mHandIndex#{s}", "mHandMiddle#{s}"),
            Helper("{s[0]}_UPPER_LEG", "mHip{s}", "UpLeg", 0.4, -0.05),
            Helper("{s[0]}_LOWER_LEG", "mKnee{s}", "Leg", 0.4, -0.05),
            Helper("{s[0]}_FOOT", "mAnkle{s}", "Foot", 0.6),
        ),
        source="secondlife/viewer, indra/newview/character/avatar_skeleton.xml",
    ),
    Rig(
        "3ds Max CAT",
        STRANGERS,
        tuple(_CAT + name for name in ("Hub001", "Spine1", "Spine2", "Hub002", "Spine", "Head")),
        tuple(
            _CAT + "{s}" + name
            for name in (
                "ArmCollarbone",
                "Arm1",
                "Arm2",
                "ArmPalm",
                "Leg1",
                "Leg2",
                "LegAnkle",
                "LegDigit11",
            )
        ),
        helpers=_fingers(_CAT + "{s}ArmPalm", *(_CAT + f"{{s}}ArmDigit{k}#" for k in range(1, 4))),
        source="ConnorTidd/SurviveVR, EnemyFiles/testMovement.clp, a clip that CAT exported",
    ),
)

RIGS = (*_WITHOUT, *_CHAINED, *_IN_THREE, *_HELPED, *_READ)
