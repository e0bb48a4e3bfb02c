"""Reading without guessing, writing without touching."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.messages import names_in_one_line, numbers, refused
from tests.tiers import examples
from tests.twistcore.strategies import orders, quaternions
from twistcore.errors import BvhError
from twistcore.formats.bvh import decimated, parse_bvh, read_bvh
from twistcore.formats.bvh.euler_branch import continuous_euler_angles
from twistcore.formats.clip import create_file_patch_for_motion, write_clip
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, multiply, quaternion_from_euler

HEADER = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition %(a)srotation %(b)srotation %(c)srotation
  JOINT Left Arm
  {
    OFFSET 0 1 0
    CHANNELS 3 %(a)srotation %(b)srotation %(c)srotation
    End Site
    {
      OFFSET 0 1 0
    }
  }
}
MOTION
Frames: %(n)d
Frame Time: 0.01
"""


def small(rows, order="ZYX", newline="\n"):
    text = HEADER % {"a": order[0], "b": order[1], "c": order[2], "n": len(rows)}
    text += "\n".join(" ".join(f"{v:.6f}" for v in row) for row in rows) + "\n"
    return text.replace("\n", newline).encode()


def test_a_real_clip_is_read_whole(walk):
    assert (walk.motion.frames, len(walk.motion.skeleton)) == (344, 31)
    assert walk.motion.fps == pytest.approx(120.0, rel=1e-4)
    assert walk.warnings == ()
    np.testing.assert_allclose(walk.values[0, :3], [10.4194, 16.7048, -30.1003])


def test_nothing_to_correct_is_byte_identical(sample, tmp_path):
    out = tmp_path / "same.bvh"
    write_clip(sample, sample.motion, out)
    assert out.read_bytes() == sample.data


def test_every_rotation_rewritten_from_quaternions_keeps_every_position(sample):
    every = np.ones(sample.motion.rotations.shape[:2], dtype=bool)
    data = sample.patched(sample.motion, every).data
    again = parse_bvh(data)
    before, after = forward_kinematics(sample.motion)[1], forward_kinematics(again.motion)[1]
    assert np.abs(before - after).max() <= 1e-6 * sample.motion.skeleton.height
    # It is not a copy: the numbers were written anew, with at least six decimals.
    assert len(data) > len(sample.data)


@settings(max_examples=examples(40))
@given(orders, st.lists(quaternions, min_size=3, max_size=8), st.data())
def test_written_rotations_are_read_back(order, rotations, data):
    rows = np.zeros((len(rotations), 9))
    clip = parse_bvh(small(rows, order))
    q = clip.motion.rotations.copy()
    first = data.draw(st.integers(0, len(rotations) - 1))
    stop = data.draw(st.integers(first + 1, len(rotations)))
    q[first:stop, 1] = rotations[first:stop]
    moved = clip.motion.with_rotations(q)
    again = parse_bvh(create_file_patch_for_motion(clip, moved).data)
    assert geodesic_angle(again.motion.rotations, q).max() < 1e-6
    np.testing.assert_array_equal(again.values[:, :6], clip.values[:, :6])


@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_line_ends_are_kept(newline):
    clip = parse_bvh(small(np.arange(27).reshape(3, 9), newline=newline))
    assert clip.motion.frames == 3
    assert clip.motion.skeleton.names == ("Hips", "Left Arm")
    q = clip.motion.rotations.copy()
    q[1, 1] = [0.5, 0.5, 0.5, 0.5]
    moved = clip.motion.with_rotations(q)
    data = create_file_patch_for_motion(clip, moved).data
    assert data.count(newline.encode()) == clip.data.count(newline.encode())
    before, after = clip.data.split(), data.split()
    assert len(before) == len(after)
    differing = [k for k, (x, y) in enumerate(zip(before, after, strict=True)) if x != y]
    assert len(differing) == 3


def test_numbers_of_any_form_are_replaced_and_nothing_beside_them(walk):
    head, word, rows = walk.data.partition(b"Frame Time")
    rows = rows.replace(b" -", b"\t -").replace(b"1 ", b"1e0 ", 500)
    clip = parse_bvh(head + word + rows)
    rng = np.random.default_rng(3)
    changed = rng.random(clip.motion.rotations.shape[:2]) < 0.05
    changed &= clip.skeleton.rotatable
    q = np.where(changed[..., None], np.roll(clip.motion.rotations, 7, 0), clip.motion.rotations)
    again = parse_bvh(clip.patched(clip.motion.with_rotations(q), changed).data)
    assert geodesic_angle(again.motion.rotations, q).max() < 1e-6
    numbers = re.compile(rb"[^\s]+")
    assert numbers.sub(b"", again.data) == numbers.sub(b"", clip.data)
    assert b"e" not in again.data[again.data_start :].replace(b"e0", b"")
    kept = np.ones(clip.values.shape, dtype=bool)
    for joint, layout in enumerate(clip.channels):
        kept[:, list(layout.rotation)] = ~changed[:, joint, None]
    before, after = (c.data[c.data_start :].split() for c in (clip, again))
    same = [x == y for x, y in zip(before, after, strict=True)]
    assert np.array(same)[kept.ravel()].all()


def test_a_slow_turn_is_written_without_jumps():
    """A joint that turns through ±180° and through gimbal lock must not flip its channels."""
    t = np.linspace(0, 2 * np.pi, 200)
    zero = np.zeros_like(t)
    q = multiply(
        quaternion_from_euler("ZYX", np.stack([t, zero, zero], axis=1)),
        quaternion_from_euler("ZYX", np.stack([zero, 0.5 * np.sin(t), 0.3 * t], axis=1)),
    )
    angles = continuous_euler_angles("ZYX", q, np.zeros((len(q), 3)), np.zeros(3), None)
    assert np.abs(np.diff(angles, axis=0)).max() < 0.1


@pytest.mark.parametrize(
    ("damage", "line", "column", "fact"),
    [
        (lambda _: b"", 1, 1, "HIERARCHY"),
        (lambda _: b"\x00\x89" + bytes(range(200)), 1, 1, "HIERARCHY"),
        (lambda t: t.replace(b"MOTION", b""), 17, 1, "MOTION"),
        (lambda t: t.replace(b"Frame Time", b"Time"), 18, 1, "Frame Time"),
        (lambda t: t.replace(b"Frames: 3", b"Frames: x"), 17, 9, "Frames"),
        (lambda t: t.replace(b"4.000000", b"nan"), 19, 37, "'nan'"),
        (lambda t: t.replace(b"4.000000", b"4,0"), 19, 37, "'4,0'"),
        (lambda t: t.replace(b"4.000000", b"-,5e-3"), 19, 37, "'-,5e-3'"),
        (lambda t: t.replace(b"OFFSET 0 1 0", b"OFFSET 0 1,5 0", 1), 8, 14, "'1,5'"),
        (lambda t: t.replace(b"4.000000", b"1e999"), 19, 37, "'1e999'"),
        (lambda t: t.replace(b"4.000000", b"4.0.0"), 19, 37, "'4.0.0'"),
        (lambda t: t.replace(b"4.000000", b"1e200"), 19, 37, "1e+100"),
        (lambda t: t.replace(b"4.000000", b"-" + b"9" * 200 + b".5"), 19, 37, "1e+100"),
        (lambda t: t.replace(b"OFFSET 0 1 0", b"OFFSET 0 -1e160 0", 1), 8, 14, "1e+100"),
        (lambda t: t.replace(b"13.000000 ", b""), 20, None, "9"),
        (lambda t: t[: t.index(b"CHANNELS 3")], 8, 17, "'}'"),
        (lambda t: t.replace(b"OFFSET 0 1 0", b"OFFSET 0 one 0", 1), 8, 14, "'one'"),
        (lambda t: t.replace(b"CHANNELS 3", b"CHANNELS 4"), 10, 5, "'End'"),
    ],
)
def test_broken_files_say_where_and_what(damage, line, column, fact):
    with refused(BvhError, fact, path="broken.bvh", line=line, column=column):
        parse_bvh(damage(small(np.arange(27).reshape(3, 9))), "broken.bvh")


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("before", [b"", b"  ", b"\t \t"])
@pytest.mark.parametrize(
    ("wanted", "found", "line"),
    [
        (b"HIERARCHY", b"HIERARCHX", 1), (b"ROOT", b"BOOT", 2), (b"CHANNELS 6", b"CHANELS 6", 5),
        (b"Frames: 3", b"frame: 3", 17), (b"Frame Time", b"Time", 18), (b"0.000000", b"x", 19),
    ],
)  # fmt: skip
def test_the_column_is_that_of_the_word(end, before, wanted, found, line):
    """Columns count from 1, for each line ending and for any text before the word."""
    lines = small(np.arange(27).reshape(3, 9)).splitlines()
    assert wanted in lines[line - 1]
    left = lines[line - 1].index(wanted)
    lines[line - 1] = before + lines[line - 1].replace(wanted, found, 1)
    with pytest.raises(BvhError) as error:
        parse_bvh(end.join(lines), "broken.bvh")
    assert (error.value.line, error.value.column) == (line, len(before) + left + 1)


def test_a_missing_file_is_one_sentence(tmp_path):
    with refused(BvhError, path=str(tmp_path / "none.bvh"), line=None):
        read_bvh(tmp_path / "none.bvh")


def test_declared_and_real_rows_may_differ_but_not_in_silence():
    data = small(np.arange(27).reshape(3, 9)).replace(b"Frames: 3", b"Frames: 300")
    clip = parse_bvh(data)
    assert clip.motion.frames == 3
    assert numbers(clip.warnings[0].text)[:2] == [300, 3]


def test_a_cut_last_row_is_left_out_and_told():
    data = small(np.arange(27).reshape(3, 9)).rstrip()[:-20]
    clip = parse_bvh(data)
    assert clip.motion.frames == 2
    assert clip.warnings


def test_rows_wrapped_over_lines_are_read_and_patched():
    plain = small(np.arange(27).reshape(3, 9))
    head, body = plain[: plain.index(b"0.000000")], plain[plain.index(b"0.000000") :]
    wrapped = head + b"\n".join(
        b" ".join(row.split()[:5]) + b"\n\t" + b" ".join(row.split()[5:])
        for row in body.splitlines()
    )
    clip = parse_bvh(wrapped)
    np.testing.assert_array_equal(clip.values, np.arange(27).reshape(3, 9))
    assert clip.patched(clip.motion, np.zeros((3, 2), dtype=bool)).data == wrapped


@pytest.mark.parametrize(
    ("counts", "wrong", "expected"),
    [
        ((3, 3, 3, 3, 2, 3, 3, 3, 3), 4, (3, 2)),
        ((3, 3, 4, 3, 3, 3, 3, 3, 2), 2, (3, 4)),  # too long for what is left of its frame
        ((3, 6, 3, 5, 3, 6), 3, (6, 5)),
    ],
)
def test_of_wrapped_rows_the_line_that_is_not_as_in_the_first_frame_is_named(
    counts, wrong, expected
):
    head = small(np.zeros((3, 9)))
    head = head[: head.index(b"0.000000")]
    rows = "".join("1 " * count + "\n" for count in counts)
    with refused(BvhError, line=head.count(b"\n") + 1 + wrong) as caught:
        parse_bvh(head + rows.encode())
    assert numbers(caught.value.expected) == list(expected)


def test_an_unusable_frame_time_is_replaced_and_told():
    clip = parse_bvh(small(np.zeros((2, 9))).replace(b"Frame Time: 0.01", b"Frame Time: 0"))
    assert clip.motion.fps == 30.0
    assert "Frame Time" in clip.warnings[0].text
    assert parse_bvh(clip.data, fps=60.0).motion.fps == 60.0


@pytest.mark.parametrize(
    ("written", "rate", "seconds"),
    [
        ("120", "120", "0.00833"),
        ("29.97", "29.97", "0.0334"),
        ("59.94006", "59.94", "0.0167"),
        ("33.333333", "30", "0.0333"),  # milliseconds
        ("16.6667", "60", "0.0167"),
        ("1.5e3", "1500", "0.000667"),
    ],
)
def test_a_rate_in_place_of_its_reciprocal_is_asked_about(written, rate, seconds):
    data = small(np.zeros((2, 9))).replace(b"Time: 0.01", f"Time: {written}".encode())
    clip = parse_bvh(data)
    [warning] = clip.warnings
    assert clip.motion.fps == 30.0
    assert warning.line == 18
    assert names_in_one_line(warning.text, f"1/{rate} = {seconds}", f"--fps {rate}")
    again = parse_bvh(data, fps=float(rate))
    assert (again.warnings, again.motion.fps) == ((), pytest.approx(float(rate)))


@pytest.mark.parametrize("written", ["0", "-1", "10001", "1e9", "nan", "fast"])
def test_other_unusable_frame_times_have_no_advice(written):
    data = small(np.zeros((2, 9))).replace(b"Time: 0.01", f"Time: {written}".encode())
    [warning] = parse_bvh(data).warnings
    assert "30" in warning.text
    assert "--fps" not in warning.text


def test_a_decimal_comma_in_the_frame_time_alone_is_a_point():
    data = small(np.zeros((2, 9))).replace(b"Time: 0.01", b"Time: 0,0125")
    clip = parse_bvh(data)
    assert clip.motion.fps == pytest.approx(80.0)
    assert [(w.line, "decimal comma" in w.text) for w in clip.warnings] == [(18, True)]


def test_a_joint_without_offset_is_a_warning_at_its_line():
    data = small(np.arange(27).reshape(3, 9))
    at = data.index(b"OFFSET 0 1 0")
    line = data[:at].count(b"\n") + 1
    clip = parse_bvh(data[:at] + data[at:].replace(b"OFFSET 0 1 0", b"", 1))
    [warning] = clip.warnings
    assert warning.line == line - 2  # the joint's own
    assert names_in_one_line(warning.text, repr(clip.skeleton.names[1]), "OFFSET")
    assert clip.skeleton.offsets[1].tolist() == [0.0, 0.0, 0.0]
    root = parse_bvh(data.replace(b"OFFSET 0 0 0", b"", 1))
    assert [w.line for w in root.warnings] == [2]


@pytest.mark.parametrize("gap", ["\n", "\r\n", "\n\n  ", "\t\n\t"])
@pytest.mark.parametrize("field", ["Frames:", "Frame Time:"])
def test_a_number_of_the_timing_may_stand_alone_on_the_next_line(field, gap):
    rows = np.arange(18).reshape(2, 9)
    data = small(rows).decode().replace(f"{field} ", f"{field}{gap}").encode()
    clip = parse_bvh(data)
    np.testing.assert_array_equal(clip.values, rows)
    assert clip.motion.fps == 100.0
    assert clip.warnings == ()
    assert decimated(clip, 2).motion.fps == pytest.approx(50.0)


def test_a_row_is_not_taken_for_a_missing_frame_time():
    rows = np.arange(18).reshape(2, 9)
    clip = parse_bvh(small(rows).replace(b"Frame Time: 0.01", b"Frame Time:"))
    np.testing.assert_array_equal(clip.values, rows)
    assert clip.motion.fps == 30.0
    assert "Frame Time" in clip.warnings[0].text


def test_a_position_channel_replaces_the_offset():
    data = (
        small(np.zeros((1, 9)))
        .replace(b"CHANNELS 3 Z", b"CHANNELS 4 Yposition Z")
        .replace(b"0.000000\n", b"0.000000 0.0\n")
    )
    row = data.rstrip().splitlines()[-1].split()
    row[6] = b"5"
    clip = parse_bvh(data.rstrip().rsplit(b"\n", 1)[0] + b"\n" + b" ".join(row))
    np.testing.assert_array_equal(forward_kinematics(clip.motion)[1][0, 1], [0.0, 5.0, 0.0])


def test_writing_over_a_read_only_folder_leaves_nothing(walk, tmp_path, monkeypatch):
    target = tmp_path / "out.bvh"
    target.write_bytes(b"old")

    def refuse(*_args):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("twistcore.files.atomic.os.fsync", refuse)
    with pytest.raises(OSError, match="space"):
        write_clip(walk, walk.motion, target)
    assert target.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [target]
