"""The view of a limb is one in which no other bone hides it."""

import numpy as np
import pytest

from inspector.viewport.limb_side import best_limb_error_view
from inspector.viewport.occlusion import Occluders
from inspector.viewport.scene import find_bones
from tests.gui.pictures import INJECTED
from twistcore import read_clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import rotate

AXES = np.vstack([np.eye(3), -np.eye(3)])


def test_a_rod_hides_what_is_behind_it():
    rod = Occluders(np.array([[1.0, -1.0, 0.0]]), np.array([[1.0, 1.0, 0.0]]), np.array([0.1]))
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 0.5]])
    # From +x the rod is before two of four points; the third is above it, the fourth is aside.
    assert rod.hidden_share(points, AXES).tolist() == [0.5, 0.0, 0.0, 0.0, 0.0, 0.0]


def test_no_bones_hide_nothing():
    none = Occluders(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    assert none.hidden_share(np.zeros((2, 3)), AXES).tolist() == [0.0] * 6


@pytest.mark.parametrize("name", ["LeftUpLeg", "RightUpLeg", "LeftLeg", "LeftForeArm", "RightArm"])
def test_the_chosen_view_shows_the_limb(name):
    motion = read_clip(INJECTED).motion
    rotations, positions = forward_kinematics(motion)
    chains = find_chains(motion)
    up, height = (
        guess_up(positions, chains, motion.skeleton),
        figure_size(positions, motion.skeleton),
    )
    bones = find_bones(motion, up, height)
    chain = next(c for c in chains if c.name == name)
    parents = [b.parent for b in bones]
    tips = np.array([b.tip for b in bones])
    others = [k for k, b in enumerate(bones) if b.parent not in (chain.parent, chain.child)]
    shares = []
    for frame in range(0, len(positions), 15):
        pose = rotations[frame], positions[frame]
        facing = figure_facing_direction(pose[1], chains, up)
        side = best_limb_error_view(
            chain, bones, pose, pose, facing, up, skeleton=motion.skeleton, height=height
        )
        ends = pose[1][parents] + rotate(pose[0][parents], tips)
        rods = Occluders(
            pose[1][parents][others], ends[others], np.full(len(others), 0.02 * height)
        )
        start, stop = pose[1][[chain.parent, chain.child]]
        points = start + np.linspace(0.1, 0.9, 9)[:, None] * (stop - start)
        shares.append(rods.hidden_share(points, side.direction[None])[0])
    assert np.mean(shares) < 0.05
    assert max(shares) <= 0.34
