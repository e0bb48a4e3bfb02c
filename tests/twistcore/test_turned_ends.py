"""Turned ends: a foot that turns by a fixed rotation during a flip, put back only on request."""

import numpy as np
import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.joint_repairs import JointRepairs
from twistcore.detection.quantity import evidence_curve_of_interval
from twistcore.detection.turned_ends import (
    APART,
    SMALLEST,
    jump_rotations_at_edges,
    mean_edge_jump,
)
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decide, Decision
from twistcore.skeleton.rotation import exponential, geodesic_angle, multiply, normalise

WALK = read_bvh(ASSETS / "walk.bvh").motion
SKELETON = WALK.skeleton
FOOT = SKELETON.index("RightFoot")
KNEE = "RightUpLeg-RightFoot"
START, STOP = 100, 118
AXIS = normalise(np.array((0.6, -0.5, 0.62)))


def flipped(degrees=90.0, back=None, *, carried=True):
    """Return the walk with a flipped knee whose foot turns by an angle, and back by another one."""
    half_turn = np.full(STOP - START, np.pi)
    flip = tc.InjectedError(KNEE, START, STOP, half_turn, kind=tc.Kind.LIMB_FLIP, carried=carried)
    motion = tc.inject(WALK, [flip])
    share = np.linspace(0.0, 1.0, STOP - START)
    angles = np.radians(degrees + share * ((degrees if back is None else back) - degrees))
    rotations = motion.rotations.copy()
    turn = exponential(angles[:, None] * AXIS)
    rotations[START:STOP, FOOT] = normalise(multiply(rotations[START:STOP, FOOT], turn))
    return motion.with_rotations(rotations)


def turned_ends(motion):
    return [i for i in tc.detect(motion) if i.kind == tc.Kind.TURNED_END]


def accepted(motion, *kinds):
    """Return the motion after a person has accepted all intervals of the kinds."""
    review = tc.Review(tc.detect(motion))
    ids = tuple(j.id for j in review.state.intervals if j.interval.kind in kinds)
    review.do(Decide(ids, Decision.ACCEPTED, "Ada", "2026-01-01T00:00:00+00:00"))
    return tc.refine(motion, review)


@parametrize("carried", [True, False])
def test_the_foot_is_put_back_if_a_person_accepts_it(carried):
    motion = flipped(carried=carried)
    (found,) = turned_ends(motion)
    assert (found.joint, found.start, found.stop) == ("RightFoot", START, STOP)
    assert np.degrees(found.residual) == pytest.approx(90.0, abs=4.0)
    assert found.evidence["turn_deg"] == pytest.approx(np.degrees(found.residual))
    assert (len(found.offset), found.carried) == (STOP - START, True)
    refined = accepted(motion, tc.Kind.LIMB_FLIP, tc.Kind.TURNED_END)
    left = geodesic_angle(refined.rotations[:, FOOT], WALK.rotations[:, FOOT])
    assert np.degrees(left.max()) < 6.0  # the foot also moves between the frames of each edge
    outside = np.r_[0:START, STOP : WALK.frames]
    np.testing.assert_array_equal(refined.rotations[outside], motion.rotations[outside])


def test_without_a_person_only_the_flip_is_corrected():
    motion = flipped()
    (found,) = turned_ends(motion)
    assert found.open
    assert not found.automatic
    refined = tc.refine(motion, tc.detect(motion))
    at = slice(START, STOP)
    assert (refined.rotations[at, FOOT] == motion.rotations[at, FOOT]).all()


@pytest.mark.parametrize(
    ("degrees", "back"),
    [(0.0, 0.0), (np.degrees(SMALLEST) - 10.0,) * 2, (90.0, 90.0 - np.degrees(APART) - 10.0)],
)
def test_small_and_unequal_turns_are_not_listed(degrees, back):
    assert turned_ends(flipped(degrees, back)) == []


def test_a_foot_without_a_flip_is_not_listed():
    rotations = WALK.rotations.copy()
    turn = exponential(np.radians(90.0) * AXIS)
    rotations[START:STOP, FOOT] = multiply(rotations[START:STOP, FOOT], turn)
    assert turned_ends(WALK.with_rotations(rotations)) == []


def test_frames_of_a_turned_end_are_no_stretch():
    kick = read_bvh(ASSETS / "kick.bvh").motion
    found = tc.detect(kick)
    ends = [i for i in found if i.kind == tc.Kind.TURNED_END]
    assert ends
    spans = {(i.joint, i.start, i.stop) for i in found if i.kind == tc.Kind.STRETCH}
    assert spans.isdisjoint((i.joint, i.start, i.stop) for i in ends)


def test_equal_turns_have_themselves_in_common():
    turn = exponential(np.radians(120.0) * AXIS)
    before, after = WALK.rotations[[10, 30], FOOT]
    edges = np.array([before, multiply(before, turn), -multiply(after, turn), after])
    turns = jump_rotations_at_edges(edges)
    for one in (*turns, mean_edge_jump(turns)):
        assert geodesic_angle(one, turn) == pytest.approx(0.0, abs=1e-6)


def test_at_an_end_of_the_clip_nothing_is_changed():
    motion = flipped()
    (found,) = turned_ends(motion)
    inside = motion.sliced(START, STOP + 5)
    repair = JointRepairs([found.with_offset(0, np.ones(found.frames))])
    assert (repair.applied(inside).rotations == inside.rotations).all()


def test_the_curve_exceeds_its_limit_in_the_interval():
    motion = flipped()
    (found,) = turned_ends(motion)
    curve = evidence_curve_of_interval(analyse(motion).search("consistency"), found)
    over = curve.values > curve.limit
    assert over[START:STOP].all()
    assert not over[START - 5 : START].any()
