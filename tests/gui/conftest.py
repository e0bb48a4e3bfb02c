"""Every test of a window begins without what an earlier one left beside the clips."""

import pytest

from tests.conftest import ASSETS


@pytest.fixture(autouse=True)
def nothing_left_over(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    yield
    for pattern in ("*.journal*", "*.twist.json*"):
        for path in ASSETS.glob(pattern):
            path.unlink()
