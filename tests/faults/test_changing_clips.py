"""Clips that change while a batch reads them: each result belongs to bytes that existed."""

import hashlib
import itertools
import json
import random
import threading
import time

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.twistcore.batch_folders import clips
from twistcore.batch import clip_result
from twistcore.batch.clip_task import run_task
from twistcore.batch.inputs import find_input_clips
from twistcore.batch.manifest import DONE, Manifest
from twistcore.batch.parameters import Parameters
from twistcore.batch.run import run_batch
from twistcore.work.processes import map_in_processes

DIRTY = ASSETS / "walk_injected.bvh"
CLIPS = 4


def replaced(path, data):
    other = path.with_name(f".{path.name}")
    other.write_bytes(data)
    other.replace(path)


def rewritten(path, data):
    """In place: who reads it meanwhile may see a part of it."""
    path.write_bytes(data)


def removed(path, data):
    path.unlink(missing_ok=True)
    path.write_bytes(data)


def appended(path, data):
    at = len(data) - 400
    path.write_bytes(data[:at])
    with path.open("ab") as file:
        file.write(data[at:])


def in_two_processes(tasks, _seconds):
    return map_in_processes(run_task, tasks, 2)


def one_by_one(tasks, _seconds):
    return ((task, run_task(task)) for task in tasks)


def run(folder, out, carry_out=one_by_one):
    sources = find_input_clips([str(folder)]).sources
    return run_batch(out, sources, Parameters(refine=True), carry_out)


def rows_of(out):
    with Manifest.open(out) as manifest:
        return {row.name: row for row in manifest.rows().values()}


def results_of(out):
    """The result of every clip without its name, by the hash of its bytes."""
    with Manifest.open(out) as manifest:
        return {
            r.sha256: json.dumps({**r.result, "clip": ""}) for r in manifest.records() if r.result
        }


@pytest.mark.thorough
@pytest.mark.parametrize("change", [replaced, rewritten, removed, appended])
def test_a_result_is_that_of_the_bytes_that_it_names(change, tmp_path):
    folder, out, done = tmp_path / "in", tmp_path / "out", threading.Event()
    made = clips(folder, DIRTY, CLIPS, frames=60)
    versions = {path: [path.read_bytes()] for path in made}
    for path, other in zip(made, clips(tmp_path / "others", DIRTY, CLIPS, frames=50), strict=True):
        versions[path].append(other.read_bytes())

    def keep_changing():
        for k in itertools.count(1):
            for path in made:
                change(path, versions[path][k % 2])
            if done.wait(0.002):
                return

    thread = threading.Thread(target=keep_changing)
    thread.start()
    try:
        run(folder, out, in_two_processes)
    finally:
        done.set()
        thread.join()
    seen = results_of(out)
    for path in made:  # at rest
        replaced(path, versions[path][0])
    run(folder, out)
    rows = rows_of(out)
    for path in made:
        row = rows[path.name]
        assert row.state == DONE, row.reason
        assert row.sha256 == hashlib.sha256(versions[path][0]).hexdigest()
    known = {hashlib.sha256(v).hexdigest(): v for pair in versions.values() for v in pair}
    still = tmp_path / "still"
    still.mkdir()
    for mark, data in known.items():
        (still / f"{mark}.bvh").write_bytes(data)
    run(still, tmp_path / "truth")
    truth = results_of(tmp_path / "truth")
    whole = {mark: result for mark, result in seen.items() if mark in known}
    assert whole == {mark: truth[mark] for mark in whole}
    assert {k: v for k, v in results_of(out).items() if k in known}.items() <= truth.items()


def test_a_clip_that_vanishes_is_listed_and_tried_again(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    made = clips(folder, DIRTY, 4, frames=150)

    def carry_out(tasks, _seconds):
        made[2].rename(tmp_path / "away.bvh")
        return one_by_one(tasks, _seconds)

    sources = find_input_clips([str(folder)]).sources
    summary = run_batch(out, sources, Parameters(refine=True), carry_out)
    assert (summary.done, len(summary.failed)) == (3, 1)
    assert "does not exist" in summary.failed[0]
    (tmp_path / "away.bvh").rename(made[2])
    assert run(folder, out).done == 1


@pytest.mark.parametrize("rest", [b"", b"0 0 0"])
def test_a_clip_that_is_still_being_copied_is_tried_again(rest, tmp_path, monkeypatch):
    """When it is read it has no end; when its bytes are hashed it may be complete."""
    folder, out = tmp_path / "in", tmp_path / "out"
    [path] = clips(folder, DIRTY, 1, frames=60)
    whole = path.read_bytes()
    path.write_bytes(whole[:300] + rest)
    work = clip_result.process_clip

    def copied_meanwhile(*words):
        try:
            return work(*words)
        finally:
            path.write_bytes(whole)

    sources = find_input_clips([str(folder)]).sources
    monkeypatch.setattr(clip_result, "process_clip", copied_meanwhile)

    summary = run_batch(out, sources, Parameters(), one_by_one)
    assert (summary.done, len(summary.failed)) == (0, 1)
    monkeypatch.undo()
    sources = find_input_clips([str(folder)]).sources
    assert run_batch(out, sources, Parameters(), one_by_one).done == 1
    path.write_bytes(whole[:300] + rest)
    for _ in range(2):  # at rest, it is not tried again
        sources = find_input_clips([str(folder)]).sources
        assert run_batch(out, sources, Parameters(), one_by_one).unreadable == 1


def truncated(path, data):
    with path.open("r+b") as file:
        file.truncate(len(data) * (3 + len(path.name) % 5) // 9)


def deleted(path, data):
    path.unlink()


@pytest.mark.thorough
@pytest.mark.parametrize("change", [replaced, rewritten, truncated, deleted])
def test_clips_that_change_once_at_random_moments(change, tmp_path):
    """Each of 20 clips, some before, some while and some after it is read."""
    folder, out, rng = tmp_path / "in", tmp_path / "out", random.Random(change.__name__)
    made = clips(folder, DIRTY, 20, frames=60)
    others = clips(tmp_path / "others", DIRTY, 40, frames=50)[20:]
    versions = [path.read_bytes() for path in made]
    sources = find_input_clips([str(folder)]).sources
    begun, order = threading.Event(), rng.sample(range(20), 20)

    def tasks_begun(tasks, seconds):
        begun.set()
        return in_two_processes(tasks, seconds)

    def change_all():
        begun.wait(60.0)
        for k in order:
            time.sleep(rng.expovariate(10.0))  # as long as a clip takes
            change(made[k], others[k].read_bytes())

    thread = threading.Thread(target=change_all)
    thread.start()
    summary = run_batch(out, sources, Parameters(), tasks_begun)
    thread.join()
    assert len(summary.failed) + summary.done == len(made)
    assert all(names_in_one_line(sentence, "clip_") for sentence in summary.failed)
    versions += [path.read_bytes() for path in made if path.exists()]
    known = {hashlib.sha256(data).hexdigest(): data for data in versions}
    for row in rows_of(out).values():
        if row.state == DONE and change is not rewritten:  # in place, a part may be read, too
            assert row.sha256 in known
    for mark, result in results_of(out).items():
        if mark in known:
            (tmp_path / "clip.bvh").write_bytes(known[mark])
            _, alone, _ = clip_result.process_clip(tmp_path / "clip.bvh", Parameters())
            assert json.loads(result) == json.loads(json.dumps({**alone, "clip": ""}))
