"""A limb that straightens hides how its twist is shared: what the detector makes of that."""

from itertools import pairwise

import numpy as np
import pytest

from benchmarks.mirrored_turns import Straightness
from benchmarks.real_flips import judge
from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine, remove_twist
from twistcore.cli import main
from twistcore.detection.straight_limbs.straight_spells import BENT, limb_bend_per_frame
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle, wrap

WALK = read_bvh(ASSETS / "walk.bvh").motion
NAMES = ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase")
OTHERS = ("Spine", "Spine1", "Spine2", "Neck", "Head")  # so that two joints are no whole figure
HIP, KNEE = 1, 2
X, Y = np.eye(3)[:2]
SECONDS, PERIOD = 6.0, 2.0
FORTY = np.radians(40.0)


def straightening(fps=120.0, least=6.0, begins=0.0):
    """A leg whose knee bends by `least` to 70 degrees and back every two seconds."""
    skeleton = Skeleton(
        NAMES + OTHERS,
        np.array([-1, 0, 1, 2, 3, 0, 5, 6, 7, 8]),
        np.array(
            [[0, 9, 0], [1, 0, 0], [0, -4, 0], [0, -4, 0], [0, -0.5, 1.5], *[[0, 1, 0]] * 5],
            dtype=float,
        ),
        ((4, (0.0, 0.0, 0.5)),),
    )
    t = begins + np.arange(0.0, SECONDS, 1.0 / fps)
    knee = np.radians(least + (70.0 - least) * np.cos(np.pi * t / PERIOD) ** 2)
    q = np.zeros((len(t), len(skeleton), 4))
    q[..., 0] = 1.0
    swing = quaternion_from_axis_angle(X, -0.4 - 0.3 * np.sin(2.0 * t))
    q[:, HIP] = multiply(swing, quaternion_from_axis_angle(Y, 0.2 * np.sin(1.3 * t)))
    pronated = quaternion_from_axis_angle(Y, 0.05 * np.sin(1.7 * t))
    q[:, KNEE] = multiply(quaternion_from_axis_angle(X, knee), pronated)
    for joint in (3, *range(5, 10)):
        sway = 0.3 * np.sin((1.0 + 0.3 * joint) * t + joint)
        q[:, joint] = quaternion_from_axis_angle(X, sway)
    return Motion(skeleton, q, (), np.zeros((len(t), 0, 3)), 1.0 / fps)


def thigh(motion, name="LeftUpLeg"):
    return next(c for c in find_chains(motion) if c.name == name)


def bend(motion, name="LeftUpLeg"):
    """Bend of a limb in every frame."""
    chain = thigh(motion, name)
    return limb_bend_per_frame(
        motion.rotations[:, chain.child], chain.axis, chain.arm, motion.fps
    ).angle


def bent(motion):
    return bend(motion) > BENT


def spells(motion, limit=18.0, name="LeftUpLeg"):
    """Frames [start, stop) in which a limb is straight."""
    angle = bend(motion, name)
    ends = np.flatnonzero(np.diff(np.r_[False, angle < np.radians(limit), False]))
    return list(zip(ends[::2].tolist(), ends[1::2].tolist(), strict=True))


def level(motion, frames, delta=FORTY, seconds=0.08):
    """δ over some frames, which sets in and ends softly but at the clip's ends; (frames,)."""
    start, stop = frames
    ramp = round(seconds * motion.fps)
    rise = np.arange(1, ramp + 1) / (ramp + 1)
    offset = np.zeros(motion.frames)
    offset[start:stop] = delta
    if start > 0:
        offset[start : start + ramp] *= rise
    if stop < motion.frames:
        offset[stop - ramp : stop] *= rise[::-1]
    return offset


def erring(motion, offset):
    return remove_twist(motion, [thigh(motion)], {"LeftUpLeg": -offset})


def taken_out(motion, name="LeftUpLeg"):
    """What is corrected unasked of a limb, radians, (frames,)."""
    total = np.zeros(motion.frames)
    for i in automatic_corrections(analyse(motion).detect(kinds="counter-twist")):
        if i.chain == name:
            total[i.start : i.stop] += i.offset
    return total


def repaired(offset, motion, name="LeftUpLeg"):
    """Share of the error frames of which 80 % is taken out."""
    wrong = np.abs(offset) > 1e-9
    left = np.abs(wrap(taken_out(motion, name) - offset))[wrong]
    return np.mean(left <= 0.2 * np.abs(offset[wrong]))


@parametrize("fps", [30.0, 60.0, 120.0], quick=2)
@parametrize("delta", [-50.0, -20.0, 20.0, 50.0], quick=2)
def test_an_error_of_every_straight_spell_is_taken_out_and_nothing_else(fps, delta):
    clean = straightening(fps)
    offset = sum(level(clean, s, np.radians(delta)) for s in spells(clean))
    motion = erring(clean, offset)
    assert repaired(offset, motion) >= 0.97
    assert not taken_out(motion)[bent(motion)].any()
    assert np.abs(taken_out(motion)[offset == 0.0]).max() < np.radians(2.0)


def test_the_shorter_spell_is_not_the_error_if_it_is_the_bent_one():
    clean = straightening(least=2.0)
    t = clean.times
    long = np.radians(4.0 + 70.0 * np.clip(2.5 * np.cos(np.pi * t / PERIOD) ** 2 - 1.5, 0.0, 1.0))
    q = clean.rotations.copy()
    q[:, KNEE] = quaternion_from_axis_angle(X, long)
    clean = clean.with_rotations(q)
    frames = spells(clean)
    between = [(a[1], b[0]) for a, b in pairwise(frames)]
    inner = frames[1:-1] or frames
    assert max(b - a for a, b in between) < min(b - a for a, b in inner)
    offset = sum(level(clean, s) for s in frames)
    motion = erring(clean, offset)
    assert repaired(offset, motion) >= 0.97
    assert not taken_out(motion)[bent(motion)].any()


@pytest.mark.parametrize("begins", [0.0, 1.0, 0.6])
def test_straight_spells_that_nothing_is_wrong_with_stay(begins):
    for fps in (30.0, 120.0):
        assert not taken_out(straightening(fps, begins=begins)).any()


@pytest.mark.parametrize("delta", [-FORTY, FORTY])
def test_a_straight_spell_at_either_end_of_the_clip(delta):
    clean = straightening(begins=1.0)
    first, *_, last = spells(clean)
    assert first[0] == 0
    assert last[1] == clean.frames
    for frames in (first, last):
        offset = level(clean, frames, delta)
        motion = erring(clean, offset)
        assert repaired(offset, motion) >= 0.97
        assert not taken_out(motion)[offset == 0.0].any()


@pytest.mark.parametrize("frames", [(95, 115), (64, 74)])
def test_a_sudden_error_is_a_jump_as_ever_of_the_bent_limb_and_of_the_straight_one(frames):
    start, stop = frames
    assert bent(WALK)[start:stop].all() == (start == 95)
    motion = erring(WALK, level(WALK, frames, seconds=0.0))
    found = [i for i in analyse(motion).detect(kinds="counter-twist") if i.chain == "LeftUpLeg"]
    assert [(i.start, i.stop) for i in found] == [frames]
    assert "edges" in found[0].evidence


@parametrize("name", ["LeftArm", "RightArm", "LeftUpLeg", "RightUpLeg"], quick=2)
@pytest.mark.parametrize("delta", [-FORTY, FORTY])
def test_arms_and_legs_of_a_walk(name, delta):
    chain = thigh(WALK, name)
    offset = np.zeros(WALK.frames)
    for frames in spells(WALK, name=name):
        if frames[0] > 1 and frames[1] - frames[0] > 15:
            offset += level(WALK, frames, delta)
    motion = remove_twist(WALK, [chain], {name: -offset})
    assert repaired(offset, motion, name) >= 0.97
    assert not taken_out(motion, name)[offset == 0.0].any()


def test_nothing_tells_where_the_limb_is_never_bent():
    clean = straightening(least=6.0)
    q = clean.rotations.copy()
    knee = np.radians(15.0 + 10.0 * np.cos(np.pi * clean.times))
    q[:, KNEE] = quaternion_from_axis_angle(X, knee)
    clean = clean.with_rotations(q)
    motion = erring(clean, sum(level(clean, s) for s in spells(clean)))
    found = ClipAnalysis(motion, [thigh(motion)]).by().chains["LeftUpLeg"]
    told = [s.interval.explain() for s in found.fixed]
    assert "a straight limb" not in {t["follows"] for t in told}


def test_evidence_says_what_turned_and_the_line_of_the_threshold_holds():
    clean = straightening()
    motion = erring(clean, level(clean, spells(clean)[1]))
    found = analyse(motion)
    (interval,) = found.detect(kinds="counter-twist")
    evidence = interval.evidence
    assert evidence["bent_sides"] == 2
    assert evidence["transition_x_deg"] * evidence["transition_y_deg"] < 0.0
    detector = found.by()
    strongest = float(detector.strength("LeftUpLeg").max())
    assert strongest == pytest.approx(np.radians(evidence["transition_deg"]))
    assert detector.intervals("LeftUpLeg", strongest) == (interval,)
    assert detector.intervals("LeftUpLeg", strongest * 1.001) == ()


def test_no_joint_moves_and_what_is_below_keeps_its_orientation():
    clean = straightening()
    motion = erring(clean, sum(level(clean, s) for s in spells(clean)))
    found = analyse(motion)
    intervals = automatic_corrections(found.detect(kinds="counter-twist"))
    after = refine(motion, found.chains_and_limbs, intervals)
    verdict = judge("leg", motion, after, 15)
    assert len(verdict.mirrored_before) == 6
    assert verdict.mirrored_after == ()
    assert verdict.e_moved == 0.0
    assert verdict.c_moved == 0.0
    assert verdict.limbs_changed.bent_changed == 0
    assert verdict.limbs_changed.straight_changed > 0.9 * verdict.limbs_changed.straight
    assert not verdict.harmed


def test_the_judge_sees_a_bent_limb_that_was_changed():
    clean = straightening()
    changed = erring(clean, level(clean, (225, 255)))
    verdict = judge("leg", clean, changed, 15)
    assert verdict.limbs_changed.bent_changed > 20
    assert verdict.changed_bent
    assert verdict.harmed
    same = judge("leg", clean, clean, 15)
    assert same.limbs_changed == Straightness(
        same.limbs_changed.bent, 0, same.limbs_changed.straight, 0
    )


@pytest.mark.parametrize("name", ["walk", "dance", "basketball", "kick"])
def test_clips_without_such_an_error_have_none(name):
    chains = analyse(read_bvh(ASSETS / f"{name}.bvh")).by().chains
    assert {n: c.fixed for n, c in chains.items() if c.fixed} == {}


def test_explained_in_words(tmp_path, capsys):
    chain = thigh(WALK, "RightArm")
    offset = level(WALK, spells(WALK, name="RightArm")[2])
    path = tmp_path / "walk.bvh"
    write_motion(remove_twist(WALK, [chain], {"RightArm": -offset}), path)
    assert main(["detect", str(path), "--explain"]) == 0
    said = capsys.readouterr().out
    assert "bent sides 2" in said
