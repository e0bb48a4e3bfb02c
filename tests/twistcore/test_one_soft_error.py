"""One soft error: its frames, and whether both joints show it, beside plain sums by hand."""

import math
import statistics
from dataclasses import replace

import numpy as np
import pytest

from twistcore.detection.soft_errors.soft_error import (
    SoftError,
    _answered,
    _shown_in_both,
    mark_error_if_unsure,
)

DEGREE = math.pi / 180.0
FRAMES = 120
NOWHERE = np.zeros(FRAMES, dtype=bool)
NOWHERE[0] = True


def level(frames=40, size=20.0, rise=4):
    """A level of so many degrees, radians, that rises and falls in so many steps."""
    up = np.arange(1, rise + 1) / (rise + 1)
    return size * DEGREE * np.r_[up, np.ones(frames - 2 * rise), up[::-1]]


def error(start=50, offset=None, **known):
    return SoftError(3, start, level() if offset is None else offset, 90.0, 0.01, **known)


def increments(found, child=1.0, parent=1.0, unrest=0.02, seed=0):
    """What P and C turn a frame: some unrest, degrees, and their shares of the error."""
    rng = np.random.default_rng(seed)
    course = np.zeros(FRAMES + 1)
    course[found.start : found.stop] = found.offset
    steps = np.diff(course, prepend=course[0])[:FRAMES]
    x, y = unrest * DEGREE * rng.standard_normal((2, FRAMES)) + [[0.2 * DEGREE], [-0.1 * DEGREE]]
    return x + parent * steps, y - child * steps


def test_it_stands_behind_its_last_frame():
    assert error().stop == 90
    assert (error().followed, error().unsure) == (1.0, False)


def test_frames_at_its_ends_without_an_error_are_no_part_of_it():
    offset = np.array([0.0, 0.049, 0.051, 0.0, 2.0, -0.06, 0.05, -0.04]) * DEGREE
    found = error(10, offset).trimmed()
    assert (found.start, found.stop) == (12, 16)
    np.testing.assert_array_equal(found.offset, offset[2:6])
    assert (found.row, found.gain, found.sigma) == (3, 90.0, 0.01)
    one = error(10, np.array([0.0, -0.06, 0.0]) * DEGREE).trimmed()
    assert (one.start, one.stop) == (11, 12)
    nothing = error(10, np.full(4, 0.04 * DEGREE))
    assert nothing.trimmed() is nothing


# Which side is wrong


@pytest.mark.parametrize(
    ("start", "frames", "cuts", "unsure"),
    [
        (0, 39, (), False),
        (0, 40, (), False),  # two thirds of the clip are left: twice as much
        (0, 41, (), True),
        (40, 41, (), False),
        (80, 40, (), False),
        (79, 41, (), True),
        (78, 41, (), False),  # a frame is left behind it
        (30, 41, (30,), True),
        (30, 41, (29,), False),
        (30, 41, (31, 70), False),
        (30, 41, (71,), True),
        (30, 41, (72,), False),
    ],
)
def test_an_error_at_an_end_must_be_by_far_the_shorter_side(start, frames, cuts, unsure):
    cut = NOWHERE.copy()
    cut[list(cuts)] = True
    one = error(start, level(frames))
    x, y = increments(one)
    found = mark_error_if_unsure(one, x, y, cut, last=False)
    assert found.unsure == unsure
    assert (found.start, found.row, found.offset is one.offset) == (start, 3, True)


def test_a_clip_begins_and_ends_without_a_cut():
    anywhere = np.zeros(FRAMES, dtype=bool)
    for start, unsure in ((0, True), (1, False), (78, False), (79, True)):
        one = error(start, level(41))
        x, y = increments(one)
        assert mark_error_if_unsure(one, x, y, anywhere, last=False).unsure == unsure


# Whether both joints show it


def plain_shown(one, x, y, if_unclear):
    course = [0.0] * (len(x) + 2)
    course[one.start : one.stop] = one.offset.tolist()
    steps = [0.0] + [course[t] - course[t - 1] for t in range(1, len(x))]
    steepest = max(range(1, len(x)), key=lambda t: (abs(steps[t]), -t))
    near = range(max(steepest - 8, 1), min(steepest + 9, len(x)))
    edge = [t for t in (steepest - 1, steepest, steepest + 1) if 1 <= t < len(x)]
    turned = []
    for own, sign in ((x, -1.0), (y, 1.0)):
        natural = [own[t] + sign * steps[t] for t in near]
        pace = statistics.median(natural)
        unrest = statistics.median(abs(v - pace) for v in natural)
        if abs(sum(steps[t] for t in edge)) < 30.0 * max(unrest, 0.05 * DEGREE):
            return if_unclear
        turned.append(abs(sum(own[t] - pace for t in edge)))
    return min(turned) >= 0.35 * max(turned)


@pytest.mark.parametrize("start", [0, 1, 2, 5, 50, 79, 80])
@pytest.mark.parametrize("rise", [1, 3, 8])
def test_whether_both_joints_show_an_error_is_seen_where_it_is_steepest(start, rise):
    told = set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        one = error(start, level(40, rng.uniform(-20.0, 20.0), rise))
        shares = rng.choice([0.2, 0.3, 0.4, 1.0], 2)
        x, y = increments(one, *shares, unrest=rng.choice([0.01, 0.06, 0.4]), seed=seed)
        for if_unclear in (False, True):
            found = _shown_in_both(one, x, y, if_unclear)
            assert found == plain_shown(one, x, y, if_unclear)
            told.add((found, if_unclear))
    assert len(told) >= (3 if start or rise < 8 else 2)


def test_one_joint_that_turns_a_third_moved_alone():
    sudden = error(offset=np.full(30, 20.0 * DEGREE))
    for child, parent in ((0.34, 1.0), (1.0, 0.34)):
        x, y = increments(sudden, child, parent, unrest=0.0)
        assert not _shown_in_both(sudden, x, y, True)
        assert mark_error_if_unsure(sudden, x, y, NOWHERE, last=False).unsure
    for child, parent in ((0.36, 1.0), (1.0, 0.36)):
        x, y = increments(sudden, child, parent, unrest=0.0)
        assert _shown_in_both(sudden, x, y, False)
        assert not mark_error_if_unsure(sudden, x, y, NOWHERE, last=False).unsure


@pytest.mark.parametrize(("degrees", "clear"), [(1.49, False), (1.51, True)])
def test_a_step_counts_from_thirty_times_what_is_seen_at_all(degrees, clear):
    sudden = error(offset=np.full(30, degrees * DEGREE))
    x, y = increments(sudden, child=0.0, unrest=0.0)
    assert _shown_in_both(sudden, x, y, True) == (not clear)


@pytest.mark.parametrize(("last", "side", "unsure"), [
    (False, 0, False), (True, 0, False), (False, 1, False), (True, 1, False), (False, -1, False),
    (True, -1, True),
])  # fmt: skip
def test_what_cannot_be_told_counts_against_a_silent_joint_at_a_lines_end(last, side, unsure):
    slow = error(offset=level(40, 1.0, 10))  # never steep
    x, y = increments(slow)
    assert mark_error_if_unsure(slow, x, y, NOWHERE, side, last=last).unsure == unsure


# Whether the other joint turns back what a silent one turns


def plain_answered(own, other, start, stop):
    frames = range(max(start, 1), min(stop + 1, len(own)))
    left = sum(abs(own[t] + other[t]) for t in frames)
    if left <= 1.5 * sum(abs(other[t]) for t in frames):
        return True
    first, behind = max(frames.start - 1, 0), min(stop + 2, len(own))
    pairs = [(own[t + 1] - own[t], other[t + 1] - other[t]) for t in range(first, behind - 1)]
    return -sum(a * b for a, b in pairs) >= 0.5 * sum(a * a for a, _ in pairs)


@pytest.mark.parametrize(
    ("start", "stop"),
    [(0, 3), (1, 4), (60, 61), (0, 9), (1, 9), (2, 20), (40, 60), (100, 119), (99, 120)],
)
def test_an_answer_is_told_by_sums_or_by_changes_of_pace(start, stop):
    told = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        other = rng.standard_normal(FRAMES) + rng.choice([0.0, 2.0])
        own = rng.choice([-1.0, -0.5, 0.5, 1.0]) * other + rng.uniform(0.5, 3.0) * (
            rng.standard_normal(FRAMES) + rng.choice([0.0, 3.0])
        )
        found = _answered(own, other, start, stop)
        assert found == plain_answered(own.tolist(), other.tolist(), start, stop)
        told.append(found)
    assert len(set(told)) == 2


def test_what_a_silent_joint_turns_the_other_one_must_turn_back():
    """A joint that only rested turns by itself: the other one goes on at its pace."""
    sharp = error(offset=np.full(30, 20.0 * DEGREE))
    x, y = increments(sharp, unrest=0.0)
    rested = np.zeros(FRAMES)
    rested[50:80] = 4.0 * DEGREE
    for side, own, other in ((1, x + rested, y), (-1, x, y + rested)):
        assert mark_error_if_unsure(sharp, x, y, NOWHERE, side, last=False).unsure is False
        found = mark_error_if_unsure(sharp, own, other, NOWHERE, side, last=False)
        assert not found.unsure  # the steps are answered, whatever was turned between them
    both = x.copy()
    both[50:81] = np.random.default_rng(0).standard_normal(31) * 9.0 * DEGREE
    both[49:52] += [0.0, 20.0 * DEGREE, 0.0]
    for side, own, other in ((1, both, y), (-1, y, both)):
        one = replace(sharp, offset=-sharp.offset if side < 0 else sharp.offset)
        alone = not plain_shown(one, own, other, True)
        answered = plain_answered(
            *((own, other) if side > 0 else (other, own)), one.start, one.stop
        )
        assert mark_error_if_unsure(one, own, other, NOWHERE, side, last=False).unsure == (
            alone or not answered
        )
        assert mark_error_if_unsure(one, own, other, NOWHERE, 0, last=False).unsure == alone
