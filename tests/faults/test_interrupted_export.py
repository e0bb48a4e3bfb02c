"""An export that was killed halfway is recognised by `apply` and by the window."""

import os
import shutil
import subprocess
import sys

import pytest

from tests.twistcore.batch_folders import KILL, ROOT, environment
from tests.twistcore.reviews import CLIP, fresh
from twistcore.cli.command_line import main
from twistcore.review import write_session
from twistcore.review.interrupted_export import (
    interrupted_export_sentence,
    interrupted_exports,
    mark_export_in_progress,
    was_export_interrupted,
)

KILLED = """
import os, sys
from pathlib import Path
from twistcore.review.interrupted_export import mark_export_in_progress
with mark_export_in_progress(Path(sys.argv[1]), Path(sys.argv[2])):
    print("begun", flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def exported(tmp_path):
    """A clip, and the session of its export, next to one another."""
    clip = tmp_path / "walk_injected.bvh"
    shutil.copy(ROOT / "assets" / clip.name, clip)
    session = tmp_path / "walk_refined.replay.json"
    write_session(CLIP, fresh().state, session)
    return clip, session


def begin(session, clip):
    words = [sys.executable, "-c", KILLED, str(session), str(clip)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    process = subprocess.Popen(words, env=environment(), **pipes)
    assert process.stdout.readline() == b"begun\n"
    return process


@pytest.mark.skipif(os.name != "posix", reason="Windows has no lasting names of open files")
@pytest.mark.parametrize("name", ["walk_refined.replay.json", "x" * 240 + ".replay.json"])
def test_a_killed_export_is_recognised_until_the_next_one(name, tmp_path, exported):
    clip, session = exported[0], tmp_path / name
    with begin(session, clip) as process:
        assert not was_export_interrupted(session), "it is under way"
        assert not interrupted_exports(clip)
        os.kill(process.pid, KILL)
    assert was_export_interrupted(session)
    assert name in interrupted_export_sentence(session)
    assert interrupted_exports(clip) == [name]
    assert not interrupted_exports(tmp_path / "other.bvh")
    with mark_export_in_progress(session, clip):
        assert not was_export_interrupted(session)
    assert not interrupted_exports(clip)
    assert not interrupted_export_sentence(session)
    assert not [path for path in tmp_path.iterdir() if path.name.startswith(".")]


def test_an_export_that_fails_leaves_no_mark(exported, tmp_path):
    clip, session = exported
    with pytest.raises(OSError, match="full"), mark_export_in_progress(session, clip):
        raise OSError("full")
    with mark_export_in_progress(tmp_path / "nowhere" / "a.replay.json", clip):
        pass
    assert not interrupted_exports(clip)
    assert {path.name for path in tmp_path.iterdir()} == {clip.name, session.name}


def test_apply_says_that_the_clip_next_to_its_session_may_be_newer(exported, tmp_path, capsys):
    clip, session = exported
    out = tmp_path / "again.bvh"
    assert main(["apply", str(session), str(clip), "-o", str(out)]) == 0
    assert "interrupted" not in capsys.readouterr().err
    with begin(session, clip) as process:
        os.kill(process.pid, KILL)
    assert main(["apply", str(session), str(clip), "-o", str(out)]) == 0
    err = capsys.readouterr().err
    assert f"{session}: the last export was interrupted" in err


@pytest.mark.parametrize(
    "data", [b"", b"[]", b"{}", b"\xff", b"[" * 9000, b"x" * 20_000, b'{"clip": 1}']
)
def test_other_files_by_the_name_of_a_mark_are_nothing(data, exported, tmp_path):
    clip, _ = exported
    (tmp_path / ".a.replay.json.twist.part.export").write_bytes(data)
    (tmp_path / ".b.export").mkdir()
    assert not interrupted_exports(clip)


def test_every_interrupted_export_of_a_clip_is_listed(exported, tmp_path):
    """Marks that no program holds, as if it had been killed."""
    clip, _ = exported
    for name in ("a", "b"):
        with mark_export_in_progress(tmp_path / f"{name}.replay.json", clip):
            (mark,) = tmp_path.glob(".*.export")
            left = mark.read_bytes()
        mark.write_bytes(left)
        shutil.move(mark, tmp_path / f"kept-{name}")
    for name in ("a", "b"):
        shutil.move(tmp_path / f"kept-{name}", tmp_path / f".{name}.replay.json.twist.part.export")
    assert interrupted_exports(clip) == ["a.replay.json", "b.replay.json"]
