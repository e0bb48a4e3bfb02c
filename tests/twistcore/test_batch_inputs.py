"""Which clips a batch means, and by what names."""

import io
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.messages import names_in_one_line, numbers
from tests.twistcore.batch_folders import COMMAND, clips, environment
from twistcore.batch import survey_folder
from twistcore.batch.clip_task import run_task
from twistcore.batch.inputs import Source, assign_batch_names, find_input_clips
from twistcore.batch.manifest import Manifest
from twistcore.batch.parameters import Parameters
from twistcore.batch.run import run_batch
from twistcore.batch.run_plan import shard_sources
from twistcore.cli import main
from twistcore.errors import TwistError
from twistcore.work.processes import map_in_processes


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Clips in three folders, and what is none."""
    monkeypatch.chdir(tmp_path)
    for name in ("a/x.bvh", "a/y.BVH", "a/deep/x.bvh", "b/x.bvh", "b/notes.txt", "b/.hidden.bvh"):
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text("HIERARCHY")
    Path("b/folder.bvh").mkdir()
    Path("b/folder.bvh/z.bvh").touch()
    return tmp_path


def names(*words, without=None):
    return sorted(source.name for source in find_input_clips(words, without).sources)


def test_folders_files_and_patterns(folder):
    assert names("a") == ["deep/x.bvh", "x.bvh", "y.BVH"]
    assert names("b") == ["folder.bvh/z.bvh", "x.bvh"]
    assert names("a/x.bvh") == ["x.bvh"]
    assert names("a/x.bvh", "b/x.bvh", "b/notes.txt") == ["a/x.bvh", "b/notes.txt", "b/x.bvh"]
    assert names("*/x.bvh") == ["a/x.bvh", "b/x.bvh"]
    assert names("**/x.bvh") == ["a/deep/x.bvh", "a/x.bvh", "b/x.bvh"]
    assert names("**/deep/*") == ["a/deep/x.bvh"]
    assert names("a/**/d*p/**/x.bvh") == ["deep/x.bvh"]
    assert names("a/**") == names("a/**/*.[bB]*") == names("a")
    assert names("a/**/[x]*") == ["deep/x.bvh", "x.bvh"]
    assert names("a", "b") == ["b/x.bvh", "deep/x.bvh", "folder.bvh/z.bvh", "x.bvh", "y.BVH"]
    assert names("a", "a/x.bvh", "./a/../a") == names("a")  # nothing twice


def test_an_npz_without_poses_is_no_clip_of_a_folder(folder):
    np.savez(folder / "a" / "shape.npz", betas=np.zeros(3))
    np.savez(folder / "a" / "poses.npz", poses=np.zeros((3, 72)))
    (folder / "a" / "poses.npz").rename(folder / "a" / "poses.NPZ")
    assert names("a") == ["deep/x.bvh", "poses.NPZ", "x.bvh", "y.BVH"]
    assert names("a/*.[nN]*") == ["poses.NPZ"]


def test_lists(folder, monkeypatch):
    Path("list").write_text("a/x.bvh\n\n  b \n")
    assert names("@list") == ["a/x.bvh", "folder.bvh/z.bvh", "x.bvh"]
    monkeypatch.setattr("sys.stdin", io.StringIO("a/deep\na/gone.bvh\n"))
    assert names("-") == ["gone.bvh", "x.bvh"]  # whoever reads it says that it is not there
    Path("list").write_bytes(b"\xef\xbb\xbfa/x.bvh\r\nb\r\n")  # as Windows writes one
    assert names("@list") == ["a/x.bvh", "folder.bvh/z.bvh", "x.bvh"]
    monkeypatch.setattr("sys.stdin", io.StringIO("\ufeffa/deep\r\na/y.BVH\r\n"))
    assert names("-") == ["x.bvh", "y.BVH"]
    with pytest.raises(TwistError, match="nolist: "):
        find_input_clips(["@nolist"])


def test_where_there_is_nothing(folder):
    (folder / "none").mkdir()
    with pytest.raises(TwistError, match="none: "):
        find_input_clips(["none"])
    found = find_input_clips(["none", "*.bvh", "a"])
    assert len(found.problems) == 2
    assert len(found.sources) == 3


def test_what_a_batch_has_written_is_no_input(folder):
    made = clips(folder / "in", ASSETS / "walk_injected.bvh", 1, 40)
    out = folder / "in" / "out"

    def here(tasks, seconds):
        return map_in_processes(run_task, tasks, 1)

    run_batch(out, find_input_clips(["in"], out).sources, Parameters(refine=True), here)
    assert (out / "corrected" / made[0].name).exists()
    assert names("in", without=out) == [made[0].name]
    assert names("in") == [made[0].name]  # that of another run is none, either
    assert names("in/**/*.bvh", without=out) == [made[0].name]
    assert names("a", without=folder / "a" / "deep") == ["x.bvh", "y.BVH"]
    with pytest.raises(TwistError, match="outside"):
        find_input_clips([str(out / "corrected")], out)
    assert names(str(out / "corrected")) == [made[0].name]  # unless it is asked for


def exported(source, name, whole=False, told=None):
    """A clip of other bytes and the session that replays it, as the window leaves them."""
    out = source.with_name(name)
    out.write_text(source.read_text() + "corrected")
    start = out.name if whole else out.stem
    out.with_name(f"{start}.replay.json").write_text(json.dumps({"clip": told or str(source)}))
    return out


def test_exports_beside_their_sources_are_taken_only_if_named(folder):
    x = folder / "a/x.bvh"
    exported(x, "one.bvh")
    exported(folder / "a/deep/x.bvh", "x_refined.bvh")
    exported(x, "far.bvh", told="/elsewhere/z.bvh")  # its source is not in the folder
    (folder / "a/two.bvh").write_text("HIERARCHY MOTION 2")
    report = {"clip": "x.bvh", "files": {"two.bvh": ""}}
    (folder / "a/two.report.json").write_text(json.dumps(report))
    (folder / "a/y.report.json").write_text(json.dumps({"clip": "x.bvh", "files": {}}))
    (folder / "b/x_refined.bvh").write_text("HIERARCHY other")  # by another program
    rest = ["deep/x.bvh", "far.bvh", "x.bvh", "y.BVH"]
    assert names("a") == rest
    assert find_input_clips(["a"]).exports == 3
    assert names("a/**/*.bvh") == [name for name in rest if name != "y.BVH"]
    assert names("a/o*.bvh") == ["one.bvh"]  # without its source it was asked for
    assert names("a", "a/one.bvh") == sorted([*rest, "one.bvh"])
    assert find_input_clips(["a", "a/one.bvh"]).exports == 2
    assert names("b") == ["folder.bvh/z.bvh", "x.bvh", "x_refined.bvh"]


def test_an_export_of_another_format_is_told_by_its_whole_name(folder):
    source = folder / "b/05.amc"
    source.write_text("#!OML:ASF")
    exported(source, "05_refined.amc", whole=True)
    exported(source, "other.amc")  # by its stem, as versions before did
    (folder / "b/other.bvh").write_text("HIERARCHY")  # a take that no export went into
    assert names("b") == ["05.amc", "folder.bvh/z.bvh", "other.bvh", "x.bvh"]


@pytest.mark.thorough
def test_a_batch_over_reviewed_clips_says_what_it_did_not_take(tmp_path, capsys):
    [clip] = clips(tmp_path / "in", ASSETS / "walk_injected.bvh", 1, 40)
    words = ["batch", str(clip.parent), "-o", str(tmp_path / "o"), "--workers", "1"]
    assert main(words) == 0
    assert "taken" not in capsys.readouterr().out
    out = clip.with_name("clip_00_refined.bvh")
    out.write_bytes(clip.read_bytes())  # by its name and its skeleton alone
    assert main(words) == 0
    said = capsys.readouterr().out
    assert numbers(said.splitlines()[-1]) == [0, 1, 0, 1]
    with Manifest.open(tmp_path / "o") as manifest:
        assert [record.name for record in manifest.records()] == [clip.name]
    assert [one.path for one in survey_folder(clip.parent)] == [clip]


PATTERNS = ("in/**/*.bvh", "in/**", "in/*/**/*.bvh", "*/**/clip*", "in/**/[c]lip_00.bv?")


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_pattern_over_folders_takes_what_a_folder_does(tmp_path, monkeypatch, pattern):
    """No clip by way of links, round and round, and none that another batch has written."""
    monkeypatch.chdir(tmp_path)
    clips(tmp_path / "in" / "d" / "e", ASSETS / "walk_injected.bvh", 1, 40)
    run_batch(
        tmp_path / "in" / "out",
        find_input_clips(["in"]).sources,
        Parameters(refine=True),
        lambda tasks, _: map_in_processes(run_task, tasks, 1),
    )
    Path("in/d/up").symlink_to("..")
    Path("in/again").symlink_to("d/e")
    name = "in/d/e/clip_00.bvh" if pattern.startswith("*") else "d/e/clip_00.bvh"
    assert names(pattern) == [name]


def test_a_name_that_was_given_stays(folder):
    first = assign_batch_names(find_input_clips(["b"]).sources, {})
    given = {source.path: source.name for source in first}
    later = {
        s.path: s.name for s in assign_batch_names(find_input_clips(["a", "b"]).sources, given)
    }
    assert {path: later[path] for path in given} == given
    assert len({name.casefold() for name in later.values()}) == len(later) == 5


texts = st.text("aAb.", min_size=1, max_size=3)


@given(st.lists(st.tuples(texts, texts), max_size=12), st.integers(1, 4))
def test_names_differ_and_every_clip_is_in_one_shard(pairs, count):
    sources = [Source(f"/r{k}/{a}/{b}.bvh", f"{b}.bvh") for k, (a, b) in enumerate(pairs)]
    named = assign_batch_names(sources, {})
    assert len({source.name.casefold() for source in named}) == len(sources)
    parts = [shard_sources(named, k, count) for k in range(1, count + 1)]
    assert sorted(s.path for part in parts for s in part) == sorted(s.path for s in sources)


def test_a_shard_goes_by_names_wherever_the_folder_lies(tmp_path):
    """A job that runs again on another machine has the same part."""
    parts = []
    for root in ("a", "b/c"):
        made = clips(tmp_path / root, ASSETS / "walk_injected.bvh", 8, 1)
        sources = find_input_clips([str(made[0].parent)]).sources
        parts.append([[s.name for s in shard_sources(sources, k, 2)] for k in (1, 2)])
    assert parts[0] == parts[1]
    assert all(parts[0])


@pytest.mark.thorough
def test_clips_and_results_at_urls(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_: tmp_path / "cache")
    clips(tmp_path / "in", ASSETS / "walk_injected.bvh", 2, 40)
    url = f"file://{tmp_path}/out"
    words = ["batch", f"file://{tmp_path}/in", "-o", url, "--refine", "--workers", "1"]
    assert main(words) == 0
    with Manifest.open(tmp_path / "out") as manifest:
        first = manifest.records()
    assert [(r.name, r.state) for r in first] == [("clip_00.bvh", "done"), ("clip_01.bvh", "done")]
    assert len(list((tmp_path / "out/corrected").iterdir())) == 2
    (tmp_path / "cache").rename(tmp_path / "gone")  # another machine goes on from the URL
    clips(tmp_path / "in", ASSETS / "walk_injected.bvh", 3, 40)
    assert main(words) == 0
    assert "1 clip done, 2 " in capsys.readouterr().out
    with Manifest.open(tmp_path / "out") as manifest:
        assert manifest.records()[:2] == first
    (tmp_path / "cache").rename(tmp_path / "other")
    (tmp_path / "gone").rename(tmp_path / "cache")  # and the first one, from what that has left
    clips(tmp_path / "in", ASSETS / "walk_injected.bvh", 4, 40)
    assert main(words) == 0
    assert "1 clip done, 3 " in capsys.readouterr().out
    with Manifest.open(tmp_path / "out") as manifest:
        assert len(manifest.records()) == 4
    assert main(["batch", "nosuch://x/y", "-o", str(tmp_path / "o")]) == 2
    assert "nosuch" in capsys.readouterr().err


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="bytes in names")
def test_a_name_that_is_no_unicode(tmp_path):
    [clip] = clips(tmp_path / "in", ASSETS / "walk_injected.bvh", 1, 40)
    odd = Path(os.fsdecode(os.fsencode(clip.parent) + b"/m\xfcde.bvh"))
    clip.rename(odd)
    assert main(["batch", str(odd), "-o", str(tmp_path / "o"), "--workers", "1", "--refine"]) == 0
    with Manifest.open(tmp_path / "o") as manifest:
        record = manifest.record(str(odd))
    assert (tmp_path / "o" / record.corrected).exists()


@pytest.mark.thorough
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no such files")
def test_a_fifo_is_never_opened(tmp_path, monkeypatch):
    """Who opens one waits for its writer: it is listed, the first time and the next."""
    clips(tmp_path / "in", ASSETS / "walk_injected.bvh", 1, 40)
    for name in ("p.bvh", "p.npz", "p.amc"):
        os.mkfifo(tmp_path / "in" / name)
    (tmp_path / "in" / "other").mkdir()
    os.mkfifo(tmp_path / "in" / "other" / "manifest.sqlite")
    words = [*COMMAND, "in", "-o", "o", "--workers", "1"]
    for counts in ([1, 0, 3], [0, 1, 3]):
        ran = subprocess.run(
            words, cwd=tmp_path, env=environment(), capture_output=True, text=True, timeout=60
        )
        assert ran.returncode == 1, ran.stderr
        assert numbers(ran.stdout.splitlines()[-1])[:3] == counts
        for name in ("p.bvh", "p.npz", "p.amc"):
            assert f"/{name}: " in ran.stderr


def test_too_little_memory_to_begin_with_is_refused(tmp_path, capsys):
    words = ["batch", str(ASSETS / "walk.bvh"), "-o", str(tmp_path / "o"), "--memory-limit", "20"]
    with pytest.raises(SystemExit) as ended:
        main(words)
    assert ended.value.code == 2
    assert names_in_one_line(capsys.readouterr().err.splitlines()[-1], "256 MiB", "'20'")
    assert not (tmp_path / "o").exists()


def test_a_folder_where_a_clip_is_wanted_is_told_what_takes_folders(tmp_path, capsys):
    assert main(["detect", str(tmp_path)]) == 2
    assert names_in_one_line(capsys.readouterr().err, str(tmp_path), "`batch`")
