"""Frames left out of tuning are a person's decision: undone, saved, brought back by the journal."""

import json
from contextlib import closing

import pytest

from tests.twistcore.reviews import CLIP, fresh
from twistcore.errors import FormatError
from twistcore.review import Journal, LeaveOut, read_session, replay_journal, session_bytes
from twistcore.review.left_out import excluded_spans_from_json, joined_spans, uncovered_parts

SPANS = ((0, 40), (100, 130))


def test_it_is_one_step_and_in_the_session_of_the_same_version(tmp_path):
    path = tmp_path / "s.json"
    review = fresh()
    plain = session_bytes(CLIP, review.state)
    review.do(LeaveOut(((100, 120), (0, 40), (110, 130))))
    assert review.state.left_out == SPANS
    saved = session_bytes(CLIP, review.state)
    path.write_bytes(saved)
    assert read_session(path).state.left_out == SPANS
    # An older program finds the rest as it was.
    document = json.loads(saved)
    assert document.pop("left_out") == [[0, 40], [100, 130]]
    assert document == json.loads(plain)
    review.do(LeaveOut(()))
    assert session_bytes(CLIP, review.state) == plain
    review.undo()
    assert review.state.left_out == SPANS


def test_the_journal_brings_it_back(tmp_path):
    path = tmp_path / "j"
    with closing(Journal(path, CLIP, fresh().state)) as journal:
        journal.do(LeaveOut(SPANS))
        journal.do(LeaveOut(((300, 9999),)))
    back = replay_journal(path, CLIP)
    assert back.review.state.left_out == SPANS
    assert (back.entries, back.damaged) == (1, 1)  # the clip has no such frames


@pytest.mark.parametrize("damage", [[[5, 5]], [[-1, 3]], [[1.0, 3]], [[3]], 7, ["ab"], [[True, 3]]])
def test_damaged_spans_are_refused(tmp_path, damage):
    path = tmp_path / "s.json"
    document = json.loads(session_bytes(CLIP, fresh().state))
    path.write_text(json.dumps({**document, "left_out": damage}))
    with pytest.raises(FormatError, match="left_out"):
        read_session(path)
    with pytest.raises(ValueError, match="frame"):
        fresh().do(LeaveOut(((5, 5),)))


@pytest.mark.parametrize(
    ("others", "left"),
    [
        ([(0, 3)], ((3, 10),)),
        ([(7, 10)], ((0, 7),)),
        ([(0, 3), (7, 10)], ((3, 7),)),
        ([(0, 4), (4, 10)], ()),
        ([(0, 10)], ()),
        ([(10, 12)], ((0, 10),)),
    ],
)
def test_what_is_missing_has_no_empty_span(others, left):
    assert uncovered_parts([(0, 10)], others) == left
    later = [(a + 10, b + 10) for a, b in others]
    assert uncovered_parts([(10, 20)], [(0, 10), *later]) == tuple(
        (a + 10, b + 10) for a, b in left
    )


@pytest.mark.parametrize("first", [(0, 5), (2, 5)])
@pytest.mark.parametrize("last", [(1, 3), (2, 9), (5, 6), (6, 7)])
def test_joined_spans_cover_the_same_frames(first, last):
    """Also where a span lies within the one before it, and where they only touch."""
    joined = joined_spans([last, first])
    assert {k for a, b in joined for k in range(a, b)} == {*range(*first), *range(*last)}
    assert len(joined) == (2 if last[0] > 5 else 1)


@pytest.mark.parametrize("entry", ["x", [1], 7, [1, 2, 3]])
def test_a_damaged_span_is_named_with_what_was_expected(entry):
    with pytest.raises(FormatError) as error:
        excluded_spans_from_json([[0, 4], entry])
    assert str(error.value).startswith("left_out, number 2: expected [start, stop] for a span")
    assert str(error.value).endswith(f"found {entry!r}")
