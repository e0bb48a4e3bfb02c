"""Links in a batch folder: nothing is written to where they lead, and foreign files stay."""

import os
import shutil
from pathlib import Path

import pytest

from tests.tiers import parametrize
from tests.twistcore.batch_folders import ROOT, clips
from tests.twistcore.reviews import CLIP, fresh
from twistcore.cli.command_line import main
from twistcore.review import write_session

DIRTY = ROOT / "assets" / "walk_injected.bvh"

pytestmark = pytest.mark.skipif(os.name != "posix", reason="Windows lets few users make links")


@pytest.fixture
def folders(tmp_path, batch_here):
    """A folder of one clip within another, the batch folder, and one elsewhere."""
    clips(tmp_path / "in" / "day", DIRTY, 1, frames=60)
    for name in ("out", "elsewhere"):
        (tmp_path / name).mkdir()
    return tmp_path


def batch(folders, *words):
    words = ["batch", str(folders / "in"), "-o", str(folders / "out"), "--workers", "1", *words]
    return main([*words, "--refine"])


def there(folder):
    """The bytes of every file below a folder."""
    return {p.relative_to(folder): p.read_bytes() for p in Path(folder).rglob("*") if p.is_file()}


@pytest.mark.parametrize(
    "link",
    [
        "corrected", "corrected/day", "manifest.sqlite", "manifest.lock", "manifest.sqlite-journal",
        "manifest.sqlite-wal", "report", "report/clips", "report/index.html",
    ],
)  # fmt: skip
@parametrize("target", ["a folder", "a file", "nothing"])
def test_a_link_is_refused_and_nothing_written_to_its_end(link, target, folders, capsys):
    end = folders / "elsewhere" / "end"
    if target == "a folder":
        end.mkdir()
    elif target == "a file":
        end.write_text("of somebody")
    (folders / "out" / link).parent.mkdir(exist_ok=True)
    (folders / "out" / link).symlink_to(end)
    before = there(folders / "elsewhere")
    code = batch(folders, "--report")
    err = capsys.readouterr().err
    assert code in (1, 2)
    assert f"{folders / 'out' / link} is a symbolic link" in err
    assert "Traceback" not in err
    assert there(folders / "elsewhere") == before
    assert end.exists() == (target != "nothing")
    assert not any(end.iterdir() if target == "a folder" else [])


def test_a_manifest_of_another_folder_is_not_written_through_a_link(folders, capsys):
    assert batch(folders) == 0
    (folders / "out").rename(folders / "other")
    (folders / "out").mkdir()
    (folders / "out" / "manifest.sqlite").symlink_to(folders / "other" / "manifest.sqlite")
    before = there(folders / "other")
    capsys.readouterr()
    assert batch(folders) == 2
    assert "symbolic link" in capsys.readouterr().err
    assert main(["report", str(folders / "out"), "-o", str(folders / "pages")]) == 2
    assert there(folders / "other") == before


def test_the_batch_folder_itself_may_be_a_link(folders):
    shutil.rmtree(folders / "out")
    (folders / "out").symlink_to(folders / "elsewhere")
    assert batch(folders) == 0
    assert (folders / "elsewhere" / "corrected" / "day" / "clip_00.bvh").is_file()


def test_parts_of_other_programs_are_kept_and_those_of_killed_runs_removed(folders):
    corrected = folders / "out" / "corrected" / "day"
    corrected.mkdir(parents=True)
    foreign = [".film.mp4.part", ".a.part", "clip.twist.part", ".clip.twist.part.txt", ".twist.x"]
    for name in foreign:
        (corrected / name).write_text("of somebody")
    (folders / "elsewhere" / ".a.bvh.twist.part").write_text("of somebody")
    (corrected / ".linked.twist.part").symlink_to(folders / "elsewhere" / ".a.bvh.twist.part")
    (folders / "out" / "corrected" / "linked").symlink_to(folders / "elsewhere")
    ours = [".clip_07.bvh.twist.part", ".clip_08.bvh.twist.ab12.part"]
    for name in ours:
        (corrected / name).write_text("half")
    batch(folders)
    assert {p.name for p in corrected.iterdir()} == {*foreign, ".linked.twist.part", "clip_00.bvh"}
    assert (folders / "elsewhere" / ".a.bvh.twist.part").exists()


@pytest.mark.parametrize("link", ["day", "applied.jsonl"])
def test_apply_does_not_follow_a_link_within_its_folder(link, folders, capsys):
    shutil.copy(DIRTY, folders / "in" / "day" / DIRTY.name)
    write_session(CLIP, fresh().state, folders / "in" / "day" / f"{DIRTY.stem}.twist.json")
    (folders / "out" / link).symlink_to(folders / "elsewhere" / "end")
    if link == "day":
        (folders / "elsewhere" / "end").mkdir()
    words = ["apply", str(folders / "in"), str(folders / "in"), "-o", str(folders / "out")]
    assert main(words) == 2
    assert not there(folders / "elsewhere")
    assert f"{folders / 'out' / link} is a symbolic link" in capsys.readouterr().err
