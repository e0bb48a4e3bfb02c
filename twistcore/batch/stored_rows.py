"""What a manifest has in its rows, looked at as any document that a stranger may have made.

Every function raises FormatError with one sentence.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from twistcore.batch.parameters import Parameters
from twistcore.detection import Kind
from twistcore.files.document_values import (
    MOST_FRAMES,
    flag,
    frames,
    has,
    items,
    number,
    one_of,
    parsed_json,
    path_text,
    read_each,
    text,
    texts,
    unexpected,
    whole,
)
from twistcore.skeleton.rig import rig_from_json

_STATES = "done", "failed", "waiting"
_KINDS = tuple(kind.value for kind in Kind)
_Check = Callable[[Any, str], Any]


def _source(value: Any, what: str) -> str:
    """An absolute path or a URL: it has the name of a file."""
    if "://" not in path_text(value, what) and not Path(value).name:
        raise unexpected("a clip's path", what, value)
    return str(value)


def _name(value: Any, what: str) -> str:
    """A place below a folder, which leads nowhere else."""
    path = PurePosixPath(path_text(value, what))
    if not path.name or path.is_absolute() or ".." in path.parts:
        raise unexpected("a place below a folder", what, value)
    return str(value)


def _place(value: Any, what: str) -> str:
    return _name(value, what) if value != "" else ""


def _state(value: Any, what: str) -> str:
    return one_of(value, what, _STATES)


def _amount(value: Any, what: str) -> float:
    return number(value, what, 0.0)


def _long(value: Any, what: str) -> int:
    return whole(value, what, 0, 2**63)


# What stands in the columns of a clip, as SQLite has it.
COLUMNS: Mapping[str, _Check] = {
    "source": _source,
    "name": _name,
    "state": _state,
    "corrected": _place,
    **dict.fromkeys(("bytes", "peak_bytes", "missing_frames", "unexamined"), _long),
    "again": lambda value, what: whole(value, what, 0, 1),
    "seconds": _amount,
    "severity": _amount,
    "intervals": whole,
}


def column(name: str, value: Any) -> Any:
    """A value of a column; most hold a text."""
    check: _Check = COLUMNS.get(name, text)
    return check(value, name)


def result_of(document: str) -> dict[str, Any]:
    """A result, 'twistcore.batch_clip/1' without its clip."""
    known = "frames", "fps", "seconds", "severity", "affected_frames", "applied", "left"
    found = dict(has(parsed_json(document), "schema", *known, *_RESULT, what="a result"))
    text(found["schema"], "schema")
    last = whole(found["frames"], "frames", 0, MOST_FRAMES)
    whole(found["affected_frames"], "affected_frames", 0, last)
    for key in ("fps", "seconds", "severity"):
        _amount(found[key], key)
    for key, check in _RESULT.items():
        check(found[key], key)
    for key, check in _MORE.items():
        if found.get(key) is not None:
            check(found[key], key)
    for key in ("intervals", "left"):
        read_each(found.get(key) or [], key, lambda entry: _interval(entry, last))
    return found


def _counts(value: Any, what: str) -> None:
    for kind, count in has(value, what=what).items():
        whole(count, f"{what} of {one_of(kind, what, _KINDS)}")


def _degrees(value: Any, what: str) -> None:
    for key in ("max", "rms"):
        _amount(has(value, key, what=what)[key], key)


def _listed(value: Any, what: str) -> None:
    if not isinstance(value, list):
        raise unexpected("a list", what, value)


def _tau(value: Any, what: str) -> None:
    for degrees in has(value, what=what).values():
        number(degrees, what, 0.0, 360.0)


def _quality(value: Any, what: str) -> None:
    """Numbers by their names, some of them by names again."""
    for key, one in has(value, what=what).items():
        if isinstance(one, Mapping):
            _quality(one, key)
        elif isinstance(one, float) or not isinstance(one, str | int | list | None):
            number(one, key)


def _limbs(value: Any, what: str) -> None:
    """Limbs that were not examined, each with the reason."""
    for entry in items(value, what):
        has(entry, "limb", "why", what="a limb")
        for key in ("limb", "why", "side", "person"):
            text(entry.get(key, ""), key)


_RESULT: Mapping[str, _Check] = {
    **dict.fromkeys(("method", "format", "unchecked"), text),
    "intervals": _listed,
    "counts": _counts,
    "degrees": _degrees,
    "tau_deg": _tau,
}
# What is not known of every clip, or was not in the first versions.
_MORE: Mapping[str, _Check] = {
    "applied": whole,
    "left": _listed,
    "uncorrected": texts,
    "warnings": texts,
    "chains": texts,
    "joints": whole,
    "missing_frames": _long,  # a header may claim any number
    "unexamined": _limbs,
    "sha256": text,
    "quality": _quality,
}
_OF_INTERVAL: Mapping[str, _Check] = {
    **dict.fromkeys(("chain", "parent", "child", "limb", "end", "joint", "person", "part"), text),
    **dict.fromkeys(("open", "carried"), flag),
    **dict.fromkeys(("delta_deg", "turn_deg", "residual_deg", "speed_deg_s", "sigma_deg"), number),
    "joints": texts,
    "confidence": lambda value, what: number(value, what, 0.0, 1.0),
}


def _interval(entry: Any, last: int) -> None:
    """An entry of `detect --json`."""
    known = "chain", "start", "stop", "kind", "delta_deg", "confidence", "open"
    has(entry, *known, what="an interval")
    frames(entry, last)
    one_of(entry["kind"], "kind", _KINDS)
    for key in ("chain", "delta_deg", "open"):
        _OF_INTERVAL[key](entry[key], key)
    for key, check in _OF_INTERVAL.items():
        if entry.get(key) is not None:
            check(entry[key], key)
    if entry.get("turn_deg") is not None:  # of a lone jump, which is told with these
        text(has(entry, "joint", "speed_deg_s")["joint"], "joint")
        number(entry["speed_deg_s"], "speed_deg_s")


def parameters_of(document: str) -> dict[str, Any]:
    """What clips were processed with, as :meth:`Parameters.to_json` has it.

    What this version knows nothing of is left out.
    """
    usual = Parameters().to_json()
    given = has(parsed_json(document), what="parameters")
    told = {key: given.get(key, value) for key, value in usual.items()}
    text(told["method"], "method")
    for key in ("kinds", "chains", "people"):
        texts(told[key], key)
    for kind in told["kinds"]:
        one_of(kind, "kinds", _KINDS)
    for key in ("refine", "include_open"):
        flag(told[key], key)
    for key in ("tau_deg", "fps", "min_confidence"):
        if told[key] is not None:
            _amount(told[key], key)
    if told["profile_rad"] is not None:
        for radians in has(told["profile_rad"], what="profile_rad").values():
            number(radians, "profile_rad", 0.0, math.pi)
    if told["rig"] is not None:
        rig_from_json(told["rig"])
    return told


_OF_DECISIONS = "accepted", "rejected", "undecided", "reviewers", "session", "at"


def decisions_of_clip(document: str) -> dict[str, Any]:
    """How far a review is, as :meth:`Manifest.note_decisions` was given it."""
    told = has(parsed_json(document), what="decisions")
    for key in ("accepted", "rejected", "undecided"):
        whole(told.get(key, 0), key)
    texts(told.get("reviewers", []), "reviewers")
    for key in ("session", "at"):
        text(told.get(key, ""), key)
    if told.get("session"):
        path_text(told["session"], "session")
    return {key: told[key] for key in _OF_DECISIONS if key in told}  # they are written again
