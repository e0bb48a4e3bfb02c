"""Coarse notation: recognised from the clip, no error by itself, and no place for one to hide."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.notation import NOTATIONS, Notation, kept, sound, with_errors
from tests.conftest import ASSETS
from tests.messages import numbers
from tests.tiers import parametrize
from tests.twistcore.test_first_frames import blended
from twistcore import analyse, read_bvh
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.analysis.why_not import Why, why_frame_bounds_no_interval, why_peaks_lack_interval
from twistcore.detection.consistency.chain_analysis import ROUNDED_GAIN, ConsistencyAnalysis
from twistcore.detection.consistency.notated import NotatedAnalysis
from twistcore.detection.cuts import count_leading_rest_frames, find_cuts
from twistcore.detection.lone_jumps import lone_jumps
from twistcore.detection.natural_events import natural_events
from twistcore.detection.prediction import (
    FLOOR,
    predict_increments_between_linear_keys,
    smallest_increment_residual_sigma,
)
from twistcore.detection.soft_errors.departures import overlapping_frame_spans_by_length
from twistcore.detection.soft_errors.natural_scale import (
    ROUNDED,
    natural_twist_departure_scales,
    unnaturally_large_twist_increments,
)
from twistcore.detection.straight_limbs.straight_course import twist_increment_change_scale
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.notation import (
    FEWEST_A_SECOND,
    KIND,
    DistinctFrames,
    Keys,
    find_keys_of_linear_motion,
    rounding_step_of_angles,
    without_repeated_frames,
)
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle
from twistcore.synthesis import InjectedError, inject

NAMES = [n.name for n in NOTATIONS]
WHOLE, TENTHS, HELD, KEYS5, KEYS10, KEYS15 = NOTATIONS


@cache
def clip(name="dance"):
    return sound(read_bvh(ASSETS / f"{name}.bvh"))


@cache
def written(notation, name="dance"):
    """A sound clip in a notation, as its file would be read."""
    base = kept(clip(name), notation)
    return notation.written(base, notation.repeats(1.0 / clip(name).frame_time)[1])


def error(motion, label, start, stop, degrees):
    """A clip's chains, and an error of so many degrees in one of them."""
    chains = find_chains(motion)
    chain = next(c for c in chains if c.label == label)
    offset = np.full(stop - start, math.radians(degrees))
    return chains, InjectedError(chain.name, start, stop, offset)


def noted(motion):
    return [n.text for n in analyse(motion).notes if n.kind == KIND]


# -- recognised ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["walk", "dance", "basketball", "kick", "walk_injected"])
def test_a_plain_clip_is_never_taken_for_a_coarse_one(name):
    motion = read_bvh(ASSETS / f"{name}.bvh").motion
    assert (
        motion.angle_step,
        without_repeated_frames(motion),
        find_keys_of_linear_motion(motion),
    ) == (
        0.0,
        None,
        None,
    )
    assert noted(motion) == []
    assert isinstance(analyse(motion).by(), ConsistencyAnalysis)


@pytest.mark.parametrize("step", [5.0, 1.0, 0.5, 0.25, 0.1])
def test_the_step_of_angles(step):
    motion = Notation("", step=step).written(clip("walk"), 1).motion
    assert motion.angle_step == pytest.approx(math.radians(step))
    assert motion.sliced(5, 50).with_rotations(motion.rotations[5:50]).angle_step > 0.0


def test_a_corrected_clip_is_still_in_whole_degrees():
    whole = written(WHOLE, "walk")
    chains, wrong = error(whole.motion, "Left ForeArm", 100, 130, 40.0)
    assert with_errors(whole, chains, [wrong]).motion.angle_step == pytest.approx(math.radians(1.0))


def test_angles_that_never_change_tell_of_no_step():
    still = np.zeros((100, 3))
    fine = np.linspace(0.0, 40.0, 100)[:, None] ** 2 / 7.0
    assert rounding_step_of_angles([still] * 20 + [fine]) == 0.0
    assert rounding_step_of_angles([still] * 20) == 0.0
    assert rounding_step_of_angles([np.round(fine), still]) == pytest.approx(math.radians(1.0))
    assert rounding_step_of_angles([np.round(fine[:20])]) == 0.0  # too few to tell


@pytest.mark.parametrize("often", [2, 3, 4])
def test_held_frames(often):
    motion = clip("walk").motion
    held = motion.at(np.repeat(np.arange(motion.frames), often))
    found = without_repeated_frames(replace(held, frame_time=motion.frame_time / often))
    np.testing.assert_array_equal(found.motion.rotations, motion.rotations)
    np.testing.assert_array_equal(found.first, often * np.arange(motion.frames))
    assert found.motion.fps == pytest.approx(motion.fps, rel=1e-3)


def test_held_by_turns_as_24_frames_in_60():
    motion = clip("walk").motion
    times = np.where(np.arange(motion.frames) % 2, 3, 2)
    held = replace(motion.at(np.repeat(np.arange(motion.frames), times)), frame_time=1 / 60)
    found = without_repeated_frames(held)
    np.testing.assert_array_equal(found.motion.rotations, motion.rotations)
    assert found.motion.fps == pytest.approx(24.0, rel=0.01)


def test_a_figure_that_stands_still_in_a_held_clip_keeps_its_time():
    motion = clip("walk").motion
    frames = np.repeat(np.r_[:100, np.full(50, 100), 100 : motion.frames], 4)
    found = without_repeated_frames(motion.at(frames))
    assert len(found.first) == pytest.approx(motion.frames + 50, abs=2)


def test_a_figure_that_stands_still_now_and_then_is_not_held():
    motion = clip("walk").motion
    frames = np.r_[:100, np.full(300, 100), 100:200, np.full(100, 200), 200 : motion.frames]
    assert without_repeated_frames(motion.at(frames)) is None
    assert without_repeated_frames(motion.at(np.zeros(200, dtype=int))) is None


@pytest.mark.parametrize("notation", [KEYS5, KEYS10, KEYS15], ids=lambda n: n.name)
def test_linear_keys(notation):
    motion = written(notation).motion
    for first in (0, 1, 4, 301):
        found = find_keys_of_linear_motion(motion.sliced(first, motion.frames))
        assert (found.spacing, found.first) == (notation.keys, -first % notation.keys)
    assert f" every {notation.keys} frames" in noted(motion)[0]


def test_a_clip_that_stands_still_for_half_its_time_has_no_keys():
    motion = clip("walk").motion
    still = motion.at(np.r_[: motion.frames, np.full(500, motion.frames - 1)])
    assert find_keys_of_linear_motion(still) is None


def test_what_is_recognised_is_said_in_a_sentence():
    found = [noted(written(form).motion)[0] for form in (WHOLE, TENTHS, HELD)]
    assert [numbers(sentence)[0] for sentence in found] == [3, 0.1, 30]
    slow = replace(written(KEYS15).motion, frame_time=1 / 30)
    assert slow.fps / 15 < FEWEST_A_SECOND
    assert len(noted(slow)) == 2


# -- no error by itself ----------------------------------------------------------------------------


@parametrize("notation", NOTATIONS, ids=NAMES, quick=2)
@pytest.mark.parametrize("name", ["dance", "basketball"])
def test_a_sound_clip_stays_as_it_is(notation, name):
    assert automatic_corrections(analyse(written(notation, name)).detect()) == ()


# -- no place to hide ------------------------------------------------------------------------------


@parametrize("degrees", [15.0, -30.0, 150.0], quick=2)
@parametrize("label", ["Left Arm", "Right ForeArm", "Left UpLeg"], quick=2)
def test_an_error_in_whole_degrees(label, degrees):
    chains, wrong = error(clip().motion, label, 200, 212, degrees)
    erring = WHOLE.written(with_errors(clip(), chains, [wrong]), 1)
    (found,) = automatic_corrections(analyse(erring).detect())
    assert (found.chain, found.start, found.stop) == (wrong.chain, 200, 212)
    assert math.degrees(found.delta) == pytest.approx(degrees, abs=3.0)


def test_a_small_error_that_rounding_hides_in_part_is_only_shown():
    found = []
    for degrees in (3.0, 6.0):
        chains, wrong = error(clip().motion, "Left UpLeg", 200, 212, degrees)
        erring = WHOLE.written(with_errors(clip(), chains, [wrong]), 1)
        found += [i for i in analyse(erring).detect(tau_degrees=1.0) if i.chain == wrong.chain]
    weak, clear = found
    assert weak.evidence["gain"] < ROUNDED_GAIN < clear.evidence["gain"]
    assert (weak.open, clear.open) == (True, False)


@pytest.mark.parametrize("degrees", [15.0, 120.0])
def test_an_error_in_held_frames_has_its_frames(degrees):
    base = kept(clip(), HELD)
    chains, wrong = error(base.motion, "Left Arm", 50, 55, degrees)
    erring = HELD.written(with_errors(base, chains, [wrong]), 4)
    analysis = analyse(erring)
    assert isinstance(analysis.by(), NotatedAnalysis)
    (found,) = automatic_corrections(analysis.detect())
    assert (found.chain, found.start, found.stop) == (wrong.chain, 200, 220)
    assert [(e["start"], e["stop"]) for e in found.evidence["edges"]] == [(200, 201), (220, 221)]
    repaired = refine(erring.motion, chains, [found])
    true = HELD.written(base, 4).motion.rotations[200:220]
    np.testing.assert_allclose(np.abs((repaired.rotations[200:220] * true).sum(-1)), 1.0, atol=1e-3)


@parametrize("notation", [KEYS5, KEYS10, KEYS15], ids=lambda n: n.name, quick=2)
@parametrize("frames", [(213, 217), (228, 232), (231, 310)], quick=2)
def test_an_error_that_jumps_between_linear_keys(notation, frames):
    whole = written(notation)
    chains, wrong = error(whole.motion, "Left Arm", *frames, 30.0)
    (found,) = automatic_corrections(analyse(with_errors(whole, chains, [wrong])).detect())
    assert (found.chain, found.start, found.stop) == (wrong.chain, *frames)
    assert math.degrees(found.delta) == pytest.approx(30.0, abs=1.0)


@pytest.mark.parametrize("notation", [KEYS5, KEYS10], ids=lambda n: n.name)
def test_an_error_in_linear_keys_comes_and_goes_with_its_keys(notation):
    base, n = kept(clip(), notation), notation.keys
    chains, wrong = error(base.motion, "Left Arm", 20, 23, 60.0)
    erring = notation.written(with_errors(base, chains, [wrong]), n)
    (found,) = automatic_corrections(analyse(erring).detect())
    assert (found.start, found.stop) == (19 * n + 1, 23 * n)
    at_keys = found.offset[n - 1 :: n]
    np.testing.assert_allclose(np.degrees(at_keys), 60.0, atol=3.0)
    assert abs(found.offset[n // 2]) == pytest.approx(abs(at_keys[0]) * (n // 2 + 1) / n)


@pytest.mark.parametrize("notation", [KEYS5, KEYS10], ids=lambda n: n.name)
@parametrize(
    ("label", "degrees"),
    [("Left UpLeg", 60.0), ("Left UpLeg", 90.0), ("Left Leg", -140.0), ("Right Leg", 170.0)],
    quick=2,
)
def test_a_large_error_in_linear_keys_is_one_interval(notation, label, degrees):
    """Euler angles that go far from key to key turn a joint unevenly: nothing jumps there."""
    base, n = kept(clip(), notation), notation.keys
    chains, wrong = error(base.motion, label, 20, 24, degrees)
    erring = notation.written(with_errors(base, chains, [wrong]), n)
    (found,) = automatic_corrections(analyse(erring).detect())
    assert (found.chain, found.start, found.stop) == (wrong.chain, 19 * n + 1, 24 * n)


def test_what_few_keys_show_is_not_corrected_automatically():
    base = kept(clip(), KEYS10)
    chains, wrong = error(base.motion, "Left Arm", 20, 23, 60.0)
    erring = KEYS10.written(with_errors(base, chains, [wrong]), 10).motion
    slow = replace(erring, frame_time=1 / 60)
    (found,) = (i for i in analyse(slow).detect() if i.chain == wrong.chain)
    assert found.open
    assert (found.start, found.stop) == (191, 230)


# -- what rounding does ----------------------------------------------------------------------------


def test_scales_are_no_less_than_what_rounding_makes():
    """Levels of angles that are rounded, each by itself: as white as rounding can be."""
    step = math.radians(1.0)
    rng = np.random.default_rng(5)
    levels = step * rng.uniform(-0.5, 0.5, (2, 4, 40_000))
    x, y = np.diff(levels, axis=-1, prepend=levels[..., :1])
    nowhere = np.zeros(x.shape, dtype=bool)
    still = np.zeros_like(x)
    every = overlapping_frame_spans_by_length(120.0, x.shape[1])
    for span, found in zip(
        every,
        natural_twist_departure_scales(still, still, 120.0, every, nowhere, step),
        strict=True,
    ):
        spread = span.departures(levels[0]).std(axis=(1, 2))
        np.testing.assert_allclose(step * ROUNDED * span.noise(), spread, rtol=0.1)
        total = (span.departures(levels[0]) + span.departures(levels[1])).std(axis=(1, 2))
        np.testing.assert_allclose(found.sigma_sum[:, 0, 0], total, rtol=0.1)
    assert not unnaturally_large_twist_increments(x, y, 120.0, step).any()
    residual = x[:, 2:-2] - np.stack(
        [2 / 3 * (x[:, 1:-3] + x[:, 3:-1]) - (x[:, :-4] + x[:, 4:]) / 6]
    )
    assert smallest_increment_residual_sigma(step) == pytest.approx(residual.std(), rel=0.05)
    assert smallest_increment_residual_sigma(0.0) == FLOOR
    assert twist_increment_change_scale(still[0], step) == pytest.approx(
        np.diff(x, axis=1).std(), rel=0.05
    )


def test_the_median_of_a_piece_between_keys():
    keys = Keys(5, 3)
    pace = np.repeat([1.0, 4.0, 2.0, 7.0], 5)[1:][None]  # the key of frame 3 is the first's last
    good = np.ones((1, 19), dtype=bool)
    np.testing.assert_array_equal(
        predict_increments_between_linear_keys(pace[None], good, keys)[0], pace
    )
    jumping = pace.copy()
    jumping[0, [5, 6]] += [9.0, -9.0]
    np.testing.assert_array_equal(
        predict_increments_between_linear_keys(jumping[None], good, keys)[0], pace
    )
    good[0, 4:9] = False  # nothing good in a piece: all of it tells
    np.testing.assert_array_equal(
        predict_increments_between_linear_keys(jumping[None], good, keys)[0], pace
    )


# -- in the clip's frames --------------------------------------------------------------------------


def test_an_offset_of_kept_frames_in_all_frames():
    motion = clip("walk").motion.sliced(0, 4)
    first = np.array([0, 3, 5, 9])
    held, even = (DistinctFrames(motion, first, 12, even) for even in (False, True))
    offset = np.array([0.3, 0.6])
    assert (held.begin(1), held.end(3), held.begin(4)) == (3, 9, 12)
    np.testing.assert_allclose(held.spread(1, offset), [0.3] * 2 + [0.6] * 4)
    np.testing.assert_allclose(held.spread(2, offset), [0.3] * 4 + [0.6] * 3)
    assert (even.begin(1), even.begin(0)) == (1, 0)
    np.testing.assert_allclose(even.spread(1, offset), [0.1, 0.2, 0.3, 0.45, 0.6, 0.45, 0.3, 0.15])
    np.testing.assert_allclose(even.spread(0, offset[:1]), [0.3, 0.2, 0.1])
    np.testing.assert_allclose(even.spread(3, offset[:1]), [0.075, 0.15, 0.225, 0.3, 0.3, 0.3])
    over = even.spread(1, np.array([3.1, -3.1]))  # beyond half a turn, not through 0
    assert np.abs(over[2:5]).min() > 3.09
    assert [held.of(t) for t in (0, 2, 3, 4, 8, 9, 11)] == [0, 0, 1, 1, 2, 3, 3]


def test_every_frame_of_a_coarse_clip_has_its_reason():
    base = kept(clip(), HELD)
    chains, wrong = error(base.motion, "Left Arm", 50, 55, 40.0)
    found = analyse(HELD.written(with_errors(base, chains, [wrong]), 4)).detect()
    for frame in range(150, 260):
        reason = why_frame_bounds_no_interval(found, wrong.chain, frame)
        assert reason.frame == frame
        if reason.why == Why.BELOW and frame % 4:
            assert f"frame {frame // 4 * 4}" in reason.text
    assert why_frame_bounds_no_interval(found, wrong.chain, 200).why == Why.INTERVAL
    open_ = found.analysis.detect(tau_degrees=0.5)
    for reason in why_peaks_lack_interval(open_, wrong.chain):
        assert reason.frame % 4 == 0
        assert f"frame {reason.frame} " in reason.text
    keyed = analyse(written(KEYS10)).detect(tau_degrees=0.5)
    for frame in range(95, 125):
        assert why_frame_bounds_no_interval(keyed, wrong.chain, frame).frame == frame


def test_the_strength_of_a_held_clip_is_where_a_frame_begins():
    analysis = analyse(written(HELD))
    for chain in analysis.chains:
        strength = analysis.by().strength(chain.name)
        assert len(strength) == analysis.motion.frames
        assert not strength[np.arange(len(strength)) % 4 > 0].any()


def test_fast_turns_of_held_frames_are_no_lone_jumps():
    """A turn of 90° from one frame of 30 Hz to the next is none; one of 170° is, in its frame."""
    motion = clip("walk").motion.sliced(1, 121)
    chains = find_chains(motion)
    chain = next(c for c in chains if c.label == "Left ForeArm")
    for degrees, jumps in ((90.0, 0), (170.0, 2)):
        q = motion.rotations.copy()
        turn = quaternion_from_axis_angle(chain.axis, np.full(30, math.radians(degrees)))
        q[40:70, chain.parent] = multiply(q[40:70, chain.parent], turn)
        slow = replace(motion.with_rotations(q), frame_time=1 / 30)
        held = replace(slow.at(np.repeat(np.arange(120), 4)), frame_time=1 / 120)
        found = lone_jumps(held, chains)[chain.name]
        assert [(i.start, i.stop) for i in found] == [(160, 161), (280, 281)][:jumps]


def test_cuts_of_a_held_clip_are_those_of_its_frames():
    """At the rate of the file every joint seems to jump in every fourth frame."""
    motion = HELD.written(kept(clip("basketball"), HELD), 4).motion
    own = find_cuts(without_repeated_frames(motion).motion)
    cut = find_cuts(motion)
    np.testing.assert_array_equal(np.flatnonzero(cut), 4 * np.flatnonzero(own))
    assert not analyse(motion).not_examined


def test_a_blend_in_a_held_clip_is_one_piece():
    capture = kept(clip("walk"), HELD).motion
    capture = capture.sliced(1, capture.frames)
    own = blended(capture, 4)
    held = replace(own.at(np.repeat(np.arange(own.frames), 4)), frame_time=own.frame_time / 4)
    first = count_leading_rest_frames(own)
    assert first >= 3
    assert count_leading_rest_frames(held) == 4 * first


def test_natural_events_of_a_held_clip_are_in_its_frames():
    base = kept(clip(), HELD)
    chains, wrong = error(base.motion, "Left Arm", 50, 55, 40.0)
    motion = HELD.written(with_errors(base, chains, [wrong]), 4).motion
    events = natural_events(chains, analyse(motion).by())
    assert (200, 220) in {(e.start, e.stop) for e in events}


def test_a_coarse_scale_is_the_notation_s_alone():
    """Where nothing is written coarsely the step changes no bit."""
    motion = clip("walk").motion
    plain, fine = (analyse(m).detect() for m in (motion, replace(motion, angle_step=0.0)))
    coarse = analyse(replace(motion, angle_step=math.radians(1.0))).detect()
    assert plain.tau == fine.tau
    assert min(coarse.tau[c.name] for c in coarse.chains) > math.radians(2.0)
    dirty = inject(motion, plain.chains, [error(motion, "Left Arm", 100, 120, 60.0)[1]])
    assert len(analyse(dirty).detect()) == 1
