"""Saving the session: when it is asked for, by itself, and before a clip gives way to another."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QMessageBox

from inspector.bundled import ASSETS
from inspector.feature import HostWindow
from inspector.folder.feature import feature as folder
from inspector.language import tr, tr_as
from inspector.lessons.feature import feature as lessons
from inspector.session.session_files import SESSION_SUFFIX, is_session
from inspector.widgets.file_dialog import ask_where

_AUTOSAVE_MS = 60_000  # after the last step


@dataclass(eq=False, kw_only=True)
class Saving:
    """Decisions are saved or wait in the journal; nothing modal while reviewing.

    tell_saved: called when the session is on disk.
    """

    window: HostWindow
    tell_saved: Callable[[], None]

    def __post_init__(self) -> None:
        window = self.window
        self.document, self.settings = window.document, window.settings
        self.bar, self.detail = window.bar, window.detail
        self.queue = window.part(folder).queue
        self.lessons = window.part(lessons).lesson_actions
        self._idle = QTimer(self.window, singleShot=True, interval=_AUTOSAVE_MS)
        self._idle.timeout.connect(self._save_by_itself)
        self.document.intervals_changed.connect(self._wait_to_save)

    def save_session_as(self) -> None:
        """Ask where to and write the session there."""
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
            return
        if self._nothing_kept():
            return
        ask_where(
            self.window,
            tr("Save session as"),
            tr("Sessions") + f" (*{SESSION_SUFFIX})",
            lambda path: self.save_session(_named_session(path)),
            wanted=self.document.proposed(SESSION_SUFFIX, own=True),
        )

    def save_session(self, path: Path | None = None) -> bool:
        """Write the session, at `path` or where it belongs; True if it is on disk."""
        self.detail.commit()
        if self._nothing_kept():
            return False
        saved, told = self.document.keeper.save(path)
        if saved:
            asked = self.bar.asks
            changed = self.document.recovery.check_clip()
            if changed and (asked or not self.bar.asks):  # else it asks what to do about it
                own = tr("The session belongs to the version that is open.")
                told += f" {changed} {own}"
            self.tell_saved()
            if self.document.data is not None:
                self.queue.refresh(self.document.data.clip.path)
            if file := self.document.keeper.session_file:
                self.window.statusBar().showMessage(tr("Saved {file}", file=file), 4000)
        if told:
            self.bar.show_message(told.strip(), True)
        return saved

    def _nothing_kept(self) -> bool:
        """Whether the clip is borrowed: its session would be taken for the own clip's; told."""
        if (borrowed := self.document.borrowed) is not None:
            self.bar.show_message(borrowed.why, False)
        return borrowed is not None

    # -- leaving a clip -----------------------------------------------------------------------

    def leave(self, then: Callable[[], object]) -> None:
        """Go on once unsaved decisions are saved, or wait in the journal; nothing modal."""
        self.lessons.hidden_errors.before_leaving(partial(self._leave, then))

    def _leave(self, then: Callable[[], object]) -> None:
        self.lessons.leave_guide()
        self.detail.commit()
        data = self.document.data
        if data is None or self._is_kept():
            then()
        elif self.settings.autosave:
            saved, told = self._save()
            if saved or self.document.keeper.journal.on_disk:
                then()
                self._tell_behind(told)
            else:
                self._tell(told)
                name = data.clip.name
                told = tr("The decisions about {clip} cannot be saved.", clip=name)
                self._ask_to_leave(told, then)
        else:
            self._ask_to_leave(_unsaved(data.clip.name), then)

    def _ask_to_leave(self, told: str, then: Callable[[], object]) -> None:
        def save() -> None:
            if self.save_session():
                then()

        def leave() -> None:
            self.document.keeper.journal.give_up()
            self.document.review.mark_saved()
            if self.document.data is not None:
                self.queue.refresh(self.document.data.clip.path)
            then()

        elsewhere = (tr("Save elsewhere…"), self.save_session_as)
        without = (tr("Leave without saving"), leave)
        self.bar.ask(told, ((tr_as("do", "Save"), save), elsewhere, without))

    def _is_kept(self) -> bool:
        """Whether nothing of the review would be lost, or it is of a borrowed clip still open."""
        return self.document.review.saved or self.document.borrowed is not None

    def save_quietly(self) -> bool:
        """Save without a word, unless something is to be told; True if it is on disk.

        Not beside what comes with the program: that opens as new for the next person, and the
        journal keeps what was decided. Nor of a borrowed clip.
        """
        saved, told = self._save()
        self._tell(told)
        return saved

    def _save(self) -> tuple[bool, str]:
        """The same, and what is to be told."""
        data = self.document.data
        bundled = data is not None and ASSETS in data.clip.path.parents
        if bundled or self.document.borrowed is not None:
            return False, ""
        saved, told = self.document.keeper.save()
        self.tell_saved()
        if saved and self.document.data is not None:
            self.queue.refresh(self.document.data.clip.path)
        return saved, told.strip()

    def _tell(self, told: str) -> None:
        if told:
            self.bar.show_message(told, True)

    def _tell_behind(self, told: str) -> None:
        """Tell it once what is being opened is there: that clears the bar and says its own."""
        opener = self.document.opener
        if not (told and opener.busy):
            self._tell(told)
            return
        once = Qt.ConnectionType.SingleShotConnection
        later = partial(QTimer.singleShot, 0, self.window, partial(self.bar.add_error, told))
        opener.over.connect(later, once)

    def _wait_to_save(self) -> None:
        if self.settings.autosave and not self.document.review.saved:
            self._idle.start()

    def _save_by_itself(self) -> None:
        if self.document.opener.busy or self.lessons.program.aside.open:
            self._idle.start()  # what waits may be of the clip that is put aside
        elif self.document.data is None or self.document.review.saved:
            return
        elif not self.document.keeper.read_only and self.settings.autosave:
            self.save_quietly()

    def may_close(self, *, ask: bool = True) -> bool:
        """True once unsaved decisions are saved or knowingly given up, or wait in the journal."""
        waits = self.lessons.hidden_errors.not_handed_in if ask else ""
        if waits and not self._closes_without_handing_in(waits):
            return False
        self.lessons.leave_guide()
        self.detail.commit()
        if not ask or self.document.data is None or self._is_kept():
            return True
        told, trouble = _unsaved(self.document.data.clip.name), ""
        if self.settings.autosave:
            saved, trouble = self._save()
            if saved:
                return True  # whatever is to be told: nobody needs to do anything about it
            if self.document.keeper.journal.on_disk and not self.document.keeper.read_only:
                return not trouble or self._closes_unsaved(trouble)
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self.window,
            "Twist Inspector",
            f"{trouble} {told}".strip(),
            button.Save | button.Discard | button.Cancel,
            button.Save,
        )
        if answer == button.Save:
            return self.save_session()
        if answer == button.Discard:
            self.document.keeper.journal.give_up()
        return answer == button.Discard

    def _closes_without_handing_in(self, told: str) -> bool:
        """Ask about verdicts for a class; handing them in closes the window once that is done."""
        button = QMessageBox.StandardButton
        buttons = button.Save | button.Discard | button.Cancel
        box = QMessageBox(QMessageBox.Icon.Question, "Twist Inspector", told, buttons, self.window)
        box.setDefaultButton(button.Save)
        box.button(button.Save).setText(tr("Hand in…"))
        box.button(button.Discard).setText(tr("Leave without"))
        answer = box.exec()
        box.deleteLater()
        if answer == button.Save:
            close = partial(QTimer.singleShot, 0, self.window, self.window.close)
            self.lessons.hidden_errors.ask_hand_in(close)
        return answer == button.Discard

    def _closes_unsaved(self, trouble: str) -> bool:
        """Say that the session cannot be written; whether to close all the same."""
        button = QMessageBox.StandardButton
        told = tr("The decisions are offered when the program is started again.")
        told = f"{trouble} {told}"
        buttons, wanted = button.Close | button.Cancel, button.Close
        answer = QMessageBox.warning(self.window, "Twist Inspector", told, buttons, wanted)
        return answer == button.Close


def _unsaved(clip: str) -> str:
    return tr("{clip} has decisions that are not saved.", clip=clip)


def _named_session(path: Path) -> Path:
    """With the ending that sessions have."""
    return path if is_session(path) else path.with_name(path.name + SESSION_SUFFIX)
