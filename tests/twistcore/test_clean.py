"""`twistcore clean` and what it rewrites: the same poses, only the bytes that it lists."""

import sys

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore import amc_files
from tests.twistcore.amass_files import write_amass
from tests.twistcore.strategies import orders
from tests.twistcore.test_cli import run, run_json
from twistcore.cli import clean_command, main
from twistcore.errors import TwistError
from twistcore.export.compare import largest_deviation
from twistcore.formats.bvh import parse_bvh, read_bvh, rewriting
from twistcore.formats.bvh.euler_branch import (
    continuous_euler_angles_in_order,
    unwrapped_euler_angles,
)
from twistcore.formats.bvh.header_places import header_word_spans
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, quaternion_from_euler, slerp

WALK = ASSETS / "walk.bvh"
HEADER = """HIERARCHY
ROOT Hips
{
  OFFSET 0 1.5 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Left Arm
  {
    OFFSET 1 2.25 -3
    CHANNELS 6 Xposition Yposition Zposition zRotation yrotation xrotation
    JOINT Élan
    {
      OFFSET 0 4 0
      CHANNELS 2 Yrotation Zrotation
      End Site
      {
        OFFSET 0 0.5 0
      }
    }
  }
}
MOTION
Frames: %d
Frame Time: 0.025
"""


def clip_of(rows, end="\n"):
    """A clip with rows of 14 numbers: hips, an arm with 6 channels and a joint with 2."""
    lines = [" ".join(f"{value:.6f}" for value in row) for row in rows]
    return parse_bvh((HEADER % len(rows) + "\n".join(lines) + end).encode())


def still(angles):
    """Rows in which only the arm's angles (frames, 3) change."""
    return [[0, 0, 0, 10, 20, 30, 1, 2.25, -3, *row, 5, 6] for row in angles]


def tokens(clip):
    """The words of the rows."""
    return clip.text[clip.data_start :].split()


def farthest(a, b):
    """Degrees between the world rotations of two clips."""
    return largest_deviation(a.motion, b.motion).degrees


# Angles at and near gimbal lock, at and beyond the turns, and any others.
near = st.sampled_from([0.0, 90.0, -90.0, 89.999999, -90.000001, 180.0, -180.0, 270.0, 360.0])
angle = near | st.floats(-400.0, 400.0).map(lambda value: round(value, 6))
triples = st.lists(st.tuples(angle, angle, angle), min_size=1, max_size=12).map(np.array)
walks = st.lists(st.tuples(*[st.floats(-40.0, 40.0)] * 3), min_size=1, max_size=30).map(
    lambda steps: np.round(np.cumsum(steps, axis=0), 6)
)
choices = st.lists(st.tuples(st.booleans(), *[st.integers(-1, 1)] * 3), min_size=30, max_size=30)


def rotations_differ(order, a, b):
    q, p = (quaternion_from_euler(order, np.radians(x)) for x in (a, b))
    return float(np.degrees(geodesic_angle(q, p).max()))


def assert_no_nearer_angles(angles):
    """No step above 90° has a shorter one to equivalent angles."""
    others = angles * (1, -1, 1) + 180.0
    for before, own, other in zip(angles[:-1], angles[1:], others[1:], strict=True):
        if np.abs(own - before).max() > 90.0:
            off = np.array([own, other]) - before
            least = np.abs(off - 360.0 * np.round(off / 360.0)).sum(axis=1).min()
            assert np.abs(own - before).sum() <= least + 1e-5


@settings(deadline=None, max_examples=300)
@given(orders, triples)
def test_unrolled_angles_are_the_same_rotations_also_in_gimbal_lock(order, angles):
    found = unwrapped_euler_angles(order, angles)
    assert rotations_differ(order, angles, found) < 3e-5
    assert_no_nearer_angles(found)


@settings(deadline=None, max_examples=200)
@given(orders, walks, choices)
def test_equivalent_angles_become_the_smooth_ones_again(order, smooth, chosen):
    assume((np.abs(np.cos(np.radians(smooth[:, 1]))) > 0.75).all())  # the solutions are far apart
    written = smooth.copy()
    for k, (other, *turns) in enumerate(chosen[1 : len(smooth)], 1):
        if other:
            written[k] = written[k] * (1, -1, 1) + 180.0
        written[k] += 360.0 * np.array(turns)
    found = unwrapped_euler_angles(order, written)
    np.testing.assert_allclose(found, smooth, atol=1e-9)
    np.testing.assert_array_equal(unwrapped_euler_angles(order, smooth), smooth)


@pytest.mark.parametrize("order", ["XYZ", "ZYX"])
@pytest.mark.parametrize("lock", [90.0, -90.0])
def test_in_gimbal_lock_a_jump_of_the_outer_angles_is_divided_between_them(order, lock):
    sign = (1 if order == "XYZ" else -1) * np.sign(lock)
    angles = np.array([[10, 0.9 * lock, 20], [10, lock, 20], [10, lock, 20], [12, lock, 20]])
    angles[2:] += np.array([150.0, 0.0, -sign * 150.0])
    assert rotations_differ(order, angles[1:2], angles[2:3]) < 1e-9
    found = unwrapped_euler_angles(order, angles)
    assert np.abs(np.diff(found, axis=0)).max() < 10.0
    assert rotations_differ(order, angles, found) < 1e-9


@settings(deadline=None, max_examples=300)
@given(orders, orders, triples)
def test_another_order_is_the_same_rotation_without_avoidable_jumps(old, new, angles):
    q = quaternion_from_euler(old, np.radians(angles))
    found = continuous_euler_angles_in_order(new, q)
    rotated = quaternion_from_euler(new, np.radians(found))
    assert np.degrees(geodesic_angle(q, rotated)).max() < 6e-5
    assert_no_nearer_angles(found)


@settings(deadline=None, max_examples=60)
@given(triples, st.sampled_from(["\n", "", "\r\n\r\n", "\n1 2 3\n"]))
def test_a_whole_clip_keeps_its_poses_and_every_number_that_is_not_listed(angles, end):
    clip = clip_of(still(angles), end)
    done = rewriting.unwrap_bvh_clip_angles(clip)
    new = done.clip
    assert farthest(clip, new) < 3e-5
    assert new.text[: new.data_start] == clip.text[: clip.data_start]
    differ = [a != b for a, b in zip(tokens(clip), tokens(new), strict=True)]
    assert sum(differ) == sum(change.numbers for change in done.changes)
    at = np.flatnonzero(differ)
    assert {int(column) for column in at % 14} <= {9, 10, 11}
    if len(at):
        [change] = done.changes
        rows = np.unique(at // 14)
        assert (change.joint, change.frames) == ("Left Arm", len(rows))
        assert (change.start, change.stop) == (rows[0], rows[-1] + 1)
    else:
        assert new.data == clip.data
    for order in ("ZXY", "XZY"):
        assert farthest(clip, rewriting.change_rotation_order(clip, {"": order}).clip) < 1e-4


def test_a_wrap_changes_only_the_wrapped_numbers():
    angles = [[170.0, 1, 2], [179.5, 1, 2], [-179.25, 1, 2], [-175.0, 1, 2], [178.0, 1, 2]]
    done = rewriting.unwrap_bvh_clip_angles(clip_of(still(angles)))
    np.testing.assert_array_equal(done.clip.values[:, 9], [170.0, 179.5, 180.75, 185.0, 178.0])
    [change] = done.changes
    assert (change.numbers, change.start, change.stop, change.words) == (2, 2, 4, 0)


def test_an_order_is_written_into_the_same_columns_in_the_same_letters():
    clip = clip_of(still([[10.0, 20, 30], [40, 50, 60]]))
    done = rewriting.change_rotation_order(clip, {"Left Arm": "XYZ"})
    head = done.clip.text[: done.clip.data_start].decode()
    assert head == (HEADER % 2).strip("\n").replace(
        "zRotation yrotation xrotation", "xRotation yrotation zrotation"
    )
    assert [c.joint for c in done.changes] == ["Left Arm"]
    assert (
        rewriting.change_rotation_order(clip, {"": "ZXY", "Left Arm": "ZYX"}).clip.data == clip.data
    )
    back = rewriting.change_rotation_order(done.clip, {"Left Arm": "ZYX"}).clip
    np.testing.assert_allclose(back.values, clip.values, atol=2e-6)
    assert (
        len(rewriting.change_rotation_order(clip, {"": "XYZ"}).notes) == 1
    )  # the joint with two channels


@pytest.mark.parametrize(("orders", "fact"), [({"Élan": "XYZ"}, "Élan"), ({"Leg": "XYZ"}, "Leg")])
def test_an_order_for_a_joint_that_cannot_have_it_is_refused(orders, fact):
    with pytest.raises(TwistError, match=fact):
        rewriting.change_rotation_order(clip_of(still([[0.0, 0, 0]])), orders)


@pytest.mark.parametrize("end", ["\n", "", "\n1 2 3 4 5 6 7 8 9 10 11 12 13\n"])
def test_still_position_channels_are_removed_and_nothing_else(end):
    angles = [[10.0, 20, 30], [40, 50, 60], [70, 80, -85]]
    clip = clip_of(still(angles), end)
    done = rewriting.without_redundant_positions(clip, keep_moving=False)
    np.testing.assert_array_equal(done.clip.values, np.delete(clip.values, [6, 7, 8], axis=1))
    kept = [t for k, t in enumerate(tokens(clip)[:42]) if k % 14 not in (6, 7, 8)]
    assert tokens(done.clip) == kept
    head = clip.text[: clip.data_start].replace(b"6 Xposition Yposition Zposition zR", b"3 zR")
    assert done.clip.text.startswith(head)
    assert farthest(clip, done.clip) < 1e-12
    [change] = done.changes
    assert (change.joint, change.numbers, change.words) == ("Left Arm", 9, 4)


def test_the_last_columns_and_wrapped_rows_lose_the_space_before():
    text = HEADER.replace("zRotation yrotation xrotation", "").replace("6 Xpos", "3 Xpos", 2)
    text = text.replace("3 Xposition", "6 Xposition", 1).replace("2 Yrotation Zrotation", "0 ")
    rows = "0 0 0 10 20 30\n 1 2.25\n -3\n0 0 0 1 2 3\n 1 2.25\n -3"
    clip = parse_bvh((text % 2 + rows).encode())
    done = rewriting.without_redundant_positions(clip, keep_moving=False).clip
    assert done.text.endswith(b"0 0 0 10 20 30\n0 0 0 1 2 3")


def test_moving_position_channels_are_refused_with_joint_and_frame_or_kept():
    rows = np.array(still(np.zeros((4, 3))))
    rows[2, 8] += 0.01
    clip = clip_of(rows)
    with pytest.raises(TwistError, match=r"Left Arm.* 0\.01 .*frame 2"):
        rewriting.without_redundant_positions(clip, keep_moving=False)
    done = rewriting.without_redundant_positions(clip, keep_moving=True)
    assert (done.clip.data, len(done.notes)) == (clip.data, 1)


@pytest.mark.parametrize("factor", [0.01, 2.5])
def test_a_scale_changes_offsets_and_positions_alone(factor):
    clip = clip_of(still([[10.0, 20, 30], [40, 50, 60]]))
    new = rewriting.change_axes_and_unit(clip, factor * np.eye(3)).clip
    np.testing.assert_allclose(new.skeleton.offsets, factor * clip.skeleton.offsets)
    np.testing.assert_allclose(new.skeleton.ends[0][1], (0, 0.5 * factor, 0))
    np.testing.assert_allclose(
        forward_kinematics(new.motion)[1], factor * forward_kinematics(clip.motion)[1], atol=1e-9
    )
    same = [k for k in range(28) if k % 14 not in (6, 7, 8)]
    assert [tokens(new)[k] for k in same] == [tokens(clip)[k] for k in same]
    back = rewriting.change_axes_and_unit(new, np.eye(3) / factor).clip
    np.testing.assert_allclose(back.values, clip.values, atol=1e-12)


def test_other_axes_turn_the_whole_figure_and_round_nothing():
    clip = read_bvh(WALK)
    new = rewriting.change_axes_and_unit(clip, clean_command.Z_TO_Y.T).clip
    (q, p), (turned, placed) = (forward_kinematics(c.motion) for c in (clip, new))
    np.testing.assert_allclose(placed, p[..., [0, 2, 1]] * (1, -1, 1), atol=1e-12)
    np.testing.assert_allclose(turned, q[..., [0, 1, 3, 2]] * (1, 1, -1, 1), atol=1e-12)
    back = rewriting.change_axes_and_unit(new, clean_command.Z_TO_Y).clip
    np.testing.assert_array_equal(back.values, clip.values)
    np.testing.assert_array_equal(back.skeleton.offsets, clip.skeleton.offsets)
    assert back.channels == clip.channels


def test_other_axes_list_every_letter_and_number_of_the_hierarchy():
    done = rewriting.change_axes_and_unit(clip_of(still([[10.0, 20, 30]])), clean_command.Z_TO_Y)
    assert [(c.words, c.numbers) for c in done.changes] == [(6, 1), (6, 2), (6, 1)]


def test_names_are_the_only_bytes_that_a_map_changes():
    clip = clip_of(still([[0.0, 0, 0]]))
    names = {"Left Arm": "arm.L", "Élan": "左 手"}
    new = rewriting.with_joint_names(clip, names).clip
    assert new.skeleton.names == ("Hips", "arm.L", "左 手")
    assert new.data == clip.data.replace(b"Left Arm", b"arm.L").replace(
        "Élan".encode(), "左 手".encode()
    )
    back = rewriting.with_joint_names(new, {new: old for old, new in names.items()}).clip
    assert back.data == clip.data


@pytest.mark.parametrize("name", ["Hips", "", "a\nb", "a {", " a"])
def test_a_name_that_cannot_be_read_back_is_refused(name):
    with pytest.raises(TwistError):
        rewriting.with_joint_names(clip_of(still([[0.0, 0, 0]])), {"Left Arm": name})


def test_words_of_a_header_are_found_with_a_mark_and_other_letters():
    text = b"\xef\xbb\xbf" + (HEADER % 1).encode()
    found = [(p.kind, p.joint, text[p.start : p.stop].decode()) for p in header_word_spans(text)]
    assert [word for kind, _, word in found if kind == "name"] == ["Hips", "Left Arm", "Élan"]
    assert [word for kind, j, word in found if kind == "offset" and j == 2] == [
        *"040",
        "0",
        "0.5",
        "0",
    ]
    assert [word for kind, _, word in found if kind == "count"] == ["6", "6", "2"]
    assert [w for kind, j, w in found if (kind, j) == ("channel", 2)] == ["Yrotation", "Zrotation"]


# -- other rates -----------------------------------------------------------------------------------


def test_half_of_the_rate_keeps_the_bytes_of_every_second_row():
    clip = read_bvh(WALK)
    new = rewriting.resample_clip(clip, 60.0).clip
    lines = [data.split(b"Frame Time:")[1].splitlines()[1:] for data in (clip.data, new.data)]
    assert lines[1] == lines[0][::2]
    assert (new.frames, new.fps) == (172, pytest.approx(60.0, rel=1e-6))


def test_twice_the_rate_keeps_all_rows_and_turns_halfway_between():
    angles = np.array([[0.0, 0, 0], [90, 0, 0], [90, 50, 20], [90, 50, 20]])
    rows = np.array(still(angles))
    rows[:, 12] = [170, -170, -170, 20]  # a joint with two channels
    rows[1, 0] = 4.0
    clip = clip_of(rows)
    done = rewriting.resample_clip(clip, 80.0)
    new = done.clip
    assert new.frames == 7
    assert tokens(new)[:14] == tokens(clip)[:14]
    np.testing.assert_array_equal(new.values[::2], clip.values)
    q = clip.motion.rotations
    middle = slerp(q[:-1], q[1:], np.full((3, 3), 0.5))
    assert np.degrees(geodesic_angle(new.motion.rotations[1::2], middle))[:, :2].max() < 1e-5
    np.testing.assert_allclose(new.values[1::2, 0], [2, 2, 0])
    np.testing.assert_allclose(new.values[1::2, 12], [180, -170, -255])
    assert tokens(new)[14 * 5 : 14 * 6 - 2] == tokens(clip)[14 * 2 : 14 * 3 - 2]  # nothing moves
    assert {c.joint for c in done.changes} == {"Hips", "Left Arm", "Élan"}


@settings(deadline=None, max_examples=20)
@given(st.floats(5.0, 200.0))
def test_any_rate_has_the_poses_between_the_frames(fps):
    clip = clip_of(still([[0.0, 10, 20], [30, 40, 60], [-20, 0, 100], [0, 0, 0]]))
    new = rewriting.resample_clip(clip, fps).clip
    times = rewriting.resampled_frame_times(clip.frames, clip.frame_time, fps)
    expected = rewriting.resample_motion(clip.motion, times, 1.0 / fps)
    found = largest_deviation(expected, new.motion)
    assert (found.degrees < 1e-5, found.of_height < 1e-6) == (True, True)
    assert new.frame_time == pytest.approx(1.0 / fps)
    assert (new.frames - 1) / fps < 3 * 0.025 * 1.001 < new.frames / fps * 1.002


@pytest.mark.parametrize(
    ("seconds", "fps", "step"),
    [(0.0083333, 60, 2), (0.0083333, 240, 0.5), (0.01667, 24, 2.5), (1 / 120, 29.97, 120 / 29.97)],
)
def test_frame_times_with_few_digits_have_the_ratio_that_is_meant(seconds, fps, step):
    times = rewriting.resampled_frame_times(100, seconds, fps)
    np.testing.assert_allclose(np.diff(times), step, rtol=1e-12)
    assert times[-1] <= 99.0 < times[-1] + step


def test_the_same_rate_keeps_the_file(capsys, tmp_path):
    out = tmp_path / "o.bvh"
    code, _, err = run(capsys, "clean", WALK, "-o", out, "--fps", "120")
    assert (code, out.read_bytes()) == (0, WALK.read_bytes())
    assert names_in_one_line(err, "120", "already")


# -- the command -----------------------------------------------------------------------------------


def test_the_command_lists_and_measures_what_it_changed(capsys, tmp_path):
    out = tmp_path / "o.bvh"
    code, document = run_json(capsys, "clean", WALK, "-o", out, "--order", "LeftArm=XYZ")
    assert code == 0
    [change] = document["changes"]
    assert (change["option"], change["joint"], change["words"]) == ("order", "LeftArm", 2)
    assert 0.0 < document["largest"]["degrees"] < 1e-4
    code, printed, err = run(capsys, "clean", WALK, "-o", out, "--order", "LeftArm=XYZ")
    assert (code, err) == (0, "")
    assert all(word in printed for word in ("LeftArm", str(change["numbers"]), "read again"))
    assert read_bvh(out).channels[read_bvh(WALK).skeleton.index("LeftArm")].order == "XYZ"


def test_axes_and_units_are_listed_by_their_options(capsys, tmp_path):
    out = tmp_path / "o.bvh"
    code, document = run_json(capsys, "clean", WALK, "-o", out, "--up", "z", "--scale", "2")
    assert (code, [*dict.fromkeys(c["option"] for c in document["changes"])]) == (
        0,
        ["up", "scale"],
    )
    before, after = (forward_kinematics(read_bvh(path).motion)[1] for path in (WALK, out))
    np.testing.assert_allclose(after, 2.0 * before[..., [0, 2, 1]] * (1, -1, 1), atol=1e-6)


def test_a_name_in_an_unknown_encoding_is_written_as_it_is(capsys, tmp_path):
    poses, out = amc_files.written(tmp_path, False), tmp_path / "o.bvh"
    for file in (poses, *tmp_path.glob("*.asf")):
        file.write_bytes(file.read_bytes().replace(b"lhand", b"m\xe8in"))
    assert run(capsys, "clean", poses, "-o", out, "--unroll")[0] == 0
    assert b"JOINT m\xe8in\n" in out.read_bytes()


def test_nothing_to_change_writes_the_same_bytes(capsys, tmp_path):
    out = tmp_path / "o.bvh"
    code, printed, _ = run(capsys, "clean", WALK, "-o", out, "--up", "y", "--channels", "3")
    assert (code, out.read_bytes()) == (0, WALK.read_bytes())
    assert "0 numbers and 0 words" in printed


def test_a_difference_beyond_the_limits_is_a_problem(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(clean_command, "LIMITS", (0.0, 1.0))
    code, _, err = run(capsys, "clean", WALK, "-o", tmp_path / "o.bvh", "--order", "XYZ")
    assert code == 1
    assert names_in_one_line(err, "o.bvh", "differs")


def test_the_known_namings_lead_to_each_other(capsys, tmp_path):
    smpl, cmu = tmp_path / "smpl.bvh", tmp_path / "cmu.bvh"
    _, document = run_json(capsys, "clean", WALK, "-o", smpl, "--rename", "smpl")
    assert document["renamed"]["LeftForeArm"] == "left_elbow"
    assert len(document["renamed"]) == 24
    assert run_json(capsys, "clean", smpl, "-o", cmu, "--rename", "cmu")[0] == 0
    assert cmu.read_bytes() == WALK.read_bytes()


@pytest.mark.parametrize(
    "text",
    [
        '{"Hips": "root", "Tail": "t"}',
        '\ufeff{"Hips": "root", "Tail": "t"}',
        "Hips,root\r\n\r\nTail,t\r\n",
        "Hips;root\nTail;t",
        "\ufeffHips,root\r\n\r\nTail,t\r\n",
    ],
)
def test_a_map_renames_the_joints_that_there_are(text, capsys, tmp_path):
    table, out = tmp_path / "map", tmp_path / "o.bvh"
    table.write_text(text, encoding="utf-8")
    code, printed, err = run(capsys, "clean", WALK, "-o", out, "--rename", table)
    assert (code, read_bvh(out).skeleton.names[0]) == (0, "root")
    assert "Hips → root" in printed
    assert names_in_one_line(err, "Tail")


@pytest.mark.parametrize(
    ("words", "facts"),
    [
        ((), ("--unroll", "--fps")),
        (("--keep-moving", "--unroll"), ("--channels",)),
        (("--order", "Tail=XYZ"), ("'Tail'",)),
        (("--order", "XXY"), ("'XXY'",)),
        (("--scale", "-1"), ("'-1'",)),
        (("--scale", "1e-300"), ("1e-6", "1e6", "'1e-300'")),
        (("--fps", "0"), ("'0'",)),
        (("--up", "x"), ("'X'", "Y", "Z")),
        (("--channels", "4"), ("'4'", "3")),
        (("--rename", "none.json"), ("none.json",)),
        (("--rename", "three.csv"), ("three.csv", "a,b,c")),
        (("--rename", "number.json"), ("number.json", "Hips")),
        (("--rename", "other.json"), ("other.json",)),
    ],
)
def test_bad_words_are_one_sentence_and_write_nothing(words, facts, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "three.csv").write_text("a,b,c\n")
    (tmp_path / "number.json").write_text('{"Hips": 1}')
    (tmp_path / "other.json").write_text('{"Tail": "t"}')
    code, out, err = run(capsys, "clean", WALK, "-o", "o.bvh", *words)
    assert (code, out) == (2, "")
    assert names_in_one_line(err, *facts)
    assert not (tmp_path / "o.bvh").exists()


def test_joints_that_share_a_name_are_renamed_only_together(capsys, tmp_path):
    clip, table, out = tmp_path / "w.bvh", tmp_path / "map.json", tmp_path / "o.bvh"
    clip.write_bytes(WALK.read_bytes().replace(b"JOINT RightArm", b"JOINT LeftArm"))
    second = read_bvh(clip).skeleton.names.index("LeftArm #2")
    table.write_text('{"LeftArm": "upper"}')
    code, _, err = run(capsys, "clean", clip, "-o", out, "--rename", table)
    assert code == 2
    assert names_in_one_line(err, "LeftArm #2")
    assert not out.exists()
    table.write_text('{"LeftArm": "upper", "LeftArm #2": "other"}')
    assert run(capsys, "clean", clip, "-o", out, "--rename", table)[0] == 0
    assert read_bvh(out).skeleton.names[second] == "other"
    table.write_text('{"Hips": "root"}')
    assert run(capsys, "clean", clip, "-o", out, "--rename", table)[0] == 0
    assert read_bvh(out).skeleton.names[second] == "LeftArm #2"


def test_neither_the_clip_nor_the_map_is_replaced(capsys, tmp_path):
    clip, table = tmp_path / "w.bvh", tmp_path / "map.bvh"
    clip.write_bytes(WALK.read_bytes())
    table.write_text('{"Hips": "root"}')
    for output in (clip, table):
        code, _, err = run(capsys, "clean", clip, "-o", output, "--rename", table)
        assert code == 2
        assert names_in_one_line(err, output.name)
    assert clip.read_bytes() == WALK.read_bytes()


def test_a_pipe_gets_the_clip_alone(capfdbinary, monkeypatch):
    monkeypatch.setattr(sys, "stdin", WALK.open())
    with sys.stdin:
        assert main(["clean", "-", "-o", "-", "--order", "XYZ"]) == 0
    out, err = capfdbinary.readouterr()
    assert farthest(read_bvh(WALK), parse_bvh(out)) < 1e-4
    assert b"read again" in err


def test_poses_of_another_format_are_written_as_bvh(capsys, tmp_path):
    poses, out = tmp_path / "p.npz", tmp_path / "o.bvh"
    write_amass(poses, read_bvh(ASSETS / "kick.bvh").motion)
    code, _, err = run(capsys, "clean", poses, "-o", out, "--unroll", "--fps", "30")
    assert (code, read_bvh(out).fps) == (0, pytest.approx(30.0))
    assert any("p.npz" in line and "BVH" in line for line in err.splitlines())
    assert run(capsys, "clean", poses, "-o", tmp_path / "o.npz", "--unroll")[0] == 2


def test_the_encoding_of_a_wide_file_is_kept(capsys, tmp_path):
    wide, out = tmp_path / "w.bvh", tmp_path / "o.bvh"
    wide.write_bytes("\ufeff".encode("utf-16-le") + WALK.read_text().encode("utf-16-le"))
    words = ("--fps", "50", "--order", "XYZ", "--rename", "smpl", "--scale", "2")
    code, _, _ = run(capsys, "clean", wide, "-o", out, *words)
    assert code == 0
    assert out.read_bytes().decode("utf-16").startswith("HIERARCHY")
