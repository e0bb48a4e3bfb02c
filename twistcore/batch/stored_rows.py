"""Check the values in the rows of a manifest, since the file may come from an untrusted source.

Every function raises FormatError if a value is wrong.
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
    check_bool,
    check_choice,
    check_integer,
    check_keys,
    check_list,
    check_number,
    check_path_string,
    check_string,
    check_string_list,
    parsed_json,
    read_each,
    read_frame_span,
    unexpected_value_error,
)
from twistcore.skeleton.rig import rig_from_json

_STATES = "done", "failed", "waiting"
_KINDS = tuple(kind.value for kind in Kind)
_Check = Callable[[Any, str], Any]


def _source(value: Any, what: str) -> str:
    """Check that a value is a URL or a path with a file name, and return it.

    `what` names the value in error messages.
    """
    if "://" not in check_path_string(value, what) and not Path(value).name:
        raise unexpected_value_error("a clip's path", what, value)
    return str(value)


def _name(value: Any, what: str) -> str:
    """Check that a value is a relative path that stays inside the folder, and return it.

    `what` names the value in error messages.
    """
    path = PurePosixPath(check_path_string(value, what))
    if not path.name or path.is_absolute() or ".." in path.parts:
        raise unexpected_value_error("a path below a folder", what, value)
    return str(value)


def _place(value: Any, what: str) -> str:
    return _name(value, what) if value != "" else ""


def _state(value: Any, what: str) -> str:
    return check_choice(value, what, _STATES)


def _amount(value: Any, what: str) -> float:
    return check_number(value, what, 0.0)


def _long(value: Any, what: str) -> int:
    return check_integer(value, what, 0, 2**63)


# The check for each column of a clip. All other columns are text.
COLUMNS: Mapping[str, _Check] = {
    "source": _source,
    "name": _name,
    "state": _state,
    "corrected": _place,
    **dict.fromkeys(("bytes", "peak_bytes", "missing_frames", "unexamined"), _long),
    "again": lambda value, what: check_integer(value, what, 0, 1),
    "seconds": _amount,
    "severity": _amount,
    "intervals": check_integer,
}


def check_column_value(name: str, value: Any) -> Any:
    """Check the value of the column `name`, and return it."""
    check: _Check = COLUMNS.get(name, check_string)
    return check(value, name)


def parse_stored_result(document: str) -> dict[str, Any]:
    """Parse and check a result, a document 'twistcore.batch_clip/1' without the clip's name."""
    known = "frames", "fps", "seconds", "severity", "affected_frames", "applied", "left"
    found = dict(check_keys(parsed_json(document), "schema", *known, *_RESULT, what="a result"))
    check_string(found["schema"], "schema")
    last = check_integer(found["frames"], "frames", 0, MOST_FRAMES)
    check_integer(found["affected_frames"], "affected_frames", 0, last)
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
    for kind, count in check_keys(value, what=what).items():
        check_integer(count, f"{what} of {check_choice(kind, what, _KINDS)}")


def _degrees(value: Any, what: str) -> None:
    for key in ("max", "rms"):
        _amount(check_keys(value, key, what=what)[key], key)


def _listed(value: Any, what: str) -> None:
    if not isinstance(value, list):
        raise unexpected_value_error("a list", what, value)


def _tau(value: Any, what: str) -> None:
    for degrees in check_keys(value, what=what).values():
        check_number(degrees, what, 0.0, 360.0)


def _quality(value: Any, what: str) -> None:
    """Check the numbers in a dict of quality measures, which may contain nested dicts."""
    for key, one in check_keys(value, what=what).items():
        if isinstance(one, Mapping):
            _quality(one, key)
        elif isinstance(one, float) or not isinstance(one, str | int | list | None):
            check_number(one, key)


def _limbs(value: Any, what: str) -> None:
    """Check a list of limbs that were not examined, each with the reason."""
    for entry in check_list(value, what):
        check_keys(entry, "limb", "why", what="a limb")
        for key in ("limb", "why", "side", "person"):
            check_string(entry.get(key, ""), key)


_RESULT: Mapping[str, _Check] = {
    **dict.fromkeys(("method", "format", "unchecked"), check_string),
    "intervals": _listed,
    "counts": _counts,
    "degrees": _degrees,
    "tau_deg": _tau,
}
# Keys that some results do not have, partly because the first versions did not write them.
_MORE: Mapping[str, _Check] = {
    "applied": check_integer,
    "left": _listed,
    "uncorrected": check_string_list,
    "warnings": check_string_list,
    "chains": check_string_list,
    "joints": check_integer,
    "missing_frames": _long,  # a header may claim any number
    "unexamined": _limbs,
    "sha256": check_string,
    "quality": _quality,
}
_OF_INTERVAL: Mapping[str, _Check] = {
    **dict.fromkeys(
        ("chain", "parent", "child", "limb", "end", "joint", "person", "part"), check_string
    ),
    **dict.fromkeys(("open", "carried"), check_bool),
    **dict.fromkeys(
        ("delta_deg", "turn_deg", "residual_deg", "speed_deg_s", "sigma_deg"), check_number
    ),
    "joints": check_string_list,
    "confidence": lambda value, what: check_number(value, what, 0.0, 1.0),
}


def _interval(entry: Any, last: int) -> None:
    """Check an interval, given as an entry of `detect --json`.

    `last` is the number of frames of the clip.
    """
    known = "chain", "start", "stop", "kind", "delta_deg", "confidence", "open"
    check_keys(entry, *known, what="an interval")
    read_frame_span(entry, last)
    check_choice(entry["kind"], "kind", _KINDS)
    for key in ("chain", "delta_deg", "open"):
        _OF_INTERVAL[key](entry[key], key)
    for key, check in _OF_INTERVAL.items():
        if entry.get(key) is not None:
            check(entry[key], key)
    if entry["kind"] == Kind.LONE_JUMP and entry.get("turn_deg") is not None:
        check_string(check_keys(entry, "joint", "speed_deg_s")["joint"], "joint")
        check_number(entry["speed_deg_s"], "speed_deg_s")


def parse_stored_parameters(document: str) -> dict[str, Any]:
    """Parse and check processing parameters, as written by :meth:`Parameters.to_json`.

    Unknown keys are ignored.
    """
    usual = Parameters().to_json()
    given = check_keys(parsed_json(document), what="parameters")
    values = {key: given.get(key, value) for key, value in usual.items()}
    check_string(values["method"], "method")
    for key in ("kinds", "chains", "people"):
        check_string_list(values[key], key)
    for kind in values["kinds"]:
        check_choice(kind, "kinds", _KINDS)
    for key in ("refine", "include_open"):
        check_bool(values[key], key)
    for key in ("tau_deg", "fps", "min_confidence"):
        if values[key] is not None:
            _amount(values[key], key)
    if values["profile_rad"] is not None:
        for radians in check_keys(values["profile_rad"], what="profile_rad").values():
            check_number(radians, "profile_rad", 0.0, math.pi)
    if values["rig"] is not None:
        rig_from_json(values["rig"])
    return values


_OF_DECISIONS = "accepted", "rejected", "undecided", "reviewers", "session", "at"


def parse_stored_decisions(document: str) -> dict[str, Any]:
    """Parse and check the progress of a review, as stored by :meth:`Manifest.note_decisions`."""
    values = check_keys(parsed_json(document), what="decisions")
    for key in ("accepted", "rejected", "undecided"):
        check_integer(values.get(key, 0), key)
    check_string_list(values.get("reviewers", []), "reviewers")
    for key in ("session", "at"):
        check_string(values.get(key, ""), key)
    if values.get("session"):
        check_path_string(values["session"], "session")
    return {key: values[key] for key in _OF_DECISIONS if key in values}  # these are stored again


# Checks of the columns of the tables other than `clips`.
STORED: Mapping[str, Mapping[str, _Check]] = {
    "parameters": {
        "mark": check_string,
        "document": lambda value, what: parse_stored_parameters(check_string(value, what)),
        "version": check_string,
    },
    "results": {
        "sha256": check_string,
        "mark": check_string,
        "bytes": _long,
        "document": lambda value, what: parse_stored_result(check_string(value, what)),
    },
    "decisions": {
        "source": _source,
        "document": lambda value, what: parse_stored_decisions(check_string(value, what)),
    },
}
