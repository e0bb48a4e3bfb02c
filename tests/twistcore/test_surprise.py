"""Natural scales and surprise, beside plain ones that go position by position."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from twistcore.detection.limbs import Limbs
from twistcore.detection.soft_errors.departures import (
    natural_accumulated_twist_curves,
    overlapping_frame_spans_by_length,
)
from twistcore.detection.soft_errors.natural_scale import (
    fit_parent_share_of_twist,
    natural_twist_departure_cost,
    natural_twist_departure_scales,
    unnaturally_large_twist_increments,
)
from twistcore.detection.soft_errors.soft_search import twist_departure_costs_per_span
from twistcore.detection.soft_errors.surprise import Surprise
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle
from twistcore.skeleton.twist_increments import twist_increments

DEGREE = math.pi / 180.0
FLOOR = 0.005 * DEGREE
FRAMES = 150


def made(seed=0, moving=False, fps=120.0, cuts=(70,)):
    """Two limbs of three chains whose joints turn smoothly with some unrest."""
    rng = np.random.default_rng(seed)
    t = np.arange(FRAMES) / fps
    joints = np.empty((4, 2, FRAMES, 4))
    for k, i in np.ndindex(4, 2):
        way = rng.standard_normal(3)
        angle = rng.uniform(0.3, 1.0) * np.sin(rng.uniform(1.0, 6.0) * t + k)
        angle += 0.2 * DEGREE * rng.standard_normal(FRAMES)
        along = np.broadcast_to(way / np.linalg.norm(way), (FRAMES, 3))
        joints[k, i] = quaternion_from_axis_angle(along, angle)
    axes = rng.standard_normal((3, 2, FRAMES, 3) if moving else (3, 2, 3))
    if moving:
        axes = np.cumsum(0.02 * axes, axis=2) + rng.standard_normal((3, 2, 1, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    cut = np.zeros(FRAMES, dtype=bool)
    cut[[0, *cuts]] = True
    return Surprise(Limbs(joints, axes), fps, cut)


def bad_frames(rows, seed=1):
    bad = np.zeros((rows, FRAMES), dtype=bool)
    for row, start in enumerate(np.random.default_rng(seed).integers(0, 120, rows)):
        bad[row, start : start + 5 * row] = True
    return bad


# Natural scales


def plain_cost(z, cap=14.0):
    return min(3.0 * math.log1p(z * z / 5.0), cap)


def test_what_a_departure_costs():
    for z in (-40.0, -3.0, 0.0, 0.5, 2.0, 10.0, 22.0, 23.0, 1e6):
        assert natural_twist_departure_cost(np.array(z)) == pytest.approx(plain_cost(z))
        assert natural_twist_departure_cost(np.array(z), 3.0) == pytest.approx(plain_cost(z, 3.0))


def plain_share(x, total, clean):
    step, share = max(1, len(x) // 800), 0.5
    tiny = FLOOR * FLOOR * 1e-3
    for _ in range(8):
        above, below = 0.5 * tiny, tiny
        for a, b, c in zip(x[::step], total[::step], clean[::step], strict=True):
            weight = c / max(abs(a - share * b), FLOOR)
            above, below = above + weight * b * a, below + weight * b * b
        share = min(max(above / below, 0.0), 1.0)
    return share


@pytest.mark.parametrize("frames", [1, 30, 1599, 1600, 2500])
def test_the_share_is_that_of_the_least_absolute_values(frames):
    rng = np.random.default_rng(frames)
    total = 0.1 * rng.standard_normal((5, frames))
    x = np.array([0.0, 0.2, 0.6, 1.0, 1.3])[:, None] * total + 0.04 * rng.standard_normal(
        total.shape
    )
    clean = rng.random(total.shape) < 0.7
    wanted = [plain_share(*row) for row in zip(x, total, clean, strict=True)]
    np.testing.assert_allclose(fit_parent_share_of_twist(x, total, clean), wanted, atol=1e-9)
    nothing = np.zeros((1, 9))
    assert fit_parent_share_of_twist(nothing, nothing, nothing == 0.0) == 0.5


def plain_sigma(values, clean, window):
    root = [math.sqrt(abs(v)) * c for v, c in zip(values, clean, strict=True)]
    overall, out = sum(root) / max(sum(clean), 1), []
    for j in range(len(values)):
        near = range(max(j - window, 0), min(j + window + 1, len(values)))
        mean, share = (sum(v[i] for i in near) / len(near) for v in (root, clean))
        local = (mean + 0.15 * overall) / (share + 0.15)
        out.append(max(1.48 * (0.3 * overall + 0.7 * local) ** 2, FLOOR))
    return out


@pytest.mark.parametrize("bad_share", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_scales_are_those_of_clean_positions_or_of_the_span_before(fps, bad_share):
    rng = np.random.default_rng(5)
    x, y = np.radians(rng.standard_normal((2, 3, 400))) * [[0.1], [1.0], [0.01]]
    bad = rng.random(x.shape) < np.array([[bad_share], [0.5 * bad_share], [0.0]])
    if bad_share == 0.3:
        bad[0] = True
    every = overlapping_frame_spans_by_length(fps, 400)[:7]
    levels = np.cumsum(x, axis=1), np.cumsum(y, axis=1)
    before, lacked = None, False
    for span, found in zip(
        every, natural_twist_departure_scales(x, y, fps, every, bad), strict=True
    ):
        dx, dy = (span.departures(v) for v in levels)
        window = max(1, round(max(0.6 * fps, 1.5 * span.length) / span.step))
        for c in range(3):
            at = [span.step * j for j in range(dx.shape[-1])]
            clean = [not bad[c, a : a + span.support].any() for a in at]
            enough = sum(clean) >= max(12, 0.06 * len(at))
            total = dx[:, c] + dy[:, c]
            share = plain_share(dx[1, c], total[1], clean)
            if not enough and before is not None:
                lacked = True
                growth = (span.length / before.span.length) ** 1.7
                middles = [(a + (span.length - before.span.length) // 2) for a in at]
                near = [min(m // before.span.step, before.sigma.shape[-1] - 1) for m in middles]
                assert found.beta[c] == before.beta[c]
                np.testing.assert_allclose(found.sigma[:, c], growth * before.sigma[:, c, near])
                np.testing.assert_allclose(
                    found.sigma_sum[:, c], growth * before.sigma_sum[:, c, near]
                )
                continue
            assert found.beta[c] == pytest.approx(share, abs=1e-7)
            used = clean if enough else [True] * len(at)
            for probe in (0, 2):
                rest = dx[probe, c] - share * total[probe]
                np.testing.assert_allclose(
                    found.sigma[probe, c], plain_sigma(rest, used, window), rtol=1e-5
                )
                np.testing.assert_allclose(
                    found.sigma_sum[probe, c], plain_sigma(total[probe], used, window), rtol=1e-5
                )
        u, sums = found.rest(dx, dy)
        np.testing.assert_allclose(sums, dx + dy)
        np.testing.assert_allclose(u[:, 1], dx[:, 1] - found.beta[1] * sums[:, 1])
        z = sums / found.sigma_sum
        np.testing.assert_allclose(found.spread(sums), found.sigma * np.sqrt((4.0 + z * z) / 5.0))
        before = found
    assert lacked == (bad_share == 0.3 or (bad_share > 0.0 and fps == 120.0))


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_increments_that_stand_out_by_themselves(fps):
    rng = np.random.default_rng(8)
    x, y = np.radians(0.2 * rng.standard_normal((2, 3, 200)))
    x[:, ::23] += 2.0 * DEGREE
    y[:, ::23] -= 2.0 * DEGREE
    x[:, 5::31] += 0.9 * DEGREE
    y[:, 5::31] -= 0.9 * DEGREE
    x[1, 60:100] *= 5.0
    x[2, rng.random(200) < 0.8] = y[2] = 0.0
    found = unnaturally_large_twist_increments(x, y, fps)
    half = round(0.6 * fps)
    for c in range(3):
        total = x[c] + y[c]
        size = np.abs(x[c] - plain_share(x[c], total, [True] * 200) * total)
        quiet = 2.2 * np.quantile(size, 0.35)
        sigma = np.full(200, max(quiet, 0.5 * FLOOR))
        for _ in range(3):
            fine, now = size < 6.0 * sigma, []
            for t in range(200):
                near = slice(max(t - half, 0), t + half + 1)
                mean = np.mean(np.sqrt(size[near]) * fine[near])
                local = (mean + 0.1 * math.sqrt(quiet / 1.48)) / (np.mean(fine[near]) + 0.1)
                now.append(max(1.48 * local**2, 0.5 * FLOOR))
            sigma = np.array(now)
        np.testing.assert_array_equal(found[c], size > 6.0 * sigma)
    assert 5 < found.sum() < 100


# Spans


@pytest.mark.parametrize(("fps", "reach", "lengths"), [
    (120.0, 2, [8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256, 384]),
    (30.0, 1, [3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96]), (24.0, 1, [3, 5, 6, 10, 13, 19, 26, 38]),
])  # fmt: skip
def test_spans_fit_a_clip_twice(fps, reach, lengths):
    found = overlapping_frame_spans_by_length(fps, 2 * (lengths[-1] + 2 * reach + 1))
    assert [s.length for s in found] == lengths
    assert {s.reach for s in found} == {reach}
    assert [s.step for s in found] == [max(1, n // 4) for n in lengths]
    assert (
        len(overlapping_frame_spans_by_length(fps, 2 * (lengths[-1] + 2 * reach + 1) - 1))
        == len(lengths) - 1
    )
    for s in found:
        counted = [f for f in range(0, 900, s.step) if f + s.length + 2 * reach + 1 <= 900]
        assert s.count(900) == len(counted)
        assert s.count(s.support - 1) == 0
        assert s.count(s.support) == 1


def plain_bridge(level, start, stop, reach):
    first, last = start - 1, stop
    before, behind = min(reach, first), min(reach, len(level) - 1 - last)
    mean = (level[last] - level[first]) / (last - first)
    slopes = (
        (level[first] - level[first - before]) / before if before else mean,
        (level[last + behind] - level[last]) / behind if behind else mean,
    )
    cubic = CubicHermiteSpline([first, last], [level[first], level[last]], slopes)
    return cubic(np.arange(start, stop))


@pytest.mark.parametrize(
    ("start", "stop"), [(1, 20), (2, 4), (3, 99), (50, 98), (50, 97), (40, 60)]
)
@pytest.mark.parametrize("reach", [1, 2, 5])
def test_a_bridge_at_a_clips_ends_has_the_slopes_that_are_left(start, stop, reach):
    level = np.random.default_rng(4).standard_normal((2, 100)).cumsum(axis=1)
    ranges = np.array([[start, stop]] * 2)
    found = natural_accumulated_twist_curves(level, ranges, slice(start, stop), reach)
    for row in range(2):
        np.testing.assert_allclose(found[row], plain_bridge(level[row], start, stop, reach))


# Surprise


def test_rows_are_chains_of_limbs():
    s = made()
    assert (s.rows, s.frames) == (6, FRAMES)
    assert [s.neighbours(r) for r in range(6)] == [
        [0, 2],
        [1, 3],
        [0, 2, 4],
        [1, 3, 5],
        [2, 4],
        [3, 5],
    ]
    assert [s.limb(r) for r in (0, 1, 3, 4)] == [[0, 2, 4], [1, 3, 5], [1, 3, 5], [0, 2, 4]]
    assert not s.x[:, s.cut].any()
    assert not s.y[:, s.cut].any()
    assert s.x[:, ~s.cut].all()


def assert_measured(s, natural):
    """All is as it would be if it were measured anew, with the same natural scales."""
    for row in range(s.rows):
        k, i = divmod(row, 2)
        x, y = twist_increments(s.joints[k, i], s.joints[k + 1, i], s.limbs.axes[k, i])
        np.testing.assert_allclose(s.x[row], np.where(s.cut, 0.0, x), atol=1e-12)
        np.testing.assert_allclose(s.y[row], np.where(s.cut, 0.0, y), atol=1e-12)
    for a, n in zip(s.at, natural, strict=True):
        u, total = n.rest(*(n.span.departures(np.cumsum(v, axis=1)) for v in (s.x, s.y)))
        np.testing.assert_allclose(a.u, u, atol=1e-11)
        np.testing.assert_allclose(a.total, total, atol=1e-11)
        np.testing.assert_allclose(a.spread, n.spread(total), rtol=1e-7)
        for j, usable in enumerate(a.usable):
            under = s.cut[j * n.span.step + 1 : j * n.span.step + n.span.support]
            assert usable != under.any()


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize(
    ("row", "start", "frames"), [(0, 40, 30), (3, 0, 12), (5, 110, 40), (2, 70, 1)]
)
def test_an_error_is_taken_out_with_its_images_and_seen_anew(moving, row, start, frames):
    s = made(3, moving)
    bad = bad_frames(s.rows)
    s.measure(bad)
    natural = [a.natural for a in s.at]
    assert_measured(s, natural_twist_departure_scales(s.x, s.y, 120.0, s.spans, bad))
    offset = np.random.default_rng(row).uniform(-1.0, 1.0, frames)
    k, i = divmod(row, 2)
    wanted = s.joints.copy()
    for n, t in enumerate(range(start, start + frames)):
        axis = s.limbs.axes[k, i, t] if moving else s.limbs.axes[k, i]
        turn = np.array([math.cos(0.5 * offset[n]), *(math.sin(0.5 * offset[n]) * axis)])
        wanted[k, i, t] = multiply(wanted[k, i, t], turn * [1.0, -1.0, -1.0, -1.0])
        wanted[k + 1, i, t] = multiply(turn, wanted[k + 1, i, t])
    s.remove_error(row, start, offset)
    np.testing.assert_allclose(s.joints, wanted, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(s.joints, axis=-1), 1.0, atol=1e-15)
    s.update_departures(row, start, start + frames)
    assert_measured(s, natural)


def telling(s, length):
    found = [a for a in s.at if a.natural.span.length <= 2.0 * length]
    return found or s.at[:1]


def weight_of(a):
    return 0.175 * a.natural.span.step / max(a.natural.span.length / 4.0, 1.0)


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_the_surprise_of_a_stretch_is_that_of_the_spans_that_meet_it(fps):
    s = made(4, fps=fps)
    s.measure(bad_frames(s.rows))
    for row, low, high in ((0, 10, 30), (3, 0, 9), (4, 130, 150), (5, 60, 75), (1, 149, 150),
                           (2, 0, 150), (1, 40, 43)):  # fmt: skip
        wanted = price = 0.0
        for a in telling(s, high - low):
            span, n = a.natural.span, a.natural
            price += 3.0 * weight_of(a) / span.step
            for j in np.flatnonzero(a.usable).tolist():
                if span.step * j < high and span.step * j + span.support > low:
                    for probe in range(3):
                        at = probe, row, j
                        wanted += weight_of(a) * plain_cost(a.u[at] / a.spread[at])
                        wanted += weight_of(a) * plain_cost(a.total[at] / n.sigma_sum[at])
        assert s.of(row, low, high) == pytest.approx(wanted)
        assert s.weight_per_frame(high - low) == pytest.approx(price)


def test_gains_are_what_probes_say_that_depart_far_enough():
    s = made(6)
    for row, start in ((1, 30), (4, 90), (4, 110)):
        s.remove_error(row, start, np.full(9, 0.1))
        s.update_departures(row, start, start + 9)
    s.measure(bad_frames(s.rows))
    said = 0
    for k, a in enumerate(s.at):
        found = twist_departure_costs_per_span(s, k, np.array([1, 4]))
        for n, row in enumerate((1, 4)):
            for j in range(a.u.shape[-1]):
                u = a.u[:, row, j]
                far = a.usable[j] and np.abs(u).max() >= 1.5 * DEGREE
                probes = zip(u, a.spread[:, row, j], strict=True)
                wanted = far * sum(plain_cost(v / w, 20.0) for v, w in probes)
                assert found[n, j] == pytest.approx(wanted)
                said += far
    assert said > 20


@pytest.mark.parametrize(("start", "frames"), [(40, 20), (3, 10), (120, 25), (80, 3), (60, 40)])
def test_what_is_left_of_a_seed_once_an_error_is_taken_out(start, frames):
    s = made(7)
    s.remove_error(2, 50, np.full(9, 0.1))
    s.update_departures(2, 50, 59)
    s.measure(bad_frames(s.rows))
    rng = np.random.default_rng(start)
    for row in range(s.rows):
        offset = rng.uniform(-0.2, 0.2) * np.ones(frames) * rng.uniform(0.2, 1.0, frames)
        level = np.zeros(FRAMES)
        level[start : start + frames] = offset
        margin, most = max(6, frames // 2), 0.0
        for a in telling(s, frames):
            span = a.natural.span
            departs = span.departures(level)
            for j in np.flatnonzero(a.usable).tolist():
                begin, end = span.step * j, span.step * j + span.support
                if begin < start - margin or end > start + frames + margin:
                    continue
                u = a.u[:, row, j] - departs[:, j]
                if np.abs(u).max() >= 1.5 * DEGREE:
                    probes = zip(u, a.spread[:, row, j], strict=True)
                    most = max(most, sum(plain_cost(v / w, 20.0) for v, w in probes))
        assert s.seed_left(row, start, offset) == pytest.approx(most)


def test_what_departs_by_less_than_is_asked_for_is_no_seed_however_quiet_it_is_there():
    """Of each position by itself: another one in the same span may depart far."""
    s = made(7)
    s.remove_error(2, 50, np.full(9, 0.1))
    s.update_departures(2, 50, 59)
    s.measure(bad_frames(s.rows))
    nothing, most, small = np.full(20, 1e-9), 0.0, 0
    for a in s.at:
        a.u[..., ::2] *= 0.01
        far = np.abs(a.u).max(axis=0) >= 1.5 * DEGREE
        a.spread[...] = np.where(far, 0.2, 1e-4)
        span = a.natural.span
        if a in telling(s, 20):
            for j in np.flatnonzero(a.usable).tolist():
                if span.step * j >= 45 - 10 and span.step * j + span.support <= 65 + 10:
                    small += not far[2, j]
                    gain = sum(plain_cost(v / 0.2, 20.0) for v in a.u[:, 2, j])
                    most = max(most, gain * far[2, j])
    assert small > 5
    assert 0.0 < most < 30.0
    assert s.seed_left(2, 45, nothing) == pytest.approx(most)


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_a_free_offset_leaves_u_its_bridge(fps):
    s = made(9, fps=fps, cuts=())
    s.measure(bad_frames(s.rows))
    lengths = [a.natural.span.length for a in s.at]
    for row, start, stop in ((0, 1, 30), (2, 40, 48), (3, 60, 65), (5, 100, 149), (1, 90, 91),
                             (4, 2, 148), (4, 50, 80), (0, 20, 40)):  # fmt: skip
        level_x, level_y = np.cumsum(s.x[row]), np.cumsum(s.y[row])
        length = stop - start
        near = max((n for n in lengths if n < length), default=lengths[0])
        far = min((n for n in lengths if n >= length), default=lengths[-1])
        values = []
        for a in (s.at[lengths.index(near)], s.at[lengths.index(far)]):
            span, sigma = a.natural.span, a.natural.sigma
            j = min(max((start + stop - span.support) // 2 // span.step, 0), sigma.shape[-1] - 1)
            values.append((a.natural.beta[row], sigma[1, row, j]))
        share = 0.0
        if near != far:
            share = min(max(math.log(length / near) / math.log(far / near), 0.0), 1.0)
        beta = values[0][0] * (1.0 - share) + values[1][0] * share
        sigma = math.exp(math.log(values[0][1]) * (1 - share) + math.log(values[1][1]) * share)
        dx, dy = (
            v[start:stop] - plain_bridge(v, start, stop, s.spans[0].reach)
            for v in (level_x, level_y)
        )
        ranges = np.array([[start, stop], [60, 70]])
        low, high = min(start, 60), max(stop, 70)
        found, spread = s.free_offsets(row, ranges, low, high)
        wanted = np.zeros(high - low)
        wanted[start - low : stop - low] = dx - beta * (dx + dy)
        np.testing.assert_allclose(found[0], wanted, atol=1e-10)
        assert not found[1, : 60 - low].any()
        assert spread[0] == pytest.approx(sigma)
        assert [v[0] for v in s.scales(row, ranges)] == pytest.approx([beta, sigma])
