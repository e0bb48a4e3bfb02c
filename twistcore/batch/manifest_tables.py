"""The tables of a manifest: create them, check their definitions, and check their rows.

Each row has a check number, the CRC-32 of its values, because SQLite does not notice when a disk or
a copy changes a byte of a value. Manifests of the first schema have no check numbers.
"""

from __future__ import annotations

import sqlite3
import zlib
from collections.abc import Iterable, Mapping
from contextlib import closing
from functools import cache
from typing import Any

from twistcore.errors import FormatError

SCHEMA = 2  # `user_version` of the file

# A result belongs to file content and parameters, so clips with equal content share it.
_TABLES = """
CREATE TABLE parameters (mark TEXT PRIMARY KEY, document TEXT NOT NULL, version TEXT NOT NULL);
CREATE TABLE results (
    sha256 TEXT NOT NULL, mark TEXT NOT NULL, bytes INTEGER NOT NULL, document TEXT NOT NULL,
    PRIMARY KEY (sha256, mark)) WITHOUT ROWID;
CREATE INDEX results_by_size ON results (bytes);
CREATE TABLE clips (
    source TEXT PRIMARY KEY, name TEXT NOT NULL UNIQUE, state TEXT NOT NULL, reason TEXT NOT NULL,
    again INTEGER NOT NULL, mark TEXT NOT NULL, sha256 TEXT NOT NULL, bytes INTEGER NOT NULL,
    signature TEXT NOT NULL, seconds REAL NOT NULL, peak_bytes INTEGER NOT NULL,
    finished_at TEXT NOT NULL, corrected TEXT NOT NULL, corrected_sha256 TEXT NOT NULL,
    corrected_signature TEXT NOT NULL);
CREATE TABLE decisions (source TEXT PRIMARY KEY, document TEXT NOT NULL);
"""

COLUMNS: Mapping[str, tuple[str, ...]] = {
    "parameters": ("mark", "document", "version"),
    "results": ("sha256", "mark", "bytes", "document"),
    "clips": (
        *("source", "name", "state", "reason", "again", "mark", "sha256", "bytes", "signature"),
        *("seconds", "peak_bytes", "finished_at"),
        *("corrected", "corrected_sha256", "corrected_signature"),
    ),
    "decisions": ("source", "document"),
}

_Shape = tuple[tuple[str, ...], ...]


def make_tables(connection: sqlite3.Connection, schema: int = SCHEMA) -> None:
    """Create the tables in an empty file, within a transaction."""
    for statement in _TABLES.split(";\n"):
        connection.execute(statement)
    if schema > 1:
        add_checks(connection)


def add_checks(connection: sqlite3.Connection) -> None:
    """Add check numbers to the tables of the first schema; the existing rows have none."""
    for table in COLUMNS:
        connection.execute(f"ALTER TABLE {table} ADD COLUMN crc INTEGER")


def table_definitions(connection: sqlite3.Connection) -> _Shape:
    """Return the SQL definitions of all tables, indices, views and triggers in a file."""
    query = "SELECT type, name, tbl_name, sql FROM sqlite_master ORDER BY type, name"
    return tuple(connection.execute(query).fetchall())


@cache
def expected_definitions(schema: int = SCHEMA) -> _Shape:
    """Return the definitions of the tables that a manifest must have.

    A file with any other table, column, view or trigger is refused, since it could be malicious.
    """
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        make_tables(connection, schema)
        return table_definitions(connection)


def columns_of(table: str, alias: str, schema: int) -> str:
    """Return the columns of a table for a query, with the check number last (NULL if none)."""
    crc = f"{alias}.crc" if schema > 1 else "NULL"
    return ", ".join((*(f"{alias}.{name}" for name in COLUMNS[table]), crc))


def put_statement(table: str, schema: int, conflict: str) -> str:
    """Return the statement that stores a row, given as :func:`with_check` returns it."""
    names = (*COLUMNS[table], "crc") if schema > 1 else COLUMNS[table]
    places = ", ".join("?" * len(names))
    keep = ", ".join(f"{name} = excluded.{name}" for name in names)
    conflict = conflict.format(update=f"UPDATE SET {keep}")
    return f"INSERT INTO {table} ({', '.join(names)}) VALUES ({places}) ON CONFLICT {conflict}"


def with_check(values: Iterable[Any], schema: int) -> tuple[Any, ...]:
    """Return the values of a row with their check number, if the schema has one."""
    values = tuple(values)
    return (*values, _crc(values)) if schema > 1 else values


def checked(table: str, values: tuple[Any, ...]) -> tuple[Any, ...] | None:
    """Return the values of a row without their check number, or None if there is no such row.

    Raises FormatError if they have changed since they were stored.
    """
    *kept, crc = values
    if kept[0] is None and crc is None:
        return None
    if crc is not None and crc != _crc(kept):
        raise FormatError(f"a row of the table {table} has been damaged")
    return tuple(kept)


def _crc(values: Iterable[Any]) -> int:
    """Return the CRC-32 of values, in which 1, 1.0 and True are the same."""
    plain = [v if isinstance(v, str | bytes) or v is None else float(v) for v in values]
    return zlib.crc32(repr(plain).encode("utf-8", "surrogatepass"))
