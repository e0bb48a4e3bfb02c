"""What a change leaves of a review: ids that are never given twice, and the offsets wanted."""

from dataclasses import replace

import numpy as np
import pytest

from twistcore.detection import Interval
from twistcore.detection.interval_offsets import (
    new_constant_offset_interval,
    same_offsets,
    with_offset_of_size,
    with_offset_replaced_by_median,
)
from twistcore.review import Redetect, start_review

ARM, LEG = "Arm", "Leg"


def a_soft(degrees=20.0):
    course = np.radians(degrees) * np.array([0.1, 0.5, 1.0, 0.9, 0.8, 0.4, 0.1])
    return Interval(ARM, 10, 17, course, 0.9)


def found_at(*starts):
    return [
        new_constant_offset_interval(chain, t, t + 4, 0.3) for chain in (ARM, LEG) for t in starts
    ]


def test_ids_go_on_from_chain_to_chain_and_are_never_given_twice():
    state = start_review("own", {ARM: 0.1, LEG: 0.2}, found_at(10, 30), (ARM, LEG))
    assert (sorted(j.id for j in state.intervals), state.next_id) == ([1, 2, 3, 4], 5)
    ids = {1, 2, 3, 4}
    for starts in ((50, 70), (90, 110, 130), (10,)):
        before = state.next_id
        state = Redetect({ARM: 0.3, LEG: 0.3}, tuple(found_at(*starts))).apply(state)
        new = {j.id for j in state.intervals}
        assert len(new) == 2 * len(starts)
        assert not new & ids
        assert min(new) == before
        assert state.next_id == max(new) + 1
        ids |= new


def test_a_flattened_interval_has_its_median_offset_everywhere():
    found = with_offset_replaced_by_median(a_soft())
    assert (found.start, found.stop, found.chain) == (10, 17, ARM)
    np.testing.assert_allclose(found.offset, np.full(7, np.radians(10.0)))


@pytest.mark.parametrize("degrees", [-30.0, 5.0, 20.0])
def test_a_soft_interval_is_stretched_to_its_largest_offset(degrees):
    found = with_offset_of_size(a_soft(), np.radians(degrees))
    np.testing.assert_allclose(found.offset, a_soft(degrees).offset, atol=1e-12)
    assert found.start == 10


def test_offsets_are_the_same_but_for_rounding():
    one = a_soft()
    assert same_offsets(one, replace(one, offset=one.offset + 1e-13))
    assert not same_offsets(one, replace(one, offset=one.offset * 1.0001))
    small = replace(one, offset=1e-9 * one.offset)
    assert not same_offsets(small, replace(one, offset=2.0 * small.offset))
    for other in ({"start": 9, "stop": 16}, {"carried": True}):
        assert not same_offsets(one, replace(one, **other))
