"""`twistcore watch`: clips that arrive are read when whole, and each trouble costs one line."""

import os
import shutil
import signal
import subprocess
import time
from functools import partial
from types import SimpleNamespace

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.batch_folders import COMMAND, clips, environment
from tests.twistcore.test_batch_run import counted
from tests.twistcore.test_cli import run
from twistcore.batch.inputs import Source
from twistcore.batch.manifest import Manifest
from twistcore.batch.run import LOCK
from twistcore.cli import watch_command
from twistcore.cli.watch_command import compare_watched_clips
from twistcore.files.lock import lock_file
from twistcore.report import folder_report
from twistcore.report.picture_job import Drawn

DIRTY = ASSETS / "walk_injected.bvh"


@pytest.fixture
def watched(tmp_path, monkeypatch, capsys):
    """Runs a watch in which each pause is one of the given steps, and Ctrl+C ends the last one."""
    folder, out, counts = tmp_path / "in", tmp_path / "out", []
    clock = [0.0]
    folder.mkdir()
    monkeypatch.setattr(
        "twistcore.cli.batch_command._in_processes", lambda tasks, s, **_: counted(counts)(tasks, s)
    )

    def watch(*steps, words=(), pause=5.0):
        clock[0], left = 0.0, list(steps)

        def sleep(seconds):
            assert seconds in (0.0, pause)
            clock[0] += seconds
            if seconds and not left:
                raise KeyboardInterrupt
            if seconds:
                left.pop(0)()

        faked = SimpleNamespace(sleep=sleep, monotonic=lambda: clock[0])
        monkeypatch.setattr(watch_command, "time", faked)
        code, printed, err = run(capsys, "watch", folder, "-o", out, *words)
        assert "Traceback" not in err
        return (
            code,
            printed.splitlines(),
            [line for line in err.splitlines() if "clips/s" not in line],
        )

    return SimpleNamespace(watch=watch, folder=folder, out=out, counts=counts,
                           seconds=lambda: clock[0])  # fmt: skip


def nothing():
    pass


def states(out):
    with Manifest.open(out) as manifest:
        return {record.name: record.state for record in manifest.records()}


def source(path, signature):
    return Source(f"/in/{path}", path, 1, signature)


def test_a_look_compares_with_the_one_before_and_with_what_is_done():
    known, changed, new = source("a", "1"), source("b", "2"), source("c", "3")
    before = {"/in/a": "1", "/in/b": "1", "/in/c": "3", "/in/d": "4"}
    done = {"/in/a": known, "/in/b": source("b", "1"), "/in/d": source("d", "4")}
    look = compare_watched_clips([known, changed, new], before, done)
    assert (look.still, look.growing) == ((known, new), (changed,))
    assert [one.path for one in look.gone] == ["/in/d"]
    assert look.news
    assert not compare_watched_clips([known, changed], before, done).news  # still growing
    assert compare_watched_clips([changed], {"/in/b": "2"}, done).news


def test_a_clip_is_read_once_it_no_longer_grows(watched):
    whole, path = DIRTY.read_bytes(), watched.folder / "new.bvh"
    grow = [partial(path.write_bytes, whole[:size]) for size in (10, 100_000, len(whole))]
    code, printed, err = watched.watch(nothing, *grow, nothing, nothing, nothing)
    assert (code, watched.counts, len(printed)) == (0, ["new.bvh"], 1)
    assert len(err) == 1  # what is watched
    with Manifest.open(watched.out) as manifest:
        [record] = manifest.records()
    assert (record.state, record.bytes) == ("done", len(whole))


def test_results_follow_what_arrives_changes_and_goes(watched, tmp_path):
    made, table = clips(tmp_path / "later", DIRTY, 3), tmp_path / "table.csv"
    shutil.copy(made[0], watched.folder)
    rows = []

    def see():
        rows.append([line.split(",")[0] for line in table.read_text("utf-8").splitlines()[1:]])

    code, *_, err = watched.watch(
        nothing,
        lambda: (see(), shutil.copy(made[1], watched.folder)),
        nothing,
        lambda: (see(), shutil.copy(made[2], watched.folder / "clip_00.bvh")),
        nothing,
        lambda: (see(), (watched.folder / "clip_01.bvh").unlink()),
        nothing,
        see,
        words=("--csv", table, "--fail-if", "count>0"),
    )
    assert code == 1
    assert rows == [["clip_00.bvh"], *[["clip_00.bvh", "clip_01.bvh"]] * 2, ["clip_00.bvh"]]
    assert watched.counts == ["clip_00.bvh", "clip_01.bvh", "clip_00.bvh"]
    assert set(states(watched.out)) == {"clip_00.bvh", "clip_01.bvh"}  # nothing is lost
    gone = [line for line in err if "removed" in line]
    assert len(gone) == 1
    assert names_in_one_line(gone[0], "1 clip", "clip_01.bvh")
    broken = [line for line in err if "'count>0'" in line]
    assert len(broken) == len(set(broken)) >= 2  # said once, not after each arrival


def test_each_bad_clip_is_one_line_and_the_others_are_done(watched):
    short = DIRTY.read_bytes()[:60_000]

    def arrive():
        (watched.folder / "cut.bvh").write_bytes(short)
        (watched.folder / "broken.bvh").write_text("HIERARCHY\nROOT")
        (watched.folder / "astray.bvh").symlink_to("nowhere")
        (watched.folder / "x\x1b[31m.bvh").write_text("no clip")

    more = partial(shutil.copy, DIRTY, watched.folder / "good.bvh")
    repaired = partial(shutil.copy, DIRTY, watched.folder / "broken.bvh")
    code, _, err = watched.watch(arrive, nothing, more, nothing, repaired, nothing, nothing)
    assert code == 1
    found = states(watched.out)
    assert {name for name, state in found.items() if state == "done"} >= {"good.bvh", "broken.bvh"}
    for name in ("cut.bvh", "broken.bvh", "astray.bvh", "x\\x1b[31m.bvh"):
        assert len([line for line in err if name in line]) == 1, (name, err)


def test_a_share_that_comes_back_is_no_harm(watched, tmp_path):
    shutil.copy(DIRTY, watched.folder / "a.bvh")
    away = partial(os.rename, watched.folder, tmp_path / "away")
    back = partial(os.rename, tmp_path / "away", watched.folder)
    code, printed, err = watched.watch(nothing, away, nothing, nothing, back, nothing, nothing)
    assert (code, len(printed), watched.counts) == (0, 1, ["a.bvh"])
    assert len(err) == 2
    assert names_in_one_line(err[1], watched.folder)


def test_while_another_run_writes_it_waits(watched):
    handle = []

    def begin():
        handle.append(os.open(watched.out / LOCK, os.O_RDWR))
        assert lock_file(handle[0])
        shutil.copy(ASSETS / "walk.bvh", watched.folder)

    shutil.copy(DIRTY, watched.folder)

    def end():
        os.close(handle[0])

    code, printed, err = watched.watch(nothing, begin, nothing, nothing, end, nothing)
    assert (code, len(printed)) == (0, 2)
    assert len([line for line in err if "another run" in line]) == 1
    assert set(states(watched.out).values()) == {"done"}


def test_once_ends_after_what_is_there_and_lists_what_grows(watched):
    path = watched.folder / "grows.bvh"
    shutil.copy(DIRTY, watched.folder / "a.bvh")
    path.write_text("HIER")
    code, printed, err = watched.watch(partial(path.write_text, "HIERA"), words=("--once",))
    assert (code, len(printed), states(watched.out)) == (1, 1, {"a.bvh": "done"})
    assert names_in_one_line(err[-1], "grows.bvh")
    path.unlink()
    assert watched.watch(nothing, words=("--once",))[0] == 0
    assert watched.counts == ["a.bvh"]
    (watched.folder / "a.bvh").unlink()
    assert watched.watch(nothing, words=("--once",))[0] == 0  # an empty folder is no fault


def test_idle_ends_when_nothing_comes(watched):
    arrive = partial(shutil.copy, DIRTY, watched.folder)
    words = ("--idle", "12", "--every", "4")
    steps = [*[nothing] * 2, arrive, *[nothing] * 9]
    code, printed, _ = watched.watch(*steps, words=words, pause=4.0)
    assert (code, len(printed)) == (0, 1)
    assert watched.seconds() == 4.0 * (2 + 1 + 1) + 12.0  # arrives, is still, and is the last


def test_a_report_keeps_the_pages_of_other_clips(watched, tmp_path, monkeypatch):
    monkeypatch.setattr(
        folder_report, "draw_figures", lambda figures, *_: [Drawn({}, "not now")] * len(figures)
    )
    made = clips(tmp_path / "later", DIRTY, 2, 60)
    shutil.copy(made[0], watched.folder)
    pages = watched.out / "report" / "clips"
    seen = []

    def arrive():
        seen.append((pages / "clip_00.bvh.html").stat().st_ino)
        shutil.copy(made[1], watched.folder)

    watched.watch(nothing, arrive, nothing, words=("--report", "--workers", "1"))
    assert seen == [(pages / "clip_00.bvh.html").stat().st_ino]
    index = (watched.out / "report" / "index.html").read_text("utf-8")
    assert all(f"clips/clip_0{k}.bvh.html" in index for k in (0, 1))
    assert (pages / "clip_01.bvh.html").exists()


def test_what_cannot_be_watched_is_refused(capsys, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "manifest.sqlite").write_text("somebody's")
    (tmp_path / "in").mkdir()
    words = ["watch", tmp_path / "in", "-o", tmp_path / "out", "--once", "--every", "0.01"]
    for wrong, fact in (
        (["watch", tmp_path / "none", "-o", tmp_path / "o"], "none"),
        (["watch", tmp_path / "in", "-o", tmp_path / "in"], tmp_path / "in"),
        (words, "manifest.sqlite"),
        ([*words, "--fail-if", "severity"], "'severity'"),
        ([*words, "--every", "0"], "'0'"),
    ):
        code, out, err = run(capsys, *wrong)
        assert (code, out) == (2, "")
        assert names_in_one_line(err.splitlines()[-1], fact)


@pytest.mark.skipif(os.name != "posix", reason="no such signals")
def test_a_signal_ends_it_with_all_results(tmp_path):
    clips(tmp_path / "in", DIRTY, 2, 60)
    words = [*COMMAND[:-1], "watch", str(tmp_path / "in"), "-o", str(tmp_path / "out")]
    words += [
        "--every",
        "0.1",
        "--idle",
        "20",
        "--csv",
        str(tmp_path / "table.csv"),
        "--workers",
        "1",
    ]
    with subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment(PYTHONUNBUFFERED=""),
    ) as process:
        assert "2 clips done" in process.stdout.readline()  # printed at once, also into a pipe
        time.sleep(0.3)
        assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 0
    assert "Traceback" not in err
    assert states(tmp_path / "out") == {"clip_00.bvh": "done", "clip_01.bvh": "done"}
    assert len((tmp_path / "table.csv").read_text("utf-8").splitlines()) == 3


def test_one_that_is_stopped_within_a_clip_is_continued(watched, monkeypatch):
    shutil.copy(DIRTY, watched.folder / "a.bvh")

    def stopped(tasks, seconds, **_):
        raise KeyboardInterrupt
        yield

    with monkeypatch.context() as patch:
        patch.setattr("twistcore.cli.batch_command._in_processes", stopped)
        code, _, err = watched.watch(nothing, nothing)
    assert code == 130
    assert any("1 clip" in line for line in err)
    assert watched.watch(nothing, nothing)[0] == 0
    assert states(watched.out) == {"a.bvh": "done"}
