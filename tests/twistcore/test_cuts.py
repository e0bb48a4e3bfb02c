"""Cuts are told by the bends of most joints: no error of chains is one, and none hides one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore import detect
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import Kind
from twistcore.detection.bends import bend_steps
from twistcore.detection.cuts import find_cuts
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.synthesis import InjectedError, inject

FILE = read_bvh(ASSETS / "walk.bvh").motion
WALK = FILE.sliced(1, FILE.frames)
CHAINS = find_chains(WALK)
LIMBS = find_limbs(WALK, CHAINS)
SIX = [c for c in CHAINS if c.segment in ("Shoulder", "ForeArm", "Leg")]  # none share a joint
# A walk is cut where the left leg is in front, to where the right one is.
SPLICE = np.concatenate([np.arange(60, 150), np.arange(210, 300)])


def level(chain, start, stop, degrees):
    return InjectedError(chain.name, start, stop, np.full(stop - start, np.radians(degrees)))


def at_once(spans, degrees=60.0):
    return [
        level(chain, start, stop, degrees + 10.0 * k)
        for k, chain in enumerate(SIX)
        for start, stop in spans
    ]


def flips(spans, carried=False):
    return [
        replace(level(limb, start, stop, 120.0), kind=Kind.LIMB_FLIP, carried=carried)
        for limb in LIMBS
        for start, stop in spans
    ]


def cuts(motion):
    return np.flatnonzero(find_cuts(motion)).tolist()


def test_a_pose_in_front_of_the_capture_is_one():
    assert cuts(FILE) == [1]


def test_chains_wrong_in_the_same_frames_are_none_and_found():
    assert len(SIX) == 6
    errors = at_once([(60, 75), (120, 121), (200, 220)])
    wrong = inject(WALK, CHAINS, errors)
    assert cuts(wrong) == []
    found = {
        (i.chain, i.start, i.stop)
        for i in automatic_corrections(detect(wrong, kinds="counter-twist"))
    }
    assert {(e.chain, e.start, e.stop) for e in errors} <= found


def test_errors_bend_nothing():
    wrong = inject(WALK, CHAINS, [level(c, 60, 75, 150.0) for c in CHAINS])
    assert cuts(wrong) == []
    np.testing.assert_allclose(bend_steps(wrong), bend_steps(WALK), atol=1e-6)
    assert np.abs(wrong.rotations - WALK.rotations).max() > 0.5


@pytest.mark.parametrize("carried", [False, True])
def test_limbs_flipped_in_the_same_frames_are_none(carried):
    assert cuts(inject(WALK, (*CHAINS, *LIMBS), flips([(60, 75), (120, 124)], carried))) == []


def test_a_cut_is_found_whatever_is_wrong_beside_it():
    spliced = WALK.at(SPLICE)
    errors = at_once([(84, 90), (90, 97), (40, 44)]), flips([(82, 96)]), at_once([(90, 91)])
    assert cuts(spliced) == [90]
    for some in errors:
        assert cuts(inject(spliced, (*CHAINS, *LIMBS), some)) == [90]


def test_position_channels_say_where_the_bones_are():
    joints = tuple(range(len(WALK.skeleton)))
    offsets = np.tile(WALK.skeleton.offsets, (WALK.frames, 1, 1))
    offsets[:, 0] = WALK.positions[:, 0]
    same = replace(WALK, positioned=joints, positions=offsets)
    np.testing.assert_allclose(bend_steps(same), bend_steps(WALK), atol=1e-6)
    nothing = replace(same, skeleton=replace(same.skeleton, offsets=0.0 * offsets[0], ends=()))
    assert len(bend_steps(nothing)) > 10
    assert cuts(nothing.at(SPLICE)) == [90]
    still = replace(same, rotations=np.tile(WALK.rotations[:1], (WALK.frames, 1, 1)))
    moving = offsets.copy()
    knee = next(c for c in CHAINS if c.segment == "Leg").grandchild
    moving[100:, knee] = moving[100:, knee, ::-1]
    assert bend_steps(still).max() < 1e-6
    assert np.flatnonzero(bend_steps(replace(still, positions=moving)).max(axis=0) > 0.1) == [99]


def test_a_skeleton_without_bones_has_roots_alone():
    point = replace(FILE.skeleton, offsets=0.0 * FILE.skeleton.offsets, ends=())
    assert bend_steps(replace(FILE, skeleton=point)).shape == (1, FILE.frames - 1)
    assert cuts(FILE.sliced(0, 1)) == cuts(FILE.sliced(0, 9)) == []
