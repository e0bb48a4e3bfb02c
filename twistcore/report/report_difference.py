"""Compare the intervals in two versions of the report on a clip."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from twistcore.errors import FormatError, TwistError
from twistcore.files.document_values import check_keys, check_string, read_each, read_frame_span
from twistcore.report.clip_report import read_report_json

SCHEMA = "twistcore.report-difference/1"
SAME, NEW, GONE, DECIDED = "same", "new", "gone", "decided differently"


def is_clip_report_json(path: Path) -> bool:
    """Return True if a file is the JSON of a clip's report. Raises TwistError if unreadable."""
    return bool(read_report_json(path))


def compare_report_files(a: Path, b: Path) -> dict[str, Any]:
    """Return the differences between the intervals in two versions of a report, as JSON data.

    `a` and `b` are the JSON files of the earlier and the later version. Two intervals are the same
    error if they have the same chain, kind and joint and share frames, so an error is recognised
    even if a new detection or an edit changed its id. Raises TwistError if a file is not the JSON
    of a report.
    """
    old, new = (list(_intervals(path)) for path in (a, b))
    alike: dict[Any, list[int]] = {}
    for n, one in enumerate(new):
        alike.setdefault(_error(one), []).append(n)
    near = ((k, n) for k, one in enumerate(old) for n in alike.get(_error(one), ()))
    partner: dict[int, int] = {}
    met: set[int] = set()
    for common, k, n in sorted((-_common(old[k], new[n]), k, n) for k, n in near):
        if common < 0 and n not in partner and k not in met:
            partner[n] = k
            met.add(k)
    changes = [_change(old[partner[n]] if n in partner else None, i) for n, i in enumerate(new)]
    changes += [_change(i, None) for k, i in enumerate(old) if k not in met]
    return {
        "schema": SCHEMA,
        "a": str(a),
        "b": str(b),
        "same": sum(one["change"] == SAME for one in changes),
        "changes": [one for one in changes if one["change"] != SAME],
    }


def _intervals(path: Path) -> Sequence[Mapping[str, Any]]:
    document = read_report_json(path)
    try:
        return read_each(check_keys(document, "intervals")["intervals"], "intervals", _interval)
    except FormatError as error:
        raise TwistError(f"{path} is not the JSON of a clip's report: {error}") from None


def _interval(entry: Any) -> Mapping[str, Any]:
    for key in ("chain", "kind", "joint", "decision"):
        check_string(check_keys(entry, key)[key], key)
    read_frame_span(check_keys(entry, "start", "stop"))
    return dict(entry)


def _error(one: Mapping[str, Any]) -> tuple[str, ...]:
    return one["chain"], one["kind"], one["joint"]


def _common(one: Mapping[str, Any], other: Mapping[str, Any]) -> int:
    return int(min(one["stop"], other["stop"]) - max(one["start"], other["start"]))


def _change(old: Mapping[str, Any] | None, new: Mapping[str, Any] | None) -> dict[str, Any]:
    decisions = [one["decision"] if one else None for one in (old, new)]
    change = SAME if decisions[0] == decisions[1] else DECIDED
    change = NEW if old is None else GONE if new is None else change
    return {"change": change, "before": decisions[0], "after": decisions[1], **(new or old or {})}
