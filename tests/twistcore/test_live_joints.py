"""The experiment on silent joints: what it takes away, and what it leaves."""

from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.live_joints import known_edges, quietened
from tests.conftest import ASSETS
from twistcore.detection.counter_twist import counter_rotation
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.twist_increments import twist_increments
from twistcore.synthesis import InjectedError

WALK = read_bvh(ASSETS / "walk.bvh").motion
CHAINS = find_chains(WALK)


def increments(motion):
    return np.array(
        [
            twist_increments(motion.rotations[:, c.parent], motion.rotations[:, c.child], c.axis)
            for c in CHAINS
        ]
    ).swapaxes(0, 1)


@pytest.mark.parametrize("share", [0.0, 0.5])
@pytest.mark.parametrize(("joint", "signal"), [("parent", 0), ("child", 1)])
def test_one_signal_of_every_chain_is_scaled(joint, signal, share):
    quiet = increments(quietened(WALK, CHAINS, joint, share))[signal]
    np.testing.assert_allclose(quiet, share * increments(WALK)[signal], atol=1e-9)


def test_known_edges_are_no_motion_and_the_detector_is_as_before_afterwards():
    usual = counter_rotation._coarsely_good
    error = InjectedError(CHAINS[1].name, 50, 55, np.array([0.1, 0.2, 0.2, 0.2, 0.1]))
    signals, live = np.zeros((2, 2, 100)), np.ones((2, 100), dtype=bool)
    plain = SimpleNamespace(step=0.0, keys=None)
    with known_edges(CHAINS[:2], [error]):
        good = counter_rotation._coarsely_good(signals, live, 12, plain)
    assert np.flatnonzero(~good[1]).tolist() == [50, 51, 54, 55]
    assert good[0].all()
    assert counter_rotation._coarsely_good is usual
