"""Numbers in a text replaced by others, every other byte kept; told the plain way, too."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from twistcore.formats.bvh.channels import JointChannels, motion_from_channels
from twistcore.formats.bvh.patch import (
    changed_position_values,
    changed_rotation_values,
    replace_numbers,
)
from twistcore.formats.clip import ChannelJump
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle, quaternion_from_euler

TOKENS = st.sampled_from(
    ("1", "-2", "+3.5", ".25", "4.", "0.1234567", "-1.23456789e-02", "7E+1", "1e5", "12.5E3")
) | st.sampled_from(("-0.000001", f"1.{1:017}", f"9.{0:050}", f"1.{0:050}e-05", "1" * 60))
GAPS = st.sampled_from([b" ", b" ", b" ", b"  ", b"\t", b"\n", b"\r\n", b" \n ", b"\x0b"])
NUMBERS = st.floats(-1e4, 1e4).map(lambda x: x + 0.0)


def plainly(data, replaced):
    """Each token by itself: {place: number} -> text."""
    out, done = b"", 0
    for place, token in enumerate(re.finditer(rb"\S+", data)):
        if place in replaced:
            mantissa = re.split(b"[eE]", token.group())[0]
            decimals = len(mantissa.partition(b".")[2])
            out += data[done : token.start()]
            out += f"{replaced[place]:.{min(max(decimals, 6), 15)}f}".encode()
            done = token.end()
    return out + data[done:]


def spans_of(data):
    places = [token.span() for token in re.finditer(rb"\S+", data)]
    return tuple(np.array(places, dtype=np.int64).reshape(-1, 2).T)


@given(st.lists(st.tuples(TOKENS, GAPS), min_size=1, max_size=12), st.data())
def test_every_other_byte_stays_and_decimals_are_kept(parts, data):
    text = b"head " + b"".join(token.encode() + gap for token, gap in parts) + b"end"
    places = st.lists(st.integers(1, len(parts)), min_size=1, unique=True)
    chosen = {place: data.draw(NUMBERS) for place in data.draw(places)}
    tokens = np.array(list(chosen), dtype=np.int64)  # in any order
    numbers = np.array(list(chosen.values()))
    assert replace_numbers(text, spans_of(text), tokens, numbers) == plainly(text, chosen)


def test_a_token_at_the_very_start_and_end():
    text = b"1.5 2.25"
    tokens = np.array([0, 1])
    assert (
        replace_numbers(text, spans_of(text), tokens, np.array([3.0, 4.0])) == b"3.000000 4.000000"
    )


SKELETON = Skeleton(("Hips", "Arm", "Prop"), np.array([-1, 0, -1]), np.zeros((3, 3)))
LAYOUTS = (
    JointChannels("ZYX", (5, 4, 3), ((0, 2), (1, 0), (2, 1))),  # columns in an order of their own
    JointChannels("XY", (6, 7), ()),
    JointChannels("", (), ((1, 8),)),
)
COLUMNS = 9


def values():
    return np.arange(6.0 * COLUMNS).reshape(6, COLUMNS)


def test_positions_that_differ_are_told_where_they_stand():
    before = motion_from_channels(SKELETON, LAYOUTS, values(), 0.1)
    tokens, numbers = changed_position_values(LAYOUTS, COLUMNS, before, before)
    assert (len(tokens), len(numbers)) == (0, 0)
    assert tokens.dtype == np.int64
    moved = values()
    for frame, column, number in ((0, 0, -1.0), (2, 1, -2.0), (5, 2, -3.0), (3, 8, -4.0)):
        moved[frame, column] = number
    after = motion_from_channels(SKELETON, LAYOUTS, moved, 0.1)
    tokens, numbers = changed_position_values(LAYOUTS, COLUMNS, before, after)
    written_values = dict(zip(tokens.tolist(), numbers.tolist(), strict=True))
    assert written_values == {0: -1.0, 2 * 9 + 1: -2.0, 5 * 9 + 2: -3.0, 3 * 9 + 8: -4.0}


def test_turned_joints_are_told_in_degrees_where_they_stand():
    before = motion_from_channels(SKELETON, LAYOUTS, values(), 0.1)
    rotations = before.rotations.copy()
    by = quaternion_from_axis_angle([0.0, 0.0, 1.0], np.radians(1.0))
    rotations[2:4, 0] = multiply(by, rotations[2:4, 0])
    rotations[5, 0] = multiply(by, rotations[5, 0])
    after = replace(before, rotations=rotations)
    changed = np.zeros((6, 3), dtype=bool)
    changed[[2, 3, 5], 0] = True
    written_values = changed_rotation_values(values(), LAYOUTS, SKELETON.names, after, changed)
    tokens, numbers, jumps = written_values
    assert jumps == ()
    assert sorted(tokens.tolist()) == [f * 9 + c for f in (2, 3, 5) for c in (3, 4, 5)]
    written = values()
    written.flat[tokens] = numbers
    np.testing.assert_allclose(
        quaternion_from_euler("ZYX", np.radians(written[:, [5, 4, 3]])), rotations[:, 0], atol=1e-12
    )
    # The first angle goes on from where it was: one degree more.
    np.testing.assert_allclose(written[:, 5] - values()[:, 5], [0, 0, 1, 1, 0, 1], atol=1e-9)
    nothing = np.zeros((6, 3), dtype=bool)
    tokens, numbers, jumps = changed_rotation_values(
        values(), LAYOUTS, SKELETON.names, after, nothing
    )
    assert (tokens.size, numbers.size, jumps) == (0, 0, ())


def test_a_jump_that_stays_is_told_with_its_channel():
    """Most of a turn in four frames, between frames that are not turned."""
    still = np.zeros((6, COLUMNS))
    motion = motion_from_channels(SKELETON, LAYOUTS, still, 0.1)
    rotations = motion.rotations.copy()
    turns = np.radians([80.0, 160.0, 240.0, 320.0])
    rotations[1:5, 0] = quaternion_from_axis_angle([0.0, 0.0, 1.0], turns)
    changed = np.zeros((6, 3), dtype=bool)
    changed[1:5, 0] = True
    after = replace(motion, rotations=rotations)
    tokens, numbers, jumps = changed_rotation_values(still, LAYOUTS, SKELETON.names, after, changed)
    written = still.copy()
    written.flat[tokens] = numbers
    (at,) = np.flatnonzero(np.abs(np.diff(written[:, 5])) > 180.0)
    assert jumps == (ChannelJump("Hips", at + 1, "Zrotation"),)


def test_a_joint_without_three_rotations_is_named():
    motion = motion_from_channels(SKELETON, LAYOUTS, values(), 0.1)
    changed = np.zeros((6, 3), dtype=bool)
    changed[1, 1] = True
    with pytest.raises(ValueError, match="'Arm'"):
        changed_rotation_values(values(), LAYOUTS, SKELETON.names, motion, changed)


@pytest.mark.parametrize("frames", [slice(0, 6), slice(0, 2), slice(4, 6)])
def test_at_an_end_of_the_clip_angles_stay_on_their_turn_and_jump_nowhere(frames):
    """A spin of nearly two turns: the last frame does not stand beside the first."""
    spun = values()
    spun[:, 3:5] = 10.0
    spun[:, 5] = 370.0 + np.array([0.0, 80.0, 200.0, 340.0, 500.0, 660.0])
    motion = motion_from_channels(SKELETON, LAYOUTS, spun, 0.1)
    rotations = motion.rotations.copy()
    by = quaternion_from_axis_angle([0.0, 0.0, 1.0], np.radians(1.0))
    rotations[frames, 0] = multiply(by, rotations[frames, 0])
    changed = np.zeros((6, 3), dtype=bool)
    changed[frames, 0] = True
    after = replace(motion, rotations=rotations)
    tokens, numbers, jumps = changed_rotation_values(spun, LAYOUTS, SKELETON.names, after, changed)
    written = spun.copy()
    written.flat[tokens] = numbers
    assert jumps == ()
    np.testing.assert_allclose(written[:, 5] - spun[:, 5], changed[:, 0], atol=1e-9)
    np.testing.assert_allclose(written[:, :5], spun[:, :5], atol=1e-9)
