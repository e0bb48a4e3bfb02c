"""Two motions compared: which joints differ in which frames, and how far they moved."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore.test_all_joints import turned
from twistcore.errors import ClipMismatchError
from twistcore.export.compare import compare_motions, difference_to_json, largest_deviation
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.motion import Motion, forward_kinematics

WALK = read_bvh(ASSETS / "walk.bvh").motion
SKELETON, HEIGHT = WALK.skeleton, WALK.skeleton.height
ARM_BELOW = ("LeftForeArm", "LeftHand", "LeftFingerBase", "LeftHandIndex1", "LThumb")


def other() -> Motion:
    """The walk with an arm that is turned by up to 40°, and a knee that is hardly turned."""
    motion = turned(WALK, "LeftArm", 100, 110, 30.0)
    motion = turned(motion, "LeftArm", 104, 105, 10.0)
    return turned(motion, "LeftLeg", 105, 112, 0.05)


def test_each_joint_has_its_frames_and_its_largest_angle():
    found = compare_motions(WALK, other())
    spans = {(j.joint, j.start, j.stop): j.max_degrees for j in found.joints}
    assert spans == pytest.approx({("LeftLeg", 105, 112): 0.05, ("LeftArm", 100, 110): 40.0})
    assert found.frames == 12  # each frame once
    assert found.moved_channels == 0
    ends = turned(turned(other(), "LeftArm", 0, 2, 5.0), "LeftArm", 340, WALK.frames, 5.0)
    spans = [(j.start, j.stop) for j in compare_motions(WALK, ends).joints if j.joint == "LeftArm"]
    assert spans == [(0, 2), (100, 110), (340, WALK.frames)]


def test_joints_that_move_are_listed_and_what_rounding_explains_is_not():
    found = compare_motions(WALK, other())
    way = np.linalg.norm(forward_kinematics(other())[1] - forward_kinematics(WALK)[1], axis=-1)
    assert {move.joint for move in found.moved} == set(ARM_BELOW)
    for move in found.moved:
        own = way[:, SKELETON.index(move.joint)]
        assert move.largest == pytest.approx(own.max())
        assert move.of_height == pytest.approx(own.max() / HEIGHT)
        assert move.frames == 10
    assert found.max_position == pytest.approx(way.max())
    assert found.max_position_of_height == pytest.approx(way.max() / HEIGHT)
    foot = way[:, SKELETON.index("LeftToeBase")].max()
    assert found.rest_of_height == pytest.approx(foot / HEIGHT)
    assert 0.0 < found.rest_of_height < 1e-3


def test_a_root_that_is_elsewhere_moves_all_joints():
    positions = WALK.positions.copy()
    positions[50:, 0, 1] += 0.02 * HEIGHT
    found = compare_motions(WALK, replace(WALK, positions=positions))
    assert (found.joints, found.frames, found.moved_channels) == ((), 0, 1)
    assert {move.joint for move in found.moved} == set(SKELETON.names)
    assert {move.frames for move in found.moved} == {WALK.frames - 50}
    assert found.max_position_of_height == pytest.approx(0.02)
    assert found.rest_of_height == 0.0


def test_errors_of_rounding_are_no_difference():
    q = WALK.rotations * (1.0 + 1e-15)
    found = compare_motions(WALK, WALK.with_rotations(q))
    assert (found.joints, found.moved, found.frames) == ((), (), 0)


def test_its_document_has_every_number():
    found = compare_motions(WALK, other())
    document = difference_to_json(found, "a.bvh", "b.bvh")
    assert (document["a"], document["b"], document["frames"]) == ("a.bvh", "b.bvh", 12)
    arm = next(j for j in document["joints"] if j["joint"] == "LeftArm")
    assert (arm["start"], arm["stop"], arm["max_deg"]) == (100, 110, pytest.approx(40.0))
    assert document["changed_position_channels"] == 0
    assert document["max_position"] == found.max_position
    assert document["max_position_of_height"] == found.max_position_of_height
    assert document["moved"] == [
        {"joint": m.joint, "max": m.largest, "max_of_height": m.of_height, "frames": m.frames}
        for m in found.moved
    ]


def _with(**changes):
    return replace(WALK, skeleton=replace(SKELETON, **changes))


def _parents():
    parents = SKELETON.parents.copy()
    parents[SKELETON.index("LeftHand")] = 0
    return parents


@pytest.mark.parametrize(
    ("different", "fact"),
    [
        (_with(names=("Pelvis", *SKELETON.names[1:])), "skeletons"),
        (_with(parents=_parents()), "skeletons"),
        (WALK.sliced(0, 100), "different numbers of frames: 344 and 100"),
        (replace(WALK, positioned=(*WALK.positioned, 1)), "position channels"),
    ],
)
def test_motions_that_cannot_be_compared_are_refused(different, fact):
    with pytest.raises(ClipMismatchError, match=fact):
        compare_motions(WALK, different)


def reordered(motion):
    """The motion with its joints in another order, in which parents are before their children."""
    skeleton = motion.skeleton
    order = np.concatenate([level[::-1] for level in skeleton.levels])
    place = np.argsort(order)
    parents = [place[parent] if parent >= 0 else -1 for parent in skeleton.parents[order]]
    changed = replace(
        skeleton,
        names=tuple(skeleton.names[joint] for joint in order),
        parents=np.array(parents),
        offsets=skeleton.offsets[order],
        ends=tuple((int(place[joint]), end) for joint, end in skeleton.ends),
    )
    return replace(motion, skeleton=changed, rotations=motion.rotations[:, order])


def test_the_largest_deviation_does_not_depend_on_the_order_of_joints():
    there = turned(WALK, "LeftArm", 104, 105, 40.0)
    way = np.linalg.norm(forward_kinematics(there)[1] - forward_kinematics(WALK)[1], axis=-1)
    assert reordered(WALK).skeleton.names != SKELETON.names
    for a, b in ((WALK, there), (WALK, reordered(there)), (reordered(there), WALK)):
        found = largest_deviation(a, b)
        assert (found.joint in ("LeftArm", *ARM_BELOW), found.frame) == (True, 104)
        assert found.degrees == pytest.approx(40.0)
        assert found.position == pytest.approx(way.max())
        assert found.of_height == pytest.approx(way.max() / HEIGHT)
    assert largest_deviation(WALK, reordered(WALK)).degrees < 1e-5
    for other_motion in (WALK.sliced(0, 100), _with(names=("Pelvis", *SKELETON.names[1:]))):
        with pytest.raises(ClipMismatchError):
            largest_deviation(WALK, other_motion)
