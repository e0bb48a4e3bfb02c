"""Places in position channels and OFFSET 0 in the header: the skeleton comes from the motion."""

import re
from pathlib import Path

import numpy as np
import pytest

from twistcore import detect, find_chains, read_clip, write_clip
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.bvh.channels import with_offsets_from_positions
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.motion import Skeleton, forward_kinematics

SAMPLE = Path("assets/walk_injected.bvh")
FRAMES = 344


def with_places(*, header, stretch=0.0, missing=()):
    """The sample's first frames with position channels on all joints.

    header: whether OFFSET keeps the bones; stretch: noise as a share of each bone; missing: frames
    whose places are 0.
    """
    clip = read_clip(SAMPLE)
    head = SAMPLE.read_bytes()[: clip.data_start].decode()
    shape = (FRAMES, len(clip.skeleton), 3)
    noise = 1.0 + stretch * np.random.default_rng(1).standard_normal(shape)
    places = clip.skeleton.offsets * noise
    places[list(missing)] = 0.0
    rows = []
    for joint, layout in enumerate(clip.channels):
        if not layout.position:
            rows.append(places[:, joint])
        rows.append(clip.values[:FRAMES, min(_columns(layout)) : max(_columns(layout)) + 1])
    head = re.sub(r"CHANNELS\s+3", "CHANNELS 6 Xposition Yposition Zposition", head)
    head = re.sub(r"Frames:\s*\d+", f"Frames: {FRAMES}", head)
    if not header:
        joints = re.compile(r"(JOINT \S+\s*\{\s*OFFSET)([^\r\n]*)")
        head = joints.sub(r"\1 0 0 0", head)
    table = np.concatenate(rows, axis=1)
    return (head.rstrip() + "\n" + _text(table)).encode()


def _columns(layout):
    return [*layout.rotation, *(column for _, column in layout.position)]


def _text(table):
    return "".join(" ".join(f"{v:.6f}" for v in row) + "\n" for row in table.tolist())


@pytest.fixture(scope="module")
def both():
    return tuple(parse_bvh(with_places(header=header), "six.bvh") for header in (True, False))


def test_chains_labels_and_axes_are_the_same_as_with_offsets(both):
    given, zero = (find_chains(clip.motion) for clip in both)
    assert [c.label for c in zero] == [c.label for c in given]
    assert len(zero) == 10
    for one, other in zip(given, zero, strict=True):
        np.testing.assert_allclose(one.axis, other.axis, atol=1e-6)
        np.testing.assert_allclose(one.arm, other.arm, atol=1e-6)


def test_height_up_and_heading_are_the_same_as_with_offsets(both):
    seen = []
    for clip in both:
        motion = clip.motion
        positions = forward_kinematics(motion)[1]
        chains = find_chains(motion)
        up = guess_up(positions, chains, motion.skeleton)
        size = figure_size(positions, motion.skeleton)
        seen.append(
            [
                motion.skeleton.height,
                size,
                *up,
                *figure_facing_direction(positions[100], chains, up),
            ]
        )
    np.testing.assert_allclose(seen[0], seen[1], rtol=1e-6, atol=1e-6)
    assert seen[0][0] > 10.0


def test_the_same_errors_are_found(both):
    given, zero = (detect(clip) for clip in both)
    assert len(given) > 0
    assert [(i.chain, i.start, i.stop) for i in given] == [(i.chain, i.start, i.stop) for i in zero]


def test_the_file_s_header_and_the_clip_s_own_skeleton_stay(both, tmp_path):
    _, zero = both
    assert not zero.skeleton.offsets[1:].any()
    rotations = zero.motion.rotations.copy()
    rotations[10, 5] = rotations[11, 5]
    write_clip(zero, zero.motion.with_rotations(rotations), tmp_path / "out.bvh")
    written = (tmp_path / "out.bvh").read_bytes()
    assert written[: zero.data_start] == zero.data[: zero.data_start]
    assert sum(a != b for a, b in zip(written.split(), zero.data.split(), strict=True)) <= 3


@pytest.mark.parametrize(("stretch", "missing"), [(0.05, ()), (0.0, (0, 1, 50))])
def test_bones_that_stretch_or_miss_some_frames_are_bones(stretch, missing):
    clip = parse_bvh(with_places(header=False, stretch=stretch, missing=missing), "six.bvh")
    found = read_clip(SAMPLE).skeleton.height
    assert clip.motion.skeleton.height == pytest.approx(found, rel=0.02)


def skeleton(parents, offsets):
    names = tuple(f"j{k}" for k in range(len(parents)))
    return Skeleton(names, np.array(parents), np.array(offsets, dtype=float))


def test_hips_that_travel_below_a_reference_are_no_bone():
    figure = skeleton([-1, 0, 1, 1, 1], [(0, 0, 0), (0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 2, 0)])
    walk = np.zeros((50, 1, 3))
    walk[:, 0, 2] = np.linspace(20.0, 30.0, 50)
    assert with_offsets_from_positions(figure, (1,), walk) is figure


def test_two_pairs_of_hips_below_one_reference_are_no_bones():
    parents = [-1, 0, 1, 1, 1, 0, 5, 5, 5]
    offsets = np.ones((9, 3))
    offsets[[0, 1, 5]] = 0.0
    figure = skeleton(parents, offsets)
    walk = np.zeros((50, 2, 3))
    walk[:, :, 1] = 10.0
    walk[:, 0, 0] = np.linspace(0.0, 3.0, 50)
    walk[:, 1, 0] = np.linspace(9.0, 6.0, 50)
    assert with_offsets_from_positions(figure, (1, 5), walk) is figure


def test_an_offset_is_kept_whatever_the_channels_say():
    figure = skeleton([-1, 0, 0], [(0, 0, 0), (0, 1, 0), (0, 0, 0)])
    places = np.broadcast_to([[0.0, 3.0, 0.0], [2.0, 0.0, 0.0]], (9, 2, 3))
    placed = with_offsets_from_positions(figure, (1, 2), places)
    np.testing.assert_array_equal(placed.offsets, [(0, 0, 0), (0, 1, 0), (2, 0, 0)])
    np.testing.assert_array_equal(figure.offsets[2], 0.0)


def test_places_of_zero_give_no_bone():
    figure = skeleton([-1, 0], [(0, 0, 0), (0, 0, 0)])
    assert with_offsets_from_positions(figure, (0, 1), np.zeros((9, 2, 3))) is figure
