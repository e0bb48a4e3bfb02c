"""The witness video beside the 3D view: the right picture, held and released, kept for its clip."""

import contextlib
import random
import shutil
import sys
import threading
import time
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QMimeData, QPointF, Qt, QUrl
from PySide6.QtGui import QDropEvent, QImage

from inspector.session.settings import Settings, load_settings
from inspector.video.remembered_videos import VIDEOS
from inspector.video.video_panel import AFTER, BEFORE, NO_VIDEO
from inspector.video.video_reader import VideoError, VideoReader
from tests.conftest import ASSETS
from tests.gui.windows import act, close_window, open_clip
from tests.tiers import parametrize
from tests.videos import number_in, write_video

FPS = 25
FRAMES = 60


@pytest.fixture
def clip(tmp_path):
    """A walk of 344 frames at 120 Hz."""
    return Path(shutil.copy(ASSETS / "walk.bvh", tmp_path))


@pytest.fixture
def movie(tmp_path):
    return write_video(tmp_path / "witness.mp4", FRAMES, FPS)


@pytest.fixture
def show_clip(qtbot, show_window, clip, tmp_path):
    """Opens the program with a clip."""

    def show(settings=None, path=clip):
        # Software draws it: small is quick.
        window = show_window(settings, tmp_path / "settings.json", size=(1000, 700))
        open_clip(qtbot, window, path)
        return window

    return show


@pytest.fixture
def window(qtbot, show_clip, movie):
    window = show_clip()
    window.video_actions.show_video(movie)
    settle(qtbot, window)
    return window


def settle(qtbot, window):
    """Let the decoder come to rest."""
    qtbot.waitUntil(lambda: not window.video.busy)


def shown(qtbot, window):
    """The number of the video's frame on the screen, None without a picture."""
    settle(qtbot, window)
    return number_in(window.video.shown.pixels) if window.video.shown else None


def expected(window, fps=FPS):
    seconds = window.document.frame / 120 + window.video.offset.value()
    return int(np.floor((seconds + 0.0005) * fps))


def files_open(path):
    """How often this process has a file open; Linux tells."""
    links = []
    for entry in Path("/proc/self/fd").iterdir():
        try:
            links.append(str(entry.readlink()))
        except OSError:
            continue  # closed meanwhile
    return links.count(str(path))


@pytest.mark.thorough
def test_the_picture_belongs_to_the_frame_at_any_offset(qtbot, show_clip, tmp_path):
    window = show_clip()
    for fps in (25, 30):
        window.video_actions.show_video(write_video(tmp_path / f"{fps}.mp4", 120, fps))
        settle(qtbot, window)
        draw = random.Random(fps)
        seen = set()
        for _ in range(20):
            window.document.go_to(draw.randrange(window.document.frames))
            window.video.offset.setValue(draw.uniform(0.0, 120 / fps - 344 / 120))
            seen.add(number := shown(qtbot, window))
            assert number == expected(window, fps)
        assert len(seen) > 10
    # Frame by frame and back: 4 of them to a picture, without gap or overlap.
    window.video.offset.setValue(0.0)
    for frame in (*range(0, 26), *range(26, 0, -5)):
        window.document.go_to(frame)
        assert shown(qtbot, window) == frame // 4


@pytest.mark.thorough
def test_the_screen_shows_what_was_decoded_in_its_aspect(qtbot, window):
    window.document.go_to(120)
    assert shown(qtbot, window) == 25
    screen = window.video.display
    grabbed = screen.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    lines = np.frombuffer(grabbed.constBits(), np.uint8).reshape(grabbed.height(), -1)
    pixels = lines[:, : 3 * grabbed.width()].reshape(grabbed.height(), grabbed.width(), 3)
    rect = screen.picture_rect()
    assert rect.width() / rect.height() == pytest.approx(160 / 96, rel=0.01)
    assert rect.width() == pytest.approx(screen.width()) or rect.height() == pytest.approx(
        screen.height()
    )
    scale = grabbed.width() / screen.width()
    left, top, right, bottom = (round(scale * n) for n in rect.getCoords())
    assert number_in(pixels[top:bottom, left:right]) == 25
    bars = [pixels[:top], pixels[bottom:], pixels[:, :left], pixels[:, right:]]
    assert all((bar == 255).all() for bar in bars)  # the light theme's surface
    assert sum(bar.size for bar in bars) > 0


def test_hold_move_release_sets_the_offset(qtbot, window):
    window.document.go_to(60)
    before = shown(qtbot, window)
    hold = window.actions_by_id["hold_video"]
    hold.trigger()
    for frame in (70, 100, 240, 200):
        window.document.go_to(frame)
        assert shown(qtbot, window) == before
    assert not window.video.offset.isEnabled()
    qtbot.mouseClick(window.video.forth, Qt.MouseButton.LeftButton)
    assert shown(qtbot, window) == before + 1
    hold.trigger()
    assert shown(qtbot, window) == before + 1
    exactly = 60 / 120 + 1 / FPS - 200 / 120
    assert window.video.offset.value() == pytest.approx(exactly, abs=0.0006)
    window.document.go_to(212)  # a tenth of a second on: two frames and a half
    assert shown(qtbot, window) == expected(window)
    assert shown(qtbot, window) > before + 2


@pytest.mark.thorough
def test_arrows_step_by_one_picture_of_the_video(qtbot, window):
    window.document.go_to(100)
    start = shown(qtbot, window)
    for step in (1, 2, 3):
        qtbot.mouseClick(window.video.forth, Qt.MouseButton.LeftButton)
        assert shown(qtbot, window) == start + step
    for step in (2, 1, 0, -1):
        qtbot.mouseClick(window.video.back, Qt.MouseButton.LeftButton)
        assert shown(qtbot, window) == start + step
    assert window.video.offset.value() == pytest.approx(-1 / FPS, abs=0.0006)


@pytest.mark.thorough
def test_outside_its_range_the_video_says_so(qtbot, window):
    assert shown(qtbot, window) == 0
    window.video.offset.setValue(-0.5)
    assert shown(qtbot, window) is None
    assert window.video.display.text == BEFORE
    window.document.go_to(60)
    assert shown(qtbot, window) == 0
    window.document.go_to(343)
    window.video.offset.setValue(0.0)
    assert shown(qtbot, window) is None
    assert window.video.display.text == AFTER
    window.document.go_to(287)  # 2.392 s: the last of the 60 frames lasts until 2.4 s
    assert shown(qtbot, window) == FRAMES - 1
    window.document.go_to(288)
    assert shown(qtbot, window) is None


@pytest.mark.thorough
def test_video_and_offset_come_back_with_their_clip(qtbot, show_clip, clip, movie, tmp_path):
    window = show_clip()
    other = Path(shutil.copy(clip, tmp_path / "other.bvh"))
    window.video_actions.show_video(movie)
    settle(qtbot, window)
    window.video.offset.setValue(0.32)
    open_clip(qtbot, window, other)
    settle(qtbot, window)
    assert window.video.display.text == NO_VIDEO
    assert not window.actions_by_id["hold_video"].isEnabled()
    close_window(qtbot, window)
    settings, complaint = load_settings(tmp_path / "settings.json")
    assert complaint == ""
    again = show_clip(settings, tmp_path / "walk.bvh")
    settle(qtbot, again)
    assert again.docks["video"].isVisible()
    assert again.video.offset.value() == pytest.approx(0.32)
    assert shown(qtbot, again) == 8
    act(again, "close_video")
    open_clip(qtbot, again, tmp_path / "walk.bvh")
    assert again.video.reader is None
    assert VIDEOS.of(again.settings) == {}


@pytest.mark.parametrize("videos", ['{"a": 3}', '{"a": ["b"]}', '{"a": ["b", NaN]}', "[]"])
def test_a_damaged_video_is_left_out_of_the_settings(tmp_path, videos):
    path = tmp_path / "settings.json"
    path.write_text(f'{{"theme": "dark", "videos": {videos}}}')
    settings, complaint = load_settings(path)
    assert settings == Settings(theme="dark")
    assert "damaged" in complaint


@pytest.mark.thorough
def test_a_video_that_is_gone_is_told_in_its_place_only(qtbot, show_clip, movie):
    window = show_clip()
    window.video_actions.show_video(movie)
    settle(qtbot, window)
    window.video.offset.setValue(0.25)
    path = window.document.data.clip.path
    movie.unlink()
    open_clip(qtbot, window, path)
    settle(qtbot, window)
    assert window.video.display.text == f"The video witness.mp4 is no longer in {movie.parent}."
    assert not window.bar.isVisible()
    assert list(VIDEOS.of(window.settings).values()) == [(str(movie), 0.25)]  # it may come back
    assert window.document.frames == 344


@pytest.mark.thorough
def test_a_broken_video_is_one_sentence_and_the_old_one_stays(qtbot, window, movie, tmp_path):
    data = movie.read_bytes()
    for number, content in enumerate((b"", b"not a video" * 100, data[: len(data) // 2])):
        broken = tmp_path / f"broken{number}.mp4"
        broken.write_bytes(content)
        window.video_actions.show_video(broken)
        settle(qtbot, window)
        sentence = window.bar.label.text()
        assert sentence.startswith(f"{broken}: this file cannot be played as a video")
        assert window.video.reader.path == movie
    window.document.go_to(120)
    assert shown(qtbot, window) == 25


def test_a_file_with_sound_only_has_no_picture(tmp_path):
    import wave

    with wave.open(str(tmp_path / "sound.wav"), "wb") as sound:
        sound.setparams((1, 2, 8000, 0, "NONE", "not compressed"))
        sound.writeframes(bytes(16_000))
    with pytest.raises(VideoError, match="this file has no video stream"):
        VideoReader(tmp_path / "sound.wav")


@pytest.mark.thorough
def test_without_pyav_the_action_names_the_extra(qtbot, show_clip, movie, monkeypatch):
    window = show_clip()
    monkeypatch.setitem(sys.modules, "av", None)
    act(window, "open_video")
    assert "pip install 'twist-inspector[video]'" in window.bar.label.text()
    window.bar.hide()
    window.video_actions.show_video(movie)
    assert "pip install 'twist-inspector[video]'" in window.bar.label.text()
    assert not window.docks["video"].isVisible()


@pytest.mark.thorough
def test_a_video_dropped_on_the_window_opens_beside_the_clip(qtbot, show_clip, movie):
    window = show_clip()
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(movie))])
    button, key = Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier
    window.dropEvent(QDropEvent(QPointF(5, 5), Qt.DropAction.CopyAction, data, button, key))
    settle(qtbot, window)
    assert window.video.reader.path == movie
    assert window.document.data.clip.name == "walk.bvh"
    assert window.docks["video"].isVisible()


@pytest.mark.thorough
def test_closing_lets_the_file_go(qtbot, window, movie):
    assert files_open(movie) == (1 if sys.platform == "linux" else 0)
    window.document.go_to(200)  # closed while a picture is being decoded
    act(window, "close_video")
    assert VIDEOS.of(window.settings) == {}
    qtbot.waitUntil(lambda: files_open(movie) == 0, timeout=3000)
    assert window.video.display.text == NO_VIDEO


@pytest.mark.thorough
def test_playing_keeps_real_time_beside_a_decoder_that_is_slow(qtbot, window, monkeypatch):
    reader, document = window.video.reader, window.document
    decode, asked, go_on = reader.picture, [], threading.Event()

    def slow(seconds, width, height):
        asked.append(seconds)
        go_on.wait()
        return decode(seconds, width, height)

    monkeypatch.setattr(reader, "picture", slow)
    frames, off = [], []

    def passed():
        frames.append(document.frame)
        if frames == sorted(frames):  # until the clip starts over
            off.append(abs(document.frame / 120 - (time.perf_counter() - begun)))

    try:
        begun = time.perf_counter()
        act(window, "toggle_play")
        document.frame_changed.connect(passed)
        qtbot.waitUntil(lambda: len(frames) > 10)
        act(window, "toggle_play")
        assert np.median(off) < 0.2
        assert len(asked) == 1  # and that picture is not there yet
    finally:
        go_on.set()
    assert shown(qtbot, window) == expected(window)
    assert len(asked) == 2  # pictures were dropped


@pytest.mark.thorough
def test_out_of_sight_nothing_is_decoded(qtbot, window, monkeypatch):
    window.docks["video"].hide()
    before = window.video.shown
    window.document.go_to(200)
    settle(qtbot, window)
    assert window.video.shown is before
    window.docks["video"].show()
    assert shown(qtbot, window) == expected(window)


@pytest.mark.parametrize(
    ("name", "codec", "rate"),
    [
        ("a.avi", "mpeg4", 30),
        ("a.avi", "mjpeg", 25),
        ("a.mkv", "mpeg4", Fraction(30000, 1001)),
        ("a.mpg", "mpeg2video", 25),
        ("a.ts", "mpeg2video", 25),
    ],
)
def test_any_container_gives_the_exact_picture(tmp_path, name, codec, rate):
    reader = VideoReader(write_video(tmp_path / name, 150, rate, codec))
    draw = random.Random(7)
    asked = [draw.randrange(150) for _ in range(30)]
    asked += [*range(40, 90), *range(90, 40, -1)]
    for number in asked:
        picture = reader.picture((number + draw.choice([0.0, 0.5, 0.9])) / float(rate), 160, 96)
        assert number_in(picture.pixels) == number
    assert reader.picture(150 / float(rate) + 0.01, 160, 96) is None
    assert reader.end == pytest.approx(150 / float(rate), abs=0.002)
    reader.close()


def test_time_stamps_decide_where_the_rate_varies(tmp_path):
    times = np.cumsum(np.random.default_rng(3).integers(8, 90, 80)).tolist()
    reader = VideoReader(write_video(tmp_path / "phone.mkv", 80, 30, times=times))
    starts = np.array(times) - times[0]
    for seconds in np.random.default_rng(4).uniform(0.0, starts[-1] / 1000, 40):
        number = int(np.searchsorted(starts / 1000, seconds + 0.0005, side="right")) - 1
        assert number_in(reader.picture(seconds, 160, 96).pixels) == number
    reader.close()


@parametrize("name", ["a.mkv", "a.avi", "a.ts"])
def test_damage_in_the_middle_is_a_sentence_or_leaves_the_rest(tmp_path, name):
    codec = "mpeg2video" if name == "a.ts" else "mpeg4"
    whole = write_video(tmp_path / name, 60, 25, codec).read_bytes()
    draw = random.Random(11)
    pictures = 0
    for trial in range(34):
        damaged = bytearray(whole[: draw.randrange(len(whole))] if trial % 4 == 0 else whole)
        for _ in range(draw.randrange(60)):
            damaged[draw.randrange(len(damaged))] = draw.randrange(256)
        path = tmp_path / f"{trial}{name}"
        path.write_bytes(damaged)
        with contextlib.suppress(VideoError):  # anything else is a failure
            reader = VideoReader(path)
            found = [reader.picture(draw.uniform(0, 2.6), 160, 96) for _ in range(6)]
            pictures += sum(p is not None for p in found)
            reader.close()
    assert pictures > 25


def test_playing_on_and_stepping_back_need_no_seek(tmp_path):
    reader = VideoReader(write_video(tmp_path / "long.mp4", 200, 25))
    for number in (*range(100), *range(99, 60, -1)):
        reader.picture(number / 25, 160, 96)
    assert reader.seeks == 0
    reader.close()


def test_a_turned_video_stands_upright(tmp_path):
    reader = VideoReader(write_video(tmp_path / "turned.mp4", 12, 25, degrees=90))
    pixels = reader.picture(5 / 25, 1000, 1000).pixels
    assert pixels.shape == (160, 96, 3)
    assert (reader.width, reader.height) == (96, 160)
    assert number_in(np.rot90(pixels, -1)) == 5
    reader.close()


def test_a_large_picture_comes_in_the_size_of_the_screen(tmp_path):
    reader = VideoReader(write_video(tmp_path / "large.mp4", 3, 25, size=(640, 360)))
    assert reader.picture(1 / 25, 320, 320).pixels.shape == (180, 320, 3)
    assert reader.picture(1 / 25, 5000, 5000).pixels.shape == (360, 640, 3)
    reader.close()
