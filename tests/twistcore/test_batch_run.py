"""A batch: each clip for itself, nothing twice, nothing lost, whatever dies on the way."""

import csv
import json
import os
import shutil
import sqlite3
from functools import partial

import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, refused
from tests.tiers import parametrize
from tests.twistcore import amc_files
from tests.twistcore.batch_folders import ROOT, as_its_name_says, clips
from tests.twistcore.reviews import find_flips, flip
from twistcore.batch.clip_task import run_task
from twistcore.batch.inputs import find_input_clips
from twistcore.batch.manifest import Manifest, is_batch_folder
from twistcore.batch.parameters import DEFAULT_METHOD, Parameters
from twistcore.batch.run import Limits, run_batch
from twistcore.cli import main
from twistcore.detection import DEFAULT_METHOD as METHOD
from twistcore.errors import TwistError
from twistcore.formats.suffixes import CLIP_SUFFIXES
from twistcore.work.processes import ProcessTimeError, map_in_processes

DIRTY = ASSETS / "walk_injected.bvh"


def here(tasks, seconds, work=run_task):
    """Tasks one after the other in this process; ones that fail apart."""
    return map_in_processes(work, tasks, 1)


def apart(work, workers=2):
    return lambda tasks, seconds: map_in_processes(
        work, tasks, workers, apart=True, seconds=seconds
    )


def run(folder, out, carry_out=here, **more):
    parameters = more.pop("parameters", Parameters())
    return run_batch(
        out, find_input_clips([str(folder)], out).sources, parameters, carry_out, **more
    )


def _patience(task):
    return 0.2 if "hangs" in task.name else 60.0


def results(out):
    with Manifest.open(out) as manifest:
        return {r.name: json.dumps(r.result, sort_keys=True) for r in manifest.records()}


def counted(counts):
    def work(task):
        counts.append(task.name)
        return run_task(task)

    return partial(here, work=work)


def test_words_that_need_no_numpy_are_those_of_the_rest():
    assert DEFAULT_METHOD == METHOD
    assert CLIP_SUFFIXES == (".bvh", ".npz", ".amc", ".pkl")


def test_only_what_is_new_is_done(tmp_path):
    folder, out, counts = tmp_path / "in", tmp_path / "out", []
    made = clips(folder, DIRTY, 3)
    assert run(folder, out, counted(counts)).done == 3
    first = results(out)
    assert run(folder, out, counted(counts)).known == 3
    assert len(counts) == 3
    made[0].write_bytes(made[0].read_bytes().replace(b"\n", b"\r\n"))  # other bytes
    made[1].rename(folder / "renamed.bvh")  # the same bytes: nothing to do
    made[2].touch()
    shutil.copy(ASSETS / "walk.bvh", folder / "new.bvh")
    summary = run(folder, out, counted(counts))
    assert counts[3:] == ["new.bvh", "clip_00.bvh"]  # the longest first
    assert (summary.done, summary.known, summary.failed) == (2, 2, [])
    again = results(out)
    assert again["renamed.bvh"] == again["clip_01.bvh"].replace("clip_01", "renamed")
    assert again["clip_02.bvh"] == first["clip_02.bvh"]
    run(folder, out, counted(counts), parameters=Parameters(tau_deg=5.0))
    assert len(counts) == 5 + 4  # other parameters: all anew


def test_a_file_changed_within_its_time_stamp_is_noticed(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    [clip] = clips(folder, DIRTY, 1)
    clip.touch()  # written just now: its time may not tell the next change
    run(folder, out)
    status, data = clip.stat(), clip.read_bytes()
    clip.write_bytes(data.replace(b".0083333", b".0093333"))
    os.utime(clip, ns=(status.st_atime_ns, status.st_mtime_ns))
    counts = []
    run(folder, out, counted(counts))
    assert counts == ["clip_00.bvh"]


@pytest.mark.thorough
def test_a_clip_that_fails_costs_itself_alone(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    made = clips(folder, DIRTY, 7)
    for path, name in zip(made, ("dies", "hangs", "greedy"), strict=False):
        path.rename(folder / f"{name}.bvh")
    (folder / "broken.bvh").write_text("HIERARCHY\nROOT")
    (folder / "astray.bvh").symlink_to("nowhere")

    def carry_out(tasks, seconds):
        assert seconds(tasks[0]) > 300.0
        return map_in_processes(as_its_name_says, tasks, 2, apart=True, seconds=_patience)

    summary = run(folder, out, carry_out, limits=Limits(memory=300_000_000))
    assert (summary.done, len(summary.failed)) == (4, 5)
    with Manifest.open(out) as manifest:
        records = {r.name: r for r in manifest.records()}
    reasons = {name: r.reason for name, r in records.items() if r.state == "failed"}
    assert "2 s" in reasons["hangs.bvh"]
    assert "memory" in reasons["greedy.bvh"]
    assert "line 2" in reasons["broken.bvh"]
    assert sorted(reasons.values()) == sorted(summary.failed)
    # What may end otherwise is tried again; the file that cannot be read stays listed.
    counts = []
    summary = run(folder, out, counted(counts))
    assert sorted(counts) == ["astray.bvh", "dies.bvh", "greedy.bvh", "hangs.bvh"]
    assert (summary.done, summary.known, len(summary.failed)) == (3, 4, 2)


def test_the_manifest_says_what_was_done(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    shutil.copytree(ASSETS, folder, ignore=lambda _, names: set(names) - {"walk_injected.bvh"})
    run(folder, out, apart(run_task, 1), parameters=Parameters(refine=True))
    with Manifest.open(out) as manifest:
        [record] = manifest.records()
        assert manifest.record(str(folder / "walk_injected.bvh")) == record
    assert (record.state, record.name) == ("done", "walk_injected.bvh")
    assert record.parameters["refine"] is True
    assert record.bytes == DIRTY.stat().st_size
    assert record.peak_bytes > 10_000_000
    result = record.result
    assert list(result)[:2] == ["schema", "clip"]
    assert result["counts"]["counter-twist"] == len(result["intervals"]) == result["applied"] > 0
    assert result["left"] == []
    assert 0 < result["degrees"]["rms"] <= result["degrees"]["max"]
    assert (out / record.corrected).read_bytes() != DIRTY.read_bytes()


@parametrize("words", [[], ["--tau", "5"], ["--kinds", "limb-flip", "--method", "paper"]])
@pytest.mark.usefixtures("batch_here")
def test_intervals_are_those_of_detect(tmp_path, capsys, words):
    assert main(["detect", str(DIRTY), "--json", *words]) == 0
    alone = json.loads(capsys.readouterr().out)
    assert main(["batch", str(DIRTY), "-o", str(tmp_path), "--workers", "1", *words]) == 0
    [text] = results(tmp_path).values()
    document = json.loads(text)
    for key in ("intervals", "tau_deg", "frames", "fps", "method"):
        assert document[key] == alone[key]


@pytest.mark.usefixtures("batch_here")
def test_corrected_clips_are_those_of_refine(tmp_path, capsys):
    words = ["--min-confidence", "0.3"]
    assert main(["refine", str(DIRTY), "-o", str(tmp_path / "alone.bvh"), *words]) == 0
    out = tmp_path / "out"
    command = ["batch", str(DIRTY), "-o", str(out), "--workers", "1", "--refine", *words]
    assert main(command) == 0
    corrected = out / "corrected" / "walk_injected.bvh"
    assert corrected.read_bytes() == (tmp_path / "alone.bvh").read_bytes()
    corrected.unlink()  # made anew where it is gone …
    assert main(command) == 0
    assert corrected.read_bytes() == (tmp_path / "alone.bvh").read_bytes()
    corrected.write_text("somebody's")  # … and never put in the place of what is not ours
    assert main(command) == 1
    assert names_in_one_line(capsys.readouterr().err.splitlines()[0], "walk_injected.bvh")
    assert corrected.read_text() == "somebody's"


def test_a_corrected_clip_whose_note_was_lost_is_ours(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    clips(folder, DIRTY, 1)
    run(folder, out, parameters=Parameters(refine=True))
    with sqlite3.connect(out / "manifest.sqlite") as connection:  # as killed before the note
        connection.execute("DELETE FROM clips")
    connection.close()
    (out / "corrected" / ".clip_00.bvh.twist.part").touch()
    assert run(folder, out, parameters=Parameters(refine=True)).done == 1
    assert [p.name for p in (out / "corrected").iterdir()] == ["clip_00.bvh"]


def test_two_runs_do_not_write_into_one_folder(tmp_path, capsys):
    folder, out = tmp_path / "in", tmp_path / "out"
    clips(folder, DIRTY, 1)
    seen = []

    def meanwhile(tasks, seconds):
        seen.append(main(["batch", str(folder), "-o", str(out)]))
        return here(tasks, seconds)

    run(folder, out, meanwhile)
    assert seen == [2]
    assert "another run" in capsys.readouterr().err


def test_decisions_stay_with_a_clip(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    [clip] = clips(folder, DIRTY, 1)
    run(folder, out)
    told = {"accepted": 1, "rejected": 0, "undecided": 2, "reviewers": ["A"], "session": "s"}
    with Manifest.open(out) as manifest:
        manifest.note_decisions(str(clip), told)
    run(folder, out, parameters=Parameters(tau_deg=9.0))
    with Manifest.open(out) as manifest:
        assert manifest.record(str(clip)).decisions == told
        manifest.note_decisions(str(clip), {})
        assert manifest.record(str(clip)).decisions == {}
        with refused(TwistError, "/other.bvh"):
            manifest.note_decisions("/other.bvh", told)


@pytest.mark.thorough
def test_shards_are_all_clips_and_none_twice(tmp_path):
    folder = tmp_path / "in"
    clips(folder, DIRTY, 12, 40)
    names = []
    for k in (1, 2, 3):
        run(folder, tmp_path / str(k), part=(k, 3))
        names += results(tmp_path / str(k))
    assert sorted(names) == sorted(p.name for p in folder.iterdir())


def test_the_page_shows_what_a_result_is(tmp_path):
    assert "(examples/batch_clip.json)" in (ROOT / "docs" / "batch.md").read_text("utf-8")
    example = json.loads((ROOT / "docs" / "examples" / "batch_clip.json").read_text("utf-8"))
    run(DIRTY, tmp_path / "out", parameters=Parameters(refine=True))
    with Manifest.open(tmp_path / "out") as manifest:
        result = manifest.records()[0].result
    assert list(example) == list(result)
    assert {type(v) for v in example.values()} == {type(v) for v in result.values()}
    assert list(example["intervals"][0]) == list(result["intervals"][0])
    for key in ("counts", "degrees", "quality"):
        assert list(example[key]) == list(result[key])


def test_what_is_no_manifest_is_said(tmp_path, capsys):
    assert not is_batch_folder(tmp_path)
    (tmp_path / "manifest.sqlite").write_text("somebody's")
    assert not is_batch_folder(tmp_path)
    assert main(["batch", str(DIRTY), "-o", str(tmp_path)]) == 2
    assert names_in_one_line(capsys.readouterr().err, "manifest.sqlite")
    assert (tmp_path / "manifest.sqlite").read_text() == "somebody's"


@parametrize(
    ("words", "said"),
    [
        ((), "--from"),
        (("gone",), "gone: "),
        (("x", "--include-open"), "--refine"),
        (("x", "--profile", "gone"), "gone: "),
        (("x", "--fail-if", "severity"), "'severity'"),
        (("x", "--scheduler", "tcp://127.0.0.1:9"), "tcp://127.0.0.1:9"),
    ],
    quick=3,
)
def test_wrong_words_are_refused(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("twistcore.batch.dask_cluster._CONNECT_S", 0.2)
    clips(tmp_path / "x", DIRTY, 1, 40)
    workers = () if "--scheduler" in words else ("--workers", "1")
    assert main(["batch", *words, "-o", "out", *workers]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.usefixtures("batch_here")
def test_files_and_rules_of_what_was_named(tmp_path, capsys):
    clips(tmp_path / "in", DIRTY, 2)
    words = ["batch", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--workers", "1"]
    files = [w for n in ("jsonl", "csv", "junit") for w in (f"--{n}", str(tmp_path / n))]
    assert main([*words, *files, "--fail-if", "count>0"]) == 1
    assert capsys.readouterr().err.count("'count>0'") == 2
    assert len((tmp_path / "jsonl").read_text().splitlines()) == 2
    assert len((tmp_path / "csv").read_text().splitlines()) == 3
    assert (tmp_path / "junit").read_text().count("<testcase") == 2
    assert main([*words, "--fail-if", "count>99"]) == 0


def test_annotations_name_files_as_from_the_current_folder(tmp_path, monkeypatch, capfd):
    clips(tmp_path / "in", DIRTY, 2)
    monkeypatch.chdir(tmp_path)
    words = ["batch", "in", "--workers", "1", "--fail-if", "count>0", "--annotations", "-"]
    assert main(words) == 1
    lines = capfd.readouterr().out.splitlines()  # and nothing else
    names = [f"in/clip_0{k}.bvh" for k in (0, 1)]
    assert [line.split(",")[0] for line in lines] == [f"::error file={name}" for name in names]


def test_a_rule_or_a_file_needs_no_folder(tmp_path, monkeypatch, capsys):
    [clip] = clips(tmp_path / "in", DIRTY, 1)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    words = ["batch", str(clip), "--workers", "1"]
    assert main([*words, "--fail-if", "count>0", "--csv", "table.csv"]) == 1
    told = capsys.readouterr()
    assert "'count>0'" in told.err
    assert str(tmp_path) not in told.out
    assert main([*words, "--fail-if", "count>99"]) == 0
    assert {p.name for p in tmp_path.iterdir()} == {"in", "table.csv", "temporary"}
    assert [*(tmp_path / "temporary").iterdir()] == []
    for more in ([], ["--refine"], ["--report", "--fail-if", "count>0"]):
        capsys.readouterr()
        assert main([*words, *more]) == 2
        assert names_in_one_line(capsys.readouterr().err, "-o OUTDIR")


def test_an_amc_is_new_where_its_skeleton_changed(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    folder.mkdir()
    for name in ("a.amc", "a.asf"):
        (folder / name).write_text("nothing")
        os.utime(folder / name, (1e9, 1e9))
    assert run(folder, out).unreadable == 1
    counts = []
    assert run(folder, out, counted(counts)).unreadable == 1
    os.utime(folder / "a.asf", (1.1e9, 1.1e9))
    run(folder, out, counted(counts))
    assert counts == ["a.amc"]


def test_exit_codes_where_nothing_came_out(tmp_path, monkeypatch, capsys):
    [clip] = clips(tmp_path / "in", DIRTY, 1, 40)
    words = ["batch", str(clip), "-o", str(tmp_path / "out")]

    def too_slow(tasks, _seconds, **_):
        return ((task, ProcessTimeError(0.01)) for task in tasks)

    monkeypatch.setattr("twistcore.cli.batch_command._in_processes", too_slow)
    assert main(words) == 1  # it can be read: another try may end otherwise
    assert "0.01 s" in capsys.readouterr().err
    monkeypatch.setattr(
        "twistcore.cli.batch_command._in_processes", lambda tasks, s, **_: here(tasks, s)
    )
    assert main(["batch", str(tmp_path / "none*.bvh"), *words[1:]]) == 1  # a word names no clip
    assert "none*.bvh: " in capsys.readouterr().err
    clip.write_text("HIERARCHY")
    assert main(words) == 2


def test_what_a_file_lets_nobody_correct_is_counted_and_told_as_by_refine(
    tmp_path, monkeypatch, capsys
):
    path, limb = amc_files.written(tmp_path / "in", False), "rfemur-rfoot"
    kept, carried = flip(limb, 20, 30), flip(limb, 60, 68, carried=True)
    find_flips(monkeypatch, kept, carried, flip("lfemur-lfoot", 80, 90, carried=True))
    monkeypatch.setattr(
        "twistcore.cli.batch_command._in_processes", lambda tasks, s, **_: here(tasks, s)
    )
    alone, out, table = tmp_path / "alone.amc", tmp_path / "out", tmp_path / "table.csv"
    assert main(["refine", str(path), "-o", str(alone), "--kinds", "limb-flip"]) == 1
    said = capsys.readouterr()
    assert "2 of 3 intervals" in said.out
    sentence = said.err.splitlines()[0].removeprefix(f"{path}: ")
    assert "rfoot" in sentence
    words = ["batch", str(path), "-o", str(out), "--kinds", "limb-flip", "--csv", str(table)]
    for _ in range(2):  # a run that does nothing says so, too
        assert main([*words, "--refine"]) == 1
        assert f"{path.name}: {sentence}\n" in capsys.readouterr().err
        [row] = csv.DictReader(table.read_text("utf-8").splitlines())
        assert (row["applied"], row["reason"], row["state"]) == ("2", sentence, "done")
    assert (out / "corrected" / path.name).read_bytes() == alone.read_bytes()
    [text] = results(out).values()
    assert json.loads(text)["uncorrected"] == [sentence] == json.loads(text)["warnings"][-1:]
    assert main(words) == 0  # nothing was to be corrected
