"""What a correction makes worse in a limb and its neighbours, and what it does not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.correction.protected_measures import (
    ENDS,
    HINGE,
    NAMES,
    PATH,
    ROLL,
    TURNS,
    Hinges,
    protected_measures,
)
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection import Interval, Kind
from twistcore.detection.evidence import ChainSignals
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains, make_chain
from twistcore.skeleton.limb import find_limbs

WALK = read_bvh(ASSETS / "walk.bvh").motion
CHAINS = find_chains(WALK)
EVERY = (*CHAINS, *find_limbs(WALK, CHAINS))
THIGH = next(c for c in CHAINS if c.name == "LeftUpLeg")
BENT = int(np.argmax(ChainSignals.of(WALK, THIGH).bend))


def interval(chain, degrees, start=BENT - 5, stop=BENT + 5, kind=Kind.COUNTER_TWIST, **more):
    offset = np.full(stop - start, math.radians(degrees))
    return Interval(chain, start, stop, offset, kind=kind, **more)


def flip(degrees, **more):
    return interval("LeftUpLeg-LeftFoot", degrees, kind=Kind.LIMB_FLIP, **more)


def with_errors(*errors):
    """The clip with errors put in, which their intervals take out."""
    return refine(WALK, EVERY, [i.with_offset(i.start, -i.offset) for i in errors])


def measured(motion, found, **more):
    return {m.name: m for m in protected_measures(motion, EVERY, found, **more)}


ERRORS = [
    interval("LeftUpLeg", 12.0),
    interval("RightArm", -40.0),
    interval("LeftForeArm", 60.0),
    interval("RightShoulder", 8.0),
    flip(150.0),
    flip(-150.0, carried=True),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda e: f"{e.chain} {e.carried}")
def test_a_correction_of_an_error_makes_nothing_worse(error):
    found = measured(with_errors(error), error)
    assert not [m for m in found.values() if m.worse]
    assert min(m.growth for m in found.values()) < -0.3
    assert (PATH in found) == (error.kind == Kind.LIMB_FLIP)


def test_a_correction_that_nothing_calls_for_takes_an_exact_hinge_apart():
    hinge = measured(WALK, interval("LeftUpLeg", 12.0))[HINGE]
    assert hinge.worse
    assert hinge.joint == "LeftLeg"
    assert hinge.before < 1.0
    assert hinge.growth == pytest.approx(12.0, abs=1.0)
    assert not measured(WALK, interval("LeftUpLeg", 0.5))[HINGE].worse


def test_a_joint_without_an_exact_hinge_is_on_none():
    assert HINGE not in measured(WALK, interval("LeftForeArm", 30.0))


def test_a_straight_limb_is_on_no_hinge():
    straight = int(np.argmin(ChainSignals.of(WALK, THIGH).bend))
    assert HINGE not in measured(WALK, interval(THIGH.name, 12.0, straight, straight + 1))


def test_a_hinge_is_told_by_the_frames_without_finds():
    """Half of a clip that is wrong hides a hinge, unless it is known to be wrong."""
    error = interval("LeftUpLeg", 25.0, 0, WALK.frames // 2)
    wrong, found = with_errors(error), interval("LeftUpLeg", 12.0, BENT, BENT + 2)
    assert HINGE not in measured(wrong, found)
    hinge = measured(wrong, found, hinges=Hinges(wrong, (error, found)))[HINGE]
    assert hinge.growth == pytest.approx(-12.0 if error.stop > BENT else 12.0, abs=1.0)


def test_turns_that_no_body_makes_are_counted():
    turns = measured(WALK, interval("RightArm", 90.0))[TURNS]
    assert (turns.before, turns.after, turns.worse) == (0.0, 2.0, True)  # P at both edges
    assert turns.joint == "RightArm"
    assert not measured(WALK, interval("RightArm", 20.0))[TURNS].worse


def test_the_next_joint_rolls_by_what_it_is_turned_back():
    roll = measured(WALK, interval("LeftForeArm", 35.0))[ROLL]
    assert roll.worse
    assert roll.joint == "LeftHand"
    assert roll.after == pytest.approx(35.0, abs=10.0)
    assert not measured(WALK, interval("LeftForeArm", 3.0))[ROLL].worse


def test_the_end_of_a_limb_is_wrung_by_a_flip_that_was_none():
    found = measured(WALK, flip(150.0))
    assert found[PATH].worse
    assert found[PATH].joint == "LeftLeg"
    assert found[PATH].growth > 5.0
    assert found[ROLL].joint == "LeftFoot"
    assert found[ROLL].growth > 20.0
    assert found[ENDS].after < 1e-6  # the foot and the toes stay
    carried = measured(WALK, flip(150.0, carried=True))
    assert carried[ROLL].growth == pytest.approx(0.0, abs=1e-6)
    assert carried[ENDS].after < 1e-6


def test_a_bone_beside_the_axis_is_moved():
    skeleton = WALK.skeleton
    chest, neck, shoulder = (skeleton.index(n) for n in ("Spine1", "Neck", "LeftShoulder"))
    offsets = skeleton.offsets.copy()
    offsets[neck], offsets[shoulder] = (0.0, 1.0, 0.0), (1.0, 0.5, 0.0)
    motion = replace(WALK, skeleton=replace(skeleton, offsets=offsets))
    chain = make_chain(motion, chest, neck)
    found = protected_measures(motion, [chain], interval("Spine1", 40.0))
    (ends,) = (m for m in found if m.name == ENDS)
    assert ends.worse
    assert ends.joint == "LeftShoulder"
    apart = 2.0 * math.sin(math.radians(20.0))  # a chord of 40° on a circle of radius 1
    assert ends.after == pytest.approx(100.0 * apart / motion.skeleton.height)


def test_what_is_corrected_as_well_is_no_fault_of_a_correction():
    """A step of 60° and, right behind it, one of 110° more: each alone leaves the other's edge."""
    one, two = interval("RightArm", 60.0, 100, 120), interval("RightArm", 110.0, 120, 140)
    wrong = with_errors(one, two)
    assert measured(wrong, one)[ROLL].worse
    found = measured(wrong, one, others=(one, two))
    assert not [m for m in found.values() if m.worse]
    assert found[ROLL].growth < -20.0


def test_what_is_corrected_as_well_is_taken_out_before_too():
    """From +60° to −60° the joint turns by 120°, of which one correction leaves 60°."""
    one, two = interval("RightArm", 60.0, 100, 120), interval("RightArm", -60.0, 120, 140)
    wrong = with_errors(one, two)
    alone, found = measured(wrong, one)[ROLL], measured(wrong, one, others=(one, two))[ROLL]
    assert alone.before > 1.5 * found.before
    assert found.before > 40.0


def test_what_cannot_be_corrected_is_not_measured():
    assert not measured(WALK, interval("RightArm", 0.0))
    assert not measured(WALK, interval("RightArm", 30.0, kind=Kind.LONE_JUMP))
    assert not measured(WALK, interval("Nobody", 30.0))


def test_intervals_at_the_ends_of_a_clip_are_measured_and_the_motion_stays():
    before = WALK.rotations.copy()
    for start, stop in ((0, 4), (WALK.frames - 4, WALK.frames), (0, WALK.frames)):
        found = measured(WALK, interval("RightArm", 30.0, start, stop))
        assert set(found) <= set(NAMES)
        assert all(math.isfinite(m.before) and math.isfinite(m.after) for m in found.values())
    assert np.array_equal(before, WALK.rotations)
