"""Intervals that set in softly: how they are told, shown and edited, and what peaks beside say."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.reasons import wrong
from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from twistcore.analysis.clip_analysis import analyse, detect
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.analysis.why_not import Why, why_frame_bounds_no_interval
from twistcore.cli import main
from twistcore.detection import Interval
from twistcore.detection.consistency.chain_analysis import FixedInterval
from twistcore.detection.interval_offsets import with_offset_of_size
from twistcore.detection.soft_onset import describe_soft_onset, rise_and_fall_frames
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import write_clip
from twistcore.review import Review
from twistcore.skeleton.chain import find_chains

CLIP = read_bvh(ASSETS / "walk.bvh")
RAMP = np.radians(np.concatenate([np.arange(1, 13), np.full(10, 13), np.arange(12, 0, -1)]) * 6.0)
EVIDENCE = {"gain": 61.5, "follows": "a soft onset", "sigma_deg": 0.5}


def soft(offset=RAMP, start=40):
    return Interval("LeftArm", start, start + len(offset), offset, 0.9, explain=EVIDENCE.copy)


def level(degrees, frames=12):
    return Interval("LeftArm", 40, 40 + frames, np.full(frames, np.radians(degrees)), 0.9)


@pytest.fixture(scope="module")
def ramped():
    """The walk with an error of the right arm and one of the right leg that ramp in and out."""
    offsets = {name: np.zeros(CLIP.motion.frames) for name in ("RightShoulder", "RightLeg")}
    offsets["RightShoulder"][80 : 80 + len(RAMP)] = -RAMP
    offsets["RightLeg"][200 : 200 + len(RAMP)] = RAMP
    return remove_twist(CLIP.motion, find_chains(CLIP.motion), offsets)


def test_how_long_an_onset_takes_and_how_many_times_its_scale_it_is():
    course = np.radians([0.0, 0.4, 0.5, 5.0, 9.0, 10.0, 10.0, 8.9, 0.5, 0.4])
    assert rise_and_fall_frames(course) == (3, 3)
    assert rise_and_fall_frames(-course[::-1]) == (3, 3)
    assert rise_and_fall_frames(np.array([0.0, 0.0, 1.0, 1.0])) == (1, 1)

    def told(sigma):
        evidence = {**EVIDENCE, "sigma_deg": sigma}
        return describe_soft_onset(Interval("A", 0, 10, course, 0.9, explain=evidence.copy))

    assert names_in_one_line(told(1.0), " 3 frames", "10 times", "1.00°")
    assert names_in_one_line(told(1.02), "9.8 times", "1.02°")
    assert "20 times" in told(0.5)
    sudden = Interval("A", 0, 4, np.radians([0.0, 5.0, 5.0, 1.0]), 0.9, explain=EVIDENCE.copy)
    assert numbers(describe_soft_onset(sudden))[:2] == [1, 2]


def test_an_onset_is_told_in_plain_words():
    assert rise_and_fall_frames(RAMP) == (12, 12)
    assert rise_and_fall_frames(np.zeros(0)) == (0, 0)
    assert numbers(describe_soft_onset(soft(-RAMP))) == [12, 12, 34, 78, 156, 0.5]
    assert describe_soft_onset(level(20.0)) == ""


def test_a_soft_interval_is_shown_by_its_largest_offset_and_an_ordinary_one_by_its_median():
    assert soft().soft_ended
    assert soft().shown == soft().largest == RAMP.max()
    assert soft(RAMP[12:]).soft_ended  # it jumps in and ramps out
    plain = level(20.0)
    assert not plain.soft_ended
    assert plain.shown == plain.size == plain.delta
    assert (soft().seen_at, plain.seen_at) == (51, 40)


def test_its_course_is_stretched_where_an_ordinary_one_is_moved():
    edited = with_offset_of_size(soft(), np.radians(-39.0))
    np.testing.assert_allclose(edited.offset, -0.5 * RAMP, atol=1e-12)
    assert with_offset_of_size(level(20.0), 1.0).delta == pytest.approx(1.0)


def test_explain_and_json_have_soft_intervals(ramped, tmp_path, capsys):
    path = tmp_path / "ramped.bvh"
    write_clip(CLIP, ramped, path)
    main(["detect", str(path), "--explain"])
    told = capsys.readouterr().out
    assert len(re.findall(r" 12 frames.* 12\b", told)) == 2
    main(["detect", str(path), "--explain", "--json"])
    found = json.loads(capsys.readouterr().out)["intervals"]
    least = {True: (), False: ("--min-confidence", "0")}
    for default, words in least.items():
        main(["refine", str(path), "-o", str(tmp_path / "out.bvh"), *words])
        said = capsys.readouterr().out
        sure = sum(i["confidence"] >= 0.5 for i in found) if default else len(found)
        assert f": {sure} of {len(found)} intervals" in said
    review = Review.of(detect(read_bvh(path)))
    assert review.accept(0.0) == len(found)


def test_every_peak_beside_a_soft_error_has_a_reason(ramped):
    found = analyse(ramped).detect()
    for name in found.tau:
        assert wrong(found, name)[1] == []


def test_intervals_between_jumps_give_way_where_a_soft_error_stands(ramped):
    own = analyse(ramped).by().chains["RightLeg"]
    given = Interval("RightLeg", 190, 240, np.full(50, 0.2))
    assert own.is_replaced(given)
    assert not own.is_replaced(Interval("RightLeg", 20, 40, np.full(20, 0.2)))


def test_below_tau_a_soft_error_is_named_at_its_peak(ramped):
    clip = analyse(ramped)
    standing: tuple[FixedInterval, ...] = clip.by().chains["RightLeg"].fixed
    (error,) = standing
    found = clip.detect(tau_radians={"RightLeg": error.strength + 0.01})
    assert not [i for i in found if i.chain == "RightLeg" and i.start == error.interval.start]
    reason = why_frame_bounds_no_interval(found, "RightLeg", error.peak)
    assert reason.why == Why.BELOW


@pytest.mark.parametrize(("chain", "why"), [("RightForeArm", Why.OTHER), ("RightArm", Why.IMAGE)])
def test_an_edge_of_what_gave_way_names_what_stands_instead(chain, why):
    """An interval between jumps, and a soft error in its chain or in that before."""
    offset = np.zeros(CLIP.motion.frames)
    offset[120:140] = 0.5
    clip = analyse(remove_twist(CLIP.motion, find_chains(CLIP.motion), {"RightForeArm": offset}))
    analysis = clip.by()
    margin = 3 if why == Why.OTHER else -20  # within, or beyond: no edge of it is at the jumps
    error = soft(np.full(20 - 2 * margin, 0.5), 120 + margin)
    standing = FixedInterval(replace(error, chain=chain), 0.5, error.start)
    chains = {
        name: own.with_soft(
            [standing] if name == chain else [], [(120, 140)] if name == "RightForeArm" else []
        )
        for name, own in analysis.chains.items()
    }
    clip._by_method["consistency"] = replace(analysis, chains=chains, witnesses={})
    found = clip.detect()
    assert [i.start for i in found if i.chain == "RightForeArm"] == [123] * (why == Why.OTHER)
    reason = why_frame_bounds_no_interval(found, "RightForeArm", 120)
    assert (reason.why, reason.suspicious) == (why, why == Why.OTHER)
    own, other = "frames 120–140 (−28.6°)", f"frames {error.start}–{error.stop}"
    assert names_in_one_line(reason.text, own, other)
    assert wrong(found, "RightForeArm")[1] == []
