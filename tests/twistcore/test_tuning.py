"""τ from noise and injected errors, and the profile that keeps it."""

import math
import re
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers, refused
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import analyse, detect
from twistcore.batch import survey_clip
from twistcore.cli import main
from twistcore.detection import DETECTORS
from twistcore.errors import FormatError
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decide, Decision, LeaveOut, Review, write_session
from twistcore.skeleton.chain import find_chains, group_connected_chains
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
)
from twistcore.tuning import (
    GRID,
    Profile,
    TauCurve,
    Tuned,
    Verdicts,
    clip_tau_curves,
    prepare_clip_tuning,
    read_profile,
    tau_with_cost,
    total_tuning_cost,
    without_known_errors,
    write_profile,
)
from twistcore.tuning.cost_words import (
    describe_false_alarms,
    format_alarm_count,
    format_repaired_share,
)
from twistcore.tuning.learned_confidence import LearnedConfidence
from twistcore.tuning.profile import TauReasons
from twistcore.tuning.tau_curve import LOSS_ALLOWED, SMALLEST_ERROR
from twistcore.tuning.verdicts_of import counter_twist_verdicts_of_review


def curve(repaired, alarms, noise=(0.01,)):
    tau = np.radians(np.arange(1.0, len(repaired) + 1))
    return TauCurve(tau, np.array(repaired, float), 1000, np.array(alarms, float), 2.0, noise)


def test_an_alarm_has_its_price_and_errors_have_theirs():
    # One alarm in two minutes is worth 2.5 points of FSR: 3° beats 2°, and 4° costs too much.
    assert np.degrees(curve([1000, 990, 985, 950], [9, 1, 0, 0]).suggested()) == pytest.approx(3.0)
    # A single natural event must not drive τ past half of the errors.
    c = curve([1000, 1000, 500, 500], [1, 1, 0, 0])
    assert np.degrees(c.suggested()) == pytest.approx(2.0)
    assert tau_with_cost(c).fsr == pytest.approx(100.0)
    assert tau_with_cost(c).alarms_per_minute == pytest.approx(0.5)


def test_among_equals_tau_is_no_larger_than_the_smallest_errors_looked_for():
    assert np.degrees(curve([1000] * 8, [0] * 8).suggested()) == pytest.approx(2.0)
    c = curve([1000] * 8, [9, 9, 9, 9, 0, 0, 0, 0])
    assert np.degrees(c.suggested()) == pytest.approx(5.0)


def test_never_below_the_clips_own_noise():
    c = curve([1000, 900, 100, 0, 0], [0] * 5, noise=tuple(np.radians([2.5, 2.6, 9.0])))
    assert np.degrees(c.suggested()) == pytest.approx(3.0)
    assert np.degrees(curve([1], [0], noise=(0.5,)).suggested()) == pytest.approx(np.degrees(0.5))


def test_curves_of_clips_add():
    both = curve([10, 5], [1, 0]) + curve([20, 5], [2, 0])
    assert both.errors == 2000
    assert both.minutes == 4.0
    np.testing.assert_allclose(both.fsr, [0.015, 0.005])
    np.testing.assert_array_equal(both.alarms, [3, 0])


def test_a_profile_comes_back(tmp_path):
    path = tmp_path / "p.toml"
    names = {'odd "name" #2': Tuned(4.5, 0.1, 99.0, 0.0), "LeftArm": Tuned(1.5, 0.2, 98.0, 0.1)}
    write_profile(path, names, "clips", "paper")
    assert {k: np.degrees(v) for k, v in read_profile(path).tau.items()} == pytest.approx(
        {'odd "name" #2': 4.5, "LeftArm": 1.5}
    )


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[LeftArm]\ntau_deg = 0\n",
        "[LeftArm]\ntau_deg = nan\n",
        "[LeftArm]\ntau_deg = 181\n",
        "[LeftArm]\nx = 1\n",
        "[LeftArm]\ntau_deg = 2\ndetector = 'radar'\n",
        "LeftArm = 3",
        "[",
    ],
)
def test_a_damaged_profile_is_one_sentence(tmp_path, text):
    path = tmp_path / "p.toml"
    path.write_text(text)
    with pytest.raises(FormatError) as caught:
        read_profile(path)
    assert "\n" not in str(caught.value)


def test_the_command_writes_a_profile_that_detect_takes(tmp_path, capsys):
    out = tmp_path / "p.toml"
    words = ["tune", str(ASSETS / "walk.bvh"), "-o", str(out), "--seeds", "1", "--workers", "1"]
    assert main([*words, "--method", "paper"]) == 0
    assert len(read_profile(out).tau) == 10
    assert main(["detect", str(ASSETS / "walk.bvh"), "--profile", str(out)]) == 0
    assert "LeftForeArm" in capsys.readouterr().out
    assert main(["tune", str(tmp_path), "-o", str(out)]) == 2


@pytest.mark.thorough
def test_a_clips_own_errors_are_neither_false_alarms_nor_in_the_way():
    """Taken as false alarms they drive τ above themselves, past most of the errors there are."""
    curves = clip_tau_curves(ASSETS / "walk_injected.bvh", "consistency", 2)
    assert len(curves) == 10
    for c in curves.values():
        assert np.degrees(c.suggested()) <= 3.0  # below, a find is left for a person
        assert tau_with_cost(c).fsr > 99.0
        assert not c.alarms.any()


@parametrize("method", ["consistency", "paper"])
def test_what_a_person_calls_natural_is_a_false_alarm(dirty_walk, method):
    motion, chains = dirty_walk.motion, find_chains(dirty_walk.motion)
    found = detect(motion, chains)
    named = Verdicts(natural=((found[0].chain, found[0].start, found[0].stop),))
    curve = prepare_clip_tuning(motion, "w", seeds=(0,), method=method, verdicts=named)
    assert curve.curve(found[0].chain).alarms[0] >= 1.0
    # Named an error it is taken out instead, whatever the detector thinks of it.
    shifted = found[0].with_offset(found[0].start, 0.5 * found[0].offset)
    half = without_known_errors(analyse(motion), Verdicts(errors=(shifted,)))
    parent = next(c.parent for c in chains if c.name == found[0].chain)
    turned = geodesic_angle(motion.rotations[:, parent], half.rotations[:, parent])
    at = slice(found[0].start, found[0].stop)
    np.testing.assert_allclose(turned[at], np.abs(shifted.offset), atol=1e-9)


def test_a_limb_by_itself_is_analysed_as_in_the_whole_body(sample):
    motion, chains = sample.motion, find_chains(sample.motion)
    whole = DETECTORS["consistency"].analyse(motion, chains)
    for chain in chains:
        limb = next(
            limb for limb in group_connected_chains(motion.skeleton, chains) if chain in limb
        )
        assert len(limb) < len(chains)
        alone = DETECTORS["consistency"].analyse(motion, limb)
        np.testing.assert_array_equal(alone.strength(chain.name), whole.strength(chain.name))
        assert alone.automatic_tau(chain.name) == whole.automatic_tau(chain.name)


@pytest.mark.thorough
def test_a_noisy_capture_gets_a_larger_tau(walk):
    rng = np.random.default_rng(3)
    motion = walk.motion
    axis = normalise(rng.standard_normal((*motion.rotations.shape[:2], 3)))
    turn = quaternion_from_axis_angle(axis, np.radians(2.0) * rng.standard_normal(axis.shape[:2]))
    noisy = motion.with_rotations(normalise(multiply(motion.rotations, turn)))
    quiet, loud = (
        prepare_clip_tuning(m, "walk", seeds=(0,)).curve("LeftForeArm").suggested()
        for m in (motion, noisy)
    )
    assert loud > 1.5 * quiet
    assert loud >= prepare_clip_tuning(noisy, "walk").clean.by().automatic_tau("LeftForeArm")


def test_a_profile_says_what_it_was_tuned_for(tmp_path, capsys):
    path = tmp_path / "p.toml"
    write_profile(path, {"LeftArm": Tuned(4.5, 0.1, math.nan, math.nan)}, "clips", "paper")
    assert read_profile(path).method == "paper"
    assert "fsr" not in path.read_text()
    walk = str(ASSETS / "walk.bvh")
    assert main(["detect", walk, "--profile", str(path)]) == 0
    assert names_in_one_line(capsys.readouterr().err, f"{path}: ", "paper", "consistency")
    assert main(["detect", walk, "--profile", str(path), "--method", "paper"]) == 0
    assert capsys.readouterr().err == ""


def test_a_survey_takes_the_tau_of_a_profile():
    clip = ASSETS / "walk_injected.bvh"
    everything = survey_clip(clip).intervals
    none = Profile(dict.fromkeys(clip_tau_curves(clip, "paper", 0), math.pi))
    assert (everything, survey_clip(clip, none).intervals) == (8, 0)


# -- the command, with sessions and both detectors ------------------------------------------------


@pytest.fixture
def reviewed(tmp_path):
    """A copy of the walk with errors; its review rejects one interval and leaves frames out."""
    path = Path(shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "w.bvh"))
    clip = read_bvh(path)
    review = Review.of(analyse(clip.motion).detect())
    state = review.state
    one = next(j for j in state.intervals if j.interval.stop <= 150)
    for command in (Decide((one.id,), Decision.REJECTED), LeaveOut(((150, 344),))):
        review.do(command)
    write_session(clip, review.state, tmp_path / "w.twist.json")
    return path, one.interval


@pytest.mark.thorough
def test_tune_leaves_out_what_a_session_leaves_out(reviewed, tmp_path, capsys):
    path, natural = reviewed
    clip = read_bvh(path)
    out = tmp_path / "p.toml"
    words = ["tune", str(path), "-o", str(out), "--seeds", "1", "--workers", "1"]
    assert main([*words, "--sessions"]) == 0
    assert "w.bvh: " in capsys.readouterr().err
    session = path.with_name("w.twist.json")
    curves = clip_tau_curves(path, "consistency", 1, session=session)
    tuning = prepare_clip_tuning(
        clip.motion, "w.bvh", seeds=(0,), left_out=[(150, 344)],
        verdicts=Verdicts(natural=((natural.chain, natural.start, natural.stop),)),
    )  # fmt: skip
    for name, curve in curves.items():
        mine = tuning.curve(name)
        np.testing.assert_array_equal(curve.repaired, mine.repaired)
        np.testing.assert_array_equal(curve.alarms, mine.alarms)
        assert curve.minutes == mine.minutes == pytest.approx(150 * clip.motion.frame_time / 60.0)
        assert read_profile(out).tau[name] == pytest.approx(curve.suggested(), abs=1e-4)
    assert curves[natural.chain].alarms[0] >= 1.0
    path.write_bytes(path.read_bytes() + b"\n")
    assert main([*words, "--sessions"]) == 2
    assert "w.bvh: " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"method": "consistency"', '"method": "guess"', "consistency or paper"),
        ('"chain": "', '"chain": "Tail', "'Tail"),
    ],
)
def test_tune_refuses_a_session_of_what_is_not_there(reviewed, tmp_path, capsys, old, new, said):
    path, _ = reviewed
    session, out = path.with_name("w.twist.json"), tmp_path / "p.toml"
    session.write_text(session.read_text().replace(old, new))
    words = ["tune", str(path), "-o", str(out), "--seeds", "0", "--workers", "1", "--sessions"]
    assert main(words) == 2
    assert names_in_one_line(capsys.readouterr().err.splitlines()[-1], "w.bvh: ", said)
    assert not out.exists()


@pytest.mark.thorough
def test_tune_guesses_nothing_where_a_session_cannot_be_read(reviewed, tmp_path, capsys):
    path, _ = reviewed
    session, out = path.with_name("w.twist.json"), tmp_path / "p.toml"
    words = ["-o", str(out), "--seeds", "0", "--workers", "1", "--sessions"]
    whole = session.read_text()
    session.write_text(whole.replace('"left_out"', '"left_out": "all", "_"'))
    assert main(["tune", str(path), *words]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert names_in_one_line(said, "w.twist.json: ", "left_out", "'all'")
    shutil.copy(ASSETS / "kick.bvh", tmp_path / "k.bvh")
    assert main(["tune", str(tmp_path), *words]) == 1
    told = capsys.readouterr().err
    assert "k.bvh: " in told
    assert "w.twist.json: " in told
    assert "w.bvh: " not in told
    out.unlink()
    assert main(["tune", str(tmp_path / "k.bvh"), *words]) == 2  # its neighbour's is none of its
    session.write_text(re.sub(r'"left_out": [^"]*$', '"left_out": [[0, 344]]}', whole))
    assert main(["tune", str(path), *words]) == 2
    assert str(path) in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.thorough
def test_tune_counts_the_minutes_of_clips_of_several_rigs_once_each(tmp_path, capsys):
    words = ["tune", str(tmp_path), "-o", str(tmp_path / "p.toml"), "--seeds", "0", "--both"]
    text = (ASSETS / "kick.bvh").read_text()
    rates = []
    for name in ("a.bvh", "b.bvh"):  # the same clip, and then twice, the other by other names
        (tmp_path / name).write_text(text)
        text = re.sub(r"((?:ROOT|JOINT)\s+)(\S+)", r"\1Z\2", text)
        assert main([*words, "--workers", "1"]) == 0
        rates.append(capsys.readouterr().out.splitlines()[-1].split())
    assert rates[0] == rates[1]
    assert any(float(rate) > 0.0 for rate in rates[0] if rate[0].isdigit())


def test_in_no_minute_nothing_is_known_of_alarms(tmp_path):
    none = TauCurve(np.radians([1.0, 2.0]), np.zeros(2), 0, np.zeros(2), 0.0, (0.01,))
    cost = none.cost(0.02)
    assert math.isnan(cost.rate)
    assert format_alarm_count(cost) == "–"
    assert numbers(describe_false_alarms(cost)) == []
    write_profile(tmp_path / "p.toml", {"A": tau_with_cost(none)}, "clips", "consistency")
    assert "false_alarms" not in (tmp_path / "p.toml").read_text()


def test_tune_prints_bands_and_both_detectors(tmp_path, capsys):
    clip, out = ASSETS / "walk.bvh", tmp_path / "p.toml"
    words = ["tune", str(clip), "-o", str(out), "--seeds", "1", "--workers", "1"]
    assert main([*words, "--both"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + 2 * 11
    measured = [clip_tau_curves(clip, m, 1) for m in ("consistency", "paper")]
    (at,) = (k for k, line in enumerate(lines) if line.startswith("RightArm "))
    for line, tau in ((lines[at], "suggested"), (lines[at + 1], "automatic")):
        assert tau in line
        for curve in (curves["RightArm"] for curves in measured):
            value = curve.suggested() if tau == "suggested" else curve.automatic
            assert f"{np.degrees(value):.2f}°" in line
            assert format_repaired_share(curve.cost(value), unit="") in line
    total = total_tuning_cost([(c, c.suggested()) for c in measured[1].values()])
    assert format_repaired_share(total, unit="") in lines[-2]
    assert read_profile(out).method == "consistency"
    assert main(["tune", str(tmp_path), "-o", str(out), "--verdicts", "--both"]) == 2
    assert names_in_one_line(capsys.readouterr().err, "--both", "--verdicts")


# -- whose profile -------------------------------------------------------------------------------

WHOSE = Profile({}, "", "ab12", 'Ann "A"', LearnedConfidence(-0.25, 0.75, 180, 20))


def written(path, **more):
    tau = {"LeftArm": Tuned(4.5, math.nan, math.nan, math.nan)}
    write_profile(path, tau, "clips", "consistency", **more)
    return path


def test_a_profile_keeps_whose_it_is_and_the_learned_confidence(tmp_path):
    reasons = {"LeftArm": TauReasons(9, 1, 3.0, 6.0)}
    got = read_profile(written(tmp_path / "p.toml", whose=WHOSE, verdicts=reasons))
    assert got == replace(WHOSE, tau={"LeftArm": math.radians(4.5)}, method="consistency")
    assert "tau_low_deg = 3.0000" in (tmp_path / "p.toml").read_text()


def test_readers_of_earlier_versions_read_it(tmp_path):
    """They take tau_deg and detector of every table of the document, and nothing else."""
    path = written(tmp_path / "p.toml", whose=WHOSE, verdicts={"LeftArm": TauReasons(9, 1)})
    document = tomllib.loads(path.read_text("utf-8"))
    assert {name: float(t["tau_deg"]) for name, t in document.items()} == {"LeftArm": 4.5}
    assert {t["detector"] for t in document.values()} == {"consistency"}


@pytest.mark.parametrize(
    ("line", "facts"),
    [
        ("confidence = 3", ("confidence",)),
        ("confidence = { shift = 0.1, scale = 0.0 }", ("scale", "0.0")),
        ("confidence = { shift = nan, scale = 1.0 }", ("shift", "-30.0", "30.0")),
        ("confidence = { shift = 0.1, scale = 1.0, accepted = -1 }", ("accepted", "0")),
        ("rig = 4", ("rig",)),
        (f"confidence = {{ shift = 1{400 * '0'}, scale = 1.0 }}", ("shift", "1000")),
        (f"[RightArm]\ntau_deg = 1{400 * '0'}", ("tau_deg", "0.0", "180.0")),
    ],
)
def test_a_damaged_profile_says_what_was_expected(tmp_path, line, facts):
    path = tmp_path / "p.toml"
    path.write_text(f"[LeftArm]\ntau_deg = 2.0\n{line}\n")
    with refused(FormatError, str(path), *facts):
        read_profile(path)


def test_two_rigs_in_one_profile_are_refused(tmp_path):
    path = tmp_path / "p.toml"
    path.write_text('[A]\ntau_deg = 2.0\nrig = "a"\n[B]\ntau_deg = 2.0\nrig = "b"\n')
    with pytest.raises(FormatError, match="rig"):
        read_profile(path)


# -- what is listed, and what is not moved -------------------------------------------------------


def test_the_counts_are_those_of_the_list_and_the_verdicts():
    clip = read_bvh(ASSETS / "walk_injected.bvh")
    analysis = analyse(clip.motion)
    review = Review.of(analysis.detect())
    first, second, *_ = review.state.of_chain("RightUpLeg")
    for judged, decision in ((first, Decision.REJECTED), (second, Decision.ACCEPTED)):
        review.do(Decide((judged.id,), decision, "me", "2026-01-01T00:00:00"))
    verdicts = counter_twist_verdicts_of_review(review.state)
    tuning = prepare_clip_tuning(clip.motion, "w", seeds=(), verdicts=verdicts)
    curve = tuning.curve("RightUpLeg")
    for k, tau in enumerate(GRID):
        listed = [i for i in analysis.detect(tau_radians=float(tau)) if i.chain == "RightUpLeg"]
        at = curve.counts_at(float(tau))
        assert at.listed == len(listed)
        assert at.automatic == sum(not i.open and i.confidence >= 0.5 for i in listed)
        wrong = [
            i for i in listed if i.start < first.interval.stop and first.interval.start < i.stop
        ]
        assert at.rejected == len(wrong) == curve.alarms[k] - curve.unjudged_at(float(tau))
    assert curve.counts_at(GRID[0]).rejected == 1.0
    # Nobody judged the three others: they are taken for errors, not for false alarms.
    assert sum(chain == "RightUpLeg" for chain, _, _ in tuning.presumed) == 3
    assert not any(curve.unjudged_at(float(tau)) for tau in GRID)


def test_frames_that_are_left_out_are_not_counted():
    clip = read_bvh(ASSETS / "walk_injected.bvh")
    tuning = prepare_clip_tuning(
        clip.motion, "w", seeds=(), verdicts=Verdicts(), left_out=[(140, 344)]
    )
    assert tuning.curve("RightUpLeg").counts_at(0.05).listed == 2.0  # of five


def test_a_suggestion_never_moves_without_a_gain():
    c = curve([1000, 1000, 990, 800], [1, 0, 0, 0])
    for degrees in (2.0, 1.7):  # of τ = 1, 2, 3, 4: 2.0 is the best, 1.7 is not
        present = float(np.radians(degrees))
        moved = c.suggested(0.05, SMALLEST_ERROR, present=present)
        better = c.losses(np.array([present, moved]), 0.05, SMALLEST_ERROR)
        assert (moved == present) == (degrees == 2.0)
        assert moved == present or better[1] < better[0] - LOSS_ALLOWED
    flat = curve([1000] * 4, [0] * 4, noise=(float(np.radians(1.2)),))
    assert flat.suggested(present=float(np.radians(1.3))) == float(np.radians(1.3))
    assert np.degrees(flat.suggested(present=float(np.radians(0.7)))) >= 1.2  # below the noise
    low, high = np.degrees(flat.plateau(float(np.radians(1.3)), 0.05, SMALLEST_ERROR))
    assert (low, high) == pytest.approx((1.2, 4.0))
    low, high = np.degrees(c.plateau(float(np.radians(2.0)), 0.05, SMALLEST_ERROR))
    assert low == high == pytest.approx(2.0)
