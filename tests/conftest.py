"""What many tests need: the sample clips and small skeletons made in memory."""

from pathlib import Path

import pytest

from twistcore.bvh import Clip, read_bvh

ASSETS = Path(__file__).parent.parent / "assets"


@pytest.fixture(scope="session")
def walk() -> Clip:
    return read_bvh(ASSETS / "walk.bvh")


@pytest.fixture(scope="session")
def dirty_walk() -> Clip:
    return read_bvh(ASSETS / "walk_injected.bvh")


@pytest.fixture(scope="session", params=["walk", "dance", "basketball", "walk_injected"])
def sample(request: pytest.FixtureRequest) -> Clip:
    return read_bvh(ASSETS / f"{request.param}.bvh")
