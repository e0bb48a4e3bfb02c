"""The queue: worst first, bad clips marked and passed over, the window free all the while."""

import os
import shutil
import signal
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QElapsedTimer, QPoint, Qt, QTimer
from PySide6.QtGui import QColor

from inspector.folder.clips_panel import ClipsPanel
from inspector.folder.informative_intervals import InformativeIntervals
from inspector.folder.queue import FolderQueue
from inspector.folder.queued_clip import ClipState, QueuedClip
from inspector.session.document import Document
from inspector.session.export_files import ExportChoice
from inspector.session.settings import Settings
from inspector.widgets.theme import LIGHT, Colours
from tests.conftest import ASSETS
from tests.gui.folders import put_errors, two_takes
from tests.gui.windows import act, export, open_clip
from twistcore.export.exported_clips import find_exports_and_their_sources


def test_the_worst_comes_first_and_the_bad_are_marked(qtbot, queue, tmp_path):
    truth = {f"{k}.bvh": put_errors(tmp_path / f"{k}.bvh", k) for k in (1, 3, 6, 9)}
    shutil.copy(ASSETS / "walk.bvh", tmp_path / "clean.bvh")
    (tmp_path / "broken.bvh").write_bytes(b"HIERARCHY\nROOT")
    (tmp_path / "empty.bvh").write_bytes(b"")
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.open(tmp_path)
    names = [c.path.name for c in queue.ordered]
    assert names[:4] == sorted(truth, key=truth.get, reverse=True)
    assert names[4] == "clean.bvh"
    assert set(names[5:]) == {"broken.bvh", "empty.bvh"}
    for clip in queue.ordered[5:]:
        assert clip.state == ClipState.FAILED
        assert clip.path.name in clip.reason
    for clip in queue.ordered[:4]:
        assert clip.severity == pytest.approx(truth[clip.path.name], rel=0.05)
    assert queue.progress == (7, 7)


@pytest.mark.thorough
def test_a_clip_that_hangs_or_eats_memory_takes_only_itself_down(
    qtbot, queue, tmp_path, monkeypatch
):
    for k in (1, 2, 3):
        put_errors(tmp_path / f"{k}.bvh", k)
    monkeypatch.setattr("inspector.folder.queue._PATIENCE_S", 0.0)
    if sys.platform == "win32":
        pytest.skip("no process can be stopped")
    put_errors(tmp_path / "0_hangs.bvh", 0)
    monkeypatch.setattr("inspector.folder.queue._PATIENCE_S", 8.0)  # of a busy machine
    queue.open(tmp_path)
    # It goes no further, as with a file of a drive that is gone.
    (hangs,) = [w for w in queue._workers if w.path == tmp_path / "0_hangs.bvh"]
    os.kill(hangs.process.pid, signal.SIGSTOP)
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        pass
    states = {c.path.name: c for c in queue.ordered}
    assert "too long" in states["0_hangs.bvh"].reason
    assert all(states[f"{k}.bvh"].state == ClipState.READY for k in (1, 2, 3))


@pytest.mark.thorough
def test_a_worker_that_is_killed_is_replaced(qtbot, queue, tmp_path):
    for k in range(1, 7):
        put_errors(tmp_path / f"{k}.bvh", k)
    queue.open(tmp_path)
    qtbot.waitUntil(lambda: any(w.path is not None for w in queue._workers), timeout=10_000)
    victim = queue._workers[0]
    path = victim.path
    victim.process.kill()
    qtbot.waitUntil(lambda: not queue.running, timeout=60_000)
    failed = [c for c in queue.ordered if c.state == ClipState.FAILED]
    assert [c.path for c in failed] == [path]
    assert "memory" in failed[0].reason


@pytest.mark.thorough
def test_new_clips_are_taken_up_and_vanished_ones_marked(qtbot, queue, tmp_path):
    put_errors(tmp_path / "1.bvh", 1)
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        queue.open(tmp_path)
    with qtbot.waitSignal(queue.finished, timeout=60_000):
        put_errors(tmp_path / "2.bvh", 4)
    assert [c.path.name for c in queue.ordered] == ["2.bvh", "1.bvh"]
    (tmp_path / "1.bvh").unlink()
    qtbot.waitUntil(lambda: queue.clips[tmp_path / "1.bvh"].reason != "", timeout=10_000)
    assert "no longer" in queue.clips[tmp_path / "1.bvh"].reason


@pytest.mark.thorough
def test_the_window_stays_free_while_clips_are_analysed(qtbot, show_window, tmp_path):
    """Not a timed test of speed: a stall of half a second would mean work in the GUI thread."""
    for k in range(8):
        put_errors(tmp_path / f"{k}.bvh", 1 + k)
    window = show_window()
    longest, clock, timer = [0], QElapsedTimer(), QTimer()

    def tick():
        longest[0] = max(longest[0], clock.restart())

    clock.start()
    timer.timeout.connect(tick)
    timer.start(5)
    with qtbot.waitSignal(window.queue.finished, timeout=60_000):
        window.queue.open(tmp_path)
    timer.stop()
    assert longest[0] < 500


@pytest.mark.thorough
def test_exports_are_no_clips_and_tell_what_was_exported(qtbot, show_window, tmp_path):
    """By the session that replays one, by its report, or by the name that it has by default."""
    window = show_window(Settings(turn_ms=0, of_features={"next_after_export": False}))
    for k in (2, 4):
        put_errors(tmp_path / f"{k}.bvh", k)
    shutil.copy(ASSETS / "walk.bvh", tmp_path / "alone_refined.bvh")  # of no clip here
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(tmp_path)
    clip = window.document.data.clip.path
    other = next(p for p in window.queue.clips if p not in (clip, tmp_path / "alone_refined.bvh"))
    assert not window.queue.clips[clip].exported
    names = {"one.bvh": {"report": False}, "two.bvh": {"session": False}, "three.bvh": {}}
    for name, words in names.items():
        export(window, ExportChoice(tmp_path / name, **words))
    shutil.copy(other, other.with_name(f"{other.stem}_refined.bvh"))
    queue = FolderQueue(workers=1)
    queue.open(tmp_path)
    found = {p.name: c.exported for p, c in queue.clips.items()}
    queue.close()
    wanted = {clip.name: "three.bvh", other.name: f"{other.stem}_refined.bvh"}
    assert found == {**wanted, "alone_refined.bvh": ""}
    assert {p.name for p in queue.exports} == {*names, f"{other.stem}_refined.bvh"}
    for name in ("two.report.html", "three.report.html"):  # one each
        assert (tmp_path / name).exists()
    queue.deleteLater()


def test_next_goes_down_the_list_and_round_it(queue, tmp_path):
    def known(name, severity, **more):
        path = tmp_path / name
        queue.clips[path] = QueuedClip(path, ClipState.READY, severity, **more)
        return path

    a, b = known("a", 3.0, intervals=2), known("b", 2.0, intervals=2, decided=(2, 2))
    c, d = known("c", 1.0, intervals=1), known("d", 0.0)
    nothing = known("e", 0.0, unchecked=True)
    cut = known("g", 0.0, missing=286)
    partly = known("h", 0.0, unexamined=2)
    assert [queue.next_after(p) for p in (None, a, b, c, d, nothing)] == [a, c, c, a, a, a]
    assert queue.totals == (1, 3, 2, 5), "clips with nothing to decide are not among those decided"
    failed = known("f", -1.0)
    queue.clips[failed] = replace(queue.clips[failed], state=ClipState.FAILED)
    document = Document()
    informative = InformativeIntervals(queue, document)
    panel = ClipsPanel(queue, document, Colours(LIGHT), informative)
    printed = (
        "1 of 3 clips done, 2 of 5 intervals decided; 1 clean; 1 partly checked; 1 truncated; "
    )
    printed += "1 not checked; 1 failed"
    assert panel.status.text() == printed
    queue.clips[b] = replace(queue.clips[b], waits=True)  # decisions of it are to be restored first
    queue.changed.emit()
    assert panel.status.text() == printed.replace("1 of 3", "0 of 3")
    for clip, state, printed in (
        (cut, "truncated", "286 frames are missing"),
        (partly, "partly checked", "2 arms and legs were not examined"),
    ):
        (thing,) = [one for one in panel._model.things if one.path == clip]
        shown = panel._model.describe(thing)
        assert shown.texts[2] == state
        assert printed in shown.tips[0]
    panel.deleteLater()
    assert [queue.clips[p].clean for p in (a, b, c, d, nothing, cut, partly)] == [
        *[False] * 3, True, *[False] * 3
    ]  # fmt: skip


def test_the_list_sorts_and_filters(qtbot, show_window, tmp_path):
    window = show_window()
    for name, bad, more in (
        ("a", 1.0, {"intervals": 4, "decided": (4, 4)}),
        ("b", 3.0, {"intervals": 2}),
        ("ab", 0.0, {}),
    ):
        path = tmp_path / f"{name}.bvh"
        window.queue.clips[path] = QueuedClip(path, ClipState.READY, bad, **more)
    window.queue.changed.emit()
    panel = window.clips
    header = panel.table.horizontalHeader()

    def shown():
        model = panel.table.model()
        return [model.index(k, 0).data() for k in range(model.rowCount())]

    def click(column):
        place = QPoint(header.sectionViewportPosition(column) + 10, header.height() // 2)
        qtbot.mouseClick(header.viewport(), Qt.MouseButton.LeftButton, pos=place)

    assert shown() == ["b", "a", "ab"]
    orders = []
    for _ in range(3):
        click(0)
        orders.append(shown())
    assert orders == [["a", "ab", "b"], ["b", "ab", "a"], ["b", "a", "ab"]]
    panel.text.setText("A")
    assert shown() == ["a", "ab"]
    panel.wanted.setCurrentText("Clean")
    assert shown() == ["ab"]
    panel.text.clear()
    panel.wanted.setCurrentText("To do")
    assert shown() == ["b"]


def test_only_an_export_of_a_clip_here_is_left_out(tmp_path):
    own, source = tmp_path / "a_refined.bvh", tmp_path / "a.bvh"
    shutil.copy(ASSETS / "walk.bvh", source)
    own.write_bytes(source.read_bytes().replace(b"\t", b"  ", 1))  # by another program
    far = Path(shutil.copy(source, tmp_path / "far.bvh"))
    far.with_suffix(".replay.json").write_text('{"clip": "elsewhere.bvh"}')
    assert own.read_bytes() != source.read_bytes()
    assert find_exports_and_their_sources([source, own, far]) == {}
    shutil.copy(source, own)
    assert find_exports_and_their_sources([source, own, far]) == {own: "a.bvh"}


@pytest.mark.thorough
def test_a_clip_is_one_of_the_folder_however_it_is_named(qtbot, show_window, tmp_path):
    (tmp_path / "takes").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "takes")
    shutil.copy(ASSETS / "walk_injected.bvh", tmp_path / "takes" / "a.bvh")
    window = show_window()
    with qtbot.waitSignal(window.document.opened, timeout=60_000):
        window.open_path(tmp_path / "link")
    open_clip(qtbot, window, window.settings.recent[0])
    act(window, "next_interval")
    act(window, "accept")
    clip = tmp_path / "link" / "a.bvh"
    qtbot.waitUntil(lambda: window.queue.clips[clip].counts[0] == 1, timeout=5000)


@pytest.mark.thorough
def test_a_double_click_opens_a_clip_once(qtbot, show_window, tmp_path):
    window = two_takes(qtbot, show_window, tmp_path)
    chosen, table = [], window.clips.table
    window.clips.chosen.connect(chosen.append)
    at = table.visualRect(table.model().index(1, 0)).center()
    with qtbot.waitSignal(window.document.opened, timeout=20_000):
        qtbot.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
        qtbot.mouseDClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    assert chosen == [window.document.data.clip.path]


@pytest.mark.thorough
def test_the_counts_are_wrapped_in_a_narrow_panel(qtbot, queue, tmp_path):
    document = Document()
    panel = ClipsPanel(queue, document, Colours(LIGHT), InformativeIntervals(queue, document))
    qtbot.addWidget(panel)
    panel.status.setText("0 of 3 clips done, 0 of 33 intervals decided; 1 clean; 1 failed")
    panel.resize(230, 300)
    panel.show()
    qtbot.waitExposed(panel)
    status = panel.status
    line = status.fontMetrics().height()
    assert status.width() < status.fontMetrics().horizontalAdvance(status.text())
    qtbot.waitUntil(lambda: status.height() >= status.heightForWidth(status.width()) > line)


def test_the_bar_of_the_severity_is_below_its_digits(qtbot, queue, tmp_path):
    document = Document()
    for name, severity in (("a", 88.8), ("b", 2.8)):
        path = tmp_path / name
        queue.clips[path] = QueuedClip(path, ClipState.READY, severity, intervals=2)
    panel = ClipsPanel(queue, document, Colours(LIGHT), InformativeIntervals(queue, document))
    qtbot.addWidget(panel)
    panel.resize(400, 300)
    panel.show()
    qtbot.waitExposed(panel)
    table = panel.table
    image = table.viewport().grab(table.visualRect(table.model().index(1, 1))).toImage()
    bar, paper = QColor(LIGHT.before).rgb(), image.pixel(1, 1)
    rows, right = range(image.height()), range(image.width() // 2, image.width() - 1)
    barred = [y for y in rows if image.pixel(6, y) == bar]
    inked = [y for y in rows if any(image.pixel(x, y) != paper for x in right)]
    assert barred
    assert inked
    assert min(barred) > max(inked) + 1  # with a gap
