"""Courses of errors between paired edges, beside ones that are summed up frame by frame."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from tests.twistcore.counters import ROW, counter_of, seeds
from twistcore.detection.counter_twist.counter_rotation import combine_counter_rotation_residuals
from twistcore.detection.counter_twist.edges import Edges, find_interval_edges_and_steps
from twistcore.detection.counter_twist.offsets import interval_twist_errors_over_time
from twistcore.detection.counter_twist.pairing import (
    Pair,
    PairTable,
    best_edge_pairs,
    edge_pair_table,
    one_ended_jump_intervals,
    running_counter_rotation_sums,
)
from twistcore.skeleton.rotation import wrap

FRAMES = 90
DEGREE = np.pi / 180.0
SHARES = (1.0, 1.0, 0.8, 0.77, 0.73, 0.7, 0.68)


def plain_course(pair, edges, low, high, d, variance, step):
    """First frame, offsets and residual of an interval, before P's own jumps are asked."""
    opening, closing, follows = pair[:3]
    if opening < 0 or closing < 0:
        k = max(opening, closing)
        start, stop = edges.start[k], edges.stop[k]
        jumps = d[start:stop] + wrap(edges.jump[k] - d[start:stop].sum()) / (stop - start)
        if closing < 0:
            rise = np.cumsum(jumps)
            return start, wrap(np.r_[rise, np.full(high - stop, rise[-1])]), 0.0
        rest = [-jumps[n:].sum() for n in range(stop - start)]
        return low, wrap(np.r_[np.full(start - 1 - low, rest[0]), rest]), 0.0
    first, last = edges.start[opening], edges.stop[closing]
    jumps, spread = [], []
    for t in range(first, last):
        k = opening if t < edges.stop[opening] else closing if t >= edges.start[closing] else -1
        if k >= 0:
            width = edges.stop[k] - edges.start[k]
            missing = wrap(edges.jump[k] - d[edges.start[k] : edges.stop[k]].sum())
            jumps.append(d[t] + missing / width)
            spread.append(edges.sigma[k] ** 2 / width)
        else:
            used = follows == 2 or (follows == 1 and step[t])
            jumps.append(d[t] * used)
            spread.append(variance[t] * used)
    left = float(wrap(sum(jumps)))
    closed = np.array(jumps) - left * np.array(spread) / sum(spread)
    return first, wrap(np.cumsum(closed))[:-1], left


def as_p_shows(offset, pair, edges, counter):
    """The offset by P's own jumps, and how far C follows, where that is clear."""
    k = [pair.opening, pair.closing]
    at = [slice(edges.start[n], edges.stop[n]) for n in k]
    width = [a.stop - a.start for a in at]
    x, y = (np.array([r[ROW, at[0]].sum(), -r[ROW, at[1]].sum()]) for r in (counter.rx, counter.ry))
    sx, sy = (
        np.array([SHARES[w] * s[ROW, a].sum() for w, a in zip(width, at, strict=True)])
        for s in (counter.sigma_x, counter.sigma_y)
    )
    both, child, apart = np.sqrt(sx**2 + sy**2), wrap(-y), wrap(x + y)
    parent = child + apart

    def alike(values, sigma):
        allowed = 4.0 * np.sqrt((sigma**2).sum()) + 0.05 * np.abs(parent).max() + 0.05 * DEGREE
        return abs(values[0] - values[1]) <= allowed

    clear = (parent != 0.0).all() and max(width) < 6
    clear = clear and (child / parent >= 0.3).all() and (apart / parent >= 0.08).all()
    clear = clear and (np.abs(apart) >= 5.0 * both).all()
    if not (clear and alike(parent, sx) and alike(apart, both)):
        return offset, 1.0
    level = np.average(parent, weights=sx**-2.0)
    steady = child[0] + wrap(edges.jump[pair.opening] - child[0])
    course = (steady + wrap(offset - steady)) * level / steady
    return wrap(course), np.average(child, weights=sy**-2.0) / level


def assert_as_plain(pairs, table, counter, step):
    """All courses; how many C follows in part only."""
    d, variance = counter.d[ROW], counter.sigma[ROW] ** 2
    found = interval_twist_errors_over_time(pairs, table, counter, ROW, step)
    partly = 0
    for pair, course in zip(pairs, found, strict=True):
        start, offset, left = plain_course(
            pair, table.edges, table.low, table.high, d, variance, step
        )
        followed = 1.0
        if min(pair[:2]) >= 0:
            offset, followed = as_p_shows(offset, pair, table.edges, counter)
        assert course.start == start
        np.testing.assert_allclose(wrap(course.offset - offset), 0.0, atol=1e-9)
        assert course.residual == pytest.approx(left, abs=1e-9)
        assert course.followed == pytest.approx(followed)
        partly += followed < 1.0
    return partly


@settings(max_examples=examples(25))
@given(seeds)
def test_courses_are_sums_of_jumps_that_close(seed):
    counter = counter_of(seed, frames=FRAMES)
    edges, step = find_interval_edges_and_steps(counter, ROW)
    table = edge_pair_table(
        edges, running_counter_rotation_sums(counter, ROW, step), seed % 20, FRAMES - seed % 7
    )
    pairs = best_edge_pairs(table, 0.5 * DEGREE, 60.0)
    pairs += one_ended_jump_intervals(table, pairs, 0.5 * DEGREE)
    for k, pair in enumerate(pairs):
        if min(pair[:2]) >= 0:  # whatever it followed, follow something else, too
            pairs.append(pair._replace(follows=(pair.follows + 1 + k % 2) % 3))
            if len(pairs) > 40:
                break
    assert_as_plain(pairs, table, counter, step)


def test_no_pairs_have_no_courses():
    counter = counter_of(1)
    edges, step = find_interval_edges_and_steps(counter, ROW)
    assert (
        interval_twist_errors_over_time(
            [],
            edge_pair_table(edges, running_counter_rotation_sums(counter, ROW, step), 0, FRAMES),
            counter,
            ROW,
            step,
        )
        == []
    )


def compensated(seed, share, size, noise, widths, apart=0.03, length=20):
    """An error of P that C turns back by a share; edges of so many frames."""
    rng = np.random.default_rng(seed)
    sigma = np.repeat(noise * rng.uniform(0.7, 1.4, (2, 2, 1)), FRAMES, axis=2)
    residual = 0.3 * sigma * rng.standard_normal(sigma.shape)
    start = 30
    for first, width, turn in (
        (start, widths[0], size),
        (start + length, widths[1], -size * rng.uniform(1.0 - apart, 1.0 + apart)),
    ):
        residual[0, ROW, first : first + width] += turn / width
        residual[1, ROW, first : first + width] -= share * turn / width
    d, _, sigma_d, _ = combine_counter_rotation_residuals(residual, sigma)
    event = np.abs(d) > 4.0 * sigma_d
    none = np.zeros_like(event)
    counter = replace(
        counter_of(0, frames=FRAMES), rx=residual[0], ry=residual[1], sigma_x=sigma[0],
        sigma_y=sigma[1], d=d, sigma=sigma_d, event=event, lone=none,
    )  # fmt: skip
    first, last = np.array([start, start + length]), np.array([start, start + length]) + widths
    jump = np.array([wrap(d[ROW, a:b].sum()) for a, b in zip(first, last, strict=True)])
    width = np.array([sigma_d[ROW, a:b].sum() for a, b in zip(first, last, strict=True)])
    edges = Edges(first, last, first, jump, width, np.full(2, 50.0), np.ones(2, dtype=bool))
    return counter, PairTable(edges, 0, FRAMES, ())


@settings(max_examples=examples(80))
@given(
    seeds,
    st.one_of(st.floats(0.0, 1.1), st.sampled_from([0.28, 0.32, 0.9, 0.94])),
    st.floats(0.02, 3.1) | st.floats(-3.1, -0.02),
    st.sampled_from([1e-5, 1e-3, 0.01]),
    st.tuples(st.integers(1, 6), st.integers(1, 6)),
    st.integers(0, 2),
    st.sampled_from([0.03, 0.1]),
)
def test_where_c_turns_back_in_part_the_course_is_as_p_shows(
    seed, share, size, noise, widths, follows, apart
):
    counter, table = compensated(seed, share, size, noise, widths, apart)
    assert_as_plain([Pair(0, 1, follows, 30.0)], table, counter, counter.event[ROW])


@pytest.mark.parametrize("share", [0.35, 0.6, 0.9])
@pytest.mark.parametrize("size", [-1.0, 0.4, 2.0])
def test_a_share_that_is_clear_is_told(share, size):
    counter, table = compensated(3, share, size, 1e-4, (2, 1))
    (course,) = interval_twist_errors_over_time(
        [Pair(0, 1, 0, 30.0)], table, counter, ROW, counter.event[ROW]
    )
    assert course.followed == pytest.approx(share, abs=0.03)
    assert course.offset[5] == pytest.approx(size, rel=0.06)  # the edges differ by up to 3 %
