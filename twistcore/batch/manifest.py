"""The manifest of a batch folder: an SQLite file with the state of every clip.

One process writes the results, clip by clip; others may read the manifest and add decisions. If
the process is killed or the disk is full, all earlier entries stay intact.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from twistcore.batch.manifest_tables import make_tables, shape_of, shape_of_ours
from twistcore.batch.parameters import Parameters
from twistcore.batch.stored_rows import (
    STORED,
    column,
    decisions_of_clip,
    parameters_of,
    result_of,
)
from twistcore.errors import FormatError, TwistError
from twistcore.files.document_values import saying, shown_words, text
from twistcore.files.encoding import escaped, json_text, legible, unescaped
from twistcore.files.ordinary import check_no_links
from twistcore.files.version import __version__
from twistcore.work.frozen import dataclass

FILE = "manifest.sqlite"
DONE, FAILED, WAITING = "done", "failed", "waiting"

_COMPANIONS = ("-journal", "-wal", "-shm")  # files that SQLite puts next to it
_SCHEMA = 1
_OURS = 0x54774261  # 'TwBa': in the file's header, where it can be read without SQLite
_MAGIC, _SCHEMA_AT, _OURS_AT = b"SQLite format 3\0", 60, 68
_BUSY_S = 10.0  # waiting time while another process writes


@dataclass(frozen=True)
class ClipRecord:
    """A clip of a batch folder.

    Parameters
    ----------
    source
        Absolute path or URL.
    name
        Unique path relative to the input folder, with '/'.
    state
        'done', 'failed' or 'waiting'.
    reason
        A sentence with the reason for a failure, or an empty string.
    sha256, bytes
        Hash and size of the file.
    seconds, peak_bytes
        Time and memory used for processing.
    finished_at
        Time in ISO 8601, UTC, or an empty string.
    parameters, version
        Processing parameters and program version used.
    result
        The document 'twistcore.batch_clip/1', or None.
    corrected
        Path of the corrected clip in the batch folder, or an empty string.
    decisions
        Progress of a review, as given to :meth:`Manifest.note_decisions`, or {}.
    """

    source: str
    name: str
    state: str = WAITING
    reason: str = ""
    sha256: str = ""
    bytes: int = 0
    seconds: float = 0.0
    peak_bytes: int = 0
    finished_at: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict)
    version: str = ""
    result: Mapping[str, Any] | None = None
    corrected: str = ""
    decisions: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class ClipGlance:
    """The main data of a clip, for long lists. For other fields, see ClipRecord and its result.

    Parameters
    ----------
    mark
        Hash of the parameters, which identifies them.
    signature
        The file's signature when it was processed, '' if unreliable.
    """

    source: str
    name: str
    state: str
    reason: str
    mark: str
    sha256: str
    signature: str
    severity: float
    intervals: int
    unchecked: str
    missing_frames: int
    unexamined: int


@dataclass(frozen=True)
class ManifestRow:
    """A clip's row as a run reads and writes it. For other fields, see ClipRecord.

    Parameters
    ----------
    again
        True if a failed clip should be processed again.
    mark
        Hash of the parameters, which identifies them.
    signature
        The file's signature, '' if the file must be read to recognise it.
    corrected_sha256, corrected_signature
        Hash and signature of the corrected file.
    """

    source: str
    name: str
    state: str = WAITING
    reason: str = ""
    again: bool = False
    mark: str = ""
    sha256: str = ""
    bytes: int = 0
    signature: str = ""
    seconds: float = 0.0
    peak_bytes: int = 0
    finished_at: str = ""
    corrected: str = ""
    corrected_sha256: str = ""
    corrected_signature: str = ""


_COLUMNS = tuple(ManifestRow.__dataclass_fields__)
_PUT = (
    f"INSERT INTO clips ({', '.join(_COLUMNS)}) VALUES ({', '.join('?' * len(_COLUMNS))}) "
    "ON CONFLICT (source) DO UPDATE SET "
    + ", ".join(f"{c} = excluded.{c}" for c in _COLUMNS if c != "source")
)
_RECORDS = (
    "SELECT c.source, c.name, c.state, c.reason, c.sha256, c.bytes, c.seconds, c.peak_bytes, "
    "c.finished_at, p.document, p.version, r.document, c.corrected, d.document FROM clips c "
    "LEFT JOIN parameters p ON p.mark = c.mark "
    "LEFT JOIN results r ON r.sha256 = c.sha256 AND r.mark = c.mark AND c.state = 'done' "
    "LEFT JOIN decisions d ON d.source = c.source "
)


_OF_RECORD = (
    *("source", "name", "state", "reason", "sha256", "bytes", "seconds", "peak_bytes"),
    *("finished_at", "corrected"),
)
_GLANCES = (
    "SELECT c.source, c.name, c.state, c.reason, c.mark, c.sha256, c.signature, "
    "coalesce(json_extract(r.document, '$.severity'), 0.0), "
    "coalesce(json_array_length(r.document, '$.intervals'), 0), "
    "coalesce(json_extract(r.document, '$.unchecked'), ''), "
    "coalesce(json_extract(r.document, '$.missing_frames'), 0), "
    "coalesce(json_array_length(r.document, '$.unexamined'), 0) FROM clips c "
    "LEFT JOIN results r ON r.sha256 = c.sha256 AND r.mark = c.mark AND c.state = 'done' "
    "ORDER BY c.name"
)

_UNCORRECTED = (
    "SELECT c.source, c.name, r.document FROM clips c "
    "JOIN results r ON r.sha256 = c.sha256 AND r.mark = c.mark AND c.state = 'done' "
    "WHERE json_array_length(r.document, '$.uncorrected') > 0 ORDER BY c.name"
)

_TAKE = {
    table: f"INSERT INTO {table} ({', '.join(checks)}) VALUES ({', '.join('?' * len(checks))}) "
    "ON CONFLICT DO NOTHING"
    for table, checks in STORED.items()
}
_TAKE["decisions"] = _TAKE["decisions"].replace(
    "DO NOTHING",
    "(source) DO UPDATE SET document = excluded.document "
    "WHERE json_extract(excluded.document, '$.at') > json_extract(document, '$.at')",
)


def is_batch_folder(path: Path | str) -> bool:
    """Return True if a folder has a manifest of this program. Reads at most 100 bytes."""
    try:
        if not (Path(path) / FILE).is_file():  # opening a FIFO would wait for its writer
            return False
        with (Path(path) / FILE).open("rb") as file:
            head = file.read(100)
    except OSError:
        return False
    ours = int.from_bytes(head[_OURS_AT : _OURS_AT + 4], "big")
    schema = int.from_bytes(head[_SCHEMA_AT : _SCHEMA_AT + 4], "big")
    return head.startswith(_MAGIC) and (ours, schema) == (_OURS, _SCHEMA)


class Manifest:
    """The manifest of a folder. Use it as a context manager to close the file.

    Its methods raise TwistError if the file is damaged or cannot be written.
    """

    def __init__(self, folder: Path, connection: sqlite3.Connection) -> None:
        self.folder = folder
        self._connection = connection

    @classmethod
    def open(cls, folder: Path | str, *, create: bool = False) -> Self:
        """Open the manifest of a folder.

        Raises TwistError if it is missing and `create` is False.
        """
        folder = Path(folder)
        file = folder / FILE
        for ours in (file, *(file.with_name(FILE + ending) for ending in _COMPANIONS)):
            check_no_links(folder, ours)
        if not file.exists() or (create and file.stat().st_size == 0):
            if not create:
                raise TwistError(f"{folder}: expected a folder written by twistcore batch")
        elif not is_batch_folder(folder):
            raise FormatError(f"{file}: expected a manifest written by twistcore batch")
        with _sqlite_errors(file):
            connection = sqlite3.connect(file, timeout=_BUSY_S, isolation_level=None)
        try:
            manifest = cls(folder, connection)
            manifest._begin(create)
        except BaseException:
            connection.close()
            raise
        return manifest

    def _begin(self, create: bool) -> None:
        file = self.folder / FILE
        with _sqlite_errors(file):
            # No WAL: its shared memory does not work on network disks, where captures are stored.
            self._connection.execute("PRAGMA journal_mode = TRUNCATE").fetchone()
            if create:
                self._make()
            if shape_of(self._connection) != shape_of_ours():
                raise FormatError(
                    "expected a manifest written by twistcore batch, found other tables"
                )

    def __enter__(self) -> Self:
        """Return the manifest."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the manifest."""
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    # -- for readers --------------------------------------------------------------------------

    def records(self) -> list[ClipRecord]:
        """Return all clips, sorted by name."""
        return list(self.each_record())

    def each_record(self) -> Iterator[ClipRecord]:
        """Yield all clips, sorted by name, with only one in memory at a time."""
        with _sqlite_errors(self.folder / FILE):
            for row in self._connection.execute(_RECORDS + "ORDER BY c.name"):
                yield _record(row)

    def glances(self) -> list[ClipGlance]:
        """Return the main data of all clips, sorted by name, without parsing the results."""
        with _sqlite_errors(self.folder / FILE):
            rows = self._connection.execute(_GLANCES).fetchall()
            names = ClipGlance.__dataclass_fields__
            return [ClipGlance(**_columns(names, row)) for row in rows]

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Return the processing parameters as JSON data, keyed by their hash (mark)."""
        with _sqlite_errors(self.folder / FILE):
            rows = self._connection.execute("SELECT mark, document FROM parameters").fetchall()
            return {column("mark", mark): parameters_of(_text(document)) for mark, document in rows}

    def uncorrected(self) -> Iterator[tuple[str, str, list[str]]]:
        """Yield (source, name, problems) of every clip that has uncorrected intervals."""
        with _sqlite_errors(self.folder / FILE):
            for source, name, document in self._connection.execute(_UNCORRECTED):
                clip = _columns(("source", "name"), (source, name))
                sentences = result_of(_text(document))["uncorrected"]
                yield clip["source"], clip["name"], sentences

    def record(self, source: str) -> ClipRecord:
        """Return the record of a source. Raises TwistError if there is none."""
        with _sqlite_errors(self.folder / FILE):
            query = _RECORDS + "WHERE c.source = ?"
            row = self._connection.execute(query, (escaped(source),)).fetchone()
            if row is not None:
                return _record(row)
        raise TwistError(f"{legible(source)} is not a clip of {self.folder}")

    def note_decisions(self, source: str, decisions: Mapping[str, Any]) -> None:
        """Store the progress of a clip's review, replacing the previous progress.

        An empty mapping removes it.

        `decisions` has the keys accepted, rejected, undecided (numbers), reviewers (names), session
        (path) and at (ISO 8601). Raises TwistError if the folder has no such clip.
        """
        self.record(source)
        with self.transaction():
            if decisions:
                self._connection.execute(
                    "INSERT OR REPLACE INTO decisions VALUES (?, ?)",
                    (escaped(source), json_text(dict(decisions), indent=None)),
                )
            else:
                key = (escaped(source),)
                self._connection.execute("DELETE FROM decisions WHERE source = ?", key)

    # -- for a run ----------------------------------------------------------------------------

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """Commit everything that is written within the block, or nothing if the block fails."""
        with _sqlite_errors(self.folder / FILE):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._connection.execute("COMMIT")
            except BaseException:
                if self._connection.in_transaction:  # a full disk may have ended it already
                    self._connection.execute("ROLLBACK")
                raise

    def rows(self) -> dict[str, ManifestRow]:
        """Return all rows, keyed by source."""
        with _sqlite_errors(self.folder / FILE):
            query = f"SELECT {', '.join(_COLUMNS)} FROM clips"
            rows = [_row(row) for row in self._connection.execute(query)]
        return {row.source: row for row in rows}

    def sizes(self, mark: str) -> frozenset[int]:
        """Return the sizes in bytes of all files that have a result with these parameters."""
        with _sqlite_errors(self.folder / FILE):
            query = "SELECT DISTINCT bytes FROM results WHERE mark = ?"
            return frozenset(row[0] for row in self._connection.execute(query, (escaped(mark),)))

    def has_result(self, sha256: str, mark: str) -> bool:
        """Return True if a file with these bytes has a result with these parameters."""
        with _sqlite_errors(self.folder / FILE):
            query = "SELECT 1 FROM results WHERE sha256 = ? AND mark = ?"
            return (
                self._connection.execute(query, (escaped(sha256), escaped(mark))).fetchone()
                is not None
            )

    def put_parameters(self, parameters: Parameters) -> None:
        """Store processing parameters, keyed by their hash (mark)."""
        document = json_text(parameters.to_json(), indent=None)
        self._connection.execute(
            "INSERT OR IGNORE INTO parameters VALUES (?, ?, ?)",
            (parameters.mark, document, __version__),
        )

    def put_rows(self, rows: Iterable[ManifestRow]) -> None:
        """Store the rows of clips. Call this within a transaction."""
        self._connection.executemany(_PUT, (_values(row) for row in rows))

    def put_result(self, row: ManifestRow, result: Mapping[str, Any]) -> None:
        """Store a clip's result, keyed by the clip's hash and the parameters.

        Call this within a transaction.
        """
        self._connection.execute(
            "INSERT OR REPLACE INTO results VALUES (?, ?, ?, ?)",
            (row.sha256, row.mark, row.bytes, json_text(dict(result), indent=None)),
        )

    def take_over(self, other: Manifest) -> None:
        """Copy the parameters, results and decisions of another manifest, without the clips.

        Of two decisions on the same clip, the later is kept. Call this within a transaction.
        """
        with _sqlite_errors(other.folder / FILE):
            for table, checks in STORED.items():
                query = f"SELECT {', '.join(checks)} FROM {table}"
                for row in other._connection.execute(query):
                    for (name, check), value in zip(checks.items(), row, strict=True):
                        check(value, name)
                    self._connection.execute(_TAKE[table], row)

    def _make(self) -> None:
        if self._connection.execute("PRAGMA user_version").fetchone()[0]:
            return
        with self.transaction():  # if it is killed before the end, the file stays empty
            make_tables(self._connection)
            self._connection.execute(f"PRAGMA application_id = {_OURS}")
            self._connection.execute(f"PRAGMA user_version = {_SCHEMA}")


def now() -> str:
    """Return the current time as a manifest stores it: ISO 8601 in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


@contextmanager
def _sqlite_errors(file: Path) -> Iterator[None]:
    """Convert SQLite's errors to TwistErrors whose message is a sentence."""
    try:
        with saying(file):
            yield
    except sqlite3.OperationalError as error:
        raise TwistError(f"{file} cannot be read or written ({shown_words(error)})") from None
    except UnicodeDecodeError:  # SQLite quotes the damaged text in its message
        raise FormatError(
            f"{file}: expected a manifest written by twistcore batch in UTF-8"
        ) from None
    except sqlite3.DatabaseError as error:
        why = shown_words(error)
        raise FormatError(
            f"{file}: expected a manifest written by twistcore batch ({why})"
        ) from None


def _columns(names: Iterable[str], values: Iterable[Any]) -> dict[str, Any]:
    """Return the checked values of the columns, keyed by column name."""
    checked = {name: column(name, value) for name, value in zip(names, values, strict=True)}
    return {k: unescaped(v) if isinstance(v, str) else v for k, v in checked.items()}


def _text(value: Any) -> str:
    return text(value, "a document")


def _values(row: ManifestRow) -> tuple[Any, ...]:
    return tuple(
        escaped(value) if isinstance(value, str) else value
        for value in (getattr(row, column) for column in _COLUMNS)
    )


def _row(values: tuple[Any, ...]) -> ManifestRow:
    columns = _columns(_COLUMNS, values)
    return ManifestRow(**{**columns, "again": bool(columns["again"])})


def _record(row: tuple[Any, ...]) -> ClipRecord:
    """Build a record from a row of _RECORDS."""
    columns = _columns(_OF_RECORD, (row[k] for k in (*range(9), 12)))
    parameters, version, result, decisions = row[9], row[10], row[11], row[13]
    document = None if result is None else result_of(_text(result))
    if document is not None:
        document = {"schema": document.pop("schema"), "clip": columns["name"]} | document
    return ClipRecord(
        **columns,
        parameters={} if parameters is None else parameters_of(_text(parameters)),
        version="" if version is None else column("version", version),
        result=document,
        decisions={} if decisions is None else decisions_of_clip(_text(decisions)),
    )
