"""What the actions of the witness video do: methods of the main window, by the actions' ids."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDockWidget, QFileDialog, QMainWindow

from inspector.session.document import Document
from inspector.video.video_panel import VideoPanel
from inspector.video.video_reader import SUFFIXES, WANTS_PYAV, can_play


class VideoActions(QMainWindow):
    """Open, hold and close the video of the present clip."""

    document: Document
    video: VideoPanel
    video_dock: QDockWidget

    def open_video(self) -> None:
        """Ask for a video and show it beside the 3D view."""
        if not self._may_open_video():
            return
        patterns = " ".join(f"*{suffix}" for suffix in sorted(SUFFIXES))
        dialog = QFileDialog(self, "Open witness video", "", f"Videos ({patterns});;All files (*)")
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        if self.document.data is not None:
            dialog.setDirectory(str(self.document.data.clip.path.parent))
        dialog.fileSelected.connect(lambda name: self.show_video(Path(name)))
        dialog.open()

    def show_video(self, path: Path) -> None:
        """Show a video beside the present clip."""
        if self._may_open_video():
            self.show_video_dock()
            self.video.open_video(path)

    def show_video_dock(self) -> None:
        """Show the dock; where it lies beside the curves it takes a third of the width."""
        if not self.video_dock.isVisible():
            self.video_dock.show()
            self.resizeDocks([self.video_dock], [self.width() // 3], Qt.Orientation.Horizontal)

    def close_video(self) -> None:
        """Take the video from the clip."""
        self.video.close_video()
        self.video_dock.hide()

    def hold_video(self, on: bool) -> None:
        """Let the video stand still while the playhead moves; released, the two belong together."""
        self.video.set_hold(on)

    def _may_open_video(self) -> bool:
        if not can_play():
            self.document.message.emit(WANTS_PYAV, True)
        elif self.document.data is None:
            self.document.message.emit("Open a clip first: a video belongs to one.", False)
        else:
            return True
        return False
