"""Create the tables of a manifest, and check the tables of an existing file."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from functools import cache

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

_Shape = tuple[tuple[str, ...], ...]


def make_tables(connection: sqlite3.Connection) -> None:
    """Create the tables in an empty file. Must be called within a transaction."""
    for statement in _TABLES.split(";\n"):
        connection.execute(statement)


def table_definitions(connection: sqlite3.Connection) -> _Shape:
    """Return the SQL definitions of all tables, indices, views and triggers in a file."""
    query = "SELECT type, name, tbl_name, sql FROM sqlite_master ORDER BY type, name"
    return tuple(connection.execute(query).fetchall())


@cache
def expected_definitions() -> _Shape:
    """Return the SQL definitions that a manifest must have.

    A file with any other table, column, view or trigger is refused, since it could be malicious.
    """
    with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
        make_tables(connection)
        return table_definitions(connection)
