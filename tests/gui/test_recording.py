"""Films and pictures: they play back, nothing half-written is left, the window stays usable."""

import os
import subprocess

import imageio_ffmpeg
import numpy as np
import pytest
from PySide6.QtCore import QTimer

from inspector.recording.choice import FPS, RecordChoice, shots
from inspector.recording.film import FilmWriter
from inspector.recording.record_dialog import RecordDialog
from tests.conftest import ASSETS
from tests.gui.windows import act

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


def test_five_seconds_play_back(qtbot, window, tmp_path):
    choice = RecordChoice(tmp_path / "five.mp4", 0, 300, 0.5, SIZE)
    assert made(qtbot, window, choice) == "five.mp4 written."
    pictures, seconds = frames_of(choice.path)
    assert pictures.shape == (150, SIZE[1], SIZE[0], 3)
    assert seconds == pytest.approx(5.0, abs=0.05)
    steps = np.abs(np.diff(pictures[::10].astype(int), axis=0)).mean(axis=(1, 2, 3))
    assert steps.min() > 0.05  # it moves, all the time
    assert [p.name for p in tmp_path.glob("*five*")] == ["five.mp4"]
    assert [p.name for p in tmp_path.glob(".*part*")] == []


def test_a_gif_shows_the_gizmo_while_the_lesson_is_on(qtbot, window, tmp_path):
    act(window, "show_teaching")
    qtbot.waitUntil(lambda: window.teaching.typesetter.done, timeout=30_000)
    choice = RecordChoice(tmp_path / "few.gif", 90, 122, 1.0, SIZE)
    made(qtbot, window, choice)
    pictures, _ = frames_of(choice.path)
    assert len(pictures) == 4
    teal = np.abs(pictures[0].astype(int) - [0x4E, 0xCD, 0xC4]).max(axis=2) < 40
    assert teal.sum() > 30


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


def test_cancel_and_close_leave_nothing(qtbot, window, tmp_path):
    for end in (window.recorder.cancel, window.close):
        window.record_actions.record(RecordChoice(tmp_path / "b.mp4", 0, 300, 0.1, SIZE))
        qtbot.wait(150)
        assert window.recorder.running
        end()
        assert not window.recorder.running
        qtbot.wait(20)
        assert [p.name for p in tmp_path.iterdir() if p.suffix == ".mp4"] == []


def test_what_cannot_be_written_is_told_in_a_sentence(qtbot, window, tmp_path):
    told = made(qtbot, window, RecordChoice(tmp_path / "none" / "c.mp4", 0, 20, 1.0, SIZE))
    assert "not written" in told
    window.record_actions.record(RecordChoice(tmp_path / "none" / "c.png", size=SIZE))
    assert "not written" in window.bar.label.text()
    there = tmp_path / "there.png"
    there.write_bytes(b"mine")
    window.record_actions.record(RecordChoice(there, size=SIZE))
    assert "there is such a file" in window.bar.label.text()
    assert there.read_bytes() == b"mine"


def test_frames_of_a_film_keep_time():
    real = RecordChoice(ASSETS / "x.mp4", 10, 130, 1.0)
    assert [s.frame for s in shots(real, 120.0, 0)] == list(range(10, 130, 4))
    slow = RecordChoice(ASSETS / "x.mp4", 0, 12, 0.1)
    frames = [s.frame for s in shots(slow, 120.0, 0)]
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
    assert "pictures" in dialog.length.text()
    dialog.format.setCurrentIndex(3)
    assert dialog.choice().path.suffix == ".svg"
    assert not dialog.speed.isVisible()
    dialog.path.setText("name")
    assert dialog.choice().path.name == "name.svg"


def test_a_writer_whose_ffmpeg_fails_ends_and_says_so(tmp_path):
    writer = FilmWriter(tmp_path / "none" / "x.mp4", (64, 64), 30.0)
    for _ in range(3):
        writer.offer(bytes(64 * 64 * 3))
    writer.finish()
    with pytest.raises(OSError, match="No such file"):
        writer.keep()


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


@pytest.mark.skipif(os.name != "posix", reason="no FIFOs")
def test_a_film_into_a_fifo_is_refused_and_said(qtbot, window, tmp_path):
    os.mkfifo(tmp_path / "film.mp4")
    window.record_actions.record(RecordChoice(tmp_path / "film.mp4", 0, 5, replace=True))
    assert not window.recorder.running
    assert window.bar.label.text().endswith("not written (is no file, and a film needs one).")
    assert (tmp_path / "film.mp4").is_fifo()
