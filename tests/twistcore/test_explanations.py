"""What explains a seed of a soft error, beside a plain search frame by frame."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.tiers import parametrize
from tests.twistcore.test_surprise import FRAMES, made
from twistcore.detection.soft_errors.explanations import (
    Explanations,
    Seed,
    _likely_levels,
    _proposed,
)
from twistcore.detection.soft_errors.softened_level import (
    Level,
    butterworth_filtered_unit_step,
    fit_softened_levels,
    guess_softened_level,
    linear_unit_ramp,
    softened_level_curves,
)

DEGREE = math.pi / 180.0
SHAPES = {
    "level": lambda n: np.ones(n),
    "ramps": lambda n: np.minimum(1.0, np.minimum(np.arange(1, n + 1), np.arange(n, 0, -1)) / 6.0),
    "bump": lambda n: np.sin(np.linspace(0.0, math.pi, n + 2))[1:-1] ** 2,
    "two": lambda n: np.where(np.abs(np.arange(n) - n / 2) < 3.0, 0.0, 1.0),
}


def erring(seed, degrees, shape="ramps", start=60, frames=30, row=2, fps=120.0):
    """A measured surprise with an error in a row."""
    s = made(seed, fps=fps, cuts=())
    s.remove_error(row, start, -degrees * DEGREE * SHAPES[shape](frames))
    s.update_departures(row, start, start + frames)
    bad = np.zeros((s.rows, FRAMES), dtype=bool)
    bad[s.neighbours(row), start : start + frames] = True
    s.measure(bad)
    return s


def seeds(surprise, row, middle, ranks=(0, 2, 4, 6)):
    """Seeds of some spans whose middle is nearest to a frame, as far as the clip reaches."""
    for k in ranks:
        if k < len(surprise.at):
            span = surprise.at[k].natural.span
            shift = span.reach + span.length // 2
            position = min(max(round((middle - shift) / span.step), 0), span.count(FRAMES) - 1)
            yield Seed(25.0, row, k, position, span.step * position + shift, span.length)


def free_offset(surprise, row, start, stop):
    """Return the free offset over one frame range, and its σ."""
    offsets, sigmas = surprise.free_offsets(row, np.array([[start, stop]]), start, stop)
    return offsets[0], float(sigmas[0])


# Where it may be


def plain_proposed(surprise, place):
    first, last = place.middle - place.length / 2, place.middle + place.length / 2
    found = set()
    for factor in (1.0, 1.3, 1.7, 2.4, 3.5):
        reach = factor * place.length / 2 + 3
        for before, behind in ((1.0, 1.0), (1.6, 0.7), (0.7, 1.6)):
            low = int(max(2, place.middle - before * reach))
            high = int(min(FRAMES - 3, place.middle + behind * reach))
            if high - low < 3:
                continue
            offset, sigma = free_offset(surprise, place.row, low, high)
            size = {low + n: abs(v) for n, v in enumerate(offset.tolist())}
            top = max((size.get(t, 0.0) for t in range(int(first), int(last))), default=0.0)
            if top < 0.75 * DEGREE:
                continue
            for least in (2.0 * sigma, 4.0 * sigma, 0.05 * top, 0.15 * top):
                above = min(max(least, 0.05 * DEGREE), 0.5 * top)
                runs = []
                for t in sorted(size):
                    if size[t] > above:
                        if runs and t - runs[-1][1] <= 3:
                            runs[-1][1] = t
                        else:
                            runs.append([t, t])
                found |= {
                    (a, b + 1) for a, b in runs
                    if a <= last and b >= first and b - a > place.length // 4
                }  # fmt: skip
    return found


CASES = [
    (0, 20.0, "level", 60, 30), (1, 6.0, "ramps", 60, 30), (2, 2.0, "bump", 50, 40),
    (3, 12.0, "two", 60, 30), (4, 20.0, "ramps", 4, 20), (5, -15.0, "bump", 120, 28),
    (6, 1.5, "level", 70, 9), (7, 40.0, "level", 30, 90),
]  # fmt: skip


@pytest.mark.parametrize(
    ("fps", "case"), [*((120.0, c) for c in CASES), (30.0, CASES[1]), (30.0, CASES[4])]
)
def test_frames_that_an_error_may_have(case, fps):
    seed, degrees, shape, start, frames = case
    s = erring(seed, degrees, shape, start, frames, fps=fps)
    many = 0
    for row in (2, 4):
        for middle in (start, start + frames // 2, start + frames + 4, 3, FRAMES - 3):
            for place in seeds(s, row, middle, (0, 3, 6)):
                found = _proposed(s, place)
                assert found == plain_proposed(s, place)
                assert all(type(v) is int for span in found for v in span)
                many += len(found)
    assert many > 5


# Levels that are tried


def plain_levels(stretch, length, middle):
    long = stretch.longer(0.6 * length)
    levels = []
    for n in (0.5, 0.7, 1.0, 1.4, 2.0, 2.8):
        for place in (-0.45, -0.3, -0.15, 0.0, 0.15, 0.3, 0.45):
            for onset in (0.2, 0.6):
                frames = n * length
                start = middle + place * max(frames, length) - 0.5 * frames
                if start > 0.0 and start + frames < stretch.frames:
                    levels.append((start, start + frames, max(onset * frames, 3.0)))
    out = []
    for wider in (1.0, 3.0):
        tried = []
        for begin, end, width in levels:
            shape = softened_level_curves(
                np.array([[1.0, begin, end, width]]), linear_unit_ramp, stretch.frames
            )
            (size,) = long.sizes(long.departures(shape), wider)
            left = float(long.surprise(long.departures(size * shape), wider)[0])
            tried.append((left, float(size), begin, end, width))
        out += [(min(tried)[1:], wider)] if tried else []
    return out


@pytest.mark.parametrize("case", CASES[1:4])
def test_the_levels_that_are_fitted_are_the_likeliest_of_many(case):
    seed, degrees, shape, start, frames = case
    s = erring(seed, degrees, shape, start, frames)
    for low, many in ((max(start - 20, 0), 80), (max(start - 4, 0), 30)):
        stretch = s.local_departures(2, low, min(many, FRAMES - low))
        for place in seeds(s, 2, start + frames // 2, (0, 4)):
            found = _likely_levels(stretch, place.length, place.middle - low)
            wanted = plain_levels(stretch, place.length, place.middle - low)
            assert [w for _, w in found] == [w for _, w in wanted]
            for (level, _), (plain, _) in zip(found, wanted, strict=True):
                assert isinstance(level, Level)
                assert level == pytest.approx(plain, rel=1e-3)
    stretch = s.local_departures(2, start, 12)
    assert _likely_levels(stretch, 384, 6) == []


# What explains it best


def plain_best(surprise, place, fit_below):
    """Start, offset, gain and σ of the best explanation; None where nothing gains enough."""
    spans = plain_proposed(surprise, place)
    if not spans:
        return None
    row = place.row
    longest = max(b - a for a, b in spans)
    margin = min(max(longest // 2, 8), 60)
    reach = min(3 * place.length, 96)
    low = max(min(min(a for a, _ in spans) - margin, place.middle - reach), 0)
    high = min(max(max(b for _, b in spans) + margin, place.middle + reach), FRAMES)
    stretch = surprise.local_departures(row, low, high - low)
    price = 4.0 * surprise.weight_per_frame(high - low)

    def left_by(shape):
        return float(stretch.surprise(stretch.departures(shape[None]))[0])

    known = {}

    def try_free(a, b):
        a, b = max(a, 1), min(b, FRAMES - 1)
        if low <= a < b <= high and (a, b) not in known:
            shape = np.zeros(high - low)
            shape[a - low : b - low], sigma = free_offset(surprise, row, a, b)
            known[a, b] = left_by(shape) + price * (b - a), shape, sigma
        return known.get((a, b))

    nothing = left_by(np.zeros(high - low))
    if nothing < 45.0:
        return None
    for a, b in sorted(spans):
        try_free(a, b)
    if not known:
        return None
    for moves in ((1, 3, 6, 10), (1, 2, 4), (1, 2, 4), (1, 2)):
        a, b = min(known, key=lambda p: known[p][0])
        for move in moves:
            for begin, end in ((a - move, b), (a + move, b), (a, b - move), (a, b + move)):
                try_free(begin, end)
    free = min(known.values(), key=lambda t: t[0])
    ratio = float(np.abs(free[1]).max()) / free[2]
    best = free
    if ratio < fit_below or nothing - free[0] < 45.0:
        rivals = [free] if ratio >= 10.0 else []
        starts = [(guess_softened_level(free[1]), ratio / 3.0)]
        starts += [
            (Level(*v), w) for v, w in plain_levels(stretch, place.length, place.middle - low)
        ]
        every = [
            (start, kernel, coarsest)
            for start, coarsest in starts
            if start is not None
            for kernel in (linear_unit_ramp, butterworth_filtered_unit_step)
        ]
        for shape, left in fit_softened_levels(
            every, high - low, stretch.departures, stretch.residuals
        ):
            rivals.append((left + 8.0, shape, 0.5 * free[2]))
            at = [low + t for t, v in enumerate(shape) if abs(v) > 0.05 * DEGREE]
            if ratio >= 10.0 and at and (again := try_free(at[0], at[-1] + 1)):
                rivals.append(again)
        if not rivals:
            return None
        best = min(rivals, key=lambda t: t[0])
    left, shape, sigma = best
    at = [t for t, v in enumerate(shape) if abs(v) > 0.05 * DEGREE]
    if nothing - left < 45.0 or not at or max(abs(shape)) < 2.0 * DEGREE:
        return None
    return low + at[0], shape[at[0] : at[-1] + 1], nothing - left, sigma


def explained_alike(surprise, place, fit_below):
    """Whether anything explains a seed, which must be what the plain search finds."""
    found = Explanations(surprise, place).best(fit_below)
    wanted = plain_best(surprise, place, fit_below)
    assert (found is None) == (wanted is None)
    if wanted is None:
        return False
    begin, offset, gain, sigma = wanted
    assert (found.row, found.start, len(found.offset)) == (place.row, begin, len(offset))
    np.testing.assert_allclose(found.offset, offset, atol=1e-7)
    assert found.gain == pytest.approx(gain, abs=1e-2)
    assert found.sigma == pytest.approx(sigma)
    assert (found.followed, found.unsure) == (1.0, False)
    return True


@parametrize(("fps", "case"), [(120.0, c) for c in CASES] + [(30.0, CASES[1])], quick=3)
def test_what_explains_a_seed_best(case, fps):
    seed, degrees, shape, start, frames = case
    s = erring(seed, degrees, shape, start, frames, fps=fps)
    explained = 0
    middle = start + frames // 2
    for row, near, k in ((2, middle, 4), (2, start, 1), (4, middle, 4)):
        for place in seeds(s, row, near, (k,)):
            explained += sum(explained_alike(s, place, below) for below in (10.0, math.inf))
    assert explained >= (0 if abs(degrees) < 3.0 or fps < 120.0 else 2)


@pytest.mark.parametrize(("start", "middle"), [(12, 16), (130, 134)])
def test_a_seed_is_looked_at_three_spans_around(start, middle):
    """However short an error: at either end of a clip only the other side reaches so far."""
    s = erring(0, 20.0, "level", start, 8)
    (place,) = seeds(s, 2, middle, (3,))
    assert explained_alike(s, place, 10.0)


@pytest.mark.parametrize(
    ("case", "k"), [((35, 40.0, "two", 46, 16), 5), ((13, 40.0, "ramps", 73, 63), 1)]
)
def test_an_offset_over_the_frames_of_a_level_may_leave_less(case, k):
    seed, degrees, shape, start, frames = case
    s = erring(seed, degrees, shape, start, frames)
    (place,) = seeds(s, 2, start + frames // 2, (k,))
    assert explained_alike(s, place, math.inf)


def test_an_offset_of_many_sigmas_is_taken_as_it_is_unless_a_level_is_asked_for():
    s = erring(1, 20.0, "ramps")
    (place,) = seeds(s, 2, 75, (4,))
    explained = Explanations(s, place)
    free, level = explained.best(10.0), explained.best(math.inf)
    wanted = np.zeros(FRAMES)
    wanted[60:90] = 20.0 * DEGREE * SHAPES["ramps"](30)
    for one in (free, level):
        at = slice(one.start, one.stop)
        np.testing.assert_allclose(one.offset, wanted[at], atol=2.0 * DEGREE)
    assert level.gain >= free.gain
    assert free.sigma in (level.sigma, 2.0 * level.sigma)


def test_nothing_is_explained_where_nothing_departs():
    s = made(3, cuts=())
    s.measure(np.zeros((s.rows, FRAMES), dtype=bool))
    for row in range(s.rows):
        for place in seeds(s, row, 75, (0, 4)):
            assert Explanations(s, place).best(math.inf) is None
    (place,) = seeds(s, 0, 75, (0,))
    assert Explanations(s, replace(place, middle=1, length=2)).best(math.inf) is None
