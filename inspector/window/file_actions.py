"""What the actions on files do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QDockWidget, QFileDialog, QMainWindow, QMenu, QMessageBox

from inspector.panels.detail_card import DetailCard
from inspector.session.document import Document
from inspector.session.export_files import ExportChoice
from inspector.session.exporter import Exporter
from inspector.session.queue import FolderQueue
from inspector.session.session_files import SESSION_SUFFIX, is_session, session_path
from inspector.session.settings import Settings
from inspector.teaching.teaching_actions import TeachingActions
from inspector.widgets.file_dialog import ask_files, ask_where
from inspector.widgets.message_bar import MessageBar
from inspector.window.export_dialog import ExportDialog


@dataclass(eq=False)
class FileActions:
    """Opening, saving and exporting; folders and recent files.

    cancel: the action that is enabled while something is being opened; tell_saved: called when
    the session is on disk.
    """

    document: Document
    settings: Settings
    exporter: Exporter
    queue: FolderQueue
    bar: MessageBar
    detail: DetailCard
    teaching: TeachingActions
    clips_dock: QDockWidget
    recent_menu: QMenu
    cancel: QAction
    tell_saved: Callable[[], None]
    window: QMainWindow
    _under_way: str = field(default="", init=False)
    _wait_for_first: bool = field(default=False, init=False)  # it opens by itself

    def __post_init__(self) -> None:
        opener, recovery = self.document.opener, self.document.recovery
        opener.locate.connect(self.locate_clip)
        opener.began.connect(self._opening)
        opener.share.connect(self._opening_share)
        opener.over.connect(self._opening_over)
        recovery.save_elsewhere.connect(self.save_session_as)
        recovery.open_again.connect(self.open_path)
        self.document.opened.connect(self._opened)
        self.queue.changed.connect(self._queue_changed)
        self.cancel.setEnabled(False)
        self._show_recent()

    # -- opening ------------------------------------------------------------------------------

    def open_path(self, path: Path) -> None:
        """Open a clip or a session."""
        if not self.may_leave():
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
        pattern = f"{patterns};;All files (*)"
        ask_files(self.window, "Open", pattern, lambda paths: self.open_path(paths[0]))

    def open_folder(self) -> None:
        """Ask for a folder and queue its clips."""
        if name := QFileDialog.getExistingDirectory(self.window, "Open folder"):
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

    def _opening(self, what: str) -> None:
        self.bar.clear()
        self._under_way = what
        self.window.statusBar().showMessage(f"{what} …")
        self.cancel.setEnabled(True)

    def _opening_share(self, share: float) -> None:
        key = self.cancel.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        how = f"   {key} cancels." if key else ""
        self.window.statusBar().showMessage(f"{self._under_way} … {100.0 * share:.0f} %{how}")

    def _opening_over(self) -> None:
        self.window.statusBar().clearMessage()
        self.cancel.setEnabled(False)

    def _opened(self) -> None:
        data = self.document.data
        assert data is not None
        if not self.teaching.program.aside.open:
            self.settings.remember(data.clip.path)
        self._show_recent()
        frames = f"{data.motion.frames} frames at {data.motion.fps:.4g} fps"
        text = f"{data.clip.name}: {frames}, {len(data.motion.skeleton)} joints"
        self.window.statusBar().showMessage(text, 8000)

    def _show_recent(self) -> None:
        self.recent_menu.clear()
        for name in self.settings.recent:
            # Made here, not by addAction(text): its answer may be taken for an object long deleted.
            action = QAction(name, self.recent_menu)
            action.triggered.connect(lambda _=False, n=name: self.open_path(Path(n)))
            self.recent_menu.addAction(action)
        self.recent_menu.setEnabled(bool(self.settings.recent))

    # -- saving and exporting -----------------------------------------------------------------

    def save_session_as(self) -> None:
        """Ask where to and write the session there."""
        if self.document.data is None:
            self.bar.show_message("Open a clip first.", False)
            return
        ask_where(
            self.window,
            "Save session as",
            f"Sessions (*{SESSION_SUFFIX})",
            lambda path: self.save_session(_named_session(path)),
            wanted=session_path(self.document.data.clip.path),
        )

    def save_session(self, path: Path | None = None) -> bool:
        """Write the session, at `path` or where it belongs; True if it is on disk."""
        self.detail.commit()
        saved, told = self.document.keeper.save(path)
        if saved:
            if changed := self.document.recovery.check_clip():
                told += f" {changed} The session belongs to the version that is open."
            self.tell_saved()
            if self.document.data is not None:
                self.queue.refresh(self.document.data.clip.path)
            if file := self.document.keeper.session_file:
                self.window.statusBar().showMessage(f"Saved {file}", 4000)
        if told:
            self.bar.show_message(told.strip(), True)
        return saved

    def locate_clip(self, session: Path) -> None:
        """Ask where the clip of a session went, and open both."""
        title, reopen = "Locate the clip", partial(self.document.opener.open_session, session)
        ask_files(self.window, title, "*.bvh", lambda p: reopen(p[0]), folder=session.parent)

    def export_dialog(self) -> None:
        """Ask where to and export."""
        if self.document.data is None:
            self.bar.show_message("Open a clip first.", False)
            return
        dialog = ExportDialog(self.document, self.window)
        dialog.accepted.connect(lambda: self.export(dialog.choice()))
        dialog.open()

    def export(self, choice: ExportChoice) -> None:
        """Write what was chosen in the background; the message bar says what changed."""
        self.detail.commit()
        self.exporter.start(choice)

    def may_leave(self, *, ask: bool = True) -> bool:
        """True once unsaved decisions are saved or knowingly given up, or wait in the journal."""
        self.teaching.leave_guide()
        self.detail.commit()
        if not ask or self.document.data is None or self.document.review.saved:
            return True
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self.window,
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
