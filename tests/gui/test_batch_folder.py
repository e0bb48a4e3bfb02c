"""A folder that `twistcore batch` left, as the window's queue, and decisions on their way back."""

import csv
import io
import shutil
from pathlib import Path

import numpy as np
import pytest

from inspector.folder.clip_table import clip_table
from inspector.folder.queued_clip import ClipState
from inspector.session.settings import Settings
from tests.gui.folders import put_errors
from tests.gui.windows import act
from twistcore.batch import Manifest
from twistcore.batch.run import LOCK
from twistcore.cli import main
from twistcore.files.lock import lock_file


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    """A batch of two clips in folders of their own and one that cannot be read."""
    folder = tmp_path_factory.mktemp("batch")
    for name, chains in (("one/a.bvh", 3), ("two/a.bvh", 1)):
        (folder / name).parent.mkdir()
        put_errors(folder / name, chains)
    (folder / "two" / "broken.bvh").write_bytes(b"HIERARCHY\nROOT")
    clips = [str(folder / name) for name in ("one", "two")]
    assert main(["batch", *clips, "-o", str(folder / "out"), "--workers", "1"]) == 1
    return folder


@pytest.fixture
def outdir(batch, tmp_path):
    """The folder of its results; what a test changes there and in the clips is undone.

    The files stay the same, as a batch knows a clip by its inode, too.
    """
    kept = shutil.copytree(batch, tmp_path / "kept")
    yield batch / "out"
    for path in sorted(batch.rglob("*"), reverse=True):
        if not (kept / path.relative_to(batch)).exists():
            path.rmdir() if path.is_dir() else path.unlink()
    for path in filter(Path.is_file, kept.rglob("*")):
        there = batch / path.relative_to(kept)
        there.write_bytes(path.read_bytes())
        shutil.copystat(path, there)


def test_what_the_batch_found_is_listed_without_another_look(queue, outdir):
    queue.open(outdir)
    assert not queue.running
    worst, other, broken = queue.ordered
    assert [c.path.parent.name for c in (worst, other)] == ["one", "two"]
    assert worst.severity > other.severity > 0.0
    assert worst.intervals >= 3
    assert broken.state == ClipState.FAILED
    assert "broken.bvh" in broken.reason


def test_a_clip_that_changed_since_is_analysed_again(qtbot, queue, outdir):
    before = {c.path: c.severity for c in (queue.open(outdir), *queue.ordered)[1:]}
    changed = outdir.parent / "two" / "a.bvh"
    put_errors(changed, 9)
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.open(outdir)
    now = {c.path: c.severity for c in queue.ordered}
    assert now[changed] > before[changed]
    assert {p: s for p, s in now.items() if p != changed} == {
        p: s for p, s in before.items() if p != changed
    }


def test_decisions_flow_back_into_the_manifest(qtbot, show_window, outdir):
    window = show_window(Settings(theme="light", turn_ms=0, reviewer="Ada"))
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(outdir)
    path = window.document.data.clip.path
    assert path.parent.name == "one"
    qtbot.waitUntil(lambda: window.document.interval is not None, timeout=10_000)
    act(window, "accept")
    act(window, "reject")
    act(window, "save_session")

    def noted():
        with Manifest.open(outdir) as manifest:
            decisions = manifest.record(str(path)).decisions
        return {k: decisions.get(k) for k in ("accepted", "rejected", "reviewers")}

    wanted = {"accepted": 1, "rejected": 1, "reviewers": ["Ada"]}
    qtbot.waitUntil(lambda: noted() == wanted, timeout=10_000)


def test_the_table_has_every_clip_that_is_listed(queue, outdir):
    queue.open(outdir)
    rows = list(csv.DictReader(io.StringIO(clip_table(queue.ordered))))
    assert [row["clip"] for row in rows] == ["a.bvh", "two/a.bvh", "broken.bvh"]
    assert [row["state"] for row in rows] == ["ready", "ready", "failed"]
    assert float(rows[0]["severity"]) > float(rows[1]["severity"])
    assert rows[2]["severity"] == rows[2]["intervals"] == ""
    assert "broken.bvh" in rows[2]["reason"]


@pytest.mark.thorough
def test_the_options_of_the_batch_are_those_of_the_window(qtbot, show_window, tmp_path):
    put_errors(tmp_path / "a.bvh", 3)
    given = ["--tau", "20", "--method", "paper"]
    out = tmp_path / "out"
    assert main(["batch", str(tmp_path / "a.bvh"), "-o", str(out), "--workers", "1", *given]) == 0
    window = show_window(Settings(theme="light", turn_ms=0))
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(out)
    state = window.document.review.state
    assert state.method == "paper"
    chains = [chain.name for chain in window.document.data.chains]
    assert np.degrees([state.tau[name] for name in chains]) == pytest.approx(20.0)
    assert len(window.document.intervals) == window.queue.ordered[0].intervals
    assert "τ 20°" in window.clips.tau.text()


@pytest.mark.thorough
def test_what_the_window_cannot_do_as_the_batch_did_it_does_itself(qtbot, queue, tmp_path):
    put_errors(tmp_path / "a.bvh", 3)
    out = tmp_path / "out"
    batch = ["batch", str(tmp_path / "a.bvh"), "-o", str(out), "--workers", "1", "--fps", "60"]
    assert main(batch) == 0
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.open(out)
    assert "--fps" in queue.profile_text
    assert queue.ordered[0].state == ClipState.READY


@pytest.mark.thorough
def test_what_waits_for_a_batch_at_work_is_left_to_it(qtbot, queue, outdir):
    put_errors(outdir.parent / "two" / "a.bvh", 9)
    with (outdir / LOCK).open("r+b") as file:
        assert lock_file(file.fileno())
        queue.open(outdir)
        assert not queue.running
        assert [c.state for c in queue.ordered].count(ClipState.WAITING) == 1
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.rescan()


def test_a_rescan_keeps_what_is_known_of_a_review(queue, outdir):
    queue.open(outdir)
    worst = queue.ordered[0].path
    queue.note(worst, (2, 9))
    queue.rescan()
    assert queue.clips[worst].decided == (2, 9)
    queue.note_export(worst, worst.with_name("a_refined.bvh"))
    assert queue.clips[worst].exported == "a_refined.bvh"


def test_clips_of_one_name_are_told_apart(queue, outdir):
    queue.open(outdir)
    assert len({clip.title for clip in queue.ordered}) == 3


@pytest.mark.thorough
def test_the_report_of_a_batch_is_written_with_what_was_decided(qtbot, show_window, outdir):
    window = show_window(Settings(theme="light", turn_ms=0, reviewer="Ada"))
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(outdir)
    qtbot.waitUntil(lambda: window.document.interval is not None, timeout=10_000)
    act(window, "accept")  # not saved: the report has it all the same
    act(window, "write_report")
    index = outdir / "report" / "index.html"
    status = window.statusBar()
    qtbot.waitUntil(lambda: str(index) in status.currentMessage(), timeout=60_000)
    assert "Ada" in (outdir / "report" / "clips" / "a.bvh.html").read_text("utf-8")
