"""The consistency detector: its invariants, and errors that are known."""

import json
import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import examples, parametrize
from tests.twistcore.strategies import axes, quaternions
from twistcore.analysis.clip_analysis import REPAIRED, analyse
from twistcore.analysis.clip_analysis import detect as detect_every_kind
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.detection import Interval
from twistcore.detection.counter_twist.offsets import Course, _measured_at_parent
from twistcore.detection.counter_twist.pairing import Pair
from twistcore.detection.detectors.consistency import ConsistencyDetector
from twistcore.detection.natural_events import natural_events
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    wrap,
)
from twistcore.skeleton.twist_increments import twist_increments
from twistcore.study.benchmark.clip_scene import make_clean_scene
from twistcore.study.benchmark.passes import run_benchmark_passes
from twistcore.synthesis import InjectedError, inject, parse_protocol

WALK, DANCE, BASKETBALL = (
    read_bvh(ASSETS / f"{name}.bvh").motion for name in ("walk", "dance", "basketball")
)
CHAINS = find_chains(WALK)
DETECTOR = ConsistencyDetector()


def detect(motion, chains=None, **given):
    """What can be repaired: real clips have jumps and spikes of other joints as well."""
    return detect_every_kind(motion, chains, kinds=REPAIRED, **given)


def cut_out(motion: Motion, at: slice | np.ndarray, step: float = 1.0) -> Motion:
    return replace(
        motion,
        rotations=motion.rotations[at],
        positions=motion.positions[at],
        frame_time=motion.frame_time * step,
    )


def shift(chain: int, start: int, offset) -> InjectedError:
    offset = np.radians(np.atleast_1d(np.asarray(offset, dtype=float)))
    return InjectedError(CHAINS[chain].name, start, start + len(offset), offset)


def found_in(motion: Motion, *errors: InjectedError, tau=None, chains=CHAINS) -> list[Interval]:
    return list(detect(inject(motion, CHAINS, errors), chains, tau_radians=tau))


def assert_found(found: list[Interval], *errors: InjectedError, within_deg: float = 1.0) -> None:
    """Exactly these intervals, each with its offsets."""
    found = sorted(found, key=lambda i: (i.chain, i.start))
    wanted = sorted(errors, key=lambda e: (e.chain, e.start))
    assert [(i.chain, i.start, i.stop) for i in found] == [
        (e.chain, e.start, e.stop) for e in wanted
    ]
    for interval, error in zip(found, wanted, strict=True):
        assert not interval.open
        assert np.degrees(np.abs(wrap(interval.offset - error.offset)).max()) < within_deg


def slerped(motion: Motion, factor: int) -> Motion:
    """`factor` times as many frames."""
    frames = motion.frames
    at = np.arange((frames - 1) * factor + 1) / factor
    low = np.minimum(at.astype(int), frames - 2)
    share = (at - low)[:, None, None]
    a, b = motion.rotations[low], motion.rotations[low + 1]
    b = np.where((a * b).sum(-1, keepdims=True) < 0.0, -b, b)
    # normalised lerp: between neighbouring frames it is slerp to well below 1e-3°
    q = normalise((1.0 - share) * a + share * b)
    positions = motion.positions[low]
    return replace(motion, rotations=q, positions=positions, frame_time=motion.frame_time / factor)


# Increments


@settings(max_examples=examples(60))
@given(
    st.lists(quaternions, min_size=3, max_size=3),
    st.lists(quaternions, min_size=3, max_size=3),
    axes,
    st.lists(st.floats(-3.1, 3.1), min_size=3, max_size=3),
)
def test_a_twist_error_moves_the_increments_by_exactly_its_steps(parent, child, axis, delta):
    q_p, q_c, delta = np.array(parent), np.array(child), np.array(delta)
    x, y = twist_increments(q_p, q_c, axis)
    turn = quaternion_from_axis_angle(axis, delta)
    back = quaternion_from_axis_angle(axis, -delta)
    x_, y_ = twist_increments(multiply(q_p, turn), multiply(back, q_c), axis)
    step = np.diff(delta, prepend=delta[0])
    # a relative swing of 180° has no twist: leave a degree of room
    relative = [
        multiply(q_p[:-1] * [1, -1, -1, -1], q_p[1:]),
        multiply(q_c[1:], q_c[:-1] * [1, -1, -1, -1]),
    ]
    for q, before, after, sign in ((relative[0], x, x_, 1.0), (relative[1], y, y_, -1.0)):
        sound = np.hypot(q[:, 0], q[:, 1:] @ axis) > 0.01
        assert np.abs(wrap(after - before - sign * step))[1:][sound].max(initial=0.0) < 1e-6


def test_increments_are_exact_where_the_swing_passes_180_degrees_and_the_limb_is_straight():
    t = np.arange(60)
    a = np.array([1.0, 0.0, 0.0])
    q_p = quaternion_from_axis_angle([0.0, 0.0, 1.0], np.radians(150.0 + t))  # through 180°
    q_c = np.tile([1.0, 0.0, 0.0, 0.0], (60, 1))  # straight: no azimuth
    delta = np.where((t > 20) & (t < 40), 1.0, 0.0)
    x, y = twist_increments(
        multiply(q_p, quaternion_from_axis_angle(a, delta)),
        multiply(quaternion_from_axis_angle(a, -delta), q_c),
        a,
    )
    np.testing.assert_allclose(x, np.diff(delta, prepend=0.0), atol=1e-9)
    np.testing.assert_allclose(y, -np.diff(delta, prepend=0.0), atol=1e-9)


@settings(max_examples=examples(8))
@given(st.integers(0, 2**32 - 1))
def test_a_quaternion_and_its_negative_are_the_same_rotation(seed):
    dirty = inject(WALK, CHAINS, [shift(2, 100, [40.0] * 9), shift(7, 200, [-170.0])])
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], dirty.rotations.shape[:2])
    flipped = dirty.with_rotations(dirty.rotations * sign[..., None])
    for one, other in zip(detect(dirty, CHAINS), detect(flipped, CHAINS), strict=True):
        assert (one.chain, one.start, one.stop) == (other.chain, other.start, other.stop)
        np.testing.assert_allclose(one.offset, other.offset, atol=1e-9)


# Intervals


@settings(max_examples=examples(25))
@given(
    st.integers(0, 9), st.integers(20, 300), st.integers(1, 20),
    st.floats(5.0, 180.0), st.sampled_from([-1.0, 1.0]),
)  # fmt: skip
def test_a_level_shift_is_found_frame_by_frame(chain, start, length, degrees, sign):
    error = shift(chain, start, [sign * degrees] * length)
    assert_found(found_in(WALK, error), error)


@pytest.mark.parametrize("clip", [WALK, DANCE, BASKETBALL])
def test_nothing_is_found_in_a_clean_clip(clip):
    assert not detect(clip, CHAINS)


@parametrize("degrees", [179.9, 180.0, -179.5, 90.0, 5.0], quick=3)
@pytest.mark.parametrize("length", [1, 300])
def test_one_frame_or_three_hundred_at_any_angle(degrees, length):
    error = shift(4, 20, [degrees] * length)
    assert_found(found_in(DANCE, error), error)


@pytest.mark.parametrize("ramp", [2, 4])
def test_a_soft_onset_is_followed(ramp):
    level = np.ones(20)
    level[:ramp] = np.arange(1, ramp + 1) / (ramp + 1)
    level[-ramp:] = level[:ramp][::-1]
    error = shift(1, 150, 60.0 * level)
    assert_found(found_in(WALK, error), error)


@pytest.mark.thorough
@parametrize("name", ["walk", "dance", "basketball"])
def test_ramps_at_60_hz_do_not_hide_themselves(name):
    """Every 2nd frame: where the first pass takes a ramp for motion, σ hides it for good."""
    scene = make_clean_scene(
        name, read_bvh(ASSETS / f"{name}.bvh").motion, parse_protocol("H2+H3-4")
    )
    tallies = [
        t
        for seed in (1, 2, 3)
        for t in run_benchmark_passes(scene, DETECTOR.info.name, seed).values()
    ]
    assert sum(t.frames for t in tallies) > 1000
    assert sum(t.repaired for t in tallies) > 0.95 * sum(t.frames for t in tallies)


def test_jitter_inside_is_followed():
    offset = 50.0 + np.random.default_rng(4).standard_normal(20)
    error = shift(3, 150, offset)
    assert_found(found_in(WALK, error), error)


@pytest.mark.parametrize("upper", [0, 1, 3, 5, 8])
def test_both_joints_of_a_chain(upper):
    errors = shift(upper, 100, [70.0] * 12), shift(upper + 1, 105, [-40.0] * 15)
    if CHAINS[upper].child != CHAINS[upper + 1].parent:
        pytest.skip("the end of a limb")
    assert_found(found_in(WALK, *errors), *errors)


def test_intervals_that_touch_the_borders():
    last = WALK.frames
    errors = shift(2, 1, [35.0] * 8), shift(7, last - 8, [-60.0] * 8)
    assert_found(found_in(WALK, *errors), *errors)


@pytest.mark.parametrize("at_end", [True, False])
def test_a_jump_that_never_closes_is_open_where_its_shorter_side_is_long(at_end):
    frames = DANCE.frames
    many = int(0.45 * frames)
    error = shift(2, frames - many, [50.0] * many) if at_end else shift(2, 1, [50.0] * many)
    (found,) = found_in(DANCE, error)
    assert found.open
    assert (found.start, found.stop) == (error.start, error.stop)
    assert np.degrees(np.abs(wrap(found.offset - error.offset)).max()) < 1.0


def test_a_cut_is_a_border():
    joined = cut_out(WALK, np.r_[1:170, 250:343])
    jump = geodesic_angle(joined.rotations[168], joined.rotations[169])
    assert np.degrees(jump.max()) > 10.0
    assert not detect(joined, CHAINS)
    # an error that runs into the cut ends there, not at some jump behind it
    error = shift(2, 160, [45.0] * 9)
    dirty = inject(joined, CHAINS, [error])
    (found,) = detect(dirty, CHAINS)
    assert (found.start, found.stop) == (160, 169)


@parametrize("fps", [15, 30, 60, 120, 240], quick=2)
def test_behaves_alike_at_any_frame_rate(fps):
    motion = cut_out(DANCE, slice(1, None))  # no T-pose to decimate
    if fps == 240:
        motion = slerped(motion, 2)
    elif fps < 120:
        motion = cut_out(motion, slice(None, None, 120 // fps), 120 / fps)
    assert round(motion.fps) == fps
    assert not detect(motion, CHAINS)
    third = motion.frames // 3
    errors = [shift(k, third, [sign * 40.0] * 5) for k, sign in ((2, 1.0), (4, -1.0), (8, 1.0))]
    assert_found(found_in(motion, *errors), *errors, within_deg=4.0)


# τ


def test_an_edge_is_used_exactly_if_its_strength_reaches_tau():
    errors = [shift(2, 100, [20.0] * 9), shift(2, 200, [9.0] * 9)]
    analysis = DETECTOR.analyse(inject(DANCE, CHAINS, errors), CHAINS)
    strength = analysis.strength(CHAINS[2].name)
    edges = strength[[100, 109, 200, 209]]
    assert np.degrees(edges) == pytest.approx([20.0, 20.0, 9.0, 9.0], abs=0.5)
    for n, tau in enumerate(np.sort(edges)):
        for shifted, used in ((tau, True), (np.nextafter(tau, 4.0), False)):
            found = [i for i in analysis.intervals(CHAINS[2].name, shifted) if not i.open]
            ends = {t for i in found for t in (i.start, i.stop)}
            frame = (100, 109, 200, 209)[int(np.argsort(edges, kind="stable")[n])]
            if not used:
                assert frame not in ends
            elif n % 2 == 0:  # both edges of its interval are at least as strong
                assert frame in ends


def test_a_higher_tau_keeps_what_is_strong():
    errors = [shift(4, 40 + 40 * n, [5.0 + 15.0 * n] * 8) for n in range(8)]
    analysis = DETECTOR.analyse(inject(DANCE, CHAINS, errors), CHAINS)
    before = {e.start for e in errors}
    for tau in np.radians([2.0, 15.0, 40.0, 90.0, 179.0]):
        now = {i.start for i in analysis.intervals(CHAINS[4].name, tau) if not i.open}
        assert now == {e.start for e in errors if abs(e.offset[0]) >= tau}
        assert now <= before
        before = now


# What is told of them


def test_confidence_is_a_probability_and_evidence_is_json():
    errors = [shift(2, 100, [30.0] * 9), shift(8, 1, [30.0] * 9), shift(4, 150, [4.0] * 5)]
    dirty = inject(DANCE, CHAINS, errors)
    analysis = DETECTOR.analyse(dirty, CHAINS)
    found = [i for c in CHAINS for i in analysis.intervals(c.name, np.radians(0.3))]
    assert len(found) >= 3
    for interval in found:
        assert 0.0 <= interval.confidence <= 1.0
        evidence = json.loads(json.dumps(interval.evidence, allow_nan=False))
        assert 1 <= len(evidence["edges"]) <= 2
        assert evidence == interval.evidence
        assert len(pickle.dumps(interval)) < 10_000 + 8 * interval.frames
        assert pickle.loads(pickle.dumps(interval)).evidence == evidence
        again = interval.with_offset(interval.start, interval.offset)
        assert again.evidence == interval.evidence


def test_taking_out_what_was_found_restores_the_clip():
    errors = [shift(k, 60 + 20 * k, [-25.0 + 15.0 * k or 8.0] * 9) for k in range(10)]
    dirty = inject(WALK, CHAINS, errors)
    offsets = {c.name: np.zeros(WALK.frames) for c in CHAINS}
    for i in detect(dirty, CHAINS):
        offsets[i.chain][i.start : i.stop] += i.offset
    refined = remove_twist(dirty, CHAINS, offsets)
    assert np.degrees(geodesic_angle(refined.rotations, WALK.rotations).max()) < 1.0


# Which chains, how long, how still


def test_chains_may_come_alone_and_in_any_order():
    error = shift(2, 100, [40.0] * 9)
    dirty = inject(DANCE, CHAINS, [error])
    assert_found(list(detect(dirty, CHAINS[2:3])), error)
    shuffled = [CHAINS[k] for k in (7, 2, 9, 0, 1, 8, 3, 5, 4, 6)]
    assert_found(list(detect(dirty, shuffled)), error)
    assert not detect(dirty, ())


def test_axes_may_vary_over_time():
    wobble = quaternion_from_axis_angle(
        [0.0, 1.0, 0.0], 0.05 * np.sin(np.arange(DANCE.frames) / 20.0)
    )
    chains = list(CHAINS)
    from twistcore.skeleton.rotation import rotate

    chains[2] = replace(CHAINS[2], axis=rotate(wobble, CHAINS[2].axis))
    error = shift(2, 100, [40.0] * 9)
    dirty = inject(DANCE, chains, [error])
    analysis = DETECTOR.analyse(dirty, chains)  # the whole clip would miss that the hand moves
    found = [i for c in chains for i in analysis.intervals(c.name, analysis.automatic_tau(c.name))]
    assert_found(found, error)


@pytest.mark.parametrize("frames", [1, 2, 3, 4, 5, 10, 17])
def test_short_clips(frames):
    short = cut_out(WALK, slice(100, 100 + frames))
    analysis = DETECTOR.analyse(short, CHAINS)
    for chain in CHAINS:
        assert analysis.automatic_tau(chain.name) > 0.0
        strength = analysis.strength(chain.name)
        assert strength.shape == (frames,)
        assert np.isfinite(strength).all()
        assert not analysis.intervals(chain.name, np.radians(0.5))


@pytest.mark.parametrize("frames", [3, 40, 200])
def test_constant_clips(frames):
    still = cut_out(WALK, np.full(frames, 100))
    assert not detect(still, CHAINS)
    assert not detect(still, CHAINS, tau_radians=0.0)
    if frames > 3:
        error = shift(2, 12, [3.0] * 5)
        assert_found(found_in(still, error), error, within_deg=1e-3)


# The audit


def events_of(motion):
    return natural_events(CHAINS, analyse(motion, CHAINS).by("consistency"))


@pytest.mark.parametrize("clip", [WALK, DANCE, BASKETBALL])
def test_the_samples_have_no_event_of_their_own(clip):
    assert events_of(clip) == []


def test_the_audit_tells_a_flip_from_a_counter_rotation():
    chain = CHAINS[2]
    turned = DANCE.rotations.copy()
    turn = quaternion_from_axis_angle(chain.axis, np.radians(170.0))
    turned[100:140, chain.parent] = multiply(turned[100:140, chain.parent], turn)
    dirty = inject(DANCE.with_rotations(turned), CHAINS, [shift(8, 200, [20.0] * 9)])
    events = events_of(dirty)
    seen = {(e.chain, e.joint, e.start, e.stop, e.kind) for e in events}
    assert seen >= {
        (chain.name, chain.parent, 100, 101, "flip"),
        (chain.name, chain.parent, 140, 141, "flip"),
        (CHAINS[8].name, CHAINS[8].parent, 200, 209, "interval"),
    }
    flip = next(e for e in events if (e.chain, e.start) == (chain.name, 100))
    assert abs(flip.degrees) == pytest.approx(170.0, abs=5.0)


def test_where_p_stands_still_a_course_stays_as_it_is():
    """C alone jumps at both edges of a pair, as in 05_07 of the CMU clips with P held still."""
    edges = SimpleNamespace(
        start=np.array([3, 8]), stop=np.array([4, 9]), jump=np.array([0.21, -0.37])
    )
    still, lively = np.zeros((1, 12)), np.full((1, 12), 0.03)
    turned = still.copy()
    turned[0, [3, 8]] = -0.21, 0.37
    counter = SimpleNamespace(rx=still, ry=turned, sigma_x=lively / 300.0, sigma_y=lively)
    course = Course(3, np.full(5, 0.27), -0.16)
    table = SimpleNamespace(edges=edges)
    assert _measured_at_parent(course, Pair(0, 1, 1, 8.0), table, counter, 0) is course
