"""Rigs of the benchmark move as CMU's does, and an error on one of them is counted once."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks import rigs
from benchmarks._rig_families import RIGS
from benchmarks._rigs import CHAINED, bone_pairs, piece_pairs, rigged, shared_joints
from benchmarks.rigs import Pair, Place, counted, drawn, variants, with_errors
from twistcore.analysis.clip_analysis import analyse
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    twist_angle,
)

EVERY = [variant for rig in RIGS for variant in variants(rig)]
BY_NAME = {rig.name: rig for rig in RIGS}
X = np.array([1.0, 0.0, 0.0])
START, STOP, OFFSET = 150, 165, 1.0


@pytest.fixture(scope="module")
def short_walk(walk):
    return walk.motion.sliced(1, walk.motion.frames)


@pytest.fixture(scope="module")
def genesis(short_walk):
    """Daz Genesis with half of the roll in first pieces, and its pairs."""
    rig = replace(BY_NAME["Daz Genesis 3/8"], share=0.5)
    made = rigged(short_walk, rig)
    pairs = [Pair(*pair, (side, "Leg" in role)) for (side, role), pair in of(made, rig)]
    return rig, made, pairs


def of(made, rig):
    return bone_pairs(made, rig).items()


@pytest.mark.parametrize("rig", EVERY, ids=lambda rig: f"{rig.name} {rig.share}")
def test_shared_joints_keep_their_places_in_the_room(short_walk, rig):
    made = rigged(short_walk, rig)
    turned, places = forward_kinematics(short_walk)
    made_turned, made_places = forward_kinematics(made)
    shared = shared_joints(short_walk, rig)
    assert len(shared) >= 22
    for name, cmu in shared.items():
        here, there = made.skeleton.index(name), short_walk.skeleton.index(cmu)
        np.testing.assert_allclose(made_places[:, here], places[:, there], atol=1e-9)
        if cmu.endswith(("Hand", "ToeBase", "Head")):  # the last pieces have the whole roll
            angle = geodesic_angle(made_turned[:, here], turned[:, there])
            assert angle.max() < 1e-7


@pytest.mark.parametrize("rig", EVERY, ids=lambda rig: f"{rig.name} {rig.share}")
def test_every_joint_of_a_limb_and_every_piece_has_its_pair(short_walk, rig):
    made = rigged(short_walk, rig)
    pairs = bone_pairs(made, rig)
    pieces = [rig.pieces(role, 0) for role in CHAINED]
    assert len(set(pairs.values())) == 10
    assert len(piece_pairs(made, rig)) == 2 * sum(len(names) - 1 for names in pieces)
    for parent, child in (*pairs.values(), *(pair for pair, _ in piece_pairs(made, rig))):
        assert made.skeleton.parents[child] == parent


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_the_first_piece_has_its_share_of_the_roll(short_walk, share):
    made = rigged(short_walk, replace(BY_NAME["Daz Genesis 3/8"], share=share))
    whole = twist_angle(short_walk.rotations[:, short_walk.skeleton.index("LeftArm")], X)
    first, second = (made.skeleton.index(name) for name in ("lShldrBend", "lShldrTwist"))
    assert np.abs(whole).max() > 0.1
    np.testing.assert_allclose(twist_angle(made.rotations[:, first], X), share * whole, atol=1e-9)
    rest = (1.0 - share) * whole
    np.testing.assert_allclose(twist_angle(made.rotations[:, second], X), rest, atol=1e-9)


def test_the_forearm_takes_pronation_over_from_the_hand(short_walk):
    hand = twist_angle(short_walk.rotations[:, short_walk.skeleton.index("RightHand")], X)
    assert np.abs(hand).max() > 0.1
    made = rigged(short_walk, replace(BY_NAME["Qualisys"], share=0.0))
    kept = twist_angle(made.rotations[:, made.skeleton.index("RightHand")], X)
    np.testing.assert_allclose(kept, 0.0, atol=1e-9)


def test_an_error_turns_p_and_its_children_and_nothing_below(genesis):
    _, made, pairs = genesis
    k = next(k for k, pair in enumerate(pairs) if made.skeleton.names[pair.child] == "lForearmBend")
    dirty = with_errors(made, pairs, [Place(k, START, STOP, OFFSET)])
    changed = geodesic_angle(made.rotations, dirty.rotations) > 1e-9
    assert {made.skeleton.names[j] for j in np.flatnonzero(changed.any(axis=0))} == {
        "lShldrTwist",
        "lForearmBend",
    }
    assert np.flatnonzero(changed.any(axis=1)).tolist() == list(range(START, STOP))
    before, after = forward_kinematics(made), forward_kinematics(dirty)
    np.testing.assert_allclose(after[1], before[1], atol=1e-9)


def test_a_repaired_error_in_a_chain_with_twist_bones_is_counted(genesis):
    rig, made, pairs = genesis
    k = next(k for k, pair in enumerate(pairs) if made.skeleton.names[pair.child] == "lForearmBend")
    count = counted(made, pairs, [Place(k, START, STOP, OFFSET)], rig, "walk")
    assert (count.errors, count.repaired, count.frames) == (1, 1, STOP - START)
    assert count.repaired_frames == count.exact_frames == STOP - START
    assert (count.made_wrong, count.missed, count.chains) == (0, (), 10)


def test_what_is_not_repaired_and_what_is_made_wrong_is_counted(genesis, monkeypatch):
    rig, made, pairs = genesis
    nothing = analyse(made, []).detect()
    wrong = quaternion_from_axis_angle(X, 0.1)

    def spoil(dirty):
        rotations = dirty.rotations.copy()
        rotations[10:13, 0] = multiply(rotations[10:13, 0], wrong)
        return dirty.with_rotations(rotations), nothing

    monkeypatch.setattr(rigs, "corrected", spoil)
    count = counted(made, pairs, [Place(0, START, STOP, OFFSET)], rig, "walk")
    assert (count.errors, count.repaired, count.repaired_frames) == (1, 0, 0)
    assert (count.made_wrong, count.chains, count.pairs) == (3, 0, 10)
    assert count.missed[0].why == "no chain of the pair"
    assert count.missed[0].degrees == pytest.approx(np.degrees(OFFSET))


@pytest.mark.parametrize("seed", range(5))
def test_errors_of_a_limb_are_apart_and_inside_of_the_clip(seed):
    limbs = [(0, False), (0, True), (1, False), (0, False)]
    places = drawn(limbs, 400, 20, np.random.default_rng(seed))
    assert len(places) == 20
    for one in places:
        assert rigs.EDGE <= one.start < one.stop <= 400 - rigs.EDGE
        assert one.stop - one.start <= rigs.LONGEST
        assert np.radians(15) <= abs(one.offset) <= np.radians(150)
        for other in places:
            if other is not one and limbs[one.pair] == limbs[other.pair]:
                assert one.start >= other.stop + rigs.APART or other.start >= one.stop + rigs.APART


def test_there_are_no_errors_where_there_is_no_room():
    assert drawn([], 400, 5, np.random.default_rng(0)) == []
    assert drawn([(0, False)], 5, 5, np.random.default_rng(0)) == []
