"""Departures from bridges, their natural scales, and levels that are softened."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from tests.twistcore.test_soft_errors import (
    FPS,
    RNG,
    SHAPES,
    THIRTY,
    chain_of,
    clip,
    erring,
    low_passed,
)
from twistcore.detection.soft_errors.departures import (
    PROBES,
    hermite_bridge_frame_weights,
    natural_accumulated_twist_curves,
    overlapping_frame_spans_by_length,
)
from twistcore.detection.soft_errors.natural_scale import (
    fit_parent_share_of_twist,
    natural_twist_departure_scales,
)
from twistcore.detection.soft_errors.softened_level import (
    KERNELS,
    Level,
    butterworth_filtered_unit_step,
    fit_softened_levels,
    guess_softened_level,
    linear_unit_ramp,
    softened_level_curves,
)
from twistcore.synthesis.protocol import parent_and_child_twist_increments

# Departures


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0, 240.0])
def test_bridges_keep_values_and_slopes_at_both_ends(fps):
    level = np.cumsum(np.random.default_rng(1).standard_normal(6 * round(fps)))
    for span in overlapping_frame_spans_by_length(fps, len(level)):
        h, n = span.reach, span.length
        assert 2 * span.support <= len(level)
        found = span.departures(level)
        assert found.shape == (len(PROBES), span.count(len(level)))
        for position in {0, found.shape[1] // 2, found.shape[1] - 1}:
            a = position * span.step + h
            b = a + n
            slopes = (level[a] - level[a - h]) / h, (level[b + h] - level[b]) / h
            cubic = CubicHermiteSpline([a, b], [level[a], level[b]], slopes)
            for probe, value in zip(PROBES, found[:, position], strict=True):
                at = a + round(probe * n)
                assert value == pytest.approx(level[at] - cubic(at), abs=1e-9 * n)
            inside = np.arange(a + 1, b)
            (course,) = natural_accumulated_twist_curves(
                level[None], np.array([[a + 1, b]]), slice(a + 1, b), h
            )
            np.testing.assert_allclose(course, cubic(inside), rtol=1e-9, atol=1e-9 * n)


def test_even_motion_departs_by_nothing_and_an_error_inside_by_itself():
    line = 0.3 + 0.01 * np.arange(900.0)
    for span in overlapping_frame_spans_by_length(FPS, len(line)):
        assert np.abs(span.departures(line)).max() < 1e-9
        weights = hermite_bridge_frame_weights(0.5, span.length, span.reach)
        assert sum(weights) == pytest.approx(1.0)
        a = 3 * span.step + span.reach
        error = line.copy()
        error[a + 1 : a + span.length] += THIRTY
        np.testing.assert_allclose(span.departures(error)[:, 3], THIRTY, atol=1e-9)


def test_the_natural_share_is_what_goes_with_the_sum():
    total = RNG.standard_normal((3, 400))
    shares = np.array([0.0, 1.0, 0.3])
    x = shares[:, None] * total
    x[:, 50:90] += THIRTY  # errors have no say
    clean = np.ones(x.shape, dtype=bool)
    np.testing.assert_allclose(fit_parent_share_of_twist(x, total, clean), shares, atol=0.02)
    clean[:, 50:90] = False
    np.testing.assert_allclose(fit_parent_share_of_twist(x, total, clean), shares, atol=1e-3)


def test_an_error_changes_the_sum_of_both_twists_by_nothing():
    motion = clip("walk.bvh", "rich")
    chain = chain_of(motion, "LeftArm")
    full, dirty = erring(motion, "LeftArm", 100, SHAPES["noise"])
    sums = [np.sum(parent_and_child_twist_increments(m, chain), axis=0) for m in (motion, dirty)]
    np.testing.assert_allclose(sums[0], sums[1], atol=1e-9)
    x = [np.cumsum(parent_and_child_twist_increments(m, chain)[0]) for m in (motion, dirty)]
    np.testing.assert_allclose(x[1] - x[0], full, atol=1e-9)


def test_scales_grow_with_the_span_and_frames_told_bad_have_no_say():
    motion = clip("walk.bvh", "rich")
    chain = chain_of(motion, "LeftArm")
    x, y = (v[None] for v in parent_and_child_twist_increments(motion, chain))
    every = overlapping_frame_spans_by_length(FPS, motion.frames)
    nowhere = np.zeros(x.shape, dtype=bool)
    natural = natural_twist_departure_scales(x, y, FPS, every, nowhere)
    middle = [float(np.median(n.sigma[1])) for n in natural]
    assert middle[-1] > 20.0 * middle[0]
    jolted = x.copy()
    jolted[0, 150:160] += np.radians(8.0)
    bad = nowhere.copy()
    bad[0, 150:160] = True
    found = natural_twist_departure_scales(jolted, y, FPS, every, bad)
    untold = natural_twist_departure_scales(jolted, y, FPS, every, nowhere)
    assert float(np.median(found[2].sigma[1])) < 1.3 * middle[2]
    at = np.abs(every[2].step * np.arange(found[2].sigma.shape[-1]) - 150) < 20
    assert untold[2].sigma[1, 0, at].mean() > 1.05 * found[2].sigma[1, 0, at].mean()


# Softened levels


def test_kernels_are_a_ramp_and_a_zero_phase_butterworth():
    t = np.linspace(-3.0, 3.0, 601)
    for kernel in KERNELS:
        np.testing.assert_allclose(kernel(t) + kernel(-t), 1.0, atol=2e-2)
        np.testing.assert_allclose(kernel(np.array([-9.0, 9.0])), [0.0, 1.0], atol=1e-6)
    np.testing.assert_allclose(
        linear_unit_ramp(np.array([-0.5, -0.25, 0.0, 0.5])), [0.0, 0.25, 0.5, 1.0]
    )
    expected = low_passed(np.ones(400), 10.0)
    frames = np.arange(len(expected)) - 40 + 0.5
    np.testing.assert_allclose(
        butterworth_filtered_unit_step(frames[:200] / 12.0), expected[:200], atol=4e-3
    )


@pytest.mark.parametrize("kernel", KERNELS)
def test_the_level_that_was_softened_is_found_again(kernel):
    truth = softened_level_curves(np.array([[0.5, 30.5, 61.5, 11.0]]), kernel, 100)[0]
    start = guess_softened_level(truth)
    assert start.size == pytest.approx(0.5, abs=0.06)
    away = Level(0.4, start.onset + 3.0, start.end - 3.0, 5.0)

    def residuals(courses, wider):
        sigma = np.radians(0.2) * wider
        return (courses - truth) / sigma, np.ones_like(courses) / sigma

    ((found, left),) = fit_softened_levels([(away, kernel, 20.0)], 100, lambda c: c, residuals)
    np.testing.assert_allclose(found, truth, atol=np.radians(0.1))
    assert left < 1.0
    assert guess_softened_level(np.zeros(50)) is None
