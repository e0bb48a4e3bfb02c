"""Soft errors beside what is known: what meets, what is doubted, what explains more."""

import copy
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.twistcore.test_silent_errors import bump, put_in
from tests.twistcore.test_silent_errors import made as with_hinges
from tests.twistcore.test_surprise import FRAMES, bad_frames, made
from twistcore.detection.limbs import Limbs
from twistcore.detection.soft_errors import Known, search_soft_errors, soft_intervals
from twistcore.detection.soft_errors.natural_scale import unnaturally_large_twist_increments
from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.soft_intervals import (
    _better,
    _lively_errors,
    _meets,
    _near_has,
    _refresh,
    _stretches,
    _unnatural,
    soft_error_confidence_from_gain,
    soft_interval,
)
from twistcore.detection.soft_errors.soft_search import twist_departure_costs_per_span
from twistcore.skeleton.twist_increments import twist_increments

DEGREE = math.pi / 180.0


def soft(row, start, frames, size=0.3, **known):
    return SoftError(row, start, np.full(frames, size), 90.0, 0.01, **known)


# How one is told


def test_a_soft_error_becomes_an_interval():
    error = soft(2, 40, 9, unsure=True, followed=0.6)
    found = soft_interval("LeftArm", error)
    assert (found.chain, found.start, found.stop, found.followed) == ("LeftArm", 40, 49, 0.6)
    assert found.offset is error.offset
    assert (found.open, found.confidence) == (True, soft_error_confidence_from_gain(90.0))
    assert {k: v for k, v in found.evidence.items() if k != "follows"} == {
        "gain": 90.0,
        "sigma_deg": pytest.approx(0.01 / DEGREE),
        "child_follows": 0.6,
        "silent_joint": False,
    }
    assert not soft_interval("LeftArm", replace(error, unsure=False)).open


def test_confidence_is_even_at_eighty_nats():
    assert soft_error_confidence_from_gain(80.0) == 0.5
    assert soft_error_confidence_from_gain(92.0) == pytest.approx(1.0 / (1.0 + math.exp(-1.0)))
    assert soft_error_confidence_from_gain(45.0) == pytest.approx(
        1.0 / (1.0 + math.exp(35.0 / 12.0))
    )
    assert soft_error_confidence_from_gain(80.0 + 12.0 * 30.0) == soft_error_confidence_from_gain(
        1e9
    )
    assert (
        soft_error_confidence_from_gain(80.0 - 12.0 * 30.0)
        == soft_error_confidence_from_gain(-1e9)
        > 0.0
    )
    assert soft_error_confidence_from_gain(80.0 - 12.0 * 29.0) > soft_error_confidence_from_gain(
        -1e9
    )
    assert 1.0 - soft_error_confidence_from_gain(
        80.0 + 12.0 * 29.0
    ) > 1.0 - soft_error_confidence_from_gain(1e9)


# What meets


def test_what_is_known_ends_behind_its_last_frame():
    known = Known(1, 7, np.zeros(5))
    assert (known.stop, known.firm) == (12, False)


@pytest.mark.parametrize("seed", range(12))
def test_errors_that_meet_share_a_stretch(seed):
    rng = np.random.default_rng(seed)
    errors = [
        soft(0, int(rng.integers(0, 80)), int(rng.integers(1, 14))) if rng.random() < 0.5
        else Known(0, int(rng.integers(0, 80)), np.zeros(int(rng.integers(1, 14))))
        for _ in range(9)
    ]  # fmt: skip
    groups = [{k} for k in range(9)]
    for a in range(9):
        for b in range(9):
            one, other = errors[a], errors[b]
            if one.start < other.stop and other.start < one.stop:
                together = groups[a] | groups[b]
                for k in together:
                    groups[k] = together
    wanted = {(min(errors[k].start for k in g), max(errors[k].stop for k in g)) for g in groups}
    assert _stretches(errors) == sorted(wanted)
    assert _stretches([]) == []


def test_what_is_near_is_within_two_chains_and_the_frames():
    s = made(0)
    for row in range(6):
        for at in range(6):
            for t in (19, 20, 29, 30):
                mask = np.zeros((6, FRAMES), dtype=bool)
                mask[at, t] = True
                near = at % 2 == row % 2 and abs(at - row) <= 4 and 20 <= t < 30
                assert _near_has(s, mask, row, 20, 30) is near
    mask = np.zeros((6, FRAMES), dtype=bool)
    mask[2, [0, FRAMES - 1]] = True
    assert _near_has(s, mask, 2, -2, 3)
    assert not _near_has(s, mask, 2, 1, FRAMES - 1)
    assert _near_has(s, mask, 2, 1, FRAMES + 3)


@pytest.mark.parametrize(
    ("row", "start", "meets"),
    [(0, 20, True), (2, 20, True), (4, 20, True), (3, 20, False), (2, 11, False), (2, 12, True),
     (2, 29, True), (2, 30, False)],
)  # fmt: skip
def test_what_is_known_meets_an_error_in_its_chain_or_beside(row, start, meets):
    known = Known(row, start, np.zeros(9))
    assert _meets(made(0), known, soft(2, 20, 10)) is meets
    if row != 2:
        assert not _meets(made(0), replace(known, row=4), soft(0, 20, 10))


# What departs too far


def test_frames_under_a_span_that_departs_too_far():
    s = made(5)
    for row, start in ((1, 30), (4, 100)):
        s.remove_error(row, start, np.full(9, 0.1))
        s.update_departures(row, start, start + 9)
    s.measure(bad_frames(s.rows))
    wanted = np.zeros((6, FRAMES), dtype=bool)
    for k, a in enumerate(s.at):
        for row in range(6):
            for j, gain in enumerate(twist_departure_costs_per_span(s, k, np.array([row]))[0]):
                if gain > 18.0:
                    first = j * a.natural.span.step
                    wanted[row, first : first + a.natural.span.length + 2 * 2 + 1] = True
    found = _unnatural(s)
    np.testing.assert_array_equal(found, wanted)
    assert wanted[1].any()
    assert not wanted.all()


def test_increments_are_told_anew_from_rotations_as_they_are():
    s = made(5)
    s.remove_error(2, 60, np.full(20, 0.2))
    _refresh(s)
    for row in range(6):
        k, i = divmod(row, 2)
        x, y = twist_increments(s.joints[k, i], s.joints[k + 1, i], s.limbs.axes[k, i])
        np.testing.assert_array_equal(s.x[row], np.where(s.cut, 0.0, x))
        np.testing.assert_array_equal(s.y[row], np.where(s.cut, 0.0, y))


# Which explains more


def taken(s, *errors, sign=1.0):
    s = copy.deepcopy(s)
    for e in errors:
        s.remove_error(e.row, e.start, sign * e.offset)
        s.update_departures(e.row, e.start, e.stop)
    return s


def surprises(s, rows, low, high):
    margin = (high - low) // 2 + 8
    window = max(low - margin, 0), min(high + margin, FRAMES)
    return sum(s.of(r, *window) for r in rows)


def measured(seed=3):
    s = made(seed, cuts=())
    s.measure(bad_frames(s.rows))
    return s


@pytest.mark.parametrize(("start", "frames"), [(4, 30), (60, 30), (115, 33)])
@pytest.mark.parametrize("share", [-0.5, 0.3, 0.98, 1.0])
def test_what_is_known_stands_unless_an_error_explains_more(share, start, frames):
    """An error is there; what was found has it right, what was known only a share of it."""
    clean, right = measured(), soft(2, start, frames, 0.4)
    known = Known(2, start, share * right.offset)
    dirty = taken(clean, right, sign=-1.0)
    rows = [0, 2, 4]
    now = surprises(taken(dirty, right), rows, start, start + frames)
    before = surprises(taken(dirty, known), rows, start, start + frames)
    stands = before < now + 10.0
    assert stands == (share == 1.0)
    elsewhere, of_another = soft(1, (start + 60) % 100, 9), Known(3, start, right.offset)
    s = taken(dirty, right)
    assert _better(s, [known, of_another], [right, elsewhere]) == [right] * (not stands) + [
        elsewhere
    ]
    assert not (set(map(id, _better(s, [], [right]))) - {id(right)})
    assert _better(taken(dirty, right), [], [right, elsewhere]) == [right, elsewhere]
    assert _better(taken(dirty, right), [known], []) == []


@pytest.mark.parametrize(("seed", "start", "frames"), [(7, 50, 24), (2, 30, 60), (3, 60, 8)])
def test_by_ten_nats_what_is_known_may_explain_less(seed, start, frames):
    clean, right = measured(seed), soft(4, start, frames, 0.4)
    dirty = taken(clean, right, sign=-1.0)

    def known(worse):
        return Known(4, start, (1.0 - worse) * right.offset)

    def by(worse):
        """By how much what is known explains less."""
        with_known, with_right = taken(dirty, known(worse)), taken(dirty, right)
        rows, end = [0, 2, 4], start + frames
        return surprises(with_known, rows, start, end) - surprises(with_right, rows, start, end)

    less, more = 0.0, 0.2
    assert by(less) < 10.0 < by(more)
    for _ in range(9):
        middle = 0.5 * (less + more)
        less, more = (middle, more) if by(middle) < 10.0 else (less, middle)
    for worse, stands in ((less, True), (more, False)):
        s = taken(dirty, right)
        assert _better(s, [known(worse)], [right]) == [right] * (not stands)


def test_what_meets_stands_or_falls_together():
    clean, rows = measured(), [0, 2, 4]
    one, other, far = soft(2, 40, 20, 0.4), soft(4, 55, 20, -0.3), soft(2, 110, 9, 0.5)
    dirty = taken(clean, one, other, far, sign=-1.0)
    half = Known(2, 40, 0.5 * one.offset)
    right = Known(2, 41, one.offset)
    s = taken(dirty, one, other, far)
    assert _better(s, [half], [far, one, other]) == [one, other, far]
    exact = [Known(2, 40, one.offset), Known(4, 55, other.offset)]
    assert _better(taken(dirty, one, other, far), exact, [far, one, other]) == [far]
    assert surprises(taken(dirty, right), rows, 40, 75) > 10.0
    beside = Known(2, 75, np.full(5, 0.2))
    found = _better(taken(dirty, one, other, far), [beside], [one, other])
    assert found == [one, other]  # they touch, but do not meet


# Rounds


def test_lively_errors_are_sought_again_with_what_was_found_out_of_the_scales(monkeypatch):
    s = made(8, cuts=())
    for row in (0, 3):
        s.remove_error(row, 60, np.full(12, 0.2))
        s.update_departures(row, 60, 72)
    bad = np.zeros((6, FRAMES), dtype=bool)
    bad[5, 20:25] = True
    told, limbs, joints = [], [], s.joints.copy()
    measure = s.measure
    monkeypatch.setattr(s, "measure", lambda b: (told.append(b.copy()), measure(b)))
    first, second = soft(0, 60, 12, -0.2), soft(3, 60, 10, -0.2)
    found = iter([[first], [second], [first], [second]])

    class Stub:
        def __init__(self, surprise, limb):
            np.testing.assert_array_equal(surprise.joints, joints)
            limbs.append(limb)
            self.limb, self.found = limb, []

        def next(self):
            return None if self.found else SimpleNamespace(gain=20.0 - self.limb[0])

        def explain(self, top):
            self.found = next(found)
            for e in self.found:
                s.remove_error(e.row, e.start, e.offset)

        def left(self):
            return np.zeros(FRAMES, dtype=bool)

    monkeypatch.setattr(soft_intervals, "Search", Stub)
    lively = np.array([True, True, True, True, False, True])
    wanted = bad | unnaturally_large_twist_increments(s.x, s.y, s.fps)
    assert _lively_errors(s, bad, lively)[0] == [first, second]
    assert limbs == [[0, 2], [1, 3, 5]] * 2
    np.testing.assert_array_equal(told[0], wanted)
    wanted[:] = False
    wanted[0, 60:72] = wanted[3, 60:70] = True
    np.testing.assert_array_equal(told[1], wanted)
    assert len(told) == 2


def test_where_nothing_lively_is_found_it_is_not_sought_again(monkeypatch):
    s = made(8, cuts=())
    s.remove_error(3, 60, np.full(12, 0.2))
    s.update_departures(3, 60, 72)
    limbs = []

    class Stub:
        def __init__(self, surprise, limb):
            limbs.append(limb)
            self.found = []

        def next(self):
            return None

        def left(self):
            return np.zeros(FRAMES, dtype=bool)

    monkeypatch.setattr(soft_intervals, "Search", Stub)
    none = np.zeros((6, FRAMES), dtype=bool)
    assert _lively_errors(s, none.copy(), np.ones(6, dtype=bool))[0] == []
    assert limbs == [[1, 3, 5]]
    assert _lively_errors(s, none.copy(), np.array([True, False] * 3))[0] == []
    assert limbs == [[1, 3, 5]]


# All together


def soft_of(s, known=(), limbs=None):
    searched = search_soft_errors(limbs or s.limbs, s.fps, s.cut, known)
    return searched.found, searched.replaced


@pytest.mark.parametrize("row", [2, 3])
def test_a_silent_joint_tells_what_was_known_wrongly(row):
    s = put_in(with_hinges(row), row, 80, bump())
    (found,), replaced = soft_of(s)
    assert (found.row, replaced, found.unsure) == (row, [], False)
    np.testing.assert_allclose(
        found.offset, bump()[found.start - 80 :][: len(found.offset)], atol=2e-3
    )
    right = Known(row, 80, bump())
    assert soft_of(s, [right]) == ([], [])
    far = Known(row, 180, np.zeros(9))
    for firm in (False, True):
        wrong = Known(row, 80, 0.5 * bump(), firm)
        (again,), replaced = soft_of(s, [wrong, far])
        assert replaced == [wrong]
        np.testing.assert_allclose(again.offset, found.offset, atol=1e-3)
    nothing = Known(row, 180, np.full(12, 0.1))  # where none is
    found, replaced = soft_of(s, [right, nothing])
    assert (found, replaced) == ([], [nothing])


def test_an_error_of_lively_joints_stands_for_what_was_known_wrongly():
    s = made(3, cuts=())
    ramp = np.minimum(1.0, np.minimum(np.arange(1, 31), np.arange(30, 0, -1)) / 6.0)
    s.remove_error(2, 60, -0.4 * ramp)
    _refresh(s)
    limbs = type(s.limbs)(s.joints, s.limbs.axes)
    (found,), replaced = soft_of(s, [], limbs)
    assert (found.row, replaced) == (2, [])
    wanted = np.zeros(FRAMES)
    wanted[60:90] = 0.4 * ramp
    np.testing.assert_allclose(found.offset, wanted[found.start : found.stop], atol=0.05)
    right, wrong = (Known(2, 60, v * ramp) for v in (0.4, 0.15))
    assert soft_of(s, [right], limbs) == ([], [])
    (again,), replaced = soft_of(s, [wrong], limbs)
    assert (again.row, replaced) == (2, [wrong])
    firm = replace(wrong, firm=True)
    assert soft_of(s, [firm], limbs) == ([], [])  # what is firm is not doubted


def half_silent(seed=4):
    """Two limbs, of which only the first has a joint that does not twist."""
    silent, lively = with_hinges(seed), with_hinges(seed + 1, silent=9)
    joints = np.stack([silent.joints[:, 0], lively.joints[:, 1]], axis=1)
    axes = np.stack([silent.limbs.axes[:, 0], lively.limbs.axes[:, 1]], axis=1)
    return type(silent)(Limbs(joints, axes), silent.fps, silent.cut)


@pytest.fixture
def sought(monkeypatch):
    """What lively chains were searched with; `sought.found` is what is found there."""
    noted = SimpleNamespace(found=[], asked=[])

    def seek(surprise, bad, lively):
        noted.asked.append((surprise.joints.copy(), surprise.x.copy(), bad.copy(), lively.copy()))
        return noted.found, np.zeros((2, surprise.frames), dtype=bool)

    monkeypatch.setattr(soft_intervals, "_lively_errors", seek)
    return noted


def test_where_nothing_departs_nothing_is_sought(sought):
    s = half_silent()
    assert soft_of(s) == ([], [])
    assert sought.asked == []
    short = type(s)(Limbs(s.joints[:, :, :14], s.limbs.axes), 120.0, s.cut[:14])
    assert soft_of(put_in(short, 2, 4, bump(4))) == ([], [])


def test_lively_chains_are_searched_without_what_is_known_and_not_doubted(sought):
    s = half_silent()
    firm = Known(5, 200, np.full(9, 0.3), firm=True)
    doubted, kept = Known(1, 100, 0.2 * bump(20)), Known(3, 20, bump(12))
    other = Known(4, 60, bump(20))  # of the silent joint, and right
    for k, offset in ((doubted, bump(20)), (kept, kept.offset), (other, other.offset)):
        s = put_in(s, k.row, k.start, offset)
    known = [firm, doubted, kept, other]
    sought.found = [soft(1, 100, 20, 0.2), soft(5, 203, 9, 0.2), soft(3, 203, 9, 0.2)]
    soft_of(s, known)
    ((joints, x, bad, lively),) = sought.asked
    np.testing.assert_array_equal(lively, [True, True, False, True, False, True])
    wanted = s
    for k in (firm, kept, other):
        wanted = put_in(wanted, k.row, k.start, -k.offset)
    np.testing.assert_allclose(joints, wanted.joints, atol=1e-9)
    np.testing.assert_allclose(x, wanted.x, atol=1e-9)
    without = put_in(wanted, 1, 100, -doubted.offset)
    unlikely = unnaturally_large_twist_increments(without.x, without.y, 120.0)
    unlikely[1, 100:120] = True
    np.testing.assert_array_equal(bad, unlikely)


def test_what_is_found_where_something_firm_stands_is_none(sought):
    s = put_in(half_silent(), 1, 100, bump(20))
    firm = Known(5, 200, np.full(9, 0.01), firm=True)
    beside, elsewhere = soft(3, 205, 9, 0.3), soft(1, 100, 20, 0.3)
    sought.found = [beside, elsewhere]
    found, replaced = soft_of(s, [firm])
    assert [(f.row, f.start) for f in found] == [(1, 100)]
    assert replaced == []
    found, _ = soft_of(s, [replace(firm, firm=False, start=20)])
    assert [(f.row, f.start) for f in found] == [(1, 100), (3, 205)]


def test_what_is_found_where_something_was_doubted_stands_for_it(sought):
    s = put_in(half_silent(), 1, 100, bump(20))
    doubted, near = Known(1, 100, 0.1 * bump(20)), Known(3, 92, np.full(9, 0.001))
    far = Known(1, 121, np.full(3, 0.001))
    sought.found = [SoftError(1, 99, np.r_[0.0, bump(20)], 90.0, 0.01)]
    found, replaced = soft_of(s, [doubted, near, far])
    assert [(f.row, f.start) for f in found] == [(1, 99)]
    assert replaced == [doubted, near]


def test_what_is_found_is_judged_by_increments_as_captured(sought, monkeypatch):
    s = half_silent()
    s = put_in(put_in(s, 1, 100, bump(20)), 2, 150, bump(20))
    judgements = []

    def judge(error, x, y, cut, side, *, last):
        judgements.append((error.row, x.copy(), y.copy(), side, last))
        assert cut is s.cut
        return replace(error, unsure=True)

    monkeypatch.setattr(soft_intervals, "mark_error_if_unsure", judge)
    sought.found = [soft(1, 100, 20, 0.3), soft(5, 180, 9, 0.3)]
    found, _ = soft_of(s, [Known(0, 30, np.full(9, 0.1))])
    assert [f.row for f in found] == [2, 1, 5]
    assert all(f.unsure for f in found)
    assert [(row, side, last) for row, _, _, side, last in judgements] == [
        (2, -1, False),
        (1, 0, False),
        (5, 0, True),
    ]
    for row, x, y, *_ in judgements:
        np.testing.assert_array_equal(x, s.x[row])
        np.testing.assert_array_equal(y, s.y[row])


@pytest.mark.parametrize(("apart", "doubts"), [(3, True), (4, False), (9, False)])
@pytest.mark.parametrize("before", [False, True])
def test_what_is_known_is_doubted_two_frames_beside_what_is_off(apart, doubts, before):
    """A run that is off reaches two frames beyond the level that shows it."""
    known = Known(2, 90, bump(30))
    step = np.full(20, 20.0 * DEGREE)
    start = 90 - apart - 20 if before else 120 + apart
    s = put_in(put_in(with_hinges(4), 2, 90, bump(30)), 2, start, step)
    found, replaced = soft_of(s, [known])
    assert replaced == [known] * doubts
    assert len(found) == 1 + doubts


def test_what_a_firm_interval_says_hides_that_a_joint_seems_silent():
    """Where the limb is straight for most of the time the level that stands is the error."""
    s = with_hinges(4)
    t = np.arange(240) / 120.0
    twists = 0.2 * np.sin(4.0 * t)
    firm, other = (Known(2, 0, twists, f) for f in (True, False))
    assert soft_of(s, [firm]) == ([], [])
    assert soft_of(s, [other]) == ([], [other])


def test_about_right_is_not_enough_beside_a_silent_joint_unless_it_is_firm():
    """It tells to a tenth of a degree what is asked for from one and a half degrees on."""
    s = put_in(with_hinges(2), 2, 80, bump())
    for share, replaces in ((0.97, True), (0.996, False)):  # 0.6 and 0.08 degrees are left
        known = Known(2, 80, share * bump())
        found, replaced = soft_of(s, [known])
        assert replaced == [known] * replaces
        assert [f.row for f in found] == [2] * replaces
        assert soft_of(s, [replace(known, firm=True)]) == ([], [])
