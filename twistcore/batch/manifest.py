"""Store the state of every clip of a batch in its manifest, an SQLite file in the batch folder.

One process writes the results, clip by clip. Other processes may read the manifest and add
decisions. If the writing process is killed or the disk is full, all earlier entries stay intact.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

from twistcore.batch.manifest_tables import (
    COLUMNS,
    SCHEMA,
    add_checksum_columns,
    append_check_number,
    create_manifest_tables,
    expected_table_definitions,
    manifest_table_definitions,
    sql_column_list,
    sql_store_row_statement,
    verify_row_checksum,
)
from twistcore.batch.parameters import Parameters
from twistcore.batch.stored_rows import (
    STORED,
    check_column_value,
    parse_stored_decisions,
    parse_stored_parameters,
    parse_stored_result,
)
from twistcore.errors import FormatError, TwistError
from twistcore.files.document_values import (
    check_string,
    format_value_for_message,
    prefix_format_errors,
    shorten_foreign_message,
)
from twistcore.files.encoding import (
    escape_control_characters,
    escape_invalid_utf8,
    json_text,
    unescape_invalid_utf8,
)
from twistcore.files.ordinary import check_no_links
from twistcore.files.version import __version__
from twistcore.work.frozen import dataclass

FILE = "manifest.sqlite"
DONE, FAILED, WAITING = "done", "failed", "waiting"

_COMPANIONS = ("-journal", "-wal", "-shm")  # files that SQLite puts next to it
_OURS = 0x54774261  # 'TwBa': in the file's header, where it can be read without SQLite
_MAGIC, _SCHEMA_AT, _OURS_AT = b"SQLite format 3\0", 60, 68
_BUSY_S = 10.0  # waiting time while another process writes


@dataclass(frozen=True)
class ClipRecord:
    """Everything that a batch folder stores about a clip.

    Parameters
    ----------
    source
        Absolute path or URL.
    name
        A unique path relative to the input folder, with '/'.
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
    """A summary of a :class:`ClipRecord`, which is quicker to read for many clips.

    All fields that are not listed below are the same as in :class:`ClipRecord` or in its result.

    Parameters
    ----------
    mark
        A hash that identifies the processing parameters.
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
    """A clip's row in the manifest, as a batch run reads and writes it.

    All fields that are not listed below are the same as in :class:`ClipRecord`.

    Parameters
    ----------
    again
        True if a failed clip should be processed again.
    mark
        A hash that identifies the processing parameters.
    signature
        The file's signature, or '' if only the file's bytes can show whether it has changed.
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


# Numbers of rows in each of SQLite's trees: damage may make one of them shorter.
_COUNTS = (
    "(SELECT count(*) FROM clips NOT INDEXED)",
    "(SELECT count(*) FROM clips INDEXED BY sqlite_autoindex_clips_1)",
    "(SELECT count(*) FROM clips INDEXED BY sqlite_autoindex_clips_2)",
)
_FROM = (
    "FROM clips c LEFT JOIN parameters p ON p.mark = c.mark "
    "LEFT JOIN results r ON r.sha256 = c.sha256 AND r.mark = c.mark AND c.state = 'done' "
    "LEFT JOIN decisions d ON d.source = c.source"
)
_JOINED = {"c": "clips", "p": "parameters", "r": "results", "d": "decisions"}
_OF_RECORD = (
    *("source", "name", "state", "reason", "sha256", "bytes", "seconds", "peak_bytes"),
    *("finished_at", "corrected"),
)
_OF_GLANCE = "source", "name", "state", "reason", "mark", "sha256", "signature"
_MORE_OF_GLANCE = {
    "severity": "coalesce(json_extract(r.document, '$.severity'), 0.0)",
    "intervals": "coalesce(json_array_length(r.document, '$.intervals'), 0)",
    "unchecked": "coalesce(json_extract(r.document, '$.unchecked'), '')",
    "missing_frames": "coalesce(json_extract(r.document, '$.missing_frames'), 0)",
    "unexamined": "coalesce(json_array_length(r.document, '$.unexamined'), 0)",
}
_UNCORRECTED = "coalesce(json_array_length(r.document, '$.uncorrected'), 0)"
_LATER = " WHERE json_extract(excluded.document, '$.at') > json_extract(document, '$.at')"


@dataclass(frozen=True)
class _Found:
    """The checked rows of one clip in all tables of a manifest, each row keyed by column name.

    `more` contains the values of the additional SQL expressions in the query.
    """

    clip: Mapping[str, Any]
    parameters: Mapping[str, Any] | None
    result: Mapping[str, Any] | None
    decisions: Mapping[str, Any] | None
    more: tuple[Any, ...]


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
    return head.startswith(_MAGIC) and ours == _OURS and 1 <= schema <= SCHEMA


class Manifest:
    """The manifest of a batch folder.

    Use it as a context manager to close the file. The methods raise TwistError if the file is
    damaged or cannot be written.
    """

    def __init__(self, folder: Path, connection: sqlite3.Connection) -> None:
        self.folder = folder
        self._connection = connection
        self._schema = SCHEMA

    @classmethod
    def open(cls, folder: Path | str, *, create: bool = False) -> Self:
        """Open the manifest of a folder.

        If there is no manifest, it is created if `create` is True. Raises TwistError if the
        manifest is missing or damaged, or if it was written by a different program.
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
            self._schema = self._connection.execute("PRAGMA user_version").fetchone()[0]
            if manifest_table_definitions(self._connection) != expected_table_definitions(
                self._schema
            ):
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

    # -- reading ------------------------------------------------------------------------------

    def records(self) -> list[ClipRecord]:
        """Return the records of all clips, sorted by name."""
        return list(self.each_record())

    def each_record(self) -> Iterator[ClipRecord]:
        """Yield the records of all clips, sorted by name. Only one is in memory at a time."""
        with _sqlite_errors(self.folder / FILE):
            for found in self._each_found():
                yield _record(found)

    def glances(self) -> list[ClipGlance]:
        """Return a summary of each clip, sorted by name, without parsing the results."""
        with _sqlite_errors(self.folder / FILE):
            return [
                ClipGlance(
                    **_columns({key: found.clip[key] for key in _OF_GLANCE}),
                    **_columns(dict(zip(_MORE_OF_GLANCE, found.more, strict=True))),
                )
                for found in self._each_found(*_MORE_OF_GLANCE.values())
            ]

    def _each_found(self, *more: str, source: str | None = None) -> Iterator[_Found]:
        """Yield the rows of all clips, sorted by name, or only the rows of the clip `source`.

        `more` are additional SQL expressions to query. Raises FormatError if a row is missing or
        damaged.
        """
        columns = [sql_column_list(table, alias, self._schema) for alias, table in _JOINED.items()]
        counts = (*_COUNTS, "(SELECT count(*) FROM decisions)")
        query = f"SELECT {', '.join((*columns, *counts, *more))} {_FROM} "
        query += "ORDER BY c.name" if source is None else "WHERE c.source = ?"
        number, decided, wanted = 0, 0, (0, 0, 0, 0)
        for row in self._connection.execute(
            query, () if source is None else (escape_invalid_utf8(source),)
        ):
            parts, rest = [], row
            for table in _JOINED.values():
                size = len(COLUMNS[table]) + 1
                values = verify_row_checksum(table, rest[:size])
                parts.append(dict(zip(COLUMNS[table], values, strict=True)) if values else None)
                rest = rest[size:]
            wanted = rest[: len(counts)]
            clip, parameters, result, decisions = parts
            if clip is None or (clip["mark"] and not parameters):
                raise FormatError("rows are missing from the table 'clips' or 'parameters'")
            if clip["state"] == DONE and not result:
                raise FormatError(
                    f"the result of {format_value_for_message(clip['name'])} is missing"
                )
            number, decided = number + 1, decided + (decisions is not None)
            yield _Found(clip, parameters, result, decisions, rest[len(counts) :])
        if source is None and (number, number, number, decided) != wanted:
            raise FormatError("rows are missing from the table 'clips' or 'decisions'")

    def parameters(self) -> dict[str, dict[str, Any]]:
        """Return all processing parameters in use as JSON data, keyed by their hash (mark)."""
        with _sqlite_errors(self.folder / FILE):
            found = {}
            for mark, document, _ in self._each_row("parameters"):
                found[check_column_value("mark", mark)] = parse_stored_parameters(_text(document))
            return found

    def uncorrected(self) -> Iterator[tuple[str, str, list[str]]]:
        """Yield the source, the name and the problems of each clip that was not fully corrected."""
        with _sqlite_errors(self.folder / FILE):
            for found in self._each_found(_UNCORRECTED):
                if found.result and found.more[0]:
                    clip = _columns({key: found.clip[key] for key in ("source", "name")})
                    sentences = parse_stored_result(_text(found.result["document"]))["uncorrected"]
                    yield clip["source"], clip["name"], sentences

    def record(self, source: str) -> ClipRecord:
        """Return the record of the clip with this path or URL.

        Raises TwistError if there is no such clip.
        """
        with _sqlite_errors(self.folder / FILE):
            for found in self._each_found(source=source):
                return _record(found)
        raise TwistError(f"{escape_control_characters(source)} is not a clip in {self.folder}")

    def note_decisions(self, source: str, decisions: Mapping[str, Any]) -> None:
        """Store the progress of a clip's review in place of the previous progress.

        Parameters
        ----------
        source
            The clip's path or URL.
        decisions
            The keys accepted, rejected and undecided (numbers), reviewers (names), session (path)
            and at (ISO 8601). An empty mapping removes the stored progress.

        Raises
        ------
        TwistError
            If the folder has no such clip.
        """
        self.record(source)
        with self.transaction():
            if decisions:
                values = escape_invalid_utf8(source), json_text(dict(decisions), indent=None)
                self._put("decisions", values, "(source) DO {update}")
            else:
                key = (escape_invalid_utf8(source),)
                self._connection.execute("DELETE FROM decisions WHERE source = ?", key)

    # -- writing ------------------------------------------------------------------------------

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
        """Return the rows of all clips, keyed by source (path or URL)."""
        with _sqlite_errors(self.folder / FILE):
            columns = ", ".join((sql_column_list("clips", "c", self._schema), *_COUNTS))
            found = self._connection.execute(
                f"SELECT {columns} FROM clips c NOT INDEXED"
            ).fetchall()
            if found and {*found[0][-len(_COUNTS) :]} != {len(found)}:
                raise FormatError("rows are missing from the table 'clips'")
            rows = [_row(row[: -len(_COUNTS)]) for row in found]
        return {row.source: row for row in rows}

    def sizes(self, mark: str) -> frozenset[int]:
        """Return the sizes in bytes of all files that have a result with the given parameters.

        `mark` is the hash of the parameters.
        """
        with _sqlite_errors(self.folder / FILE):
            query = "SELECT DISTINCT bytes FROM results WHERE mark = ?"
            return frozenset(
                row[0] for row in self._connection.execute(query, (escape_invalid_utf8(mark),))
            )

    def has_result(self, sha256: str, mark: str) -> bool:
        """Return True if a file with the given hash has a result with the given parameters.

        `mark` is the hash of the parameters.
        """
        with _sqlite_errors(self.folder / FILE):
            where = (
                "t.sha256 = ? AND t.mark = ?",
                escape_invalid_utf8(sha256),
                escape_invalid_utf8(mark),
            )
            return any(True for _ in self._each_row("results", *where))

    def put_parameters(self, parameters: Parameters) -> None:
        """Store processing parameters, keyed by their hash (mark)."""
        document = json_text(parameters.to_json(), indent=None)
        self._put("parameters", (parameters.mark, document, __version__), "DO NOTHING")

    def put_rows(self, rows: Iterable[ManifestRow]) -> None:
        """Store the rows of clips. Call this within a transaction."""
        statement = sql_store_row_statement("clips", self._schema, "(source) DO {update}")
        self._connection.executemany(
            statement, (append_check_number(_values(row), self._schema) for row in rows)
        )

    def put_result(self, row: ManifestRow, result: Mapping[str, Any]) -> None:
        """Store a clip's result, keyed by the hashes of the clip and of the parameters.

        Must be called within a transaction.
        """
        values = row.sha256, row.mark, row.bytes, json_text(dict(result), indent=None)
        self._put("results", values, "(sha256, mark) DO {update}")

    def take_over(self, other: Manifest) -> None:
        """Copy the parameters, results and decisions of another manifest, but not its clips.

        If both manifests have decisions on a clip, the later ones are used. Call this within a
        transaction.
        """
        for table, checks in STORED.items():
            conflict = "(source) DO {update}" + _LATER if table == "decisions" else "DO NOTHING"
            try:
                with _sqlite_errors(other.folder / FILE):
                    for row in other._each_row(table):
                        for (name, check), value in zip(checks.items(), row, strict=True):
                            check(value, name)
                        self._put(table, row, conflict)
            except FormatError as error:  # the error names the other file, not this one
                raise TwistError(str(error)) from None

    def _each_row(self, table: str, where: str = "1", *words: str) -> Iterator[tuple[Any, ...]]:
        """Yield the checked rows of a table.

        `where` is an SQL condition in which the table is called t, and `words` are the values of
        its placeholders.
        """
        columns = sql_column_list(table, "t", self._schema)
        query = f"SELECT {columns} FROM {table} t WHERE {where}"
        for row in self._connection.execute(query, words):
            yield _row_of(table, row)

    def _put(self, table: str, values: Iterable[Any], conflict: str) -> None:
        statement = sql_store_row_statement(table, self._schema, conflict)
        self._connection.execute(statement, append_check_number(values, self._schema))

    def _make(self) -> None:
        known = self._connection.execute("PRAGMA user_version").fetchone()[0]
        if known == SCHEMA:
            return
        with self.transaction():  # if the process is killed, the file stays unchanged
            if known:
                add_checksum_columns(self._connection)
            else:
                create_manifest_tables(self._connection)
            self._connection.execute(f"PRAGMA application_id = {_OURS}")
            self._connection.execute(f"PRAGMA user_version = {SCHEMA}")


def manifest_timestamp() -> str:
    """Return the current time as stored in a manifest: ISO 8601 in UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


@contextmanager
def _sqlite_errors(file: Path) -> Iterator[None]:
    """Convert SQLite errors to TwistErrors that name the file."""
    try:
        with prefix_format_errors(file):
            yield
    except sqlite3.OperationalError as error:
        raise TwistError(
            f"{file} cannot be read or written ({shorten_foreign_message(error)})"
        ) from None
    except UnicodeDecodeError:  # SQLite quotes the damaged text in its message
        raise FormatError(
            f"{file}: expected a manifest written by twistcore batch in UTF-8"
        ) from None
    except sqlite3.DatabaseError as error:
        why = shorten_foreign_message(error)
        raise FormatError(
            f"{file}: expected a manifest written by twistcore batch ({why})"
        ) from None


def _columns(values: Mapping[str, Any]) -> dict[str, Any]:
    """Check the values of columns, keyed by name, and return them. Raises FormatError."""
    checked_ones = {name: check_column_value(name, value) for name, value in values.items()}
    return {
        k: unescape_invalid_utf8(v) if isinstance(v, str) else v for k, v in checked_ones.items()
    }


def _text(value: Any) -> str:
    return check_string(value, "a document")


def _values(row: ManifestRow) -> tuple[Any, ...]:
    return tuple(
        escape_invalid_utf8(value) if isinstance(value, str) else value
        for value in (getattr(row, column) for column in COLUMNS["clips"])
    )


def _row_of(table: str, row: tuple[Any, ...]) -> tuple[Any, ...]:
    values = verify_row_checksum(table, row)
    if values is None:
        raise FormatError(f"a row of the table {table!r} has no key")
    return values


def _row(row: tuple[Any, ...]) -> ManifestRow:
    columns = _columns(dict(zip(COLUMNS["clips"], _row_of("clips", row), strict=True)))
    return ManifestRow(**{**columns, "again": bool(columns["again"])})


def _record(found: _Found) -> ClipRecord:
    columns = _columns({key: found.clip[key] for key in _OF_RECORD})
    parameters, result, decisions = found.parameters, found.result, found.decisions
    document = parse_stored_result(_text(result["document"])) if result else None
    if document is not None:
        document = {"schema": document.pop("schema"), "clip": columns["name"]} | document
    return ClipRecord(
        **columns,
        parameters=parse_stored_parameters(_text(parameters["document"])) if parameters else {},
        version=check_column_value("version", parameters["version"]) if parameters else "",
        result=document,
        decisions=parse_stored_decisions(_text(decisions["document"])) if decisions else {},
    )
