"""A trial sees every way to fail, goes on behind it, and says how it is made again."""

import sys

import pytest

from tests.fuzz.trial import (
    ENDED,
    HUNG,
    LARGE,
    READ,
    REFUSED,
    TRACEBACK,
    UNWORDED,
    files_of,
    kind_of,
    kinds,
    trial,
)

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="the bounds are those of Linux")


@pytest.mark.parametrize(
    ("name", "outcome"),
    [
        ("refused", REFUSED),
        ("traceback", TRACEBACK),
        ("unclosed", TRACEBACK),
        ("unworded", UNWORDED),
        pytest.param("large", LARGE, marks=LINUX),
        pytest.param("no-memory", LARGE, marks=LINUX),
        pytest.param("hung", HUNG, marks=pytest.mark.thorough),
        ("ended", ENDED),
    ],
)
def test_every_way_to_fail_is_seen(name, outcome):
    report = trial(
        kind_of("tests.fuzz.failing", f"failing-{name}"), 3, 5, wait=10 if name == "hung" else 60
    )
    assert report.counts == {READ: 2, outcome: 1}
    assert [one.case for one in report.failures] == ([] if outcome == REFUSED else [1])


def test_a_case_is_made_again_by_its_number():
    for kind in kinds().values():
        assert files_of(kind, 7, 3) == files_of(kind, 7, 3)
