"""Shards merged: the folder that one run would have written, and no wrong or lost clip."""

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from tests.conftest import ASSETS
from tests.twistcore import amc_files
from tests.twistcore.batch_folders import clips
from tests.twistcore.reviews import find_flips, flip
from tests.twistcore.test_batch_run import apart, results, run
from tests.twistcore.test_cli import run as command
from twistcore.batch.clip_task import run_task
from twistcore.batch.manifest import FILE, Manifest
from twistcore.batch.merging import merge_batch_folders
from twistcore.batch.parameters import Parameters
from twistcore.errors import TwistError

DIRTY = ASSETS / "walk_injected.bvh"
REFINE = {"parameters": Parameters(refine=True)}


def corrected(out):
    folder = out / "corrected"
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def shards(folder, out, count, **more):
    parts = [out.with_name(f"{out.name}-{k + 1}") for k in range(count)]
    for k, part in enumerate(parts):
        run(folder, part, part=(k + 1, count), **more)
    return parts


def rows(out):
    with Manifest.open(out) as manifest:
        return {row.name: row for row in manifest.rows().values()}


def test_merged_shards_are_the_folder_of_one_run(tmp_path, capsys):
    folder, out = tmp_path / "in", tmp_path / "out"
    clips(folder, DIRTY, 6, frames=150)
    shutil.copytree(folder, folder / "more" / "deep")
    (folder / "bad.bvh").write_text("no clip")
    run(folder, tmp_path / "whole", **REFINE)
    parts = shards(folder, out, 3, **REFINE)
    before = [(part / FILE).read_bytes() for part in parts]
    code, said, err = command(capsys, "merge", *parts, "-o", out)
    assert code == 1
    assert "bad.bvh" in err
    assert f"{len(rows(tmp_path / 'whole')) - 1} clips done, 1 failed, from 3 folders" in said
    assert results(out) == results(tmp_path / "whole")
    assert corrected(out) == corrected(tmp_path / "whole")
    assert [(part / FILE).read_bytes() for part in parts] == before
    assert run(folder, out, **REFINE).known == len(rows(out)) - 1  # nothing is done again
    again = merge_batch_folders(parts, out)  # twice is as once
    assert (again.done, again.waiting, len(again.failed)) == (len(rows(out)) - 1, 0, 1)
    assert again.problems == []
    assert results(out) == results(tmp_path / "whole")


def test_the_skeleton_of_a_corrected_amc_comes_along(tmp_path, monkeypatch):
    amc_files.written(tmp_path / "in" / "day", False)
    find_flips(monkeypatch, flip("rfemur-rfoot", 20, 30))
    run(tmp_path / "in", tmp_path / "a", **REFINE)
    merge_batch_folders([tmp_path / "a"], tmp_path / "out")
    assert corrected(tmp_path / "out").keys() == {"day/01.asf", "day/01_02.amc"}
    assert corrected(tmp_path / "out") == corrected(tmp_path / "a")


@pytest.mark.thorough
def test_what_is_missing_is_told_and_done_by_the_next_run(tmp_path, capsys):
    folder, out = tmp_path / "in", tmp_path / "out"
    clips(folder, DIRTY, 4, frames=150)
    parts = shards(folder, out, 2, **REFINE)
    changed, gone = [next(iter((part / "corrected").iterdir())) for part in parts]
    changed.write_bytes(changed.read_bytes() + b"\n")
    gone.unlink()
    code, _, err = command(capsys, "merge", *parts, "-o", out)
    assert code == 1
    assert f"{changed.name}: {changed} has been changed since it was written" in err
    assert f"{gone.name}: {gone} cannot be copied (No such file or directory)" in err
    assert {changed.name, gone.name}.isdisjoint(corrected(out))
    listed = {row.corrected.removeprefix("corrected/") for row in rows(out).values()}
    assert listed == {"", *corrected(out)}
    assert run(folder, out, **REFINE).done == 2
    run(folder, tmp_path / "whole", **REFINE)
    assert corrected(out) == corrected(tmp_path / "whole")


def test_the_latest_result_of_a_clip_counts(tmp_path):
    folder = tmp_path / "in"
    made = clips(folder, DIRTY, 2, frames=150)
    run(folder, tmp_path / "old")
    made[0].write_bytes(made[1].read_bytes().replace(b"\n", b"\r\n"))
    run(folder, tmp_path / "new")
    with Manifest.open(tmp_path / "new") as manifest, manifest.transaction():
        later = "2999-01-01T00:00:00+00:00"
        manifest.put_rows([replace(row, finished_at=later) for row in manifest.rows().values()])
    for k, order in enumerate((("old", "new"), ("new", "old"))):
        out = tmp_path / f"out{k}"
        merge_batch_folders([tmp_path / name for name in order], out)
        assert results(out) == results(tmp_path / "new")
    merge_batch_folders([tmp_path / "old"], tmp_path / "new")
    assert results(tmp_path / "new") == results(out)


def test_clips_of_the_same_name_are_told_apart(tmp_path):
    for k, name in enumerate(("a", "b")):
        clips(tmp_path / name, DIRTY, 1, frames=120 + k)
        run(tmp_path / name, tmp_path / f"out-{name}", **REFINE)
    merge_batch_folders([tmp_path / "out-a", tmp_path / "out-b"], tmp_path / "out")
    found = rows(tmp_path / "out")
    assert len(found) == len({row.sha256 for row in found.values()}) == 2
    for row in found.values():
        part = tmp_path / f"out-{Path(row.source).parent.name}"
        [data] = corrected(part).values()
        assert (tmp_path / "out" / row.corrected).read_bytes() == data


def test_later_decisions_are_kept(tmp_path):
    folder = tmp_path / "in"
    [path] = clips(folder, DIRTY, 1)
    for year, name in ((2026, "a"), (2027, "b"), (2025, "out")):
        run(folder, tmp_path / name)
        with Manifest.open(tmp_path / name) as manifest:
            at = f"{year}-01-01T00:00:00+00:00"
            manifest.note_decisions(str(path), {"accepted": year, "at": at})
    merge_batch_folders([tmp_path / "b", tmp_path / "a"], tmp_path / "out")
    with Manifest.open(tmp_path / "out") as manifest:
        assert manifest.record(str(path)).decisions["accepted"] == 2027


def test_folders_that_are_refused(tmp_path):
    folder = tmp_path / "in"
    clips(folder, DIRTY, 1)
    run(folder, tmp_path / "a")
    for other, why in (
        (tmp_path / "a", "expected a folder other than the output folder"),
        (tmp_path / "in", "expected a folder written by twistcore batch"),
    ):
        with pytest.raises(TwistError, match=why):
            merge_batch_folders([other], tmp_path / "a")
    run(folder, tmp_path / "b", apart(run_task, 1))
    with Manifest.open(tmp_path / "b") as manifest, manifest.transaction():
        [row] = manifest.rows().values()
        manifest.put_result(row, {})
    with pytest.raises(TwistError, match=f"^{tmp_path}/b/{FILE}: the key schema is missing"):
        merge_batch_folders([tmp_path / "a", tmp_path / "b"], tmp_path / "out")
    assert rows(tmp_path / "out") == {}
