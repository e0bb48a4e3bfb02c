"""What may be taken out unasked, and what is taken out, on a limb of four joints."""

from dataclasses import replace

import numpy as np
import pytest

from twistcore.analysis.correction.twist_removal import (
    automatic_corrections,
    children_off_axis,
    joints_lacking_channels,
    offsets_by_chain,
    offsets_carried_to_child,
    refine,
    remove_twist,
)
from twistcore.detection import Interval, Kind
from twistcore.skeleton.chain import make_chain
from twistcore.skeleton.limb import as_limb
from twistcore.skeleton.motion import Motion, Skeleton, forward_kinematics
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    twist_angle,
    wrap,
)

NAMES = ("Hips", "Thigh", "Shin", "Foot", "Beside")
OFFSETS = np.array([[0, 9, 0], [1, 0, 0], [0, -4, 0], [0, -3, 1], [0.5, -1, 0]], dtype=float)
FRAMES = 7


def interval(chain, start, stop, offset=0.5, **more):
    return Interval(chain, start, stop, np.full(stop - start, offset), **more)


def leg(rotatable=None):
    skeleton = Skeleton(NAMES, np.array([-1, 0, 1, 2, 1]), OFFSETS)
    if rotatable is not None:
        skeleton = replace(skeleton, rotatable=np.array(rotatable))
    rotations = normalise(np.random.default_rng(3).normal(size=(FRAMES, 5, 4)))
    return Motion(skeleton, rotations, (), np.zeros((FRAMES, 0, 3)), 0.1)


def chain_of(motion):
    return make_chain(motion, 1, 2, 3)


def test_what_may_be_corrected_without_a_person_s_word():
    sure, half, faint, unknown = (interval("A", 0, 2, confidence=c) for c in (0.9, 0.5, 0.49, None))
    is_open = interval("A", 0, 2, confidence=1.0, open=True)
    jump = interval("A", 0, 2, confidence=1.0, kind=Kind.LONE_JUMP)
    everything = (sure, half, faint, unknown, is_open, jump)
    assert automatic_corrections(everything) == (sure, half, unknown)
    assert automatic_corrections(everything, 0.9) == (sure,)
    assert automatic_corrections(everything, 0.0) == (sure, half, faint, unknown)
    assert automatic_corrections(everything, 0.95, include_open=True) == (is_open,)
    assert automatic_corrections(everything, confidence=lambda _: None) == (
        sure,
        half,
        faint,
        unknown,
    )
    assert automatic_corrections(everything, confidence=lambda _: 0.4) == ()


def test_offsets_of_a_chain_add_up_to_the_shorter_way_round():
    found = [interval("A", 1, 4, 2.0), interval("A", 3, 6, 2.0), interval("B", 0, 2, 0.1)]
    sums = offsets_by_chain(found, FRAMES)
    np.testing.assert_allclose(sums["A"], [0, 2, 2, 4 - 2 * np.pi, 2, 2, 0])
    np.testing.assert_allclose(sums["B"], [0.1, 0.1, 0, 0, 0, 0, 0])
    flip = interval("A", 0, 1, 1.0, carried=True)
    carried = offsets_carried_to_child([*found, flip], FRAMES)
    assert list(carried) == ["A"]
    np.testing.assert_allclose(carried["A"], [1, 0, 0, 0, 0, 0, 0])


def test_a_twist_is_taken_out_of_the_parent_and_of_nothing_else():
    motion = leg()
    chain = chain_of(motion)
    after = refine(motion, [chain], [interval("Thigh", 2, 5), interval("Unknown", 0, 7)])
    np.testing.assert_array_equal(after.rotations[[0, 1, 5, 6]], motion.rotations[[0, 1, 5, 6]])
    np.testing.assert_array_equal(after.rotations[:, [0, 3]], motion.rotations[:, [0, 3]])
    turned, there = forward_kinematics(after)
    was, before = forward_kinematics(motion)
    np.testing.assert_allclose(there[:, :4], before[:, :4], atol=1e-12)
    assert geodesic_angle(turned[:, [0, 2, 3, 4]], was[:, [0, 2, 3, 4]]).max() < 1e-7
    lost = wrap(
        twist_angle(motion.rotations[:, 1], chain.axis)
        - twist_angle(after.rotations[:, 1], chain.axis)
    )
    np.testing.assert_allclose(lost, [0, 0, 0.5, 0.5, 0.5, 0, 0], atol=1e-9)


def test_chains_without_an_offset_are_passed_over():
    motion = leg()
    chain = chain_of(motion)
    idle, still = as_limb(motion, chain), replace(chain, name="Still")
    offset = np.where(np.arange(FRAMES) > 3, 0.5, 0.0)
    alone = remove_twist(motion, [chain], {"Thigh": offset})
    found = remove_twist(motion, [idle, still, chain], {"Thigh": offset, "Still": 0.0 * offset})
    np.testing.assert_array_equal(found.rotations, alone.rotations)
    assert (found.rotations != motion.rotations).any()
    both = remove_twist(motion, [idle, chain], {idle.name: offset[::-1], "Thigh": offset})
    first = remove_twist(motion, [idle], {idle.name: offset[::-1]})
    second = remove_twist(first, [chain], {"Thigh": offset})
    np.testing.assert_array_equal(both.rotations, second.rotations)


@pytest.mark.parametrize("carried", [False, True])
def test_a_limb_turns_about_its_line_and_its_end_keeps_its_place(carried):
    motion = leg()
    limb = as_limb(motion, chain_of(motion))
    flip = interval(limb.name, 2, 5, kind=Kind.LIMB_FLIP, carried=carried)
    after = refine(motion, [limb], [flip])
    np.testing.assert_array_equal(after.rotations[[0, 1, 5, 6]], motion.rotations[[0, 1, 5, 6]])
    np.testing.assert_array_equal(after.rotations[:, [0, 2, 4]], motion.rotations[:, [0, 2, 4]])
    (turned, there), (was, before) = forward_kinematics(after), forward_kinematics(motion)
    np.testing.assert_allclose(there[:, [0, 1, 3]], before[:, [0, 1, 3]], atol=1e-12)
    at = slice(2, 5)
    line = normalise(before[at, 3] - before[at, 1])
    back = quaternion_from_axis_angle(line, -0.5)
    assert geodesic_angle(turned[at, 1], multiply(back, was[at, 1])).max() < 1e-7
    end = multiply(back, was[at, 3]) if carried else was[at, 3]
    assert geodesic_angle(turned[at, 3], end).max() < 1e-7
    if carried:
        np.testing.assert_array_equal(after.rotations[:, 3], motion.rotations[:, 3])


def test_in_one_limb_one_flip_may_carry_the_end_and_another_not():
    motion = leg()
    limb = as_limb(motion, chain_of(motion))
    both = [
        interval(limb.name, 0, 3, 0.4, kind=Kind.LIMB_FLIP, carried=True),
        interval(limb.name, 2, 5, 0.3, kind=Kind.LIMB_FLIP),
    ]
    one_by_one = refine(refine(motion, [limb], both[:1]), [limb], both[1:])
    together = refine(motion, [limb], both)
    assert geodesic_angle(together.rotations, one_by_one.rotations).max() < 1e-7


def test_a_folded_limb_has_no_line_and_stays():
    offsets = OFFSETS.copy()
    offsets[3] = -offsets[2]
    motion = leg()
    motion = replace(motion, skeleton=replace(motion.skeleton, offsets=offsets))
    limb = as_limb(motion, chain_of(motion))
    rotations = motion.rotations.copy()
    rotations[:4, 2] = [1.0, 0.0, 0.0, 0.0]  # the end lies on the first joint
    motion = motion.with_rotations(rotations)
    after = refine(motion, [limb], [interval(limb.name, 0, 7, kind=Kind.LIMB_FLIP)])
    np.testing.assert_array_equal(after.rotations[:4], motion.rotations[:4])
    assert (geodesic_angle(after.rotations[4:, 1], motion.rotations[4:, 1]) > 0.4).all()


def test_what_cannot_be_turned_stays_and_is_named():
    motion = leg([True, True, False, True, True])  # the shin has no three channels
    chain = chain_of(motion)
    limb = as_limb(motion, chain)
    own = interval("Thigh", 0, 7)
    assert joints_lacking_channels(motion, chain, [own]) == ("Shin",)
    assert joints_lacking_channels(motion, chain, [interval("Other", 0, 7)]) == ()
    assert refine(motion, [chain], [own]).rotations.tolist() == motion.rotations.tolist()
    flip = interval(limb.name, 0, 7, kind=Kind.LIMB_FLIP)
    assert joints_lacking_channels(motion, limb, [flip]) == ()
    assert (refine(motion, [limb], [flip]).rotations[:, 1] != motion.rotations[:, 1]).any()

    motion = leg([True, True, True, False, True])  # the end: fine only where it was carried
    limb = as_limb(motion, chain_of(motion))
    flip = interval(limb.name, 0, 3, kind=Kind.LIMB_FLIP)
    carried = interval(limb.name, 4, 6, kind=Kind.LIMB_FLIP, carried=True)
    assert joints_lacking_channels(motion, limb, [flip, carried]) == ("Foot",)
    assert joints_lacking_channels(motion, limb, [carried]) == ()
    after = refine(motion, [limb], [flip, carried])
    changed = (after.rotations != motion.rotations).any(axis=(1, 2))
    assert changed.tolist() == [False] * 4 + [True] * 2 + [False]
    offsets = offsets_by_chain([flip, carried], FRAMES)
    parts = remove_twist(motion, [limb], offsets, offsets_carried_to_child([carried], FRAMES))
    np.testing.assert_array_equal(parts.rotations, after.rotations)
    untold = remove_twist(motion, [limb], offsets)
    np.testing.assert_array_equal(untold.rotations, motion.rotations)

    motion = leg([True, False, True, True, True])  # the first joint: never
    limb = as_limb(motion, chain_of(motion))
    assert joints_lacking_channels(motion, limb, [carried]) == ("Thigh",)
    after = remove_twist(motion, [limb], offsets, offsets)
    np.testing.assert_array_equal(after.rotations, motion.rotations)


def test_a_bone_with_positions_is_turned_about_where_it_is_in_each_frame():
    motion = leg()
    rng = np.random.default_rng(5)
    place = OFFSETS[2] + 0.02 * rng.normal(size=(FRAMES, 3))  # less than 1° of its direction
    motion = replace(motion, positioned=(2,), positions=place[:, None])
    chain = chain_of(motion)
    assert chain.axis.ndim == 1
    after = refine(motion, [chain], [interval("Thigh", 0, 7)])
    was, there = forward_kinematics(motion)[1], forward_kinematics(after)[1]
    np.testing.assert_allclose(there[:, :4], was[:, :4], atol=1e-12)
    # A place of no length has no direction: the chain's own axis is taken.
    place = np.where(np.arange(FRAMES)[:, None] == 3, 0.0, place)
    motion = replace(motion, positions=place[:, None])
    after = remove_twist(motion, [chain], {"Thigh": np.full(FRAMES, 0.5)})
    lost = twist_angle(motion.rotations[:, 1], chain.axis) - twist_angle(
        after.rotations[:, 1], chain.axis
    )
    np.testing.assert_allclose(wrap(lost), 0.5, atol=1e-9)


def test_children_beside_the_bone_are_named_with_their_distance():
    motion = leg()
    chain = chain_of(motion)
    assert children_off_axis(motion, chain) == {"Beside": pytest.approx(0.5)}
    assert children_off_axis(motion, as_limb(motion, chain)) == {}
    for sideways, named in ((0.008, False), (0.0095, True)):  # half a degree: 0.0087 of its length
        for far in (0.3, 1.0, 3.0):
            offsets = OFFSETS.copy()
            offsets[4] = (sideways * far, -far, 0.0)
            beside = replace(motion, skeleton=replace(motion.skeleton, offsets=offsets))
            assert ("Beside" in children_off_axis(beside, chain_of(beside))) is named
    offsets = OFFSETS.copy()
    offsets[4] = 0.0
    at_parent = replace(motion, skeleton=replace(motion.skeleton, offsets=offsets))
    assert children_off_axis(at_parent, chain_of(at_parent)) == {}
