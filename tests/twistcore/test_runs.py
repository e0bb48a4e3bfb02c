"""Spans that overlap are one group, whichever of them reaches farthest."""

import pytest

from twistcore.detection.noise_bursts import NoiseBurst
from twistcore.skeleton.runs import group_overlapping_spans


@pytest.mark.parametrize(
    ("apart", "groups"),
    [
        (0, [[(0, 30), (5, 10), (20, 40)], [(40, 50)], [(53, 60)]]),
        (1, [[(0, 30), (5, 10), (20, 40), (40, 50)], [(53, 60)]]),
        (3, [[(0, 30), (5, 10), (20, 40), (40, 50)], [(53, 60)]]),
        (4, [[(0, 30), (5, 10), (20, 40), (40, 50), (53, 60)]]),
    ],
)
def test_groups_are_apart_by_so_many_frames(apart, groups):
    spans = [NoiseBurst(0, a, b, 1.0) for group in groups for a, b in group]
    found = group_overlapping_spans(spans, apart)
    assert [[(s.start, s.stop) for s in group] for group in found] == groups


def test_of_nothing_there_is_no_group():
    assert group_overlapping_spans([]) == []
