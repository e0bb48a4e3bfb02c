"""Many clips: how bad one is."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore.reviews import find_flips, flip
from twistcore.batch import severity, survey
from twistcore.review.model import constant
from twistcore.tuning import Profile


def test_severity_is_the_mean_error_a_frame_weighed_by_confidence():
    error = constant("LeftArm", 10, 20, np.radians(-30.0))  # 300° over ten frames
    assert severity([error], 100) == pytest.approx(3.0)
    assert severity([replace(error, confidence=0.25)], 100) == pytest.approx(0.75)
    assert severity([replace(error, confidence=0.0)], 100) == 0.0
    assert severity([error, replace(error, chain="LeftLeg", confidence=0.5)], 50) == pytest.approx(
        9
    )


def test_an_interval_without_a_second_edge_makes_no_clip_bad():
    error = constant("LeftArm", 10, 20, 0.5)
    assert severity([replace(error, open=True)], 100) == 0.0
    assert severity([], 0) == 0.0


def test_flips_of_limbs_make_a_clip_bad(monkeypatch):
    find_flips(monkeypatch, flip(confidence=0.5), flip(start=20, stop=30, open=True))
    found = survey(ASSETS / "walk.bvh")
    assert found.intervals == 2
    assert found.severity == pytest.approx(8 * 170.0 * 0.5 / found.frames)
    high = Profile({"RightUpLeg-RightFoot": np.radians(175.0)})
    assert survey(ASSETS / "walk.bvh", high).intervals == 0


def test_a_clip_in_which_nothing_can_be_checked_is_not_called_clean(tmp_path):
    assert survey(ASSETS / "walk.bvh").unchecked == ""
    lines = (ASSETS / "walk.bvh").read_text("utf-8").splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("Frames:"))
    short = [*lines[:at], "Frames: 2", lines[at + 1], *lines[at + 2 : at + 4]]
    (tmp_path / "short.bvh").write_text("\n".join(short) + "\n", "utf-8")
    told = survey(tmp_path / "short.bvh").unchecked
    assert told == "2 frames are too few to tell error from motion"
    (tmp_path / "ball.bvh").write_text(
        "HIERARCHY\nROOT Ball\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n"
        "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 100\nFrame Time: 0.01\n"
        + "0 0 0\n"
        * 100,
        "utf-8",
    )
    assert "no arm or leg" in survey(tmp_path / "ball.bvh").unchecked
