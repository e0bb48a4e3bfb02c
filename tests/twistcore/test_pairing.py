"""Pairs of edges, beside ones that are weighed pair by pair, and the best of all sets of them."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from tests.twistcore.counters import ROW, counter_of, seeds
from twistcore.detection.counter_twist import pairing
from twistcore.detection.counter_twist.edges import find_interval_edges_and_steps
from twistcore.detection.counter_twist.pairing import (
    Block,
    Pair,
    PairTable,
    best_edge_pairs,
    edge_pair_table,
    one_ended_jump_intervals,
    running_counter_rotation_sums,
)
from twistcore.skeleton.rotation import wrap

FRAMES = 90
FPS = st.sampled_from([24.0, 30.0, 60.0, 120.0])
DEGREE = math.pi / 180.0


def table_of(seed, low=0, high=FRAMES, jumps=0.08):
    counter = counter_of(seed, frames=FRAMES, jumps=jumps)
    edges, step = find_interval_edges_and_steps(counter, ROW)
    return (
        counter,
        step,
        edge_pair_table(edges, running_counter_rotation_sums(counter, ROW, step), low, high),
    )


def closing(residual, variance):
    """How much likelier a sum is 0 than just anything on the circle, nats."""
    sigma = math.sqrt(variance)
    cost = 2.5 * math.log1p((float(wrap(residual)) / sigma) ** 2 / 4.0)
    return math.log(2.0 * math.pi / 2.5 / sigma) - min(cost, 25.0)


def plain_gain(counter, step, edges, opening, closing_):
    """What a pair gains, nats, and what it follows: 0 its edges, 1 its steps, 2 every frame."""
    j, i = opening, closing_
    size = np.abs(edges.jump)
    inner = 0.0
    threshold = min(max(0.4 * size[i], 4.25 * DEGREE), 8.0 * DEGREE)
    for k in range(j + 1, len(edges)):
        between = edges.stop[k] <= edges.start[i]
        if between and edges.primary[k] and size[k] >= 1.5 * DEGREE:
            inner += edges.gain[k] - (8.0 if size[k] < threshold else 30.0)
    total = edges.jump[j] + edges.jump[i]
    spread = edges.sigma[j] ** 2 + edges.sigma[i] ** 2
    spread += (0.05 * DEGREE) ** 2 + (0.005 * max(size[i], size[j])) ** 2
    at = slice(edges.stop[j], edges.start[i])
    d, variance, steps = counter.d[ROW, at], counter.sigma[ROW, at] ** 2, step[at]
    ways = [
        closing(total, spread),
        closing(total + d[steps].sum(), spread + variance[steps].sum()) + inner - 2.0,
        closing(total + d.sum(), spread + variance.sum()) + inner - 6.0,
    ]
    follows = int(np.argmax(ways))
    length = max(edges.start[i] - edges.start[j], 0)
    gain = edges.gain[j] + edges.gain[i] - 20.0 - 4.0 * math.log1p(length / 30.0)
    return ways[follows] + gain, follows


@pytest.mark.parametrize(("block", "band"), [(5, 512), (5, 3), (64, 512)])
@settings(max_examples=examples(15))
@given(seed=seeds)
def test_every_pair_gains_what_it_gains_by_itself(block, band, seed):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pairing, "BLOCK", block)
        patch.setattr(pairing, "BAND", band)
        counter, step, table = table_of(seed)
        assert_no_set_gains_more(table, 0.5 * DEGREE, 60.0)
    edges = table.edges
    assert all(b.first_column == max(0, b.first_row - band) for b in table.blocks)
    assert [b.first_row for b in table.blocks] == list(range(0, len(edges), block))
    for b in table.blocks:
        for row, column in np.ndindex(b.gain.shape):
            i, j = row + b.first_row, column + b.first_column
            gain, follows = -math.inf, 0
            if edges.stop[j] <= edges.start[i]:
                gain, follows = plain_gain(counter, step, edges, j, i)
            if gain <= 0.0:
                assert b.gain[row, column] == -math.inf
            else:
                assert b.gain[row, column] == pytest.approx(gain, abs=1e-6)
                assert b.follows[row, column] == follows


@settings(max_examples=examples(15))
@given(seeds, st.integers(0, 40), st.integers(50, FRAMES))
def test_a_segment_has_the_edges_inside_of_it_but_those_too_small_to_be_asked_for(seed, low, high):
    every, _ = find_interval_edges_and_steps(counter_of(seed, frames=FRAMES), ROW)
    if seed % 2 and len(every) > 1:  # to the frame
        low, high = int(every.start[len(every) // 3]), int(every.stop[2 * len(every) // 3])
    _, _, table = table_of(seed, low, high)
    wanted = [
        k
        for k in range(len(every))
        if low < every.start[k] and every.stop[k] <= high and abs(every.jump[k]) >= 0.3 * DEGREE
    ]
    np.testing.assert_array_equal(table.edges.jump, every.jump[wanted])
    assert (table.low, table.high) == (low, high)


@settings(max_examples=examples(15))
@given(seeds)
def test_partners_are_told_by_both_edges_alike(seed):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pairing, "BLOCK", 7)
        patch.setattr(pairing, "BAND", 9)
        counter, step, table = table_of(seed)
    for i in range(len(table.edges)):
        wanted = {}
        for j in range(len(table.edges)):
            first, last = (j, i) if j < i else (i, j)
            in_band = first >= max(0, last - last % 7 - 9)
            if in_band and table.edges.stop[first] <= table.edges.start[last]:
                gain, _ = plain_gain(counter, step, table.edges, first, last)
                if gain > 0.0:
                    wanted[j] = pytest.approx(gain, abs=1e-6)
        assert table.partners(i) == wanted


# The best set


def alone(table, k, side, other, fps):
    """What an edge gains with a border, −inf where that side is long."""
    if side > max(24, round(0.7 * fps)) or side > 0.5 * other:
        return -math.inf
    gain = table.edges.gain[k] - 12.0 - 4.0 * math.log1p(side / 30.0)
    return gain - 4.5 * (side > round(0.25 * fps))


def allowed(table, pair, fps):
    """Whether a pair leaves so much of its segment that its ends are not rather the error."""
    edges, longest = table.edges, max(24, round(0.7 * fps))
    before = edges.stop[pair.opening] - 1 - table.low
    behind = table.high - edges.start[pair.closing]
    if before > longest or behind > longest:
        return True
    inside = edges.start[pair.closing] - edges.start[pair.opening]
    ends = (edges.gain[k] - 12.0 - 4.0 * math.log1p(n / 30.0) for k, n in
            ((pair.opening, before), (pair.closing, behind)))  # fmt: skip
    share = 0.5 if pair.gain < sum(ends) else 0.125
    return table.high - table.low - inside > share * inside


def most_gained(table, tau, fps):
    """The gain of the best set of disjoint intervals, by trying at every edge all ways on."""
    edges = table.edges
    at = [k for k in range(len(edges)) if abs(edges.jump[k]) >= tau]
    ways = []  # first frame, frame behind the last, gain
    for k in at:
        before, behind = edges.stop[k] - 1 - table.low, table.high - edges.start[k]
        ways.append((-1, edges.stop[k], alone(table, k, before, behind, fps)))
        ways.append((edges.start[k], table.high + 1, alone(table, k, behind, before, fps)))
        for other, gain in table.partners(k).items():
            pair = Pair(other, k, 0, gain)
            if other < k and other in at and allowed(table, pair, fps):
                ways.append((edges.start[other], edges.stop[k], gain))
    best = {}

    def from_(frame):
        if frame not in best:
            later = [w for w in ways if w[0] >= frame and w[2] > 0.0]
            best[frame] = max((w[2] + from_(w[1]) for w in later), default=0.0)
        return best[frame]

    return from_(-1)


@settings(max_examples=examples(30))
@given(seeds, st.sampled_from([0.5, 1.5, 5.0, 20.0]), FPS, st.sampled_from([0.03, 0.08]))
def test_no_set_of_disjoint_intervals_gains_more(seed, tau, fps, jumps):
    low, high = seed % 20, FRAMES - seed % 7
    assert_no_set_gains_more(table_of(seed, low, high, jumps)[2], tau * DEGREE, fps)


def assert_no_set_gains_more(table, tau, fps):
    edges = table.edges
    pairs = best_edge_pairs(table, tau, fps)
    assert sum(p.gain for p in pairs) == pytest.approx(most_gained(table, tau, fps), abs=1e-6)
    behind = -1
    for pair in pairs:
        at = [k for k in pair[:2] if k >= 0]
        assert all(abs(edges.jump[k]) >= tau for k in at)
        assert (edges.start[pair.opening] if pair.opening >= 0 else -1) >= behind
        behind = edges.stop[pair.closing] if pair.closing >= 0 else math.inf
        if len(at) == 1:
            assert pair.follows == 0
        else:
            assert table.partners(pair.closing)[pair.opening] == pair.gain
            block = next(b for b in table.blocks if 0 <= pair.closing - b.first_row < len(b.gain))
            cell = pair.closing - block.first_row, pair.opening - block.first_column
            assert block.follows[cell] == pair.follows


@settings(max_examples=examples(60))
@given(
    st.integers(1, 40), st.integers(45, 88), st.integers(0, 5), st.integers(0, 9),
    st.tuples(st.floats(10.0, 60.0), st.floats(10.0, 60.0), st.floats(0.1, 60.0)), FPS,
)  # fmt: skip
def test_an_interval_over_nearly_all_gives_way_to_errors_at_both_ends(
    opens, closes, low, behind, gains, fps
):
    edges = table_of(3)[2].edges[np.array([0, 1])]
    start = low + np.array([opens, closes])
    edges = replace(
        edges, start=start, stop=start + 1, jump=np.array([1.0, -1.0]), gain=np.array(gains[:2])
    )
    gain = np.array([[-np.inf, -np.inf], [gains[2], -np.inf]])
    block = Block.of(0, 0, gain, np.zeros((2, 2), dtype=np.int8))
    high = low + closes + 1 + behind
    assert_no_set_gains_more(PairTable(edges, low, high, (block,)), 0.01, fps)


@pytest.mark.parametrize(("fps", "longest"), [(24.0, 24), (60.0, 42)])
@pytest.mark.parametrize("low", [0, 7])
def test_an_edge_is_near_an_end_of_its_segment_to_the_frame(fps, longest, low):
    """An interval gives way to errors at both ends only if both of its edges are near them."""
    edges = table_of(3)[2].edges[np.array([0, 1])]
    gain = np.array([[-np.inf, -np.inf], [60.0, -np.inf]])
    block = Block.of(0, 0, gain, np.zeros((2, 2), dtype=np.int8))
    for before in (longest - 1, longest, longest + 1):
        for behind in (longest - 1, longest, longest + 1):
            start = low + before + np.array([0, 800])
            own = replace(
                edges, start=start, stop=start + 1, jump=np.array([1.0, -1.0]),
                gain=np.array([40.0, 40.0]),
            )  # fmt: skip
            pairs = best_edge_pairs(
                PairTable(own, low, int(start[1]) + behind, (block,)), 0.01, fps
            )
            near = max(before, behind) <= longest
            assert ((0, 1) in [p[:2] for p in pairs]) == (not near)


@settings(max_examples=examples(30))
@given(seeds, st.sampled_from([0.5, 5.0, 20.0]), FPS)
def test_clear_jumps_that_nothing_explains_are_told_by_their_shorter_side(seed, tau, fps):
    _, _, table = table_of(seed, seed % 20, FRAMES - seed % 7)
    edges, tau = table.edges, tau * DEGREE
    pairs = best_edge_pairs(table, tau, fps)
    wanted = []
    for k in range(len(edges)):
        frames = set(range(edges.start[k], edges.stop[k]))
        explained = False
        for p in pairs:
            first = edges.start[p.opening] if p.opening >= 0 else table.low
            last = edges.stop[p.closing] if p.closing >= 0 else table.high
            explained |= not frames.isdisjoint(range(first, last))
        if explained or not edges.primary[k]:
            continue
        if abs(edges.jump[k]) < tau or edges.gain[k] < 20.0:
            continue
        before = edges.stop[k] - 1 - table.low <= table.high - edges.start[k]
        wanted.append((-1, k, 0, edges.gain[k]) if before else (k, -1, 0, edges.gain[k]))
    assert [tuple(p) for p in one_ended_jump_intervals(table, pairs, tau)] == wanted


def test_a_segment_without_edges_has_no_pairs():
    _, _, table = table_of(3, jumps=0.0)
    none = table_of(3, low=40, high=41)[2]
    for some in (none, table):
        assert best_edge_pairs(some, 100.0, 30.0) == []
        assert one_ended_jump_intervals(some, [], 100.0) == []
    assert none.blocks == ()


@pytest.mark.parametrize(("high", "before"), [(18, False), (19, False), (20, True), (21, True)])
def test_the_shorter_side_is_told_to_the_frame(high, before):
    _, _, table = table_of(3)
    one = table.edges[np.array([0])]
    one = replace(
        one, start=np.array([10]), stop=np.array([11]), gain=np.array([90.0]),
        jump=np.array([1.0]), primary=np.array([True]),
    )  # fmt: skip
    (pair,) = one_ended_jump_intervals(
        replace(table, edges=one, low=0, high=high, blocks=()), [], 0.01
    )
    assert tuple(pair) == ((-1, 0, 0, 90.0) if before else (0, -1, 0, 90.0))


@pytest.mark.parametrize(("gain", "expected"), [(19.9, False), (20.0, True)])
def test_a_jump_that_nothing_explains_is_told_if_both_signals_show_it_clearly(gain, expected):
    _, _, table = table_of(3)
    edges = table.edges
    one = edges[np.array([int(np.abs(edges.jump).argmax())])]
    one = replace(one, gain=np.array([gain]), primary=np.array([True]))
    found = one_ended_jump_intervals(replace(table, edges=one, blocks=()), [], 0.01)
    assert bool(found) is expected
    hidden = replace(one, gain=np.array([90.0]), primary=np.array([False]))
    assert not one_ended_jump_intervals(replace(table, edges=hidden, blocks=()), [], 0.01)
