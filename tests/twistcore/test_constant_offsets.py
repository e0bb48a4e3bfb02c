"""A bone that is turned against its child throughout shows next to the other side or a take."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.test_bvh import small
from tests.twistcore.test_registry import run
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.detection.constant_offsets import constant_offsets, constant_offsets_from_other_take
from twistcore.errors import ClipMismatchError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.formats.reading import read_clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle, twist_angle, wrap

WALK = read_bvh(ASSETS / "walk.bvh").motion
CHAINS = {c.name: c for c in find_chains(WALK)}


def offset_by(name, degrees):
    offset = np.full(WALK.frames, np.radians(-degrees))
    return remove_twist(WALK, [CHAINS[name]], {name: offset})


@pytest.mark.parametrize("clip", ["walk", "dance", "kick", "basketball"])
def test_sound_clips_have_none(clip):
    motion = read_bvh(ASSETS / f"{clip}.bvh").motion
    assert constant_offsets(motion, find_chains(motion)) == ()


@pytest.mark.parametrize(
    ("name", "degrees"), [("LeftUpLeg", 45.0), ("LeftForeArm", 170.0), ("RightArm", -80.0)]
)
def test_the_bone_and_the_angle_are_named(name, degrees):
    (found,) = constant_offsets(offset_by(name, degrees), tuple(CHAINS.values()))
    assert found.chain.name == name
    assert found.other.segment == found.chain.segment
    assert found.degrees == pytest.approx(degrees, abs=12.0)


@pytest.mark.parametrize(("clip", "least"), [("walk", 10), ("kick", 4)])
@pytest.mark.parametrize("degrees", [60.0, -60.0, 120.0, 170.0])
def test_the_bone_is_named_or_none(clip, least, degrees):
    """In a kick some are hidden: its arms are held differently, and a wrist turns all around."""
    motion = read_bvh(ASSETS / f"{clip}.bvh").motion
    chains, named = find_chains(motion), 0
    for chain in chains:
        offset = {chain.name: np.full(motion.frames, np.radians(-degrees))}
        for one in constant_offsets(remove_twist(motion, [chain], offset), chains):
            assert (one.chain.name, one.clear) == (chain.name, True)
            assert abs(wrap(np.radians(one.degrees - degrees))) < np.radians(12.0)
            named += 1
    assert named >= least


def test_where_no_side_is_clearly_off_both_are_named():
    """Halves of an offset on both sides differ from rest alike."""
    off = offset_by("LeftUpLeg", 30.0)
    right = {"RightUpLeg": np.full(WALK.frames, np.radians(-30.0))}
    (found,) = constant_offsets(
        remove_twist(off, [CHAINS["RightUpLeg"]], right), [*CHAINS.values()]
    )
    assert not found.clear
    assert {found.chain.name, found.other.name} == {"LeftUpLeg", "RightUpLeg"}
    assert "Left UpLeg" in str(found)
    assert "Right UpLeg" in str(found)


def test_a_clip_that_could_not_be_examined_has_none():
    analysis = analyse(offset_by("LeftUpLeg", 60.0).sliced(100, 104))
    assert [note.kind for note in analysis.notes] == ["not examined"]


def test_what_turns_along_or_is_small_is_none():
    """A shoulder that is held rolled takes its child along: that is a pose."""
    j = WALK.skeleton.index("LeftArm")
    half = offset_by("LeftArm", 80.0).rotations[:, j]
    rotations = WALK.rotations.copy()
    rotations[:, j] = half
    assert constant_offsets(WALK.with_rotations(rotations), tuple(CHAINS.values())) == ()
    assert constant_offsets(offset_by("LeftUpLeg", 20.0), tuple(CHAINS.values())) == ()


def test_it_is_a_note_of_the_analysis_and_no_interval():
    found = analyse(offset_by("LeftUpLeg", 60.0)).detect()
    assert [n.kind for n in found.analysis.notes if n.kind == "constant offset"]
    assert not [i for i in found if i.chain == "LeftUpLeg"]


# Compared with the rest pose


def test_legs_that_are_off_alike_on_both_sides_are_off_from_their_rest_pose():
    both = {"LeftUpLeg": -45.0, "RightUpLeg": 45.0}
    motion = remove_twist(
        WALK,
        [CHAINS[name] for name in both],
        {name: np.full(WALK.frames, np.radians(degrees)) for name, degrees in both.items()},
    )
    found = constant_offsets(motion, tuple(CHAINS.values()))
    assert {one.chain.name: round(one.degrees / 45.0) for one in found} == {
        "LeftUpLeg": 1,
        "RightUpLeg": -1,
    }
    assert all("rest pose" in str(one) for one in found)


def test_a_bone_that_the_other_side_shows_is_named_once():
    assert len(constant_offsets(offset_by("LeftUpLeg", 60.0), tuple(CHAINS.values()))) == 1


# Compared with another take

OTHER = read_bvh(ASSETS / "walk_injected.bvh").motion


@pytest.mark.parametrize("name", sorted(CHAINS))
@pytest.mark.parametrize("degrees", [45.0, -90.0, 170.0])
def test_another_take_shows_the_bone_and_the_angle(name, degrees):
    (found,) = constant_offsets_from_other_take(
        offset_by(name, degrees), tuple(CHAINS.values()), OTHER, "take"
    )
    assert (found.chain.name, found.reference) == (name, "take")
    assert abs(wrap(np.radians(found.degrees - degrees))) < np.radians(1.0)
    assert str(found).endswith("compared with take.")


@pytest.mark.parametrize("extra", [-40.0, 40.0])
def test_poses_of_takes_may_differ_by_less_than_the_offset(extra):
    """The less steady joint then has less weight."""
    arm, motion = CHAINS["LeftArm"], offset_by("LeftArm", 90.0)
    rotations = motion.rotations.copy()
    roll = quaternion_from_axis_angle(arm.axis, np.radians(-extra))
    rotations[:, arm.child] = multiply(roll, rotations[:, arm.child])
    chains = tuple(CHAINS.values())
    (found,) = constant_offsets_from_other_take(
        motion.with_rotations(rotations), chains, OTHER, "take"
    )
    assert found.chain is arm
    assert min(90.0, 90.0 + extra) < found.degrees < max(90.0, 90.0 + extra)
    assert abs(found.degrees - 90.0) < abs(extra) / 2.0  # the upper arm is steadier


@pytest.mark.parametrize("frame", [7, 63, 91])
def test_of_two_held_poses_both_joints_count_alike(frame):
    """Where no joint moves, an error of rounding must not weigh one against the other."""
    chains, take = tuple(CHAINS.values()), WALK.at(np.full(77, frame + 50))
    names = []
    for chain in chains:
        offset = {chain.name: np.full(60, np.radians(-60.0))}
        motion = remove_twist(WALK.at(np.full(60, frame)), [chain], offset)
        for found in constant_offsets_from_other_take(motion, chains, take, "take"):
            of_p, of_c = (
                np.subtract(
                    *(twist_angle(m.rotations[0, joint], found.chain.axis) for m in (motion, take))
                )
                for joint in (found.chain.parent, found.chain.child)
            )
            angle = np.radians(found.degrees)
            assert wrap(angle - of_p) == pytest.approx(wrap(-of_c - angle), abs=1e-9)
            names.append(found.chain.name)
    assert len(set(names)) > 5


def test_a_take_shows_the_same_error_of_both_sides():
    """Which no comparison of the sides can show."""
    motion = WALK
    for name, degrees in (("LeftArm", 80.0), ("RightArm", -80.0)):
        offset = {name: np.full(WALK.frames, np.radians(-degrees))}
        motion = remove_twist(motion, [CHAINS[name]], offset)
    chains = tuple(CHAINS.values())
    assert constant_offsets(motion, chains) == ()
    found = constant_offsets_from_other_take(motion, chains, OTHER, "take")
    assert {one.chain.name: round(one.degrees) for one in found} == {
        "LeftArm": 80,
        "RightArm": -80,
    }


@pytest.mark.parametrize("other", ["dance", "kick", "basketball"])
def test_other_sound_takes_show_nothing(other):
    other = read_bvh(ASSETS / f"{other}.bvh").motion
    assert constant_offsets_from_other_take(WALK, tuple(CHAINS.values()), other, "take") == ()
    assert (
        constant_offsets_from_other_take(
            offset_by("LeftUpLeg", 20.0), tuple(CHAINS.values()), other, "take"
        )
        == ()
    )


def _renamed(skeleton):
    names = ("Pelvis", *skeleton.names[1:])
    return replace(skeleton, names=names)


def _hung_elsewhere(skeleton):
    parents = skeleton.parents.copy()
    parents[skeleton.index("LeftHand")] = 0
    return replace(skeleton, parents=parents)


def _turned(skeleton):
    offsets = skeleton.offsets.copy()
    offsets[skeleton.index("LeftLeg")] = np.linalg.norm(offsets[skeleton.index("LeftLeg")]), 0, 0
    return replace(skeleton, offsets=offsets)


@pytest.mark.parametrize(
    ("changed", "named"),
    [(_renamed, "Pelvis"), (_hung_elsewhere, "LeftHand"), (_turned, "LeftLeg")],
)
def test_a_take_of_another_skeleton_is_refused(changed, named):
    other = replace(WALK, skeleton=changed(WALK.skeleton))
    with pytest.raises(ClipMismatchError) as error:
        constant_offsets_from_other_take(WALK, tuple(CHAINS.values()), other, "take.bvh")
    assert names_in_one_line(str(error.value) + "\n", "take.bvh", named)


def test_bones_of_other_lengths_are_the_same_skeleton():
    other = replace(WALK, skeleton=replace(WALK.skeleton, offsets=1.2 * WALK.skeleton.offsets))
    assert constant_offsets_from_other_take(WALK, tuple(CHAINS.values()), other, "take") == ()


# At the command line


@pytest.fixture
def turned(tmp_path):
    clip = read_clip(ASSETS / "walk.bvh")
    write_clip(clip, offset_by("LeftUpLeg", 60.0), path := tmp_path / "turned.bvh")
    return path


def test_the_commands_print_the_bone_the_degrees_and_the_reference(turned):
    code, _, err = run("detect", turned, "--reference", ASSETS / "dance.bvh")
    lines = [line for line in err.splitlines() if "dance.bvh" in line]
    assert code == 0
    assert len(lines) == 1
    assert "Left UpLeg" in lines[0]
    assert "60°" in lines[0]
    _, out, _ = run("detect", turned, "--reference", ASSETS / "dance.bvh", "--json")
    notes = [n for n in json.loads(out)["notes"] if "dance.bvh" in n["text"]]
    assert [n["kind"] for n in notes] == ["constant offset"]
    _, out, _ = run("info", turned, "--reference", ASSETS / "dance.bvh")
    assert lines[0].partition("note: ")[2] in out
    _, _, err = run("detect", turned)
    assert "dance.bvh" not in err


def test_a_bad_reference_is_one_sentence(turned, tmp_path):
    (tmp_path / "empty.bvh").write_text("")
    for reference in (tmp_path / "none.bvh", tmp_path / "empty.bvh", ASSETS / "no.txt"):
        code, _, err = run("detect", turned, "--reference", reference)
        assert code == 2
        assert names_in_one_line(err, str(reference))
    (tmp_path / "small.bvh").write_bytes(small(np.arange(27).reshape(3, 9)))
    code, _, err = run("detect", turned, "--reference", tmp_path / "small.bvh")
    assert code == 2
    assert names_in_one_line(err, "small.bvh", "2 joints", "31")
