"""A correction that makes something worse is left to a person; all others are as they were."""

import gc
import math
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.analysis.correction.protected_measures import (
    PATH,
    ROLL,
    SHARE,
    TOLERANCE,
    restrict_interval_to_frames,
)
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.detection import Interval, Kind
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.limb import Limb

WALK = read_bvh(ASSETS / "walk.bvh").motion
INJECTED = read_bvh(ASSETS / "walk_injected.bvh").motion
FLIPPED = read_bvh(ASSETS / "kick.bvh").motion


@pytest.fixture(scope="module")
def walk():
    return analyse(WALK)


def find(chain, degrees, start=100, stop=110, **more):
    offset = np.full(stop - start, math.radians(degrees))
    return Interval(chain, start, stop, offset, **{"confidence": 0.9, **more})


def test_a_find_that_makes_something_worse_is_open_and_says_why(walk):
    made_up = find("LeftForeArm", 35.0)
    left = walk.protected(made_up)
    assert left.open
    assert not automatic_corrections([left])
    assert automatic_corrections([left], include_open=True)
    assert left.evidence["worse"] == [ROLL]
    (doubt,) = left.evidence["doubts"]
    assert doubt.startswith("in one frame, the wrist would turn by 3")
    assert "° instead of" in doubt
    assert (left.start, left.stop, left.confidence) == (100, 110, 0.9)
    assert np.array_equal(left.offset, made_up.offset)


def test_what_was_said_before_is_still_said_and_nothing_twice(walk):
    knee = find("LeftUpLeg", 12.0, 235, 239, explain=lambda: {"gain": 3.0, "doubts": ["so what"]})
    evidence = walk.protected(knee).evidence
    assert evidence["gain"] == 3.0
    assert evidence["doubts"] == [
        "the knee would bend 12° further out of its hinge plane",
        "so what",
    ]
    again = replace(
        knee, explain=lambda: {"doubts": ["the knee would bend 12° further out of its hinge plane"]}
    )
    assert walk.protected(again).evidence["doubts"] == [
        "the knee would bend 12° further out of its hinge plane"
    ]


def test_what_makes_nothing_worse_and_what_is_not_automatic_is_the_same_find(walk):
    error = find("LeftForeArm", 35.0)
    wrong = analyse(refine(WALK, walk.chains, [error.with_offset(100, -error.offset)]))
    assert wrong.protected(error) is error
    for stays in (
        replace(error, open=True),
        replace(error, confidence=None),  # the paper's, taken at its word
        replace(error, kind=Kind.LONE_JUMP, residual=1.0),
        replace(error, kind=Kind.HELPER_ROLL),
    ):
        assert walk.protected(stays) is stays


@pytest.mark.parametrize("motion", [INJECTED, FLIPPED], ids=["twists", "flips"])
def test_finds_of_real_errors_stay_automatic(motion, monkeypatch):
    now = automatic_corrections(analyse(motion).detect())
    monkeypatch.setattr(ClipAnalysis, "protected", lambda *given: given[1])
    before = automatic_corrections(analyse(motion).detect())
    assert before
    assert [(i.chain, i.start, i.stop) for i in now] == [(i.chain, i.start, i.stop) for i in before]


@pytest.mark.parametrize(
    ("motion", "name"), [(INJECTED, ROLL), (FLIPPED, PATH)], ids=["twists", "flips"]
)
def test_detection_gives_out_the_same_open_finds_each_time(motion, name, monkeypatch):
    monkeypatch.setitem(TOLERANCE, name, -1e9)  # so that everything is worse
    monkeypatch.setitem(SHARE, name, -1e9)
    analysis = analyse(motion)
    found = analysis.detect()
    vetoed = [i for i in found if name in (i.evidence or {}).get("worse", ())]
    assert vetoed
    assert all(i.open for i in vetoed)
    wrong = Limb if name == PATH else object
    assert not [
        i for i in automatic_corrections(found) if isinstance(analysis.chain(i.chain), wrong)
    ]
    assert all(a is b for a, b in zip(found, analysis.detect(), strict=True))
    chosen = analyse(motion, [vetoed[0].chain]).detect()
    assert [i.open for i in chosen if (i.start, i.stop) == (vetoed[0].start, vetoed[0].stop)] == [
        True
    ]


def test_a_find_that_is_gone_is_not_kept(walk):
    gc.collect()
    before = len(walk._protected)
    for degrees in range(30, 40):
        walk.protected(find("LeftForeArm", degrees))
        walk.protected(find("LeftForeArm", 0.1))
    gc.collect()
    assert len(walk._protected) == before


def test_the_correction_of_one_error_is_judged_with_the_others_beside_it():
    """Two errors in a row: without the second the first one's correction leaves a larger step."""
    one, two = find("RightArm", 60.0, 100, 120), find("RightArm", 110.0, 120, 140)
    taken = [i.with_offset(i.start, -i.offset) for i in (one, two)]
    wrong = analyse(refine(WALK, analyse(WALK).chains, taken))
    wrong._sure["consistency"] = (one, two)
    assert wrong.protected(one) is one
    assert wrong.protected(two) is two
    alone = analyse(wrong.motion)
    alone._sure["consistency"] = (one,)
    assert alone.protected(one).open


@pytest.mark.parametrize("held", [1, 2, 4])
def test_held_frames_are_no_frames_of_their_own(held):
    """90° a frame are too fast at 120 frames a second, but not at the 30 that are held."""
    slow = replace(WALK, rotations=WALK.rotations[::4], positions=WALK.positions[::4])
    slow = replace(slow, frame_time=4.0 * WALK.frame_time)
    at = np.arange(slow.frames).repeat(held)
    motion = replace(slow.at(at), frame_time=slow.frame_time / held)
    made_up = find("RightArm", 90.0, 20 * held, 25 * held)
    left = analyse(motion).protected(made_up)
    assert "impossible turns" not in (left.evidence or {}).get("worse", ())
    assert left.open  # its forearm would turn by 90° in one frame


def test_a_correction_of_linear_keys_is_judged_at_the_keys():
    kept = np.arange(0, WALK.frames - 4, 4)
    keys = restrict_interval_to_frames(find("RightArm", 90.0, 40, 81), kept)
    assert (keys.start, keys.stop, len(keys.offset)) == (10, 21, 11)
    assert not restrict_interval_to_frames(find("RightArm", 90.0, 41, 43), kept).frames
