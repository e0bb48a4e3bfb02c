"""Levels that set in and end softly: courses by hand, guesses, and the level that fits best."""

import math

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.signal import butter, sosfiltfilt

from twistcore.detection.soft_errors import softened_level
from twistcore.detection.soft_errors.softened_level import (
    KERNELS,
    Level,
    butterworth_filtered_unit_step,
    fit_softened_levels,
    guess_softened_level,
    linear_unit_ramp,
    softened_level_curves,
)

FRAMES = 80


def test_a_ramp_rises_evenly_within_one_unit():
    t = np.array([-9.0, -0.5, -0.25, 0.0, 0.25, 0.5, 9.0])
    np.testing.assert_allclose(linear_unit_ramp(t), [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0])


@pytest.mark.parametrize("period", [20.0, 37.0])
def test_the_filtered_step_is_what_a_filter_run_both_ways_makes_of_it(period):
    step = np.r_[np.zeros(400), np.ones(400)]
    sos = butter(2, 1.0 / period, fs=1.0, output="sos")
    t = (np.arange(800) - 399.5) / period
    np.testing.assert_allclose(butterworth_filtered_unit_step(t), sosfiltfilt(sos, step), atol=6e-3)
    assert butterworth_filtered_unit_step(np.array(0.0)) == pytest.approx(0.5)
    away = math.pi * math.sqrt(2.0) * 0.1
    wanted = 0.5 * math.exp(-away) * math.cos(away)
    np.testing.assert_allclose(
        butterworth_filtered_unit_step(np.array([-0.1, 0.1])), [wanted, 1.0 - wanted]
    )


def test_levels_are_looked_at_as_ramps_and_as_filtered_ones():
    assert (linear_unit_ramp, butterworth_filtered_unit_step) == KERNELS


@pytest.mark.parametrize("kernel", [linear_unit_ramp, butterworth_filtered_unit_step])
def test_a_course_rises_at_its_onset_and_falls_at_its_end(kernel):
    levels = np.array([[0.5, 9.0, 21.0, 4.0], [-0.2, -3.0, 30.5, 11.0], [1.0, 5.0, 9.0, 0.1]])
    found = softened_level_curves(levels, kernel, 40)
    assert found.shape == (3, 40)
    for row, (size, onset, end, width) in zip(found, levels, strict=True):
        width = max(width, 0.5)
        for t in range(40):
            rises, falls = (kernel(np.array((t - at) / width)) for at in (onset, end))
            assert row[t] == pytest.approx(size * float(rises - falls))


def test_a_course_by_hand():
    (found,) = softened_level_curves(np.array([[2.0, 3.0, 8.0, 4.0]]), linear_unit_ramp, 12)
    wanted = [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0, 0.0]
    wanted[5:7] = [1.0, 1.0]
    wanted[7:10] = [0.75, 0.5, 0.25]
    np.testing.assert_allclose(found, 2.0 * np.array(wanted))


# Guesses


def plain_guess(offset):
    size = [abs(v) for v in offset]
    top = max(size)
    place = size.index(top)

    def ends(share):
        above = [t for t, v in enumerate(size) if v > share * top]
        return above[0], above[-1]

    (first, last), (low, below), (high, behind) = ends(0.5), ends(0.2), ends(0.8)
    width = 0.5 * ((high - low) + (below - behind)) / 0.6
    return offset[place], first - 0.5, last + 0.5, max(width, 2.0)


@pytest.mark.parametrize("seed", range(6))
def test_a_level_is_guessed_by_where_an_offset_is_half_as_large(seed):
    rng = np.random.default_rng(seed)
    level = np.array([[rng.choice([-1, 1]) * rng.uniform(0.1, 2.0), 20.0, 45.0, 3.0 + 3.0 * seed]])
    (offset,) = softened_level_curves(level, linear_unit_ramp, FRAMES) + 0.01 * rng.standard_normal(
        FRAMES
    )
    found = guess_softened_level(offset)
    assert found == pytest.approx(plain_guess(offset.tolist()))
    assert isinstance(found, Level)
    assert guess_softened_level(np.full(9, -0.5)) == (-0.5, -0.5, 8.5, 2.0)
    assert guess_softened_level(np.array([0.1, 1.0, 0.1])) == (1.0, 0.5, 1.5, 2.0)


def test_a_level_is_not_guessed_where_nothing_rises():
    assert guess_softened_level(np.zeros(9)) is None
    assert guess_softened_level(np.ones(2)) is None
    assert guess_softened_level(np.ones(3)) == (1.0, -0.5, 2.5, 2.0)
    assert guess_softened_level(np.full(5, 1e-9)) is not None


# The best fit


def same(courses):
    """Departures that are the courses themselves."""
    return courses


def fitted(start, kernel, frames, residuals, coarsest):
    """Fit one level."""
    return fit_softened_levels([(start, kernel, coarsest)], frames, same, residuals)[0]


def residuals_of(wanted, spread=0.02, cap=math.inf):
    """Return a function for residuals of at most `cap` and their derivatives."""

    def of(courses, wider=1.0):
        z = (wanted - courses) / (spread * wider)
        return np.clip(z, -cap, cap), np.where(np.abs(z) < cap, -1.0 / (spread * wider), 0.0)

    return of


@pytest.mark.parametrize("kernel", [linear_unit_ramp, butterworth_filtered_unit_step])
@pytest.mark.parametrize("seed", range(4))
def test_the_level_is_found_that_leaves_the_least(kernel, seed):
    rng = np.random.default_rng(seed)
    truth = np.array([0.6, 22.3, 51.7, 9.4])
    (clean,) = softened_level_curves(truth[None], kernel, FRAMES)
    of = residuals_of(clean + 0.02 * rng.standard_normal(FRAMES))
    start = Level(0.45, 20.0, 54.0, 7.0)
    shape, left = fitted(start, kernel, FRAMES, of, 1.0)
    best = least_squares(
        lambda v: of(softened_level_curves(v[None], kernel, FRAMES))[0][0],
        truth,
        x_scale=[0.03, 1, 1, 1],
    )
    assert left == pytest.approx(2.0 * best.cost, abs=0.5)
    assert left == pytest.approx(float((of(shape[None])[0] ** 2).sum()))
    np.testing.assert_allclose(
        shape, softened_level_curves(best.x[None], kernel, FRAMES)[0], atol=0.02
    )


def test_what_fits_exactly_is_left_as_it_is():
    start = Level(0.6, 22.0, 51.0, 9.0)
    (wanted,) = softened_level_curves(np.array([start]), linear_unit_ramp, FRAMES)
    shape, left = fitted(start, linear_unit_ramp, FRAMES, residuals_of(wanted), 1.0)
    np.testing.assert_allclose(shape, wanted, atol=1e-12)
    assert left == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("coarsest", "widths"),
    [
        (0.3, [1.0]),
        (1.0, [1.0]),
        (4.0, [4.0, 1.0]),
        (5.0, [5.0, 1.0]),
        (30.0, [30.0, 6.0, 1.2, 1.0]),
    ],
)
def test_scales_are_wide_first_and_narrower_by_a_fifth(coarsest, widths):
    (wanted,) = softened_level_curves(np.array([[0.6, 22.0, 51.0, 9.0]]), linear_unit_ramp, FRAMES)
    of, asked = residuals_of(wanted), []

    def noted(courses, wider):
        assert np.ptp(wider) == 0.0
        asked.append(float(wider[0, 0]))
        return of(courses, wider)

    fitted(Level(0.5, 24.0, 50.0, 7.0), linear_unit_ramp, FRAMES, noted, coarsest)
    assert [w for k, w in enumerate(asked) if k == 0 or w != asked[k - 1]] == pytest.approx(widths)


def test_wide_scales_lead_where_every_residual_is_at_its_cap():
    (wanted,) = softened_level_curves(np.array([[1.0, 22.0, 51.0, 9.0]]), linear_unit_ramp, FRAMES)
    of = residuals_of(wanted, 0.01, cap=3.0)
    start = Level(0.5, 10.0, 65.0, 5.0)
    _, alone = fitted(start, linear_unit_ramp, FRAMES, of, 1.0)
    shape, left = fitted(start, linear_unit_ramp, FRAMES, of, 40.0)
    assert left < 0.1 < alone
    np.testing.assert_allclose(shape, wanted, atol=0.01)


def steps_of(kernel, start, of, frames):
    """Levenberg and Marquardt's steps, with the slopes of one number after the other."""
    scales = np.array([math.radians(2.0), 1.0, 1.0, 1.0])
    number = np.array(start) / scales
    at = tried = number
    damping, best, asked = 0.01, math.inf, 0
    for turn in range(12):
        here = softened_level_curves((tried * scales)[None], kernel, frames)[0]
        left, change = of(here, 1.0)
        asked += 1
        value = float(sum(v * v for v in left))
        if value < best:
            gained, best, at = best - value, value, tried
            damping = max(0.2 * damping, 1e-6)
            if gained < 0.05 or turn == 11:
                break
            slopes = []
            for k in range(4):
                by = 1e-3 * max(abs(at[k]), 1.0)
                changed = at.copy()
                changed[k] += by
                moved = softened_level_curves((changed * scales)[None], kernel, frames)[0]
                slopes.append(change * (moved - here) / by)
            curvature = [[float(a @ b) for a in slopes] for b in slopes]
            down = [float(a @ left) for a in slopes]
        else:
            damping *= 8.0
            if damping > 1e4:
                break
        damped = np.array(curvature)
        for k in range(4):
            damped[k, k] += damping * (curvature[k][k] + 1e-9)
        tried = at - np.linalg.solve(damped, down)
    return softened_level_curves((at * scales)[None], kernel, frames)[0], best, asked


@pytest.mark.parametrize("kernel", [linear_unit_ramp, butterworth_filtered_unit_step])
@pytest.mark.parametrize("cap", [2.0, 8.0, 1e9])
@pytest.mark.parametrize(
    "start", [(0.4, 15.0, 60.0, 3.0), (-0.2, 30.0, 40.0, 20.0), (0.6, 22.0, 50.0, 9.0)]
)
def test_the_steps_are_levenbergs_and_marquardts(kernel, cap, start):
    rng = np.random.default_rng(5)
    (wanted,) = softened_level_curves(np.array([[0.6, 22.3, 51.7, 9.4]]), kernel, FRAMES)
    of, asked = residuals_of(wanted + 0.01 * rng.standard_normal(FRAMES), 0.02, cap), []

    def noted(courses, wider):
        asked.append(len(courses))
        return of(courses, wider)

    shape, left = fitted(Level(*start), kernel, FRAMES, noted, 1.0)
    wanted_shape, wanted_left, many = steps_of(kernel, start, of, FRAMES)
    assert left == pytest.approx(wanted_left, rel=1e-6)
    np.testing.assert_allclose(shape, wanted_shape, atol=1e-6)
    assert len(asked) == many
    assert set(asked) == {1}


def test_no_more_steps_are_made_than_are_allowed(monkeypatch):
    (wanted,) = softened_level_curves(np.array([[0.6, 22.0, 51.0, 9.0]]), linear_unit_ramp, FRAMES)
    of, asked = residuals_of(wanted), []

    def noted(courses, wider):
        asked.append(len(courses))
        return of(courses, wider)

    monkeypatch.setattr(softened_level, "MOST_STEPS", 3)
    fitted(Level(0.2, 30.0, 45.0, 3.0), linear_unit_ramp, FRAMES, noted, 1.0)
    assert asked.count(1) == 3


def test_the_best_of_many_starts_is_as_good_as_alone_with_less_work():
    rng = np.random.default_rng(7)
    (wanted,) = softened_level_curves(np.array([[0.6, 22.3, 51.7, 9.4]]), linear_unit_ramp, FRAMES)
    of, asked = residuals_of(wanted + 0.01 * rng.standard_normal(FRAMES), 0.02, 8.0), []

    def noted(courses, wider):
        asked.append(len(courses))
        return of(courses, wider)

    starts = [
        (Level(0.4, 15.0, 60.0, 3.0), linear_unit_ramp, 1.0),
        (Level(-0.2, 30.0, 40.0, 20.0), butterworth_filtered_unit_step, 12.0),
        (Level(0.6, 22.0, 50.0, 9.0), butterworth_filtered_unit_step, 1.0),
        (Level(0.5, 24.0, 50.0, 7.0), linear_unit_ramp, 3.0),
    ]
    together = fit_softened_levels(starts, FRAMES, same, noted)
    calls, courses = len(asked), sum(asked)
    asked.clear()
    alone = [fitted(start, kernel, FRAMES, noted, wider) for start, kernel, wider in starts]
    for (_, left), (_, least) in zip(together, alone, strict=True):
        assert left >= least
    best, least = (min(found, key=lambda f: f[1]) for found in (together, alone))
    assert best[1] == least[1]
    np.testing.assert_array_equal(best[0], least[0])
    assert courses < sum(asked)
    assert calls < 0.7 * len(asked)
    assert fit_softened_levels([], FRAMES, same, of) == []


def test_a_fit_far_behind_the_best_is_given_up():
    (wanted,) = softened_level_curves(np.array([[0.6, 22.0, 51.0, 9.0]]), linear_unit_ramp, FRAMES)
    starts = [Level(0.55, 23.0, 50.0, 8.0), Level(-0.4, 60.0, 75.0, 3.0)]
    of = residuals_of(wanted, cap=3.0)
    best, behind = fit_softened_levels(
        [(start, linear_unit_ramp, 1.0) for start in starts], FRAMES, same, of
    )
    assert best[1] < 0.1
    assert behind[1] > 50.0
