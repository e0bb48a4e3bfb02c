"""Two reviewers of one clip: how far they agree, where they differ, and what both say."""

import json
import shutil
from dataclasses import replace

import pytest

from tests.conftest import ASSETS
from tests.messages import refused
from tests.twistcore.reviews import flip
from twistcore.analysis.clip_analysis import detect
from twistcore.cli import main
from twistcore.detection.interval_offsets import new_constant_offset_interval, resized_interval
from twistcore.errors import ClipMismatchError
from twistcore.formats.bvh import read_bvh
from twistcore.review import (
    Annotate,
    Decide,
    Decision,
    Edit,
    Insert,
    Journal,
    Review,
    Settle,
    read_session,
    replay_journal,
    write_session,
)
from twistcore.review.agreement import (
    Agreement,
    PairDifference,
    cohen_kappa,
    decisions_only_by_second,
    merged_review,
    pair_intervals,
    reviewers_of,
)

A, R = Decision.ACCEPTED, Decision.REJECTED
CLIP = read_bvh(ASSETS / "walk_injected.bvh")
FOUND = detect(CLIP)
THEN, LATER = "2026-11-01T09:00:00+00:00", "2026-11-02T09:00:00+00:00"


def reviewed(name, accepted=(), rejected=(), *more, at=THEN):
    """A review of the eight errors of the walk."""
    review = Review(FOUND)
    for ids, decision in ((accepted, A), (rejected, R)):
        review.do(Decide(tuple(ids), decision, name, at))
    for command in more:
        review.do(command)
    return review.state


def longer(state, number, frames=3):
    one = state.find(number).interval
    return Edit(number, resized_interval(one, one.start, one.stop + frames))


START = Review(FOUND).state
ADA = reviewed("Ada", (1, 2, 3, 5), (6,))
BY_HAND = new_constant_offset_interval("LeftArm", 300, 310, 0.4)
BEN = reviewed(
    "Ben", (1, 2, 4), (3, 5, 6), longer(START, 2), Annotate(3, "natural", "motion"),
    Insert(BY_HAND), Decide((9,), A, "Ben", LATER), at=LATER,
)  # fmt: skip


def differences(mine, theirs):
    """The difference of each pair that differs, keyed by the id of one of them."""
    found = Agreement(pair_intervals(mine.intervals, theirs.intervals))
    return {pair.either.id: pair.difference for pair in found.differences}


def test_every_way_to_differ_is_named_and_is_the_same_from_the_other_side():
    expected = {
        2: PairDifference.CORRECTION,
        3: PairDifference.VERDICT,
        4: PairDifference.DECIDED,
        5: PairDifference.VERDICT,
        9: PairDifference.INSERTED,
    }
    assert differences(ADA, BEN) == differences(BEN, ADA) == expected
    assert differences(ADA, ADA) == differences(START, START) == {}
    assert reviewers_of((*ADA.intervals, *BEN.intervals)) == ("Ada", "Ben")


def test_edits_differ_even_if_nobody_has_decided_but_not_of_what_both_reject():
    edited = longer(START, 1).apply(START)
    assert differences(START, edited) == {1: PairDifference.CORRECTION}
    both = [Decide((1,), R, name).apply(state) for name, state in (("a", START), ("b", edited))]
    assert differences(*both) == {}
    turned, kept = (Insert(flip(carried=on)).apply(START) for on in (True, False))
    assert differences(turned, kept) == {}  # nobody has decided
    both = [Decide((9,), A, "a").apply(state) for state in (turned, kept)]
    assert differences(*both) == {9: PairDifference.CORRECTION}
    fewer = START.with_intervals(START.intervals[1:])
    first = START.intervals[0].id
    assert differences(fewer, START) == {}
    decided = Decide((first,), A, "Ben", THEN).apply(START)
    assert differences(fewer, decided) == {first: PairDifference.DETECTED}


def test_automatic_corrections_are_nobody_s_decision():
    automatic = reviewed("")
    automatic = Decide((1, 2), A).apply(automatic)
    found = Agreement(pair_intervals(automatic.intervals, BEN.intervals))
    assert found.decisions == ()
    assert differences(automatic, reviewed("Ben", (1,))) == {1: PairDifference.DECIDED}


def test_pairs_need_the_chain_and_kind_and_the_largest_overlap_is_first():
    def listed(*spans, chain="LeftArm"):
        found = START.with_intervals(())
        for start, stop in spans:
            found = Insert(new_constant_offset_interval(chain, start, stop, 0.4)).apply(found)
        return found.intervals

    mine, theirs = listed((10, 40), (40, 50)), listed((5, 12), (12, 41), (60, 70))
    spans = [
        tuple(j and (j.interval.start, j.interval.stop) for j in (pair.mine, pair.theirs))
        for pair in pair_intervals(mine, theirs)
    ]
    assert spans == [((10, 40), (12, 41)), ((40, 50), None), (None, (5, 12)), (None, (60, 70))]
    other = listed((10, 40), chain="RightArm")
    assert all(None in (pair.mine, pair.theirs) for pair in pair_intervals(mine, other))


def test_percent_and_kappa_of_what_both_have_decided():
    found = Agreement(pair_intervals(ADA.intervals, BEN.intervals))
    assert (len(found.decisions), found.alike, found.percent) == (5, 3, 60.0)
    assert found.kappa == pytest.approx((0.6 - 0.44) / 0.56)  # 4/5·2/5 + 1/5·3/5 by chance
    assert found.why_no_kappa == ""


@pytest.mark.parametrize(
    ("mine", "theirs", "percent", "why"),
    [
        (START, BEN, None, "no interval was decided by both reviewers"),
        (reviewed("a", (1, 2)), reviewed("b", (1, 2, 3)), 100.0, "both reviewers accepted every"),
        (reviewed("a", (), (1,)), reviewed("b", (), (1,)), 100.0, "both reviewers rejected every"),
    ],
)
def test_an_undefined_kappa_has_a_reason(mine, theirs, percent, why):
    found = Agreement(pair_intervals(mine.intervals, theirs.intervals))
    assert (found.percent, found.kappa) == (percent, None)
    assert why in found.why_no_kappa
    assert why in found.summary
    assert "nan" not in found.summary


def test_kappa_is_one_for_all_alike_and_zero_as_by_chance():
    assert cohen_kappa("eade", "eade") == 1.0
    assert cohen_kappa("eeaa", "eaea") == pytest.approx(0.0)
    assert cohen_kappa("ee", "aa") == 0.0
    assert cohen_kappa("ee", "ee") is cohen_kappa("", "") is None
    # Two by two with 20, 5, 10, 15: agreement 0.7, by chance 0.5.
    first, second = "e" * 25 + "a" * 25, "e" * 20 + "a" * 5 + "e" * 10 + "a" * 15
    assert cohen_kappa(first, second) == pytest.approx(0.4)


# -- taking their decisions ------------------------------------------------------------------------


def test_their_decision_comes_with_their_correction_and_the_id_of_mine():
    pairs = {p.either.id: p for p in pair_intervals(ADA.intervals, BEN.intervals)}
    state = Settle(tuple(pairs[k].taken(ADA.next_id) for k in (2, 3, 9))).apply(ADA)
    assert {j.id for j in state.intervals} == {*range(1, 9), ADA.next_id}
    assert state.find(2).interval.stop == BEN.find(2).interval.stop
    assert state.find(2).edited
    assert (state.find(3).decision, state.find(3).reason) == (R, "motion")
    assert state.find(3).interval is ADA.find(3).interval  # with its evidence
    assert (state.find(9).by_hand, state.find(9).reviewer, state.next_id) == (True, "Ben", 10)
    assert differences(state, BEN).keys() == {4, 5}
    assert pairs[7].taken(10) is None
    noted = Annotate(3, "my note").apply(ADA)
    [pair] = (p for p in pair_intervals(noted.intervals, BEN.intervals) if p.either.id == 3)
    assert pair.taken(10).note == "my note"
    with pytest.raises(ValueError, match="no chain"):
        Settle(BEN.intervals).apply(replace(ADA, tau={}))


def test_what_was_taken_is_one_step_and_is_in_the_journal(tmp_path):
    review, path = Review(ADA), tmp_path / "walk.twist.json.journal"
    journal = Journal(path, CLIP, ADA)
    command = Settle(
        tuple(filter(None, (p.taken(9) for p in pair_intervals(ADA.intervals, BEN.intervals))))
    )
    review.do(command)
    journal.do(command)
    journal.close()
    assert review.undo_text == f"Settle {len(command.earlier)} differences"
    again = replay_journal(path, CLIP).review.state
    assert differences(review.state, again) == differences(again, BEN) == {}
    review.undo()
    assert review.state is ADA


def test_what_the_first_left_undecided_is_taken_unless_it_would_be_added_twice():
    def taken(state, theirs=BEN):
        return {
            j.id: j.reviewer
            for j in decisions_only_by_second(pair_intervals(state.intervals, theirs.intervals), 20)
        }

    assert taken(ADA) == {4: "Ben", 20: "Ben"}
    assert taken(longer(ADA, 4).apply(ADA)) == {20: "Ben"}  # my own edit
    two = Insert(new_constant_offset_interval("LeftArm", 320, 330, 0.4)).apply(BEN)
    two = Decide((10,), A, "Ben", LATER).apply(two)
    assert taken(ADA, two).keys() == {4, 20, 21}
    # Mine is the pair of one, and overlaps the other of the same chain as well.
    mine = Insert(new_constant_offset_interval("LeftArm", 305, 330, 0.4)).apply(ADA)
    assert taken(mine, two).keys() == {4}
    # Theirs is the pair of one that I left undecided, and overlaps another of mine as well.
    stop = ADA.find(4).interval.stop
    mine = Insert(
        new_constant_offset_interval(ADA.find(4).interval.chain, stop + 5, stop + 15, 0.4)
    ).apply(ADA)
    longer_by_six = Edit(
        4, resized_interval(ADA.find(4).interval, ADA.find(4).interval.start, stop + 6)
    )
    assert 4 in taken(ADA, longer_by_six.apply(BEN))
    assert 4 not in taken(mine, longer_by_six.apply(BEN))


# -- merging ---------------------------------------------------------------------------------------


def test_a_merged_review_decides_nothing_by_itself():
    found = Agreement(pair_intervals(ADA.intervals, BEN.intervals))
    both = merged_review(found, ADA)
    decided = {j.id: j.decision for j in both.intervals if j.decision != Decision.UNDECIDED}
    assert decided == {1: A, 6: R}
    assert {both.find(k).reviewer for k in decided} == {"Ada, Ben"}
    assert both.find(1).decided_at == LATER
    assert both.find(3).note == (
        "Ada: accepted 305–323 +152.5°; Ben: rejected 305–323 +152.5°, motion, natural"
    )
    open_again = both.find(3)
    assert (open_again.reviewer, open_again.decided_at, open_again.reason) == ("", "", "")
    assert both.find(9).by_hand
    assert both.find(9).interval.start == 300
    assert both.find(8).note == ""
    other = merged_review(Agreement(pair_intervals(BEN.intervals, ADA.intervals)), BEN)
    assert {j.id: j.decision for j in other.intervals} == {j.id: j.decision for j in both.intervals}


def test_a_note_on_what_only_one_review_has_is_kept_as_it_is():
    noted = Annotate(1, "look again").apply(START)
    fewer = START.with_intervals(START.intervals[1:])
    for mine, theirs in ((noted, fewer), (noted, START), (START, noted)):
        found = Agreement(pair_intervals(mine.intervals, theirs.intervals))
        assert merged_review(found, mine).find(1).note == "look again"


@pytest.fixture
def sessions(tmp_path):
    clip = read_bvh(shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "walk.bvh"))
    paths = tmp_path / "ada.twist.json", tmp_path / "ben.twist.json"
    for path, state in zip(paths, (ADA, BEN), strict=True):
        write_session(clip, state, path)
    return paths


def test_the_command_compares_and_merges(sessions, capsys):
    out = sessions[0].with_name("both.twist.json")
    assert main(["diff", *map(str, sessions), "--merge", str(out)]) == 0
    said = capsys.readouterr()
    assert (
        "decided by both reviewers: 5, with the same decision: 3 (60 %), Cohen's kappa: 0.29"
        in said.out
    )
    assert said.out.count("opposite decisions") == 2
    assert "5 of 8 intervals decided by Ada" in said.out
    assert "agreed decisions: 2; 5 intervals left undecided" in said.out
    both = read_session(out).state
    assert [j.id for j in both.intervals if j.decision != Decision.UNDECIDED] == [1, 6]
    clip, moved = sessions[0].with_name("walk.bvh"), sessions[0].with_name("out.bvh")
    assert main(["apply", str(out), str(clip), "-o", str(moved)]) == 0
    capsys.readouterr()
    before = out.read_bytes()
    assert main(["diff", *map(str, sessions), "--merge", str(out)]) == 2  # it has decisions
    assert main(["diff", *map(str, sessions), "--merge", str(sessions[1])]) == 2
    assert out.read_bytes() == before


def test_the_document_names_both_sides(sessions, capsys):
    assert main(["diff", *map(str, sessions), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["reviewers"] == {"a": ["Ada"], "b": ["Ben"]}
    assert (found["decided_by_both"], found["alike"], found["merged"]) == (5, 3, None)
    inserted = found["differences"][-1]
    assert (inserted["a"], inserted["b"]["start"]) == (None, 300)
    sides = [side for one in found["differences"] for side in (one["a"], one["b"]) if side]
    assert {side["kind"] for side in sides} == {"counter-twist"}
    assert main(["diff", str(sessions[0]), str(sessions[0]), "--json"]) == 0
    same = json.loads(capsys.readouterr().out)
    assert (same["percent"], same["kappa"], same["differences"]) == (100.0, 1.0, [])


def test_what_cannot_be_compared_is_refused(sessions, tmp_path, capsys):
    document = json.loads(sessions[1].read_text(encoding="utf-8"))
    other = tmp_path / "other.twist.json"
    other.write_text(json.dumps(document | {"sha256": "0" * 64}), encoding="utf-8")
    for words, why in (
        ((sessions[0], other), "different clips"),
        ((sessions[0], tmp_path / "walk.bvh"), "two sessions"),
        ((tmp_path / "walk.bvh", tmp_path / "walk.bvh", "--merge", "x.json"), "two sessions"),
    ):
        assert main(["diff", *map(str, words)]) == 2
        assert why in capsys.readouterr().err
    (tmp_path / "walk.bvh").unlink()
    assert main(["diff", *map(str, sessions), "--merge", str(tmp_path / "both.json")]) == 2
    assert "clip" in capsys.readouterr().err
    fewer = replace(ADA, tau={k: v for k, v in ADA.tau.items() if k != "LeftArm"})
    with refused(ClipMismatchError, "different chains"):
        merged_review(Agreement(pair_intervals(ADA.intervals, BEN.intervals)), fewer)


def test_a_session_that_does_not_fit_the_clip_is_not_merged(sessions, tmp_path, capsys):
    document = json.loads(sessions[1].read_text(encoding="utf-8"))
    document["intervals"][-1] |= {"start": 9_000, "stop": 9_010}
    sessions[1].write_text(json.dumps(document), encoding="utf-8")
    out = tmp_path / "both.twist.json"
    assert main(["diff", *map(str, sessions), "--merge", str(out)]) == 2
    assert "last frame" in capsys.readouterr().err
    assert not out.exists()


def test_the_report_names_the_reviewer_of_each_decision(sessions, tmp_path, capsys):
    pairs = pair_intervals(ADA.intervals, BEN.intervals)
    state = Settle(decisions_only_by_second(pairs, ADA.next_id)).apply(ADA)
    state = Decide((3,), R, "Carla", LATER).apply(state)
    write_session(read_bvh(tmp_path / "walk.bvh"), state, sessions[0])
    assert main(["report", str(sessions[0]), "-o", str(tmp_path / "out"), "--no-pictures"]) == 0
    page = (tmp_path / "out" / "walk.report.html").read_text(encoding="utf-8")
    for count, name in (("4 decisions", "Ada"), ("2 decisions", "Ben"), ("1 decision", "Carla")):
        assert f"{count} by {name}, " in page
        assert page.count(f"<td>{name}</td>") == int(count[0])
