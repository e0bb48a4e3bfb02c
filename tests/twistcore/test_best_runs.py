"""Runs of neighbouring chains: of all sets of them that which gains most, and nothing by chance."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.tiers import examples
from twistcore.detection.counter_twist.best_runs import best_runs

runs = st.tuples(st.integers(0, 1), st.integers(0, 6), st.integers(1, 3), st.integers(-25, 30))


def chosen(found, lone=18.0):
    frame, first, length, gain = (np.array(v, dtype=np.int64) for v in zip(*found, strict=True))
    return best_runs(frame, first, first + length, gain.astype(float), lone).tolist()


@settings(max_examples=examples(200))
@given(st.lists(runs, min_size=1, max_size=9))
def test_runs_without_a_common_joint_gain_most_together(found):
    def worth(some):
        """What a set gains: more by 18 if there is one at all, none where joints are shared."""
        joints = [j for k in some for j in range(found[k][1], found[k][1] + found[k][2] + 1)]
        shared = len(set(joints)) < len(joints)
        return -np.inf if shared else sum(found[k][3] for k in some) + 18.0 * bool(some)

    taken = chosen(found)
    for frame in (0, 1):
        here = [k for k in range(len(found)) if found[k][0] == frame]
        sets = (some for n in range(len(here) + 1) for some in combinations(here, n))
        assert worth([k for k in taken if k in here]) == max(map(worth, sets))


@pytest.mark.parametrize("gain", [12, -5])
def test_of_equals_the_shorter_run_and_the_one_nearer_to_the_tip(gain):
    assert chosen([(0, 2, 2, gain), (0, 2, 1, gain), (0, 2, 3, gain)]) == [1]
    assert chosen([(0, 2, 2, gain), (0, 3, 2, gain), (0, 1, 2, gain)]) == [1]


def test_what_gains_nothing_beside_others_may_be_the_one_run_of_its_frame():
    assert chosen([(0, 0, 1, -17)]) == [0]
    assert chosen([(0, 0, 1, -18)]) == chosen([(0, 0, 1, -19)]) == []
    assert chosen([(0, 0, 1, -17), (0, 4, 1, -5), (1, 0, 1, 3), (1, 4, 1, -5)]) == [2, 1]
    assert chosen([(0, 0, 1, 0)], lone=0.0) == []


def test_no_runs_are_none():
    none = np.zeros(0, dtype=np.int64)
    assert best_runs(none, none, none, np.zeros(0), 18.0).tolist() == []
