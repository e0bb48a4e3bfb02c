"""Flips of limbs put in on purpose: what they move, and that their truth takes them out again."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.twist_removal import refine, remove_twist
from twistcore.cli import main
from twistcore.detection import Interval, Kind
from twistcore.detection.natural_events import (
    NaturalEvent,
    chains_and_limbs_with_events,
    limb_flip_events,
)
from twistcore.errors import FormatError, TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs, limb_middle_and_end_positions
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.study.benchmark import passes, runner
from twistcore.study.benchmark.clip_run import (
    BenchmarkSettings,
    benchmark_result_from_json,
    run_clip_benchmark,
)
from twistcore.study.benchmark.clip_scene import CleanScene
from twistcore.study.benchmark.markdown import benchmark_to_markdown
from twistcore.study.benchmark.tables import benchmark_rows
from twistcore.study.benchmark.tally import Tally
from twistcore.study.evaluation import (
    body_segment_sort_key,
    measure_corrected_clip,
    summarise_samples,
)
from twistcore.synthesis import (
    PROTOCOLS,
    InjectedError,
    Truth,
    clip_random_generator,
    draw_errors,
    draw_targets,
    inject,
    parse_protocol,
    prepare_clean_motion_for_injection,
    read_truth,
    write_truth,
)

WALK = read_bvh(ASSETS / "walk.bvh").motion
CHAINS = find_chains(WALK)
LIMBS = find_limbs(WALK, CHAINS)
EVERY = (*CHAINS, *LIMBS)
# What P0 drew with seed 5 before there were protocols of limbs.
P0_SEED_5 = [
    ("LeftArm", 73, 74, 33.887275),
    ("LeftArm", 114, 131, 22.600754),
    ("LeftArm", 135, 139, -6.654822),
    ("LeftArm", 146, 150, 133.985023),
    ("LeftArm", 200, 216, 126.789101),
    ("RightUpLeg", 182, 201, 161.597838),
    ("RightUpLeg", 278, 285, -77.197697),
]


def flip(limb, start, stop, degrees, *, carried=False):
    offset = np.full(stop - start, np.radians(degrees))
    return InjectedError(limb.name, start, stop, offset, None, Kind.LIMB_FLIP, carried)


def drawn(name, seed=5):
    protocol = parse_protocol(name)
    return draw_errors(WALK, LIMBS, clip_random_generator(seed, "walk.bvh"), protocol)


def scene_of(name):
    """Without the audit, for which a detector would be asked."""
    protocol = parse_protocol(name)
    motion = prepare_clean_motion_for_injection(WALK.sliced(1, WALK.frames), CHAINS, protocol)
    chains = find_chains(motion)
    return CleanScene("walk.bvh", protocol, motion, chains, find_limbs(motion, chains), 1, ())


def test_what_the_paper_injects_is_drawn_as_before():
    rng = clip_random_generator(5, "walk.bvh")
    errors = draw_errors(WALK, draw_targets(CHAINS, rng), rng)
    listed = [(e.chain, e.start, e.stop, round(float(np.degrees(e.offset[0])), 6)) for e in errors]
    assert listed == P0_SEED_5
    assert not any(e.carried or e.kind != Kind.COUNTER_TWIST for e in errors)


def test_flips_keep_to_the_protocol():
    errors = [e for seed in range(20) for e in drawn("L0", seed)]
    sizes = np.abs(np.degrees([e.offset[0] for e in errors]))
    assert {e.chain for e in errors} == {limb.name for limb in LIMBS}
    assert {e.kind for e in errors} == {Kind.LIMB_FLIP}
    assert {e.stop - e.start for e in errors} == set(range(1, 21))
    assert 60.0 <= sizes.min() < 70.0 < 170.0 < sizes.max() <= 180.0
    assert 0.4 < np.mean([e.carried for e in errors]) < 0.6
    assert all(2 <= sum(e.chain == limb.name for e in drawn("L0")) <= 5 for limb in LIMBS)


def test_protocols_of_limbs_combine_with_others():
    both = parse_protocol("L0+H2")
    assert (both.limb, both.step, both.delta) == (True, 2, (60.0, 180.0))
    assert replace(parse_protocol("L0+H1"), name="", text="") == replace(
        PROTOCOLS["L1"], name="", text=""
    )
    with pytest.raises(TwistError, match="H8"):
        parse_protocol("L0+H8")


@pytest.mark.parametrize("carried", [False, True])
@pytest.mark.parametrize("limb", LIMBS, ids=lambda limb: limb.label)
def test_the_middle_joint_goes_round_the_line_and_the_end_stays(limb, carried):
    error = flip(limb, 100, 120, 130.0, carried=carried)
    dirty = inject(WALK, EVERY, [error])
    at = slice(100, 120)
    (middle, end), (turned, still) = (
        limb_middle_and_end_positions(WALK, limb),
        limb_middle_and_end_positions(dirty, limb),
    )
    np.testing.assert_allclose(still, end, atol=1e-9 * WALK.skeleton.height)
    line = end / np.linalg.norm(end, axis=1)[:, None]
    along = np.einsum("fi,fi->f", middle, line)[:, None] * line
    across, now = middle - along, turned - along
    np.testing.assert_allclose(now[:100], across[:100])
    expected = np.cos(error.offset)[:, None] * across[at] + np.sin(error.offset)[:, None] * (
        np.cross(line[at], across[at])
    )
    np.testing.assert_allclose(now[at], expected, atol=1e-9 * WALK.skeleton.height)

    (globally, where), (then, there) = forward_kinematics(WALK), forward_kinematics(dirty)
    turn = geodesic_angle(globally[at, limb.end], then[at, limb.end])
    np.testing.assert_allclose(turn, np.radians(130.0 if carried else 0.0), atol=1e-7)
    others = [j for j in range(len(WALK.skeleton)) if j not in (limb.parent, limb.end)]
    np.testing.assert_array_equal(dirty.rotations[:, others], WALK.rotations[:, others])
    own = np.abs(dirty.rotations - WALK.rotations).max(axis=(0, 2)) > 1e-12
    changed = set(np.flatnonzero(own).tolist())
    assert changed == set(error.changed_joints(limb, WALK.skeleton))
    moved = np.abs(there - where).max(axis=(0, 2)) > 1e-6 * WALK.skeleton.height
    assert moved[limb.child]
    assert not moved[limb.end]


def test_the_truth_takes_out_what_was_put_in():
    errors = drawn("L0")
    dirty = inject(WALK, EVERY, errors)
    assert geodesic_angle(dirty.rotations, WALK.rotations).max() > 1.0
    intervals = [
        Interval(e.chain, e.start, e.stop, e.offset, kind=e.kind, carried=e.carried) for e in errors
    ]
    again = refine(dirty, EVERY, intervals).rotations
    signs = np.sign(np.einsum("fji,fji->fj", again, WALK.rotations))[..., None]
    np.testing.assert_allclose(again * signs, WALK.rotations, atol=1e-9)


def test_noise_on_the_compensation_turns_the_end_about_the_line():
    errors = drawn("L0+H5")
    assert all((e.leak is None) == e.carried for e in errors)
    loose, tight = (
        forward_kinematics(inject(WALK, EVERY, es))[0]
        for es in (errors, [replace(e, leak=None) for e in errors])
    )
    for e in errors:
        limb = next(limb for limb in LIMBS if limb.name == e.chain)
        turn = geodesic_angle(tight[e.start : e.stop, limb.end], loose[e.start : e.stop, limb.end])
        expected = np.zeros(e.stop - e.start) if e.leak is None else np.abs(e.leak)
        np.testing.assert_allclose(turn, expected, atol=1e-6)


def test_a_truth_says_what_is_a_flip(tmp_path):
    path, errors = tmp_path / "t.json", drawn("L0")
    chains = draw_errors(WALK, CHAINS[:1], clip_random_generator(5, "walk"))
    write_truth(path, Truth("walk.bvh", "L0", 5, WALK.frames, WALK.fps, (*errors, *chains)))
    written = json.loads(path.read_text())
    assert written["schema"] == "twistcore.truth/1"
    for e, entry in zip((*errors, *chains), written["errors"], strict=True):
        assert entry.get("kind") == (None if e in chains else "limb flip")
        assert entry.get("carried") is (True if e.carried else None)
    read = read_truth(path)
    for e, back in zip((*errors, *chains), read.errors, strict=True):
        assert (back.chain, back.start, back.stop) == (e.chain, e.start, e.stop)
        assert (back.kind, back.carried, back.leak) == (e.kind, e.carried, None)
        np.testing.assert_allclose(back.offset, e.offset, atol=1e-10)
    for wrong in ({"kind": "lone jump"}, {"kind": "magic"}, {"kind": "counter-twist"}):
        entry = {**written["errors"][0], "carried": True, **wrong}
        path.write_text(json.dumps({**written, "errors": [entry]}))
        with pytest.raises(FormatError):
            read_truth(path)


def test_an_evaluation_has_rows_of_whole_limbs():
    errors = drawn("L0")
    truth = Truth("walk.bvh", "L0", 5, WALK.frames, WALK.fps, errors)
    dirty = inject(WALK, EVERY, errors)
    left = summarise_samples([measure_corrected_clip(truth, WALK, dirty, CHAINS)])
    assert [(r.side, r.segment) for r in left.rows] == [
        (side, f"whole {segment}") for side in ("Left", "Right") for segment in ("arm", "leg")
    ]
    assert (left.overall.fsr_percent, left.damage_share) == (0.0, 0.0)
    assert left.overall.mae_before_deg == pytest.approx(
        np.degrees(np.abs(np.concatenate([e.offset for e in errors])).mean())
    )
    assert (
        summarise_samples([measure_corrected_clip(truth, WALK, WALK, CHAINS)]).overall.fsr_percent
        == 100.0
    )
    assert sorted(["whole leg", "x", "whole arm", "Leg"], key=body_segment_sort_key) == [
        "Leg", "whole arm", "whole leg", "x"
    ]  # fmt: skip


@pytest.mark.parametrize("carried", [True, False])
def test_an_end_taken_for_what_it_is_not_is_an_error(carried):
    errors = [flip(LIMBS[0], 100, 120, 90.0, carried=carried)]
    truth = Truth("walk.bvh", "L0", 5, WALK.frames, WALK.fps, tuple(errors))
    dirty = inject(WALK, EVERY, errors)
    offset = np.zeros(WALK.frames)
    offset[100:120] = errors[0].offset
    name = LIMBS[0].name
    along = remove_twist(dirty, EVERY, {name: offset}, {name: offset})
    stays = remove_twist(dirty, EVERY, {name: offset})
    right, wrong = (along, stays) if carried else (stays, along)
    reported = [
        summarise_samples([measure_corrected_clip(truth, WALK, m, CHAINS)]) for m in (right, wrong)
    ]
    assert [t.overall.fsr_percent for t in reported] == [100.0, 0.0]
    assert reported[0].damage_share == 0.0
    pairs = WALK.frames * len({j for c in CHAINS for j in (c.parent, c.child)}) - 20
    damaged = 20 if carried else 0  # an end that was right is turned; one that was wrong, left
    assert reported[1].damage_share == pytest.approx(100.0 * damaged / pairs)


class TruthTeller(ClipAnalysis):
    """Knows the errors of the pass, and finds nothing else."""

    errors: tuple[InjectedError, ...] = ()

    def detect(self, method, kinds=None, tau_radians=None):
        del method, kinds, tau_radians
        names = {c.name for c in (*self.chains, *self.limbs)}
        return [
            Interval(e.chain, e.start, e.stop, e.offset, 1.0, kind=e.kind, carried=e.carried)
            for e in self.errors
            if e.chain in names
        ]


@pytest.mark.parametrize("name", ["L0", "L1", "L0+H2", "L0+H9", "P0"])
def test_who_knows_the_truth_repairs_everything_and_damages_nothing(name, monkeypatch):
    scene, drawing = scene_of(name), passes.draw_pass_errors

    def draw(*given):
        monkeypatch.setattr(TruthTeller, "errors", drawing(*given))
        return TruthTeller.errors

    monkeypatch.setattr(passes, "ClipAnalysis", TruthTeller)
    monkeypatch.setattr(passes, "draw_pass_errors", draw)
    total = sum(passes.run_benchmark_passes(scene, "consistency", 3).values(), Tally())
    assert total.passes == (10 if name == "P0" else 4)
    assert total.frames == total.repaired > 0
    assert (total.damaged, total.natural, total.after) == (0, 0, pytest.approx(0, abs=1000))
    assert total.truths == total.found == total.matched


def test_the_papers_method_is_not_asked_about_limbs():
    scene = scene_of("L0")
    assert any(passes.run_on_clean_motion(scene, "paper").outcome.found) is True
    of_chains = passes.apply_benchmark_method("paper", scene.motion, scene.chains)
    of_all = passes.apply_benchmark_method("paper", scene.motion, (*scene.chains, *scene.limbs))
    np.testing.assert_array_equal(of_all.rotations, of_chains.rotations)
    assert of_all.found == of_chains.found | {limb.name: [] for limb in scene.limbs}


def test_a_flip_of_the_clips_own_takes_its_neighbours_out_of_the_audit():
    arm = next(limb for limb in LIMBS if limb.label == "Left arm")
    interval = Interval(arm.name, 5, 9, np.full(4, np.pi), kind=Kind.LIMB_FLIP)
    twist = Interval("RightLeg", 5, 9, np.full(4, np.pi))
    (event,) = limb_flip_events(LIMBS, [interval, twist])
    assert event.to_json() == {
        "chain": arm.name, "kind": "limb flip", "start": 5, "stop": 9, "degrees": 180.0
    }  # fmt: skip
    assert (event.joint, event.chain) == (arm.parent, arm.name)
    out = chains_and_limbs_with_events(WALK.skeleton, CHAINS, LIMBS, [event])
    assert out == {arm.name, "LeftShoulder", "LeftArm", "LeftForeArm"}
    leg = next(limb for limb in LIMBS if limb.label == "Right leg")
    own = NaturalEvent("RightLeg", "flip", 5, 6, 90.0, leg.child)
    assert chains_and_limbs_with_events(WALK.skeleton, CHAINS, LIMBS, [own]) == {
        "RightLeg",
        leg.name,
    }
    assert chains_and_limbs_with_events(WALK.skeleton, CHAINS, LIMBS, []) == frozenset()


@pytest.mark.thorough
def test_a_benchmark_of_flips(monkeypatch):
    asked = ClipAnalysis.detect

    def of_bones(self, *words, **more):  # what a detector makes of flips is tested elsewhere
        return asked(ClipAnalysis(self.motion, self.chains, self.name), *words, **more)

    monkeypatch.setattr(ClipAnalysis, "detect", of_bones)
    settings = BenchmarkSettings(("L0", "L1", "P0"), ("consistency", "paper", "slerp-oracle"), (1,))
    result = run_clip_benchmark(ASSETS / "walk.bvh", "walk.bvh", settings)
    assert not result.problems
    assert (
        benchmark_result_from_json(json.loads(json.dumps(result.to_json()))).to_json()
        == result.to_json()
    )
    summary = runner.BenchmarkSummary()
    summary.add(result)
    rows = {
        (r.protocol, r.method, r.side, r.segment): r.to_json()
        for r in benchmark_rows(summary, settings)
        if not r.audited
    }
    for protocol in ("L0", "L1"):
        for method in ("consistency", "paper"):
            total = rows[protocol, method, "", "Overall"]
            assert (total["passes"], total["fsr_percent"]) == (4, 0.0)
            assert total["recall_percent"] == 0.0
        assert rows[protocol, "slerp-oracle", "", "Overall"]["fsr_percent"] > 50.0
    segments = {key[3] for key in rows if key[:2] == ("L0", "slerp-oracle")}
    assert segments == {"whole arm", "whole leg", "Overall"}
    assert {key[3] for key in rows if key[0] == "P0"}.isdisjoint(segments - {"Overall"})
    assert "whole arm" in benchmark_to_markdown(summary, settings, "assets")


@pytest.mark.parametrize("protocol", ["L0", "L1"])
def test_the_commands_put_flips_in_and_measure_them(protocol, tmp_path, capsys):
    dirty, truth = str(tmp_path / "dirty.bvh"), str(tmp_path / "truth.json")
    walk = str(ASSETS / "walk.bvh")
    words = ["--truth", truth, "--seed", "4", "--protocol", protocol]
    assert main(["inject", walk, "-o", dirty, *words]) == 0
    assert "-" in capsys.readouterr().out
    named = {e["chain"] for e in json.loads((tmp_path / "truth.json").read_text())["errors"]}
    assert len(named) == 2
    assert named < {limb.name for limb in LIMBS}
    assert main(["evaluate", "--truth", truth, "--clean", walk, "--refined", dirty, "--json"]) == 0
    table = json.loads(capsys.readouterr().out)
    assert {row["segment"] for row in table["rows"]} <= {"whole arm", "whole leg"}
    assert (table["overall"]["fsr_percent"], table["clean_damage_percent"]) == (0.0, 0.0)
    assert table["overall"]["mae_before_deg"] > 60.0
