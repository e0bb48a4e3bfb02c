"""Verdicts as reviews and their files hold them, and the command that tunes by them."""

import json
import math
import os
import shutil
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from twistcore.analysis.clip_analysis import analyse, detect
from twistcore.cli import main
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.bvh import read_bvh
from twistcore.review import Decide, Decision, Review, write_session
from twistcore.review.folder_sessions import session_files_by_clip
from twistcore.review.model import Judged
from twistcore.review.session import session_document, session_from_document
from twistcore.skeleton.rig import skeleton_hash
from twistcore.tuning import GRID, read_profile
from twistcore.tuning.learned_confidence import (
    verdicts_with_confidence,
)
from twistcore.tuning.verdict_curve import tau_curve_from_verdicts
from twistcore.tuning.verdicts_of import (
    judged_clip_from_review,
    judged_intervals_found_per_tau,
    performer_of_clip,
    read_judged_clip,
)

INJECTED = ASSETS / "walk_injected.bvh"
TAU = np.degrees(GRID)


# --- from reviews ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "performer"),
    [
        ("05_03.bvh", "05"),
        ("143_12.bvh", "143"),
        ("walk_injected.bvh", ""),
        ("walk1_subject5.bvh", "subject5"),
        ("2024_05.bvh", ""),
    ],
)
def test_a_performer_is_told_by_a_name(name, performer):
    assert performer_of_clip(name) == performer


@pytest.fixture(scope="module")
def analysis():
    return analyse(read_bvh(INJECTED))


def judged_state(analysis, said, **more):
    """The review of what is found, decided by `said`(k)."""
    state = Review.of(detect(read_bvh(INJECTED))).state
    with_time = {"decided_at": "2026-01-01T00:00:00+00:00", **more}
    every = [replace(j, decision=said(k), **with_time) for k, j in enumerate(state.intervals)]
    return state.with_intervals(every)


def test_verdicts_are_accepted_or_rejected_and_what_nobody_said_is_none(analysis):
    decisions = Decision.ACCEPTED, Decision.REJECTED, Decision.UNDECIDED
    state = judged_state(analysis, lambda k: decisions[k % 3])
    judged_clip = judged_clip_from_review(analysis, state)
    wanted = [j for j in state.intervals if j.decision != Decision.UNDECIDED]
    assert len(judged_clip.verdicts) == len(wanted) > 3
    assert [v.error for v in judged_clip.verdicts] == [
        j.decision == Decision.ACCEPTED for j in wanted
    ]
    assert judged_clip.rig == skeleton_hash(analysis.motion.skeleton)
    first = wanted[0].interval
    left = judged_clip_from_review(
        analysis, replace(state, left_out=((first.start, first.start + 1),))
    )
    assert len(left.verdicts) < len(judged_clip.verdicts)
    assert left.minutes == pytest.approx(judged_clip.minutes - analysis.motion.frame_time / 60.0)
    automatic = judged_state(analysis, lambda _: Decision.ACCEPTED, decided_at="")
    assert judged_clip_from_review(analysis, automatic).verdicts == ()
    sure = judged_state(analysis, lambda _: Decision.UNDECIDED)
    ids = tuple(j.id for j in sure.intervals)
    sure = Decide(ids, Decision.ACCEPTED, "me", "2026-01-01T00:00:00+00:00", True).apply(sure)
    kept = session_from_document(session_document(read_bvh(INJECTED), sure)).state
    for state in (sure, kept):  # or a learned confidence would confirm itself
        assert judged_clip_from_review(analysis, state).verdicts == ()
    looked = Decide(ids[:1], Decision.ACCEPTED, "me", "2026-01-02T00:00:00+00:00").apply(kept)
    assert len(judged_clip_from_review(analysis, looked).verdicts) == 1


def half_judged(analysis, said=lambda _: Decision.ACCEPTED):
    """The review of the first chain that has anything listed; all others wait."""
    state = judged_state(analysis, said)
    first = state.intervals[0].interval.chain
    open_again = [
        j if j.interval.chain == first else replace(j, decision=Decision.UNDECIDED)
        for j in state.intervals
    ]
    return first, state.with_intervals(open_again)


def test_chains_that_nobody_has_judged_are_none_without_an_alarm(analysis):
    first, state = half_judged(analysis)
    judged_clip = judged_clip_from_review(analysis, state)
    assert judged_clip.reviewed.keys() == {first}
    assert judged_clip.reviewed_chains == 1.0
    done = judged_clip_from_review(analysis, judged_state(analysis, lambda _: Decision.REJECTED))
    assert done.reviewed.keys() == {c.name for c in analysis.chains}  # in these nothing was listed


def test_a_lower_tau_alone_is_no_look(analysis):
    state = judged_state(analysis, lambda _: Decision.REJECTED)
    chain = "LeftForeArm"
    before = judged_clip_from_review(analysis, state)
    low = before.reviewed[chain] / 4.0
    listed = analysis.by().intervals(chain, before.reviewed[chain])
    free = [t for t in range(0, 300, 9) if not any(i.start < t + 5 and t < i.stop for i in listed)]
    waits = [
        Judged(900 + k, new_constant_offset_interval(chain, t, t + 5, low))
        for k, t in enumerate(free)
    ]
    tau = {**state.tau, chain: low}
    lowered = replace(state, tau=tau).with_intervals((*state.intervals, *waits))
    after = judged_clip_from_review(analysis, lowered)
    assert after.reviewed[chain] >= before.reviewed[chain]
    assert after.shares[chain] == 1.0  # nothing that waits is listed at the τ that was looked at


def test_of_a_chain_decided_in_part_only_that_part_was_looked_at(analysis):
    state = judged_state(analysis, lambda _: Decision.REJECTED)
    own = state.of_chain("LeftForeArm")
    assert len(own) == 3
    strongest = max(own, key=lambda j: abs(j.interval.largest))
    part = [
        replace(j, decision=Decision.UNDECIDED) if j is strongest else j for j in state.intervals
    ]
    judged_clip = judged_clip_from_review(analysis, state.with_intervals(part))
    assert judged_clip.shares["LeftForeArm"] == pytest.approx(2 / 3)


def test_where_a_verdict_is_found_is_what_the_detector_finds(analysis):
    state = judged_state(analysis, lambda _: Decision.ACCEPTED)
    for v in judged_clip_from_review(analysis, state).verdicts:
        for k in range(0, len(GRID), 6):
            found = analysis.by().intervals(v.chain, float(GRID[k]))
            same = any((i.start, i.stop) == (v.start, v.stop) for i in found)
            assert v.found[k] == same
    # The strongest jump beside it bounds what finds it: no τ above that does.
    strengths = [
        np.degrees(analysis.by().strength(v.chain)).max() for v in judged_clip(analysis, state)
    ]
    for v, strength in zip(judged_clip(analysis, state), strengths, strict=True):
        assert not v.found[strength < TAU].any()


def judged_clip(analysis, state):
    return judged_clip_from_review(analysis, state).verdicts


def test_an_error_made_by_hand_is_missed_at_every_tau_unless_it_is_found(analysis):
    state = judged_state(analysis, lambda _: Decision.ACCEPTED)
    hand = Judged(
        99,
        new_constant_offset_interval("LeftUpLeg", 300, 310, 0.5),
        Decision.ACCEPTED,
        by_hand=True,
        reviewer="me",
    )
    judged_clip = judged_clip_from_review(analysis, state.with_intervals((*state.intervals, hand)))
    (mine,) = (v for v in judged_clip.verdicts if v.by_hand)
    assert not mine.found.any()
    assert mine.confidence is None
    curve = tau_curve_from_verdicts([judged_clip])
    assert curve.recall.max() == pytest.approx(1 - 1 / len(judged_clip.verdicts))
    assert len(verdicts_with_confidence([judged_clip])) == len(judged_clip.verdicts) - 1


class Lists:
    """A detector that lists the same at every τ."""

    def __init__(self, *spans):
        self.spans = spans

    def intervals(self, chain, tau):
        return tuple(
            new_constant_offset_interval(chain, start, stop, 0.5) for start, stop in self.spans
        )


@pytest.mark.parametrize(
    ("spans", "found"),
    [
        ([(10, 20), (40, 60)], (True, True)),
        ([(10, 15), (58, 80)], (True, True)),  # half of the error; any of what is natural
        ([(10, 14)], (False, False)),  # too little of the error
        ([(0, 30)], (False, False)),  # and too much
        ([(19, 45)], (False, True)),  # belongs to the one that it shares most with
    ],
)
def test_an_error_has_to_be_found_and_an_alarm_only_to_sound(spans, found):
    judged = [
        new_constant_offset_interval("A", 10, 20, 0.5),
        new_constant_offset_interval("A", 40, 60, 0.5),
    ]
    by_tau = judged_intervals_found_per_tau(judged, [True, False], Lists(*spans), "A")
    assert tuple(by_tau.all(axis=1)) == found
    assert tuple(by_tau.any(axis=1)) == found


def test_sessions_of_a_folder(tmp_path, analysis):
    path = shutil.copy(INJECTED, tmp_path / "05_01.bvh")
    clip = read_bvh(path)
    state = judged_state(analysis, lambda _: Decision.ACCEPTED)
    write_session(clip, state, tmp_path / "05_01.twist.json")
    write_session(clip, state, tmp_path / "05_01_refined.replay.json")
    (tmp_path / "other.json").write_text("{}")
    ((found, session),) = session_files_by_clip(tmp_path).of.items()
    judged_clip = read_judged_clip(found, session)
    assert judged_clip.performer == "05"
    assert len(judged_clip.verdicts) == len(state.intervals)
    assert read_judged_clip(found, session, "Ann").performer == "Ann"
    document = session_document(clip, state)
    for k, name in enumerate(("", "/", 300 * "a")):  # of no clip at all
        (tmp_path / f"none{k}.json").write_text(json.dumps(document | {"clip": name}))
    there = session_files_by_clip(tmp_path)
    assert (there.of, there.damaged) == ({found: session}, ())
    stale = tmp_path / "stale.json"  # saved later, but for other bytes
    stale.write_text(json.dumps(document | {"sha256": "0" * 64}))
    os.utime(stale, (2e9, 2e9))
    assert session_files_by_clip(tmp_path).of == {found: session}
    session.unlink()
    assert session_files_by_clip(tmp_path).of == {found: stale}
    write_session(clip, state, session)
    shutil.copy(ASSETS / "walk.bvh", path)
    with pytest.raises(Exception, match="another version"):
        read_judged_clip(found, session)


def test_of_two_clips_of_one_stem_a_damaged_session_is_of_the_one_in_its_name(tmp_path):
    for name in ("a.amc", "a.bvh"):
        (tmp_path / name).touch()
        (tmp_path / f"{name.removesuffix('.bvh')}.twist.json").write_text("garbage")
    judged_clip = {d.path.name: d.clip.name for d in session_files_by_clip(tmp_path).damaged}
    assert judged_clip == {"a.twist.json": "a.bvh", "a.amc.twist.json": "a.amc"}


@pytest.mark.parametrize(
    "damage",
    ["garbage", {"left_out": "all"}, {"left_out": [[-5, 10]]}, {"schema": "twistcore.session/99"}],
)
def test_a_damaged_session_is_told_with_its_clip(tmp_path, damage):
    for name in ("a.bvh", "b.bvh"):
        shutil.copy(ASSETS / "kick.bvh", tmp_path / name)
    whole = session_document(
        read_bvh(tmp_path / "b.bvh"), Review.of(detect(read_bvh(tmp_path / "b.bvh"))).state
    )
    text = damage if isinstance(damage, str) else json.dumps(whole | damage)
    for name in ("a.twist.json", "other.json"):
        (tmp_path / name).write_text(text)
    there = session_files_by_clip(tmp_path)
    assert not there.of
    named = damage == "garbage"  # what it is of, it does not say, nor that it is a session
    of = "a.bvh" if named else "b.bvh"
    names = ["a.twist.json"] if named else ["a.twist.json", "other.json"]
    assert [(d.path.name, d.clip.name) for d in there.damaged] == [(name, of) for name in names]
    assert all(d.why.startswith(f"{d.path}: ") and "expected" in d.why for d in there.damaged)


# --- the command -------------------------------------------------------------------------------


@pytest.fixture
def judged_folder(tmp_path, analysis):
    """Two clips of performer 05, judged: 14 accepted and two rejected."""
    for k in (1, 2):
        path = shutil.copy(INJECTED, tmp_path / f"05_0{k}.bvh")
        state = judged_state(analysis, lambda n: Decision(("rejected", "accepted")[n > 0]))
        write_session(read_bvh(path), state, tmp_path / f"05_0{k}.twist.json")
    return tmp_path


@pytest.mark.thorough
def test_tune_by_verdicts_writes_a_profile(judged_folder, tmp_path, capsys):
    output = tmp_path / "p.toml"
    assert main(["tune", str(judged_folder), "--verdicts", "-o", str(output)]) == 0
    said = capsys.readouterr().out
    assert "14 accepted and 2 rejected intervals in 2 clips" in said
    assert (
        "The confidence is the detector's own, because at least 20 verdicts are needed to learn one"
        in said
    )
    profile = read_profile(output)
    clip = read_bvh(INJECTED)
    assert profile.rig == skeleton_hash(clip.motion.skeleton)
    assert (profile.performer, profile.method) == ("05", "consistency")
    assert profile.tau.keys() == {c.name for c in analyse(clip).chains}
    assert profile.confidence is None
    tau = set(profile.tau.values())
    assert math.radians(1.5) <= min(tau)


@pytest.mark.thorough
def test_tune_by_verdicts_says_what_is_missing(judged_folder, tmp_path, capsys):
    output, one = str(tmp_path / "p.toml"), ("--workers", "1")
    for more, judged_clip in (
        (["--performer", "06"], "'06'"),
        (["--seeds", "5"], "--verdicts"),
        (["--method", "paper"], "consistency"),
    ):
        command = ["tune", str(judged_folder), "--verdicts", "-o", output, *one, *more]
        assert main(command) == 2
        assert judged_clip in capsys.readouterr().err
    damaged = judged_folder / "05_03.twist.json"
    damaged.write_text("garbage")
    assert main(["tune", str(judged_folder), "--verdicts", "-o", output, *one]) == 1
    assert f"{damaged}: expected JSON" in capsys.readouterr().err
    (tmp_path / "p.toml").unlink()
    assert main(["tune", str(judged_folder), "--verdicts", "-o", str(damaged)]) == 2
    assert damaged.read_text() == "garbage"
    damaged.unlink()
    (judged_folder / "05_02.twist.json").unlink()
    assert main(["tune", str(judged_folder), "--verdicts", "-o", output, *one]) == 2
    assert numbers(capsys.readouterr().err)[:2] == [10, 7]
    assert main(["tune", str(INJECTED), "--verdicts", "-o", output]) == 2
    assert names_in_one_line(capsys.readouterr().err, f"{INJECTED}: ")
    assert main(["tune", str(INJECTED), "--performer", "05", "-o", output]) == 2
    assert names_in_one_line(capsys.readouterr().err, "--performer", "--verdicts")
    assert not (tmp_path / "p.toml").exists()
