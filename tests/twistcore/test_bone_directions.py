"""Which bones have a direction: how short is nothing, and what position channels do to it."""

import numpy as np
import pytest

from tests.messages import names_in_one_line
from twistcore.skeleton.body import has_bone_offset_direction
from twistcore.skeleton.chain import (
    Chain,
    find_chains,
    group_connected_chains,
    make_chain,
    uncorrectable_joints,
)
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion, Skeleton

NOTHING = 1e-6  # of the height
HEIGHTS = [1e-3, 1e3]


def still(offsets, parents, *, names=None, ends=(), frames=4, rotatable=None, **places):
    """A motion at rest; places: where position channels put a joint, by 'j' and its number."""
    names = tuple(names or (f"j{k}" for k in range(len(parents))))
    offsets = np.array(offsets, dtype=float)
    skeleton = Skeleton(names, np.array(parents), offsets, tuple(ends), rotatable)
    rotations = np.zeros((frames, len(parents), 4))
    rotations[..., 0] = 1.0
    moved = {int(key[1:]): np.broadcast_to(at, (frames, 3)) for key, at in places.items()}
    positions = np.stack([*moved.values(), np.zeros((frames, 3))], axis=1)[:, : len(moved)]
    return Motion(skeleton, rotations, tuple(moved), positions, 0.01)


def beside(height, offset, **more):
    """A bone from the root to joint 2, beside another as long as the skeleton is high."""
    return still([(0, 0, 0), (0, height, 0), offset], [-1, 0, 0], **more)


@pytest.mark.parametrize("height", HEIGHTS)
def test_an_offset_is_a_bone_from_a_millionth_of_the_height_on(height):
    limit = NOTHING * height
    assert make_chain(beside(height, (limit, 0, 0)), 0, 2) is None
    chain = make_chain(beside(height, (1.5 * limit, 0, 0)), 0, 2)
    np.testing.assert_array_equal(chain.axis, [1.0, 0.0, 0.0])
    assert (chain.side, chain.segment, chain.grandchild, chain.warnings) == ("", "", -1, ())


@pytest.mark.parametrize("height", HEIGHTS)
def test_a_bone_that_vanishes_in_one_frame_has_no_direction(height):
    limit = NOTHING * height
    places = np.full((4, 3), (0.0, 0.0, height))
    for shortest, expected in ((limit, None), (1.5 * limit, [0.0, 0.0, 1.0])):
        places[2] = 0.0, 0.0, shortest
        chain = make_chain(beside(height, (0, 0, 0), j2=places), 0, 2)
        assert (chain and chain.axis.tolist()) == expected
        assert chain is None or chain.warnings == ()
    # The length that OFFSET has is no help where the channels are not next to zero in all frames.
    places[2] = 0.0
    assert make_chain(beside(height, (0, 0, height), j2=places), 0, 2) is None


@pytest.mark.parametrize("height", HEIGHTS)
def test_positions_of_a_hundredth_of_the_offset_are_deltas_from_it(height):
    def chain(length, place):
        motion = beside(height, (length * height, 0, 0), j2=(0, 0, place * height))
        return make_chain(motion, 0, 2)

    x, z = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    for length, place, expected in (
        (0.5, 0.0049, x),
        (0.5, 0.0051, z),
        (4e-6, 0.0, x),
        (4e-6, 0.9e-6, x),  # more than a hundredth, but nothing for a skeleton so high
        (4e-6, 1.1e-6, z),
        (1.1e-6, 0.0, x),
        (0.9e-6, 1.1e-6, z),
    ):
        found = chain(length, place)
        assert found.axis.tolist() == expected, (length, place)
        assert len(found.warnings) == (expected == x)
    assert chain(0.9e-6, 0.9e-6) is None
    assert chain(0.9e-6, 0.0) is None
    exact = make_chain(beside(200.0, (100.0, 0, 0), j2=(0, 0, 1.0)), 0, 2)
    assert exact.axis.tolist() == x
    [warning] = exact.warnings
    assert names_in_one_line(warning, "j2", "OFFSET")


def test_the_longest_of_all_frames_says_whether_positions_are_deltas():
    places = np.zeros((4, 3))
    places[:, 2] = 0.8  # together more than a hundredth of 100, each less
    assert make_chain(beside(200.0, (100.0, 0, 0), j2=places), 0, 2).axis.tolist() == [1, 0, 0]
    places[1, 2] = 50.0
    assert make_chain(beside(200.0, (100.0, 0, 0), j2=places), 0, 2).axis.tolist() == [0, 0, 1]


def test_each_frame_s_length_is_its_own():
    """Short in two frames at once, though together longer than nothing."""
    height = 1000.0
    places = np.full((4, 3), (0.0, 5.0, 0.0))
    places[1:3] = 0.0, 0.8e-3, 0.0
    assert make_chain(beside(height, (0, 0, 0), j2=places), 0, 2) is None


@pytest.mark.parametrize("height", HEIGHTS)
def test_an_end_site_next_to_its_joint_is_no_direction(height):
    def chain(end, segment="Leg"):
        motion = beside(height, (height / 2, 0, 0), ends=((2, (0.0, -end * height, 0.0)),))
        return make_chain(motion, 0, 2, segment=segment)

    assert chain(1.5e-6).arm.tolist() == [0.0, -1.0, 0.0]
    assert chain(0.9e-6).arm.tolist() == [0.0, 0.0, 1.0]
    assert chain(0.5).arm.tolist() == [0.0, -1.0, 0.0]
    assert chain(0.5, "ForeArm").arm.tolist() == [0.0, 0.0, 1.0]


def test_a_grandchild_in_the_child_s_place_is_none():
    offsets = [(0, 0, 0), (0, 5, 0), (0, 0, 0)]
    chain = make_chain(still(offsets, [-1, 0, 1]), 0, 1, 2)
    assert (chain.grandchild, chain.arm.tolist()) == (-1, [0.0, 0.0, 1.0])
    chain = make_chain(still(offsets, [-1, 0, 1], ends=((1, (3.0, 0.0, 0.0)),)), 0, 1, 2)
    assert (chain.grandchild, chain.arm.tolist()) == (-1, [1.0, 0.0, 0.0])


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_hand_s_own_z_serves_from_20_degrees_off_the_bone_on(sign):
    def arm(degrees, sideways):
        angle = np.radians(degrees)
        offset = np.array(sideways) * np.sin(angle) + np.array([0, 0, np.cos(angle)])
        return make_chain(still([(0, 0, 0), sign * 7.0 * offset], [-1, 0]), 0, 1).arm.tolist()

    x, y, z = np.eye(3).tolist()
    for sideways, other in (((1, 0, 0), y), ((-1, 0, 0), y), ((0, -1, 0), x), ((0.6, 0.8, 0), x)):
        assert arm(20.3, sideways) == z
        assert arm(90.0, sideways) == z
        assert arm(19.7, sideways) == other
        assert arm(5.0, sideways) == other


def test_of_a_bone_that_varies_the_first_frame_chooses_the_hand_s_axis():
    places = np.array([(0.0, 1.0, 9.0), (0.0, 9.0, 0.0)])
    for order, expected in ((slice(None), [1.0, 0.0, 0.0]), (slice(None, None, -1), [0, 0, 1.0])):
        moved = still([(0, 0, 0), (0, 9, 0)], [-1, 0], frames=2, j1=places[order])
        chain = make_chain(moved, 0, 1)
        assert chain.axis.shape == (2, 3)
        assert chain.arm.tolist() == expected


def test_a_chain_of_no_known_limb_has_no_side_and_no_warning():
    chain = Chain("a", 0, 1, -1, np.ones(3), np.ones(3))
    assert (chain.side, chain.segment, chain.warnings, chain.label) == ("", "", (), "a")


# -- bones of no length along a line ---------------------------------------------------------------


def arm(height, short, names):
    """A spine and one arm on either side; the joint `short` lies next to the one above it."""
    parents, offsets, every = [-1, 0], [(0, 0, 0), (0, height, 0)], ["hip", "chest"]
    for side in ("Left", "Right"):
        above = 1
        for name in names:
            parents.append(above)
            above = len(every)
            every.append(name.replace("*", side))
            offsets.append((short if name == "*Arm" else height / 9, 0, 0))
    return still(offsets, parents, names=every)


@pytest.mark.parametrize("height", HEIGHTS)
def test_a_joint_next_to_the_one_below_it_is_no_part_of_an_arm(height):
    names = ["*Clavicle", "*Extra", "*Arm", "*ForeArm", "*Hand"]

    def left(short):
        chains = find_chains(arm(height, short * height, names))
        return [(c.segment, c.name) for c in chains if c.side == "Left"]

    lower = [("Arm", "LeftArm"), ("ForeArm", "LeftForeArm")]
    assert left(0.9e-6) == [("Shoulder", "LeftClavicle"), *lower]
    assert left(1.5e-6) == [("Shoulder", "LeftExtra"), *lower]


def lines(second):
    """From a joint below the root two lines of three bones, the second one's of this length."""
    parents = [-1, 0, 1, 2, 3, 1, 5, 6]
    offsets = [(0, 0, 0), (0, 9, 0), *[(0, 1, 0)] * 3, *[(second, 0, 0)] * 3]
    return still(offsets, parents, names="rkabcuvw")


@pytest.mark.parametrize(
    ("length", "expected"), [(1.2e-5, "k a b"), (0.5, "k a b"), (0.7, "a b u v"), (1.0, "a b u v")]
)
def test_a_line_much_shorter_than_the_longest_is_no_limb(length, expected):
    """The longest line is 12: where the second line counts, the joint with both is of the trunk."""
    assert " ".join(c.name for c in find_chains(lines(length))) == expected


def test_a_bone_that_has_length_in_some_frame_counts():
    skeleton = lines(1.0).skeleton
    places = np.zeros((4, 3))
    assert not has_bone_offset_direction(skeleton, places)
    places[2] = 1.3e-5, 0, 0
    assert has_bone_offset_direction(skeleton, places)
    places[2] = 1.1e-5, 0, 0
    assert not has_bone_offset_direction(skeleton, places)


# -- what belongs together -------------------------------------------------------------------------


def test_chains_that_turn_a_joint_in_common_are_a_limb_in_the_order_of_their_last():
    skeleton = still([(0, 1, 0)] * 8, [-1, 0, 1, 2, 0, 4, 5, 6]).skeleton

    def chain(parent):
        return Chain(f"c{parent}", parent, parent + 1, -1, np.ones(3), np.ones(3))

    def grouped(*parents):
        return [
            [c.parent for c in group]
            for group in group_connected_chains(skeleton, list(map(chain, parents)))
        ]

    assert grouped() == []
    assert grouped(1, 5, 2) == [[5], [1, 2]]
    assert grouped(5, 1, 6, 2) == [[5, 6], [1, 2]]
    assert grouped(1, 4, 0) == [[1, 4, 0]]  # through the root, which turns both
    assert grouped(6, 4, 5) == [[6, 4, 5]]
    assert grouped(1, 6) == [[1], [6]]


def test_a_flip_with_the_end_turned_along_needs_the_end_s_channels_not():
    rotatable = np.array([True, True, False])
    motion = still([(0, 1, 0)] * 3, [-1, 0, 1], rotatable=rotatable)
    limb = Limb("j0-j2", 0, 1, 2, np.ones(3), np.ones(3))
    assert uncorrectable_joints(motion, limb) == ("j2",)
    assert uncorrectable_joints(motion, limb, carried=True) == ()
    lower = make_chain(motion, 1, 2)
    assert uncorrectable_joints(motion, lower) == ("j2",)
    every = still([(0, 1, 0)] * 3, [-1, 0, 1])
    assert uncorrectable_joints(every, limb) == ()
