"""Exercises of a class: what is written is read again, and the table is right."""

import csv
import io
import json

import numpy as np
import pytest

from twistcore.detection import Interval
from twistcore.errors import TwistError
from twistcore.review import Decision, Judged
from twistcore.study.class_exercise import (
    ClassExercise,
    StudentAnswer,
    read_student_answer,
    read_student_exercise,
    student_exercise_score_table,
    write_student_answer,
    write_student_exercise,
)
from twistcore.synthesis import InjectedError


def interval(start, stop, chain="LeftArm", degrees=40.0):
    return Interval(chain, start, stop, np.full(stop - start, np.radians(degrees)))


ERROR = InjectedError("LeftArm", 10, 20, np.full(10, 0.7))
OTHER = InjectedError("RightArm", 30, 35, np.full(5, 0.7))
LISTED = (interval(10, 20), interval(30, 35, "RightArm"), interval(50, 60, "LeftLeg", -90.0))


def handed(name, *decisions):
    verdicts = (Judged(k, i, d) for k, (i, d) in enumerate(zip(LISTED, decisions, strict=True)))
    return StudentAnswer(name, 61.25, "a.bvh", "9f2c", tuple(verdicts))


YES, NO, OPEN = Decision.ACCEPTED, Decision.REJECTED, Decision.UNDECIDED


def test_an_exercise_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "a.json"
    write_student_exercise(path, ClassExercise("a.bvh", "9f2c", "judge", LISTED))
    again = read_student_exercise(path)
    assert (again.clip, again.sha256, again.kind) == ("a.bvh", "9f2c", "judge")
    for one, other in zip(again.listed, LISTED, strict=True):
        assert (one.chain, one.start, one.stop) == (other.chain, other.start, other.stop)
        assert np.allclose(one.offset, other.offset)
    # Nothing but the intervals: no word on which of them is an error.
    assert set(json.loads(path.read_text())["intervals"][0]) == {
        "chain", "start", "stop", "delta_deg",
    }  # fmt: skip


def test_what_is_handed_in_is_read_and_scored(tmp_path):
    students = [handed("Zoe", YES, NO, NO), handed("Ana, B.", YES, YES, OPEN)]
    again = []
    for k, one in enumerate(students):
        write_student_answer(tmp_path / f"{k}.json", one)
        again.append(read_student_answer(tmp_path / f"{k}.json"))
    table = student_exercise_score_table((ERROR, OTHER), again)
    rows = list(csv.DictReader(io.StringIO(table)))
    assert [row["name"] for row in rows] == ["Ana, B.", "Zoe"]
    ana, zoe = rows
    assert [ana[k] for k in ("hits", "misses", "without_verdict")] == ["2", "0", "1"]
    assert [zoe[k] for k in ("hits", "misses", "false_accepted", "false_rejected")] == [
        "1", "1", "0", "1",
    ]  # fmt: skip
    assert zoe["seconds"] == "61.2"
    wrong = student_exercise_score_table((ERROR, OTHER), [handed("Kim", NO, NO, YES)])
    (kim,) = csv.DictReader(io.StringIO(wrong))
    assert (kim["false_accepted"], kim["false_rejected"], kim["hits"]) == ("1", "2", "0")


GOOD = {"schema": "twistcore.exercise/1", "clip": "a.bvh", "sha256": "9", "kind": "find"}


@pytest.mark.parametrize(
    "change",
    [
        {"schema": "twistcore.truth/1"},
        {"kind": "guess"},
        {"clip": "../a.bvh"},
        {"intervals": [{"chain": "LeftArm", "start": 9, "stop": 4, "delta_deg": 1.0}]},
        {"intervals": [{"chain": "LeftArm", "start": 1, "stop": 4, "delta_deg": None}]},
        {"intervals": [{"start": 1, "stop": 4, "delta_deg": 5.0}]},
        {"intervals": 3},
    ],
)
def test_a_damaged_exercise_is_refused_in_a_sentence(tmp_path, change):
    path = tmp_path / "a.json"
    path.write_text(json.dumps(GOOD | {"intervals": []}))
    assert read_student_exercise(path).listed == ()
    path.write_text(json.dumps(GOOD | {"intervals": []} | change))
    with pytest.raises(TwistError, match=r"a\.json") as told:
        read_student_exercise(path)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("text", ["", "[]", '{"schema": 3}', "{"])
def test_what_is_no_score_file_is_refused(tmp_path, text):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(TwistError, match=r"a\.json"):
        read_student_answer(path)
    with pytest.raises(TwistError, match=r"b\.json"):
        read_student_answer(tmp_path / "b.json")


HANDED = {
    "schema": "twistcore.exercise-score/1", "exercise": {"clip": "a.bvh", "sha256": "9"},
    "name": "Kim", "seconds": 4.0,
}  # fmt: skip


def verdict(start, stop, delta="5.0"):
    own = f'{{"chain": "LeftArm", "start": {start}, "stop": {stop}, "delta_deg": {delta}'
    return f'{own}, "decision": "accepted"}}'


@pytest.mark.parametrize(
    "verdicts",
    [
        verdict(0, 900_000_000_000_000),
        verdict(899_999_999_999_999, 900_000_000_000_000),
        ", ".join([verdict(0, 9_000_000)] * 1001),
        verdict(1, 4, "1" + "0" * 400),
        verdict(1, 4, "1e999"),
        "[" * 200_000,
        "[" * 200_000 + "]" * 200_000,
        verdict(1, 4) + " " * 10_000_000,
    ],
    ids=lambda text: text[:60],
)
def test_no_file_of_a_student_takes_the_memory(tmp_path, verdicts):
    path = tmp_path / "a.json"
    start = json.dumps(HANDED)[:-1]
    path.write_text(f'{start}, "verdicts": [{verdict(1, 4)}]}}')
    assert len(read_student_answer(path).verdicts) == 1
    path.write_text(f'{start}, "verdicts": [{verdicts}]}}')
    with pytest.raises(TwistError, match=r"a\.json") as told:
        read_student_answer(path)
    assert "\n" not in str(told.value)
    path.write_text(json.dumps(GOOD)[:-1] + f', "intervals": [{verdicts}]}}')
    with pytest.raises(TwistError, match=r"a\.json"):
        read_student_exercise(path)


def test_long_intervals_of_a_student_take_no_memory_before_they_are_compared(tmp_path):
    path = tmp_path / "a.json"
    verdicts = ", ".join([verdict(0, 9_000_000)] * 1000)  # 72 GB in all
    path.write_text(f'{json.dumps(HANDED)[:-1]}, "verdicts": [{verdicts}]}}')
    offsets = [judged.interval.offset for judged in read_student_answer(path).verdicts]
    assert {offset.shape for offset in offsets} == {(9_000_000,)}
    assert {offset.strides for offset in offsets} == {(0,)}


@pytest.mark.parametrize(
    ("name", "cell"),
    [
        ('=HYPERLINK("http://x/","Ada")', '\'=HYPERLINK("http://x/","Ada")'),
        ("\t=1+1", "'=1+1"),
        ("\r\n@SUM(A1)", "'@SUM(A1)"),
        ("-2+3", "'-2+3"),
        ("+1", "'+1"),
        ("Ada\n\u2028 Lovelace", "Ada Lovelace"),
        ("Ada = Lovelace", "Ada = Lovelace"),
    ],
)
def test_a_name_is_one_line_and_no_formula(name, cell):
    table = student_exercise_score_table((ERROR, OTHER), [handed(name, YES, NO, NO)])
    assert len(table.splitlines()) == 2
    (row,) = csv.DictReader(io.StringIO(table))
    assert row["name"] == cell
