"""Predictions and scales of natural motion, beside plain ones that are made frame by frame."""

import numpy as np
import pytest

from twistcore.detection.prediction import (
    FLOOR,
    GapGrowth,
    Predictor,
    interpolate_sigma_growth_over_gaps,
    local_sigma_of_increment_residuals,
    residual_from_coarse_median,
    residual_sigma_half_window_frames,
)
from twistcore.skeleton.rotation import wrap


def signals(chains=3, frames=60, seed=0, size=0.3):
    rng = np.random.default_rng(seed)
    rate, phase = rng.uniform(0.05, 0.4, (2, chains, 1)), rng.uniform(0.0, 6.0, (2, chains, 1))
    found = size * np.sin(rate * np.arange(frames) + phase)
    return found + 0.01 * rng.standard_normal(found.shape)


def some(shape, share, seed=0):
    return np.random.default_rng(seed).random(shape) < share


def test_the_window_of_the_scale_is_a_time_and_never_few_frames():
    assert [residual_sigma_half_window_frames(fps) for fps in (24.0, 30.0, 120.0, 240.0)] == [
        12,
        12,
        18,
        36,
    ]


@pytest.mark.parametrize("step", [1, 4, 7])
@pytest.mark.parametrize("frames", [1, 3, 40])
def test_coarse_residuals_are_off_the_median_of_five(step, frames):
    given = signals(frames=frames, size=3.0)
    at = np.arange(frames) + step * np.arange(-2, 3)[:, None]
    median = np.median(given[..., at.clip(0, frames - 1)], axis=2)
    np.testing.assert_allclose(
        residual_from_coarse_median(given, step), wrap(given - median), atol=1e-12
    )


def plain_scale(residual, good, half):
    """σ of one signal of one chain."""
    frames = len(residual)
    root, found = np.sqrt(np.abs(residual)), np.empty(frames)
    overall = root[good].sum() / max(good.sum(), 1)
    for t in range(frames):
        near = [k for k in range(max(t - half, 0), min(t + half + 1, frames)) if good[k]]
        wide = [k for k in range(max(t - 4 * half, 0), min(t + 4 * half + 1, frames)) if good[k]]
        lent = (root[wide].sum() + 2.0 * overall) / (len(wide) + 2.0)
        lacking = max(0.5 * half - len(near), 0.0)
        found[t] = (root[near].sum() + lacking * lent) / (len(near) + lacking)
    return np.maximum(1.48 * found**2, FLOOR)


@pytest.mark.parametrize("share", [0.0, 0.1, 0.3, 0.7, 1.0])
@pytest.mark.parametrize("half", [4, 12])
def test_a_scale_is_that_of_the_good_frames_around_and_borrows_where_they_are_few(share, half):
    residual, good = signals(2, 90), some((2, 90), share)
    good[0, 20:60] = False
    found = local_sigma_of_increment_residuals(np.sqrt(np.abs(residual)), good, half)
    for s in range(2):
        for c in range(2):
            wanted = plain_scale(residual[s, c], good[c], half)
            np.testing.assert_allclose(found[s, c], wanted, rtol=1e-9)


def test_the_scale_of_normal_noise_is_its_standard_deviation():
    noise = 0.01 * np.random.default_rng(5).standard_normal((2, 1, 20000))
    found = local_sigma_of_increment_residuals(
        np.sqrt(np.abs(noise)), np.ones((1, 20000), dtype=bool), 5000
    )
    np.testing.assert_allclose(found[:, :, 10000], 0.01, rtol=0.05)


def plain_neighbours(good, t):
    """The two good frames before t and the two after it, the nearer first."""
    before = [k for k in range(t - 1, -1, -1) if good[k]][:2]
    behind = [k for k in range(t + 1, len(good)) if good[k]][:2]
    return before, behind


def plain_predictions(signal, good, t):
    """Cubic and linear prediction of a frame, and the gap that they bridge."""
    before, behind = plain_neighbours(good, t)
    if before and behind:
        at = [behind[0], before[0]]
        share = (t - before[0]) / (behind[0] - before[0])
        linear = share * signal[behind[0]] + (1.0 - share) * signal[before[0]]
        gap = behind[0] - before[0] - 1.0
        at = [*before, *behind]
        if len(at) < 4:
            return linear, linear, gap
        fit = np.polynomial.Polynomial.fit(np.array(at) - t, signal[at], 3)
        return fit(0.0), linear, gap
    if not (before or behind):
        return 0.0, 0.0, len(good)
    side = before or behind
    mean = signal[side].mean()
    return mean, mean, 2.0 * abs(side[0] - t)


@pytest.mark.parametrize("share", [0.0, 0.05, 0.4, 0.9])
def test_irregular_frames_are_predicted_by_their_good_neighbours(share):
    given, good = signals(3, 40), some((3, 40), share)
    changed = some((3, 40), 0.05, seed=1)
    p = Predictor(given).irregular(good, changed, given)
    cubic, linear = p.predicted(p.cubic), p.predicted(p.linear)
    seen = set()
    for n, (chain, t) in enumerate(zip(*np.divmod(p.at, 40), strict=True)):
        seen.add((int(chain), int(t)))
        for s in range(2):
            wanted = plain_predictions(given[s, chain], good[chain], t)
            np.testing.assert_allclose((cubic[s, n], linear[s, n]), wanted[:2], atol=1e-9)
            assert p.gap[n] == wanted[2]
    for chain in range(3):
        for t in range(40):
            near = slice(max(t - 2, 0), t + 3)
            kept = good[chain, near].all() and not changed[chain, near].any()
            assert ((chain, t) in seen) is not (kept and 2 <= t < 38)


@pytest.mark.parametrize("frames", [1, 4, 5, 6, 40])
def test_regular_frames_are_predicted_by_the_four_beside_them(frames):
    given, good = signals(2, frames), np.ones(frames, dtype=bool)
    p = Predictor(given)
    for s in range(2):
        for chain in range(2):
            for t in range(2, frames - 2):
                cubic, linear, _ = plain_predictions(given[s, chain], good, t)
                np.testing.assert_allclose(p.cubic[s, chain, t], cubic, atol=1e-12)
                np.testing.assert_allclose(p.linear[s, chain, t], linear, atol=1e-12)
    ends = np.r_[0 : min(2, frames), max(frames - 2, 0) : frames]
    assert not p.cubic[..., ends].any()
    assert not p.linear[..., ends].any()
    np.testing.assert_allclose(p.cubic_root**2, np.abs(wrap(given - p.cubic)), atol=1e-12)
    np.testing.assert_allclose(p.linear_root**2, np.abs(wrap(given - p.linear)), atol=1e-12)


def test_of_x_and_y_each_has_weights_of_its_own():
    given = signals(2, 30)
    p = Predictor(given).irregular(some((2, 30), 0.6), np.zeros((2, 30), dtype=bool), given)
    both = p.predicted(np.stack([p.cubic, p.linear]))
    np.testing.assert_allclose(both[0], p.predicted(p.cubic)[0])
    np.testing.assert_allclose(both[1], p.predicted(p.linear)[1])


def plain_growth(signal, good, cubic):
    """Growth of σ at gaps of 1, 3, 5, 9 frames, from the errors in the middle of such gaps."""
    frames, sizes = len(signal), []
    for k in (1, 2, 3, 5):
        if frames <= 2 * k + 12:
            sizes.append(2.0 * sizes[-1] if sizes else 1.0)
            continue
        roots = []
        for t in range(k + 1, frames - k - 1):
            if not (good[t] and good[t - k] and good[t + k]):
                continue
            at = [t - k - 1, t - k, t + k, t + k + 1] if cubic else [t - k, t + k]
            fit = np.polynomial.Polynomial.fit(np.array(at) - t, signal[at], len(at) - 1)
            roots.append(np.sqrt(abs(signal[t] - fit(0.0))))
        sizes.append((sum(roots) / max(len(roots), 1)) ** 2 + 0.3 * FLOOR)
    return np.maximum.accumulate(np.array(sizes) / sizes[0])


@pytest.mark.parametrize("frames", [10, 14, 15, 16, 17, 18, 19, 22, 23, 60])
def test_growth_over_gaps_is_measured_in_the_clip(frames):
    given, good = signals(2, frames), some((2, frames), 0.9)
    cubic = np.array([[[True], [False]], [[False], [True]]])
    found = GapGrowth(given, cubic).measured(good)
    for s in range(2):
        for chain in range(2):
            wanted = plain_growth(given[s, chain], good[chain], cubic[s, chain, 0])
            np.testing.assert_allclose(found[s, chain], wanted, rtol=1e-6)


def test_growth_is_measured_at_one_position_too():
    given, good = signals(1, 17), np.zeros((1, 17), dtype=bool)
    good[0, [5, 6, 7, 9]] = True  # a gap of 1 at frame 6, one of 3 at frame 7
    cubic = np.zeros((2, 1, 1), dtype=bool)
    found = GapGrowth(given, cubic).measured(good)
    for s in range(2):
        np.testing.assert_allclose(found[s, 0], plain_growth(given[s, 0], good[0], cubic=False))


def test_growth_at_a_gap_lies_between_the_measured_ones_by_logarithms():
    growth = np.array([[[1.0, 2.0, 5.0, 7.0], [1.0, 3.0, 3.0, 8.0]]] * 2)
    growth[1] **= 2.0
    gap = np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 9.0, 40.0] * 2)
    chain = np.repeat([0, 1], 8)
    found = interpolate_sigma_growth_over_gaps(growth, chain, gap)
    for s in range(2):
        for n, (c, g) in enumerate(zip(chain.tolist(), gap.tolist(), strict=True)):
            x, y = np.log([1.0, 3.0, 5.0, 9.0]), np.log(growth[s, c])
            beyond = y[-1] + (y[-1] - y[-2]) / (x[-1] - x[-2]) * (np.log(g) - x[-1])
            wanted = beyond if g > 9.0 else np.interp(np.log(g), x, y)
            np.testing.assert_allclose(np.log(found[s, n]), wanted, atol=1e-12)
