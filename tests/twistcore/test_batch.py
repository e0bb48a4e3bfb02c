"""Many clips: how bad one is."""

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.severity_order import jumps_a_second
from tests.conftest import ASSETS
from tests.twistcore.reviews import find_flips, flip, spun
from twistcore.analysis.clip_severity import severity_of_intervals
from twistcore.batch import survey_clip
from twistcore.detection import Interval, Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.tuning import Profile

CHAINS = {c.name: c for c in find_chains(read_bvh(ASSETS / "walk.bvh").motion)}


def bad(*intervals, frames=100, fps=10.0):
    return severity_of_intervals([(i, CHAINS[i.chain]) for i in intervals], frames, fps)


def test_severity_is_the_root_mean_square_weighed_by_confidence_and_joint():
    error = new_constant_offset_interval(
        "LeftArm", 10, 19, np.radians(-30.0)
    )  # with 0.1 s of edge ten frames
    assert bad(error) == pytest.approx(30.0 * math.sqrt(0.1))
    assert bad(replace(error, confidence=0.25)) == pytest.approx(15.0 * math.sqrt(0.1))
    assert bad(replace(error, confidence=0.0)) == 0.0
    assert bad(replace(error, chain="LeftUpLeg")) == bad(error)
    for chain in ("LeftShoulder", "LeftForeArm", "LeftLeg"):
        assert bad(replace(error, chain=chain)) == pytest.approx(0.7 * bad(error))
    assert bad(error, error) == pytest.approx(math.sqrt(2.0) * bad(error))
    assert bad() == bad(frames=0) == 0.0


def test_a_find_left_to_a_person_counts_as_it_is_sure():
    error = new_constant_offset_interval("LeftArm", 10, 20, 0.5)
    assert bad(replace(error, open=True)) == bad(error)


def test_what_moves_counts_by_how_far_and_what_turns_by_how_much_hangs_on_it():
    def found(kind, degrees=0.0, **evidence):
        turn, explain = np.radians(degrees), evidence and (lambda: evidence)
        return Interval("LeftLeg", 30, 31, np.zeros(1), residual=turn, kind=kind, explain=explain)

    moved = [bad(found(Kind.PLACE_JUMP, way_percent=way)) for way in (35.0, 7.0)]
    assert moved == pytest.approx([4.5, math.degrees(math.atan(0.2)) / 10.0])  # 45° at 35 %
    assert bad(found(Kind.PLACE_JUMP)) == bad(found(Kind.PLACE_JUMP, way_percent=0.0)) == 0.0
    spikes = [bad(found(Kind.SPIKE, 40.0, reach=reach)) for reach in (0.07, 0.35, 0.7)]
    assert spikes == pytest.approx([0.8, 4.0, 4.0])
    assert bad(found(Kind.SPIKE, 40.0)) == pytest.approx(2.8)  # as the segment of its chain


def test_jumps_that_nothing_takes_out_make_a_clip_bad():
    jump = Interval(
        "LeftLeg", 30, 31, np.zeros(1), open=True, residual=np.radians(160.0), kind=Kind.LONE_JUMP
    )
    assert bad(*[jump] * 6, frames=3600, fps=120.0) > 5.0


def test_a_knee_on_the_wrong_side_outweighs_a_small_guess_that_lasts():
    knee = new_constant_offset_interval("LeftUpLeg", 30, 40, np.radians(175.0))
    knee = replace(knee, kind=Kind.LIMB_FLIP, confidence=0.95)
    guess = replace(
        new_constant_offset_interval("RightForeArm", 0, 2200, np.radians(8.0)), confidence=0.5
    )
    frames = {"frames": 2400, "fps": 120.0}
    assert bad(knee, **frames) > 3.0 * bad(guess, **frames)


def test_flips_of_limbs_make_a_clip_bad(monkeypatch):
    find_flips(monkeypatch, flip(confidence=0.5), flip(start=20, stop=30, open=True))
    found = survey_clip(ASSETS / "walk.bvh")
    assert found.intervals == 2
    lasts = found.fps * 0.1
    squares = 0.5 * (8 + lasts) + 0.97 * (10 + lasts)
    assert found.severity == pytest.approx(1.5 * 170.0 * math.sqrt(squares / found.frames))
    high = Profile({"RightUpLeg-RightFoot": np.radians(175.0)})
    assert survey_clip(ASSETS / "walk.bvh", high).intervals == 0


def test_a_clip_in_which_nothing_can_be_checked_is_not_called_clean(tmp_path):
    assert survey_clip(ASSETS / "walk.bvh").unchecked == ""
    lines = (ASSETS / "walk.bvh").read_text("utf-8").splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("Frames:"))
    short = [*lines[:at], "Frames: 2", lines[at + 1], *lines[at + 2 : at + 4]]
    (tmp_path / "short.bvh").write_text("\n".join(short) + "\n", "utf-8")
    reported = survey_clip(tmp_path / "short.bvh").unchecked
    assert reported.startswith("2 frames ")
    (tmp_path / "ball.bvh").write_text(
        "HIERARCHY\nROOT Ball\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n"
        "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 100\nFrame Time: 0.01\n"
        + "0 0 0\n"
        * 100,
        "utf-8",
    )
    assert survey_clip(tmp_path / "ball.bvh").unchecked


def test_a_plain_count_of_jumps_knows_a_joint_that_jumps():
    walk = read_bvh(ASSETS / "walk.bvh").motion
    assert jumps_a_second(walk) == 0.0
    jumping = spun("LeftFoot", 100, 110, 170.0, walk)
    assert jumps_a_second(jumping) * walk.frames / walk.fps >= 2.0
    assert jumps_a_second(walk.sliced(0, 3)) == 0.0
