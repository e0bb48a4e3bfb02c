"""The actions that open and close the witness video."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QMainWindow

from inspector.language import tr
from inspector.session.document import Document
from inspector.video.video_panel import VideoPanel
from inspector.video.video_reader import SUFFIXES, WANTS_PYAV, can_play
from inspector.widgets.file_dialog import ask_files


@dataclass(eq=False)
class VideoActions:
    """The actions that open and close the video of the open clip."""

    document: Document
    video: VideoPanel
    dock: QDockWidget
    window: QMainWindow

    def open_video(self) -> None:
        """Let the user choose a video, and show it next to the 3D view."""
        if not self._may_open_video() or self.document.data is None:
            return
        patterns = " ".join(f"*{suffix}" for suffix in sorted(SUFFIXES))
        ask_files(
            self.window,
            tr("Open witness video"),
            tr("Videos ({patterns});;All files (*)", patterns=patterns),
            lambda paths: self.show_video(paths[0]),
            folder=self.document.data.clip.path.parent,
        )

    def show_video(self, path: Path) -> None:
        """Show a video file next to the 3D view of the open clip."""
        if self._may_open_video():
            self.show_dock()
            self.video.open_video(path)

    def show_dock(self) -> None:
        """Show the video dock. If it was hidden, it gets a third of the window's width."""
        if not self.dock.isVisible():
            self.dock.show()
            width = self.window.width() // 3
            self.window.resizeDocks([self.dock], [width], Qt.Orientation.Horizontal)

    def close_video(self) -> None:
        """Close the video, delete its link to the clip, and hide the dock."""
        self.video.close_video()
        self.dock.hide()

    def _may_open_video(self) -> bool:
        if not can_play():
            self.document.message.emit(WANTS_PYAV, True)
        elif self.document.data is None:
            message = tr("Open a clip first, then its video.")
            self.document.message.emit(message, False)
        else:
            return True
        return False
