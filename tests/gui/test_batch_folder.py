"""A folder that `twistcore batch` left, as the window's queue, and decisions on their way back."""

import csv
import io

import pytest

from inspector.folder.clip_table import clip_table
from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import ClipState
from inspector.session.settings import Settings
from tests.gui.folders import put_errors
from tests.gui.windows import act
from twistcore.batch import Manifest
from twistcore.cli import main


@pytest.fixture
def outdir(tmp_path):
    """A batch of two clips in folders of their own and one that cannot be read."""
    for name, chains in (("one/a.bvh", 3), ("two/a.bvh", 1)):
        (tmp_path / name).parent.mkdir()
        put_errors(tmp_path / name, chains)
    (tmp_path / "two" / "broken.bvh").write_bytes(b"HIERARCHY\nROOT")
    clips = [str(tmp_path / name) for name in ("one", "two")]
    assert main(["batch", *clips, "-o", str(tmp_path / "out"), "--workers", "1"]) == 1
    return tmp_path / "out"


@pytest.fixture
def queue(qtbot):
    queue = FolderQueue(workers=1)
    yield queue
    queue.close()
    queue.deleteLater()
    qtbot.wait(20)


def test_what_the_batch_found_is_listed_without_another_look(queue, outdir):
    queue.open(outdir)
    assert not queue.running
    worst, other, broken = queue.ordered
    assert [c.path.parent.name for c in (worst, other)] == ["one", "two"]
    assert worst.severity > other.severity > 0.0
    assert worst.intervals >= 3
    assert broken.state == ClipState.FAILED
    assert "broken.bvh" in broken.reason


def test_a_clip_that_changed_since_is_analysed_again(qtbot, queue, outdir, tmp_path):
    before = {c.path: c.severity for c in (queue.open(outdir), *queue.ordered)[1:]}
    changed = tmp_path / "two" / "a.bvh"
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
    assert [row["clip"] for row in rows] == ["a.bvh", "a.bvh", "broken.bvh"]
    assert [row["state"] for row in rows] == ["ready", "ready", "failed"]
    assert float(rows[0]["severity_deg"]) > float(rows[1]["severity_deg"])
    assert rows[2]["severity_deg"] == rows[2]["intervals"] == ""
    assert "broken.bvh" in rows[2]["reason"]
