"""Runs that explain a limb's jumps, beside a plain search of all ways; and flips made of them."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.tiers import parametrize
from tests.twistcore.reviews import flip, flipped
from twistcore.detection import Kind
from twistcore.detection.limb_flips import analyse_limbs
from twistcore.detection.limb_flips.explanation import (
    Run,
    _possible_runs,
    explain_limb_jumps,
    why_unexplained,
)
from twistcore.detection.limb_flips.flips import LimbFlips, _end_turns, _of_limb
from twistcore.detection.limb_flips.jumps import Jump
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import conjugate, multiply, quaternion_from_axis_angle, wrap

DEGREE = math.pi / 180.0
FRAMES = 300
WALK = read_bvh(ASSETS / "walk.bvh").motion.sliced(1, 200)
CHAINS = find_chains(WALK)
LIMBS = find_limbs(WALK, CHAINS)


def jumps_of(seed, many=7):
    """Sharp jumps of every size, some too small to lead, and soft ones."""
    rng = np.random.default_rng(seed)
    jumps, at = [], 20
    for _ in range(many):
        at += int(rng.choice([0, 1, 2, 6, 20, 40]))
        degrees = rng.choice([-1, 1]) * rng.choice([45.0, 90.0, 150.0, 175.0, 180.0])
        degrees += rng.uniform(-4.0, 4.0)
        scale, step = (
            rng.choice([1.0, 12.0, 18.0, 25.0, 40.0]) * DEGREE,
            rng.choice([0, 0, 0.09, 0.3]),
        )
        if rng.random() < 0.25:
            n = int(rng.integers(2, 12))
            turns = tuple(rng.uniform(0.5, 1.5, n) * degrees * DEGREE / n)
            jumps.append(Jump(at, at + n, turns, sharp=False, leads=False))
        else:
            leads = bool(rng.random() < 0.8)
            jumps.append(Jump(at, at + 1, (degrees * DEGREE,), scale, step, leads=leads))
            at += 1
    return sorted(jumps, key=lambda j: (j.start, j.stop))


def limb_of(seed):
    """Angle and height of a limb that is at its own side for most of the time, and capture."""
    rng = np.random.default_rng(seed)
    angle = 0.3 * rng.standard_normal(FRAMES) + rng.uniform(-np.pi, np.pi)
    away = rng.random(FRAMES // 10).repeat(10) < 0.2
    angle[away] += rng.uniform(1.0, 3.0)
    return wrap(angle), rng.uniform(0.0, 0.2, FRAMES), rng.random(FRAMES) < 0.9


def plain_log(angle, weight):
    """Logarithm of the density of angles, by bins of 5 degrees, blurred by 25."""

    def bin_of(a):
        return min(int((float(wrap(a)) + math.pi) / (2.0 * math.pi) * 72), 71)

    count = [0.0] * 72
    for a, w in zip(angle, weight, strict=True):
        count[bin_of(np.array(a))] += w
    smooth = []
    for b in range(72):
        apart = [min((b - c) % 72, (c - b) % 72) * 5.0 for c in range(72)]
        smooth.append(
            sum(n * math.exp(-0.5 * (d / 25.0) ** 2) for n, d in zip(count, apart, strict=True))
        )
    every = sum(smooth)
    share = [s / every if every > 0.0 else 1.0 / 72 for s in smooth]
    return lambda a: math.log(0.9 * share[bin_of(a)] + 0.1 / 72)


def plain_price_left(jump):
    if not jump.leads:
        return 0.0
    turn = abs(sum(jump.turns))
    strange = min(max((turn / jump.scale - 4.0) / 4.0, 0.0), 1.0)
    still = min(max(2.0 - jump.step / 0.06, 0.4), 1.0)
    return 6.0 * min(1.0, turn / (120.0 * DEGREE)) * strange * still


def plain_runs(jumps, angle, height, capture, fps, known):
    """All runs between two jumps by the places of these, with their prices."""
    own = capture.copy()
    for run in known:
        own[run["start"] : run["stop"]] = False
    weight = np.minimum(height / 0.1, 1.0)
    log = plain_log(angle[own], weight[own])
    out = []
    for last in range(len(jumps)):
        for first in range(last):
            a, b = jumps[first], jumps[last]
            inside = [j for j in jumps[first + 1 : last] if j.leads]
            apart = b.start - a.stop
            farthest = any(b.start - j.stop > 3.0 * fps for j in jumps[first:last])
            if farthest or len(inside) > 4 or not (a.leads or b.leads) or apart < 0:
                continue
            if not (a.sharp and b.sharp) and apart > 0.25 * fps:
                continue
            if any(j.start < a.stop or j.stop > b.start for j in inside):
                continue
            turns = {}
            for j in (a, b, *inside):
                turns |= dict(zip(range(j.start, j.stop), j.turns, strict=True))
            frames = range(a.start, b.stop - 1)
            residual = float(wrap(np.array(sum(turns.values()))))
            if abs(residual) >= 110.0 * DEGREE:
                continue
            offset, level, side = [], 0.0, 0.0
            for n, t in enumerate(frames):
                level += turns.get(t, 0.0)
                offset.append(level - residual * (n + 1) / (len(frames) + 1))
                here = log(np.array(angle[t] - offset[-1])) - log(np.array(angle[t]))
                side += here * weight[t] / (0.08 * fps)
            side = min(side, 6.0)
            price = 1.0 + 2.5 * len(inside) + 4.0 * len(frames) / fps - side
            price += abs(residual) / (80.0 * DEGREE) + 0.6 * min(1.0, abs(residual) / (15 * DEGREE))
            price += 0.8 * ((not a.sharp) + (not b.sharp))
            out.append(
                {"first": first, "last": last, "start": a.start, "stop": b.stop - 1, "side": side,
                 "offset": offset, "residual": residual, "price": price, "inside": inside}
            )  # fmt: skip
    return out


def cheapest(jumps, runs):
    """The least cost of explaining all jumps and the runs that it takes, by trying all ways."""

    @cache
    def behind(k):
        if k == len(jumps):
            return 0.0, ()
        cost, rest = behind(k + 1)
        ways = [(cost + plain_price_left(jumps[k]), rest)]
        for n, run in enumerate(runs):
            if run["first"] == k:
                cost, rest = behind(run["last"] + 1)
                ways.append((cost + run["price"], (n, *rest)))
        return min(ways)

    return behind(0)


def one_finding(a, b):
    shared = min(a["stop"], b["stop"]) - max(a["start"], b["start"])
    return shared >= 0.5 * (max(a["stop"], b["stop"]) - min(a["start"], b["start"]))


def plain_explain(jumps, angle, height, capture, fps):
    found = []
    for _ in range(3):
        runs = plain_runs(jumps, angle, height, capture, fps, found)
        least, taken = cheapest(jumps, runs)
        found = []
        for n in taken:
            others = [r for r in runs if not one_finding(r, runs[n])]
            found.append({**runs[n], "odds": cheapest(jumps, others)[0] - least})
    return found


@pytest.mark.parametrize("fps", [30.0, 120.0])
@parametrize("seed", range(16), quick=8)
def test_the_cheapest_explanation_is_that_of_all_ways(seed, fps):
    jumps, (angle, height, capture) = jumps_of(seed, 6 + 2 * (seed % 4)), limb_of(seed)
    found = explain_limb_jumps(jumps, angle, height, capture, fps)
    wanted = plain_explain(jumps, angle, height, capture, fps)
    assert [(r.start, r.stop) for r in found] == [(w["start"], w["stop"]) for w in wanted]
    for run, plain in zip(found, wanted, strict=True):
        assert (run.first, run.last) == (jumps[plain["first"]], jumps[plain["last"]])
        assert list(run.followed) == plain["inside"]
        np.testing.assert_allclose(run.offset, plain["offset"], atol=1e-9)
        for name in ("residual", "side", "odds"):
            assert getattr(run, name) == pytest.approx(plain[name], abs=1e-7)
    runs = plain_runs(jumps, angle, height, capture, fps, wanted)
    for k, jump in enumerate(jumps):
        why = why_unexplained(jumps, jump, found, angle, height, capture, fps)
        assert why.cost == pytest.approx(plain_price_left(jump))
        spared = {}
        for n, run in enumerate(runs):
            if k in (run["first"], run["last"]):
                edges = jumps[run["first"]], jumps[run["last"]], *run["inside"]
                spared[n] = sum(map(plain_price_left, edges))
        if not spared:
            assert (why.run, why.price, why.spared) == (None, math.inf, 0.0)
            continue
        best = min(spared, key=lambda n: runs[n]["price"] - spared[n])
        assert (why.run.start, why.run.stop) == (runs[best]["start"], runs[best]["stop"])
        assert (why.run.residual, why.run.odds) == (pytest.approx(runs[best]["residual"]), 0.0)
        assert why.price == pytest.approx(runs[best]["price"])
        assert why.spared == pytest.approx(spared[best])


def test_partners_alone_explain_nothing():
    quiet = [Jump(20, 21, (3.0,), 0.01, leads=False), Jump(30, 31, (-3.0,), 0.01, leads=False)]
    nothing, everywhere = np.zeros(FRAMES), np.ones(FRAMES, dtype=bool)
    assert explain_limb_jumps(quiet, nothing, nothing, everywhere, 120.0) == []
    assert explain_limb_jumps([], nothing, nothing, everywhere, 120.0) == []


def test_a_run_follows_four_jumps_inside_at_most():
    jumps = [Jump(20 + 2 * n, 21 + 2 * n, ((-1) ** n * 1.5,), 0.01) for n in range(9)]
    nothing, everywhere = np.zeros(FRAMES), np.ones(FRAMES, dtype=bool)
    arcs = _possible_runs(jumps, 120.0)
    followed = {len(a.run.followed) for a in arcs if a.run}
    assert followed == {0, 1, 2, 3, 4}
    assert len(explain_limb_jumps(jumps, nothing, nothing, everywhere, 120.0)) > 0


# Flips


class FlipsOfDegree(LimbFlips):
    """Flips of a limb that departs by a degree by nature, and whose end does not jump."""

    def scale_at(self, frames):
        return np.full(len(frames), DEGREE)

    def steps_at(self, frames):
        return np.zeros(len(frames))


def flips_of(departures, name="Left leg"):
    """Flips of a limb of the walk with other departures, degrees by frame."""
    limb = next(n for n in LIMBS if n.label == name)
    found = analyse_limbs(WALK, [limb]).limbs[limb.name]
    own = np.zeros(WALK.frames)
    for t, degrees in departures.items():
        own[t] = degrees * DEGREE
    return FlipsOfDegree(limb, found.fps, found.swivel, own, found.capture, found.noisy, ())


def plain_end(limb, start, offset, along):
    """How far E turns in the room at both edges of a flip, radians."""
    turned, at = forward_kinematics(WALK)
    line = at[:, limb.end] - at[:, limb.parent]
    total = 0.0
    stop = start + len(offset)
    for inside, outside, level in ((start, start - 1, offset[0]), (stop - 1, stop, offset[-1])):
        if 0 <= outside < WALK.frames:
            q = turned[inside, limb.end]
            if along:
                axis = line[inside] / np.linalg.norm(line[inside])
                q = multiply(quaternion_from_axis_angle(axis, -level), q)
            total += 2.0 * math.acos(min(1.0, abs(float(q @ turned[outside, limb.end]))))
    return total


@pytest.mark.parametrize(("start", "frames"), [(0, 5), (1, 4), (60, 3), (80, 1), (194, 5)])
def test_an_end_turned_along_if_it_jumps_less_once_turned_back(start, frames):
    flips = flips_of({})
    rng = np.random.default_rng(start)
    for _ in range(12):
        offset = rng.uniform(-0.12, 0.12, frames)
        wanted = plain_end(flips.limb, start, offset, along=True)
        as_is = plain_end(flips.limb, start, offset, along=False)
        for along, turned in ((True, wanted), (False, as_is)):
            found = _end_turns(flips.swivel, start, offset, along=along)
            assert found == pytest.approx(turned, abs=1e-6)
        if abs(wanted - as_is) > 1e-5:
            assert flips.end_carried(start, offset) == (wanted < as_is)


def test_a_flip_says_what_it_was_found_by():
    flips = flips_of({60: 170.0, 72: -150.0, 73: 35.0})
    (flip,) = flips.intervals(50.0 * DEGREE)
    assert (flip.chain, flip.kind, flip.start, flip.stop) == (
        flips.limb.name,
        Kind.LIMB_FLIP,
        60,
        72,
    )
    assert (flip.open, flip.residual) == (True, pytest.approx(20.0 * DEGREE))  # nothing is flipped
    told = flip.evidence
    assert told["edges"] == [
        {"start": t, "stop": t + 1, "jump_deg": pytest.approx(d), "sigma_deg": pytest.approx(1.0),
         "sharp": True}
        for t, d in ((60, 170.0), (72, -150.0))
    ]  # fmt: skip
    assert told["closing_residual_deg"] == pytest.approx(20.0)
    path = {f"path{what}{when}" for what in ("", "_roughness") for when in ("", "_corrected")}
    assert set(told) == {"edges", "closing_residual_deg", "side", "odds", "doubts", *path}
    (run,) = explain_limb_jumps(
        flips.jumps(50.0 * DEGREE),
        flips.swivel.angle,
        flips.swivel.height,
        flips.capture,
        flips.fps,
    )
    assert (told["side"], told["odds"]) == (run.side, run.odds)
    assert flip.confidence == pytest.approx(1.0 / (1.0 + math.exp(-run.odds)))
    assert flip.carried == flips.end_carried(60, flip.offset)
    assert flips.intervals(50.0 * DEGREE) is flips.intervals(60.0 * DEGREE)  # the same jumps lead
    assert flips.intervals(175.0 * DEGREE) == ()


def test_a_limb_tells_why_a_jump_is_left():
    flips = flips_of({60: 170.0, 72: -150.0, 110: 100.0})
    jumps = flips.jumps(50.0 * DEGREE)
    s = flips.swivel
    runs = explain_limb_jumps(jumps, s.angle, s.height, flips.capture, flips.fps)
    for jump in jumps:
        found = flips.why_unexplained(jumps, jump)
        wanted = why_unexplained(jumps, jump, runs, s.angle, s.height, flips.capture, flips.fps)
        assert (found.cost, found.price, found.spared) == (
            wanted.cost,
            wanted.price,
            wanted.spared,
        )


@pytest.mark.parametrize(("odds", "opened"), [(1.49, True), (1.5, False), (80.0, False)])
def test_a_flip_is_sure_from_odds_of_one_and_a_half(odds, opened, monkeypatch):
    monkeypatch.setattr("twistcore.detection.limb_flips.flips.LimbFlips.doubts", lambda *_: [])
    jump = Jump(60, 61, (3.0,), 0.01)
    run = Run(60, np.array([3.0, 3.0]), jump, jump, (jump,), 0.0, 0.0, odds)
    flip = flips_of({})._interval(run)
    assert flip.open == opened
    assert flip.confidence == pytest.approx(1.0 / (1.0 + math.exp(-min(odds, 50.0))), abs=1e-12)
    assert len(flip.evidence["edges"]) == 3


def test_a_flip_that_makes_the_path_of_the_knee_longer_is_left_to_a_person():
    """However sure the jumps are: nothing of the walk is flipped."""
    jump = Jump(60, 61, (3.0,), 0.01)
    run = Run(60, np.array([3.0, 3.0]), jump, jump, (jump,), 0.0, 0.0, 80.0)
    made_up = flips_of({})._interval(run)
    assert made_up.open
    assert made_up.evidence["path_corrected"] > made_up.evidence["path"]
    assert made_up.evidence["doubts"] == ["the knee would travel a longer path"]
    limb = "LeftUpLeg-LeftFoot"
    motion = flipped(WALK, flip(limb, 60, 72, 150.0))
    (real,) = analyse_limbs(motion, LIMBS).intervals(limb, 50.0 * DEGREE)
    assert not real.open
    assert real.evidence["doubts"] == []
    assert real.evidence["path_corrected"] < real.evidence["path"]


def test_a_flip_that_ends_over_two_frames_is_found():
    """The thigh rolls back first, half of that with the shin; then the knee comes back."""
    limb, start, stop = "LeftUpLeg-LeftFoot", 60, 72
    motion = flipped(WALK, flip(limb, start, stop, 179.0))
    by_name = {c.name: c for c in CHAINS}
    upper, lower = (by_name[name].axis for name in ("LeftUpLeg", "LeftLeg"))
    thigh, shin = (WALK.skeleton.index(name) for name in ("LeftUpLeg", "LeftLeg"))
    rotations, t = motion.rotations.copy(), stop - 1
    whole = quaternion_from_axis_angle(upper, np.radians(179.0))
    half = quaternion_from_axis_angle(lower, np.radians(90.0))
    rotations[t, thigh] = multiply(rotations[t, thigh], whole)
    rotations[t, shin] = multiply(multiply(conjugate(whole), rotations[t, shin]), half)
    split = motion.with_rotations(rotations)
    found = analyse_limbs(split, LIMBS).intervals(limb, 50.0 * DEGREE)
    assert [(i.start, i.stop) for i in found] == [(start, stop)]


def test_departures_without_an_offset_are_those_of_the_turns_that_are_left():
    flips = flips_of({})
    offset = np.zeros(WALK.frames)
    offset[60:72] = 2.0
    turned = flips.departures_without(offset) - flips.departures_without(np.zeros(WALK.frames))
    at = np.flatnonzero(np.abs(turned) > 1e-9)
    assert turned[60] == pytest.approx(-2.0, abs=0.1)
    assert turned[72] == pytest.approx(2.0, abs=0.1)
    assert at.min() >= 56
    assert at.max() <= 76
    plain = analyse_limbs(WALK, [flips.limb]).limbs[flips.limb.name]
    np.testing.assert_allclose(
        flips.departures_without(np.full(WALK.frames, 1.0)), plain.departures, atol=1e-12
    )


@pytest.mark.parametrize("many", [2, 3])
@pytest.mark.parametrize("jumping", [1, 2, 3])
def test_where_more_than_half_of_several_limbs_jump_the_pose_does(many, jumping):
    limbs = LIMBS[:many]
    q = WALK.rotations.copy()
    for limb in limbs[:jumping]:
        along = np.array(limb.axis)
        q[90:, limb.parent] = multiply(
            q[90:, limb.parent], quaternion_from_axis_angle(along, np.full(len(q) - 90, 2.5))
        )
    told = []
    found = analyse_limbs(WALK.with_rotations(q), limbs, told.append)
    assert told == [k / many for k in range(many)]
    pose = many == 3 and jumping > 1
    for limb in limbs:
        own = found.limbs[limb.name]
        assert own.capture[90] != pose
        assert (found.strength(limb.name) == np.abs(own.departures)).all()
        assert found.automatic_tau(limb.name) == pytest.approx(55.0 * DEGREE)
        if pose:
            assert own.departures[90] == 0.0
    assert found.strength(limbs[0].name)[90] > 1.0 or pose


def test_no_soft_jump_leads_across_a_border():
    flips = flips_of({})
    turns = np.zeros(WALK.frames)
    turns[60:68] = 15.0 * DEGREE
    swivel = replace(flips.swivel, jump=turns)
    border = np.zeros(WALK.frames, dtype=bool)
    border[0] = True
    found = _of_limb(flips.limb, swivel, border, border, 120.0)
    assert [(j.start, j.stop) for j in found.soft] == [(60, 68)]
    border[64] = True
    assert _of_limb(flips.limb, swivel, border, border, 120.0).soft == ()


def test_steps_are_how_far_an_end_moves_beyond_what_it_does_around():
    flips = analyse_limbs(WALK, LIMBS[:1]).limbs[LIMBS[0].name]
    step = flips.swivel.step
    for t in range(WALK.frames):
        near = [step[i] for i in range(t - 4, t + 5) if i != t and 0 < i < len(step)]
        assert flips.steps_at(np.array([t]))[0] == pytest.approx(
            max(step[t] - np.median(near), 0.0), abs=1e-12
        )
