"""Create the tables of a batch manifest, and check their definitions and their rows.

Each row has a check number, which is the CRC-32 of its values, because SQLite does not detect
values that were changed by a faulty disk or copy. Manifests of schema 1 have no check numbers.
"""

from __future__ import annotations

import sqlite3
import zlib
from collections.abc import Iterable, Mapping
from contextlib import closing
from functools import cache
from typing import Any

from twistcore.errors import FormatError

SCHEMA = 2  # version of the tables, stored as `user_version` in the SQLite file

# A result is stored for the hash of a file's content and the hash of the parameters (mark), so that
# files with the same content share it.
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


def create_manifest_tables(connection: sqlite3.Connection, schema: int = SCHEMA) -> None:
    """Create the tables of a schema version in an empty file. Call this within a transaction."""
    for statement in _TABLES.split(";\n"):
        connection.execute(statement)
    if schema > 1:
        add_checksum_columns(connection)


def add_checksum_columns(connection: sqlite3.Connection) -> None:
    """Add a column for check numbers to tables of schema 1.

    The column is NULL in the existing rows, which are therefore not checked.
    """
    for table in COLUMNS:
        connection.execute(f"ALTER TABLE {table} ADD COLUMN crc INTEGER")


def manifest_table_definitions(connection: sqlite3.Connection) -> _Shape:
    """Return the definitions of all tables, indices, views and triggers in a file.

    Each definition contains the type, the name, the name of the table, and the SQL text.
    """
    query = "SELECT type, name, tbl_name, sql FROM sqlite_master ORDER BY type, name"
    return tuple(connection.execute(query).fetchall())


@cache
def expected_table_definitions(schema: int = SCHEMA) -> _Shape:
    """Return the definitions that a manifest of a schema must have.

    A file with any other table, column, view or trigger is not opened, because it could be
    malicious.
    """
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        create_manifest_tables(connection, schema)
        return manifest_table_definitions(connection)


def sql_column_list(table: str, alias: str, schema: int) -> str:
    """Return the column list of a SELECT query for a table, as SQL text.

    The last column is the check number, or NULL if the schema has no check numbers.

    Parameters
    ----------
    table
        The name of the table.
    alias
        The name of the table in the query.
    schema
        The schema of the file.
    """
    crc = f"{alias}.crc" if schema > 1 else "NULL"
    return ", ".join((*(f"{alias}.{name}" for name in COLUMNS[table]), crc))


def sql_store_row_statement(table: str, schema: int, conflict: str) -> str:
    """Return the SQL statement that stores a row in a table.

    Execute the statement with the values from :func:`append_check_number`.

    Parameters
    ----------
    table
        The name of the table.
    schema
        The schema of the file.
    conflict
        SQL text after ON CONFLICT, in which '{update}' is replaced by an update of all columns.
    """
    names = (*COLUMNS[table], "crc") if schema > 1 else COLUMNS[table]
    places = ", ".join("?" * len(names))
    keep = ", ".join(f"{name} = excluded.{name}" for name in names)
    conflict = conflict.format(update=f"UPDATE SET {keep}")
    return f"INSERT INTO {table} ({', '.join(names)}) VALUES ({places}) ON CONFLICT {conflict}"


def append_check_number(values: Iterable[Any], schema: int) -> tuple[Any, ...]:
    """Return the values of a row and, if the schema has check numbers, their check number."""
    values = tuple(values)
    return (*values, _crc(values)) if schema > 1 else values


def verify_row_checksum(table: str, values: tuple[Any, ...]) -> tuple[Any, ...] | None:
    """Check the values of a row, and return the values without the check number.

    Parameters
    ----------
    table
        The name of the table, for the error message.
    values
        The values of the row, with the check number or None at the end.

    Returns
    -------
    tuple or None
        The values, or None if the first value and the check number are None, which means that the
        query found no row.

    Raises
    ------
    FormatError
        If the values have changed since they were stored.
    """
    *kept, crc = values
    if kept[0] is None and crc is None:
        return None
    if crc is not None and crc != _crc(kept):
        raise FormatError(f"a row of the table {table!r} is damaged")
    return tuple(kept)


def _crc(values: Iterable[Any]) -> int:
    """Return the CRC-32 of the values of a row. The values 1, 1.0 and True give the same CRC-32."""
    plain = [v if isinstance(v, str | bytes) or v is None else float(v) for v in values]
    return zlib.crc32(repr(plain).encode("utf-8", "surrogatepass"))
