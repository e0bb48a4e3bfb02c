"""Poses relative to SMPL's rest pose on skeletons that rest otherwise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.smpl.rest_pose import RestChange, smpl_rest_pose_change
from twistcore.formats.smpl.skeleton import PARENTS, find_network_joints, smpl_joint_positions
from twistcore.skeleton.rotation import exponential, normalise

LEFT_LEG, RIGHT_LEG = (4, 7, 10), (5, 8, 11)
LEFT_ARM, RIGHT_ARM = (18, 20, 22), (19, 21, 23)
OLD = RestChange(np.tile([1.0, 0.0, 0.0, 0.0], (24, 1)), ())  # as if every rest were SMPL's


def t_pose():
    """Rest offsets of a made-up body in SMPL's T-pose, metres: no numbers of the model's."""
    offsets = np.zeros((24, 3))
    left = {
        1: (0.1, -0.1, 0.0), 4: (0, -0.4, 0), 7: (0, -0.42, 0), 10: (0, -0.05, 0.14),
        13: (0.06, 0.1, 0), 16: (0.12, 0.03, 0), 18: (0.28, 0, 0), 20: (0.25, 0, 0),
        22: (0.08, 0, 0),
    }  # fmt: skip
    for j, v in left.items():
        offsets[j] = v
        offsets[j + 1] = np.array(v) * [-1.0, 1.0, 1.0]
    for j, v in {3: 0.11, 6: 0.13, 9: 0.06, 12: 0.21, 15: 0.1}.items():
        offsets[j] = (0.0, v, 0.01)
    return offsets


def turned(offsets, joints, axis, degrees):
    out = offsets.copy()
    rotation = Rotation.from_rotvec(np.radians(degrees) * np.asarray(axis, dtype=float))
    out[list(joints)] = rotation.apply(offsets[list(joints)])
    return out


def legs_apart(offsets, degrees=20.0):
    return turned(turned(offsets, LEFT_LEG[:2], Z, degrees), RIGHT_LEG[:2], Z, -degrees)


def arms_down(offsets, degrees):
    return turned(turned(offsets, LEFT_ARM, Z, -degrees), RIGHT_ARM, Z, degrees)


X, Y, Z = np.eye(3)
RESTS = {
    "legs apart": legs_apart(t_pose()),
    "A-pose": arms_down(t_pose(), 45.0),
    "arms hang": arms_down(legs_apart(t_pose()), 88.0),
    "z up": turned(t_pose(), range(24), X, 90.0),
    "faces x, A-pose": turned(arms_down(t_pose(), 50.0), range(24), Y, 90.0),
    "feet down": turned(t_pose(), (10, 11), X, 68.0),
    "arms ahead": turned(turned(t_pose(), LEFT_ARM, Y, -80.0), RIGHT_ARM, Y, 80.0),
}


def poses(frames=5, seed=0):
    return exponential(np.random.default_rng(seed).normal(0.0, 0.7, (frames, 24, 3)))


def directions(offsets, rotations):
    places = smpl_joint_positions(offsets, rotations, np.zeros((len(rotations), 3)))
    return normalise(places[:, 1:] - places[:, list(PARENTS[1:])])


@pytest.mark.parametrize("name", RESTS)
def test_bones_point_where_the_same_poses_point_them_on_a_t_pose(name):
    q, rest = poses(), RESTS[name]
    wanted = directions(t_pose(), q)
    wanted_feet = [k for k in range(23) if k + 1 not in (10, 11)]
    change = smpl_rest_pose_change(rest)
    found, old = directions(rest, change.carried(q)), directions(rest, OLD.carried(q))
    compared = wanted_feet if name == "feet down" else list(range(23))
    assert found[:, compared] == pytest.approx(wanted[:, compared], abs=1e-9)
    assert np.linalg.norm(old - wanted, axis=-1).max() > 0.3
    assert change.notes
    lengths = np.linalg.norm(rest, axis=1) - np.linalg.norm(t_pose(), axis=1)
    assert lengths == pytest.approx(0.0, abs=1e-12)


def test_feet_that_rest_downwards_are_turned_ahead():
    q, rest = poses(), RESTS["feet down"]
    found = directions(rest, smpl_rest_pose_change(rest).carried(q))
    ahead = t_pose()
    ahead[[10, 11]] = [0.0, 0.0, 0.15]
    assert found == pytest.approx(directions(ahead, q), abs=1e-9)


@given(st.floats(-6.0, 6.0), st.floats(-6.0, 6.0), st.floats(-5.0, 5.0))
def test_a_rest_near_smpls_is_left_alone(legs, arms, lean):
    rest = turned(arms_down(legs_apart(t_pose(), legs), arms), (3, 6, 9, 12), X, lean)
    change = smpl_rest_pose_change(rest)
    assert change.turns == pytest.approx(OLD.turns, abs=1e-12)
    assert change.notes == ()


@given(
    st.floats(-40.0, 40.0), st.floats(-30.0, 95.0), st.sampled_from([X, Y, Z]), st.integers(0, 3)
)
def test_any_standing_rest_gives_the_same_figure_with_smpls_own_offsets(legs, arms, axis, quarters):
    """With the rest that the poses refer to at hand, limbs are right to the last degree."""
    rest = turned(arms_down(legs_apart(t_pose(), legs), arms), range(24), axis, 90.0 * quarters)
    own = legs_apart(t_pose(), 5.0)
    q = poses(2)
    found = directions(rest, smpl_rest_pose_change(rest, own).carried(q))
    assert found == pytest.approx(directions(own, q), abs=1e-9)


def test_a_bone_without_length_goes_with_the_one_above():
    rest = arms_down(t_pose(), 45.0)
    rest[[22, 23]] = 0.0
    turns = smpl_rest_pose_change(rest).turns
    assert (turns[20] == turns[18]).all()
    assert (turns[22] == turns[18]).all()


def test_cmus_legs_are_brought_together():
    topology = find_network_joints(read_bvh(ASSETS / "dance.bvh").skeleton)
    change = smpl_rest_pose_change(topology.offsets)
    assert names_in_one_line(change.notes[0], "left_hip", "20°")
    q = np.tile([1.0, 0.0, 0.0, 0.0], (1, 24, 1))
    r = np.zeros((1, 3))
    still = smpl_joint_positions(topology.offsets, change.carried(q), r)[0]
    old = smpl_joint_positions(topology.offsets, q, r)[0]
    assert still[4] - still[1] == pytest.approx([0.0, still[4, 1] - still[1, 1], 0.0], abs=1e-9)
    moved = 56.444 * np.linalg.norm(still[7] - old[7])  # millimetres
    assert 250.0 < moved < 320.0


@pytest.mark.parametrize(
    ("rest", "what"),
    [
        (turned(t_pose(), LEFT_LEG, X, -100.0), "left_hip.*100°"),
        (turned(t_pose(), RIGHT_ARM, Z, -140.0), "right_shoulder.*140°"),
        (turned(t_pose(), range(24), Y, 44.0), "44°"),
        (turned(t_pose(), (10, 11), Y, 180.0), "left"),
        (np.zeros((24, 3)), "hips"),
        (t_pose() * [0.0, 1.0, 1.0], "hips"),
    ],
)
def test_rests_that_cannot_be_told_are_refused(rest, what):
    with pytest.raises(TwistError, match=what) as caught:
        smpl_rest_pose_change(rest)
    assert "\n" not in str(caught.value)
