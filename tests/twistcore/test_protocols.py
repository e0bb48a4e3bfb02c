"""What each protocol draws, that old seeds mean what they meant, and what is counted."""

import json
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.cli import main
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rotation import (
    conjugate,
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    rotate,
    twist_angle,
)
from twistcore.study.benchmark.clip_run import BenchmarkSettings, run_clip_benchmark
from twistcore.study.benchmark.clip_scene import make_clean_scene
from twistcore.study.benchmark.markdown import benchmark_to_markdown
from twistcore.study.benchmark.passes import run_benchmark_passes
from twistcore.study.benchmark.runner import BenchmarkSummary
from twistcore.study.benchmark.tables import benchmark_rows
from twistcore.study.benchmark.tally import Tally, tally_error_angles
from twistcore.study.evaluation import measure_corrected_clip, summarise_samples
from twistcore.synthesis import (
    InjectedError,
    Truth,
    clip_random_generator,
    draw_errors,
    draw_targets,
    inject,
    parse_protocol,
    read_truth,
    write_truth,
)
from twistcore.synthesis.injection import LEAST
from twistcore.synthesis.offset_shape import injected_offset_over_time, spans_with_straight_chain
from twistcore.synthesis.protocol import PROTOCOLS, parent_and_child_twist_increments

WALK = read_bvh(ASSETS / "walk.bvh").motion
CHAINS = find_chains(WALK)
RAMPS = ["R6", "R8", "R12", "R16"]
FILTERED = ["F15", "F10", "F6"]
STRAIGHT = np.radians(18.0)
NEW = [*RAMPS, *FILTERED, "D", "S", "K50", "K80", "B", "ST", "FL", "NB", "M5", "GH", "GI", "SL"]
# Name, frames, sum of δ in degrees, with seed 7: as drawn before there were the protocols above.
BEFORE = {
    "P0": [
        ("LeftForeArm", 55, 58, -280.871887),
        ("LeftForeArm", 98, 113, 886.24216),
        ("LeftForeArm", 160, 176, 1439.18616),
        ("LeftForeArm", 228, 244, 947.729342),
        ("LeftForeArm", 294, 312, 427.677215),
        ("RightShoulder", 71, 78, -1038.661383),
        ("RightShoulder", 179, 182, -274.880405),
        ("RightShoulder", 215, 226, -1384.513777),
        ("RightShoulder", 243, 254, -1279.147667),
    ],
    "H5": [
        ("LeftForeArm", 22, 42, -1341.911621),
        ("LeftForeArm", 55, 58, -280.871887),
        ("LeftForeArm", 171, 185, 1726.408906),
        ("LeftForeArm", 293, 309, -2050.676309),
        ("LeftForeArm", 333, 336, -518.037465),
        ("RightShoulder", 13, 30, 777.062717),
        ("RightShoulder", 283, 295, -1063.440231),
    ],
    "H9": [
        ("LeftForeArm", 1, 4, -280.871887),
        ("LeftForeArm", 98, 113, 886.24216),
        ("LeftForeArm", 228, 244, 947.729342),
        ("LeftForeArm", 294, 312, 427.677215),
        ("LeftForeArm", 328, 344, 1439.18616),
        ("RightShoulder", 1, 12, -1279.147667),
        ("RightShoulder", 71, 78, -1038.661383),
        ("RightShoulder", 215, 226, -1384.513777),
        ("RightShoulder", 341, 344, -274.880405),
    ],
    "H11": [
        ("LeftForeArm", 41, 133, -4259.375863),
        ("LeftForeArm", 135, 200, 5239.426948),
        ("LeftForeArm", 215, 303, 1520.467381),
        ("RightShoulder", 50, 110, -503.361084),
        ("RightShoulder", 137, 202, -3954.543912),
        ("RightShoulder", 207, 288, 867.923852),
    ],
}


def drawn(name, seed=7):
    """Errors as `inject` draws them."""
    protocol, rng = parse_protocol(name), clip_random_generator(seed, "walk.bvh")
    return draw_errors(WALK, draw_targets(CHAINS, rng, protocol), rng, protocol)


def every(name, seeds=6):
    """Errors in each chain by itself, as the benchmark draws them."""
    return [
        (chain, error)
        for seed in range(seeds)
        for k, chain in enumerate(CHAINS)
        for error in draw_errors(
            WALK, [chain], clip_random_generator(seed, "walk.bvh", k), parse_protocol(name)
        )
    ]


def size(error):
    return float(np.degrees(np.abs(error.offset)).max())


@pytest.mark.parametrize("name", BEFORE)
def test_a_seed_means_what_it_always_meant(name):
    listed = [
        (e.chain, e.start, e.stop, round(float(np.degrees(e.offset).sum()), 6)) for e in drawn(name)
    ]
    assert listed == BEFORE[name]


@pytest.mark.parametrize("name", NEW)
def test_a_seed_alone_decides_and_errors_lie_apart_inside_of_the_clip(name):
    first, again, other = every(name, 2), every(name, 2), drawn(name, 8)
    assert len(first) == len(again) > 4
    for (_, a), (_, b) in zip(first, again, strict=True):
        assert (a.chain, a.start, a.stop) == (b.chain, b.start, b.stop)
        np.testing.assert_array_equal(a.offset, b.offset)
    here = [(e.chain, e.start, e.offset.tolist()) for e in drawn(name)]
    assert here != [(e.chain, e.start, e.offset.tolist()) for e in other]
    for (c, a), (d, b) in pairwise(first):
        assert 1 <= a.start < a.stop <= WALK.frames
        assert len(a.offset) == a.stop - a.start
        if c is d and a.start < b.start:
            assert a.stop < b.start


@pytest.mark.parametrize("name", RAMPS)
def test_ramps_lie_inside_of_the_interval_on_both_sides(name):
    ramp = int(name[1:])
    for _, error in every(name):
        assert 2 * ramp + 1 <= len(error.offset) <= 2 * ramp + 20
        level = error.offset[ramp]
        assert 5.0 <= abs(np.degrees(level)) <= 180.0
        np.testing.assert_allclose(error.offset[ramp:-ramp], level)
        np.testing.assert_allclose(error.offset[:ramp], level * np.arange(1, ramp + 1) / (ramp + 1))
        np.testing.assert_allclose(error.offset, error.offset[::-1])


@pytest.mark.parametrize("fps", [60.0, 120.0])
@pytest.mark.parametrize("name", FILTERED)
def test_filtered_offsets_are_levels_through_a_zero_phase_butterworth(name, fps):
    protocol, length, around = parse_protocol(name), 17, 2000
    offset = injected_offset_over_time(
        1.0, length, True, True, np.random.default_rng(1), protocol, fps
    )
    level = np.zeros(length + 2 * around)
    level[around:-around] = 1.0
    expected = sosfiltfilt(butter(2, int(name[1:]), fs=fps, output="sos"), level)
    beyond = (len(offset) - length) // 2
    assert beyond >= 2.5 * fps / int(name[1:]) - 1.0
    np.testing.assert_allclose(offset, expected[around - beyond : beyond - around], atol=1e-6)


@pytest.mark.parametrize("name", FILTERED)
def test_drawn_filtered_offsets_keep_their_tails(name):
    hertz = int(name[1:])
    for _, error in every(name, 2):
        ends = np.abs(error.offset[[0, -1]])
        assert ends.min() >= LEAST
        assert ends.max() < max(0.05 * np.abs(error.offset).max(), 3.0 * LEAST)
        power = np.abs(np.fft.rfft(error.offset, 4096)) ** 2
        above = np.fft.rfftfreq(4096, 1.0 / WALK.fps) > 3.0 * hertz
        assert power[above].sum() < 2e-3 * power.sum()


def test_drifts():
    slow = every("D", 3)
    for _, error in slow:
        assert len(error.offset) == round(WALK.fps / 2)
        np.testing.assert_allclose(error.offset, np.linspace(0.0, error.offset[-1], 60), atol=1e-12)
    assert 5.0 <= min(size(e) for _, e in slow) < 100.0 < max(size(e) for _, e in slow) <= 180.0
    for name, eased in (("H11", False), ("S", True)):
        for _, error in every(name, 3):
            length = len(error.offset)
            assert round(0.5 * WALK.fps) <= length <= WALK.frames // 3
            t = 1.0 - np.abs(np.linspace(-1.0, 1.0, length))
            course = 0.5 - 0.5 * np.cos(np.pi * t) if eased else t
            top = error.offset[(length - 1) // 2] / course[(length - 1) // 2]
            np.testing.assert_allclose(error.offset, top * course, atol=1e-12)


@pytest.mark.parametrize(("name", "share"), [("K50", 0.5), ("K80", 0.8)])
def test_the_child_turns_back_by_a_share_only(name, share):
    chain, error = every(name, 1)[0]
    np.testing.assert_allclose(error.leak, (1.0 - share) * error.offset)
    dirty = inject(WALK, CHAINS, [error])
    x, y = (
        b - a
        for a, b in zip(
            *(parent_and_child_twist_increments(m, chain) for m in (WALK, dirty)), strict=True
        )
    )
    full = np.zeros(WALK.frames)
    full[error.start : error.stop] = error.offset
    np.testing.assert_allclose(np.cumsum(x), full, atol=1e-9)
    np.testing.assert_allclose(np.cumsum(y), -share * full, atol=1e-9)


def test_leaks_add_up():
    (_, alone), *_ = every("H5", 1)
    (_, both), *_ = every("H5+K50", 1)
    np.testing.assert_allclose(both.leak, alone.leak + 0.5 * both.offset)


def test_errors_from_the_start_and_to_the_end_alone():
    for seed in range(4):
        errors = drawn("B", seed)
        for chain in {e.chain for e in errors}:
            first, last = (e for e in errors if e.chain == chain)
            assert (first.start, last.stop) == (1, WALK.frames)
            assert all(30 <= len(e.offset) <= WALK.frames // 3 for e in (first, last))


def test_staircases_flicker_and_bursts():
    for _, error in every("ST"):
        top = error.offset[-1]
        levels, frames = np.unique(np.round(error.offset / top, 9), return_counts=True)
        np.testing.assert_allclose(levels, [1 / 3, 2 / 3, 1.0], atol=1e-8)
        assert np.ptp(frames) <= 1
        assert np.all(np.diff(error.offset / top) >= 0.0)
    for _, error in every("FL"):
        assert not error.offset[1::2].any()
        np.testing.assert_allclose(error.offset[::2], error.offset[0])
    noise = np.concatenate([e.offset for _, e in every("NB")])
    assert np.degrees(noise).mean() == pytest.approx(0.0, abs=0.25)
    assert np.degrees(noise).std() == pytest.approx(5.0, abs=0.2)
    assert all(10 <= len(e.offset) <= 40 for _, e in every("NB"))


def test_five_chains_go_wrong_in_the_same_frames_and_turn_no_joint_of_each_other():
    for seed in range(8):
        errors = drawn("M5", seed)
        chains = [next(c for c in CHAINS if c.name == n) for n in {e.chain for e in errors}]
        assert len(chains) == 5
        turned = [j for c in chains for j in (c.parent, c.child)]
        assert len(set(turned)) == 10
        places = {c.name: [(e.start, e.stop) for e in errors if e.chain == c.name] for c in chains}
        assert len({tuple(p) for p in places.values()}) == 1
        assert len({round(size(e), 6) for e in errors}) == len(errors)
    scene = make_clean_scene("walk.bvh", WALK, parse_protocol("M5"))
    assert [targets[0].name for _, targets in scene.passes()] == [c.name for c in CHAINS]
    assert {len(targets) for _, targets in scene.passes()} == {5}


@pytest.mark.parametrize("name", ["GH", "GI"])
def test_over_a_gap_the_twist_is_held_or_goes_on_evenly(name):
    errors = every(name, 3)
    assert {c.name for c, _ in errors} >= {"LeftArm", "RightUpLeg"}
    for chain, error in errors[::7]:
        before, after = (
            parent_and_child_twist_increments(m, chain)[0]
            for m in (WALK, inject(WALK, CHAINS, [error]))
        )
        inside = after[error.start + 1 : error.stop]
        assert np.abs(inside - (0.0 if name == "GH" else inside[0])).max() < 1e-9
        # Cut where the filled twist is the true one: no frame is turned that need not be.
        assert np.abs(error.offset[[0, -1]]).min() >= LEAST
        np.testing.assert_allclose(
            np.cumsum(after - before)[error.start : error.stop], error.offset, atol=1e-9
        )


def test_a_gap_in_which_nothing_turns_is_no_error():
    assert not any(c.name == "LeftShoulder" for c, _ in every("GH"))


def test_straight_limbs_are_wrong_where_they_are_straight():
    found = every("SL", 2)
    assert {c.name for c, _ in found} >= {"LeftArm", "RightArm"}
    for chain, error in found:
        v = rotate(WALK.rotations[:, chain.child], chain.arm)
        bend = np.arccos(np.clip(v @ chain.axis, -1.0, 1.0))[error.start : error.stop]
        assert bend[0] < STRAIGHT
        assert bend[-1] < STRAIGHT
        bent = np.split(bend, np.flatnonzero(bend < STRAIGHT))
        assert max(map(len, bent)) - 1 <= round(0.1 * WALK.fps)
        if len(bend) > 33:
            assert 15.0 <= size(error) <= 60.0
            level = np.isclose(np.abs(error.offset), np.abs(error.offset).max())
            ramp = int(level.argmax())
            assert error.start == 1 or 8 <= ramp <= 16
    targets = make_clean_scene("walk.bvh", WALK, parse_protocol("SL")).targets
    assert {c.segment for c in targets} == {"Arm", "UpLeg"}


def test_protocols_combine_or_say_why_not():
    both = parse_protocol("rich+R8+H2")
    assert (both.rich, both.ramp, both.step, both.length) == (True, 8, 2, (17, 36))
    for name in ("L0+M5", "L0+GH", "SL+L1"):
        with pytest.raises(TwistError, match="cannot be combined with errors of single bones"):
            parse_protocol(name)
    assert len({p.text for p in PROTOCOLS.values()}) == len(PROTOCOLS)


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    """A clip that is quickly written."""
    path = tmp_path_factory.mktemp("short") / "short.bvh"
    write_motion(WALK.sliced(1, 241), path)
    return str(path)


@parametrize("name", [*NEW, "H12+R8"], quick=4)
def test_the_commands_put_them_in_and_measure_them(name, short, tmp_path, capsys):
    dirty, truth = str(tmp_path / "dirty.bvh"), str(tmp_path / "truth.json")
    words = ["--truth", truth, "--seed", "8", "--protocol", name]
    assert main(["inject", short, "-o", dirty, *words]) == 0
    assert f"protocol {name}, seed 8" in capsys.readouterr().out
    known = read_truth(tmp_path / "truth.json")
    assert (known.protocol, known.frames) == (name, 240)
    assert len(known.errors) >= 1
    assert (known.errors[0].leak is not None) == name.startswith("K")
    files = ["--truth", truth, "--clean", short, "--refined"]
    assert main(["evaluate", *files, dirty, "--json"]) == 0
    table = json.loads(capsys.readouterr().out)
    assert table["overall"]["rer_percent"] == pytest.approx(100.0, abs=0.5)
    assert table["overall"]["fsr_percent"] == 0.0
    assert table["clean_damage_percent"] == 0.0
    counted = sum((np.abs(e.offset) >= np.radians(0.5)).sum() for e in known.errors)
    assert table["overall"]["frames"] == counted


def test_every_protocol_is_in_the_help(capsys):
    with pytest.raises(SystemExit):
        main(["inject", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert all(f"{name}: " in said for name in PROTOCOLS)


def test_an_offset_below_half_a_degree_is_neither_wrong_nor_clean():
    chain = CHAINS[1]
    offset = np.radians([0.2, 0.49, 0.51, 30.0, 0.51, 0.49, 0.2])
    truth = Truth(
        "walk", "P0", 1, WALK.frames, WALK.fps, (InjectedError(chain.name, 50, 57, offset),)
    )
    untouched = measure_corrected_clip(truth, WALK, inject(WALK, CHAINS, truth.errors), CHAINS)
    np.testing.assert_allclose(
        np.degrees(untouched.errors[0].before), [0.51, 30.0, 0.51], atol=1e-6
    )
    whole = measure_corrected_clip(
        Truth("walk", "H10", 1, WALK.frames, WALK.fps, ()), WALK, WALK, CHAINS
    )
    turned = len(chain.changed_joints(WALK.skeleton))
    assert len(whole.clean_change) - len(untouched.clean_change) == 7 * turned
    repaired = measure_corrected_clip(truth, WALK, WALK, CHAINS)
    assert repaired.errors[0].after.max() < 1e-9
    assert repaired.clean_change.max() < 1e-9


def test_what_comes_out_worse_is_counted():
    before, after = np.radians([[10.0, 10.0, 10.0, 1.0], [10.4, 10.6, 0.0, 60.0]])
    tally = tally_error_angles(before, after)
    assert (tally.frames, tally.repaired, tally.worse) == (4, 1, 2)


@pytest.mark.thorough
def test_the_benchmark_tells_of_new_rows_and_of_what_came_out_worse():
    settings = BenchmarkSettings(("R8", "GI", "SL"), ("unroll", "pca", "slerp-oracle"), (1,))
    result = run_clip_benchmark(ASSETS / "walk.bvh", "walk.bvh", settings)
    assert not result.problems
    summary = BenchmarkSummary()
    summary.add(result)
    rows = {
        (r.protocol, r.method): r.to_json()
        for r in benchmark_rows(summary, settings)
        if (r.side, r.segment, r.audited) == ("", "Overall", False)
    }
    for name in settings.protocols:
        assert rows[name, "unroll"]["worse_percent"] == 0.0
        assert rows[name, "unroll"]["fsr_percent"] == 0.0
        assert rows[name, "slerp-oracle"]["frames"] > 50
    assert rows["SL", "unroll"]["passes"] == 4
    assert rows["GI", "pca"]["worse_percent"] > 0.0
    page = benchmark_to_markdown(summary, settings, "assets")
    header = next(line for line in page.splitlines() if "FSR %" in line)
    assert "worse %" in header
    value = f"{rows['GI', 'pca']['worse_percent']:.2f}"
    assert any("PCA" in line and f" {value} " in line for line in page.splitlines())
    assert "grew by more than 0.5°" in " ".join(page.split())
    for name in settings.protocols:
        assert f"## {name}: {PROTOCOLS[name].text}" in page


@pytest.mark.parametrize("first", [0, 3])
@pytest.mark.parametrize(
    ("straight", "wanted"),
    [
        ([(10, 20)], [(10, 20)]),
        ([(10, 20), (21, 30)], [(10, 30)]),  # a tenth of a second apart at most
        ([(10, 20), (22, 30)], [(10, 20), (22, 30)]),
        ([(10, 11)], []),  # too short
        ([(10, 12)], [(10, 12)]),
        ([(0, 7), (40, 50)], [(0, 7), (40, 50)]),  # at both ends of the clip
        ([(0, 50)], []),  # always straight
        ([], []),
    ],
)
def test_spells_in_line_begin_and_end_with_their_own_frames(straight, wanted, first):
    at = np.zeros(50, dtype=bool)
    for start, stop in straight:
        at[start:stop] = True
    bend = np.where(at, 0.9, 1.1) * STRAIGHT
    x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    offsets = np.array([0.0 * x, x, x, x])
    skeleton = Skeleton(("A", "B", "C", "D"), np.array([-1, 0, 1, 2]), offsets)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (50, 4, 1))
    q[:, 2] = quaternion_from_axis_angle(y, bend)
    motion = Motion(skeleton, q, (0,), np.zeros((50, 1, 3)), 1 / 20)
    later = [(max(start, first), stop) for start, stop in wanted]
    assert list(spans_with_straight_chain(motion, Chain("B", 1, 2, 3, x, x), first)) == later
    assert list(spans_with_straight_chain(motion, Chain("B", 1, 2, -1, x, x), first)) == []


# -- errors of a single joint ----------------------------------------------------------------------


@pytest.mark.parametrize(("name", "about"), [("STR", 1.0), ("SP", 0.0)])
def test_an_error_of_a_single_joint_turns_only_a_foot_or_a_hand(name, about):
    """A stretch turns it about its bone, and a spike about an axis across the bone."""
    scene = make_clean_scene("walk.bvh", WALK, parse_protocol(name))
    names = WALK.skeleton.names
    assert {names[c.child] for c in scene.targets} == {
        "LeftFoot", "RightFoot", "LeftHand", "RightHand",
    }  # fmt: skip
    for chain in scene.targets:
        errors = draw_errors(
            scene.motion, [chain], clip_random_generator(3, "walk"), scene.protocol
        )
        assert errors
        assert name == "SP" or len(errors) == 1
        dirty = inject(scene.motion, [chain], errors)
        changed = (dirty.rotations != scene.motion.rotations).any(axis=2)
        assert np.flatnonzero(changed.any(axis=0)).tolist() == [chain.child]
        for error in errors:
            before, after = (
                m.rotations[error.start : error.stop, chain.child] for m in (scene.motion, dirty)
            )
            turn = geodesic_angle(before, after)
            np.testing.assert_allclose(turn, np.abs(error.offset), atol=1e-9)
            axis = own_bone_axis(WALK.skeleton, chain.child)
            rolled = np.abs(twist_angle(multiply(conjugate(before), after), axis))
            np.testing.assert_allclose(rolled, about * turn, atol=1e-9)


@pytest.mark.parametrize("name", ["STR", "SP"])
def test_errors_of_a_single_joint_are_measured_as_if_all_findings_were_accepted(name):
    scene = make_clean_scene("walk.bvh", WALK, parse_protocol(name))
    total = sum(run_benchmark_passes(scene, "consistency", 1).values(), Tally())
    assert (total.matched, total.found) == (total.truths, total.truths)
    assert total.repaired >= 0.9 * total.frames > 0
    assert total.damaged == 0
    nothing = sum(run_benchmark_passes(scene, "unroll", 1).values(), Tally())
    assert (nothing.frames, nothing.repaired) == (total.frames, 0)


@pytest.mark.parametrize("name", ["STR", "SP"])
def test_a_truth_with_errors_of_a_single_joint_is_read_back(tmp_path, name):
    scene = make_clean_scene("walk.bvh", WALK, parse_protocol(name))
    errors = draw_errors(
        scene.motion, scene.targets, clip_random_generator(3, "walk"), scene.protocol
    )
    truth = Truth("walk.bvh", name, 3, scene.motion.frames, WALK.fps, errors)
    path = tmp_path / "truth.json"
    write_truth(path, truth)
    again = read_truth(path)
    assert [(e.kind, e.carried, e.start) for e in again.errors] == [
        (scene.protocol.single, True, e.start) for e in errors
    ]
    dirty = inject(scene.motion, scene.chains, again.errors)
    untouched = summarise_samples(
        [measure_corrected_clip(again, scene.motion, dirty, scene.chains)]
    )
    assert (untouched.overall.fsr_percent, untouched.damage_share) == (0.0, 0.0)
    perfect = summarise_samples(
        [measure_corrected_clip(again, scene.motion, scene.motion, scene.chains)]
    )
    assert perfect.overall.fsr_percent == 100.0
    path.write_text(path.read_text("utf-8").replace('"carried": true', '"carried": false'))
    with pytest.raises(TwistError, match="carried"):
        read_truth(path)


def test_errors_of_a_single_joint_fit_only_some_protocols():
    assert all(parse_protocol(name).single for name in ("STR+P0", "SP+H1", "STR+H7"))
    for name in ("STR+L0", "SP+CR", "SP+R8", "STR+M5"):
        with pytest.raises(TwistError, match="single joint"):
            parse_protocol(name)


def test_inject_puts_an_error_of_a_single_joint_into_a_file(tmp_path, capsys):
    out, truth = tmp_path / "out.bvh", tmp_path / "truth.json"
    given = ["--protocol", "STR", "--seed", "2", "--truth", truth]
    assert main(["inject", *map(str, (ASSETS / "walk.bvh", "-o", out, *given))]) == 0
    errors = read_truth(truth).errors
    names = WALK.skeleton.names
    ends = {c.name: c.child for c in CHAINS if names[c.child].endswith(("Foot", "Hand"))}
    assert {e.chain for e in errors} <= set(ends)
    turn = geodesic_angle(read_bvh(out).motion.rotations, WALK.rotations) > 1e-6
    assert {*np.flatnonzero(turn.any(axis=0)).tolist()} == {ends[e.chain] for e in errors}
