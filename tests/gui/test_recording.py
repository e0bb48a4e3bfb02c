"""Films and pictures: they play back, nothing half-written is left, the window stays usable."""

import os
import subprocess
import sys
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PySide6.QtCore import QSize, QTimer

from inspector.recording.choice import FPS, Contents, Paper, RecordChoice, film_shots
from inspector.recording.figure_file import figure_file
from inspector.recording.film import FilmWriter
from inspector.recording.record_dialog import RecordDialog
from inspector.recording.sheet import Sheet
from inspector.recording.sweep import SWEPT, Sweep
from tests.conftest import ASSETS
from tests.gui.windows import act
from twistcore.analysis.decomposition import WhatIf

ONE_WINDOW = True

SIZE = (640, 360)


@pytest.fixture
def window(at_forearm):
    return at_forearm


def made(qtbot, window, choice):
    window.record_actions.record(choice)
    qtbot.waitUntil(lambda: not window.recorder.running, timeout=120_000)
    return window.bar.label.text()


def frames_of(path):
    """Frames (n, height, width, 3) of a film, and its seconds, as ffmpeg plays it."""
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    play = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-i", str(path)]
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    done = subprocess.run([*play, *raw], capture_output=True, check=True)
    assert done.stderr == b""
    pictures = np.frombuffer(done.stdout, np.uint8).reshape(-1, SIZE[1], SIZE[0], 3)
    assert len(pictures) == count
    return pictures, seconds


@pytest.mark.thorough
def test_five_seconds_play_back(qtbot, window, tmp_path):
    choice = RecordChoice(tmp_path / "five.mp4", 0, 300, 0.5, SIZE)
    assert made(qtbot, window, choice) == "five.mp4 was written."
    pictures, seconds = frames_of(choice.path)
    assert pictures.shape == (150, SIZE[1], SIZE[0], 3)
    assert seconds == pytest.approx(5.0, abs=0.05)
    steps = np.abs(np.diff(pictures[::10].astype(int), axis=0)).mean(axis=(1, 2, 3))
    assert steps.min() > 0.05  # it moves, all the time
    assert [p.name for p in tmp_path.glob("*five*")] == ["five.mp4"]
    assert [p.name for p in tmp_path.glob(".*part*")] == []


@pytest.mark.thorough
def test_a_gif_shows_the_gizmo_while_the_lesson_is_on(qtbot, window, tmp_path):
    act(window, "show_teaching")
    qtbot.waitUntil(lambda: window.teaching.typesetter.done, timeout=30_000)
    choice = RecordChoice(tmp_path / "few.gif", 90, 122, 1.0, SIZE)
    made(qtbot, window, choice)
    pictures, _ = frames_of(choice.path)
    assert len(pictures) == 4
    teal = np.abs(pictures[0].astype(int) - [0x4E, 0xCD, 0xC4]).max(axis=2) < 40
    assert teal.sum() > 30


@pytest.mark.thorough
def test_the_window_is_usable_meanwhile_and_is_not_filmed(qtbot, window, tmp_path):
    turns = []
    timer = QTimer()
    timer.timeout.connect(lambda: turns.append(1))
    timer.start(0)
    window.record_actions.record(RecordChoice(tmp_path / "a.mp4", 0, 120, 1.0, SIZE))
    window.document.go_to(200)
    window.document.select_chain("RightArm")
    act(window, "next_interval")
    act(window, "accept")
    qtbot.waitUntil(lambda: not window.recorder.running, timeout=60_000)
    timer.stop()
    assert len(turns) >= 30  # the event loop turned between any two pictures
    assert window.document.frame != 119
    assert not window.document.review.saved  # the person's verdict stands, in their review only
    assert frames_of(tmp_path / "a.mp4")[0].shape[0] == 30


@pytest.mark.thorough
def test_cancel_and_close_leave_nothing(qtbot, window, tmp_path):
    for end in (window.recorder.cancel, window.close):
        window.record_actions.record(RecordChoice(tmp_path / "b.mp4", 0, 300, 0.1, SIZE))
        qtbot.wait(150)
        assert window.recorder.running
        end()
        assert not window.recorder.running
        qtbot.wait(20)
        assert [p.name for p in tmp_path.iterdir() if p.suffix == ".mp4"] == []


@pytest.mark.thorough
def test_what_cannot_be_written_is_told_in_a_sentence(qtbot, window, tmp_path):
    told = made(qtbot, window, RecordChoice(tmp_path / "none" / "c.mp4", 0, 20, 1.0, SIZE))
    assert "could not be written" in told
    window.record_actions.record(RecordChoice(tmp_path / "none" / "c.png", size=SIZE))
    assert "could not be written" in window.bar.label.text()
    there = tmp_path / "there.png"
    there.write_bytes(b"mine")
    window.record_actions.record(RecordChoice(there, size=SIZE))
    assert "already exists" in window.bar.label.text()
    assert there.read_bytes() == b"mine"


def test_frames_of_a_film_keep_time():
    real = RecordChoice(ASSETS / "x.mp4", 10, 130, 1.0)
    assert [s.frame for s in film_shots(real, 120.0, 0)] == list(range(10, 130, 4))
    slow = RecordChoice(ASSETS / "x.mp4", 0, 12, 0.1)
    frames = [s.frame for s in film_shots(slow, 120.0, 0)]
    assert len(frames) == round(12 / 120.0 / 0.1 * FPS[".mp4"])
    assert frames == sorted(frames)
    assert (frames[0], frames[-1]) == (0, 11)


def test_the_form_says_what_it_will_make(qtbot, window):
    act(window, "next_interval")
    dialog = RecordDialog(window.document, (10.0, 60.0), window, teaching=False)
    qtbot.addWidget(dialog)
    dialog.show()
    assert dialog.range.count() == 4
    judged = window.document.interval.interval
    assert dialog.choice().first == max(0, judged.start - 60)
    assert "images" in dialog.length.text()
    dialog.format.setCurrentIndex(3)
    assert dialog.choice().path.suffix == ".svg"
    assert not dialog.speed.isVisible()
    dialog.path.setText("name")
    assert dialog.choice().path.name == "name.svg"


def test_the_form_opens_with_the_format_that_was_recorded_last(qtbot, window, tmp_path):
    def form():
        act(window, "record_dialog")
        qtbot.waitUntil(lambda: window.findChildren(RecordDialog)[-1:] != [])
        return window.findChildren(RecordDialog)[-1]

    first = form()
    first.format.setCurrentIndex(first.format.findData(".png"))
    first.path.setText(str(tmp_path / "figure.png"))
    first.accept()
    qtbot.waitUntil(lambda: (tmp_path / "figure.png").is_file())
    again = form()
    assert again.format.currentData() == ".png"
    assert Path(again.path.text()).suffix == ".png"
    again.reject()


def test_a_writer_whose_ffmpeg_fails_ends_and_says_so(tmp_path, monkeypatch):
    with pytest.raises(FileNotFoundError):
        FilmWriter(tmp_path / "none" / "x.mp4", (64, 64), 30.0)
    fails = [sys.executable, "-c", "import sys; sys.exit('it has no room')"]
    monkeypatch.setattr("inspector.recording.film._command", lambda *_: fails)
    writer = FilmWriter(tmp_path / "x.mp4", (64, 64), 30.0)
    for _ in range(3):
        writer.offer(bytes(64 * 64 * 3))
    writer.finish()
    with pytest.raises(OSError, match="it has no room"):
        writer.keep()
    assert list(tmp_path.iterdir()) == []


def test_a_film_goes_where_a_link_leads(tmp_path):
    (tmp_path / "films").mkdir()
    film, link = tmp_path / "films" / "kept.mp4", tmp_path / "link.mp4"
    film.write_bytes(b"old")
    link.symlink_to("films/kept.mp4")
    writer = FilmWriter(link, (64, 64), 30.0)
    for _ in range(3):
        writer.offer(bytes(64 * 64 * 3))
    writer.finish()
    writer.keep()
    assert link.is_symlink()
    assert b"ftyp" in film.read_bytes()[:12]
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["films", "kept.mp4", "link.mp4"]


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="no FIFOs")
def test_a_film_into_a_fifo_is_refused_and_said(qtbot, window, tmp_path):
    os.mkfifo(tmp_path / "film.mp4")
    window.record_actions.record(RecordChoice(tmp_path / "film.mp4", 0, 5, replace=True))
    assert not window.recorder.running
    assert window.bar.label.text().endswith(
        "could not be written: a video can only be written to a regular file."
    )
    assert (tmp_path / "film.mp4").is_fifo()


# -- a slider that moves --------------------------------------------------------------------------


def test_a_sweep_shows_both_ends_and_comes_back():
    there = Sweep("twist", -90.0, 90.0, 1.0, and_back=False).values(30.0)
    assert (there[0], there[-1], len(there)) == (-90.0, 90.0, 30)
    assert np.allclose(np.diff(there), there[1] - there[0])
    back = Sweep("twist", -90.0, 90.0, 1.0).values(30.0)
    assert back == there + there[-2:0:-1]  # a film that repeats shows no picture twice


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("slider", "value", "expected"),
    [
        ("twist", 90.0, {"twist": np.pi / 2}),
        ("swing", 180.0, {"swing": np.pi}),
        ("bend", 45.0, {"bend": np.pi / 4}),
        ("nudge", -3.0, {"nudge": np.radians(-3.0)}),
        ("applied", 25.0, {"applied": 0.25}),
    ],
)
def test_every_slider_is_swept_in_its_unit(qapp, window, slider, value, expected):
    window.taught.alter(counter=True)
    Sweep(slider, 0.0, value).show(window.taught, value)
    assert vars(window.taught.what_if) == vars(WhatIf(counter=True, **expected))
    assert SWEPT[slider].low <= value <= SWEPT[slider].high


@pytest.mark.thorough
def test_stages_are_swept(window):
    Sweep("stage", 0.0, 2.0).show(window.taught, 1.5)
    assert window.taught.stage == 1.5


@pytest.mark.thorough
def test_a_film_of_a_sweep_moves_the_figure_and_not_the_persons(qtbot, window, tmp_path):
    window.taught.alter(nudge=0.01)
    mine, frame = window.taught.what_if, window.document.frame
    sweep = Sweep("twist", 0.0, 120.0, 0.5)
    contents = Contents(curves=False)
    choice = RecordChoice(tmp_path / "s.mp4", size=SIZE, contents=contents, sweep=sweep)
    window.record_actions.record(choice)  # its symbols are typeset first
    qtbot.waitUntil(lambda: window.bar.label.text() == "s.mp4 was written.", timeout=60_000)
    pictures, seconds = frames_of(choice.path)
    assert len(pictures) == len(sweep.values(30.0)) == 28
    assert seconds == pytest.approx(28 / 30, abs=0.02)
    apart = np.abs(pictures.astype(int) - pictures[0]).mean(axis=(1, 2, 3))
    assert apart[11:18].min() > apart[[1, 2, 3, -3, -2, -1]].max()  # farthest at the far end
    mirrored = np.abs(pictures[5].astype(int) - pictures[28 - 5]).mean()  # the way back
    assert mirrored < 0.3 * np.abs(pictures[5].astype(int) - pictures[14]).mean()
    assert (window.taught.what_if, window.taught.stage) == (mine, None)
    assert window.document.frame == frame
    assert not window.taught.active


@pytest.mark.thorough
def test_rows_that_do_not_apply_are_not_there(qtbot, window):
    dialog = RecordDialog(window.document, (10.0, 60.0), window, teaching=True)
    qtbot.addWidget(dialog)
    dialog.show()
    sweep, picture = dialog.sweep, dialog.picture
    assert dialog.speed.isVisible()
    assert not sweep.slider.isVisible()
    assert not picture.preset.isVisible()
    dialog.range.setCurrentIndex(dialog.range.count() - 1)
    assert sweep.slider.isVisible()
    assert not dialog.speed.isVisible()
    sweep.slider.setCurrentIndex(sweep.slider.findData("nudge"))
    sweep.first.setValue(-3.0)
    assert dialog.choice().sweep == Sweep("nudge", -3.0, 3.0)
    assert dialog.length.text().startswith("238 images, 7.9 s")
    dialog.format.setCurrentIndex(2)
    assert not sweep.slider.isVisible()
    assert dialog.choice().sweep is None
    for check in (dialog.view, dialog.curves, dialog.equations):
        check.setChecked(False)
    assert not dialog.do_it.isEnabled()


@pytest.mark.thorough
def test_a_picture_has_any_size_in_any_unit(qtbot, window):
    dialog = RecordDialog(window.document, (10.0, 60.0), window, teaching=True)
    qtbot.addWidget(dialog)
    dialog.show()
    dialog.format.setCurrentIndex(2)
    picture = dialog.picture
    assert picture.size == (2126, 0)  # 90 mm at 600 dpi, as high as needed
    assert picture.paper == Paper(600.0, 7.0, white=True)
    assert not picture.width.isVisible()
    picture.preset.setCurrentIndex(picture.preset.findText("1920 × 1080 pixels"))
    assert (picture.size, picture.paper) == ((1920, 1080), Paper(96.0, 12.0, white=False))
    assert not picture.dpi.isVisible()
    picture.preset.setCurrentIndex(picture.preset.findText("Custom size"))
    picture.width.setValue(100)
    picture.height.setValue(50)
    picture.dpi.setCurrentIndex(picture.dpi.findData(300))
    assert picture.size == (1181, 591)
    picture.unit.setCurrentText("pixels")
    assert picture.size == (1181, 591)  # the same, told otherwise
    picture.width.setValue(4000)
    assert dialog.choice().size == (4000, 591)
    assert "339 × 50 mm (4000 × 591 pixels)" in dialog.length.text()


@pytest.mark.thorough
@pytest.mark.parametrize(("dpi", "most"), [(600, 508), (300, 1016), (96, 3175)])
def test_no_picture_is_larger_than_qt_paints(qtbot, window, dpi, most):
    dialog = RecordDialog(window.document, (10.0, 60.0), window, teaching=True)
    qtbot.addWidget(dialog)
    dialog.format.setCurrentIndex(2)
    picture = dialog.picture
    picture.preset.setCurrentIndex(picture.preset.findText("Custom size"))
    picture.unit.setCurrentText("pixels")
    picture.width.setValue(20_000)
    picture.height.setValue(20_000)
    assert picture.size == (12_000, 12_000)
    picture.unit.setCurrentText("mm")
    assert picture.size == (12_000, 12_000)
    assert "At 600 dpi, each side can be at most 508 mm" in dialog.length.text()
    picture.dpi.setCurrentIndex(picture.dpi.findData(dpi))
    picture.width.setValue(12_000)
    assert picture.width.value() == most
    assert max(picture.size) <= 12_000
    picture.preset.setCurrentIndex(0)
    assert picture.size == (2126, 0)
    assert "at most" not in dialog.length.text()


@pytest.mark.parametrize("size", [(200_000, 200_000), (40_000, 10)])
def test_a_picture_that_qt_cannot_hold_is_no_empty_file(size, qapp):
    with pytest.raises(OSError, match="is too large"):
        figure_file(Sheet(20.0, 10.0, 96), ".png", "x", QSize(*size), 600.0)


@pytest.mark.thorough
def test_of_a_whole_limb_nothing_is_taught(qtbot, window):
    limb = window.document.data.analysis.limbs[0]
    window.document.select_chain(limb.name)
    dialog = RecordDialog(window.document, (10.0, 60.0), window, teaching=True)
    qtbot.addWidget(dialog)
    assert not dialog.equations.isEnabled()
    assert not dialog.choice().contents.equations
    spans = [dialog.range.itemData(k) for k in range(dialog.range.count())]
    assert None not in spans
