"""The benchmark: the same numbers however it is run, and the numbers of evaluation.py."""

import csv
import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.cli import main
from twistcore.detection import DETECTORS
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.detection.evidence import ChainSignals
from twistcore.errors import FormatError
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import (
    continuous_quaternion_signs,
    geodesic_angle,
    normalise,
    quaternion_from_axis_angle,
    slerp,
)
from twistcore.study.benchmark import runner
from twistcore.study.benchmark.baselines import BASELINES
from twistcore.study.benchmark.clip_run import (
    BenchmarkSettings,
    benchmark_result_from_json,
    run_clip_benchmark,
)
from twistcore.study.benchmark.clip_scene import make_clean_scene
from twistcore.study.benchmark.filtering_cost import measure_fidelity
from twistcore.study.benchmark.hinge import benchmark_hinge_correction_offsets
from twistcore.study.benchmark.markdown import aligned_markdown_table, benchmark_to_markdown
from twistcore.study.benchmark.passes import (
    apply_benchmark_method,
    benchmark_method_names,
    draw_pass_errors,
    run_benchmark_passes,
    run_on_clean_motion,
)
from twistcore.study.benchmark.runner import run_benchmark
from twistcore.study.benchmark.tables import benchmark_rows, benchmark_to_json
from twistcore.study.benchmark.tally import MICRO, Tally
from twistcore.study.evaluation import match_intervals, measure_corrected_clip, summarise_samples
from twistcore.synthesis import Truth, inject, parse_protocol

CLIPS = {name: ASSETS / name for name in ("basketball.bvh", "walk.bvh")}
QUICK = BenchmarkSettings(("P0",), ("paper", "savgol"), (1,))


@pytest.fixture(scope="module")
def scene(walk):
    return make_clean_scene("walk.bvh", walk.motion, parse_protocol("P0"))


def document(summary, settings=QUICK):
    return benchmark_to_json(summary, settings, "assets")


def test_intervals_match_one_to_one_at_half_their_union():
    assert match_intervals([(0, 10)], [(0, 20)]) == {0: 0}
    assert match_intervals([(0, 10)], [(0, 21)]) == {}
    assert match_intervals([(0, 10), (0, 9)], [(0, 9)]) == {1: 0}
    assert match_intervals([], [(0, 9)]) == {}
    assert match_intervals([(0, 1), (5, 6)], [(5, 6), (0, 1)]) == {0: 1, 1: 0}


@parametrize("method", ["paper", "savgol", "pca"])
def test_a_pass_counts_what_evaluation_measures(scene, method):
    """Passes look at one limb; evaluation.py looks at the whole clip and knows no limbs."""
    samples, motion = [], scene.motion
    for index, targets in scene.passes():
        errors = draw_pass_errors(scene, index, targets, 7)
        dirty = inject(motion, scene.chains, errors)
        refined = apply_benchmark_method(method, dirty, scene.chains, errors)
        truth = Truth("walk.bvh", "P0", 7, motion.frames, motion.fps, errors)
        samples.append(
            measure_corrected_clip(
                truth, motion, motion.with_rotations(refined.rotations), scene.chains
            )
        )
    known = summarise_samples(samples)
    ours = sum(run_benchmark_passes(scene, method, 7).values(), Tally())
    assert ours.frames == known.overall.frames
    assert 100.0 * ours.repaired / ours.frames == pytest.approx(known.overall.fsr_percent)
    assert ours.after / ours.frames / MICRO == pytest.approx(known.overall.mae_after_deg, abs=1e-6)
    assert np.sqrt(ours.after_squared / ours.frames / MICRO) == pytest.approx(
        known.overall.rmse_after_deg, abs=1e-4
    )
    altered = 100.0 * (ours.damaged + ours.natural) / ours.pairs
    assert altered == pytest.approx(known.damage_share)


@pytest.mark.parametrize("method", DETECTORS)
def test_a_limb_alone_is_analysed_as_in_the_whole_body(scene, method):
    index, targets = scene.passes()[3]
    errors = draw_pass_errors(scene, index, targets, 1)
    group = next(group for group in scene.groups if targets[0] in group)
    every = (*scene.chains, *scene.limbs)
    dirty = inject(scene.motion, scene.chains, errors)
    alone, whole = (apply_benchmark_method(method, dirty, c, errors) for c in (group, every))
    for chain in group:
        assert alone.found[chain.name] == whole.found[chain.name]
        np.testing.assert_array_equal(
            alone.rotations[:, chain.parent], whole.rotations[:, chain.parent]
        )


def test_errors_depend_on_seed_clip_chain_and_protocol_alone(scene):
    def starts(seed, which):
        return [
            (e.chain, e.start, e.stop)
            for e in draw_pass_errors(scene, *scene.passes()[which], seed)
        ]

    assert starts(1, 0) == starts(1, 0)
    assert starts(1, 0) != starts(2, 0)
    assert {chain for chain, *_ in starts(1, 4)} == {scene.chains[4].name}


def test_groups_of_a_body(scene):
    assert sorted(len(group) for group in scene.groups) == [3, 3, 4, 4]
    assert all(sum(limb in group for limb in scene.limbs) == 1 for group in scene.groups)


def test_a_leading_pose_is_dropped_and_motion_is_not(walk):
    moving = walk.motion.sliced(count_leading_rest_frames(walk.motion), walk.motion.frames)
    assert count_leading_rest_frames(moving) == 0
    posed = np.concatenate([moving.rotations[:3] * 0.0, moving.rotations])
    posed[:3, :, 0] = 1.0
    turned = moving.rotations.copy()  # far from the T-pose in every joint
    turned = np.concatenate([posed[:3], normalise(turned + np.array([0.0, 1.0, 1.0, 0.0]))], axis=0)
    positions = np.concatenate([moving.positions[:3], moving.positions])
    assert count_leading_rest_frames(replace(moving, rotations=turned, positions=positions)) == 3


@pytest.mark.parametrize("name", BASELINES)
def test_a_baseline_leaves_a_still_pose_alone(name):
    pose = normalise(np.array([[0.9, 0.1, -0.3, 0.2], [0.5, 0.5, 0.5, -0.5]]))
    still = np.repeat(pose[None], 60, axis=0)
    out = BASELINES[name].correct(still, 120.0, [(10, 20)])
    np.testing.assert_allclose(out, still, atol=1e-9)


def test_slerp_turns_evenly():
    q = quaternion_from_axis_angle(np.array([0.0, 0.6, 0.8]), np.linspace(0.0, 2.0, 30))[:, None]
    spoiled = q.copy()
    spoiled[[*range(5), *range(10, 17)]] = [1.0, 0.0, 0.0, 0.0]
    out = BASELINES["slerp-oracle"].correct(spoiled, 120.0, [(0, 5), (10, 17)])
    assert geodesic_angle(out[5:], q[5:]).max() < 1e-9
    assert geodesic_angle(out[:5], q[5]).max() < 1e-9  # nothing before it: the next pose is held
    assert geodesic_angle(slerp(q[0], -q[9], np.array([1.0])), q[9]).max() < 1e-9


def test_continuous_changes_signs_only():
    rng = np.random.default_rng(3)
    q = np.cumsum(rng.normal(size=(50, 2, 4)) * 0.1, axis=0)
    q[..., 0] += 2.0
    mixed = q * rng.choice([-1.0, 1.0], size=(50, 2, 1))
    out = continuous_quaternion_signs(mixed)
    assert (np.abs(out) == np.abs(q)).all()
    assert (np.einsum("tji,tji->tj", out[:-1], out[1:]) > 0.0).all()


def test_a_causal_low_pass_lags_and_flattens_and_the_detectors_do_not(scene):
    measured = {
        m: measure_fidelity(scene, run_on_clean_motion(scene, m).outcome.rotations)
        for m in benchmark_method_names()
    }
    assert measured["butterworth-causal"].lag > 40_000
    assert abs(measured["butterworth"].lag) < 8_000
    for low_pass in ("butterworth-causal", "butterworth"):
        assert measured[low_pass].kept < 950_000
    for exact in (*DETECTORS, "unroll"):
        assert (measured[exact].lag, measured[exact].kept) == (0, 1_000_000)


@pytest.mark.thorough
def test_every_method_on_a_clip():
    settings = BenchmarkSettings(("P0", "H8", "H10", "rich+H1"), benchmark_method_names(), (1,))
    result = run_clip_benchmark(CLIPS["walk.bvh"], "walk.bvh", settings)
    assert not result.problems
    assert (
        benchmark_result_from_json(json.loads(json.dumps(result.to_json()))).to_json()
        == result.to_json()
    )
    summary = runner.BenchmarkSummary()
    summary.add(result)
    rows = {
        (r.protocol, r.method): r.to_json()
        for r in benchmark_rows(summary, settings)
        if (r.side, r.segment, r.audited) == ("", "Overall", False)
    }
    for protocol in ("P0", "H8", "rich+H1"):
        assert rows[protocol, "unroll"]["rer_percent"] == pytest.approx(100.0)
        assert rows[protocol, "unroll"]["damage_percent"] == 0.0
        assert rows[protocol, "slerp-oracle"]["fsr_percent"] > 50.0
    assert rows["P0", "paper"]["fsr_percent"] > 80.0
    assert rows["P0", "consistency"]["fsr_percent"] > 99.0
    assert rows["P0", "consistency"]["recall_percent"] > 99.0
    assert rows["P0", "savgol"]["precision_percent"] is None
    assert rows["P0", "paper"]["passes"] == 10
    assert rows["H8", "paper"]["passes"] == 6
    assert rows["H10", "paper"]["fsr_percent"] is None
    assert rows["H10", "consistency"]["false_alarms"] == 0
    assert rows["H10", "butterworth-causal"]["natural_percent"] > 1.0
    page = benchmark_to_markdown(summary, settings, "assets")
    assert "P0-all" in page
    assert "Performance Improvement" in page
    assert "░" in page


@pytest.mark.thorough
def test_the_same_numbers_with_any_number_of_workers(tmp_path):
    alone = run_benchmark(CLIPS, QUICK, workers=1)
    pooled = run_benchmark(CLIPS, QUICK, workers=2, partial=tmp_path / "p.jsonl")
    assert document(alone) == document(pooled)
    resumed = run_benchmark(CLIPS, QUICK, workers=1, partial=tmp_path / "p.jsonl", resume=True)
    assert document(resumed) == document(alone)


@pytest.mark.thorough
def test_an_interrupted_run_keeps_what_is_done_and_resumes(tmp_path, monkeypatch):
    part, done = tmp_path / "p.jsonl", []

    def once(path, name, settings):
        if done:
            raise KeyboardInterrupt
        done.append(name)
        return run_clip_benchmark(path, name, settings)

    monkeypatch.setattr(runner, "run_clip_benchmark", once)
    stopped = run_benchmark(CLIPS, QUICK, workers=1, partial=part)
    assert (stopped.clips, stopped.missing) == (1, 1)
    with part.open("a") as file:
        file.write('{"clip": "walk.bvh", "mic')  # killed while it wrote

    ran = []

    def seen(path, name, settings):
        ran.append(name)
        return run_clip_benchmark(path, name, settings)

    monkeypatch.setattr(runner, "run_clip_benchmark", seen)
    resumed = run_benchmark(CLIPS, QUICK, workers=1, partial=part, resume=True)
    assert ran == [name for name in CLIPS if name not in done]
    assert document(resumed) == document(run_benchmark(CLIPS, QUICK, workers=1))
    ran.clear()
    run_benchmark(CLIPS, QUICK, workers=1, partial=part, resume=True)
    assert not ran
    with pytest.raises(FormatError, match="protocols"):
        run_benchmark(CLIPS, BenchmarkSettings(), workers=1, partial=part, resume=True)


def test_the_command_lists_a_clip_that_it_cannot_read(tmp_path, capsys):
    folder = tmp_path / "clips"
    (folder / "inner").mkdir(parents=True)
    shutil.copy(CLIPS["walk.bvh"], folder / "inner" / "walk.BVH")
    (folder / "broken.bvh").write_text("HIERARCHY\nROOT")
    out, sheet = tmp_path / "out.json", tmp_path / "out.csv"
    words = ["benchmark", str(folder), "--methods", "paper", "--seeds", "1", "--workers", "1"]
    assert main([*words, "--json", str(out), "--csv", str(sheet)]) == 1
    printed = capsys.readouterr()
    assert "broken.bvh" in printed.err
    assert str(tmp_path) not in printed.out
    written = json.loads(out.read_text())
    assert [p["clip"] for p in written["problems"]] == ["broken.bvh"]
    assert (written["clips"], written["complete"]) == (1, True)
    lines = list(csv.DictReader(sheet.read_text().splitlines()))
    assert len(lines) == len(written["rows"])
    assert lines[0]["fsr_percent"] == str(written["rows"][0]["fsr_percent"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nowhere"], "nowhere"),
        ([str(ASSETS), "--methods", "magic"], "'magic'"),
        ([str(ASSETS), "--protocol", "P7"], "'P7'"),
        ([str(ASSETS), "--json", "nowhere/x.json"], "nowhere"),
    ],
)
def test_refused_in_one_line(words, said, capsys):
    assert main(["benchmark", *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_a_table_lines_up():
    assert aligned_markdown_table(["a", "n"], [["x", "1.0"], ["yy", "-10.25"]]) == (
        "| a  |      n |\n|----|-------:|\n| x  |    1.0 |\n| yy | -10.25 |"
    )


@pytest.mark.thorough
def test_a_tau_that_is_given_is_the_one_that_is_judged(walk):
    scene = make_clean_scene("walk", walk.motion, parse_protocol("P0"))

    def repaired(tau):
        total = Tally()
        for tally in run_benchmark_passes(scene, "consistency", 3, tau=tau).values():
            total += tally
        return total.repaired, total.frames

    own, frames = repaired({})
    deaf = {c.name: np.pi for c in scene.chains}
    assert own > 0.9 * frames
    assert repaired(deaf) == (0, frames)
    one = scene.chains[0].name
    assert 0 < repaired({one: np.pi})[0] < own


def test_the_hinge_repairs_a_bent_limb_and_takes_pronation_for_an_error():
    motion = read_bvh(ASSETS / "walk.bvh").motion
    chains = {c.name: c for c in find_chains(motion)}
    thigh, hand = chains["LeftUpLeg"], chains["LeftForeArm"]
    frames = np.arange(motion.frames)
    bent = frames[ChainSignals.of(motion, thigh).bend > 15.0][:20]
    offset = np.zeros(motion.frames)
    offset[bent] = 0.5
    wrong = remove_twist(motion, [thigh], {thigh.name: -offset})
    found = benchmark_hinge_correction_offsets(wrong, [thigh, replace(hand, grandchild=-1)])
    assert set(found) == {thigh.name}
    np.testing.assert_allclose(found[thigh.name][bent], 0.5, atol=0.05)
    outcome = apply_benchmark_method("hinge", wrong, [thigh])
    assert np.abs(outcome.rotations - motion.rotations)[bent].max() < 0.05
