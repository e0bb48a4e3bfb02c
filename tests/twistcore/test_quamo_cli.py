"""`twistcore quamo …`: its words, what it changes on disk, its refusals and its tables."""

import json

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore.test_quamo_data import write_poses
from twistcore.bvh import read_bvh
from twistcore.cli import main
from twistcore.quamo import Gains, HandGains, track
from twistcore.quamo.network import untrained, write_network
from twistcore.quamo.weights import weights_name
from twistcore.rotation import geodesic_angle
from twistcore.study.quamo.quamo_bars import Bar
from twistcore.study.quamo.sequences import read_sequence

WALK, DIRTY, DANCE = (ASSETS / f"{n}.bvh" for n in ("walk", "walk_injected", "dance"))


def run(capsys, *words):
    try:
        code = main([str(w) for w in ("quamo", *words)])
    except SystemExit as stop:
        code = int(stop.code or 0)
    out, err = capsys.readouterr()
    return code, out, err


@pytest.fixture
def weights(tmp_path):
    for subject in ("none", "05", "06"):
        network = untrained(8, 4, np.random.default_rng(0), "full")
        write_network(network, tmp_path / weights_name("full", subject))
    return tmp_path


def test_refine_tracks_and_changes_only_the_chosen_joints(capsys, tmp_path):
    out = tmp_path / "out.bvh"
    code, told, err = run(capsys, "refine", WALK, "-o", out, "--joints", "LeftArm", "Spine")
    assert code == 0
    assert "2 joints tracked with hand gains" in told
    assert "no error" in told
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
    joint = before.skeleton.index("LeftArm")
    q = before.motion.rotations[1:, [joint]]
    ours = track(q, np.zeros((len(q), 3)), before.frame_time, HandGains()).q[:, 0]
    assert np.degrees(geodesic_angle(after.motion.rotations[1:, joint], ours)).max() < 1e-4


def test_root_position_is_tracked_when_asked(capsys, tmp_path):
    out = tmp_path / "out.bvh"
    words = ("refine", WALK, "-o", out, "--joints", "Hips", "--root-position")
    assert run(capsys, *words)[0] == 0
    before, after = read_bvh(WALK).values, read_bvh(out).values
    assert (before[2:, :3] != after[2:, :3]).any(axis=0).all()
    assert (before[:, 6:] == after[:, 6:]).all()


def test_refine_warns_of_twist_errors_that_tracking_would_smear(capsys, tmp_path):
    code, _, err = run(capsys, "refine", DIRTY, "-o", tmp_path / "out.bvh")
    assert code == 0
    assert "8 intervals of twist errors" in err
    assert "first" in err


@pytest.mark.parametrize(
    ("options", "what"),
    [
        (("--kd", "1000"), "unstable at 120 Hz"),
        (("--kp", "-5"), "unstable"),
        (("--kp", "nan"), "unstable"),
        (("--joints", "Nose"), "no joint 'Nose'"),
        (("--kp", "many"), "expected a number"),
        (("--gains", "both"), "invalid choice"),
        (("--gains", "learned", "--weights", "missing.npz"), "missing.npz"),
    ],
)
def test_refusals_are_one_sentence_and_write_nothing(options, what, capsys, tmp_path):
    out = tmp_path / "out.bvh"
    code, told, err = run(capsys, "refine", WALK, "-o", out, *options)
    assert (code, told) == (2, "")
    assert what in err
    assert err.count("\n") == 1
    assert not out.exists()


def test_the_source_is_never_overwritten(capsys):
    before = WALK.read_bytes()
    assert run(capsys, "refine", WALK, "-o", WALK)[0] == 2
    assert WALK.read_bytes() == before


def test_learned_gains_run_at_25_hz_and_carry_the_correction_back(capsys, weights, tmp_path):
    out = tmp_path / "out.bvh"
    file = weights / weights_name("full", "none")
    code, told, _ = run(capsys, "refine", DANCE, "-o", out, "--gains", "learned", "--weights", file)
    assert code == 0
    assert "24 joints tracked with learned gains" in told
    words = ("refine", DANCE, "-o", out, "--gains", "learned", "--weights", file)
    code, _, err = run(capsys, *words, "--joints", "LThumb")
    assert (code, "'LThumb' is not among the 24" in err) == (2, True)
    before, after = read_bvh(DANCE), read_bvh(out)
    thumb = list(before.channels[before.skeleton.index("LThumb")].rotation)
    assert (before.values[:, thumb] == after.values[:, thumb]).all()
    turned = geodesic_angle(before.motion.rotations, after.motion.rotations)
    assert 0.5 < np.degrees(turned[1:, before.skeleton.index("LeftArm")]).mean() < 30.0


def test_learned_gains_wait_for_one_sample_of_25_hz_and_no_more(walk):
    from twistcore.quamo.track_clip import chosen_joints, track_learned

    network = untrained(8, 4, np.random.default_rng(0), "full")
    motion, joints = walk.motion, chosen_joints(walk.skeleton, None)
    whole = track_learned(motion, joints, network).motion.rotations
    frames = 200
    part = track_learned(motion.sliced(0, frames), joints, network).motion.rotations
    lag = 5  # native frames in one sample, rounded up
    settled = frames - 1 - 2 * lag
    assert np.degrees(geodesic_angle(part[:settled], whole[:settled])).max() < 1e-5
    assert (part[-1] != whole[frames - 1]).any()


def test_poses_in_bvh_out(capsys, tmp_path):
    sequence = read_sequence(DANCE)
    source = write_poses(tmp_path / "dance.npz", sequence)
    out = tmp_path / "out.bvh"
    code, told, err = run(capsys, "refine", source, "-o", out, "--up", "y")
    assert (code, "24 joints" in told) == (0, True)
    clip = read_bvh(out)
    assert clip.motion.fps == pytest.approx(25.0)
    assert len(clip.skeleton) == 24
    no_rate = write_poses(tmp_path / "none.npz", sequence, mocap_framerate=None)
    code, _, err = run(capsys, "refine", no_rate, "-o", tmp_path / "x.bvh")
    assert (code, "--fps" in err, err.count("\n")) == (2, True, 1)


def test_noise_is_seeded_and_says_its_size(capsys, tmp_path):
    first, again, other = (tmp_path / f"{n}.bvh" for n in "abc")
    code, told, _ = run(capsys, "noise", DANCE, "-o", first, "--level", "B", "--seed", 3)
    assert code == 0
    assert "MPJPE" in told
    run(capsys, "noise", DANCE, "-o", again, "--level", "B", "--seed", 3)
    run(capsys, "noise", DANCE, "-o", other, "--level", "B", "--seed", 4)
    assert first.read_bytes() == again.read_bytes()
    assert first.read_bytes() != other.read_bytes()
    code, told, _ = run(capsys, "noise", DANCE, "-o", other, "--level", "A", "--json")
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
    code, told, err = run(capsys, "evaluate", folder, "--seeds", 1, "--weights", weights)
    assert code == 0
    assert "--weights FOLDER" not in err
    for row in ("| constant offset |", "| One-Euro |", "| spline, file |", "| both ways, file |"):
        assert told.count(row) == 4 + (row != "| constant offset |")  # and of lags
    assert told.count("| input |") == 2
    assert "A + systematic: full model, MPJPE | 0.91 | ≤ 0.92" in told
    assert "| A: spline, file, Accel | – | ≤ 0.37 |" in told
    assert "bound of the task: 0.53 even with 80 ms of waiting" in told
    assert "learned, full" in told


def test_what_the_task_bounds_is_told_from_what_is_missed():
    missed = Bar("PD", "0.30", 0.45, 0.73, 0.01)
    assert missed.verdict == "**not met**"
    bounded = Bar("PD", "0.30", 0.45, 0.73, 0.01, task_bound=0.53, task="at 80 ms")
    assert bounded.verdict == "bound of the task: 0.53 at 80 ms"
    assert not bounded.met
    assert Bar("PD", "0.30", 0.45, 0.44, 0.01, task_bound=0.46).verdict == "met"


def test_ablation_as_json_holds_bars_rows_and_drift(capsys, folder, tmp_path):
    words = ("ablation", folder, "--seeds", 1, "--weights", tmp_path, "--json")
    code, told, err = run(capsys, *words)
    assert code == 0
    assert "expected --weights FOLDER with full-without-01-0.npz" in err
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
    code, _, err = run(capsys, "evaluate", tmp_path)
    assert (code, "subjects 01, 05, 06, 14" in err) == (2, True)


def test_training_refuses_what_is_not_there(capsys, folder, tmp_path, monkeypatch):
    words = ("train", folder, "-o", tmp_path / "out", "--hold-out", "99")
    code, _, err = run(capsys, *words)
    assert (code, "'99'" in err) == (2, True)
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    code, _, err = run(capsys, "train", folder, "-o", tmp_path / "out", "--hold-out", "05")
    assert (code, "pip install" in err) == (2, True)
    assert not (tmp_path / "out").exists()


def test_hand_gains_on_the_command_line_are_used(capsys, tmp_path):
    out = tmp_path / "out.bvh"
    words = ("refine", WALK, "-o", out, "--joints", "LeftArm", "--kp", 900, "--kd", 20)
    assert run(capsys, *words)[0] == 0
    before, after = read_bvh(WALK), read_bvh(out)
    joint = before.skeleton.index("LeftArm")
    q = before.motion.rotations[1:, [joint]]
    gains = HandGains(Gains(kp=900.0, kd=20.0))
    ours = track(q, np.zeros((len(q), 3)), before.frame_time, gains).q[:, 0]
    assert np.degrees(geodesic_angle(after.motion.rotations[1:, joint], ours)).max() < 1e-4
