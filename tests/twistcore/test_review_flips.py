"""Flips of limbs in a review: what its session and its journal hold of them, and who reads it."""

import json
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.twistcore.reviews import CARRIED, CHAINS, CLIP, LIMBS, TAU, flip, fresh
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Kind
from twistcore.detection.interval_offsets import (
    new_constant_offset_interval,
    with_offset_of_size,
)
from twistcore.errors import ClipMismatchError, FormatError
from twistcore.formats.bvh import read_bvh
from twistcore.review import (
    CarryOver,
    Decide,
    Decision,
    Edit,
    Insert,
    Journal,
    Judged,
    Redetect,
    Review,
    Track,
    Tracking,
    read_session,
    replay_journal,
    session_bytes,
    start_review,
    write_session,
)
from twistcore.review.reasons import intervals_detected_at_review_tau
from twistcore.review.replay import accepted_motion, check_session_fits_clip
from twistcore.skeleton.motion import forward_kinematics


def with_flips():
    """A review of eight twists and two flips, nothing decided."""
    names = [c.name for c in (*CHAINS, *LIMBS)]
    tau = {**TAU, **{limb.name: 1.0 for limb in LIMBS}}
    twists = fresh().state.chosen(undecided=True)
    return Review(start_review("paper", tau, [*twists, CARRIED, flip()], names))


def test_a_session_with_flips_comes_back_with_kind_and_end(tmp_path):
    review = with_flips()
    assert [j.interval.chain for j in review.state.intervals[8:]] == [CARRIED.chain, flip().chain]
    ids = [j.id for j in review.state.intervals]
    review.do(Decide(tuple(ids), Decision.ACCEPTED))
    path = tmp_path / "s.json"
    for tracking in (None, Tracking(("LeftArm",))):
        review.do(Track(tracking))
        write_session(CLIP, review.state, path)
        document, session = json.loads(path.read_bytes()), read_session(path)
        assert document["schema"] == "twistcore.session/3"
        assert ("tracking" in document) == (tracking is not None)
        assert session.state.tracking == tracking
        assert session_bytes(CLIP, session.state) == path.read_bytes()
        kinds = [(i.kind, i.carried) for i in session.state.chosen()]
        assert kinds[7:] == [
            (Kind.COUNTER_TWIST, False), (Kind.LIMB_FLIP, True), (Kind.LIMB_FLIP, False)
        ]  # fmt: skip
        check_session_fits_clip(session, CLIP, (*CHAINS, *LIMBS))
        with pytest.raises(ClipMismatchError, match="'LeftUpLeg-LeftFoot'"):
            check_session_fits_clip(session, CLIP, CHAINS)
    review.do(Track(None))
    motion = accepted_motion(CLIP, (*CHAINS, *LIMBS), read_session(path).state)
    assert np.abs(forward_kinematics(motion)[1] - forward_kinematics(CLIP.motion)[1]).max() > 1.0
    document["tracking"] = None
    path.write_text(json.dumps(document))
    assert read_session(path).state.tracking is None


def test_only_what_is_new_asks_for_the_new_schema(tmp_path):
    """So that older versions read all the rest."""
    plain = fresh().state
    of_limb = replace(plain, tau={**TAU, "RightUpLeg-RightFoot": 1.0})
    flips = replace(with_flips().state, tau=plain.tau)
    wanted = {"1": plain, "2": replace(plain, tracking=Tracking(("LeftArm",)))}
    for version, state in [*wanted.items(), ("3", of_limb), ("3", flips)]:
        document = json.loads(session_bytes(CLIP, state))
        assert document["schema"] == f"twistcore.session/{version}"
        assert all(("kind" in i) == (version == "3") for i in document["intervals"])


@pytest.mark.parametrize(
    "damage",
    [
        {"kind": "limb-flip"}, {"kind": None}, {"kind": ["limb flip"]}, {"kind": 3},
        {"carried": None}, {"carried": 1}, {"carried": "yes"}, {"kind": ...}, {"carried": ...},
    ],
)  # fmt: skip
@pytest.mark.parametrize("at", [0, -1])
def test_a_damaged_kind_is_one_sentence(tmp_path, damage, at):
    path = tmp_path / "s.json"
    document = json.loads(session_bytes(CLIP, with_flips().state))
    entry = document["intervals"][at] | damage
    document["intervals"][at] = {k: v for k, v in entry.items() if v is not ...}
    path.write_text(json.dumps(document))
    with pytest.raises(FormatError) as caught:
        read_session(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert next(iter(damage)) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_flip_of_a_chain_and_a_twist_of_a_limb_belong_to_no_clip(tmp_path):
    state, every = with_flips().state, (*CHAINS, *LIMBS)
    for change in ({"kind": Kind.COUNTER_TWIST}, {"chain": "RightUpLeg"}, {"chain": "Tail-Tip"}):
        *others, last = state.intervals
        other = replace(last, interval=replace(last.interval, **change))
        path = tmp_path / "s.json"
        write_session(CLIP, replace(state, intervals=(*others, other)), path)
        with pytest.raises(ClipMismatchError, match=repr(other.interval.chain)):
            check_session_fits_clip(read_session(path), CLIP, every)


def test_a_journal_keeps_kinds_and_old_ones_open(tmp_path):
    review = with_flips()
    moved = flip(start=150, stop=160, carried=True)
    commands = [
        Insert(moved),
        Edit(10, with_offset_of_size(review.state.find(10).interval, 3.0)),
        Redetect({"RightUpLeg-RightFoot": 0.7}, (flip(start=100, stop=109),)),
        CarryOver((Judged(1, CARRIED, Decision.ACCEPTED),), same_clip=True),
    ]
    with closing(Journal(tmp_path / "j", CLIP, review.state)) as journal:
        for command in commands:
            review.do(command)
            journal.do(command)
    back = replay_journal(tmp_path / "j", CLIP)
    assert (back.entries, back.damaged) == (4, 0)
    assert session_bytes(CLIP, back.review.state) == session_bytes(CLIP, review.state)
    assert [j.interval.carried for j in back.review.state.of_chain(moved.chain)] == [False, True]
    with closing(Journal(tmp_path / "old", CLIP, fresh().state)) as journal:
        journal.do(Insert(new_constant_offset_interval("LeftLeg", 100, 110, -0.7)))
    assert b"kind" not in (tmp_path / "old").read_bytes()  # as it was before there were any
    old = replay_journal(tmp_path / "old", CLIP)
    assert {j.interval.kind for j in old.review.state.intervals} == {Kind.COUNTER_TWIST}


def test_a_session_read_again_is_told_why_without_a_change(tmp_path):
    """Reasons are in no file: what is found alike at the session's τ has them, in every state."""
    clip = read_bvh(ASSETS / "kick.bvh")
    analysis = analyse(clip)
    found = analysis.detect()
    review = Review.of(found)
    write_session(clip, review.state, tmp_path / "s.json")
    written = (tmp_path / "s.json").read_bytes()
    back = Review(read_session(tmp_path / "s.json").state)
    begin = back.state
    assert [j.interval.evidence for j in begin.intervals] == [None] * len(begin.intervals)
    back.do(Insert(new_constant_offset_interval("RightUpLeg", 14, 31, 0.5)))
    back.do(Decide((1,), Decision.ACCEPTED))
    back.mark_saved()
    *_, moved = begin.intervals
    back.do(Edit(moved.id, replace(moved.interval, start=moved.interval.start - 1,
                                   offset=np.ones(moved.interval.frames + 1))))  # fmt: skip
    assert intervals_detected_at_review_tau(analysis, back.state) == found.intervals
    back.take_reasons(intervals_detected_at_review_tau(analysis, back.state))
    evidence = {j.id: j.interval.evidence for j in review.state.intervals}
    none = {moved.id, begin.next_id}
    assert {j.id: j.interval.evidence for j in back.state.intervals} == {
        k: None if k in none else evidence.get(k) for k in (*evidence, begin.next_id)
    }
    assert not back.saved
    back.undo()
    assert (back.saved, back.position) == (True, 2)
    back.undo()
    back.undo()
    assert [j.interval.evidence for j in back.state.intervals] == list(evidence.values())
    assert session_bytes(clip, back.state) == written
    same = back.state
    back.take_reasons(found)
    assert back.state is same
    assert (
        intervals_detected_at_review_tau(analyse(clip), begin)[0].kind == Kind.LIMB_FLIP
    )  # nothing long is started
