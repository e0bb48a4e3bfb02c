"""What other programs rely on: exit codes, schemas and tables are those of the documentation."""

import csv
import re
import shutil
import signal
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.test_cli import run
from tests.twistcore.test_cli_words import COMMANDS
from tests.twistcore.test_formats import EXAMPLES, LINES, PAGE
from twistcore.batch.manifest import Manifest
from twistcore.cli import detect_commands

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
TABLE = (DOCS / "command-line.md").read_text("utf-8").partition("## Exit codes")[2]
CODES = {int(code) for code in re.findall(r"^\| (\d+) \|", TABLE, re.M)}
WALK, DIRTY, NONE = ASSETS / "walk.bvh", ASSETS / "walk_injected.bvh", "none.bvh"
ONE_WORKER = ("--workers", "1")
WATCH = ("watch", "in", "-o", "out", "--once", "--every", "0.05", *ONE_WORKER)
BATCH = ("batch", "in", "-o", "out", *ONE_WORKER)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (0, ("info", WALK)),
        (0, BATCH),
        (0, WATCH),
        (1, ("info", WALK, NONE)),
        (1, ("detect", DIRTY, "--chain", "LeftForeArm", "--fail-over", "0")),
        (1, (*BATCH, "--fail-if", "count>0")),
        (1, (*WATCH, "--fail-if", "count>0")),
        (2, ("info", NONE)),
        (2, (*BATCH, "--fail-if", "count")),
        (2, (*WATCH, "--fail-if", "count")),
        (2, ("watch", "none", "-o", "out")),
    ],
)
def test_a_command_ends_with_the_code_of_the_page(code, words, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    shutil.copy(DIRTY, tmp_path / "in")
    found, out, err = run(capsys, *words)
    assert found == code
    assert found in CODES
    assert bool(out + err) or not code
    assert not out or code != 2


@pytest.mark.parametrize("name", COMMANDS)
def test_wrong_usage_of_any_command_is_code_2(name, capsys):
    code, out, err = run(capsys, *name.split(), "--no-such-option")
    assert (code, out) == (2, "")
    assert names_in_one_line(err, name)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_command_that_is_stopped_ends_with_the_code_of_the_page(number, monkeypatch, capsys):
    monkeypatch.setattr(detect_commands, "info_command", lambda _: signal.raise_signal(number))
    code, *_ = run(capsys, "info", WALK)
    assert code == 128 + number
    assert code in CODES or str(code) in TABLE


def test_the_codes_of_the_page_are_all_there_are():
    assert sorted(CODES) == [0, 1, 2, 130]


def test_every_schema_of_the_code_is_on_the_page():
    files = [file for house in ("twistcore", "inspector") for file in (ROOT / house).rglob("*.py")]
    code = "\n".join(file.read_text("utf-8") for file in files)
    found = set(re.findall(r'"(twistcore\.[a-z_-]+/\d+)"', code))
    lines = set(re.findall(r'"(twistcore\.[a-z_-]+/\d+)"', "\n".join(LINES)))
    versions = {f"twistcore.session/{n}" for n in re.findall(r"\*\*\[?Version (\d)", PAGE)}
    elsewhere = {"twistcore.batch_clip/1", "twistcore.report_pictures/1"}  # batch.md; of no file
    assert len(found) > 25
    assert found - elsewhere <= set(EXAMPLES) | lines | versions


def test_the_manifest_has_the_tables_and_marks_of_the_page(tmp_path):
    with (DOCS / "tables" / "batch-manifest.csv").open(encoding="utf-8") as file:
        listed = {row["Table"].strip("`"): row["Columns"] for row in csv.DictReader(file)}
    Manifest.open(tmp_path, create=True).close()
    with closing(sqlite3.connect(tmp_path / "manifest.sqlite")) as connection:
        tables = [n for (n,) in connection.execute("SELECT name FROM pragma_table_list")]
        ours = {n for n in tables if not n.startswith("sqlite_")}
        assert ours == set(listed)
        for name in ours:
            columns = [n for _, n, *_ in connection.execute(f"PRAGMA table_info({name})")]
            named = re.findall(r"`(\w+)`", re.sub(r"\(.*?\)", "", listed[name]))
            assert named[: len(columns)] == columns, name
        marks = [connection.execute(f"PRAGMA {m}").fetchone()[0]
                 for m in ("application_id", "user_version")]  # fmt: skip
    assert f"(`application_id` {marks[0]:#x}, `user_version` {marks[1]})" in (
        DOCS / "batch.md"
    ).read_text("utf-8")
