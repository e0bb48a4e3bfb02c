"""The motion in a page that plays: of the worst finds, as it is and as corrected, within a size."""

import base64
import json
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from tests.twistcore.reviews import CHAINS, CLIP, LIMBS, fresh
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.report.document import Report
from twistcore.report.played_finds import MOST_BYTES, player_script_data, select_intervals_to_play
from twistcore.review import Decide, Decision
from twistcore.review.replay import accepted_motion

WHEN = "2026-01-02T10:00:00+00:00"
LOOK = {"figure": {}, "themes": {}, "ghost": []}


def reviewed(accepted=(), rejected=()):
    state = fresh().state
    for ids, decision in ((accepted, Decision.ACCEPTED), (rejected, Decision.REJECTED)):
        state = Decide(tuple(ids), decision, "Kim", WHEN).apply(state) if ids else state
    return of(state)


def of(state):
    chains = (*CHAINS, *LIMBS)
    return Report(CLIP, chains, state, accepted_motion(CLIP, chains, state))


def data_of(report, most=MOST_BYTES):
    finds, _ = select_intervals_to_play(report, most)
    return player_script_data(report, finds, LOOK | {"views": [{}] * len(finds)})


def numbers(packed, *shape):
    values = np.frombuffer(base64.b64decode(packed["data"]), f"<{packed['kind']}")
    return values.reshape(shape).astype(float)


def rotations(packed, *shape):
    """As the page reads them: of length 1."""
    values = numbers(packed, *shape)
    return values / np.linalg.norm(values, axis=-1, keepdims=True)


def apart(some, others):
    """The largest angle between rotations, degrees."""
    cosine = np.abs((some * others).sum(axis=-1)).clip(0.0, 1.0)
    return float(np.degrees(2.0 * np.arccos(cosine)).max())


def test_the_page_has_the_motion_around_every_find_before_and_after():
    """Once each, to a hundredth of a degree; a find nobody accepted as if it were."""
    report = reviewed(accepted=(1, 2))
    motion, data, joints = CLIP.motion, data_of(report), len(CLIP.motion.skeleton)
    finds, left_out = select_intervals_to_play(report)
    assert len(finds) == len(report.state.intervals) == len(data["pages"])
    assert left_out == []
    frames = [(s["first"], rotations(s["rotations"], -1, joints, 4)) for s in data["spans"]]
    ends = [(first, first + len(values)) for first, values in frames]
    assert all(stop < start for (_, stop), (start, _) in pairwise(ends))
    for first, values in frames:
        there = motion.rotations[first : first + len(values)]
        assert apart(values, there) < 0.01
    for find, page in zip(finds, data["pages"], strict=True):
        start, stop = ends[page["span"]]
        assert start <= page["first"] <= page["frame"] <= page["last"] < stop
        assert page["last"] - page["first"] >= 60  # half a second on either side
        interval = find.judged.interval
        accepted = find.judged.decision == Decision.ACCEPTED
        also = [] if accepted else [interval]
        wanted = refine(motion, report.chains, [*report.applied, *also])
        turned = page["after"]["joints"]
        own = rotations(page["after"]["rotations"], -1, len(turned), 4)
        expected = wanted.rotations[page["first"] : page["last"] + 1][:, turned]
        assert apart(own, expected) < 0.01
        assert page["accepted"] == accepted
        assert page["offset"][0] == pytest.approx(np.degrees(interval.offset[0]), abs=0.05)


def test_the_worst_come_first_and_the_rest_is_named_within_a_size():
    report = reviewed(rejected=(3,))
    every, _ = select_intervals_to_play(report)
    assert every[-1].judged.id == 3  # of the others, the worst is first
    few, left_out = select_intervals_to_play(report, 310_000)
    assert 0 < len(few) < len(every)
    assert {f.judged.id for f in few} | {j.id for j in left_out} == {f.judged.id for f in every}
    assert few[0].judged.id == every[0].judged.id
    small = len(json.dumps(data_of(report, 310_000)))
    assert small < 310_000 - 8_000 * len(CLIP.motion.skeleton)
    assert small < len(json.dumps(data_of(report)))
    assert select_intervals_to_play(report, 0) == ([], [f.judged for f in every])


def test_what_has_no_correction_is_the_same_on_both_sides():
    state = fresh().state
    jump = replace(
        new_constant_offset_interval("LeftForeArm", 50, 51, 0.0), kind=Kind.LONE_JUMP, residual=0.7
    )
    first = replace(state.intervals[0], interval=jump)
    report = of(state.with_intervals((first, *state.intervals[1:])))
    finds, _ = select_intervals_to_play(report)
    (page,) = [p for p in data_of(report)["pages"] if p["start"] == 50]
    assert page["after"] is None
    assert [f.joints for f in finds if f.judged.interval is jump] == [()]


def test_only_a_part_of_a_very_long_find_is_played():
    state, motion = fresh().state, CLIP.motion
    whole = new_constant_offset_interval("LeftForeArm", 0, motion.frames, 0.5)
    state = state.with_intervals([replace(state.intervals[0], interval=whole)])
    fast = replace(motion, frame_time=1.0 / 20.0)  # so that four seconds are 80 frames
    (find,), _ = select_intervals_to_play(
        replace(of(state), clip=SimpleNamespace(motion=fast), refined=fast)
    )
    assert find.span[1] - find.span[0] == 80
    assert find.span[0] <= find.frame < find.span[1]


def test_positions_that_never_change_are_stored_once():
    motion = CLIP.motion
    still = np.concatenate([motion.positions, np.full((motion.frames, 1, 3), 7.0)], axis=1)
    more = replace(motion, positioned=(*motion.positioned, 5), positions=still)
    report = replace(reviewed(), clip=SimpleNamespace(motion=more), refined=more)
    span = data_of(report)["spans"][0]
    assert span["moving"] == list(motion.positioned)
    assert span["offsets"][5] == [7.0, 7.0, 7.0]
    place = numbers(span["positions"], -1, len(motion.positioned), 3)
    assert place == pytest.approx(motion.positions[span["first"] :][: len(place)], abs=1e-4)
