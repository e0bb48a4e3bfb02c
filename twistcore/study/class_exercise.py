"""An exercise for a class: what students get, what they hand in, and what a teacher makes of it.

The truth stays with the teacher, as a truth file (:mod:`twistcore.synthesis`): the exercise says
which intervals are to be judged, and of which clip, but not which of them are errors.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.atomic import write_atomically
from twistcore.detection import Interval
from twistcore.encoding import csv_text, json_bytes
from twistcore.errors import FormatError, TwistError
from twistcore.review import Decision, Judged
from twistcore.study.exercise import score
from twistcore.synthesis import InjectedError

EXERCISE = "twistcore.exercise/1"
SCORE = "twistcore.exercise-score/1"
KINDS = ("judge", "find")
_MOST_BYTES = 10_000_000  # of a file: a student may hand in anything
_MOST_FRAMES = 10_000_000  # in all intervals of a file: a day at 120 fps
_LONGEST_NAME = 100  # letters, in the table
COLUMNS = (
    "name", "hits", "misses", "false_accepted", "false_rejected", "without_verdict", "seconds",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class ClassExercise:
    """clip: the BVH file's name, beside the exercise; listed: what is to be judged."""

    clip: str
    sha256: str
    kind: str
    listed: tuple[Interval, ...]


@dataclass(frozen=True, eq=False)
class HandedIn:
    """What one student made of it: every interval with its verdict, and how long it took."""

    name: str
    seconds: float
    clip: str
    sha256: str
    verdicts: tuple[Judged, ...]


def write_exercise(path: Path, exercise: ClassExercise) -> None:
    """Write an exercise, atomically; angles in degrees."""
    own = {"clip": exercise.clip, "sha256": exercise.sha256, "kind": exercise.kind}
    listed = [_interval_to_json(i) for i in exercise.listed]
    write_atomically(path, json_bytes({"schema": EXERCISE, **own, "intervals": listed}))


def read_exercise(path: Path) -> ClassExercise:
    """Read an exercise; raises TwistError in one sentence."""
    document = _document(path, EXERCISE)
    try:
        if document["kind"] not in KINDS:
            raise ValueError(f"a kind {document['kind']!r}")
        name = str(document["clip"])
        if not name or Path(name).name != name:
            raise ValueError("a clip elsewhere than beside it")
        listed = _intervals(document["intervals"])
        return ClassExercise(name, str(document["sha256"]), document["kind"], listed)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{path}: {error} is missing or of the wrong kind") from None


def write_handed_in(path: Path, handed: HandedIn) -> None:
    """Write what a student hands in, atomically."""
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


def read_handed_in(path: Path) -> HandedIn:
    """Read what a student handed in; raises TwistError in one sentence."""
    document = _document(path, SCORE)
    try:
        entries = document["verdicts"]
        verdicts = tuple(
            Judged(k, interval, Decision(entry["decision"]))
            for k, (interval, entry) in enumerate(zip(_intervals(entries), entries, strict=True))
        )
        own = document["exercise"]
        seconds = float(document["seconds"])
        if not np.isfinite(seconds):
            raise ValueError("a time that is not finite")
        return HandedIn(
            str(document["name"]), seconds, str(own["clip"]), str(own["sha256"]), verdicts
        )
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise FormatError(f"{path}: {error} is missing or of the wrong kind") from None


def class_table(errors: Sequence[InjectedError], handed: Iterable[HandedIn]) -> str:
    """CSV with a row a student, by name: what the verdicts come to against the truth."""
    rows = []
    for student in sorted(handed, key=lambda h: h.name):
        result = score(errors, student.verdicts)
        counts = (
            _in_cell(student.name), len(result.hits), len(result.misses),
            len(result.false_accepted), len(result.false_rejected), result.left,
            round(student.seconds, 1),
        )  # fmt: skip
        rows.append(dict(zip(COLUMNS, counts, strict=True)))
    return csv_text(COLUMNS, rows)


def _in_cell(name: str) -> str:
    """On one line."""
    return " ".join(name.split())[:_LONGEST_NAME]


def schema_of(path: Path) -> str:
    """What kind of document a file is; raises TwistError where it is no JSON of ours."""
    return str(_document(path)["schema"])


def _document(path: Path, schema: str = "") -> Mapping[str, Any]:
    try:
        with path.open("rb") as file:
            data = file.read(_MOST_BYTES + 1)
        if len(data) > _MOST_BYTES:
            raise FormatError(f"{path}: expected a file of at most {_MOST_BYTES // 10**6} MB")
        document = json.loads(data)
    except OSError as error:
        raise TwistError(f"{path}: cannot be read ({error.strerror})") from None
    except RecursionError:
        raise FormatError(f"{path}: expected JSON that is less deep") from None
    except ValueError as error:
        raise FormatError(f"{path}: expected JSON ({error})") from None
    found = document.get("schema") if isinstance(document, dict) else None
    if found is None or (schema and found != schema):
        raise FormatError(f"{path}: expected a document with schema {schema or EXERCISE!r}")
    return dict(document)


def _interval_to_json(interval: Interval) -> dict[str, Any]:
    shown = round(float(np.degrees(interval.shown)), 3)
    own = {"chain": interval.chain, "start": interval.start, "stop": interval.stop}
    return {**own, "delta_deg": shown}


def _intervals(entries: Iterable[Mapping[str, Any]]) -> tuple[Interval, ...]:
    out: list[Interval] = []
    left = _MOST_FRAMES  # looked at before an offset for every frame takes the memory
    for entry in entries:
        out.append(_interval(entry, left))
        left -= out[-1].stop - out[-1].start
    return tuple(out)


def _interval(entry: Mapping[str, Any], most: int) -> Interval:
    """With at most so many frames."""
    start, stop, delta = entry["start"], entry["stop"], float(entry["delta_deg"])
    whole = isinstance(start, int) and isinstance(stop, int)
    if not (whole and 0 <= start < stop <= _MOST_FRAMES):
        raise ValueError(f"the interval {start}-{stop}")
    if stop - start > most:
        raise ValueError(f"so long an interval as {start}-{stop}")
    if not np.isfinite(delta):
        raise ValueError("an angle that is not finite")
    return Interval(str(entry["chain"]), start, stop, np.full(stop - start, np.radians(delta)))
