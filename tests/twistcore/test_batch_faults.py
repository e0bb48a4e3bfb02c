"""A batch of real processes: they are killed, the disk is full, and all that can be is done."""

import contextlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.conftest import ASSETS
from tests.processes import children_of, is_alive, until
from tests.twistcore.batch_folders import COMMAND, KILL, ROOT, clips, environment
from tests.twistcore.test_batch_run import results
from twistcore.batch.clip_task import ClipTask, run_task
from twistcore.batch.inputs import find_input_clips
from twistcore.batch.manifest import Manifest
from twistcore.batch.parameters import Parameters
from twistcore.batch.run import run_batch
from twistcore.errors import TwistError
from twistcore.work.processes import map_in_processes

pytestmark = [
    pytest.mark.thorough,
    pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="Linux"),
]

DIRTY = ASSETS / "walk_injected.bvh"
SLOW_RUN = (
    "import sys; from tests.twistcore.batch_folders import run_slowly; run_slowly(*sys.argv[1:])"
)


def rows(out):
    """What a manifest has, as far as it can be read by now."""
    with contextlib.suppress(TwistError), Manifest.open(out) as manifest:
        return manifest.rows()
    return {}


def done(out):
    return {row.source: row for row in rows(out).values() if row.state == "done"}


def started(*words):
    return subprocess.Popen([sys.executable, *map(str, words)], cwd=ROOT, env=environment())


def command(*words):
    ran = [*COMMAND, *map(str, words)]
    return subprocess.run(ran, cwd=ROOT, env=environment(), capture_output=True, text=True)


def finished(folder, out):
    """Run what is left here; the summary."""
    sources = find_input_clips([str(folder)]).sources
    return run_batch(
        out, sources, Parameters(refine=True), lambda tasks, _: map_in_processes(run_task, tasks, 1)
    )


def test_a_worker_that_is_killed_costs_nothing(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    clips(folder, DIRTY, 6, 40)
    run = started("-c", SLOW_RUN, folder, out)
    until(lambda: done(out))
    os.kill(min(children_of(run.pid)), KILL)
    assert run.wait(60) == 0
    assert len(done(out)) == 6


def test_a_run_that_is_killed_goes_on_and_does_nothing_twice(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    clips(folder, DIRTY, 8, 40)
    run = started("-c", SLOW_RUN, folder, out)
    until(lambda: len(done(out)) >= 2)
    workers = children_of(run.pid)
    assert len(workers) == 2
    run.send_signal(KILL)
    run.wait(60)
    until(lambda: not any(map(is_alive, workers)))  # none stays behind
    before = done(out)
    assert 2 <= len(before) < 8
    summary = finished(folder, out)
    assert (summary.known, summary.done) == (len(before), 8 - len(before))
    after = done(out)
    assert {source: after[source] for source in before} == before  # to the second, and what it took
    corrected = sorted(p.name for p in (out / "corrected").iterdir())
    assert corrected == sorted(p.name for p in folder.iterdir())


@pytest.fixture(
    params=[pytest.param("a small disk", marks=pytest.mark.thorough), "a limit of files"]
)
def full(request, tmp_path):
    """A folder in which 300 kB have room, and what a process that writes there is started with."""
    out = tmp_path / "out"
    out.mkdir()
    if request.param == "a limit of files":  # kB; no file of the run may be larger
        yield out, ("bash", "-c", 'ulimit -f 60; exec "$@"', "bash")
        return
    words = ["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(out)]
    if not shutil.which("mount") or subprocess.run(words, capture_output=True).returncode:
        pytest.skip("needs leave to mount")
    try:
        yield out, ()
    finally:
        subprocess.run(["umount", str(out)], check=True)


def test_a_full_disk_is_told_and_a_later_run_goes_on(full, tmp_path):
    out, before = full
    folder = tmp_path / "in"
    clips(folder, DIRTY, 5, 40)  # some 40 kB
    shutil.copy(ASSETS / "dance.bvh", folder)
    clips(tmp_path / "large", DIRTY, 2, 344)
    for path in (tmp_path / "large").iterdir():
        path.rename(folder / f"large_{path.name}")
    words = [*before, *COMMAND, str(folder), "-o", str(out / "o"), "--refine", "--workers", "1"]
    ran = subprocess.run(words, cwd=ROOT, env=environment(), capture_output=True, text=True)
    assert ran.returncode == 1, ran.stderr
    failed = [row.reason for row in rows(out / "o").values() if row.state == "failed"]
    assert failed
    assert "Traceback" not in ran.stderr
    for line in failed:
        assert line in ran.stderr
        assert "cannot be" in line
    good = done(out / "o")
    moved = tmp_path / "moved"
    shutil.copytree(out / "o", moved)  # to where there is room
    summary = finished(folder, moved)
    assert summary.done >= len(failed)
    assert len(done(moved)) == 8
    assert all(done(moved)[source].sha256 == row.sha256 for source, row in good.items())


def test_equal_results_of_one_process_two_and_a_cluster(tmp_path):
    folder = tmp_path / "in"
    clips(folder, DIRTY, 4, 150)
    found = []
    for words in (["--workers", "1"], ["--workers", "2"], ["--local-cluster", "2"]):
        out = tmp_path / words[0] / words[1]
        ran = command(folder, "-o", out, "--refine", *words)
        assert ran.returncode == 0, ran.stderr
        found.append(results(out))
    assert found[0] == found[1] == found[2]
    assert len(found[0]) == 4


@pytest.fixture
def scheduler(tmp_path):
    """A Dask scheduler with a worker: its process and its address."""
    listing = tmp_path / "scheduler.json"
    own = ("--scheduler-file", listing, "--no-dashboard")
    here = ("--host", "127.0.0.1")
    first = started("-m", "distributed.cli.dask_scheduler", "--port", "0", *here, *own)
    until(listing.exists)
    worker = started(
        "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny",
        "--death-timeout", "30", "--local-directory", tmp_path, *own,
    )  # fmt: skip
    address = until(lambda: json.loads(listing.read_text() or "{}").get("address"))
    yield first, address
    for one in (worker, first):
        one.kill()
        one.wait()


def test_a_scheduler_that_is_killed_ends_the_run_and_another_goes_on(scheduler, tmp_path):
    first, address = scheduler
    folder, out = tmp_path / "in", tmp_path / "out"
    made = clips(folder, DIRTY, 12, 344)
    run = subprocess.Popen(
        [*COMMAND, str(folder), "-o", str(out), "--refine", "--scheduler", address],
        cwd=ROOT, env=environment(), stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    until(lambda: done(out))
    first.kill()
    _, err = run.communicate(timeout=60)
    assert run.returncode == 1, err
    assert "Dask" in err
    assert "Traceback" not in err
    before = done(out)
    summary = finished(folder, out)
    assert (summary.known, summary.done) == (len(before), len(made) - len(before))
    assert summary.done > 0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has such a limit")
def test_who_carries_a_task_out_is_left_without_a_limit():
    import resource

    before = resource.getrlimit(resource.RLIMIT_AS)
    assert run_task(ClipTask("nowhere.bvh", "nowhere.bvh", 0, Parameters())).reason
    assert resource.getrlimit(resource.RLIMIT_AS) == before
