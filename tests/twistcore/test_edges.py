"""Edges and their readings, beside ones that are read run by run."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from tests.twistcore.counters import counter_of, seeds
from twistcore.detection.counter_twist.edges import ALONE, find_interval_edges_and_steps
from twistcore.detection.robust_cost import CAP, residual_cost
from twistcore.skeleton.rotation import wrap

SHARES = (1.0, 1.0, 0.8, 0.77, 0.73, 0.7, 0.68)  # σ of a sum of w frames, of the sum of their σ


def plain_cost(z):
    """Of a residual of z standard deviations: Student's t with ν = 4, at most 14 nats."""
    return min(2.5 * math.log1p(z * z / 4.0), 14.0)


def runs(at, kind, d):
    """Runs [start, stop) of frames `at` of one sign and kind, of at most 6; large ones alone."""
    groups = []
    for t in at:
        joins = groups and groups[-1][-1] == t - 1 and kind[t] == kind[t - 1]
        joins = joins and d[t] * d[t - 1] > 0.0
        if joins and max(abs(d[t]), abs(d[t - 1])) < math.radians(75.0):
            groups[-1].append(t)
        else:
            groups.append([t])
    parts = [group[k : k + 6] for group in groups for k in range(0, len(group), 6)]
    return [(part[0], part[-1] + 1) for part in parts]


def readings(counter, row, start, stop):
    """Jump, σ and gain of the ways to read a run, the quieter first."""
    at = slice(start, stop)
    share = SHARES[stop - start]
    x, y = (float(wrap(r[row, at].sum())) for r in (counter.rx, counter.ry))
    sx, sy = (share * float(s[row, at].sum()) for s in (counter.sigma_x, counter.sigma_y))
    apart = float(wrap(x + y))
    if abs(apart) > 3.0 * math.hypot(sx, sy):
        ways = [(x, sx), (-y, sy)] if sx <= sy else [(-y, sy), (x, sx)]
    else:
        mean = float(wrap(x - apart * sx * sx / (sx * sx + sy * sy)))
        ways = [(mean, sx * sy / math.hypot(sx, sy))]
    natural = plain_cost(x / sx) + plain_cost(y / sy)
    for jump, sigma in ways:
        error = plain_cost(float(wrap(jump - x)) / sx) + plain_cost(float(wrap(jump + y)) / sy)
        yield jump, sigma, natural - error


def plain_edges(counter, row):
    """Readings by start and stop: (start, stop, peak, jump, σ, gain, primary)."""
    d, event = counter.d[row], counter.event[row]
    large = np.abs(d) > 4.0 * counter.sigma[row]
    wide = runs(np.flatnonzero(event | counter.lone[row] | large).tolist(), large, d)
    narrow = runs(np.flatnonzero(event | counter.lone[row]).tolist(), event, d)
    out = []
    for primary, some in ((True, wide), (False, [r for r in narrow if r not in wide])):
        for start, stop in some:
            peak = start + int(np.abs(d[start:stop]).argmax())
            for n, reading in enumerate(readings(counter, row, start, stop)):
                out.append((start, stop, peak, *reading, primary and n == 0))
    return sorted(out, key=lambda e: e[:2])


@settings(max_examples=examples(30))
@given(seeds)
def test_every_run_is_read_as_by_itself(seed):
    counter = counter_of(seed)
    for row in range(len(counter.d)):
        edges, step = find_interval_edges_and_steps(counter, row)
        wanted = plain_edges(counter, row)
        found = list(zip(*(column.tolist() for column in vars(edges).values()), strict=True))
        assert len(edges) == len(wanted)
        for one, other in zip(found, wanted, strict=True):
            assert one[:3] == other[:3]
            assert one[3:6] == pytest.approx(other[3:6], abs=1e-9)
            assert one[6] == other[6]
        steps = counter.event[row].copy()
        for start, stop, _, _, _, gain, primary in wanted:
            if primary and gain > 6.0:
                steps[start:stop] = True
        np.testing.assert_array_equal(step, steps)


def test_the_counters_that_are_read_have_all_there_is_to_read():
    """Or the comparison would say little."""
    every = [e for seed in range(40) for e in plain_edges(counter_of(seed), 0)]
    lengths = {stop - start for start, stop, *_ in every}
    assert lengths == {1, 2, 3, 4, 5, 6}
    assert sum(not e[-1] for e in every) > 50  # second readings, and runs that agreement splits
    assert sum(abs(e[3]) > ALONE for e in every) > 20


@given(st.floats(-60.0, 60.0))
def test_a_cost_is_a_robust_one(z):
    assert float(residual_cost(np.array(z))) == pytest.approx(plain_cost(z), abs=1e-12)
    assert float(residual_cost(np.array(z), 3.0)) == pytest.approx(min(plain_cost(z), 3.0))
    assert CAP == 14.0


def test_some_edges_are_edges_with_the_same_columns():
    edges, _ = find_interval_edges_and_steps(counter_of(1), 0)
    some = edges[edges.primary]
    assert len(some) == int(edges.primary.sum())
    for name, column in vars(some).items():
        np.testing.assert_array_equal(column, vars(edges)[name][edges.primary])
