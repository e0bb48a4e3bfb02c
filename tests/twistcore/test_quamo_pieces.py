"""A clip with cuts is tracked and smoothed capture by capture; its figure's place is found so."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.cli import main
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.bvh.compose import write_motion
from twistcore.formats.clip import write_clip
from twistcore.quamo import Gains, HandGains, track
from twistcore.quamo.clip_tracking import (
    check_tracking_fits_motion,
    network_weights_identifier,
    track_motion_with_internal_values,
    tracked_motion,
)
from twistcore.quamo.network import initial_gain_network_for_training
from twistcore.quamo.pieces import capture_start_frames_after, frame_ranges_between_cuts
from twistcore.quamo.track_clip import (
    check_position_trackable,
    find_figure_position_joint,
    select_writable_joints,
    smooth_captures_with_spline,
    track_with_hand_gains,
    track_with_network,
    untracked_rotating_and_moving_joints,
)
from twistcore.review import Tracking

WALK = read_bvh(ASSETS / "walk.bvh")
MOTION = WALK.motion
CAPTURE = MOTION.sliced(1, 151)
OTHER = read_bvh(ASSETS / "dance.bvh").motion.sliced(101, 221)
JOINTS = select_writable_joints(MOTION.skeleton, None)
NETWORK = initial_gain_network_for_training(8, 4, np.random.default_rng(0), "full")


def joined(*parts):
    return replace(
        MOTION,
        rotations=np.concatenate([part.rotations for part in parts]),
        positions=np.concatenate([part.positions for part in parts]),
    )


CUT = joined(CAPTURE, OTHER)


def both_ways(motion, **options):
    return track_with_hand_gains(motion, JOINTS, causal=False, place=True, **options).motion


def learned(motion, **options):
    return track_with_network(motion, JOINTS, NETWORK, causal=False, place=True, **options).motion


def spline(motion, **options):
    return smooth_captures_with_spline(motion, JOINTS, place=True, **options)


WAYS = pytest.mark.parametrize("way", [both_ways, learned, spline])


def assert_same(found, expected):
    np.testing.assert_array_equal(found.rotations, expected.rotations)
    np.testing.assert_array_equal(found.positions, expected.positions)


def test_a_clip_without_cuts_is_one_piece_and_one_with_a_cut_two():
    assert frame_ranges_between_cuts(MOTION, 1) == ((1, MOTION.frames),)
    assert capture_start_frames_after(CUT, 0).tolist() == [150]
    assert frame_ranges_between_cuts(CUT, 0) == ((0, 150), (150, 270))
    assert frame_ranges_between_cuts(CUT, 3) == ((3, 150), (150, 270))


@WAYS
def test_across_a_cut_nothing_is_smeared(way):
    assert_same(way(CUT), joined(way(CAPTURE), way(OTHER)))


@WAYS
@pytest.mark.parametrize("length", [1, 10])
def test_a_rest_pose_at_the_end_stays_and_moves_nothing_before_it(way, length):
    rest = MOTION.sliced(0, 1)
    clip = joined(CAPTURE, *[rest] * length)
    end = int(capture_start_frames_after(clip, 0)[0])
    assert end == CAPTURE.frames
    found = way(clip)
    assert_same(found.sliced(end, clip.frames), clip.sliced(end, clip.frames))
    assert_same(found.sliced(0, end), way(CAPTURE))


def test_the_causal_way_goes_through_a_cut_as_the_tracker_does():
    found = track_with_hand_gains(CUT, JOINTS, place=True).motion
    expected = track(CUT.rotations, CUT.positions[:, 0], CUT.frame_time, HandGains())
    np.testing.assert_array_equal(found.rotations[:, JOINTS], expected.q[:, JOINTS])
    np.testing.assert_array_equal(found.positions[:, 0], expected.r)


def test_where_nothing_is_captured_nothing_is_tracked(monkeypatch):
    every = np.ones(CAPTURE.frames, dtype=np.bool_)
    monkeypatch.setattr("twistcore.quamo.pieces.find_cuts", lambda _motion: every)
    tracking = Tracking(("LeftArm",), causal=False, kp=900.0, kd=20.0)
    found, traces = track_motion_with_internal_values(CAPTURE, tracking)
    assert_same(found, CAPTURE)
    assert traces.gains.shape == (0, 1, 3)
    assert find_figure_position_joint(CAPTURE) == 0


def test_what_is_done_is_told_once_over_all_pieces():
    reported = []
    track_with_hand_gains(CUT, JOINTS[:2], causal=False, tell=reported.append)
    assert reported == sorted(reported)
    assert reported[0] == 0.0
    assert 0.8 < reported[-1] < 1.0


@pytest.mark.parametrize("causal", [True, False])
def test_refine_writes_the_bytes_of_a_session_and_names_the_cut(capsys, tmp_path, causal):
    source, out, expected = (tmp_path / f"{name}.bvh" for name in ("cut", "out", "expected"))
    write_motion(CUT, source)
    clip = read_bvh(source)
    gains = Gains.by_hand(clip.frame_time, causal=causal)
    names = tuple(clip.skeleton.names)
    tracking = Tracking(names, causal=causal, place=True, kp=gains.kp, kd=gains.kd, ka=0.0)
    motion, traces = track_motion_with_internal_values(clip.motion, tracking)
    assert_same(motion, tracked_motion(clip.motion, tracking))
    if not causal:
        assert traces.frames.tolist() == list(range(CUT.frames))
    write_clip(clip, motion, expected)
    words = ["quamo", "refine", str(source), "-o", str(out)]
    assert main(words + (["--causal"] if causal else ["--method", "quamo"])) == 0
    assert out.read_bytes() == expected.read_bytes()
    reported = capsys.readouterr().out
    assert ("frame 150: " in reported) == (not causal)


def with_places(moving, *, motion=MOTION):
    """The motion with position channels on every joint; moving: how far some go, by name."""
    skeleton = motion.skeleton
    places = np.broadcast_to(skeleton.offsets, (motion.frames, *skeleton.offsets.shape)).copy()
    for name, way in moving.items():
        places[:, skeleton.index(name)] += np.asarray(way)[:, None]
    return replace(motion, positioned=tuple(range(len(skeleton))), positions=places)


def test_the_figures_place_is_that_of_a_joint_that_carries_the_figure():
    names = MOTION.skeleton.names
    wave = np.sin(np.arange(MOTION.frames) / 7.0)
    thumb = with_places({"LThumb": wave})
    assert names[find_figure_position_joint(thumb)] == "Hips"
    assert untracked_rotating_and_moving_joints(thumb, JOINTS, find_figure_position_joint(thumb))[
        1
    ] == ("LThumb",)
    assert (
        names[find_figure_position_joint(with_places({"LThumb": wave, "LowerBack": wave}))]
        == "LowerBack"
    )
    assert (
        names[find_figure_position_joint(with_places({"Hips": wave, "LowerBack": wave}))] == "Hips"
    )
    at = MOTION.skeleton.index("LThumb")
    alone = replace(thumb, positioned=(at,), positions=thumb.positions[:, [at]])
    assert find_figure_position_joint(alone) is None
    with pytest.raises(TwistError, match="position channels"):
        check_position_trackable(alone)


@pytest.mark.parametrize("rest", [slice(0, 1), slice(-1, None)])
def test_a_jump_out_of_or_into_a_rest_pose_is_no_way_that_a_place_goes(rest):
    jump = np.zeros(MOTION.frames)
    jump[rest] = 5.0
    motion = joined(CAPTURE, MOTION.sliced(0, 1)) if rest.start else MOTION
    jump, wave = jump[-motion.frames :], np.sin(np.arange(motion.frames) / 7.0)
    found = with_places({"Hips": jump, "LowerBack": wave}, motion=motion)
    assert motion.skeleton.names[find_figure_position_joint(found)] == "LowerBack"
    assert untracked_rotating_and_moving_joints(found, JOINTS, None)[1] == ("LowerBack",)


def test_learned_gains_refuse_a_place_that_is_not_of_their_root():
    wave = np.sin(np.arange(MOTION.frames) / 7.0)
    motion = with_places({"LowerBack": wave})
    tracking = Tracking(
        ("LeftArm",), learned=True, weights=network_weights_identifier(), causal=False, place=True
    )
    for track_it in (lambda: learned(motion), lambda: check_tracking_fits_motion(motion, tracking)):
        with pytest.raises(TwistError, match=r"'Hips'.*'LowerBack'"):
            track_it()
    kept = track_with_network(motion, JOINTS, NETWORK, causal=False).motion
    np.testing.assert_array_equal(kept.positions, motion.positions)
    check_tracking_fits_motion(motion, replace(tracking, place=False))
    check_tracking_fits_motion(MOTION, tracking)
