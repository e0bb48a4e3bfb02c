"""The judge of real flips sees what was done to a leg, and nothing in a leg that only walks."""

import json
import sys

import numpy as np
import pytest

from benchmarks import real_flips
from benchmarks._limb_poses import Jump, most
from benchmarks.real_flips import judge, judged_file
from tests.conftest import ASSETS
from twistcore.skeleton.motion import Motion, Skeleton, forward_kinematics
from twistcore.skeleton.rotation import conjugate, multiply, normalise, quaternion_from_axis_angle

FRAMES, START, STOP = 60, 20, 30
NAMES = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase")
HIP, KNEE, ANKLE = 1, 2, 3
X = np.array([1.0, 0.0, 0.0])


def walking(fps=120.0):
    """A leg that swings and bends by a few degrees a frame."""
    skeleton = Skeleton(
        NAMES,
        np.arange(-1, 4),
        np.array([[0, 9, 0], [1, 0, 0], [0, -4, 0], [0, -4, 0], [0, -0.5, 1.5]], dtype=float),
        ((4, (0.0, 0.0, 0.5)),),
    )
    t = np.linspace(0.0, 4.0, FRAMES)
    q = np.zeros((FRAMES, len(NAMES), 4))
    q[..., 0] = 1.0
    q[:, HIP] = quaternion_from_axis_angle(X, -0.5 - 0.3 * np.sin(t))
    q[:, KNEE] = quaternion_from_axis_angle(X, 0.9 + 0.3 * np.sin(t + 1.0))
    q[:, ANKLE] = quaternion_from_axis_angle(X, 0.2 * np.sin(t))
    return Motion(skeleton, q, (), np.zeros((FRAMES, 0, 3)), 1.0 / fps)


def turned(motion, joint, axis, degrees, frames):
    """The motion with a joint turned about an axis of its own in some frames."""
    q = motion.rotations.copy()
    turn = quaternion_from_axis_angle(axis, np.radians(degrees))
    q[frames, joint] = multiply(q[frames, joint], turn)
    return motion.with_rotations(q)


def flipped(motion, degrees=180.0, kept=True):
    """The leg turned about the line from hip to ankle; kept: the foot is as it was."""
    world, at = forward_kinematics(motion)
    line = normalise(at[:, ANKLE] - at[:, HIP])  # the hips stand as the world does
    q = motion.rotations.copy()
    some = slice(START, STOP)
    q[some, HIP] = multiply(
        quaternion_from_axis_angle(line[some], np.radians(degrees)), q[some, HIP]
    )
    if kept:
        shin = multiply(q[some, HIP], q[some, KNEE])
        q[some, ANKLE] = multiply(conjugate(shin), world[some, ANKLE])
    return motion.with_rotations(q)


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_a_walk_has_nothing(fps):
    found = judge("walk", walking(fps), walking(fps), 6)
    assert found.limbs == 1
    assert not any(found.row)
    assert not found.harmed


@pytest.mark.parametrize("kept", [True, False])
@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_a_flip_is_two_swivels_and_a_knee_backward(kept, fps):
    found = judge("flip", flipped(walking(fps), kept=kept), walking(fps), 6)
    assert [(j.of, j.frame) for j in found.swivels_before] == [
        ("LeftUpLeg", START),
        ("LeftUpLeg", STOP),
    ]
    assert found.backward_before == {"LeftUpLeg": list(range(START, STOP))}
    assert {"LeftUpLeg", "LeftLeg"} <= {j.of for j in found.turns_old}
    assert ("LeftFoot" in {j.of for j in found.turns_old}) is not kept
    assert not found.swivels_after
    assert not found.backward_after
    assert not found.turns_left
    assert not found.harmed


def test_where_the_side_was_before_counts_afterwards_too():
    everywhere = flipped(walking())
    found = judge("flip", walking(), everywhere, 6)
    assert found.backward_after == {"LeftUpLeg": list(range(START, STOP))}
    assert found.changed_clean
    assert found.c_moved > 0.05
    assert found.e_moved == 0.0
    assert {j.frame for j in found.turns_new} == {START, STOP}


@pytest.mark.parametrize(("degrees", "moves"), [(1e-7, False), (1e-5, True), (1.0, True)])
def test_an_ankle_that_moves_beyond_the_decimals_is_seen(degrees, moves):
    found = judge("walk", walking(), turned(walking(), HIP, X, degrees, [40]), 6)
    assert (found.e_moved > 0.0) is moves
    assert found.changed_clean is moves
    assert found.harmed is moves


def test_a_foot_that_spins_is_new_once():
    bone = normalise(np.array([0.0, -0.5, 1.5]))
    spun = turned(walking(), ANKLE, bone, 100.0, [40])
    new = judge("walk", walking(), spun, 6).turns_new
    assert [j for j in new if j.of == "LeftFoot"] == [
        Jump("LeftFoot", 40, 100.0),
        Jump("LeftFoot", 41, -100.0),
    ]
    again = judge("walk", spun, spun, 6)
    assert not again.turns_new
    assert again.turns_left == again.turns_old == new


@pytest.mark.parametrize(("fps", "degrees"), [(240, 60), (120, 62.5), (60, 125), (30, 120)])
def test_what_a_body_can_do_depends_on_the_rate(fps, degrees):
    assert most(fps) == degrees


def test_the_sample_holds_six_flips_of_the_right_leg():
    found = judged_file(ASSETS / "kick.bvh", "kick")
    frames = [j.frame for j in found.swivels_before]
    assert frames == [14, 31, 34, 37, 38, 42, 45, 52, 73, 76, 174, 177]
    backward = [range(a, b) for a, b in zip(frames[::2], frames[1::2], strict=True)]
    assert found.backward_before == {"RightUpLeg": [t for part in backward for t in part]}


def test_a_file_that_cannot_be_read_is_listed(tmp_path, monkeypatch, capsys):
    (tmp_path / "broken.bvh").write_text("no motion")
    (tmp_path / "walk.bvh").write_bytes((ASSETS / "walk.bvh").read_bytes())
    output = tmp_path / "found.json"
    monkeypatch.setattr(sys, "argv", ["real_flips", str(tmp_path), "--json", str(output)])
    assert real_flips.main() == 0
    told = capsys.readouterr().out
    assert "broken: not judged" in told
    assert "1 clips, 4 limbs, 344 frames" in told
    found = json.loads(output.read_text("utf-8"))
    assert [c["clip"] for c in found["clips"]] == ["walk"]
    assert list(found["not_judged"]) == ["broken"]
