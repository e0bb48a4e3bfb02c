"""A bone that is turned against its child throughout shows next to the other side."""

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.detection.constant_offsets import constant_offsets
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import wrap

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
