"""`twistcore quamo …`: its words, what it changes on disk, its refusals and its tables."""

import json
import re

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.tiers import parametrize
from tests.twistcore.test_cli import run
from tests.twistcore.test_noise_bursts import ARM, HAND, START, STOP, noisy
from tests.twistcore.test_quamo_data import write_poses
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.quamo import Gains, HandGains, Stepper, track, track_both_ways
from twistcore.quamo.bursts import noise_burst_spans_to_smooth
from twistcore.quamo.network import initial_gain_network_for_training, write_gain_network_weights
from twistcore.quamo.response import steady_tracking_lags, tracking_overshoots
from twistcore.quamo.track_clip import smooth_captures_with_spline
from twistcore.quamo.weights import gain_network_file_name
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.study.quamo.bars import BoundCheck
from twistcore.study.quamo.sequences import read_cmu_bvh_sequence

BOTH_WAYS = ("--method", "quamo")
WALK, DIRTY, DANCE = (ASSETS / f"{n}.bvh" for n in ("walk", "walk_injected", "dance"))


def run_quamo(capsys, *words):
    return run(capsys, "quamo", *words)


@pytest.fixture
def weights(tmp_path):
    for subject in ("none", "05", "06"):
        network = initial_gain_network_for_training(8, 4, np.random.default_rng(0), "full")
        write_gain_network_weights(network, tmp_path / gain_network_file_name("full", subject))
    return tmp_path


def turned(clip, joint, run, gains=None):
    """What `run` makes of a joint of a clip behind its T-pose."""
    q = clip.motion.rotations[1:, [clip.skeleton.index(joint)]]
    return run(q, np.zeros((len(q), 3)), clip.frame_time, HandGains(gains)).q[:, 0]


def moved(clip, run):
    """What `run` makes of the root's place behind the T-pose."""
    r = clip.motion.positions[1:, 0]
    return run(np.zeros((len(r), 0, 4)), r, clip.frame_time, HandGains()).r


@pytest.mark.parametrize(("way", "run"), [(BOTH_WAYS, track_both_ways), (("--causal",), track)])
def test_refine_tracks_and_changes_only_the_chosen_joints(capsys, tmp_path, way, run):
    out = tmp_path / "out.bvh"
    code, told, err = run_quamo(
        capsys, "refine", WALK, "-o", out, "--joints", "LeftArm", "Spine", *way
    )
    assert code == 0
    assert "2 joints" in told
    assert "Hips" in told
    assert "Spine1" not in told  # who names joints knows which are left
    assert err == ""
    before, after = read_bvh(WALK), read_bvh(out)
    changed = [
        name
        for j, name in enumerate(before.skeleton.names)
        if (before.values != after.values)[:, list(before.channels[j].rotation)].any()
    ]
    assert changed == ["Spine", "LeftArm"]
    assert (before.values[0] == after.values[0]).all()  # the T-pose is no capture
    assert (before.values[:, :3] == after.values[:, :3]).all()
    found = after.motion.rotations[1:, before.skeleton.index("LeftArm")]
    assert np.degrees(geodesic_angle(found, turned(before, "LeftArm", run))).max() < 1e-4


def test_what_moves_and_is_not_tracked_is_named(capsys, tmp_path):
    out = tmp_path / "out.bvh"
    code, told, _ = run_quamo(capsys, "refine", WALK, "-o", out, "--gains", "learned")
    assert code == 0
    left = "Neck1, LeftFingerBase, LThumb, RightFingerBase, RThumb"
    assert left in told  # they turn, and no network knows them; LHipJoint stands still


@parametrize(
    ("options", "place"),
    [
        (BOTH_WAYS, True),
        ((*BOTH_WAYS, "--no-root-position"), False),
        ((*BOTH_WAYS, "--joints", "Hips"), True),
        ((*BOTH_WAYS, "--joints", "Spine"), False),
        ((*BOTH_WAYS, "--joints", "Spine", "--root-position"), True),
        ((*BOTH_WAYS, "--joints", "Hips", "--no-root-position"), False),
        (("--gains", "learned"), True),
    ],
    quick=2,
)
def test_the_roots_place_is_tracked_unless_it_is_left_out(capsys, tmp_path, options, place):
    out = tmp_path / "out.bvh"
    code, told, _ = run_quamo(capsys, "refine", WALK, "-o", out, *options)
    assert (code, "Hips" in told) == (0, True)
    before, after = read_bvh(WALK), read_bvh(out)
    changed = (before.values != after.values)[1:, :3].any(axis=0)
    assert changed.all() if place else not changed.any()
    if place and "learned" not in options:
        assert np.abs(after.values[1:, :3] - moved(before, track_both_ways)).max() < 1e-6


def test_the_causal_way_writes_the_bytes_of_the_tracker_frame_by_frame(capsys, tmp_path):
    out, expected = tmp_path / "out.bvh", tmp_path / "expected.bvh"
    assert run_quamo(capsys, "refine", WALK, "-o", out, "--causal", "--no-root-position")[0] == 0
    clip = read_bvh(WALK)
    rotations = clip.motion.rotations.copy()
    tracker = Stepper(HandGains())
    for q in rotations[1:]:
        q[:] = tracker.step(q, np.zeros(3), clip.frame_time).state.q
    write_clip(clip, clip.motion.with_rotations(rotations), expected)
    assert out.read_bytes() == expected.read_bytes()


def test_the_causal_way_says_what_it_does_not_do_and_the_other_what_it_needs(capsys, tmp_path):
    out = tmp_path / "out.bvh"
    told = run_quamo(capsys, "refine", WALK, "-o", out, "--causal")[1]
    assert all(fact in told for fact in ("14 ms", "19 %", "18 ms", "21 %"))
    told = run_quamo(capsys, "refine", WALK, "-o", out, "--causal", "--gains", "learned")[1]
    assert "40 ms" in told
    run_quamo(capsys, "refine", WALK, "-o", out)
    before, after = read_bvh(WALK), read_bvh(out)
    dt = before.frame_time
    late, over = (
        steady_tracking_lags(Gains.by_hand(dt), dt),
        tracking_overshoots(Gains.by_hand(dt), dt),
    )
    assert late == pytest.approx((0.0140, 0.0184), abs=1e-4)
    assert over == pytest.approx((0.191, 0.207), abs=1e-3)
    assert len(before.values) == len(after.values)


@pytest.mark.parametrize(
    ("options", "facts"), [(("--kp", 0), ("κP", "18 ms")), (("--fps", 4), ("16 ms", "15 %"))]
)
def test_a_lag_that_is_none_is_said_in_other_words(capsys, tmp_path, options, facts):
    words = ("refine", WALK, "-o", tmp_path / "out.bvh", "--causal", *options)
    code, told, _ = run_quamo(capsys, *words)
    assert (code, "inf" in told, " -16 ms" in told) == (0, False, False)
    assert all(fact in told for fact in facts)


def test_passes_that_lie_far_apart_are_said(capsys, tmp_path):
    words = ("refine", DIRTY, "-o", tmp_path / "out.bvh")
    err = run_quamo(capsys, *words, *BOTH_WAYS)[2]
    assert "90°" in err
    weak = (*words, "--joints", "LeftForeArm", "--kp", 5)
    for way in (BOTH_WAYS, ("--causal",)):
        assert re.search("LeftForeArm .*90°.* frame", run_quamo(capsys, *weak, *way)[2])


def test_a_figure_without_a_place_is_tracked_without_one(capsys, tmp_path):
    text = WALK.read_text(encoding="ascii").replace(
        "CHANNELS 6 Xposition Yposition Zposition", "CHANNELS 3", 1
    )
    head, _, motion = text.partition("Frame Time")
    rate, *frames = motion.splitlines()
    rows = [" ".join(line.split()[3:]) for line in frames]
    source, out = tmp_path / "still.bvh", tmp_path / "out.bvh"
    source.write_text("\n".join([head + "Frame Time" + rate, *rows, ""]), encoding="ascii")
    code, told, _ = run_quamo(capsys, "refine", source, "-o", out)
    assert (code, "31 joints" in told) == (0, True)
    out.unlink()
    for way in (BOTH_WAYS, ()):
        code, told, err = run_quamo(capsys, "refine", source, "-o", out, "--root-position", *way)
        assert (code, told, out.exists()) == (2, "", False)
        assert names_in_one_line(err, f"{source}: ", "position channels")


def test_refine_warns_of_twist_errors_that_tracking_would_smear(capsys, tmp_path):
    code, _, err = run_quamo(capsys, "refine", DIRTY, "-o", tmp_path / "out.bvh")
    assert code == 0
    assert "8 intervals" in err


@parametrize(
    ("options", "method"),
    [
        ((), "spline"),
        (("--cutoff", "5"), "spline"),
        (("--gains", "hand"), "tracked both ways"),
        (("--kp", "600"), "tracked both ways"),
        (("--causal",), "tracked causally"),
    ],
    quick=2,
)
def test_a_file_is_smoothed_by_the_spline_unless_an_option_of_the_tracker_is_given(
    capsys, tmp_path, options, method
):
    code, printed, _ = run_quamo(capsys, "refine", WALK, "-o", tmp_path / "out.bvh", *options)
    assert (code, method in printed) == (0, True)


def test_only_bursts_are_smoothed_and_every_other_line_keeps_its_bytes(capsys, tmp_path):
    clip, source, out = read_bvh(WALK), tmp_path / "noisy.bvh", tmp_path / "out.bvh"
    made = noisy(ARM, HAND)
    write_clip(clip, made, source)
    code, printed, err = run_quamo(capsys, "refine", source, "-o", out, "--where", "noisy")
    assert (code, err) == (0, "")
    spans = noise_burst_spans_to_smooth(read_bvh(source).motion)
    start, stop = spans[0].start, spans[0].stop
    assert f"frames {start}–{stop}: LeftArm, LeftForeArm" in printed
    before, after = (path.read_bytes().splitlines(keepends=True) for path in (source, out))
    head = len(before) - clip.frames
    changed = [
        k - head for k, pair in enumerate(zip(before, after, strict=True)) if len({*pair}) > 1
    ]
    assert changed == list(range(start, stop))
    assert START - 10 < start <= START
    assert STOP <= stop < STOP + 10
    columns = (read_bvh(source).values != read_bvh(out).values).any(axis=0)
    own = [list(clip.channels[joint].rotation) for joint in (ARM, HAND)]
    assert set(np.flatnonzero(columns)) <= {*own[0], *own[1]}
    distance = [
        geodesic_angle(m.rotations, clip.motion.rotations) for m in (made, read_bvh(out).motion)
    ]
    assert distance[1][start:stop].mean() < 0.5 * distance[0][start:stop].mean()


def test_a_clip_without_bursts_keeps_its_bytes(capsys, tmp_path):
    out = tmp_path / "out.bvh"
    code, told, _ = run_quamo(capsys, "refine", WALK, "-o", out, "--where", "noisy")
    assert (code, "no burst" in told) == (0, True)
    assert out.read_bytes() == WALK.read_bytes()


def test_bursts_are_smoothed_in_the_named_joints_only(capsys, tmp_path):
    clip, source, out = read_bvh(WALK), tmp_path / "noisy.bvh", tmp_path / "out.bvh"
    write_clip(clip, noisy(ARM, HAND), source)
    words = ("refine", source, "-o", out, "--where", "noisy", "--joints", "LeftArm")
    assert run_quamo(capsys, *words)[0] == 0
    before, after = read_bvh(source), read_bvh(out)
    changed = (before.values != after.values).any(axis=0)
    assert set(np.flatnonzero(changed)) == set(clip.channels[ARM].rotation)


@pytest.mark.parametrize(("options", "cutoff"), [((), 5.92), (("--cutoff", "7"), 7.0)])
def test_the_spline_smooths_the_file_and_says_so(capsys, tmp_path, options, cutoff):
    out = tmp_path / "out.bvh"
    code, told, err = run_quamo(
        capsys, "refine", WALK, "-o", out, "--method", "spline", "--joints", "Hips", *options
    )
    assert (code, err) == (0, "")
    assert re.search(f"1 joint .*Hips.* {cutoff:.2g} Hz", told)
    before, after = read_bvh(WALK), read_bvh(out)
    wanted = smooth_captures_with_spline(before.motion, np.array([0]), cutoff, place=True, first=1)
    assert np.degrees(geodesic_angle(after.motion.rotations, wanted.rotations)).max() < 1e-3
    np.testing.assert_allclose(after.motion.positions, wanted.positions, atol=1e-5)
    assert (before.values[:, 6:] == after.values[:, 6:]).all()
    assert (before.values[0] == after.values[0]).all()  # the T-pose is no capture


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (("--method", "spline", "--kd", "10"), "--kd"),
        (("--method", "spline", "--gains", "learned"), "--gains"),
        (("--method", "spline", "--causal"), "--causal"),
        (("--method", "spline", "--cutoff", "70"), "60 Hz"),
        (("--method", "spline", "--cutoff", "0.1"), "0.12 Hz"),
        ((*BOTH_WAYS, "--cutoff", "5"), "--method spline"),
        (("--kp", "500", "--cutoff", "5"), "--method spline"),
        ((*BOTH_WAYS, "--where", "noisy"), "--method spline"),
        (("--causal", "--where", "noisy"), "--method spline"),
        (("--where", "noisy", "--root-position"), "--root-position"),
        (("--where", "noisy", "--joints", "Nose"), "'Nose'"),
        (("--kd", "1000"), "120 Hz"),
        (("--kp", "-5"), "120 Hz"),
        (("--kp", "1e9"), "120 Hz"),
        (("--kp", "nan"), "'nan'"),
        (("--joints", "Nose"), "'Nose'"),
        (("--kp", "many"), "'many'"),
        (("--gains", "both"), "'both'"),
        (("--gains", "learned", "--kp", "600"), "--kp"),
        (("--gains", "learned", "--ka", "0"), "--ka"),
        (("--gains", "learned", "--weights", "missing.npz"), "missing.npz"),
        (("--weights", "missing.npz"), "--weights"),
        (("--person", "1"), "--person"),
        (("--up", "y"), "--up"),
        (("--template", DANCE), "--template"),
    ],
)
def test_refusals_are_one_sentence_and_write_nothing(options, what, capsys, tmp_path):
    out = tmp_path / "out.bvh"
    code, told, err = run_quamo(capsys, "refine", WALK, "-o", out, *options)
    assert (code, told) == (2, "")
    assert names_in_one_line(err, what)
    assert not out.exists()


def test_the_source_is_never_overwritten(capsys):
    before = WALK.read_bytes()
    assert run_quamo(capsys, "refine", WALK, "-o", WALK)[0] == 2
    assert WALK.read_bytes() == before


def test_learned_gains_run_at_25_hz_and_carry_the_correction_back(capsys, weights, tmp_path):
    out = tmp_path / "out.bvh"
    file = weights / gain_network_file_name("full", "none")
    code, told, _ = run_quamo(
        capsys, "refine", DANCE, "-o", out, "--gains", "learned", "--weights", file
    )
    assert code == 0
    assert "24 joints" in told
    words = ("refine", DANCE, "-o", out, "--gains", "learned", "--weights", file)
    code, _, err = run_quamo(capsys, *words, "--joints", "LThumb")
    assert code == 2
    assert names_in_one_line(err, "'LThumb'", "24")
    before, after = read_bvh(DANCE), read_bvh(out)
    thumb = list(before.channels[before.skeleton.index("LThumb")].rotation)
    assert (before.values[:, thumb] == after.values[:, thumb]).all()
    by = geodesic_angle(before.motion.rotations, after.motion.rotations)
    assert 0.5 < np.degrees(by[1:, before.skeleton.index("LeftArm")]).mean() < 30.0


def test_learned_gains_wait_for_one_sample_of_25_hz_and_no_more(walk):
    from twistcore.quamo.track_clip import select_writable_joints, track_with_network

    network = initial_gain_network_for_training(8, 4, np.random.default_rng(0), "full")
    motion, joints = walk.motion, select_writable_joints(walk.skeleton, None)
    whole = track_with_network(motion, joints, network).motion.rotations
    frames = 200
    part = track_with_network(motion.sliced(0, frames), joints, network).motion.rotations
    lag = 5  # native frames in one sample, rounded up
    settled = frames - 1 - 2 * lag
    assert np.degrees(geodesic_angle(part[:settled], whole[:settled])).max() < 1e-5
    assert (part[-1] != whole[frames - 1]).any()


def test_poses_in_bvh_out(capsys, tmp_path):
    sequence = read_cmu_bvh_sequence(DANCE)
    source = write_poses(tmp_path / "dance.npz", sequence)
    out = tmp_path / "out.bvh"
    code, told, err = run_quamo(capsys, "refine", source, "-o", out, "--up", "y")
    assert (code, "24 joints" in told) == (0, True)
    clip = read_bvh(out)
    assert clip.motion.fps == pytest.approx(25.0)
    assert len(clip.skeleton) == 24
    no_rate = write_poses(tmp_path / "none.npz", sequence, mocap_framerate=None)
    code, _, err = run_quamo(capsys, "refine", no_rate, "-o", tmp_path / "x.bvh")
    assert (code, "--fps" in err, err.count("\n")) == (2, True, 1)


def test_noise_is_seeded_and_says_its_size(capsys, tmp_path):
    first, again, other = (tmp_path / f"{n}.bvh" for n in "abc")
    code, told, _ = run_quamo(capsys, "noise", DANCE, "-o", first, "--level", "B", "--seed", 3)
    assert code == 0
    assert "MPJPE" in told
    run_quamo(capsys, "noise", DANCE, "-o", again, "--level", "B", "--seed", 3)
    run_quamo(capsys, "noise", DANCE, "-o", other, "--level", "B", "--seed", 4)
    assert first.read_bytes() == again.read_bytes()
    assert first.read_bytes() != other.read_bytes()
    code, told, _ = run_quamo(capsys, "noise", DANCE, "-o", other, "--level", "A", "--json")
    document = json.loads(told)
    assert document["schema"] == "twistcore.quamo-noise/1"
    assert 35.0 < document["errors_mm"]["mpjpe"] < 80.0
    assert 14.0 < document["errors_mm"]["accel"] < 24.0


@pytest.fixture
def folder(tmp_path):
    clips = tmp_path / "clips"
    clips.mkdir()
    (clips / "05_03.bvh").write_bytes(DANCE.read_bytes())
    (clips / "06_08.bvh").write_bytes((ASSETS / "basketball.bvh").read_bytes())
    return clips


def test_evaluate_prints_the_bars_and_every_rival(capsys, folder, weights):
    code, told, err = run_quamo(capsys, "evaluate", folder, "--seeds", 1, "--weights", weights)
    assert code == 0
    assert "no network for a held-out subject" not in err
    for row in ("| constant offset |", "| One-Euro |", "| spline, file |", "| both ways, file |"):
        assert told.count(row) == 4 + (row != "| constant offset |")  # and of lags
    assert told.count("| input |") == 2
    assert "A + systematic: full model, MPJPE | 0.91 | ≤ 0.92" in told
    assert "| A: spline, file, Accel | – | ≤ 0.37 |" in told
    assert "learned, full" in told


def test_what_the_task_bounds_is_told_from_what_is_missed():
    missed = BoundCheck("PD", "0.30", 0.45, 0.73, 0.01)
    bounded = BoundCheck("PD", "0.30", 0.45, 0.73, 0.01, task_bound=0.53, task="at 80 ms")
    assert "0.53 at 80 ms" in bounded.verdict
    assert not missed.met
    assert not bounded.met
    assert BoundCheck("PD", "0.30", 0.45, 0.44, 0.01, task_bound=0.46).met


def test_ablation_as_json_holds_bars_rows_and_drift(capsys, folder, tmp_path):
    words = ("ablation", folder, "--seeds", 1, "--weights", tmp_path, "--json")
    code, told, err = run_quamo(capsys, *words)
    assert code == 0
    assert "full-without-01-0.npz" in err
    document = json.loads(told)
    assert document["schema"] == "twistcore.quamo-ablation/1"
    methods = {row["method"] for row in document["rows"]}
    assert {"input", "hand gains", "hand gains, first-order", "hand gains + α"} <= methods
    assert [d["exact"] < 1e-6 < d["first_order"] for d in document["drift_deg"]] == [True] * 3
    for bar in document["bars"]:
        if bar["bound"] is None:
            assert "exact ÷ first-order" in bar["check"] or "÷ six" in bar["check"]
            continue
        kept = bar["value"] >= bar["bound"] if bar["above"] else bar["value"] <= bar["bound"]
        assert bar["met"] == kept


def test_tables_need_the_held_out_subjects(capsys, tmp_path):
    (tmp_path / "02_01.bvh").write_bytes(WALK.read_bytes())
    code, _, err = run_quamo(capsys, "evaluate", tmp_path)
    assert (code, "subjects 01, 05, 06, 14" in err) == (2, True)


def test_training_refuses_what_is_not_there(capsys, folder, tmp_path, monkeypatch):
    words = ("train", folder, "-o", tmp_path / "out", "--hold-out", "99")
    code, _, err = run_quamo(capsys, *words)
    assert (code, "'99'" in err) == (2, True)
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    code, _, err = run_quamo(capsys, "train", folder, "-o", tmp_path / "out", "--hold-out", "05")
    assert (code, "pip install" in err) == (2, True)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("way", "run"), [(BOTH_WAYS, track_both_ways), (("--causal",), track)])
def test_hand_gains_on_the_command_line_are_used(capsys, tmp_path, way, run):
    out = tmp_path / "out.bvh"
    words = ("refine", WALK, "-o", out, "--joints", "LeftArm", "--kp", 900, "--kd", 20, *way)
    assert run_quamo(capsys, *words)[0] == 0
    before, after = read_bvh(WALK), read_bvh(out)
    found = after.motion.rotations[1:, before.skeleton.index("LeftArm")]
    expected = turned(before, "LeftArm", run, Gains(kp=900.0, kd=20.0))
    assert np.degrees(geodesic_angle(found, expected)).max() < 1e-4
