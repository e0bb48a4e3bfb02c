"""People in one skeleton: who is found, what they are called, and what is no person."""

import numpy as np
import pytest

from twistcore.skeleton.joint_names import interpret_names
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.people import find_people, interpret_person_joint_names

SIDES = ("Left", "Right")
LEGS = [("Hips", None)] + [
    (f"{side}{name}", f"{side}{above}" if above else "Hips")
    for side in SIDES
    for above, name in (("", "UpLeg"), ("UpLeg", "Leg"), ("Leg", "Foot"), ("Foot", "Toe"))
]
TRUNK = [("Spine", None), ("Spine1", "Spine"), ("Neck", "Spine1"), ("Head", "Neck")] + [
    (f"{side}{name}", f"{side}{above}" if above else "Spine1")
    for side in SIDES
    for above, name in (("", "Shoulder"), ("Shoulder", "Arm"), ("Arm", "ForeArm"),
                        ("ForeArm", "Hand"), ("Hand", "Finger"))
]  # fmt: skip
BODY = LEGS + [(name, above or "Hips") for name, above in TRUNK]
_SYLLABLES = [a + b for a in "bdfgkmnprst" for b in ("a", "e", "o")]
UNKNOWN = {name: _SYLLABLES[k] for k, (name, _) in enumerate(BODY)}


def called(pattern, body=BODY, *, on=None):
    """A body with other names: '*' is the joint's own; on: what its first joint hangs on."""

    def name(own):
        return pattern.replace("*", own)

    return [(name(own), name(above) if above else on) for own, above in body]


def skeleton(*parts):
    """Joints of (name, parent's name); the second of equal names as a reader calls it."""
    names, parents = [], []
    latest: dict[str, int] = {}
    for name, above in (joint for part in parts for joint in part):
        parents.append(latest[above] if above is not None else -1)
        latest[name] = len(names)
        count = sum(other.split(" #")[0] == name for other in names)
        names.append(f"{name} #{count + 1}" if count else name)
    return Skeleton(tuple(names), np.array(parents), np.ones((len(names), 3)))


def people(*parts):
    """Names of people with how many joints each has."""
    return {p.name: len(p.joints) for p in find_people(skeleton(*parts))}


@pytest.mark.parametrize(
    ("one", "other", "names"),
    [
        ("*", "*_B", "AB"),
        ("*_A", "*_B", "AB"),
        ("A:*", "B:*", "AB"),
        ("*", "B:*", "AB"),
        ("scene:A:*", "scene:B:*", ("scene:A", "scene:B")),
        ("mixamorig:*", "mixamorig1:*", ("mixamorig", "mixamorig1")),
        ("Anna_*", "Bob_*", ("Anna", "Bob")),
        ("rig_Anna_*", "rig_Bob_*", ("Anna", "Bob")),
        ("*-anna", "*-bob", ("anna", "bob")),
        ("P1_*", "P2_*", ("P1", "P2")),
        ("Person 1 *", "Person 2 *", ("Person1", "Person2")),
        ("Bip01 *", "Bip02 *", ("Bip01", "Bip02")),
        ("*.001", "*.002", ("001", "002")),
        ("*", "*.001", ("000", "001")),
        ("*", "*", "12"),
        ("A:*", "A:*", "12"),
    ],
)
@pytest.mark.parametrize("root", [[], [("World", None)], [("World", None), ("Reference", "World")]])
def test_two_people_are_told_by_what_their_names_have_in_common(one, other, names, root):
    on = root[-1][0] if root else None
    pair = skeleton(root, called(one, on=on), called(other, on=on))
    first, second = find_people(pair)
    assert (first.name, second.name) == tuple(names)
    assert set(first.joints) == set(range(len(root), len(root) + len(BODY)))
    assert set(second.joints) == set(range(len(root) + len(BODY), len(pair)))


@pytest.mark.parametrize("pattern", ["*_B", "B:*", "Bob_*", "*-bob", "P2_*", "*.001", "*", "B-*"])
def test_without_the_person_s_words_the_names_say_what_they_say_of_one_person(pattern):
    pair = skeleton(called("*"), called(pattern))
    alone = interpret_names([name for name, _ in BODY])
    both = find_people(pair)
    said = interpret_person_joint_names(pair, both)
    for person in both:
        assert [said[j] for j in person.joints] == alone


def test_one_person_has_no_name_and_all_joints():
    for pattern in ("*", "A:*", "*_B", "mixamorig:*", "DEF-*"):
        [person] = find_people(skeleton(called(pattern)))
        assert (person.name, len(person.joints)) == ("", len(BODY))


def test_three_people_with_equal_names_are_numbered():
    assert list(people(called("*"), called("*"), called("*"))) == ["1", "2", "3"]


def test_people_with_rigs_of_their_own_are_called_by_their_first_joints():
    other = [(name.replace("Hips", "Pelvis"), above and above.replace("Hips", "Pelvis"))
             for name, above in BODY]  # fmt: skip
    assert people(called("*"), other) == {"Hips": len(BODY), "Pelvis": len(BODY)}


def test_a_person_whose_legs_and_trunk_have_roots_of_their_own_is_one():
    assert people(LEGS, TRUNK) == {"": len(BODY)}
    assert people(LEGS, TRUNK, called("*_B", LEGS), called("*_B", TRUNK)) == {
        "A": len(BODY), "B": len(BODY)
    }  # fmt: skip


def test_people_of_whom_only_a_part_was_captured_are_people():
    assert people(called("*"), called("*_B", TRUNK)) == {"A": len(BODY), "B": len(TRUNK)}
    arm = [joint for joint in TRUNK if joint[0].startswith("Left")]
    alone = [(name, above if above != "Spine1" else None) for name, above in arm]
    assert people(called("*"), called("*_B", alone)) == {"A": len(BODY), "B": len(alone)}


def test_a_person_who_hangs_on_the_other_one_s_hips_is_one():
    found = people(called("*"), called("*_B", on="Hips"))
    assert found["B"] == len(BODY)
    assert found["A"] == len(BODY)


def test_people_next_to_props_and_cameras_are_found():
    camera = [("Camera", None), ("Lens", "Camera")]
    rack = [("Rack", None), *((f"Rack{k}", "Rack") for k in range(12))]
    root = [("World", None)]
    pair = called("*", on="World"), called("*_B", on="World")
    assert people(camera, rack, root, *pair) == {"A": len(BODY), "B": len(BODY)}


def unknown(pattern, *, on=None):
    body = [(UNKNOWN[name], UNKNOWN[above] if above else None) for name, above in BODY]
    return called(pattern, body, on=on)


def test_people_with_unknown_names_are_found_by_being_alike():
    root = [("World", None)]
    assert set(people(unknown("*"), unknown("*_B"))) == {"A", "B"}
    assert set(people(root, unknown("*", on="World"), unknown("*_B", on="World"))) == {"A", "B"}
    assert set(people(called("*"), unknown("*"))) == {"Hips", UNKNOWN["Hips"]}


def with_sides(left, right):
    body = [(n.replace("Left", "") + left if "Left" in n else n, a) for n, a in BODY]
    body = [(n, a.replace("Left", "") + left if a and "Left" in a else a) for n, a in body]
    body = [(n.replace("Right", "") + right if "Right" in n else n, a) for n, a in body]
    return [(n, a.replace("Right", "") + right if a and "Right" in a else a) for n, a in body]


@pytest.mark.parametrize("sides", [("_L", "_R"), ("_G", "_D"), (" links", " rechts")])
def test_sides_are_no_people(sides):
    assert people(with_sides(*sides)) == {"": len(BODY)}


def test_pieces_numbered_01_and_02_are_no_people():
    pieces = []
    for name, above in BODY:
        pieces += [(f"{name}01", f"{above}02" if above else None), (f"{name}02", f"{name}01")]
    assert people(pieces) == {"": 2 * len(BODY)}


@pytest.mark.parametrize("on", ["Spine1", "Hips", None])
def test_a_prop_with_a_hand_s_name_is_no_person(on):
    prop = [("Sword", on), ("LeftHand", "Sword"), ("Blade", "LeftHand")]
    assert list(people(BODY, prop)) == [""]
    assert list(people(prop if on is None else [], BODY)) == [""]


@pytest.mark.parametrize("before", [True, False])
def test_a_second_arm_on_the_same_hips_is_no_person(before):
    second = [("LeftGrip", "Hips"), ("LeftHilt", "LeftGrip"), ("LeftHand", "LeftHilt")]
    body = [LEGS[0], *second, *BODY[1:]] if before else [*BODY, *second]
    assert list(people(body)) == [""]


def test_a_cape_with_a_root_of_its_own_is_no_person():
    cape = [("Cape", None)] + [
        (f"Cape{k}{j}", f"Cape{k}{j - 1}" if j else "Cape") for k in range(5) for j in range(4)
    ]
    assert list(people(BODY, cape)) == [""]


def test_layers_of_a_rig_in_one_tree_are_no_people():
    layers = [("root", None)]
    for name, above in BODY:
        layers += [(f"ORG-{name}", f"ORG-{above}" if above else "root"),
                   (f"DEF-{name}", f"ORG-{name}")]  # fmt: skip
    assert list(people(layers)) == [""]


def test_a_skeleton_of_one_joint_or_of_a_line_is_one_person():
    assert people([("Root", None)]) == {"": 1}
    line = [("j0", None), *((f"j{k}", f"j{k - 1}") for k in range(1, 3000))]
    assert people(line) == {"": 3000}
