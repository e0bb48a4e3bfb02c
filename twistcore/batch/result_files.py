"""Write the results of a batch as JSON lines, as Parquet, and as a CSV table of clips."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from twistcore.analysis.clip_severity import percent_of_frames_with_error, unexamined_limb_sentences
from twistcore.batch.manifest import ClipRecord
from twistcore.detection import Kind
from twistcore.detection.kind import plural_kind_name
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically, writing_atomically
from twistcore.files.encoding import csv_text, encode_utf8, escape_invalid_utf8, json_text

_KINDS = {plural_kind_name(kind.value).replace(" ", "_").replace("-", "_"): kind for kind in Kind}
_VERDICTS = ("accepted", "rejected", "undecided")
_ROWS = 50_000  # rows in a Parquet row group, a few MB

# Name and type of the columns about a clip, in the CSV and in every row of the Parquet.
CLIP_COLUMNS: Mapping[str, type] = {
    "clip": str,  # name in the batch
    "state": str,  # done, failed or waiting
    "frames": int,
    "missing_frames": int,  # declared in the header, but not in the file
    "unexamined": int,  # arms and legs that no chain examines
    "fps": float,
    "seconds": float,
    "severity": float,  # root mean square of the errors, degrees
    **dict.fromkeys(_KINDS, int),
    "affected_frames": int,
    "affected_percent": float,
    "max_deg": float,  # largest offset over the affected frames
    "rms_deg": float,
    **dict.fromkeys(_VERDICTS, int),
    "reviewers": str,  # separated by '; '
    "applied": int,  # number of corrected intervals, with --refine
    "left": int,  # number of intervals that are found in the corrected clip
    "corrected": str,  # path in the batch folder
    "format": str,
    "method": str,
    "reason": str,  # why the clip or a limb was not processed, examined or corrected
    "sha256": str,
    "source": str,
}

# Name and type of the columns about an interval in the Parquet, as in `detect --json`. A value that
# the kind of interval does not have is null.
INTERVAL_COLUMNS: Mapping[str, type] = {
    "interval": int,  # index in the clip; null in the row of a clip without intervals
    "chain": str,
    "parent": str,
    "child": str,
    "limb": str,
    "end": str,
    "joint": str,
    "kind": str,
    "start": int,
    "stop": int,
    "delta_deg": float,
    "turn_deg": float,
    "confidence": float,
    "open": bool,
    "carried": bool,
}


def clip_result_row(record: ClipRecord) -> dict[str, Any]:
    """Return the values of a clip for :data:`CLIP_COLUMNS`, with None for unknown values."""
    row: dict[str, Any] = dict.fromkeys(CLIP_COLUMNS)
    row |= {"clip": record.name, "state": record.state, "source": record.source}
    row |= {"reason": record.reason, "sha256": record.sha256, "corrected": record.corrected}
    row |= {name: record.decisions.get(name) for name in _VERDICTS}
    row["reviewers"] = "; ".join(record.decisions.get("reviewers", ()))
    if (result := record.result) is not None:
        same = ("frames", "fps", "seconds", "severity", "affected_frames", "applied")
        row |= {name: result[name] for name in (*same, "format", "method")}
        row["missing_frames"] = result.get("missing_frames")
        limbs = result.get("unexamined")
        row["unexamined"] = None if limbs is None else len(limbs)
        row |= {name: result["counts"].get(kind.value, 0) for name, kind in _KINDS.items()}
        row["affected_percent"] = percent_of_frames_with_error(
            result["affected_frames"], result["frames"]
        )
        row |= {f"{name}_deg": result["degrees"][name] for name in ("max", "rms")}
        row["left"] = None if result["left"] is None else len(result["left"])
        left = (*(result.get("uncorrected") or ()), *unexamined_limb_sentences(result))
        row["reason"] = record.reason or result["unchecked"] or "; ".join(left)
    return row


def clips_csv(records: Iterable[ClipRecord]) -> str:
    """Return a CSV table with a header and one line for each clip."""
    return csv_text(CLIP_COLUMNS, map(clip_result_row, records))


def write_clip_table(path: Path, records: Iterable[ClipRecord]) -> None:
    """Write the clip table as a CSV file. Raises OSError."""
    write_atomically(path, encode_utf8(clips_csv(records)))


def json_line(record: ClipRecord) -> str:
    """Return a clip's result document, including its source, state and decisions, as a JSON line.

    If the clip has no result, only the schema, the name and the SHA-256 are written in its place.
    """
    bare = {"schema": "twistcore.batch_clip/1", "clip": record.name, "sha256": record.sha256}
    document = {
        **(bare if record.result is None else record.result),
        "source": record.source,
        "state": record.state,
        "reason": record.reason,
        "corrected": record.corrected,
        "decisions": dict(record.decisions),
    }
    return json_text(document, indent=None)


def write_json_lines(path: Path, records: Iterable[ClipRecord]) -> None:
    """Write one line of JSON per clip. Only one clip is in memory at a time. Raises OSError."""
    with writing_atomically(path) as file:
        for record in records:
            file.write(json_line(record).encode() + b"\n")


def interval_rows(record: ClipRecord) -> Iterator[dict[str, Any]]:
    """Yield one row for each interval of a clip, with the clip's columns repeated.

    A clip without intervals has one row with None in the interval columns, so that the clip is
    listed.
    """
    result = record.result or {}
    of_clip = clip_result_row(record) | {
        "quality": json.dumps(result.get("quality", {}), sort_keys=True)
    }
    intervals = result.get("intervals", ())
    for number, interval in enumerate(intervals):
        yield (
            of_clip | {name: interval.get(name) for name in INTERVAL_COLUMNS} | {"interval": number}
        )
    if not intervals:
        yield of_clip | dict.fromkeys(INTERVAL_COLUMNS)


def write_interval_parquet(path: Path, records: Iterable[ClipRecord]) -> None:
    """Write the :func:`interval_rows` of all clips as Parquet.

    Raises TwistError if pyarrow is not installed, and OSError if the file cannot be written.
    """
    try:
        import pyarrow as pa  # optional, and slow to import
        import pyarrow.parquet as pq
    except ImportError:
        raise TwistError(
            'Parquet needs pyarrow: install it with pip install "twist-inspector[parquet]"'
        ) from None
    types = {str: pa.string(), int: pa.int64(), float: pa.float64(), bool: pa.bool_()}
    columns = {**CLIP_COLUMNS, "quality": str, **INTERVAL_COLUMNS}
    schema = pa.schema([(name, types[kind]) for name, kind in columns.items()])
    rows = (row for record in records for row in interval_rows(record))
    with writing_atomically(path) as file, pq.ParquetWriter(file, schema) as writer:
        while some := list(islice(rows, _ROWS)):
            writer.write_table(pa.Table.from_pylist(list(map(_plain, some)), schema=schema))


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of the row in which bytes that are not UTF-8 are escaped, for Parquet."""
    return {k: escape_invalid_utf8(v) if isinstance(v, str) else v for k, v in row.items()}
