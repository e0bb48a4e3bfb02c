"""The actions for files and folders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QApplication, QDockWidget, QMenu

from inspector.folder.remembered_folders import (
    NEXT_AFTER_EXPORT,
    folder_record,
    recent_folders,
    remember_folder,
)
from inspector.language import chosen_language, plural, tr, tr_as
from inspector.session.export_files import Export, ExportChoice
from inspector.session.leftovers import unsaved_clips
from inspector.session.session_files import SESSION_PATTERNS, is_session, modified_ns
from inspector.widgets.background import OneTask
from inspector.widgets.file_dialog import ask_files, ask_folder
from inspector.widgets.labels import escape_menu_text, escape_tool_tip_text
from inspector.widgets.review_keys import is_typing_text
from inspector.window.export_dialog import ExportDialog
from inspector.window.saving import Saving
from inspector.window.scene_files import CLIPS, CLIPS_AND_SCENES, SceneFiles
from twistcore.detection import DEFAULT_METHOD, DETECTORS
from twistcore.review import Decision, ReviewState
from twistcore.tuning import Profile

_FIRST_MS = 4_000  # time to wait for the worst clip of a folder
_VISITED = 100
_CHAINS = 160  # height in pixels of the list of chains below the list of clips


@dataclass(eq=False, kw_only=True)
class FileActions(Saving):
    """The actions that open, save and export files, analyse folders, and list recent files.

    `begin` is a function that goes to the first undecided interval.
    """

    recent_menu: QMenu
    begin: Callable[[], object]
    closing: bool = field(default=False, init=False)  # if True, no other clip is opened
    _under_way: str = field(default="", init=False)
    # If True, the next clip opens automatically
    _wait_for_first: bool = field(default=False, init=False)
    _so_far: Path | None = field(default=None, init=False)  # the worst clip so far, opened early
    # Severity of the worse clip that was offered last
    _offered: float = field(default=0.0, init=False)
    _since: ReviewState | None = field(default=None, init=False)  # the review when waiting began
    # The hidden dialog of an immediate export, while it reads the files to replace
    _at_once: ExportDialog | None = field(default=None, init=False)
    # The clips opened so far; the open clip is last
    _visited: list[Path] = field(default_factory=list, init=False)
    _when_open: tuple[Path, Callable[[], object]] | None = field(default=None, init=False)
    _back_to: Path | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        self.exporter, self.clips_dock = self.window.exporter, self.window.docks["clips"]
        # Enabled while a file is being opened
        self.cancel = self.window.actions_by_id["cancel_opening"]
        self._scenes = SceneFiles(self.bar.show_message, self.open_path, self.window)
        self._first = QTimer(self.window, singleShot=True, interval=_FIRST_MS)
        self._first.timeout.connect(self._queue_changed)
        opener, recovery = self.document.opener, self.document.recovery
        opener.locate.connect(self.locate_clip)
        opener.began.connect(self._opening)
        opener.share.connect(self._opening_share)
        opener.over.connect(self._opening_ended)
        recovery.save_elsewhere.connect(self.save_session_as)
        recovery.open_again.connect(self.open_path)
        self.document.opened.connect(self._opened)
        self.queue.changed.connect(self._queue_changed)
        self.queue.finished.connect(self._open_first)
        self.queue.profile_changed.connect(self._keep_profile)
        self.queue.failed.connect(lambda text: self.bar.show_message(text, True))
        self.exporter.written.connect(self._exported)
        self.cancel.setEnabled(False)
        self._show_recent()

    # -- opening ------------------------------------------------------------------------------

    def open_path(self, path: Path) -> None:
        """Open a clip, a session, a folder, or a scene that Blender converts to a clip."""
        if path.is_dir():
            self.open_queue(path)
        elif not self._scenes.take(path):
            self._wait_for_first = False
            self.leave(lambda: self._open(self.queue.listed(path)))

    def _open(self, path: Path) -> None:
        if is_session(path):
            self.document.opener.open_session(path)
        else:
            self.document.opener.open(path, self.queue.profile_of(path))

    def open_dialog(self) -> None:
        """Ask for a file, and open it."""
        patterns = tr("Motion and sessions") + f" ({CLIPS_AND_SCENES} {SESSION_PATTERNS})"
        pattern = f"{patterns};;" + tr("All files") + " (*)"
        ask_files(
            self.window,
            tr_as("do", "Open"),
            pattern,
            lambda paths: self.open_path(paths[0]),
            folder=self.document.folder,
        )

    def open_then(self, path: Path, then: Callable[[], object]) -> None:
        """Open a clip, and call `then` after the messages about the clip have been shown."""
        self._when_open = path, then
        self.open_path(path)

    def open_folder(self) -> None:
        """Ask for a folder, and analyse its clips."""
        ask_folder(self.window, tr("Open folder"), self.open_path, start=self.document.folder)

    def open_queue(self, folder: Path) -> None:
        """Analyse the clips of a folder in the background.

        The clip that was last open in this folder is opened. If there is none, the worst clip is
        opened as soon as a tenth of the clips, or 20 clips, are analysed. If a worse clip is found
        later, the program offers to open that clip.
        """
        kept = folder_record(self.settings, folder)
        self._wait_for_first = False
        there = (kept["method"] or DEFAULT_METHOD) in DETECTORS
        profile = Profile(kept["tau"], kept["method"]) if kept["profile"] and there else None
        self.queue.open(folder, profile, kept["profile"])
        if self.clips_dock.isHidden():
            self.clips_dock.show()
            heights = {"clips": self.clips_dock.widget().sizeHint().height(), "chains": _CHAINS}
            docks = [d for d in self.window.findChildren(QDockWidget) if d.objectName() in heights]
            wanted = [heights[d.objectName()] for d in docks]
            upright = Qt.Orientation.Vertical
            resize = partial(self.window.resizeDocks, docks, wanted, upright)
            QTimer.singleShot(0, self.window, resize)  # as soon as the panel has its position
        name = Path(kept["clip"]).name  # the clips of a batch may be in other folders
        stopped_at = next((c for c in self.queue.clips.values() if c.path.name == name), None)
        if stopped_at is not None and (stopped_at.waits or not stopped_at.done):
            self.open_path(stopped_at.path)
            return
        if not self.queue.clips:
            text = tr(
                "{folder}: there are no clips in this folder yet. New clips will appear in "
                "the list.",
                folder=folder,
            )
        else:
            text = tr("{folder}: the worst clip opens in a moment …", folder=folder.name)
        self.bar.show_message(text, False)
        self._wait_for_first, self._since = True, self._state()
        self._first.start()
        self._queue_changed()

    def _queue_changed(self) -> None:
        early = self._first.isActive() or not self.queue.knows_enough
        if not self.queue.running or not early:
            self._open_first()
        self._offer_worse()

    def _open_first(self) -> None:
        if not self._wait_for_first:
            return
        if self._is_busy(self._since):
            self._wait_for_first = False
        elif path := self.queue.next_after(None):
            self._open_worst(path)
        elif not self.queue.running and self.queue.clips:
            self._wait_for_first = False
            text = tr(
                "{folder}: no clip has undecided intervals. Double-click a clip to open it.",
                folder=self.queue.folder and self.queue.folder.name,
            )
            one_is_open = self.document.data is not None
            self.bar.show_message(self._nothing_next() if one_is_open else text, False)

    def _open_worst(self, path: Path) -> None:
        """Open the worst clip of the folder.

        If other clips are still being analysed, show a message that this clip is the worst so far.
        """
        if self.queue.running:
            self._so_far, self._offered = path, self.queue.clips[path].severity
            if self._when_open is None:
                self._when_open = path, partial(self._report_so_far, path)
        self.open_path(path)

    def _report_so_far(self, path: Path) -> None:
        done, total = self.queue.progress
        text = tr(
            "{name} is the worst clip so far ({done} of {total} clips analysed).",
            name=path.name,
            done=done,
            total=total,
        )
        self.bar.show_message(text, False)

    def _offer_worse(self) -> None:
        """Offer to open a worse clip if the previous worst clip is still open."""
        data, path = self.document.data, self._so_far
        if path is None or data is None or data.clip.path != path or self.bar.asks:
            return
        worse = self.queue.worse_than(path)
        if worse is not None and worse.severity > self._offered:
            self._offered = worse.severity
            text = tr(
                "{name} is worse than the open clip: its severity is {severity:.1f}°.",
                name=worse.path.name,
                severity=worse.severity,
            )
            open_it = tr("Open {name}", name=worse.path.name), partial(self._open_worst, worse.path)
            self.bar.offer(text, (open_it,))

    def _keep_profile(self) -> None:
        if (folder := self.queue.folder) is not None:
            profile = self.queue.profile or Profile({})
            remember_folder(
                self.settings,
                folder,
                profile=self.queue.profile_name,
                method=profile.method,
                tau=dict(profile.tau),
            )

    def next_clip(self) -> None:
        """Open the next clip with undecided intervals. Clips are ordered from worst to best."""
        data = self.document.data
        path = self.queue.next_after(data.clip.path if data else None)
        if path is not None:
            self.open_path(path)
        elif self.queue.folder is None:
            self.bar.show_message(tr("Open a folder first (Ctrl+Shift+O)."), False)
        else:
            self.bar.show_message(self._nothing_next(), False)
            self._wait_for_first, self._since = self.queue.running, self._state()

    def _nothing_next(self) -> str:
        if self.queue.running:
            return tr(
                "The other clips are still being analysed. The next one will open automatically."
            )
        return tr("No other clip in this folder has undecided intervals.")

    def previous_clip(self) -> None:
        """Open the clip that was open before the current one."""
        if len(self._visited) < 2:
            self.bar.show_message(tr("No other clip has been opened yet."), False)
            return
        self._back_to = self._visited[-2]
        self.open_path(self._back_to)

    def _opening(self, what: str) -> None:
        self.bar.clear()
        self._under_way = what
        self.window.statusBar().showMessage(f"{what} …")
        self.cancel.setEnabled(True)

    def _opening_share(self, share: float) -> None:
        key = self.cancel.shortcut().toString(QKeySequence.SequenceFormat.NativeText)
        how = "   " + tr("Press {key} to cancel.", key=key) if key else ""
        self.window.statusBar().showMessage(f"{self._under_way} … {100.0 * share:.0f} %{how}")

    def _opening_ended(self) -> None:
        self.window.statusBar().clearMessage()
        self.cancel.setEnabled(False)

    def _opened(self) -> None:
        data = self.document.data
        assert data is not None
        if not self.lessons.program.aside.open:
            path = data.clip.path
            self.settings.remember(path)
            if path == self._back_to:
                del self._visited[self._visited.index(path) + 1 :]
            else:
                self._visited = [*(p for p in self._visited if p != path), path][-_VISITED:]
            self._back_to = None
            if self.queue.folder is not None and path in self.queue.clips:
                remember_folder(self.settings, self.queue.folder, clip=path.name)
                if not self.document.keeper.leftovers:  # a question about leftovers comes first
                    QTimer.singleShot(0, self.window, self.begin)
        self._show_recent()
        when_open, self._when_open = self._when_open, None
        if when_open is not None and when_open[0] == data.clip.path:
            # This comes after the messages and questions about the clip itself.
            QTimer.singleShot(0, self.window, when_open[1])
        text = tr(
            "{clip}: {frames} frames at {fps:.4g} fps, {joints} joints",
            clip=data.clip.name,
            frames=data.motion.frames,
            fps=data.motion.fps,
            joints=len(data.motion.skeleton),
        )
        self.window.statusBar().showMessage(text, 8000)

    def recent(self) -> tuple[list[Path], list[Path]]:
        """Return the recent clips and the recent folders, latest first."""
        return [Path(name) for name in self.settings.recent], recent_folders(self.settings)

    def _show_recent(self) -> None:
        self.recent_menu.clear()
        for name in self.settings.recent:
            # Do not use addAction(text): PySide may confuse its result with a deleted object.
            action = QAction(
                escape_menu_text(name), self.recent_menu, toolTip=escape_tool_tip_text(name)
            )
            action.triggered.connect(lambda _=False, n=name: self.open_path(Path(n)))
            self.recent_menu.addAction(action)
        self.recent_menu.setEnabled(bool(self.settings.recent))

    # -- exporting ----------------------------------------------------------------------------

    def locate_clip(self, session: Path) -> None:
        """Ask the user for the clip of a session, and open the session with this clip."""
        title, reopen = tr("Locate the clip"), partial(self.document.opener.open_session, session)
        ask_files(self.window, title, CLIPS, lambda p: reopen(p[0]), folder=session.parent)

    def export_dialog(self, *, at_once: bool = False) -> None:
        """Open the export dialog.

        If `at_once` is True, export without the dialog unless something prevents this. For a clip
        of a lesson, the dialog always opens, because the user must choose the target folder.
        """
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
            return
        dialog = ExportDialog(self.document, self.window)
        dialog.accepted.connect(lambda: self.export(dialog.choice()))
        if not at_once or self.document.borrowed is not None:
            dialog.open()
            return
        if self._at_once is not None:
            self._at_once.reject()  # the key was pressed again: export the current review
        self._at_once = dialog
        dialog.finished.connect(self._export_at_once_ended)

        def decide() -> None:
            if dialog.do_it.isEnabled():
                dialog.accept()
            else:  # a new form, because this one shows earlier files
                dialog.reject()
                self.export_dialog()

        if dialog.looking:
            self.bar.show_message(tr("Checking which files the export would replace …"), False)
        dialog.when_checked(decide)

    def _export_at_once_ended(self, _: int) -> None:
        self._at_once = None

    def export(self, choice: ExportChoice) -> None:
        """Write an export in the background, and show the result in the message bar."""
        self.detail.commit()
        self.exporter.start(choice)

    def _exported(self, export: Export, text: str) -> None:
        """Record the export in the session, save the session, and open the folder's next clip."""
        path, data = export.clip.path, self.document.data
        own = data is not None and data.clip is export.clip
        if own and not self.document.review.saved and not self.document.keeper.read_only:
            self.save_quietly()
        if path not in self.queue.clips:
            return
        self.queue.note_export(path, export.choice.path)
        if not own or self.closing or export.changed or not NEXT_AFTER_EXPORT.of(self.settings):
            return
        if self._is_busy(export.state):
            return
        correctable = (j for j in export.state.intervals if j.interval.correctable)
        if left := sum(j.decision == Decision.UNDECIDED for j in correctable):
            words = plural(
                "{n} undecided interval was not corrected.",
                "{n} undecided intervals were not corrected.",
                left,
            )
            text = f"{text} {words}"
        if (following := self.queue.next_after(path)) is None:
            self.bar.show_message(f"{text} {self._nothing_next()}", False)
            self._wait_for_first, self._since = self.queue.running, self._state()
            return
        message = f"{text} " + tr("Next clip: {name}.", name=following.name)
        self._when_open = following, lambda: self._report_next(message, path)
        self.open_path(following)

    def _is_busy(self, since: ReviewState | None) -> bool:
        """Return True if the user is busy, or if the review is no longer in the state `since`.

        In that case, no other clip may be opened automatically.
        """
        dialog = QApplication.activeModalWidget() or QApplication.activePopupWidget()
        busy = self.document.opener.busy or self.lessons.on
        elsewhere = busy or dialog is not None or is_typing_text()
        return elsewhere or self._state() is not since

    def _state(self) -> ReviewState | None:
        return None if self.document.data is None else self.document.review.state

    def _report_next(self, text: str, before: Path) -> None:
        if self.bar.asks:
            self.window.statusBar().showMessage(text, 15_000)
        else:
            back = tr("Back to {clip}", clip=before.name)
            self.bar.offer(text, ((back, lambda: self.open_path(before)),))

    def offer_unsaved(self) -> None:
        """Offer to restore a recently opened clip with unsaved decisions."""
        clips = tuple(map(Path, self.settings.recent))
        OneTask(self.window).run(lambda _: unsaved_clips(clips), self._offer)

    def _offer(self, unsaved: Sequence[tuple[Path, Path, int]]) -> None:
        busy = self.document.opener.busy or self.bar.asks
        if not unsaved or self.document.data is not None or busy:
            return  # the question is asked anyway when the clip is opened
        (clip, journal, count), *others = unsaved
        when = datetime.fromtimestamp(modified_ns(journal) / 1e9)
        text = tr(
            "The last review of {clip} was not saved ({when}). {decisions} can be restored.",
            clip=clip.name,
            when=f"{when:%d %B, %H:%M}" if chosen_language() == "en" else f"{when:%x, %H:%M}",
            decisions=plural("{n} decision", "{n} decisions", count),
        )
        if others:
            text += " " + plural(
                "{n} more recent clip has unsaved decisions.",
                "{n} more recent clips have unsaved decisions.",
                len(others),
            )
        restore = tr("Open and restore"), lambda: self._restore(clip)
        self.bar.ask(text, (restore, (tr("Not now"), lambda: None)))

    def _restore(self, clip: Path) -> None:
        """Open a clip and restore its latest review.

        If the clip was the last open clip of its folder, open the folder as well.
        """

        def go_on() -> None:
            if leftovers := self.document.keeper.leftovers:
                self.bar.clear()
                self.document.recovery.restore(leftovers[0])

        self._when_open = clip, go_on
        if folder_record(self.settings, clip.parent)["clip"] == clip.name:
            self.open_queue(clip.parent)
        else:
            self.open_path(clip)
