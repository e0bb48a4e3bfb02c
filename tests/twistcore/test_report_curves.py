"""Curves of a page: small, and no frame's peak is lost in them."""

import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.corrected import Corrected
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.reading import read_clip
from twistcore.report.curve_drawing import HEIGHT, ClipCurves, _edges, _path
from twistcore.review import Decide, Decision, Review, start_review

KICK = read_clip(ASSETS / "kick.bvh")


def drawn(path):
    """Columns of a path with the lowest and highest level that the pen is at in each."""
    x = y = 0
    out = {}
    for letter, numbers in re.findall(r"([Mlvh])([^Mlvh]*)", path):
        values = [int(n) for n in re.findall(r"[+-]?\d+", numbers)]
        if letter == "h":
            for x in range(x + 1, x + values[0] + 1):  # noqa: B020
                out[x] = (y, y)
            continue
        if letter == "v":
            low, high = out[x]
            y += values[0]
            out[x] = min(low, y), max(high, y)
            continue
        x, y = values if letter == "M" else (x + values[0], y + values[1])
        out[x] = (y, y)
    return out


@given(
    st.lists(st.integers(0, HEIGHT), min_size=1, max_size=60),
    st.integers(1, 60),
    st.randoms(use_true_random=False),
)
def test_every_column_has_the_extremes_of_its_frames(levels, columns, random):
    columns = min(columns, len(levels))
    edges = _edges(len(levels), columns)
    shown = np.array([random.random() < 0.7 for _ in range(columns)])
    parts = np.split(np.array(levels), edges[1:])
    expected = {k: (min(p), max(p)) for k, p in enumerate(parts) if shown[k]}
    found = drawn(_path(np.array(levels), edges, shown))
    assert {k: tuple(map(int, v)) for k, v in found.items()} == expected


def curves(state):
    analysis = analyse(KICK)
    corrected = Corrected(analysis)
    corrected.take(state.chosen())
    drawing = ClipCurves(analysis, state.method, state.tau, state.intervals)
    return drawing, corrected


@pytest.fixture(scope="module")
def reviewed():
    review = Review.of(analyse(KICK).detect())
    review.accept()
    return review.state


def test_before_and_after_are_drawn_where_they_differ_and_nowhere_else(reviewed):
    panels, left_out = curves(reviewed)[0].panels(curves(reviewed)[1])
    assert left_out == 0
    limb = next(p for p in panels if p.chain == "RightUpLeg-RightFoot")
    lines = {line.look: drawn(line.path) for line in limb.rows[0].lines}
    applied = [j.interval for j in reviewed.intervals if j.verdict == "applied automatically"]
    inside = {int((i.start + i.stop) / 2 * limb.columns / limb.stop) for i in applied}
    assert inside <= lines["before"].keys()
    assert lines["before"].keys() == lines["after"].keys()
    assert inside.isdisjoint(lines["same"])
    apart = [abs(lines["before"][k][0] - lines["after"][k][0]) for k in inside]
    assert min(apart) > 0.4 * HEIGHT  # a flip of 180° in a range that is little more


def test_where_nothing_is_applied_there_is_one_curve(reviewed):
    ids = tuple(j.id for j in reviewed.intervals)
    state = Decide(ids, Decision.UNDECIDED).apply(reviewed)
    drawing, corrected = curves(state)
    looks = {
        line.look for p in drawing.panels(corrected)[0] for row in p.rows for line in row.lines
    }
    assert looks == {"same", "strength"}


def test_a_clip_with_errors_everywhere_has_small_curves():
    """Eight chains are drawn at most, and the more, the coarser."""
    analysis = analyse(read_clip(ASSETS / "walk_injected.bvh"))
    names = [c.name for c in analysis.chains]
    every = [
        new_constant_offset_interval(name, 50 * k, 50 * k + 30, 1.0)
        for k in range(4)
        for name in names
    ]
    state = start_review("consistency", dict.fromkeys(names, 0.1), every, names)
    corrected = Corrected(analysis)
    corrected.take(j.interval for j in state.intervals if j.interval.repairable)
    drawing = ClipCurves(analysis, state.method, state.tau, state.intervals)
    panels, left_out = drawing.panels(corrected)
    assert (len(panels), left_out) == (8, 2)
    paths = [line.path for p in panels for row in p.rows for line in row.lines]
    assert sum(map(len, paths)) < 60_000
