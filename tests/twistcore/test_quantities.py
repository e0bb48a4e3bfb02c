"""The curve of each kind of error: it reaches the number on the card, beyond its limit."""

import math
from dataclasses import replace

import numpy as np
import pytest

import twistcore as tc
from benchmarks.notation import kept
from tests.twistcore.test_all_joints import at_30_hz, stepping, turned
from tests.twistcore.test_backward_bends import bent
from tests.twistcore.test_noise_bursts import ARM, noisy
from tests.twistcore.test_notation import KEYS5
from tests.twistcore.test_strangers import UNREAL, rolled
from tests.twistcore.test_stretches import turned as turned_about_bone
from tests.twistcore.test_turned_ends import flipped
from twistcore.analysis.clip_analysis import DEFAULT_METHOD, analyse
from twistcore.detection import Kind
from twistcore.detection.interval import Interval
from twistcore.detection.kind import KindInfo
from twistcore.detection.quantity import evidence_curve_of_interval
from twistcore.errors import TwistError
from twistcore.formats.bvh import parse_bvh
from twistcore.formats.clip import create_file_patch_for_motion

WALK = tc.read_clip("assets/walk.bvh").motion


def place_jump():
    positions = WALK.positions.copy()
    positions[150:, 0, 1] += 0.1 * WALK.skeleton.height
    return replace(WALK, positions=positions)


def helper_roll():
    degrees = np.zeros(UNREAL.frames)
    degrees[150:165] = 90.0
    return rolled(UNREAL, "upperarm_twist_01_l", degrees)


MOTIONS = {
    Kind.SPIKE: lambda: turned(WALK, "Neck", 150, 152, 40.0),
    Kind.JOINT_JUMP: lambda: turned(WALK, "Neck", 150, WALK.frames, 60.0),
    Kind.LONE_JUMP: lambda: turned_about_bone("LeftFoot", 170.0, 60, 260),
    Kind.STRETCH: lambda: turned_about_bone("LeftFoot", 170.0, 60, 260),
    Kind.TURNED_END: flipped,
    Kind.PLACE_JUMP: place_jump,
    Kind.BODY_STEP: lambda: stepping(150),
    Kind.BACKWARD_BEND: lambda: bent(WALK, "LeftUpLeg", 40.0, 150, 200),
    Kind.HELPER_ROLL: helper_roll,
    Kind.NOISE_BURST: lambda: noisy(ARM),
}


def curves_of(motion, kind, *, reviewed=True):
    """The intervals of a kind with their curves, as a review stores the intervals."""
    clip = analyse(motion)
    own = [i for i in clip.detect() if i.kind == kind]
    assert own
    own = [i.for_review if reviewed else i for i in own]
    return [(i, evidence_curve_of_interval(clip.search(DEFAULT_METHOD), i)) for i in own]


def held(motion):
    slow = at_30_hz(motion)
    return replace(slow.at(np.repeat(np.arange(slow.frames), 4)), frame_time=motion.frame_time)


def test_all_kinds_but_those_of_chains_and_limbs_have_a_curve():
    without = {kind for kind in Kind if not kind.info.quantity}
    assert without == {Kind.COUNTER_TWIST, Kind.CARRIED_ROLL, Kind.LIMB_FLIP, Kind.FROZEN}
    assert set(MOTIONS) == set(Kind) - without


@pytest.mark.parametrize("kind", MOTIONS)
def test_it_reaches_the_number_on_the_card_beyond_its_limit(kind):
    for interval, quantity in curves_of(MOTIONS[kind](), kind):
        inside = quantity.values[interval.start : interval.stop]
        evidence, degrees = interval.evidence, math.degrees(interval.size)
        if kind == Kind.PLACE_JUMP:
            assert (quantity.size, quantity.unit) == (evidence["way_percent"], " %")
        else:
            assert quantity.size == pytest.approx(
                -degrees if kind == Kind.BACKWARD_BEND else degrees
            )
        reached = {
            Kind.SPIKE: inside.min(),  # all frames of a spike are off by at least its angle
            Kind.STRETCH: np.nanmean(inside),
            Kind.TURNED_END: np.median(inside),
            Kind.HELPER_ROLL: np.median(inside),
            Kind.NOISE_BURST: np.median(inside),
        }.get(kind, inside[np.abs(inside - quantity.size).argmin()])
        # In many frames the joint moves naturally as well; the card shows the jump, or a median.
        near = {
            Kind.STRETCH: 15.0,
            Kind.TURNED_END: 10.0,
            Kind.HELPER_ROLL: 10.0,
            Kind.NOISE_BURST: 0.5,
        }.get(kind, 1e-6)
        assert reached == pytest.approx(quantity.size, abs=near)
        limit, sign = quantity.limit[interval.start : interval.stop], np.sign(quantity.size)
        assert (sign * (inside - limit) > 0.0).any()


@pytest.mark.parametrize("kind", MOTIONS)
def test_ordinary_frames_stay_within_the_limit(kind):
    interval, quantity = curves_of(MOTIONS[kind](), kind)[0]
    sign = np.sign(quantity.size)
    beyond = sign * (quantity.values - quantity.limit) > 0.0
    beyond[interval.start - 20 : interval.stop + 20] = False
    assert beyond.mean() < 0.02


def test_limits_and_numbers_are_those_of_the_search():
    """Its thresholds are the same: a limit just above them would hide the interval."""
    ((_, bend),) = curves_of(MOTIONS[Kind.BACKWARD_BEND](), Kind.BACKWARD_BEND)
    clip = analyse(MOTIONS[Kind.BACKWARD_BEND]())
    (found,) = (i for i in clip.detect() if i.kind == Kind.BACKWARD_BEND)
    assert bend.limit[0] == pytest.approx(-found.evidence["limit_deg"])
    for jump, curve in curves_of(MOTIONS[Kind.LONE_JUMP](), Kind.LONE_JUMP):
        fastest = jump.evidence["limit_deg_s"] / WALK.fps
        assert abs(curve.limit[0]) == pytest.approx(fastest)
    ((stretch, roll),) = curves_of(MOTIONS[Kind.STRETCH](), Kind.STRETCH)
    mean = np.nanmean(roll.values[stretch.start : stretch.stop])
    assert mean == pytest.approx(stretch.evidence["roll_deg"], abs=0.5)
    ((helper, own),) = curves_of(helper_roll(), Kind.HELPER_ROLL)
    assert helper.confidence is None  # it was not measured for this kind
    jump = own.values[helper.start] - own.values[helper.start - 1]
    assert jump == pytest.approx(helper.evidence["opens_deg"], abs=1e-6)
    jump = own.values[helper.stop] - own.values[helper.stop - 1]
    assert jump == pytest.approx(helper.evidence["closes_deg"], abs=1e-6)


@pytest.mark.parametrize("degrees", [9.0, 11.0, 14.0, 40.0])
def test_a_spike_is_listed_exactly_if_it_is_beyond_its_limit(degrees):
    motion = turned(WALK, "LeftForeArm", 100, 101, degrees)
    found = [i for i in analyse(motion).detect() if i.kind == Kind.SPIKE]
    one = Interval("LeftForeArm", 100, 101, np.zeros(1), kind=Kind.SPIKE, joint="LeftForeArm")
    quantity = evidence_curve_of_interval(analyse(motion).search(DEFAULT_METHOD), one)
    assert bool(found) == bool(quantity.values[100] >= quantity.limit[100])


def test_frames_that_are_held_have_the_value_of_their_own_frame():
    spike = held(turned(WALK, "Neck", 160, 164, 60.0))
    ((interval, quantity),) = curves_of(spike, Kind.SPIKE)
    assert (interval.start, interval.stop) == (160, 164)
    assert len(quantity.values) == spike.frames
    np.testing.assert_allclose(quantity.values[160:164], math.degrees(interval.size))


def test_between_linear_keys_a_curve_has_the_value_of_the_change_to_the_next_key():
    clip = tc.read_clip("assets/walk.bvh")
    stepped = parse_bvh(create_file_patch_for_motion(clip, stepping(150, 30.0)).data, clip.path)
    keyed = KEYS5.written(kept(stepped, KEYS5), KEYS5.repeats(WALK.fps)[1]).motion
    ((interval, quantity),) = curves_of(keyed, Kind.BODY_STEP)
    assert (interval.start, interval.stop) == (146, 151)
    np.testing.assert_allclose(quantity.values[146:151], math.degrees(interval.size))
    assert (quantity.values[146:151] > quantity.limit[146:151]).all()
    assert (quantity.values[141:146] < quantity.limit[141:146]).all()


@pytest.mark.parametrize(
    ("kind", "curve", "around"),
    [
        (Kind.SPIKE, "values", 3),
        (Kind.JOINT_JUMP, "values", 0),
        (Kind.PLACE_JUMP, "values", 2),
        (Kind.BODY_STEP, "values", 0),
        (Kind.BODY_STEP, "limit", 1),
    ],
)
def test_cuts_and_the_ends_of_a_clip_are_left_out_but_no_frame_of_the_interval(kind, curve, around):
    cut, frames = 200, WALK.frames
    left_out = {*range(5), *range(cut - around, cut + around + 1), *range(frames - 4, frames)}
    search = analyse(stepping(100).at(np.r_[0:cut, 60 : frames - cut + 60])).search(DEFAULT_METHOD)
    for start in (100, 2, cut):
        step = Interval("LeftArm", start, start + 1, np.zeros(1), kind=kind, joint="Hips")
        if (quantity := evidence_curve_of_interval(search, step)) is not None:
            left_out = {
                *range(5),
                *range(cut - around, cut + around + 1),
                *range(frames - 4, frames),
            }
            found = np.flatnonzero(np.isnan(getattr(quantity, curve)))
            assert set(found.tolist()) == left_out - {start}


@pytest.mark.parametrize("edges", [(0, 3), (340, 344), (0, 344), (100, 160)])
def test_an_interval_of_any_length_by_hand_has_a_curve_or_none(edges):
    start, stop = edges
    search = analyse(WALK).search(DEFAULT_METHOD)
    for kind in MOTIONS:
        one = Interval(
            "LeftArm", start, stop, np.ones(stop - start), kind=kind, joint="LeftForeArm"
        )
        quantity = evidence_curve_of_interval(search, one)
        assert quantity is None or len(quantity.values) == WALK.frames


@pytest.mark.parametrize("other", [0.0, 90.0])
def test_a_stretch_by_hand_is_compared_with_the_rest_if_no_roll_is_usual(other):
    """With the rest pose, or with the rest of the clip if the other foot never has this roll."""
    motion = turned_about_bone("LeftFoot", 170.0, 60, 200)
    rotations, right = motion.rotations.copy(), WALK.skeleton.index("RightFoot")
    both = turned_about_bone("RightFoot", other, 0, WALK.frames)
    rotations[:, right] = both.rotations[:, right]
    search = analyse(motion.with_rotations(rotations).sliced(0, 260)).search(DEFAULT_METHOD)
    foot = Interval(
        "LeftLeg", 60, 200, np.ones(140), kind=Kind.STRETCH, joint="LeftFoot", residual=3.0
    )
    quantity = evidence_curve_of_interval(search, foot)
    outside, inside = np.delete(quantity.values, slice(60, 200)), quantity.values[60:200]
    assert abs(np.nanmean(outside)) < 10.0
    assert abs(np.nanmean(inside)) == pytest.approx(170.0, abs=25.0)


@pytest.mark.parametrize(
    "curve",
    [
        "no.such.module:curve",
        "math:no_such_name",
        "math:sqrt",
        "tests.twistcore.test_quantities:short",
    ],
)
def test_a_curve_that_fails_is_one_error(monkeypatch, curve):
    info = KindInfo("foot slide", "Foot slides", 35, quantity=curve)
    kind = Kind("foot slide")
    monkeypatch.setattr(kind, "info", info)
    one = Interval("LeftArm", 3, 5, np.zeros(2), kind=kind, joint="LeftArm")
    with pytest.raises(TwistError, match="foot slide"):
        evidence_curve_of_interval(analyse(WALK).search(DEFAULT_METHOD), one)


def short(search, interval):
    """A curve of the wrong length."""
    from twistcore.detection.quantity import Quantity

    return Quantity("slide", np.zeros(3))
