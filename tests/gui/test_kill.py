"""kill -9 in the midst of a review: what was done is there again, and no file is half written.

Of each a few; `python -m benchmarks.kills` does as many as one likes.
"""

import sys

import pytest

from tests.gui.kills import (
    equal_exports,
    killed_in_an_export,
    killed_twice_among_decisions,
    killed_with_a_folder,
)

pytestmark = pytest.mark.thorough


@pytest.mark.parametrize("seed", range(2))
def test_killed_at_random_moments(tmp_path, seed):
    killed_twice_among_decisions(tmp_path, seed)


@pytest.mark.parametrize("seed", range(2))
def test_killed_in_the_midst_of_an_export(tmp_path, seed):
    killed_in_an_export(tmp_path, seed)


def test_exports_are_what_apply_makes_of_their_sessions(tmp_path):
    assert equal_exports(tmp_path, 0, count=3) == 3


@pytest.mark.skipif(sys.platform != "linux", reason="children are told by /proc")
def test_killed_with_a_folder_under_survey_it_leaves_no_process(tmp_path):
    assert killed_with_a_folder(tmp_path, 0)
