"""What docs/limits.md says is not found: whoever finds it one day mends the page."""

from dataclasses import replace

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle
from twistcore.synthesis.injection import InjectedError, inject

SPELL = slice(100, 110)


@pytest.fixture(scope="module", params=["walk", "dance", "basketball"])
def motion(request):
    return tc.read_bvh(ASSETS / f"{request.param}.bvh").motion


def twisted(motion, degrees):
    """The right upper arm turned about its bone, and nothing turned back."""
    arm = next(c for c in tc.find_chains(motion) if c.name == "RightArm")
    turn = quaternion_from_axis_angle(arm.axis, np.radians(degrees))
    rotations = motion.rotations.copy()
    rotations[SPELL, arm.parent] = multiply(rotations[SPELL, arm.parent], turn)
    return replace(motion, rotations=rotations)


def not_of_capture(motion):
    return [i for i in tc.detect(motion) if not i.kind.of_capture]


def test_a_twist_that_no_child_takes_back_is_not_found_unless_it_is_a_flip_or_a_jump(motion):
    assert not not_of_capture(twisted(motion, 40.0))
    kinds = {i.kind for i in not_of_capture(twisted(motion, 90.0))}
    assert kinds
    assert kinds <= {tc.Kind.LIMB_FLIP, tc.Kind.LONE_JUMP}


def test_an_offset_that_never_changes_is_not_found(motion):
    chains = tc.find_chains(motion)
    always = InjectedError("RightArm", 0, motion.frames, np.full(motion.frames, np.radians(60.0)))
    assert not not_of_capture(inject(motion, chains, [always]))
    stop = motion.frames // 2
    half = InjectedError("RightArm", 100, stop, np.full(stop - 100, np.radians(60.0)))
    assert tc.detect(inject(motion, chains, [half]))
