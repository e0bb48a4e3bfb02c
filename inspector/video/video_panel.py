"""The panel with the witness video of a clip. It follows the playhead with a time offset."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtGui import QAction, QImage, QShowEvent
from PySide6.QtWidgets import QToolButton, QWidget

from inspector.language import tr, tr_as
from inspector.session.document import Document
from inspector.session.settings import Settings
from inspector.video.remembered_videos import (
    FARTHEST_S,
    VIDEOS,
    forget_video,
    remember_video,
)
from inspector.video.screen import Screen
from inspector.video.video_reader import Picture, VideoReader
from inspector.widgets.background import OneTask, Task
from inspector.widgets.building import (
    action_button,
    hbox,
    tool_button,
    use_secondary_text_colour,
    vbox,
)
from inspector.widgets.labels import ElidedLabel, SteadyLabel, escape_tool_tip_text
from inspector.widgets.signed_numbers import SignedBox
from inspector.widgets.theme import Colours
from twistcore.files.ordinary import real_path

_FPS = tr_as("frames per second", "fps")
NO_VIDEO = tr("No video for this clip.\nFile → Open witness video…, or drop one here.")
BEFORE, AFTER = tr("before the video's start"), tr("after the video's end")


class VideoPanel(QWidget):
    """A panel with an image of the video, its time offset, and a button that holds the image.

    The time in the video, in seconds, is the time in the clip plus the offset. While the video is
    held, only the playhead moves. When the video is released, the offset is set so that the image
    matches the playhead.
    """

    restored = Signal()  # the clip that was opened has a video

    def __init__(
        self,
        document: Document,
        colours: Colours,
        settings: Settings,
        actions: Mapping[str, QAction],
    ) -> None:
        super().__init__()
        self._document, self._settings, self._hold = document, settings, actions["hold_video"]
        self.reader: VideoReader | None = None
        self.shown: Picture | None = None
        self._offset = 0.0
        self._held: float | None = None
        self._task = OneTask(self)
        self._size: tuple[int, int] | None = None  # size in pixels for which the image was decoded
        self.display = Screen(colours, NO_VIDEO)
        self.offset = SignedBox(decimals=3, singleStep=0.001, suffix=" s")
        self.offset.setRange(-FARTHEST_S, FARTHEST_S)
        self.offset.setKeyboardTracking(False)
        self.offset.setAccessibleName(tr("Offset of the video"))
        self.offset.setToolTip(tr("Time, in seconds, at which the clip begins in the video"))
        self.back = self._button("◀", tr("One video frame back"), lambda: self.nudge(-1))
        self.forth = self._button("▶", tr("One video frame forward"), lambda: self.nudge(+1))
        self.hold = action_button(self._hold)
        self.hold.setObjectName("hold")
        self.facts, self.clock = (
            use_secondary_text_colour(ElidedLabel()),
            use_secondary_text_colour(SteadyLabel()),
        )
        buttons = self.back, self.forth, self.hold
        row = hbox(tr("Offset"), (self.offset, 1), *buttons, margins=(8, 4, 8, 0))
        below = hbox((self.facts, 1), self.clock, margins=(8, 0, 8, 6))
        vbox((self.display, 1), row, below, owner=self, margins=(0, 0, 0, 0), spacing=4)
        self.offset.valueChanged.connect(self._set_offset)
        self.offset.valueChanged.connect(self._follow)
        self.display.resized.connect(self._follow)
        document.frame_changed.connect(self._follow)
        document.opened.connect(self._clip_opened)
        self._show_facts()

    def _button(self, glyph: str, tip: str, do: Callable[[], None]) -> QToolButton:
        button = tool_button(glyph, tip, flat=False)
        button.setAutoRepeat(True)
        button.clicked.connect(lambda: do())
        return button

    @property
    def busy(self) -> bool:
        """True while a video is being opened or an image is being decoded."""
        return self._task.running

    # -- which video --------------------------------------------------------------------------

    def open_video(self, path: Path) -> None:
        """Load a video for the open clip.

        The previous video is visible until the new one is loaded.
        """
        self._load(path, 0.0, lambda error: self._document.message.emit(str(error), True))

    def close_video(self) -> None:
        """Close the video, and delete its link to the open clip."""
        if clip := self._clip():
            forget_video(self._settings, clip)
        self.close_file()

    def close_file(self, text: str = NO_VIDEO) -> None:
        """Close the video file, and show a message."""
        self._task.cancel()
        self._replace_reader(None, 0.0)
        self._set_picture(None, text)
        self._show_facts()

    def _clip_opened(self) -> None:
        self.close_file()
        known = VIDEOS.of(self._settings).get(self._clip())
        if known is not None:
            path, offset = known
            self.restored.emit()
            self._load(Path(path), offset, lambda error: self.close_file(str(error)))

    def _load(self, path: Path, offset: float, failed: Callable[[Exception], None]) -> None:
        if self.reader is None:
            self._set_picture(None, tr("Opening {name} …", name=path.name))
        self._task.run(
            lambda _: VideoReader(path),
            lambda reader: self._loaded(reader, offset),
            lambda error: self._not_loaded(error, failed),
        )

    def _loaded(self, reader: VideoReader, offset: float) -> None:
        self._replace_reader(reader, offset)
        self._set_picture(None, "")
        self._remember()
        self._show_facts()
        self._follow()

    def _not_loaded(self, error: Exception, failed: Callable[[Exception], None]) -> None:
        if self.reader is None:
            self._set_picture(None, NO_VIDEO)
        failed(error)
        self._follow()

    def _clip(self) -> str:
        data = self._document.data
        return str(real_path(data.clip.path)) if data else ""

    def _remember(self) -> None:
        if self.reader is not None and (clip := self._clip()):
            remember_video(self._settings, clip, self.reader.path, self._offset)

    # -- when ---------------------------------------------------------------------------------

    def time(self) -> float:
        """Return the time in the video at the playhead, in seconds since the first image."""
        return self._clip_time() + self._offset if self._held is None else self._held

    def _clip_time(self) -> float:
        data = self._document.data
        return self._document.frame * data.motion.frame_time if data else 0.0

    def set_hold(self, on: bool) -> None:
        """Hold the image or, if `on` is False, release it and align it with the playhead."""
        if on == (self._held is not None):
            return
        if on:
            self._held = self.time()
        else:
            assert self._held is not None
            offset, self._held = self._held - self._clip_time(), None
            self._set_offset(offset)
        self._show_facts()
        self._follow()

    def nudge(self, frames: int) -> None:
        """Shift the video relative to the clip by a number of video frames."""
        if self.reader is None:
            return
        by = frames / self.reader.fps
        if self._held is None:
            self._set_offset(self._offset + by)
        else:
            self._held += by
        self._follow()

    def _set_offset(self, seconds: float) -> None:
        self._show_offset(seconds)
        self._remember()

    def _show_offset(self, seconds: float) -> None:
        self._offset = seconds
        with QSignalBlocker(self.offset):
            self.offset.setValue(seconds)

    def _replace_reader(self, reader: VideoReader | None, offset: float) -> None:
        """Replace the video, or close it if `reader` is None. A held image is released."""
        if self.reader is not None:
            close = self.reader.close
            # This is done in a thread, because the reader may still be decoding.
            Task(lambda _: close(), self).start()
        self.reader, self._held = reader, None
        self._hold.setChecked(False)
        self._show_offset(offset)

    # -- the picture --------------------------------------------------------------------------

    def _follow(self) -> None:
        """Decode and show the image at the playhead, unless an image is already being decoded."""
        reader = self.reader
        if reader is None or self.busy or not self.isVisible():
            return
        seconds, size = self.time(), self.display.pixels()
        if self.shown is not None and size == self._size and self.shown.covers(seconds):
            return
        if place := reader.place(seconds):
            self._set_picture(None, BEFORE if place < 0 else AFTER)
            return

        def decoded(picture: Picture | None) -> None:
            self._size = size
            self._set_picture(picture, AFTER)
            self._follow()

        self._task.run(
            lambda _: reader.picture(seconds, *size),
            decoded,
            lambda error: self.close_file(str(error)),
        )

    def _set_picture(self, picture: Picture | None, message: str) -> None:
        if picture is None:
            self.display.show_image(None, message)
        else:
            height, width, _ = picture.pixels.shape
            form = QImage.Format.Format_RGB888
            self.display.show_image(QImage(picture.pixels.data, width, height, 3 * width, form))
        self.shown = picture  # this reference keeps the pixels of the displayed image alive
        self._show_time()

    def _show_facts(self) -> None:
        """Show the name and the properties of the video, and enable or disable the controls."""
        reader = self.reader
        for widget in (self.back, self.forth, self._hold):
            widget.setEnabled(reader is not None)
        self.offset.setEnabled(reader is not None and self._held is None)
        text = tip = ""
        if reader is not None:
            text = f"{reader.fps:.4g} {_FPS} · {reader.width}×{reader.height} · {reader.path.name}"
            tip = f"{reader.path}\n{reader.duration:.2f} s"
        self.facts.setText(text)
        self.facts.setToolTip(escape_tool_tip_text(tip))
        self._show_time()

    def _show_time(self) -> None:
        text = ""
        if self.shown is not None:
            running, held = tr("video {seconds:.3f} s"), tr("held at {seconds:.3f} s")
            words = running if self._held is None else held
            text = words.format(seconds=self.shown.start)
        self.clock.setText(text)

    def showEvent(self, event: QShowEvent) -> None:
        """Decode the image when the panel becomes visible."""
        super().showEvent(event)
        self._follow()
