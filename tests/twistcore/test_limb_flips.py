"""Flips of limbs: found in a real clip and where they were put, and nothing else taken for one."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.correction.twist_removal import refine, remove_twist
from twistcore.detection import Interval, Kind
from twistcore.detection.limb_flips import analyse_limbs, flips
from twistcore.detection.limb_flips.explanation import explain_limb_jumps
from twistcore.detection.limb_flips.flips import SURE
from twistcore.detection.limb_flips.jumps import Jump
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs, limb_middle_and_end_positions
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import (
    conjugate,
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    rotate,
)

KICK = read_bvh(ASSETS / "kick.bvh")
WALK = read_bvh(ASSETS / "walk.bvh")
CLEAN = ("walk", "dance", "basketball", "walk_injected")


def limbs_of(motion):
    chains = find_chains(motion)
    return chains, {limb.label: limb for limb in find_limbs(motion, chains)}


def found(motion, label, among=None):
    limbs = limbs_of(motion)[1]
    analysis = analyse_limbs(motion, among or list(limbs.values()))
    name = limbs[label].name
    return analysis.intervals(name, analysis.automatic_tau(name))


def flipped(motion, label, *runs):
    """The motion with flips (start, stop, degrees, carried) of a limb."""
    chains, limbs = limbs_of(motion)
    intervals = [
        Interval(
            limbs[label].name,
            a,
            b,
            np.full(b - a, -np.radians(d)),
            kind=Kind.LIMB_FLIP,
            carried=along,
        )
        for a, b, d, along in runs
    ]
    return refine(motion, (*chains, *limbs.values()), intervals)


def test_the_flips_of_a_real_kick():
    intervals = found(KICK.motion, "Right leg")
    frames = [(i.start, i.stop) for i in intervals]
    assert frames == [(14, 31), (34, 37), (38, 42), (45, 52), (73, 76), (174, 177)]
    assert all(i.kind == Kind.LIMB_FLIP and not i.open for i in intervals)
    assert all(140.0 < abs(np.degrees(i.delta)) <= 180.0 for i in intervals)
    assert all(i.confidence > 0.9 for i in intervals)
    for label in ("Left leg", "Left arm", "Right arm"):
        assert found(KICK.motion, label) == ()


@pytest.mark.parametrize("name", CLEAN)
def test_clips_without_a_flip_have_none(name):
    motion = read_bvh(ASSETS / f"{name}.bvh").motion
    assert [i for label in limbs_of(motion)[1] for i in found(motion, label)] == []


def test_a_repair_moves_the_knee_and_nothing_else(tmp_path):
    chains, limbs = limbs_of(KICK.motion)
    leg = limbs["Right leg"]
    intervals = found(KICK.motion, "Right leg")
    refined = refine(KICK.motion, (*chains, leg), intervals)
    write_clip(KICK, refined, tmp_path / "kick.bvh")
    written = read_bvh(tmp_path / "kick.bvh").motion
    turned = (geodesic_angle(KICK.motion.rotations, refined.rotations) > 1e-9).any(axis=0)
    assert set(np.flatnonzero(turned)) == {leg.parent, leg.end}
    before, after = (forward_kinematics(m)[1] for m in (KICK.motion, refined))
    way = np.linalg.norm(after - before, axis=2)
    below_end = {leg.end + 1}  # toes follow a foot that carried along
    assert set(np.flatnonzero(way.max(axis=0) > 1e-9)) == {leg.child, *below_end}
    assert way[:, leg.child].max() > 0.05 * KICK.motion.skeleton.height
    moved = np.linalg.norm(forward_kinematics(written)[1] - before, axis=2)[:, leg.end]
    assert moved.max() < 1e-4 * KICK.motion.skeleton.height
    again = found(written, "Right leg")
    assert again == ()


def test_the_knee_stands_still_about_the_line_once_repaired():
    chains, limbs = limbs_of(KICK.motion)
    leg = limbs["Right leg"]
    refined = refine(KICK.motion, (*chains, leg), found(KICK.motion, "Right leg"))
    jumps = [np.abs(analyse_limbs(m, [leg]).limbs[leg.name].swivel.jump).max() for m in (
        KICK.motion.sliced(2, 246), refined.sliced(2, 246))]  # fmt: skip
    assert jumps[0] > np.radians(170.0)
    assert jumps[1] < np.radians(40.0)


@pytest.mark.parametrize("label", ["Left arm", "Right arm", "Left leg", "Right leg"])
def test_what_was_put_in_is_found_to_the_frame(label):
    runs = ((40, 41, 75.0, False), (80, 97, -120.0, True), (150, 158, 180.0, False))
    runs += ((250, 270, 62.0, True),)
    intervals = found(flipped(WALK.motion, label, *runs), label)
    assert [(i.start, i.stop, i.carried) for i in intervals] == [(a, b, c) for a, b, _, c in runs]
    for interval, (_, _, degrees, _) in zip(intervals, runs, strict=True):
        off = (np.degrees(interval.offset) - degrees + 180.0) % 360.0 - 180.0
        assert np.abs(off).max() < 6.0


def test_a_flip_of_a_straight_leg_is_seen_in_the_rotations_alone():
    leg = limbs_of(WALK.motion)[1]["Left leg"]
    rotations = WALK.motion.rotations.copy()
    rotations[:, leg.child] = (1.0, 0.0, 0.0, 0.0)
    straight = WALK.motion.with_rotations(rotations)
    to_knee, to_ankle = limb_middle_and_end_positions(straight, leg)
    aside = np.linalg.norm(np.cross(to_knee, to_ankle), axis=1)
    assert (aside / np.linalg.norm(to_ankle, axis=1) ** 2).max() < 0.02
    intervals = found(flipped(straight, "Left leg", (60, 75, 150.0, False)), "Left leg")
    assert [(i.start, i.stop) for i in intervals] == [(60, 75)]


def test_a_twist_that_the_child_takes_back_is_no_flip():
    chains, limbs = limbs_of(WALK.motion)
    for chain in chains:
        offset = np.zeros(WALK.motion.frames)
        offset[100:115] = np.radians(150.0)
        twisted = remove_twist(WALK.motion, chains, {chain.name: offset})
        assert [i for label in limbs for i in found(twisted, label)] == []


def test_bones_that_spin_while_the_knee_stays_are_no_flip():
    """Thigh and shank turn by half about themselves; the leg bends the other way, to no effect."""
    chains, _ = limbs_of(WALK.motion)
    offsets = {name: np.zeros(WALK.motion.frames) for name in ("RightUpLeg", "RightLeg")}
    for offset in offsets.values():
        offset[200:203] = np.pi
    assert found(remove_twist(WALK.motion, chains, offsets), "Right leg") == ()


def test_a_pose_that_pops_is_no_flip_of_four_limbs():
    motion = WALK.motion
    for label in limbs_of(motion)[1]:
        motion = flipped(motion, label, (120, 124, 150.0, True))
    assert [i for label in limbs_of(motion)[1] for i in found(motion, label)] == []
    two = flipped(WALK.motion, "Left leg", (120, 124, 150.0, True))
    two = flipped(two, "Right leg", (120, 124, 150.0, True))
    assert all(len(found(two, label)) == 1 for label in ("Left leg", "Right leg"))


def test_a_jump_without_a_way_back_is_left():
    assert found(flipped(WALK.motion, "Left leg", (200, 344, 150.0, True)), "Left leg") == ()


def test_a_longer_spell_on_the_other_side_is_the_error():
    """A knee that stands backward for a second is wrong, however long: the clip knows its side."""
    intervals = found(flipped(KICK.motion, "Left leg", (60, 150, 180.0, False)), "Left leg")
    assert [(i.start, i.stop) for i in intervals] == [(60, 150)]


def test_a_lower_threshold_finds_more_and_a_higher_less():
    motion = flipped(WALK.motion, "Left leg", (50, 60, 100.0, True), (150, 160, 45.0, True))
    limb = limbs_of(motion)[1]["Left leg"]
    analysis = analyse_limbs(motion, [limb])
    assert np.abs(np.degrees(analysis.strength(limb.name)[50]) - 100.0) < 6.0
    starts = [
        [i.start for i in analysis.intervals(limb.name, np.radians(tau))] for tau in (30, 55, 120)
    ]
    assert starts == [[50, 150], [50], []]


@pytest.mark.parametrize("angle", [1.1, 2.6])
def test_wherever_the_body_faces_and_whatever_the_rigs_axes(angle):
    """Turned in the room, and with the thigh's own frame turned in its bone: the same flips."""
    motion = flipped(WALK.motion, "Left leg", (50, 60, 170.0, False))
    leg = limbs_of(motion)[1]["Left leg"]
    turn = quaternion_from_axis_angle(np.array([0.6, 0.0, 0.8]), angle)
    rotations, offsets = motion.rotations.copy(), motion.skeleton.offsets.copy()
    rotations[:, 0] = multiply(turn, rotations[:, 0])
    rotations[:, leg.parent] = multiply(rotations[:, leg.parent], turn)
    rotations[:, leg.child] = multiply(conjugate(turn), rotations[:, leg.child])
    offsets[leg.child] = rotate(conjugate(turn), offsets[leg.child])
    turned = replace(motion.with_rotations(rotations), skeleton=replace(
        motion.skeleton, offsets=offsets))  # fmt: skip
    assert [(i.start, i.stop, i.carried) for i in found(turned, "Left leg")] == [(50, 60, False)]


def edge(frame, degrees, scale=1.0, step=0.0):
    return Jump(frame, frame + 1, (np.radians(degrees),), np.radians(scale), step)


def ramp(start, stop, degrees):
    turns = (np.radians(degrees) / (stop - start),) * (stop - start)
    return Jump(start, stop, turns, sharp=False, leads=False)


def runs_of(*jumps, height=0.2):
    """Frames of the runs that explain jumps of a limb that else stands at its own side."""
    frames = 600
    found = explain_limb_jumps(
        jumps, np.zeros(frames), np.full(frames, height), np.ones(frames, dtype=bool), 120.0
    )
    return [(r.start, r.stop) for r in found]


def test_what_a_limb_does_by_nature_is_left():
    assert runs_of(edge(100, 70.0), edge(104, -70.0), height=0.0) == [(100, 104)]
    assert runs_of(edge(100, 70.0, 18.0), edge(104, -70.0, 18.0), height=0.0) == []


def test_a_flip_may_come_softly_and_go_at_once():
    assert runs_of(ramp(92, 100, 110.0), edge(104, -175.0), height=0.0) == [(92, 104)]
    # Not from afar, and not both ends so.
    assert runs_of(ramp(92, 100, 110.0), edge(160, -175.0), height=0.0) == []
    assert runs_of(ramp(92, 100, 110.0), ramp(110, 118, -110.0), height=0.0) == []


def test_two_jumps_the_same_way_are_a_flip_only_if_they_make_a_turn():
    assert runs_of(edge(100, 170.0), edge(110, 150.0), height=0.0) == [(100, 110)]
    assert runs_of(edge(100, 130.0), edge(110, 90.0), height=0.0) == []


def test_a_jump_in_which_the_end_jumps_too_need_not_be_one_of_a_flip():
    """Between two readings: one alone and a pair that closes, or all three in one run."""
    plain = edge(100, -95.0), edge(108, 178.0), edge(126, -179.0)
    assert runs_of(*plain, height=0.0)[0][0] == 100
    moved = edge(100, -95.0, step=0.13), *plain[1:]
    assert runs_of(*moved, height=0.0) == [(108, 126)]


def test_a_flip_that_is_not_sure_is_shown_and_not_applied(monkeypatch):
    """A jump of an arm that is unrest itself, there and back by as much: it may be either."""
    motion, limb = WALK.motion, limbs_of(WALK.motion)[1]["Left arm"]
    analysis = analyse_limbs(motion, [limb]).limbs[limb.name]
    unsure = []
    for scale in (1.0, 15.5):
        departures = np.zeros(motion.frames)
        departures[[100, 101]] = np.radians([80.0, -75.0])
        monkeypatch.setattr(
            flips, "natural_departure_scale", lambda *a, s=scale: np.full(len(a[3]), np.radians(s))
        )
        (flip,) = replace(analysis, departures=departures).intervals(1.0)
        unsure.append((flip.start, flip.stop, flip.evidence["odds"] < SURE, flip.open))
    # The jumps are none of the limb's: taken out, they make the elbow's path longer.
    assert unsure == [(100, 101, False, True), (100, 101, True, True)]


def test_of_two_partners_the_one_that_closes_is_taken():
    frames = 400
    jumps = [edge(100, 170.0), edge(110, -169.0), edge(130, -60.0)]
    nothing = np.zeros(frames)
    level = np.full(frames, 0.2)
    runs = explain_limb_jumps(jumps, nothing, level, np.ones(frames, dtype=bool), 120.0)
    assert [(r.start, r.stop) for r in runs] == [(100, 110)]
    assert np.degrees(runs[0].residual) == pytest.approx(1.0)
    assert runs[0].odds > 3.0


def test_the_clips_own_side_decides_between_two_spells():
    """Three jumps of half a turn: the middle ones are an error on one side, right on the other."""
    frames = 400
    jumps = [edge(t, 180.0) for t in (100, 120, 140)]
    everywhere = np.ones(frames, dtype=bool)
    for wrong in ((100, 120), (120, 140)):
        angle = np.zeros(frames)
        angle[slice(*wrong)] = np.pi - 0.1
        runs = explain_limb_jumps(jumps, angle, np.full(frames, 0.2), everywhere, 120.0)
        assert [(r.start, r.stop) for r in runs] == [wrong]
