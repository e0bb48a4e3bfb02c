"""A bone that is turned against its child throughout shows next to the other side."""

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis import analyse
from twistcore.bvh import read_bvh
from twistcore.chain import find_chains
from twistcore.detection.constant_offsets import constant_offsets
from twistcore.twist_removal import remove_twist

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
