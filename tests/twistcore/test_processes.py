"""Many files in many processes: one that fails, or kills its process, stops no other."""

import contextlib
import os
import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ASSETS
from tests.messages import names_in_one_line
from tests.tiers import parametrize
from tests.twistcore.process_work import dies_once, prints, unsendable, work
from twistcore.cli import main
from twistcore.tuning import read_profile
from twistcore.work import processes
from twistcore.work.processes import (
    ProcessEndedError,
    ProcessTimeError,
    describe_failure,
    map_in_processes,
)


@pytest.mark.parametrize("workers", [1, 2])
def test_a_failure_is_an_answer_like_any_other(workers):
    names = ["a", "memory", "bvh", "b", "defect"]
    found = dict(map_in_processes(work, names, workers))
    assert sorted(found) == sorted(names)
    assert (found["a"], found["b"]) == ("A", "B")
    assert names_in_one_line(describe_failure("m.bvh", found["memory"]), "m.bvh: ", "memory")
    assert names_in_one_line(describe_failure("x.bvh", found["bvh"]), "x.bvh, line 2: ", "OFFSET")
    assert describe_failure("d.bvh", found["defect"]) == "d.bvh: ZeroDivisionError: of ours"


def test_who_kills_its_process_is_known_and_the_others_go_on():
    names = ["slow 1", "dies 1", "a", "slow 2", "dies 2", *"bcdefg"]
    found = dict(map_in_processes(work, names, 2))
    assert sorted(found) == sorted(names)
    for name, result in found.items():
        if name.startswith("dies"):
            assert isinstance(result, ProcessEndedError)
            assert names_in_one_line(describe_failure(name, result), str(name))
        else:
            assert result == name.upper()


def test_a_name_is_tried_once_more_where_its_process_was_killed_by_others(tmp_path):
    found = dict(
        map_in_processes(dies_once, [str(tmp_path / "a"), str(tmp_path / "b")], 1, apart=True)
    )
    assert set(found.values()) == {"well"}


def test_who_hangs_is_ended_and_the_others_go_on():
    names = ["a", "hangs", "b", "spins", "slow 1"]
    limits = {"hangs": 0.15, "spins": 0.8}
    found = dict(map_in_processes(work, names, 2, seconds=lambda name: limits.get(name, 60.0)))
    assert [found[n] for n in ("a", "b", "slow 1")] == ["A", "B", "SLOW 1"]
    assert isinstance(found["hangs"], ProcessTimeError)
    assert names_in_one_line(describe_failure("x.bvh", found["hangs"]), "x.bvh", "1.5 s")
    assert isinstance(found["spins"], ProcessTimeError)
    assert names_in_one_line(describe_failure("x.bvh", found["spins"]), "x.bvh", "0.8 s")


def test_time_in_which_a_process_only_waits_is_not_counted():
    found = dict(map_in_processes(work, ["slow 1"], 1, apart=True, seconds=lambda _: 0.5))
    assert found == {"slow 1": "SLOW 1"}


def test_without_timers_a_process_looks_at_its_own_time(monkeypatch):
    ended = []
    monkeypatch.setattr(processes, "_LOOKS_S", 0.01)
    monkeypatch.setattr(processes.os, "_exit", ended.append)
    with processes._watched(0.05):
        end = time.process_time() + 5.0
        while not ended and time.process_time() < end:
            pass
    assert set(ended) == {processes._ENDED_FOR_TIME}


def test_names_are_taken_as_they_are_needed():
    taken = []
    names = (taken.append(name) or name for name in map(str, range(1000)))
    results = map_in_processes(work, names, 2)
    assert next(results)[1] in ("0", "1")
    time.sleep(0.2)
    assert len(taken) <= 8
    results.close()


def test_whoever_cannot_name_the_next_is_told():
    def names():
        yield "a"
        raise KeyError("no more")

    results = map_in_processes(work, names(), 2)
    with pytest.raises(KeyError):
        list(results)


def test_what_is_printed_does_not_stand_among_the_answers(capfd):
    assert list(map_in_processes(prints, ["a"], 1, apart=True)) == [("a", 1)]
    assert capfd.readouterr().err == "a\n"


def test_a_name_that_cannot_be_sent_is_an_answer(tmp_path):
    [(_, result)] = map_in_processes(work, [lambda: 0], 1, apart=True)
    assert isinstance(result, Exception)
    [(_, result)] = map_in_processes(unsendable, ["a"], 1, apart=True)
    assert "Defect" in str(result)


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="Linux")
def test_whoever_stops_looking_leaves_no_process():
    before = children()
    results = map_in_processes(work, ["a", "hangs 1", "hangs 2", "hangs 3"], 2)
    assert next(results) == ("a", "A")
    assert children() > before
    results.close()  # and waits for nobody: they would take longer than a test may
    assert children() == before


def children():
    """Of this process, by number."""
    found = set()
    for task in Path("/proc/self/task").iterdir():
        with contextlib.suppress(OSError):
            found |= set((task / "children").read_text().split())
    return found


def short(source, target, frames=60):
    """A clip's first frames."""
    lines = (ASSETS / source).read_text("utf-8").splitlines(keepends=True)
    first = next(k for k, line in enumerate(lines) if line.startswith("Frame Time")) + 1
    target.write_text("".join(lines[: first + frames]), "utf-8")


BAD = {"broken.bvh", "empty.bvh", "astray.bvh", "stick.bvh", "unread.bvh"}


@pytest.fixture
def folder(tmp_path):
    """Three clips that are good and some that are bad, each in its own way."""
    made = tmp_path / "clips"
    made.mkdir()
    for name in ("a", "m", "z"):
        short("walk.bvh", made / f"01_{name}.bvh", 344)
    (made / "broken.bvh").write_text("HIERARCHY\nROOT")
    (made / "empty.bvh").touch()
    (made / "astray.bvh").symlink_to("nowhere")
    (made / "folder.bvh").mkdir()  # no clip: clips may lie in a folder of any name
    (made / "stick.bvh").write_text(
        "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
        "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0\n1 1 1\n"
    )
    shutil.copy(ASSETS / "walk.bvh", made / "unread.bvh")
    (made / "unread.bvh").chmod(0)
    if os.access(made / "unread.bvh", os.R_OK):  # root may read anything but this
        (made / "unread.bvh").unlink()
        (made / "unread.bvh").symlink_to("/proc/self/mem")
    return made


def listed(err, names):
    """Every one of the files in a line of its own that says what is wrong."""
    said = [line for line in err.splitlines() if not re.match(r"\d+/\d+ ", line)]  # progress
    for name in names:
        lines = [line for line in said if name in line]
        assert len(lines) == 1, (name, err)
        assert len(lines[0].partition(name)[2]) > 10
    assert "Traceback" not in err


@pytest.mark.skipif(os.name != "posix", reason="links, permissions")
@parametrize("workers", ["1", "2"])
def test_tune_goes_on(folder, tmp_path, capsys, workers):
    words = ["tune", str(folder), "-o", str(tmp_path / "p.toml"), "--method", "paper"]
    assert main([*words, "--seeds", "1", "--workers", workers]) == 1
    listed(capsys.readouterr().err, BAD)
    both = read_profile(tmp_path / "p.toml").tau
    for path in folder.glob("[!0]*"):
        path.rmdir() if path.is_dir() else path.unlink()
    words = ["tune", str(folder), "-o", str(tmp_path / "q.toml"), "--method", "paper"]
    assert main([*words, "--seeds", "1", "--workers", "1"]) == 0
    alone = read_profile(tmp_path / "q.toml").tau
    assert list(both) == list(alone)
    np.testing.assert_array_equal(list(both.values()), list(alone.values()))


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="links, permissions")
def test_benchmark_and_quamo_go_on(folder, capsys):
    words = ["benchmark", str(folder), "--methods", "paper", "--seeds", "1", "--workers", "2"]
    assert main([*words, "--json", str(folder / "out.json")]) == 1
    printed = capsys.readouterr()
    listed(printed.err, BAD)
    assert main(["quamo", "evaluate", str(folder), "--seeds", "1"]) == 1
    listed(capsys.readouterr().err, BAD)


@parametrize(
    "words",
    [
        ("tune", "{}", "-o", "p.toml", "--workers", "2"),
        ("benchmark", "{}", "--methods", "paper", "--seeds", "1", "--workers", "2"),
        ("quamo", "train", "{}", "-o", "weights"),
    ],
)
def test_two_where_nothing_could_be_processed(tmp_path, capsys, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in").mkdir()
    for name in ("x.bvh", "y.bvh"):
        (tmp_path / "in" / name).write_text("HIERARCHY\nROOT")
    assert main([word.replace("{}", "in") for word in words]) == 2
    listed(capsys.readouterr().err, ("x.bvh", "y.bvh"))
    assert [p.name for p in tmp_path.iterdir()] == ["in"]


def test_evaluate_goes_on(capsys):
    truth, walk = str(ASSETS / "walk_injected.truth.json"), str(ASSETS / "walk.bvh")
    words = ["evaluate", "--truth", truth, truth, "--clean", walk, walk, "--refined"]
    assert main([*words, walk, "none.bvh"]) == 1
    printed = capsys.readouterr()
    listed(printed.err, ["none.bvh"])
    assert "Overall" in printed.out
    assert main([*words, "none.bvh", "neither.bvh"]) == 2
    listed(capsys.readouterr().err, ["none.bvh", "neither.bvh"])
