"""A motion of one's own is written and read back; nobody's source is replaced by accident."""

from dataclasses import replace

import numpy as np
import pytest

import twistcore
from tests.conftest import ASSETS
from tests.messages import names_in_one_line, refused
from tests.twistcore.test_bvh_numbers import MIXED
from twistcore.errors import TwistError
from twistcore.files.atomic import STANDARD_OUTPUT
from twistcore.formats.bvh import parse_bvh, read_bvh, write_motion
from twistcore.formats.clip import create_file_patch_for_motion, write_clip
from twistcore.skeleton.motion import Motion, Skeleton, forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, normalise, quaternion_from_axis_angle


def own():
    """Two roots, joints with positions, with two End Sites, with none, and any rotation."""
    rng = np.random.default_rng(4)
    skeleton = Skeleton(
        names=("Hips", "left arm: a}", "Hand", "Tail", "Prop"),
        parents=np.array([-1, 0, 1, 0, -1]),
        offsets=rng.normal(size=(5, 3)),
        ends=((0, (0.0, -0.5, 0.25)), (2, (0.1, 0.2, 0.3)), (2, (1.0, 0.0, 0.0)), (3, (0, 1, 0))),
    )
    rotations = normalise(rng.normal(size=(40, 5, 4)))
    return Motion(skeleton, rotations, (0, 3), 9.0 * rng.normal(size=(40, 2, 3)), 1.0 / 24.0)


def thinner_and_slower():
    """Every third frame of a clip, at a third of its rate."""
    motion = read_bvh(ASSETS / "walk.bvh").motion
    kept = replace(motion, rotations=motion.rotations[::3], positions=motion.positions[::3])
    return replace(kept, frame_time=3.0 * motion.frame_time)


@pytest.mark.parametrize(
    "motion",
    [own(), thinner_and_slower(), parse_bvh(MIXED).motion, own().sliced(3, 4)],
    ids=["own", "thinner", "mixed", "one frame"],
)
def test_a_motion_is_read_back(motion, tmp_path):
    path = tmp_path / "own.bvh"
    write_motion(motion, path)
    clip = read_bvh(path)
    found, skeleton = clip.motion, motion.skeleton
    assert clip.warnings == ()
    assert (found.frames, found.skeleton.names) == (motion.frames, skeleton.names)
    assert found.fps == pytest.approx(motion.fps, rel=1e-6)
    np.testing.assert_array_equal(found.skeleton.parents, skeleton.parents)
    np.testing.assert_allclose(found.skeleton.offsets, skeleton.offsets, atol=1e-6)
    for joint, children in enumerate(skeleton.children):
        there, here = ([o for k, o in s.ends if k == joint] for s in (found.skeleton, skeleton))
        if here or children:
            np.testing.assert_allclose(there, here, atol=1e-6)
        else:  # given to it, since many readers need one
            assert len(there) == 1
    assert geodesic_angle(found.rotations, motion.rotations).max() < 1e-7
    for a, b in zip(forward_kinematics(found), forward_kinematics(motion), strict=True):
        if a.shape[-1] == 3:
            np.testing.assert_allclose(a, b, atol=1e-5)
    for joint in motion.positioned:
        np.testing.assert_allclose(found.translation(joint), motion.translation(joint), atol=1e-6)


def test_a_chain_of_a_thousand_joints_is_written(tmp_path):
    joints = 1500
    names = tuple(f"J{k}" for k in range(joints))
    skeleton = Skeleton(names, np.arange(-1, joints - 1), np.ones((joints, 3)))
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (2, joints, 1))
    twistcore.write_motion(
        Motion(skeleton, rotations, (), np.zeros((2, 0, 3)), 0.1), tmp_path / "a"
    )
    assert read_bvh(tmp_path / "a").skeleton.names == names


def with_number(field, value):
    motion = own()
    values = getattr(motion, field).copy()
    values[2, 1, 0] = value
    return replace(motion, **{field: values})


def with_skeleton(**changes):
    motion = own()
    return replace(motion, skeleton=replace(motion.skeleton, **changes))


@pytest.mark.parametrize(
    ("motion", "words"),
    [
        (own().sliced(0, 0), "one joint"),
        (with_number("rotations", np.nan), r"rotations.* nan .*\[2, 1, 0\]"),
        (with_number("positions", -np.inf), r"positions.* -inf .*\[2, 1, 0\]"),
        (with_number("positions", 1e100), "1e\\+100"),
        (with_skeleton(offsets=np.full((5, 3), np.nan)), "OFFSET"),
        (with_skeleton(ends=((2, (0.0, np.inf, 0.0)),)), "End Site"),
        (with_skeleton(names=("a", "b", "c\nd", "e", "f")), "name"),
        (with_skeleton(names=("a", "b {", "c", "d", "e")), "name"),
        (replace(own(), frame_time=0.0), "0.0001 to 1 s.* 0"),
        (replace(own(), frame_time=np.nan), "nan"),
    ],
)
def test_what_would_not_be_read_back_is_refused_in_a_sentence(motion, words, tmp_path):
    path = tmp_path / "own.bvh"
    path.write_bytes(b"old")
    with pytest.raises(TwistError, match=words) as caught:
        write_motion(motion, path)
    assert names_in_one_line(str(caught.value), path)
    assert path.read_bytes() == b"old"


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "clip.bvh"
    path.write_bytes((ASSETS / "walk.bvh").read_bytes())
    return path


def test_the_source_of_a_clip_is_replaced_only_if_told(source, tmp_path):
    (tmp_path / "link.bvh").symlink_to(source)
    (tmp_path / "hard.bvh").hardlink_to(source)
    (tmp_path / "folder").mkdir()
    clip = read_bvh(source)
    motion = clip.motion.with_rotations(np.roll(clip.motion.rotations, 1, axis=0))
    others = (tmp_path / name for name in ("link.bvh", "hard.bvh", "folder/../clip.bvh"))
    for path in (source, str(source), *others):
        with refused(TwistError, str(path)):
            write_clip(clip, motion, path)
    assert source.read_bytes() == clip.data
    write_clip(clip, motion, tmp_path / "other.bvh")
    write_clip(clip, motion, source, replace_source=True)
    assert source.read_bytes() == (tmp_path / "other.bvh").read_bytes() != clip.data


def test_a_source_that_is_gone_is_in_nobodys_way(source):
    clip = read_bvh(source)
    source.unlink()
    write_clip(clip, clip.motion, source)
    assert source.read_bytes() == clip.data


def test_a_stream_is_written_into_though_the_clip_came_from_it(walk, capfdbinary):
    clip = parse_bvh(walk.data, STANDARD_OUTPUT)
    write_clip(clip, clip.motion, STANDARD_OUTPUT)
    assert capfdbinary.readouterr().out == walk.data


def test_every_repr_is_one_informative_line(walk):
    assert repr(walk) == "<Clip walk.bvh: 344 frames at 120 fps, 31 joints>"
    assert repr(walk.motion) == "<Motion: 344 frames at 120 fps, 31 joints>"
    assert repr(walk.skeleton) == "<Skeleton: 31 joints from Hips>"
    assert repr(own().skeleton) == "<Skeleton: 5 joints from Hips, Prop>"
    nothing = np.zeros(walk.motion.rotations.shape[:2], dtype=bool)
    assert repr(walk.patched(walk.motion, nothing)) == "Patch(jumps=())"


def test_beside_an_angle_of_millions_of_turns_the_rotations_are_still_the_corrected_ones(walk):
    """As near to it as it is written, no digit would be left for the angle itself."""
    joint, column = 5, walk.channels[5].rotation[0]
    rows = walk.data[walk.data.index(b"Frame Time") :].splitlines(keepends=True)
    words = rows[21].split()
    words[column] = b"-2.44e19"
    data = walk.data.replace(rows[21], b" ".join(words) + b"\n")
    clip = parse_bvh(data)
    rotations = clip.motion.rotations.copy()
    rotations[10:20, joint] = quaternion_from_axis_angle(np.array([0.6, 0.0, 0.8]), 0.5)
    patch = create_file_patch_for_motion(clip, clip.motion.with_rotations(rotations))
    again = parse_bvh(patch.data).motion.rotations
    assert geodesic_angle(again, rotations).max() < 1e-5
    assert [jump.frame for jump in patch.jumps] == [20]
