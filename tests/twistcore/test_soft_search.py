"""The search for soft errors of a limb, beside a plain one that looks at everything anew."""

import copy
import math

import numpy as np
import pytest

from tests.tiers import parametrize
from tests.twistcore.test_surprise import FRAMES, made
from twistcore.detection.soft_errors import soft_search
from twistcore.detection.soft_errors.explanations import LEVELS, TO_BEGIN, Explanations, Seed
from twistcore.detection.soft_errors.soft_error import SoftError
from twistcore.detection.soft_errors.soft_search import (
    OVER,
    Search,
    explain_seeds_within_budget,
    twist_departure_costs_per_span,
)

DEGREE = math.pi / 180.0


class Explained:
    """Instead of what explains a seed: the free offset of its span, or nothing, as it falls out."""

    made: list[Seed]

    def __init__(self, surprise, place):
        self.made.append(place)
        self._place, self._chance = place, np.random.default_rng([*map(int, vars(place).values())])
        half = place.length // 2 + int(self._chance.integers(0, 4))
        self._start = max(place.middle - half, 1)
        stop = min(place.middle + half, FRAMES - 1)
        frames = np.array([[self._start, stop]])
        (self._offset,), _ = surprise.free_offsets(place.row, frames, self._start, stop)
        self._gain = float(self._chance.choice([50.0, 90.0, 300.0]))
        self._none = self._chance.random() < 0.2
        self._levels = self._chance.random() < 0.5

    def best(self, fit_below):
        if self._none or (fit_below == math.inf and not self._levels):
            return None
        assert fit_below in (10.0, math.inf)
        gain = self._gain + (1.0 if fit_below == math.inf else 0.0)
        return SoftError(self._place.row, self._start, self._offset, gain, 0.01)


@pytest.fixture(autouse=True)
def explained(monkeypatch):
    """Seeds of which it was asked what explains them."""
    monkeypatch.setattr(soft_search, "Explanations", Explained)
    Explained.made = []
    return Explained.made


def erring(seed, many=5):
    """A measured surprise with errors in one limb."""
    rng = np.random.default_rng(seed)
    s = made(seed, cuts=(70,) if seed % 2 else ())
    bad = np.zeros((s.rows, FRAMES), dtype=bool)
    for _ in range(many):
        row, frames = 2 * int(rng.integers(0, 3)), int(rng.integers(4, 40))
        start = int(rng.integers(0, FRAMES - frames))
        size = rng.choice([-1, 1]) * rng.choice([3.0, 6.0, 20.0]) * DEGREE
        s.remove_error(row, start, -size * np.sin(np.linspace(0.1, 3.0, frames)))
        s.update_departures(row, start, start + frames)
        bad[s.neighbours(row), start : start + frames] = True
    s.measure(bad)
    return s


def plain_seed(s, row, k, done, near=(0, FRAMES)):
    best = None
    span = s.at[k].natural.span
    for j, gain in enumerate(twist_departure_costs_per_span(s, k, np.array([row]))[0].tolist()):
        middle = span.step * j + span.reach + span.length // 2
        if (row, middle) in done or not near[0] <= middle <= near[1] or gain <= 0.0:
            continue
        if best is None or gain > best.gain:
            best = Seed(gain, row, k, j, middle, span.length)
    return best


def without(s, error):
    taken = copy.deepcopy(s)
    taken.remove_error(error.row, error.start, error.offset)
    taken.update_departures(error.row, error.start, error.stop)
    return taken


def plain_shortest(s, row, places):
    found = []
    for place in sorted(places, key=lambda p: p.length):
        one = Explained(s, place).best(10.0)
        if one is None:
            continue
        if s.seed_left(row, one.start, one.offset) < 18.0:
            return Explained(s, place).best(math.inf) or one
        found.append(one)
    return max(found, key=lambda e: e.gain / len(e.offset) ** 0.5) if found else None


def lowered_by(s, one):
    """By how much a limb's surprise around an error is lower without it."""
    margin = len(one.offset) // 2 + 8
    window = max(one.start - margin, 0), min(one.stop + margin, FRAMES)
    rows = [r for r in (one.row - 2, one.row, one.row + 2) if 0 <= r < s.rows]
    taken = without(s, one)
    return sum(s.of(r, *window) - taken.of(r, *window) for r in rows)


def plain_best(s, limb, top, done):
    rivals = []
    for row in (top.row - 2, top.row, top.row + 2):
        if row in limb:
            places = []
            for k, a in enumerate(s.at):
                reach = a.natural.span.length // 2 + 2
                place = plain_seed(s, row, k, done, (top.middle - reach, top.middle + reach))
                if place and place.gain > 0.8 * 18.0:
                    places.append(place)
            if found := plain_shortest(s, row, places):
                rivals.append(found)
    lowered = [lowered_by(s, one) for one in rivals]
    if not rivals:
        return None
    first = lowered.index(max(lowered))
    return rivals[first] if max(lowered) > max(45.0, 0.7 * rivals[first].gain) else None


def plain_run(s, limb, in_vain):
    """Soft errors of a limb; how many seeds nothing explained."""
    found, done, vain, every = [], set(), 0, 0
    while vain < in_vain:
        seeds = [plain_seed(s, row, k, done) for row in limb for k in range(len(s.at))]
        seeds = [one for one in seeds if one and one.gain > 18.0]
        if not seeds:
            break
        top = max(seeds, key=lambda one: (round(one.gain), -one.length))
        best = plain_best(s, limb, top, done)
        if best is None:
            vain, every = vain + 1, every + 1
            reach = max(2, top.length // 2)
            done |= {(top.row, t) for t in range(top.middle - reach, top.middle + reach + 1)}
        else:
            vain = 0
            found.append(best)
            s = without(s, best)
    return found, every


def all_found(search):
    explain_seeds_within_budget([search], search._surprise, math.inf)
    return search.found


@parametrize("seed", range(14), quick=4)
def test_the_search_finds_what_a_plain_one_does(seed, monkeypatch):
    in_vain = (20, 3, 1)[seed % 3]
    monkeypatch.setattr(soft_search, "IN_VAIN", in_vain)
    s = erring(seed)
    limb = ([0, 2, 4], [0, 2], [2, 4])[seed % 5 % 3]
    wanted, vain = plain_run(copy.deepcopy(s), limb, in_vain)
    asked = list(Explained.made)
    Explained.made.clear()
    search = Search(s, limb)
    found = all_found(search)
    assert [(f.row, f.start, f.stop, f.gain) for f in found] == [
        (w.row, w.start, w.stop, w.gain) for w in wanted
    ]
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_allclose(one.offset, other.offset, atol=1e-9)
    assert len(Explained.made) <= len(asked)  # what is known is not asked again
    clean = erring(seed)
    for one in found:
        clean = without(clean, one)
    np.testing.assert_allclose(s.joints, clean.joints, atol=1e-9)
    np.testing.assert_allclose(s.x, clean.x, atol=1e-9)
    assert vain <= 20 * (1 + len(found))


def test_searches_find_and_fail():
    """That the comparison above is one: errors are found, and seeds are tried in vain."""
    ended = [plain_run(erring(seed), [0, 2, 4], 20) for seed in (0, 4, 10)]
    assert sum(len(found) for found, _ in ended) >= 4
    assert sum(vain for _, vain in ended) >= 4


@pytest.mark.parametrize(("start", "frames"), [(0, 12), (40, 9), (50, 40), (130, 20)])
def test_what_an_error_gains_is_asked_of_its_chain_and_those_beside(start, frames):
    s = erring(3)
    joints = s.joints.copy()
    search = Search(s, [0, 2, 4])
    for row in (0, 2, 4):
        one = SoftError(row, start, np.full(frames, 0.1), 90.0, 0.01)
        assert search._gain_of_limb(one) == pytest.approx(lowered_by(s, one), abs=1e-6)
    np.testing.assert_allclose(s.joints, joints, atol=1e-12)


def test_a_limb_without_seeds_is_not_searched(explained):
    s = made(2, cuts=())
    s.measure(np.zeros((s.rows, FRAMES), dtype=bool))
    assert all_found(Search(s, [0, 2, 4])) == []
    assert explained == []


def test_a_seed_is_explained_once(explained):
    s = erring(4)
    search = Search(s, [0, 2, 4])
    places = [p for k in range(len(s.at)) if (p := search._seed(2, k))]
    first = search._shortest(2, places)
    many = len(explained)
    assert many > 0
    again = search._shortest(2, places)
    assert len(explained) == many
    assert (first is None) == (again is None)


def test_of_a_span_without_positions_there_is_no_seed():
    s = erring(0)
    search = Search(s, [0])
    search._gain[0, 2] = np.zeros(0)
    assert search._seed(0, 2) is None
    search._gain[0, 2] = np.zeros(5)
    assert search._seed(0, 2) is None
    search._gain[0, 2] = np.array([0.0, 0.5, 0.25, 0.5, 0.0])
    found = search._seed(0, 2)
    assert (found.gain, found.row, found.at, found.position) == (0.5, 0, 2, 1)
    assert found.middle == s.at[2].natural.span.step + 2 + s.at[2].natural.span.length // 2


# A budget


def searches_of(s):
    return [Search(s, [0, 2, 4]), Search(s, [1, 3, 5])]


def counted(monkeypatch, s, cost=10):
    """Gains of the seeds that are explained, in order; each costs so much work."""
    told, explain = [], Search.explain

    def noted(self, top):
        told.append(top.gain)
        s.work += cost
        explain(self, top)

    monkeypatch.setattr(Search, "explain", noted)
    return told


def two_limbs(seed):
    s = erring(seed)
    for start in (20, 90):
        s.remove_error(3, start, np.full(14, 9.0 * DEGREE))
        s.update_departures(3, start, start + 14)
    return s


@pytest.mark.parametrize("seed", [0, 4, 10])
def test_limbs_searched_together_find_what_each_finds_alone(seed):
    alone = [all_found(search) for search in searches_of(two_limbs(seed))]
    s = two_limbs(seed)
    together = searches_of(s)
    assert explain_seeds_within_budget(together, s, math.inf)
    for search, wanted in zip(together, alone, strict=True):
        found = [(f.row, f.start, f.stop, f.gain) for f in search.found]
        assert found == [(w.row, w.start, w.stop, w.gain) for w in wanted]
        assert not search.left().any()


@pytest.mark.parametrize("budget", [1, 30, 55])
def test_a_budget_ends_the_search_where_seeds_say_least(monkeypatch, budget):
    s = two_limbs(4)
    with monkeypatch.context() as patch:
        every = counted(patch, s)
        explain_seeds_within_budget(searches_of(s), s, math.inf)
    s = two_limbs(4)
    s.work = 777  # of an earlier round
    told = counted(monkeypatch, s)
    searches = searches_of(s)
    assert not explain_seeds_within_budget(searches, s, budget)
    assert told == every[: -(-budget // 10)]
    assert len(told) < len(every)


def test_the_search_says_which_frames_it_did_not_look_at(monkeypatch):
    s = two_limbs(4)
    counted(monkeypatch, s)
    searches = searches_of(s)
    explain_seeds_within_budget(searches, s, 15)
    tops = [top for search in searches if (top := search.next()) is not None]
    assert tops
    left = np.array([search.left() for search in searches])
    for top in tops:
        assert left[top.row % 2, top.middle]
    for search in searches:
        search._in_vain = 99  # it would have ended here by itself
        assert not search.left().any()


@pytest.mark.parametrize("spent", [False, True])
def test_a_seed_that_takes_too_much_work_is_left(monkeypatch, spent):
    s = two_limbs(4)
    s.budget = 1000.0
    search = Search(s, [1, 3, 5])
    top = search.next()
    asked = []

    class InVain:
        def __init__(self, surprise, place):
            asked.append(place)
            surprise.work = (OVER + 0.1) * s.budget if spent else 0

        def best(self, gain):
            return None

    monkeypatch.setattr(soft_search, "Explanations", InVain)
    search.explain(top)
    assert len(asked) == 1 or not spent
    assert search.left()[top.middle] or not spent
    assert (search.next() == top) is spent


def test_work_is_counted_by_departures():
    s = erring(4)
    search = Search(s, [0, 2, 4])
    place = search.next()
    one = Explanations(s, place)
    size = TO_BEGIN + one._departures.u.size
    assert s.work == size
    one.best(math.inf)
    assert s.work == (1 + LEVELS) * size
    one.best(math.inf)
    assert s.work == (1 + LEVELS) * size  # what is known costs nothing
