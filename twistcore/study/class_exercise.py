"""Read and write the files of a class exercise: the exercise, the answers and the results.

The exercise lists the intervals of a clip that students must judge, but not which of them are
errors. The errors are in the teacher's truth file (:mod:`twistcore.synthesis`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from twistcore.detection import Interval
from twistcore.errors import FormatError
from twistcore.files.atomic import write_atomically
from twistcore.files.document_values import (
    DEGREES,
    check_choice,
    check_keys,
    check_number,
    check_path_string,
    check_string,
    parsed_json,
    prefix_format_errors,
    read_bytes_limited,
    read_each,
    read_frame_span,
    unexpected_value_error,
)
from twistcore.files.encoding import csv_text, json_bytes
from twistcore.review import Decision, Judged
from twistcore.study.exercise import score_review_of_hidden_errors
from twistcore.synthesis import InjectedError

EXERCISE = "twistcore.exercise/1"
SCORE = "twistcore.exercise-score/1"
KINDS = ("judge", "find")
_MOST_BYTES = 10_000_000  # maximum size of a file, because a student may hand in any file
_MOST_FRAMES = 10_000_000  # maximum length of a clip, which is a day at 120 fps
_MOST_INTERVALS = 1000
_LONGEST_NAME = 100  # maximum length of a name in the table
_Thing = TypeVar("_Thing")
COLUMNS = (
    "name", "hits", "misses", "false_accepted", "false_rejected", "without_verdict", "seconds",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class ClassExercise:
    """An exercise in which students judge intervals of a clip.

    Attributes
    ----------
    clip
        Name of the clip's file, which is in the same folder.
    sha256
        SHA-256 of this file.
    kind
        One of KINDS.
    listed
        The intervals to judge.
    """

    clip: str
    sha256: str
    kind: str
    listed: tuple[Interval, ...]


@dataclass(frozen=True, eq=False)
class StudentAnswer:
    """A student's answer to a class exercise.

    Attributes
    ----------
    name
        The student's name.
    seconds
        The time that the student needed.
    clip, sha256
        Name and SHA-256 of the clip's file.
    verdicts
        The student's verdict on each interval.
    """

    name: str
    seconds: float
    clip: str
    sha256: str
    verdicts: tuple[Judged, ...]


def write_student_exercise(path: Path, exercise: ClassExercise) -> None:
    """Write an exercise atomically, with angles in degrees."""
    own = {"clip": exercise.clip, "sha256": exercise.sha256, "kind": exercise.kind}
    listed = [_interval_to_json(i) for i in exercise.listed]
    write_atomically(path, json_bytes({"schema": EXERCISE, **own, "intervals": listed}))


def read_student_exercise(path: Path) -> ClassExercise:
    """Read an exercise. Raises TwistError if the file is invalid."""
    with prefix_format_errors(path):
        document = check_keys(_document(path, EXERCISE), "kind", "clip", "sha256", "intervals")
        name = check_path_string(document["clip"], "clip")
        if not name or Path(name).name != name:
            raise unexpected_value_error("the name of a clip in the same folder", "clip", name)
        return ClassExercise(
            name,
            check_string(document["sha256"], "sha256"),
            check_choice(document["kind"], "kind", KINDS),
            _few(read_each(document["intervals"], "intervals", _interval)),
        )


def write_student_answer(path: Path, handed: StudentAnswer) -> None:
    """Write a student's answer atomically."""
    verdicts = [
        {**_interval_to_json(j.interval), "decision": j.decision.value} for j in handed.verdicts
    ]
    document = {
        "schema": SCORE,
        "exercise": {"clip": handed.clip, "sha256": handed.sha256},
        "name": handed.name,
        "seconds": round(handed.seconds, 1),
        "verdicts": verdicts,
    }
    write_atomically(path, json_bytes(document))


def read_student_answer(path: Path) -> StudentAnswer:
    """Read a student's answer. Raises TwistError if the file is invalid."""
    with prefix_format_errors(path):
        document = check_keys(_document(path, SCORE), "verdicts", "exercise", "name", "seconds")
        verdicts = _few(read_each(document["verdicts"], "verdicts", _verdict))
        own = check_keys(document["exercise"], "clip", "sha256", what="exercise")
        return StudentAnswer(
            check_string(document["name"], "name"),
            check_number(document["seconds"], "seconds"),
            check_string(own["clip"], "clip"),
            check_string(own["sha256"], "sha256"),
            tuple(replace(judged, id=k) for k, judged in enumerate(verdicts)),
        )


def student_exercise_score_table(
    errors: Sequence[InjectedError], handed: Iterable[StudentAnswer]
) -> str:
    """Return a CSV table that compares students' verdicts with the hidden errors.

    `handed` contains the students' answers. The table has one row per student, sorted by name.
    """
    rows = []
    for student in sorted(handed, key=lambda h: h.name):
        result = score_review_of_hidden_errors(errors, student.verdicts)
        counts = (
            _in_cell(student.name), len(result.hits), len(result.misses),
            len(result.false_accepted), len(result.false_rejected), result.left,
            round(student.seconds, 1),
        )  # fmt: skip
        rows.append(dict(zip(COLUMNS, counts, strict=True)))
    return csv_text(COLUMNS, rows)


def _in_cell(name: str) -> str:
    """Convert a name to a single line that is short enough for a table cell."""
    return " ".join(name.split())[:_LONGEST_NAME]


def exercise_json_file_schema(path: Path) -> str:
    """Return the schema of a JSON file. Raises TwistError if the file has none."""
    with prefix_format_errors(path):
        return str(_document(path)["schema"])


def _document(path: Path, schema: str = "") -> Mapping[str, Any]:
    document = parsed_json(read_bytes_limited(path, _MOST_BYTES))
    found = document.get("schema") if isinstance(document, dict) else None
    if not isinstance(found, str) or (schema and found != schema):
        raise FormatError(f"expected a document with schema {schema or EXERCISE!r}")
    return dict(document)


def _interval_to_json(interval: Interval) -> dict[str, Any]:
    shown = round(float(np.degrees(interval.shown)), 3)
    own = {"chain": interval.chain, "start": interval.start, "stop": interval.stop}
    return {**own, "delta_deg": shown}


def _few(things: tuple[_Thing, ...]) -> tuple[_Thing, ...]:
    """Return the intervals or verdicts unchanged. Raises FormatError if there are too many."""
    if len(things) > _MOST_INTERVALS:
        raise FormatError(f"expected at most {_MOST_INTERVALS} intervals, found {len(things)}")
    return things


def _verdict(entry: Any) -> Judged:
    decision = check_keys(entry, "decision", what="a verdict")["decision"]
    known = [d.value for d in Decision]
    return Judged(0, _interval(entry), Decision(check_choice(decision, "decision", known)))


def _interval(entry: Any) -> Interval:
    """Convert a JSON entry to an interval.

    To save memory, its constant offset is stored as a broadcast array.
    """
    check_keys(entry, "chain", "start", "stop", "delta_deg", what="an interval")
    start, stop = read_frame_span(entry, _MOST_FRAMES)
    delta = np.radians([check_number(entry["delta_deg"], "delta_deg", -DEGREES, DEGREES)])
    offset = np.broadcast_to(delta, (stop - start,))
    return Interval(check_string(entry["chain"], "chain"), start, stop, offset)
