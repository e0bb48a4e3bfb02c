"""What detection costs: what is loaded, what is computed again, what is kept."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from twistcore.analysis import analyse
from twistcore.bvh import read_bvh
from twistcore.detection import cuts, noise_bursts
from twistcore.detection.cuts import find_cuts
from twistcore.detection.noise_bursts import noise_level, noise_near

ASSETS = Path(__file__).parents[2] / "assets"
_DETECT = """
import sys
from twistcore.cli.command_line import main
assert main(["detect", sys.argv[1]]) == 0
print(sorted({".".join(name.split(".")[:2]) for name in sys.modules}), file=sys.stderr)
"""


def test_detecting_in_an_ordinary_clip_loads_nothing_slow() -> None:
    clip = ASSETS / "walk.bvh"
    done = subprocess.run(
        [sys.executable, "-c", _DETECT, str(clip)], check=True, capture_output=True, text=True
    )
    loaded = done.stderr.splitlines()[-1]
    assert "twistcore.detection" in loaded
    for slow in ("scipy", "twistcore.tuning", "twistcore.review", "twistcore.npz", "twistcore.amc"):
        assert f"'{slow}" not in loaded


def test_cuts_are_sought_once_a_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    steps = cuts.bend_steps
    monkeypatch.setattr(cuts, "bend_steps", lambda motion: calls.append(motion) or steps(motion))
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    assert analyse(motion).detect().notes is not None
    assert sum(one is motion for one in calls) == 1


def test_a_caller_may_change_the_cuts_it_was_given() -> None:
    motion = read_bvh(ASSETS / "walk.bvh").motion
    find_cuts(motion)[:] = True
    assert not find_cuts(motion).all()


def test_noise_of_quiet_joints_takes_no_memory() -> None:
    motion = read_bvh(ASSETS / "walk.bvh").motion
    joints = range(len(motion.skeleton))
    noise_near(motion, joints)
    kept = [noise_bursts._of_joint(motion, joint) for joint in joints]
    assert all(one.strides == (0,) for one in kept)


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0])
def test_a_quick_look_leaves_out_no_noise(fps: float, monkeypatch: pytest.MonkeyPatch) -> None:
    rng, some = np.random.default_rng(1), 0
    looks = [noise_bursts._often, lambda _mask, _width: True]
    for trial in range(60):
        turns = rng.normal(size=(300, 3)) * rng.uniform(1.0, 9.0)
        turns[: rng.integers(300)] *= 0.1
        turns = np.diff(turns, axis=0, prepend=0.0) if trial % 2 else turns
        found = []
        for look in looks:
            monkeypatch.setattr(noise_bursts, "_often", look)
            found.append(noise_level(turns, fps))
        assert np.array_equal(*found)
        some += found[0].any()
    assert 5 < some < 55
