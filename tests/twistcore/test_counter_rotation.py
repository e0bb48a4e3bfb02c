"""Counter-rotations, beside plain ones: each limb by itself, every frame in every round anew."""

from bisect import bisect_left, bisect_right
from functools import cache

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.detection.consistency.detector import _alike, _limbs, _lines
from twistcore.detection.counter_twist.counter_rotation import (
    combine_counter_rotation_residuals,
    counter_rotation,
)
from twistcore.detection.counter_twist.coupling import remove_neighbour_errors
from twistcore.detection.limbs import Limbs
from twistcore.detection.prediction import (
    GapGrowth,
    interpolate_sigma_growth_over_gaps,
    local_sigma_of_increment_residuals,
    residual_from_coarse_median,
    residual_sigma_half_window_frames,
)
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import wrap
from twistcore.synthesis import InjectedError, add_twist_from_opposite_side, inject

FRAMES = 150


@cache
def made(kind):
    """Limbs of a walk, some with errors, and where it is cut."""
    walk = read_bvh(ASSETS / "walk.bvh").motion.sliced(1, FRAMES + 1)
    chains = find_chains(walk)
    if "rich" in kind:
        walk = add_twist_from_opposite_side(walk, chains)
    rng = np.random.default_rng(len(kind))
    errors = []
    for chain in chains[::2] if "some" in kind else chains:
        for start in (14, 60, 105):
            length = int(rng.integers(1, 20))
            offset = np.full(length, rng.uniform(-2.8, 2.8))
            if length > 8:
                offset[:4] *= np.arange(1, 5) / 5.0
            errors.append(InjectedError(chain.name, start, start + length, offset))
    if "clean" not in kind:
        walk = inject(walk, chains, errors)
    cut = np.zeros(FRAMES, dtype=bool)
    cut[:1] = True
    if "cut" in kind:
        walk = walk.with_rotations(np.roll(walk.rotations, 47, axis=0))
        cut[[47, 90, 91]] = True
    return [_limbs(lines, walk) for lines in _alike(_lines(chains))], walk.fps, cut


KINDS = ("clean", "some", "all", "rich some", "rich all", "rich some cut")


def lagrange(places, values):
    """At 0, of the polynomial through values at places."""
    total = 0.0
    for place, value in zip(places, values, strict=True):
        for other in places:
            if other != place:
                value *= other / (other - place)
        total += value
    return total


def predicted(signal, good):
    """Cubic and linear prediction of every frame from good ones, and the gaps, (3, frames)."""
    known, out, signal = np.flatnonzero(good).tolist(), [], signal.tolist()
    for t in range(len(signal)):
        first = bisect_left(known, t)
        before, behind = known[max(first - 2, 0) : first], known[bisect_right(known, t) :][:2]
        if before and behind:
            near = [before[-1], behind[0]]
            linear = cubic = lagrange([k - t for k in near], [signal[k] for k in near])
            if len(before) + len(behind) == 4:
                near = before + behind
                cubic = lagrange([k - t for k in near], [signal[k] for k in near])
            out.append((cubic, linear, behind[0] - before[-1] - 1.0))
        else:
            side = before[::-1] or behind
            mean = sum(signal[k] for k in side) / max(len(side), 1)
            out.append((mean, mean, 2.0 * abs(side[0] - t) if side else len(signal)))
    return np.array(out).T


def judged(residual, sigma, least, least_lone):
    """Events, lone jumps, and where x and y disagree."""
    variance = sigma**2
    apart = wrap(residual[0] + residual[1])
    d = wrap(residual[0] - apart * variance[0] / variance.sum(axis=0))
    sigma_d = 1.0 / np.sqrt((1.0 / variance).sum(axis=0))
    denied = np.abs(apart) > 0.4 * np.abs(d) + 3.0 * np.sqrt(variance.sum(axis=0))
    lone = (np.abs(residual) > least_lone * sigma).any(axis=0)
    return (np.abs(d) > least * sigma_d) & ~denied, lone, denied


def plain(limb, fps, cut):
    """Residuals, scales, events and lone jumps of one limb."""
    captured = limb.increments()
    half, live = residual_sigma_half_window_frames(fps), np.broadcast_to(~cut, captured.shape[1:])
    good = live
    for steps in (4, 4, 7, 7):
        residual = residual_from_coarse_median(captured, steps)
        sigma = local_sigma_of_increment_residuals(np.sqrt(np.abs(residual)), good, half)
        event, lone, _ = judged(residual, sigma, 3.0, 8.0)
        good = good & ~event & ~lone
    signals = captured
    for turn in range(6):
        ways = np.array([[predicted(v, g) for v, g in zip(s, good, strict=True)] for s in signals])
        cubic, linear, gap = ways.transpose(2, 0, 1, 3)
        if turn <= 1:
            roots = [(np.sqrt(np.abs(wrap(signals - p))) * good).sum(-1) for p in (cubic, linear)]
            fits = (roots[0] < roots[1])[..., None]
            growth = GapGrowth(captured, fits).measured(good)
        course = np.where(fits, cubic, linear)
        root = np.sqrt(np.abs(wrap(signals - course)))
        sigma = local_sigma_of_increment_residuals(root, good & (gap[0] < 4.0), half)
        for chain in range(len(good)):
            at = np.flatnonzero(gap[0, chain] > 1.0)
            of = np.full(len(at), chain)
            sigma[:, chain, at] *= interpolate_sigma_growth_over_gaps(growth, of, gap[0, chain, at])
        residual = wrap(captured - course)
        if turn and len(limb) > 1:
            jumping = (np.abs(residual) > 4.0 * sigma).any(axis=(0, 1)) & ~cut
            t = np.flatnonzero(jumping)
            signals = captured.copy()
            if len(t):
                given = captured[..., t], course[..., t], sigma[..., t]
                signals[..., t] = remove_neighbour_errors(limb, t, *given)
            residual = wrap(signals - course)
        event, lone, denied = judged(residual, sigma, 4.0, 6.0)
        before, good = good, live & ~event & ~(lone & denied)
        if turn > 1 and (good == before).all():
            break
    return residual, sigma, event & live, lone & live


@pytest.mark.parametrize("kind", KINDS)
def test_limbs_at_once_are_as_each_by_itself_and_every_frame_anew(kind):
    limbs_of_all, fps, cut = made(kind)
    for limbs in limbs_of_all:
        found = counter_rotation(limbs, fps, cut)
        captured = limbs.increments()
        np.testing.assert_array_equal((found.x, found.y), captured)
        for i in range(limbs.count):
            rows = np.arange(i, len(found.x), limbs.count)
            axes = limbs.axes[:, i : i + 1]
            residual, sigma, event, lone = plain(Limbs(limbs.joints[:, i : i + 1], axes), fps, cut)
            np.testing.assert_array_equal(found.event[rows], event)
            np.testing.assert_array_equal(found.lone[rows], lone)
            np.testing.assert_allclose((found.rx[rows], found.ry[rows]), residual, atol=1e-7)
            scales = found.sigma_x[rows], found.sigma_y[rows]
            np.testing.assert_allclose(scales, sigma, rtol=1e-6)
            d, _, sigma_d, _ = combine_counter_rotation_residuals(residual, sigma)
            np.testing.assert_allclose(found.d[rows], np.where(cut, 0.0, d), atol=1e-7)
            np.testing.assert_allclose(found.sigma[rows], sigma_d, rtol=1e-6)


def test_what_is_compared_has_events_lone_jumps_and_limbs_that_settle_late():
    """Or the comparison would say little."""
    found = [counter_rotation(l, f, c) for ls, f, c in map(made, KINDS) for l in ls]  # noqa: E741
    assert sum(int(f.event.sum()) for f in found) > 300
    assert sum(int((f.lone & ~f.event).sum()) for f in found) > 10


def test_it_is_told_how_far_the_rounds_are():
    limbs, fps, cut = made("some")
    told: list[float] = []
    counter_rotation(limbs[0], fps, cut, told.append)
    assert 3 <= len(told) <= 6
    np.testing.assert_allclose(told, np.arange(len(told)) / 6)


def test_the_common_turn_is_the_mean_by_inverse_variance_on_the_circle():
    rng = np.random.default_rng(2)
    sigma = rng.uniform(0.01, 0.2, (2, 50))
    turn = rng.uniform(-np.pi, np.pi, 50)
    noise = 0.1 * rng.standard_normal((2, 50))
    residual = wrap(np.stack([turn + noise[0], -turn + noise[1]]))
    weight = 1.0 / sigma**2
    mean = turn + (weight[0] * noise[0] - weight[1] * noise[1]) / weight.sum(axis=0)
    d, apart, sigma_d, sigma_apart = combine_counter_rotation_residuals(residual, sigma)
    np.testing.assert_allclose(wrap(d - mean), 0.0, atol=1e-12)
    np.testing.assert_allclose(apart, noise.sum(axis=0), atol=1e-12)
    np.testing.assert_allclose(sigma_d, weight.sum(axis=0) ** -0.5)
    np.testing.assert_allclose(sigma_apart, np.hypot(*sigma))
