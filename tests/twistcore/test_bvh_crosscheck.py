"""Our joints are where an independent reader puts them; runs where pybvh is installed."""

import pytest

from tests.conftest import ASSETS

pytest.importorskip("pybvh")

from benchmarks.bvh_crosscheck import differences


@pytest.mark.parametrize("name", ["walk", "dance", "basketball", "walk_injected"])
def test_positions_agree_with_pybvh_as_read_and_rewritten(name):
    read, written = differences(ASSETS / f"{name}.bvh")
    assert read <= 1e-9
    assert written <= 1e-6
