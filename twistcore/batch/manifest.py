"""The manifest of a batch folder: what became of every clip, in one SQLite file.

One process writes it, a clip's outcome at a time; others may read, and note decisions. A process
that is killed, or a full disk, leaves what was noted before.
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
from twistcore.batch.stored_rows import column, decisions_of_clip, parameters_of, result_of
from twistcore.errors import FormatError, TwistError
from twistcore.files.document_values import saying, shown_words, text
from twistcore.files.encoding import escaped, json_text, legible, unescaped
from twistcore.files.version import __version__
from twistcore.work.frozen import dataclass

FILE = "manifest.sqlite"
DONE, FAILED, WAITING = "done", "failed", "waiting"

_SCHEMA = 1
_OURS = 0x54774261  # 'TwBa': SQLite keeps it in the file's head, where it is read without SQLite
_MAGIC, _SCHEMA_AT, _OURS_AT = b"SQLite format 3\0", 60, 68
_BUSY_S = 10.0  # another process notes something, which takes no longer


@dataclass(frozen=True)
class ClipRecord:
    """A clip of a batch folder.

    source: absolute path or URL; name: below its input, with '/', unique; state: 'done', 'failed'
    or 'waiting'; reason: why it failed, one sentence, else ''; sha256, bytes: of the file; seconds,
    peak_bytes: what it took; finished_at: ISO 8601, UTC, or ''; parameters, version: it was
    processed with; result: 'twistcore.batch_clip/1', or None; corrected: path below the folder, or
    ''; decisions: of a review, as :meth:`Manifest.note_decisions` was given them, or {}.
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
    """The least of a clip that a list of many shows: see ClipRecord and its result.

    mark: of the parameters; signature: of the file as it was processed, '' where that could not be
    kept.
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
    """What a run needs to know of a clip, and notes of it: see ClipRecord.

    again: whether a failure may end otherwise; mark: of the parameters; signature: of the file,
    '' if it has to be read to be known; corrected_sha256, corrected_signature: of what was written.
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


def is_batch_folder(path: Path | str) -> bool:
    """Whether a folder has a manifest of ours; reads a hundred bytes at most."""
    try:
        if not (Path(path) / FILE).is_file():  # to open a FIFO would wait for its writer
            return False
        with (Path(path) / FILE).open("rb") as file:
            head = file.read(100)
    except OSError:
        return False
    ours = int.from_bytes(head[_OURS_AT : _OURS_AT + 4], "big")
    schema = int.from_bytes(head[_SCHEMA_AT : _SCHEMA_AT + 4], "big")
    return head.startswith(_MAGIC) and (ours, schema) == (_OURS, _SCHEMA)


class Manifest:
    """The manifest of a folder; a context manager that closes it.

    Methods raise TwistError where the file is damaged or cannot be written.
    """

    def __init__(self, folder: Path, connection: sqlite3.Connection) -> None:
        self.folder = folder
        self._connection = connection

    @classmethod
    def open(cls, folder: Path | str, *, create: bool = False) -> Self:
        """That of a folder; `create`: made where there is none. TwistError without one."""
        folder = Path(folder)
        file = folder / FILE
        if not file.exists() or (create and file.stat().st_size == 0):
            if not create:
                raise TwistError(f"{folder}: expected a folder that twistcore batch has written")
        elif not is_batch_folder(folder):
            raise FormatError(f"{file}: expected a manifest of twistcore batch")
        with _told(file):
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
        with _told(file):
            # No WAL: its shared memory does not work on network disks, where captures live.
            self._connection.execute("PRAGMA journal_mode = TRUNCATE").fetchone()
            if create:
                self._make()
            if shape_of(self._connection) != shape_of_ours():
                raise FormatError("expected a manifest of twistcore batch with its own tables")

    def __enter__(self) -> Self:
        """Itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Closed."""
        self.close()

    def close(self) -> None:
        """Let the file go."""
        self._connection.close()

    # -- what others read ---------------------------------------------------------------------

    def records(self) -> list[ClipRecord]:
        """All clips, by name."""
        return list(self.each_record())

    def each_record(self) -> Iterator[ClipRecord]:
        """All clips, by name, one at a time: of a million no one wants a list."""
        with _told(self.folder / FILE):
            for row in self._connection.execute(_RECORDS + "ORDER BY c.name"):
                yield _record(row)

    def glances(self) -> list[ClipGlance]:
        """All clips, by name, without their results being read: of many thousands in a moment."""
        with _told(self.folder / FILE):
            rows = self._connection.execute(_GLANCES).fetchall()
            names = ClipGlance.__dataclass_fields__
            return [ClipGlance(**_columns(names, row)) for row in rows]

    def parameters(self) -> dict[str, dict[str, Any]]:
        """What clips were processed with, JSON by mark."""
        with _told(self.folder / FILE):
            rows = self._connection.execute("SELECT mark, document FROM parameters").fetchall()
            return {column("mark", mark): parameters_of(_text(told)) for mark, told in rows}

    def uncorrected(self) -> Iterator[tuple[str, str, list[str]]]:
        """Of clips in which something could not be corrected: source, name and sentences."""
        with _told(self.folder / FILE):
            for source, name, document in self._connection.execute(_UNCORRECTED):
                told = _columns(("source", "name"), (source, name))
                sentences = result_of(_text(document))["uncorrected"]
                yield told["source"], told["name"], sentences

    def record(self, source: str) -> ClipRecord:
        """That of a source; TwistError where there is none."""
        with _told(self.folder / FILE):
            query = _RECORDS + "WHERE c.source = ?"
            row = self._connection.execute(query, (escaped(source),)).fetchone()
            if row is not None:
                return _record(row)
        raise TwistError(f"{legible(source)}: expected a clip of {self.folder}")

    def note_decisions(self, source: str, decisions: Mapping[str, Any]) -> None:
        """Keep how far a clip's review is, in place of what was noted before; {} forgets it.

        decisions: accepted, rejected, undecided (numbers), reviewers (names), session (path), at
        (ISO 8601). TwistError where the clip is none of these.
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

    # -- what a run reads and notes -----------------------------------------------------------

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """All that is noted inside, or nothing of it."""
        with _told(self.folder / FILE):
            self._connection.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._connection.execute("COMMIT")
            except BaseException:
                if self._connection.in_transaction:  # a full disk may have ended it already
                    self._connection.execute("ROLLBACK")
                raise

    def rows(self) -> dict[str, ManifestRow]:
        """All clips by source."""
        with _told(self.folder / FILE):
            query = f"SELECT {', '.join(_COLUMNS)} FROM clips"
            rows = [_row(row) for row in self._connection.execute(query)]
        return {row.source: row for row in rows}

    def sizes(self, mark: str) -> frozenset[int]:
        """Bytes of the files that have results with these parameters."""
        with _told(self.folder / FILE):
            query = "SELECT DISTINCT bytes FROM results WHERE mark = ?"
            return frozenset(row[0] for row in self._connection.execute(query, (escaped(mark),)))

    def has_result(self, sha256: str, mark: str) -> bool:
        """Whether bytes have a result with these parameters."""
        with _told(self.folder / FILE):
            query = "SELECT 1 FROM results WHERE sha256 = ? AND mark = ?"
            return (
                self._connection.execute(query, (escaped(sha256), escaped(mark))).fetchone()
                is not None
            )

    def put_parameters(self, parameters: Parameters) -> None:
        """Keep what a mark stands for."""
        document = json_text(parameters.to_json(), indent=None)
        self._connection.execute(
            "INSERT OR IGNORE INTO parameters VALUES (?, ?, ?)",
            (parameters.mark, document, __version__),
        )

    def put_rows(self, rows: Iterable[ManifestRow]) -> None:
        """Note what became of clips; inside a transaction."""
        self._connection.executemany(_PUT, (_values(row) for row in rows))

    def put_result(self, row: ManifestRow, result: Mapping[str, Any]) -> None:
        """Keep a clip's result under its bytes and parameters; inside a transaction."""
        self._connection.execute(
            "INSERT OR REPLACE INTO results VALUES (?, ?, ?, ?)",
            (row.sha256, row.mark, row.bytes, json_text(dict(result), indent=None)),
        )

    def _make(self) -> None:
        if self._connection.execute("PRAGMA user_version").fetchone()[0]:
            return
        with self.transaction():  # killed before its end, there is an empty file
            make_tables(self._connection)
            self._connection.execute(f"PRAGMA application_id = {_OURS}")
            self._connection.execute(f"PRAGMA user_version = {_SCHEMA}")


def now() -> str:
    """The time as a manifest has it: ISO 8601, UTC, to the second."""
    return datetime.now(UTC).isoformat(timespec="seconds")


@contextmanager
def _told(file: Path) -> Iterator[None]:
    """What SQLite raises, as a sentence."""
    try:
        with saying(file):
            yield
    except sqlite3.OperationalError as error:
        told = shown_words(error)
        raise TwistError(f"{file}: cannot be read or written ({told})") from None
    except UnicodeDecodeError:  # SQLite tells of damage in the damaged words
        raise FormatError(f"{file}: expected a manifest of twistcore batch in UTF-8") from None
    except sqlite3.DatabaseError as error:
        told = shown_words(error)
        raise FormatError(f"{file}: expected a manifest of twistcore batch ({told})") from None


def _columns(names: Iterable[str], values: Iterable[Any]) -> dict[str, Any]:
    """Values of columns by their names."""
    told = {name: column(name, value) for name, value in zip(names, values, strict=True)}
    return {k: unescaped(v) if isinstance(v, str) else v for k, v in told.items()}


def _text(value: Any) -> str:
    return text(value, "a document")


def _values(row: ManifestRow) -> tuple[Any, ...]:
    return tuple(
        escaped(value) if isinstance(value, str) else value
        for value in (getattr(row, column) for column in _COLUMNS)
    )


def _row(values: tuple[Any, ...]) -> ManifestRow:
    told = _columns(_COLUMNS, values)
    return ManifestRow(**{**told, "again": bool(told["again"])})


def _record(row: tuple[Any, ...]) -> ClipRecord:
    """A row of _RECORDS."""
    told = _columns(_OF_RECORD, (row[k] for k in (*range(9), 12)))
    parameters, version, result, decisions = row[9], row[10], row[11], row[13]
    document = None if result is None else result_of(_text(result))
    if document is not None:
        document = {"schema": document.pop("schema"), "clip": told["name"]} | document
    return ClipRecord(
        **told,
        parameters={} if parameters is None else parameters_of(_text(parameters)),
        version="" if version is None else column("version", version),
        result=document,
        decisions={} if decisions is None else decisions_of_clip(_text(decisions)),
    )
