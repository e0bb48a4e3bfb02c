"""What is put together once for a stretch tells what each span tells by itself."""

import math

import numpy as np
import pytest

from tests.twistcore.test_soft_errors import SHAPES, clip, erring, surprise_of
from twistcore.detection.soft_errors.explanations import FREE_AT, Explanations, Seed
from twistcore.detection.soft_errors.natural_scale import natural_twist_departure_cost
from twistcore.detection.soft_errors.softened_level import linear_unit_ramp, softened_level_curves
from twistcore.detection.soft_errors.surprise import LONGEST

ROW, START, MIDDLE = "LeftArm", 150, 165
LEVELS = np.array([[0.5, 9.0, 21.0, 4.0], [-0.2, 1.0, 30.0, 11.0], [0.0, 5.0, 9.0, 3.0]])


@pytest.fixture(scope="module")
def measured():
    """A clip with a soft error in ROW and a cut behind it, measured; the row."""
    _, dirty = erring(clip("walk.bvh", "rich"), ROW, START, SHAPES["ramp of 8"])
    surprise, rows = surprise_of(dirty)
    surprise.cut[205] = True
    bad = np.zeros((surprise.rows, surprise.frames), dtype=bool)
    bad[:, START : START + 30] = True
    surprise.measure(bad)
    return surprise, rows[ROW]


def one_by_one(surprise, row, low, courses, wider, shortest):
    """Residuals of courses from the departures of whole levels, one span after the other."""
    frames = courses.shape[1]
    level = np.zeros((len(courses), surprise.frames))
    level[:, low : low + frames] = courses
    out = []
    for a in surprise.at:
        span = a.natural.span
        if not shortest <= span.length <= LONGEST * frames:
            continue
        first = span.step * np.arange(a.u.shape[-1])
        meets = (first < low + frames) & (first + span.support > low)
        departures = np.moveaxis(span.departures(level), 0, 1)[..., meets]
        z = (a.u[:, row, meets] - departures) / (wider * a.spread[:, row, meets])
        weight = surprise._weight(a) * a.usable[meets]
        out.append(np.sign(z) * np.sqrt(weight * natural_twist_departure_cost(z)))
    return np.concatenate(out, axis=2).reshape(len(courses), -1)


@pytest.mark.parametrize("low", [0, 140, 190, -32])  # at both ends, at the error, by the cut
@pytest.mark.parametrize(("wider", "shortest"), [(1.0, 0.0), (2.5, 13.0)])
def test_residuals_of_a_stretch_are_those_of_its_spans(measured, low, wider, shortest):
    surprise, row = measured
    low %= surprise.frames
    courses = softened_level_curves(LEVELS, linear_unit_ramp, 32)
    stretch = surprise.local_departures(row, low, 32).longer(shortest)
    found, changes = stretch.residuals(stretch.departures(courses), np.full((3, 1), wider))
    expected = one_by_one(surprise, row, low, courses, wider, shortest)
    assert found.shape == expected.shape
    assert found.shape[1] > 50
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-3)  # σ is at least 0.005°
    left = stretch.surprise(stretch.departures(courses), wider)
    np.testing.assert_allclose(left, (expected**2).sum(axis=1), rtol=1e-4)
    by, step = stretch.departures(courses), np.float32(1e-4)
    sides = [stretch.residuals(by + d, np.full((3, 1), wider))[0] for d in (-step, step)]
    slopes = (sides[1] - sides[0]) / (2.0 * step)
    smooth = np.abs(slopes - changes) < 0.05 * np.abs(slopes).max()  # not where the cost is capped
    assert smooth.mean() > 0.97


def test_no_span_tells_of_a_stretch_when_all_are_too_short(measured):
    surprise, row = measured
    stretch = surprise.local_departures(row, 100, 32).longer(1000.0)
    by = stretch.departures(np.ones((2, 32)))
    assert stretch.residuals(by, np.ones((2, 1)))[0].shape == (2, 0)
    assert stretch.sizes(by).tolist() == stretch.surprise(by).tolist() == [0.0, 0.0]


def seeds(surprise, row):
    for k in (2, 4, 6):
        span = surprise.at[k].natural.span
        position = (MIDDLE - span.support // 2) // span.step
        middle = span.step * position + span.reach + span.length // 2
        yield Seed(20.0, row, k, position, middle, span.length)


def test_what_explains_a_seed_is_the_same_however_often_it_is_asked(measured):
    surprise, row = measured
    explained = 0
    for seed in seeds(surprise, row):
        one, other = Explanations(surprise, seed), Explanations(surprise, seed)
        first = [one.best(f) for f in (FREE_AT, math.inf, FREE_AT, math.inf)]
        second = [other.best(f) for f in (math.inf, FREE_AT)]
        for e, f in zip(first, second[::-1] * 2, strict=True):
            assert (e is None) == (f is None)
            if e is not None:
                explained += 1
                assert (e.start, e.gain, e.sigma) == (f.start, f.gain, f.sigma)
                np.testing.assert_array_equal(e.offset, f.offset)
    assert explained >= 4


def plain_size(stretch, by, wider):
    """How many times departures explain u best: least squares, six times weighed anew."""
    weight = trust = stretch.root.ravel().astype(float) ** 2
    spread = 1.0 / (math.sqrt(5.0) * stretch.per_scale.ravel().astype(float))
    for _ in range(6):
        a, b = by.ravel() / (wider * spread), stretch.u.ravel() / (wider * spread)
        over = max(sum(t * v * v for t, v in zip(trust, a, strict=True)), np.radians(0.005))
        size = sum(t * v * w for t, v, w in zip(trust, a, b, strict=True)) / over
        trust = weight / (5.0 + (b - size * a) ** 2)
    return size


@pytest.mark.parametrize("wider", [1.0, 3.0])
def test_how_many_times_a_course_is_there(measured, wider):
    surprise, row = measured
    stretch = surprise.local_departures(row, 140, 50)
    levels = np.array([[1.0, 12.0, 36.0, 8.0], [1.0, 4.0, 20.0, 3.0], [1e-9, 9.0, 15.0, 3.0]])
    by = stretch.departures(softened_level_curves(levels, linear_unit_ramp, 50))
    found = stretch.sizes(by, wider)
    assert found.shape == (3,)
    for size, own in zip(found, by, strict=True):
        assert size == pytest.approx(plain_size(stretch, own, wider), rel=1e-3)
    assert 0.3 < found[0] < 0.7  # it is there with 30 degrees: 0.52
