"""What the actions on files do: methods of the main window, by the actions' ids."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QDragEnterEvent, QDropEvent, QKeySequence
from PySide6.QtWidgets import QDockWidget, QFileDialog, QMainWindow, QMenu, QMessageBox

from inspector.bundled import SAMPLE
from inspector.panels.detail_card import DetailCard
from inspector.session.document import Document
from inspector.session.export_files import ExportChoice
from inspector.session.exporter import Exporter
from inspector.session.queue import FolderQueue
from inspector.session.session_files import SESSION_SUFFIX, is_session, session_path
from inspector.session.settings import Settings
from inspector.teaching.interrupted_review import Aside
from inspector.video.video_reader import SUFFIXES
from inspector.widgets.message_bar import MessageBar
from inspector.window.export_dialog import ExportDialog


class FileActions(QMainWindow):
    """Opening, saving and exporting; folders, recent files, files that are dropped."""

    document: Document
    settings: Settings
    exporter: Exporter
    queue: FolderQueue
    bar: MessageBar
    detail: DetailCard
    aside: Aside
    clips_dock: QDockWidget
    recent_menu: QMenu
    actions_by_id: Mapping[str, QAction]
    _under_way = ""
    _unasked = False  # closing: what is not saved stays in the journal
    _wait_for_first = False  # the folder's first clip that is ready opens by itself
    # The window and its other actions have these:
    leave_guide: Callable[[], None]
    show_video: Callable[[Path], None]
    _review_changed: Callable[[], None]

    # -- opening ------------------------------------------------------------------------------

    def open_path(self, path: Path) -> None:
        """Open a clip or a session."""
        if not self._may_leave():
            return
        if path.is_dir():
            self.open_queue(path)
        elif is_session(path):
            self.document.opener.open_session(path)
        else:
            profile = self.queue.profile if path in self.queue.clips else None
            self.document.opener.open(path, profile)

    def open_dialog(self) -> None:
        """Ask for a file and open it."""
        patterns = f"Motion and sessions (*.bvh *{SESSION_SUFFIX}*)"
        dialog = QFileDialog(self, "Open", "", f"{patterns};;All files (*)")
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.fileSelected.connect(lambda name: self.open_path(Path(name)))
        dialog.open()

    def open_folder(self) -> None:
        """Ask for a folder and queue its clips."""
        name = QFileDialog.getExistingDirectory(self, "Open folder")
        if name:
            self.open_path(Path(name))

    def open_queue(self, folder: Path) -> None:
        """Analyse the clips of a folder in the background; the first that is ready opens."""
        self.queue.open(folder)
        self.clips_dock.show()
        if not self.queue.clips:
            self.bar.show_message(f"{folder}: no BVH in this folder yet; it is watched.", False)
        self._wait_for_first = True

    def _queue_changed(self) -> None:
        if self._wait_for_first and (path := self.queue.next_after(None)):
            self._wait_for_first = False
            self.open_path(path)

    def next_clip(self) -> None:
        """Open the worst clip that is not decided."""
        data = self.document.data
        path = self.queue.next_after(data.clip.path if data else None)
        if path is None:
            self.bar.show_message("No other clip of the folder waits for a decision.", False)
        else:
            self.open_path(path)

    def open_sample(self) -> None:
        """Open the bundled walk with known errors."""
        self.open_path(SAMPLE)

    def cancel_opening(self) -> None:
        """Give up what is being opened."""
        self.document.opener.cancel()

    def _opening(self, what: str) -> None:
        self.bar.clear()
        self._under_way = what
        self.statusBar().showMessage(f"{what} …")
        self.actions_by_id["cancel_opening"].setEnabled(True)

    def _opening_share(self, share: float) -> None:
        action = self.actions_by_id["cancel_opening"]
        key = action.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        how = f"   {key} cancels." if key else ""
        self.statusBar().showMessage(f"{self._under_way} … {100.0 * share:.0f} %{how}")

    def _opening_over(self) -> None:
        self.statusBar().clearMessage()
        self.actions_by_id["cancel_opening"].setEnabled(False)

    def _opened(self) -> None:
        data = self.document.data
        assert data is not None
        if not self.aside.open:
            self.settings.remember(data.clip.path)
        self._show_recent()
        motion = data.motion
        self.statusBar().showMessage(
            f"{data.clip.name}: {motion.frames} frames at {motion.fps:.4g} fps, "
            f"{len(motion.skeleton)} joints",
            8000,
        )
        self._review_changed()

    def _show_recent(self) -> None:
        self.recent_menu.clear()
        for name in self.settings.recent:
            # Made here, not by addAction(text): its answer may be taken for an object long deleted.
            action = QAction(name, self.recent_menu)
            action.triggered.connect(lambda _=False, n=name: self.open_path(Path(n)))
            self.recent_menu.addAction(action)
        self.recent_menu.setEnabled(bool(self.settings.recent))

    def dragEnterEvent(self, event: QDragEnterEvent) -> None:
        """A file may be dropped."""
        if any(url.isLocalFile() for url in event.mimeData().urls()):
            event.acceptProposedAction()

    def dropEvent(self, event: QDropEvent) -> None:
        """Open the first file that was dropped; a video goes beside the present clip."""
        files = [u.toLocalFile() for u in event.mimeData().urls() if u.isLocalFile()]
        if files:
            event.acceptProposedAction()
            path = Path(files[0])
            video = path.suffix.lower() in SUFFIXES
            self.show_video(path) if video else self.open_path(path)

    # -- saving and exporting -----------------------------------------------------------------

    def save_session(self) -> bool:
        """Write the session beside the clip; True if it is on disk."""
        return self._save(None)

    def save_session_as(self) -> None:
        """Ask where to and write the session there."""
        if self.document.data is None:
            self.bar.show_message("Open a clip first.", False)
            return
        dialog = QFileDialog(self, "Save session as", "", f"Sessions (*{SESSION_SUFFIX})")
        dialog.setFileMode(QFileDialog.FileMode.AnyFile)
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.selectFile(str(session_path(self.document.data.clip.path)))
        dialog.fileSelected.connect(lambda name: self._save(_named_session(Path(name))))
        dialog.open()

    def _save(self, path: Path | None) -> bool:
        self.detail.commit()
        saved, told = self.document.keeper.save(path)
        if saved:
            if changed := self.document.recovery.check_clip():
                told += f" {changed} The session belongs to the version that is open."
            self._review_changed()
            if self.document.data is not None:
                self.queue.refresh(self.document.data.clip.path)
            if file := self.document.keeper.session_file:
                self.statusBar().showMessage(f"Saved {file}", 4000)
        if told:
            self.bar.show_message(told.strip(), True)
        return saved

    def locate_clip(self, session: Path) -> None:
        """Ask where the clip of a session went, and open both."""
        name, _ = QFileDialog.getOpenFileName(self, "Locate the clip", str(session.parent), "*.bvh")
        if name:
            self.document.opener.open_session(session, Path(name))

    def export_dialog(self) -> None:
        """Ask where to and export."""
        if self.document.data is None:
            self.bar.show_message("Open a clip first.", False)
            return
        dialog = ExportDialog(self.document, self)
        dialog.accepted.connect(lambda: self.export(dialog.choice()))
        dialog.open()

    def export(self, choice: ExportChoice) -> None:
        """Write what was chosen in the background; the message bar says what changed."""
        self.detail.commit()
        self.exporter.start(choice)

    def _may_leave(self) -> bool:
        """True once unsaved decisions are saved or knowingly given up."""
        self.leave_guide()
        self.detail.commit()
        if self._unasked or self.document.data is None or self.document.review.saved:
            return True
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self,
            "Twist Inspector",
            f"{self.document.data.clip.name} has decisions that are not saved.",
            button.Save | button.Discard | button.Cancel,
            button.Save,
        )
        if answer == button.Save:
            return self.save_session()
        if answer == button.Discard:
            self.document.keeper.journal.give_up()
        return answer == button.Discard


def _named_session(path: Path) -> Path:
    """With the ending that sessions have."""
    return path if is_session(path) else path.with_name(path.name + SESSION_SUFFIX)
