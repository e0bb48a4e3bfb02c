"""Errors that set in softly: on silent joints at any pace, on lively ones what departs too far."""

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine, remove_twist
from twistcore.cli import main
from twistcore.detection.consistency.detector import _limbs, _lines
from twistcore.detection.soft_errors import Known, search_soft_errors
from twistcore.detection.soft_errors.silent_joints import (
    accumulated_twist_if_silent,
    find_silent_joints,
    silent_joint_error_ranges,
)
from twistcore.detection.soft_errors.surprise import Surprise
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    wrap,
)
from twistcore.synthesis import (
    add_twist_from_opposite_side,
    clip_random_generator,
    draw_errors,
    inject,
    parse_protocol,
    prepare_clean_motion_for_injection,
)

CLIPS = sorted(
    p.relative_to(ASSETS).as_posix()
    for p in ASSETS.glob("**/*.bvh")
    if p.stem not in ("walk_injected", "walk_noisy")
)
FPS = 120.0
THIRTY = np.radians(30.0)
RNG = np.random.default_rng(11)


@cache
def clip(name, kind="plain"):
    """A clip behind its T-pose: as captured, with lively joints, or every fourth frame."""
    motion = read_bvh(ASSETS / name).motion
    motion = motion.sliced(1, motion.frames)
    if kind == "rich":
        return add_twist_from_opposite_side(motion, find_chains(motion))
    return (
        prepare_clean_motion_for_injection(motion, (), parse_protocol("H1"))
        if kind == "30 Hz"
        else motion
    )


def chain_of(motion, name):
    return next(c for c in find_chains(motion) if c.name == name)


def erring(motion, name, start, offset):
    full = np.zeros(motion.frames)
    full[start : start + len(offset)] = offset
    return full, remove_twist(motion, [chain_of(motion, name)], {name: -full})


def found_in(motion):
    """Intervals that are corrected unasked, and what they take out, by chain."""
    intervals = automatic_corrections(analyse(motion).detect(kinds="counter-twist"))
    total = {c.name: np.zeros(motion.frames) for c in find_chains(motion)}
    for i in intervals:
        total[i.chain][i.start : i.stop] += i.offset
    return intervals, total


def soft_of(motion):
    """Intervals that stand by softness, all chains."""
    return soft_in(ClipAnalysis(motion, find_chains(motion)).by())


def soft_in(found):
    return [
        s
        for c in found.chains.values()
        for s in c.fixed
        if s.interval.evidence["follows"] == "a soft onset"
    ]


def low_passed(level, hertz, fps=FPS):
    return sosfiltfilt(butter(2, hertz, fs=fps, output="sos"), np.pad(level, 40))


def step(length, delta=THIRTY, width=8):
    rise = np.arange(1, width + 1) / (width + 1)
    return delta * np.r_[rise, np.ones(length - 2 * width), rise[::-1]]


SHAPES = {
    "ramp of 8": step(30),
    "ramp of 16": step(50, width=16),
    "low-passed at 10 Hz": low_passed(np.full(15, THIRTY), 10.0),
    "low-passed at 6 Hz": low_passed(np.full(18, THIRTY), 6.0),
    "drift of a second": THIRTY * np.sin(np.linspace(0.0, np.pi, 122))[1:-1] ** 2,
    "drifts in, jumps out": THIRTY * np.linspace(0.0, 1.0, 61)[1:],
    "staircase": np.repeat([THIRTY / 3, 2 * THIRTY / 3, THIRTY], 9),
    "noise": np.radians(5.0) * np.random.default_rng(3).standard_normal(30),
}
CHAINS = ("LeftArm", "RightForeArm", "LeftUpLeg", "RightLeg")


def left_of(name, start, offset, motion):
    """What is left of an error in its frames and beside them, and what else is turned, radians."""
    full, dirty = erring(motion, name, start, offset)
    _, total = found_in(dirty)
    left = np.abs(wrap(total.pop(name) - full))
    at = np.abs(full) > 0.0
    return left[at], left[~at], max(np.abs(v).max() for v in total.values())


@parametrize("shape", SHAPES, quick=4)
@pytest.mark.parametrize("name", ["LeftArm", "RightForeArm", "RightLeg"])
def test_a_silent_joint_tells_an_error_of_any_pace(name, shape):
    inside, outside, elsewhere = left_of(name, 120, SHAPES[shape], clip("basketball.bvh"))
    assert np.degrees(inside.max()) < 0.15
    assert np.degrees(outside.max(initial=0.0)) < 0.15
    assert elsewhere == 0.0


def test_what_a_silent_joint_tells_is_sure():
    _, dirty = erring(clip("walk.bvh"), "RightForeArm", 150, SHAPES["ramp of 8"])
    (standing,) = soft_of(dirty)
    assert standing.interval.confidence > 0.5


@pytest.mark.parametrize("fps", [30, 60])
def test_at_lower_rates_too(fps):
    base = clip("walk.bvh")
    motion = prepare_clean_motion_for_injection(
        base, (), parse_protocol("H1" if fps == 30 else "H2")
    )
    inside, outside, elsewhere = left_of("LeftUpLeg", 30, step(14, width=4), motion)
    assert np.degrees(max(inside.max(), outside.max(), elsewhere)) < 0.15


@parametrize("shape", ["ramp of 8", "low-passed at 10 Hz", "staircase"])
def test_where_both_joints_live_what_departs_from_natural_motion_is_found(shape):
    before, after, offset = [], [], SHAPES[shape]
    for name in CHAINS:
        for start in (60, 200):
            inside, outside, elsewhere = left_of(name, start, offset, clip("walk.bvh", "rich"))
            assert np.degrees(outside.max()) < 2.0
            assert elsewhere == 0.0  # its image in a neighbouring chain is none
            before.append(np.abs(offset[offset != 0.0]))
            after.append(inside)
    after, before = np.concatenate(after), np.concatenate(before)
    counted = before >= np.radians(0.5)
    # At most one of the eight is left for a person, as the azimuth speaks against it.
    assert np.mean(after[counted] <= 0.2 * before[counted]) > 0.85
    assert after[counted].mean() < 0.16 * before[counted].mean()


def test_a_burst_of_noise_where_both_joints_live():
    noise = SHAPES["noise"]
    inside, outside, elsewhere = left_of("RightForeArm", 200, noise, clip("walk.bvh", "rich"))
    assert np.sqrt(np.mean(inside**2)) < 0.2 * np.sqrt(np.mean(noise**2))
    assert np.degrees(outside.max()) < 2.0
    assert elsewhere == 0.0


def test_what_departs_no_more_than_motion_does_is_left_alone():
    motion = clip("walk.bvh", "rich")
    for name in CHAINS:
        _, outside, elsewhere = left_of(name, 150, SHAPES["drift of a second"], motion)
        assert outside.max() < np.radians(0.5)
        assert elsewhere == 0.0


@parametrize("kind", ["plain", "rich", "30 Hz"])
@parametrize("name", CLIPS)
def test_clips_without_an_error_hold_none(name, kind):
    motion = clip(name, kind)
    assert soft_of(motion) == []
    limit = np.radians(2.0) if kind == "rich" else 0.0  # one jump of 1.6° in the dance made rich
    assert all(np.abs(v).max() <= limit for v in found_in(motion)[1].values())


@pytest.mark.parametrize("kind", ["plain", "rich"])
@parametrize("delta", [4.0, -35.0, 170.0], quick=2)
def test_a_step_is_a_jump_as_ever_exact_and_beside_no_soft_error(kind, delta):
    motion = clip("walk.bvh", kind)
    for name in ("LeftArm", "RightLeg"):
        full, dirty = erring(motion, name, 140, np.full(17, np.radians(delta)))
        (interval,), total = found_in(dirty)
        assert (interval.chain, interval.start, interval.stop) == (name, 140, 157)
        assert "edges" in interval.evidence
        assert soft_of(dirty) == []
        tolerance = 1e-5 if kind == "plain" else np.radians(1.0)
        assert np.abs(wrap(total[name] - full)).max() < tolerance


@pytest.mark.parametrize("kind", ["plain", "rich"])
def test_steps_in_one_chain_and_a_soft_error_in_another_are_each_their_own(kind):
    motion = clip("walk.bvh", kind)
    jump, first = erring(motion, "RightLeg", 80, np.full(9, -THIRTY))
    soft, dirty = erring(first, "LeftArm", 180, SHAPES["ramp of 8"])
    _, total = found_in(dirty)
    for name, full in (("RightLeg", jump), ("LeftArm", soft)):
        assert np.abs(total[name] - full).max() < np.radians(0.1 if kind == "plain" else 2.5)
    assert [s.interval.chain for s in soft_of(dirty)] == ["LeftArm"]


@pytest.mark.thorough
def test_nothing_is_taken_out_twice_and_nothing_is_left_to_find():
    for name, kind in (("LeftArm", "plain"), ("RightForeArm", "rich")):
        motion = clip("walk.bvh", kind)
        chains = find_chains(motion)
        for shape in ("ramp of 8", "staircase", "noise"):
            _, dirty = erring(motion, name, 200, SHAPES[shape])
            intervals, _ = found_in(dirty)
            own = sorted((i.start, i.stop) for i in intervals if i.chain == name)
            assert all(a[1] <= b[0] for a, b in pairwise(own))
            after = refine(dirty, chains, intervals)
            assert soft_of(after) == []
            chain = chain_of(motion, name)
            places, were = (forward_kinematics(m)[1] for m in (after, dirty))
            np.testing.assert_allclose(places, were, atol=1e-9)
            same = [j for j in range(len(motion.skeleton)) if j not in (chain.parent, chain.child)]
            assert geodesic_angle(after.rotations[:, same], dirty.rotations[:, same]).max() < 1e-6


@pytest.mark.parametrize("kind", ["plain", "rich"])
def test_one_is_shown_exactly_if_its_strength_reaches_the_threshold(kind):
    motion = clip("walk.bvh", kind)
    _, dirty = erring(motion, "RightForeArm", 150, SHAPES["ramp of 8"])
    analysis = analyse(dirty).by()
    (standing,) = soft_of(dirty)
    strength = standing.strength
    assert strength == pytest.approx(float(np.abs(standing.interval.offset).max()))
    assert analysis.strength("RightForeArm")[standing.peak] == strength
    assert standing.interval.start <= standing.peak < standing.interval.stop

    def shown(tau):
        return [(i.start, i.stop) for i in analysis.intervals("RightForeArm", tau)]

    frames = [(standing.interval.start, standing.interval.stop)]
    for tau in (np.radians(1.5), 0.5 * strength, strength):
        assert shown(tau) == frames
    assert shown(np.nextafter(strength, 9.0)) == []


def test_a_threshold_brings_back_no_jumps_that_a_soft_error_stands_for():
    _, dirty = erring(clip("walk.bvh"), "RightForeArm", 150, SHAPES["staircase"])
    chain = analyse(dirty).by().chains["RightForeArm"]
    for tau in np.radians([1.5, 5.0, 9.0]):
        inside = [i for i in chain.intervals(tau) if i.start < 180 and i.stop > 150]
        total = np.zeros(dirty.frames)
        for i in inside:
            total[i.start : i.stop] += i.offset
        np.testing.assert_allclose(total[150:177], SHAPES["staircase"], atol=np.radians(0.2))


def test_the_command_says_what_it_follows(tmp_path, capsys):
    _, dirty = erring(clip("walk.bvh"), "RightForeArm", 150, SHAPES["ramp of 8"])
    path = tmp_path / "soft.bvh"
    write_motion(dirty, path)
    assert main(["detect", str(path), "--explain"]) == 0
    assert re.search(r" 9 frames.* 9\b", capsys.readouterr().out)


# Silent joints


def test_a_joint_that_never_twists_is_silent_one_that_rests_is_not():
    turning = np.radians(0.5) * np.sin(np.arange(400) / 9.0)
    never = np.zeros(400)
    np.testing.assert_allclose(
        accumulated_twist_if_silent(never, turning, np.zeros(len(never), dtype=bool)), 0.0
    )
    rests = turning[::-1].copy()
    rests[100:200] = 0.0
    assert accumulated_twist_if_silent(rests, turning, np.zeros(len(rests), dtype=bool)) is None
    halts = turning[::-1].copy()
    halts[::25] = 0.0  # now and then, at its turning points as well
    assert accumulated_twist_if_silent(halts, turning, np.zeros(len(halts), dtype=bool)) is None
    both_rest = turning.copy()
    both_rest[100:300] = 0.0
    assert (
        accumulated_twist_if_silent(both_rest, both_rest, np.zeros(len(both_rest), dtype=bool))
        is None
    )


def test_the_level_of_a_silent_joint_is_that_of_most_frames():
    turning = np.radians(0.5) * np.sin(np.arange(400) / 9.0)
    level = np.zeros(400)
    level[150:240] = THIRTY * np.sin(np.linspace(0.0, np.pi, 90))
    silent = np.diff(level, prepend=0.0)
    np.testing.assert_allclose(
        accumulated_twist_if_silent(silent, turning, np.zeros(len(silent), dtype=bool)),
        level,
        atol=1e-9,
    )
    nowhere = np.zeros(400, dtype=bool)
    ((start, stop),) = silent_joint_error_ranges(level, nowhere)
    assert start <= 150
    assert stop >= 240
    assert silent_joint_error_ranges(0.04 * level, nowhere) == []  # 1.2°: less than is asked for
    cut = nowhere.copy()
    cut[200] = True
    assert silent_joint_error_ranges(level, cut) == [(start, 200), (200, stop)]


def surprise_of(motion, name="LeftArm", cut=None):
    """Of the arms or legs that a chain belongs to, and the rows of its chains by name."""
    lines = [line for line in _lines(find_chains(motion)) if len(line) == 3]
    if all(c.name != name for line in lines for c in line):
        lines = [line for line in _lines(find_chains(motion)) if len(line) == 2]
    rows = {c.name: k * len(lines) + i for i, line in enumerate(lines) for k, c in enumerate(line)}
    nowhere = np.zeros(motion.frames, dtype=bool)
    return Surprise(_limbs(lines, motion), motion.fps, nowhere if cut is None else cut), rows


def test_the_rig_of_the_samples_has_silent_joints_and_made_rich_it_has_none():
    for name in CLIPS:
        surprise, rows = surprise_of(clip(name))
        sides = {n: find_silent_joints(surprise).get(r) for n, r in rows.items()}
        assert {s for n, s in sides.items() if n.endswith("Arm") and "Fore" not in n} == {-1}
        assert {s for n, s in sides.items() if n.endswith("ForeArm")} == {1}
        assert find_silent_joints(surprise_of(clip(name, "rich"))[0]) == {}


@pytest.mark.parametrize(("fill", "least"), [("GH", 8.0), ("GI", 3.0)])
def test_a_joint_held_over_gaps_is_not_the_silent_one(fill, least):
    motion, chains = clip("walk.bvh"), find_chains(clip("walk.bvh"))
    chain = chain_of(motion, "RightArm")
    for seed in (0, 1):
        errors = draw_errors(
            motion, [chain], clip_random_generator(seed, "walk", 6), parse_protocol(fill)
        )
        dirty = inject(motion, chains, errors)
        surprise, rows = surprise_of(dirty)
        assert find_silent_joints(surprise)[rows["RightArm"]] == -1
        _, total = found_in(dirty)
        full = np.zeros(motion.frames)
        for e in errors:
            full[e.start : e.stop] = e.offset
        left, large = np.abs(total["RightArm"] - full), np.abs(full) > np.radians(least)
        if fill == "GH":
            assert np.degrees(left[large]).max() < 0.5
        assert (left < np.abs(full) + np.radians(0.5)).all()


def test_jumps_paired_wrongly_do_not_hide_that_a_joint_is_silent():
    motion, chains = clip("kick.bvh"), find_chains(clip("kick.bvh"))
    chain = chain_of(motion, "RightForeArm")
    errors = draw_errors(motion, [chain], clip_random_generator(0, "kick", 7), parse_protocol("D"))
    dirty = inject(motion, chains, errors)
    full = np.zeros(motion.frames)
    for e in errors:
        full[e.start : e.stop] = e.offset
    _, total = found_in(dirty)
    assert np.degrees(np.abs(total["RightForeArm"] - full).max()) < 0.5


# What is known, and cuts


def test_what_is_known_rightly_stays_and_what_is_known_wrongly_is_replaced():
    motion = clip("walk.bvh")
    full, dirty = erring(motion, "RightForeArm", 150, SHAPES["ramp of 8"])
    surprise, rows = surprise_of(dirty, "RightForeArm")
    row, cut = rows["RightForeArm"], surprise.cut
    known = Known(row, 150, SHAPES["ramp of 8"])
    right = search_soft_errors(surprise.limbs, FPS, cut, [known])
    assert (right.found, right.replaced) == ([], [])
    wrong = Known(row, 150, 0.5 * SHAPES["ramp of 8"])
    searched = search_soft_errors(surprise.limbs, FPS, cut, [wrong])
    (found,) = searched.found
    assert found.row == row
    np.testing.assert_allclose(found.offset, full[found.start : found.stop], atol=np.radians(0.1))
    assert searched.replaced == [wrong]


def test_errors_are_taken_out_exactly_with_their_images():
    motion = clip("walk.bvh", "rich")
    _, dirty = erring(motion, "LeftArm", 100, SHAPES["noise"])
    clean, rows = surprise_of(motion)
    surprise, _ = surprise_of(dirty)
    row = rows["LeftArm"]
    nowhere = np.zeros(surprise.x.shape, dtype=bool)
    for s in (surprise, clean):
        s.measure(nowhere)
    before = [surprise.of(r, 90, 140) for r in surprise.limb(row)]
    surprise.remove_error(row, 100, SHAPES["noise"])
    surprise.update_departures(row, 100, 130)
    np.testing.assert_allclose(surprise.x, clean.x, atol=1e-9)
    np.testing.assert_allclose(surprise.y, clean.y, atol=1e-9)
    assert sum(surprise.of(r, 90, 140) for r in surprise.limb(row)) < sum(before)
    surprise.remove_error(row, 100, -SHAPES["noise"])
    surprise.update_departures(row, 100, 130)
    np.testing.assert_allclose([surprise.of(r, 90, 140) for r in surprise.limb(row)], before)


def cut_together(a, b):
    """Both, one behind the other, as one clip."""
    rotations = np.concatenate([a.rotations, b.rotations])
    positions = np.concatenate([a.positions, b.positions])
    return replace(a, rotations=rotations, positions=positions)


@pytest.mark.parametrize("kind", ["plain", "rich"])
def test_no_cut_is_bridged(kind):
    both = cut_together(clip("walk.bvh", kind).sliced(0, 170), clip("kick.bvh", kind))
    found = analyse(both).by()
    cut = found.cut
    assert np.flatnonzero(cut).tolist() == [0, 170]
    assert soft_in(found) == []
    surprise, _ = surprise_of(both, cut=cut)
    surprise.measure(np.zeros(surprise.x.shape, dtype=bool))
    for a in surprise.at:
        first = a.natural.span.step * np.arange(a.u.shape[-1])
        over = (first < 170) & (first + a.natural.span.support > 170)
        assert not a.usable[over].any()


def test_an_error_before_a_cut_leaves_what_is_behind_alone():
    both = cut_together(clip("walk.bvh").sliced(0, 170), clip("kick.bvh").sliced(0, 90))
    full, dirty = erring(both, "RightForeArm", 120, SHAPES["ramp of 8"])
    assert np.abs(found_in(dirty)[1]["RightForeArm"] - full).max() < np.radians(0.2)


def test_a_clip_too_short_for_any_span_is_left_alone():
    motion = clip("walk.bvh").sliced(0, 20)
    surprise, _ = surprise_of(motion)
    assert surprise.spans == ()
    none = search_soft_errors(surprise.limbs, FPS, surprise.cut, [])
    assert (none.found, none.replaced) == ([], [])
    assert soft_of(motion) == []


def restless_errors(seed):
    """A kick whose joints never rest, and errors that jump or set in softly: frames by chain."""
    rng, motion = np.random.default_rng(seed), read_bvh(ASSETS / "kick.bvh").motion
    q, n, made = motion.rotations.copy(), motion.frames, {}

    def turn(joint, axis, angle):
        q[:, joint] = normalise(multiply(q[:, joint], quaternion_from_axis_angle(axis, angle)))

    for chain in find_chains(motion):
        for joint in (chain.parent, chain.child):
            walk = np.cumsum(np.cumsum(rng.normal(0.0, 0.02, n)))
            walk = np.radians(np.clip(walk - np.convolve(walk, np.ones(61) / 61, "same"), -25, 25))
            turn(joint, chain.axis, np.convolve(walk, np.ones(9) / 9, "same"))
        for _ in range(3):
            start, length = int(rng.integers(20, n - 60)), int(rng.integers(8, 40))
            softly, error = rng.integers(0, 2), np.zeros(n)
            if softly:
                bump = np.sin(np.pi * (np.arange(length) + 0.5) / length) ** 2
                error[start : start + length] = np.radians(rng.uniform(8, 40)) * bump
            else:
                error[start : start + length] = np.radians(rng.uniform(8, 60))
                made.setdefault(chain.name, []).append((start, start + length))
            turn(chain.parent, chain.axis, error)
            for child in motion.skeleton.children[chain.parent]:
                back = quaternion_from_axis_angle(chain.axis, -error)
                q[:, child] = normalise(multiply(back, q[:, child]))
    return made, motion.with_rotations(q)


@parametrize(("seed", "chain"), [(14, "LeftArm"), (2002, "LeftLeg")])
def test_nothing_gives_way_to_a_soft_error_that_is_rejected(seed, chain):
    """All the evidence takes it for motion: the jumps that it would explain stay."""
    made, motion = restless_errors(seed)
    detector = analyse(motion).by()
    assert detector.taken_for_motion(chain, detector.automatic_tau(chain))
    found = detector.intervals(chain, detector.automatic_tau(chain))
    sure = {(i.start, i.stop) for i in automatic_corrections(found)}
    assert set(made[chain]) <= sure
