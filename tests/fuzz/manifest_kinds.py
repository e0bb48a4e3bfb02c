"""Manifests of a batch, damaged: other values, other tables, other bytes."""

from __future__ import annotations

import json
import random
import sqlite3
import tempfile
from contextlib import closing, suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from inspector.folder.batch_folder import BatchFolder, _options_text
from tests.fuzz.json_damage import TEXTS, damage_bytes, damaged_json
from tests.fuzz.review_kinds import ASSETS
from tests.fuzz.trial import Kind
from twistcore.batch.clip_result import process_clip
from twistcore.batch.gates import broken_rules, parse_batch_rule
from twistcore.batch.junit import junit_xml
from twistcore.batch.manifest import DONE, FAILED, FILE, Manifest, ManifestRow
from twistcore.batch.manifest_tables import COLUMNS
from twistcore.batch.parameters import Parameters
from twistcore.batch.result_files import clips_csv, interval_rows, json_line
from twistcore.report.folder_numbers import FolderNumbers, worst_first
from twistcore.report.folder_page import clip_page_from_manifest, folder_page_html
from twistcore.report.folder_report import _home, clip_page_path

_RULES = [
    parse_batch_rule(rule)
    for rule in (
        "count[limb-flip]>0",
        "total.affected>2%",
        "severity>1",
        "degrees[confidence>=0.8]>9",
        "total.severity>0",
    )
]


@cache
def _manifest() -> bytes:
    with tempfile.TemporaryDirectory() as folder, Manifest.open(folder, create=True) as manifest:
        usual = Parameters()
        other = Parameters(
            tau_deg=5.0, kinds=("limb flip",), profile_rad={"LeftArm": 0.1}, refine=True
        )
        rows = []
        with manifest.transaction():
            for k, (name, parameters) in enumerate(
                (("walk_injected", usual), ("kick", usual), ("walk", other))
            ):
                path = ASSETS / f"{name}.bvh"
                clip, result, _ = process_clip(path, parameters)
                manifest.put_parameters(parameters)
                row = ManifestRow(
                    str(path), f"takes/{path.name}", DONE, mark=parameters.mark,
                    sha256=clip.sha256, bytes=len(clip.data), seconds=0.1 * k, peak_bytes=10**8,
                    finished_at="2026-01-01T00:00:00+00:00",
                )  # fmt: skip
                manifest.put_result(row, result)
                rows.append(row)
            rows.append(replace(rows[0], source="/a/b.bvh", name="b.bvh", state=FAILED, reason="x"))
            rows.append(ManifestRow("s3://bucket/c.bvh", "c.bvh"))
            manifest.put_rows(rows)
        manifest.note_decisions(
            rows[0].source,
            {"accepted": 3, "rejected": 1, "undecided": 4, "reviewers": ["Kim"],
             "session": "/a/walk.twist.json", "at": "2026-01-01T00:00:00+00:00"},
        )  # fmt: skip
        return (Path(folder) / FILE).read_bytes()


_CELLS = (
    ("clips", "source"), ("clips", "name"), ("clips", "state"), ("clips", "reason"),
    ("clips", "again"), ("clips", "mark"), ("clips", "sha256"), ("clips", "bytes"),
    ("clips", "signature"), ("clips", "seconds"), ("clips", "peak_bytes"), ("clips", "finished_at"),
    ("clips", "corrected"), ("parameters", "version"), ("parameters", "mark"), ("results", "bytes"),
)  # fmt: skip
_DOCUMENTS = ("parameters", "results", "results", "results", "decisions")
_VALUES: tuple[Any, ...] = (
    None, 0, -1, 1.5, 2**63 - 1, -(2**63), 1e308, float("inf"), b"\xff\xfe", b"", b"\0" * 1000, "",
    "done", "failed", "waiting", "../../x", "/", ".", "..", "a\0b", "x" * 100_000, "://",
    "1", "true",
    "/etc/passwd", "\\udc80", "x/" * 2000, "C:\\x", *TEXTS,
)  # fmt: skip
_STATEMENTS = (
    "DROP TABLE {t}", "ALTER TABLE {t} RENAME TO other", "ALTER TABLE {t} ADD COLUMN extra",
    "DELETE FROM {t}", "PRAGMA user_version = 3", "PRAGMA user_version = 1",
    "PRAGMA application_id = 0",
    "PRAGMA user_version = 0", "CREATE TABLE extra (x)",
    "ALTER TABLE clips RENAME COLUMN name TO n",
    "ALTER TABLE clips RENAME TO old; CREATE VIEW clips AS SELECT * FROM old",
    "ALTER TABLE clips RENAME TO old; CREATE VIEW clips AS WITH RECURSIVE c(source) AS "
    "(VALUES('a') UNION ALL SELECT source || 'a' FROM c) SELECT source, source AS name, "
    "'done' AS state, '' AS reason, 0 AS again, '' AS mark, '' AS sha256, 0 AS bytes, "
    "'' AS signature, 0.0 AS seconds, 0 AS peak_bytes, '' AS finished_at, '' AS corrected, "
    "'' AS corrected_sha256, '' AS corrected_signature FROM c",
    "CREATE TRIGGER t AFTER INSERT ON decisions BEGIN DELETE FROM clips; END",
    "PRAGMA encoding = 'UTF-16'", "UPDATE clips SET name = name || source",
    "PRAGMA writable_schema = 1; UPDATE sqlite_master SET sql = 'CREATE TABLE clips (x)' "
    "WHERE name = 'clips'",
    "PRAGMA writable_schema = 1; UPDATE sqlite_master SET rootpage = 9999 WHERE name = 'clips'",
    "PRAGMA writable_schema = 1; UPDATE sqlite_master SET sql = CAST(x'ff' AS TEXT)",
    "INSERT INTO decisions VALUES ('nobody', 'x', NULL)", "PRAGMA journal_mode = WAL",
)  # fmt: skip


def _make(rng: random.Random) -> dict[str, bytes]:
    data = _manifest()
    what = rng.random()
    if what < 0.8:
        with closing(sqlite3.connect(":memory:", isolation_level=None)) as connection:
            connection.text_factory = bytes
            connection.deserialize(data)
            for _ in range(rng.choice((1, 1, 2))):
                try:
                    _damage(connection, rng)
                except (sqlite3.Error, IndexError, OverflowError, UnicodeError, ValueError):
                    continue  # what SQLite itself does not take
            if rng.random() < 0.9:  # a made file: no check number says that it was changed
                for table in COLUMNS:
                    with suppress(sqlite3.Error):
                        connection.execute(f"UPDATE {table} SET crc = NULL")
            data = connection.serialize()
    if 0.75 < what < 0.99:
        data = damage_bytes(data, rng)
    return {FILE: data}


def _damage(connection: sqlite3.Connection, rng: random.Random) -> None:
    what = rng.random()
    if what < 0.35:
        table, name = rng.choice(_CELLS)
        where = rng.choice(("", " WHERE state = 'done'")) if table == "clips" else ""
        value = rng.choice(_VALUES)
        connection.execute(f"UPDATE OR IGNORE {table} SET {name} = ?{where}", (value,))
    elif what < 0.88:
        table = rng.choice(_DOCUMENTS)
        rows = connection.execute(f"SELECT document FROM {table}").fetchall()
        old = bytes(rng.choice(rows)[0])
        try:
            new = damaged_json(json.loads(old), rng)
        except (ValueError, RecursionError):  # damaged already
            new = damage_bytes(old, rng)
        value = new if rng.random() < 0.05 else new.decode("utf-8", "replace")
        connection.execute(
            f"UPDATE {table} SET document = ? WHERE document = ?", (value, old.decode())
        )
    else:
        table = rng.choice(("clips", "parameters", "results", "decisions"))
        connection.executescript(rng.choice(_STATEMENTS).format(t=table))


def _read(folder: Path) -> object:
    """As the window lists it, and as the commands and the report tell of it."""
    batch = BatchFolder(folder, None)
    batch.clips()
    for path in list(batch._glances):
        batch.profile_of(path)
    with Manifest.open(folder) as manifest:
        for row in manifest.rows().values():
            manifest.has_result(row.sha256, row.mark)
        manifest.sizes("a")
        list(manifest.uncorrected())
        words = [_options_text(told) for told in manifest.parameters().values()]
        records = manifest.records()
        for record in records:
            manifest.record(record.source)
            manifest.note_decisions(record.source, dict(record.decisions))
    numbers = FolderNumbers()
    rows = worst_first([numbers.add(record) for record in records])
    broken = broken_rules(_RULES, records)
    folder_page_html("x", rows, numbers, broken)
    junit_xml(records, _RULES, broken)
    clips_csv(records)
    for record in records:
        clip_page_from_manifest(record, "", _home(record, "home"))
        json_line(record)
        list(interval_rows(record))
        assert (
            (folder / clip_page_path(record.name))
            .resolve()
            .is_relative_to((folder / "clips").resolve())
        )
    return words


KINDS = (Kind("manifest", _make, _read),)
