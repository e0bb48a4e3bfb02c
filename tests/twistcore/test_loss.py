"""The loss: what it is zero for, what it charges, and that following it repairs."""

import numpy as np
from hypothesis import given
from scipy.optimize import minimize

from tests.conftest import ASSETS
from tests.twistcore.strategies import axes, quaternions
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import conjugate, multiply, quaternion_from_axis_angle, twist_angle
from twistcore.study.loss import twist_consistency_loss
from twistcore.synthesis import InjectedError, inject

WALK = read_bvh(ASSETS / "walk.bvh")
CHAIN = next(c for c in find_chains(WALK.motion) if c.name == "LeftArm")


@given(quaternions, quaternions, quaternions, quaternions, axes)
def test_increments_are_those_of_the_relative_rotations(p0, p1, c0, c1, a):
    q_p, q_c = np.stack([p0, p1]), np.stack([c0, c1])
    x = twist_angle(multiply(conjugate(p0), p1), a)
    y = twist_angle(multiply(c1, conjugate(c0)), a)
    expected = max(0.0, -x * y) / np.sqrt(x * x + y * y + 1e-6)
    loss = twist_consistency_loss(q_p, q_c, a)
    if min(abs(multiply(conjugate(p0), p1)[0]), abs(multiply(c1, conjugate(c0))[0])) > 1e-6:
        assert abs(loss - expected) < 1e-7
        assert abs(twist_consistency_loss(-q_p, q_c, a) - loss) < 1e-12


def test_an_error_costs_its_two_edges():
    error = InjectedError("LeftArm", 100, 110, np.full(10, 1.0))
    dirty = inject(WALK.motion, find_chains(WALK.motion), [error])

    def loss(m):
        q = m.rotations
        return twist_consistency_loss(q[1:, CHAIN.parent], q[1:, CHAIN.child], CHAIN.axis)

    gained = (loss(dirty) - loss(WALK.motion)) * (WALK.motion.frames - 2)
    assert abs(gained - 2 * 1.0 / np.sqrt(2)) < 0.05


def test_following_the_loss_downhill_finds_the_offset():
    """The example of the docs: one unknown offset, found by a minimiser from the loss alone."""
    q_p, q_c = WALK.motion.rotations[1:, CHAIN.parent], WALK.motion.rotations[1:, CHAIN.child]
    at = np.zeros(len(q_p))
    at[100:110] = 1.0

    def twisted(delta):
        return (
            multiply(q_p, quaternion_from_axis_angle(CHAIN.axis, at * delta)),
            multiply(quaternion_from_axis_angle(CHAIN.axis, -at * delta), q_c),
        )

    found = minimize(lambda d: twist_consistency_loss(*twisted(0.8 - d[0]), CHAIN.axis), [0.0])
    assert abs(found.x[0] - 0.8) < 0.05
