"""Our joints are where an independent reader puts them; runs where pybvh is installed."""

import sys

import pytest

from tests.conftest import ASSETS
from tests.messages import numbers

pytest.importorskip("pybvh")

from benchmarks import crosschecks
from benchmarks.bvh_crosscheck import MOST, corrected, differences


@pytest.mark.parametrize("name", ["walk", "dance", "basketball", "walk_injected"])
def test_positions_agree_with_pybvh_as_read_and_rewritten(name):
    read, written = differences(ASSETS / f"{name}.bvh")
    assert read <= 1e-9
    assert written <= 1e-6


@pytest.mark.parametrize("name", ["walk_injected", "kick"])
def test_positions_agree_with_pybvh_after_correction(name):
    after, moved = corrected(ASSETS / f"{name}.bvh")
    assert after <= MOST[2]
    assert (moved > 0.01) == (name == "kick"), "a twist moves no joint, a limb's flip its knee"


def test_everything_that_is_checked_is_told(tmp_path, monkeypatch, capsys):
    for name, text in {"good": (ASSETS / "walk.bvh").read_bytes(), "bad": b"HIERARCHY\n"}.items():
        (tmp_path / f"{name}.bvh").write_bytes(text)
    monkeypatch.setattr(sys, "argv", ["crosschecks", str(tmp_path), "--uncorrected"])
    assert crosschecks.main() == 0
    *lines, counts, pybvh = capsys.readouterr().out.splitlines()
    assert "bad.bvh  refused" in lines[0]
    assert "good.bvh  read  344 frames, 31 joints" in lines[1]
    assert numbers(counts)[:4] == [2, 1, 1, 0]
    assert numbers(pybvh)[:2] == [1, 0]
    for wrong in (
        {"comes_back": lambda _clip: False},
        {"comes_back": lambda _clip: 1 / 0},
        {"comes_back": lambda _clip: True, "_by_pybvh": lambda *_: (0.0, float("nan"))},
    ):
        for name, value in wrong.items():
            monkeypatch.setattr(crosschecks, name, value)
        assert crosschecks.main() == 1
