"""A first guess for an interval made by hand."""

import numpy as np
import pytest

from twistcore.review.proposal import proposed_interval
from twistcore.signals import TwistSignals

FPS = 100.0


def signals(theta_p, strength):
    """Only what a proposal looks at; the rest would be seen if it were used."""
    nothing = np.full(len(theta_p), np.nan)
    return TwistSignals(theta_p, nothing, nothing, nothing, strength, nothing, nothing)


def with_error(frames, start, stop, delta, edges):
    """Twist that drifts, with an error of `delta` radians in [start, stop)."""
    theta_p = 0.002 * np.arange(frames)
    theta_p[start:stop] += delta
    strength = np.full(frames, 0.001)
    for at, size in edges:
        strength[at] = size
    return signals(theta_p, strength)


@pytest.mark.parametrize("frame", [90, 100, 119])
def test_the_strongest_counter_rotations_round_the_frame_are_the_edges(frame):
    edges = [(90, 0.5), (120, 0.5), (85, 0.1), (130, 0.1), (100, 0.05)]
    found = proposed_interval("LeftArm", with_error(300, 90, 120, 0.5, edges), frame, FPS)
    assert (found.chain, found.start, found.stop) == ("LeftArm", 90, 120)
    # The drift of twist that goes on under the error is not taken for a part of it.
    np.testing.assert_allclose(found.offset, np.full(30, 0.5), atol=1e-12)


def test_edges_further_than_half_a_second_are_not_taken():
    edges = [(90, 0.5), (200, 0.5), (120, 0.1)]
    found = proposed_interval("LeftArm", with_error(300, 90, 200, 0.5, edges), 100, FPS)
    assert (found.start, found.stop) == (90, 120)


def test_edges_of_less_than_a_degree_are_none():
    weak = 0.9 * np.radians(1.0)
    quiet = with_error(300, 90, 120, 0.0, [(90, weak), (120, weak)])
    assert proposed_interval("LeftArm", quiet, 100, FPS).frames == 11  # 0.1 s round the frame
    first = proposed_interval("LeftArm", quiet, 0, FPS)
    assert (first.start, first.stop) == (0, 11)
    last = proposed_interval("LeftArm", quiet, 299, FPS)
    assert (last.stop, 299 in range(last.start, last.stop)) == (300, True)


def test_with_one_edge_the_other_lies_a_tenth_of_a_second_away():
    begins = proposed_interval("A", with_error(300, 90, 300, 0.5, [(90, 0.5)]), 95, FPS)
    assert (begins.start, begins.stop) == (90, 101)
    ends = proposed_interval("A", with_error(300, 0, 120, 0.5, [(120, 0.5)]), 115, FPS)
    assert (ends.start, ends.stop) == (109, 120)
