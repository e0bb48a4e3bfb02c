"""A manifest damaged at any place: refused in one sentence, or every value is as it was."""

import random
import sqlite3
from contextlib import closing

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.tiers import examples
from tests.twistcore.batch_folders import clips
from tests.twistcore.test_batch_run import results, run
from twistcore.batch.manifest import FILE, Manifest
from twistcore.batch.manifest_tables import COLUMNS, expected_table_definitions
from twistcore.errors import TwistError
from twistcore.files.version import __version__

PLACES = examples(200)
DIRTY = ASSETS / "walk_injected.bvh"


def made(folder):
    """A manifest of a few clips, of which one has failed, one is not done and one is reviewed."""
    source = folder / "in"
    paths = clips(source, DIRTY, 4, frames=100)
    paths[3].write_text("no clip")
    run(source, folder / "out")
    (source / "new.bvh").write_bytes(DIRTY.read_bytes())
    run(source, folder / "out", lambda _tasks, _seconds: iter(()))
    with Manifest.open(folder / "out") as manifest:
        manifest.note_decisions(str(paths[0]), {"accepted": 2, "at": "2026-01-01T00:00:00+00:00"})
    return folder / "out" / FILE


def read(folder):
    """All that a program can read of a manifest."""
    with Manifest.open(folder) as manifest:
        rows = manifest.rows()
        records = manifest.records()
        known = [manifest.has_result(row.sha256, row.mark) for row in rows.values()]
        return rows, manifest.glances(), manifest.parameters(), records, known


def flipped(data, rng):
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]


def cut(data, rng):
    return data[: rng.randrange(len(data))]


def overwritten(data, rng):
    """A sector of a disk that holds something else."""
    at = rng.randrange(0, len(data), 512)
    other = rng.choice((bytes(512), rng.randbytes(512), data[:512]))
    return data[:at] + other + data[at + 512 :]


@pytest.mark.parametrize("damage", [flipped, cut, overwritten])
def test_a_damaged_manifest_is_refused_or_says_what_it_said(damage, tmp_path):
    data = made(tmp_path).read_bytes()
    truth, refused = read(tmp_path / "out"), 0
    for place in range(PLACES):
        folder = tmp_path / str(place)
        folder.mkdir()
        (folder / FILE).write_bytes(damage(data, random.Random(f"{damage.__name__} {place}")))
        try:
            found, said = read(folder), ""
        except TwistError as error:
            found, said = truth, str(error)
            refused += 1
        assert found == truth, place
        assert not said or names_in_one_line(said, folder)
    assert refused


def test_a_result_that_is_missing_is_told(tmp_path):
    with closing(sqlite3.connect(made(tmp_path), isolation_level=None)) as connection:
        connection.execute("DELETE FROM results")
    with pytest.raises(TwistError, match=r"the result of 'clip_00\.bvh' is missing"):
        read(tmp_path / "out")


def test_a_clip_that_was_not_processed_has_no_version_and_no_parameters(tmp_path):
    made(tmp_path)
    records = {record.name: record for record in read(tmp_path / "out")[3]}
    assert {name: record.state for name, record in records.items()} == {
        **{f"clip_0{k}.bvh": "done" for k in range(3)},
        "clip_03.bvh": "failed",
        "new.bvh": "waiting",
    }
    for record in records.values():
        processed = record.state != "waiting"
        assert record.version == (__version__ if processed else "")
        assert bool(record.parameters) == bool(record.finished_at) == processed
        assert (record.result is not None) == (record.state == "done")


def test_a_manifest_that_another_program_locks_is_refused_with_the_reason(tmp_path, monkeypatch):
    monkeypatch.setattr("twistcore.batch.manifest._BUSY_S", 0.0)
    with closing(sqlite3.connect(made(tmp_path), isolation_level=None)) as connection:
        connection.execute("BEGIN EXCLUSIVE")
        with pytest.raises(TwistError, match=rf"{FILE} .*locked"):
            read(tmp_path / "out")
    assert read(tmp_path / "out")


def test_manifests_of_the_first_schema_are_read_and_continued(tmp_path):
    file = made(tmp_path)
    before = read(tmp_path / "out")
    with closing(sqlite3.connect(file, isolation_level=None)) as connection:
        for table in COLUMNS:
            connection.execute(f"ALTER TABLE {table} DROP COLUMN crc")
        connection.execute("PRAGMA user_version = 1")
    assert expected_table_definitions(1) != expected_table_definitions()
    old = file.read_bytes()
    assert read(tmp_path / "out") == before
    assert file.read_bytes() == old
    with Manifest.open(tmp_path / "out") as manifest:
        manifest.note_decisions(next(iter(before[0])), {"accepted": 1})
    assert run(tmp_path / "in", tmp_path / "out").known == 3
    assert results(tmp_path / "out").keys() == {row.name for row in before[0].values()}
    with closing(sqlite3.connect(file)) as connection:
        assert connection.execute("PRAGMA user_version").fetchone() == (2,)
