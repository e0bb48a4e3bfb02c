"""Save the session on request, automatically, and before another clip is opened."""

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
from inspector.widgets.file_dialog import ask_save_path

_AUTOSAVE_MS = 60_000  # time after the last step


@dataclass(eq=False, kw_only=True)
class Saving:
    """Saves the decisions of a review. Modal dialogs are shown only when the window closes.

    Decisions that are not saved stay in the journal. `tell_saved` is called when the session is on
    disk.
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
        """Ask for a path, and write the session to it."""
        if self.document.data is None:
            self.bar.show_message(tr("Open a clip first."), False)
            return
        if self._is_borrowed():
            return
        ask_save_path(
            self.window,
            tr("Save session as"),
            tr("Sessions") + f" (*{SESSION_SUFFIX})",
            lambda path: self.save_session(_named_session(path)),
            wanted=self.document.proposed(SESSION_SUFFIX, own=True),
        )

    def save_session(self, path: Path | None = None) -> bool:
        """Write the session to `path` or next to the clip. Return True if it is on disk."""
        self.detail.commit()
        if self._is_borrowed():
            return False
        saved, trouble = self.document.keeper.save(path)
        if saved:
            asks = self.bar.asks
            changed = self.document.recovery.check_clip()
            if changed and (asks or not self.bar.asks):  # if neither, the question is already shown
                own = tr("The session belongs to the version of the clip that is open.")
                trouble += f" {changed} {own}"
            self.tell_saved()
            if self.document.data is not None:
                self.queue.refresh(self.document.data.clip.path)
            if file := self.document.keeper.session_file:
                self.window.statusBar().showMessage(tr("Saved {file}", file=file), 4000)
        if trouble:
            self.bar.show_message(trouble.strip(), True)
        return saved

    def _is_borrowed(self) -> bool:
        """If a lesson or an exercise owns the clip, show why it is not saved, and return True."""
        if (borrowed := self.document.borrowed) is not None:
            self.bar.show_message(borrowed.why, False)
        return borrowed is not None

    # -- leaving a clip -----------------------------------------------------------------------

    def leave(self, then: Callable[[], object]) -> None:
        """Save unsaved decisions or keep them in the journal, then call `then`.

        If the user must be asked, the question is not modal.
        """
        self.lessons.hidden_errors.before_leaving(partial(self._leave, then))

    def _leave(self, then: Callable[[], object]) -> None:
        self.lessons.leave_guide()
        self.detail.commit()
        data = self.document.data
        if data is None or self._is_kept():
            then()
        elif self.settings.autosave:
            saved, trouble = self._save()
            if saved or self.document.keeper.journal.on_disk:
                then()
                self._report_later(trouble)
            else:
                self._report(trouble)
                name = data.clip.name
                text = tr("The decisions about {clip} cannot be saved.", clip=name)
                self._ask_to_leave(text, then)
        else:
            self._ask_to_leave(_unsaved_text(data.clip.name), then)

    def _ask_to_leave(self, text: str, then: Callable[[], object]) -> None:
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
        here = () if self.document.keeper.read_only else ((tr_as("do", "Save"), save),)
        self.bar.ask(text, (*here, elsewhere, without))

    def _is_kept(self) -> bool:
        """Return True if the review is saved or, as in a lesson, does not need to be saved."""
        return self.document.review.saved or self.document.borrowed is not None

    def save_quietly(self) -> bool:
        """Save the session. Return True if it is on disk. Only errors are shown.

        Clips of lessons and clips shipped with the program get no session, because the next user
        must find them unchanged. Their decisions stay in the journal.
        """
        saved, trouble = self._save()
        self._report(trouble)
        return saved

    def _save(self) -> tuple[bool, str]:
        """Save the session if possible.

        Returns True if the session is on disk, and an error message, or ''.
        """
        data = self.document.data
        bundled = data is not None and ASSETS in data.clip.path.parents
        if bundled or self.document.borrowed is not None:
            return False, ""
        saved, trouble = self.document.keeper.save()
        self.tell_saved()
        if saved and self.document.data is not None:
            self.queue.refresh(self.document.data.clip.path)
        return saved, trouble.strip()

    def _report(self, trouble: str) -> None:
        if trouble:
            self.bar.show_message(trouble, True)

    def _report_later(self, trouble: str) -> None:
        """Show an error message after the next clip has opened, because opening clears messages."""
        opener = self.document.opener
        if not (trouble and opener.busy):
            self._report(trouble)
            return
        once = Qt.ConnectionType.SingleShotConnection
        later = partial(QTimer.singleShot, 0, self.window, partial(self.bar.add_error, trouble))
        opener.over.connect(later, once)

    def _wait_to_save(self) -> None:
        if self.settings.autosave and not self.document.review.saved:
            self._idle.start()

    def _save_by_itself(self) -> None:
        if self.document.opener.busy or self.lessons.program.aside.open:
            self._idle.start()  # the changes may belong to the clip that was put aside
        elif self.document.data is None or self.document.review.saved:
            return
        elif not self.document.keeper.read_only and self.settings.autosave:
            self.save_quietly()

    def may_close(self, *, ask: bool = True) -> bool:
        """Return True if the window can close without losing any decision.

        Each decision must be saved, written to the journal, or discarded by the user. If `ask` is
        True, ask the user when necessary.
        """
        waits = self.lessons.hidden_errors.not_handed_in if ask else ""
        if waits and not self._closes_without_handing_in(waits):
            return False
        self.lessons.leave_guide()
        self.detail.commit()
        if not ask or self.document.data is None or self._is_kept():
            return True
        unsaved, trouble = _unsaved_text(self.document.data.clip.name), ""
        if self.settings.autosave:
            saved, trouble = self._save()
            if saved:
                return True  # other messages require no action by the user
            if self.document.keeper.journal.on_disk and not self.document.keeper.read_only:
                return not trouble or self._closes_unsaved(trouble)
        if self.document.keeper.read_only:
            return self._closes_read_only(f"{trouble} {unsaved}".strip())
        button = QMessageBox.StandardButton
        answer = QMessageBox.question(
            self.window,
            "Twist Inspector",
            f"{trouble} {unsaved}".strip(),
            button.Save | button.Discard | button.Cancel,
            button.Save,
        )
        if answer == button.Save:
            return self.save_session()
        if answer == button.Discard:
            self.document.keeper.journal.give_up()
        return answer == button.Discard

    def _closes_without_handing_in(self, text: str) -> bool:
        """Ask whether to hand in the decisions to a class. Return True to close the window now.

        If the user chooses to hand in, the window closes afterwards.
        """
        button = QMessageBox.StandardButton
        answer = self._ask_to_close(text, tr("Hand in…"), tr("Close without handing in"))
        if answer == button.Save:
            close = partial(QTimer.singleShot, 0, self.window, self.window.close)
            self.lessons.hidden_errors.ask_hand_in(close)
        return answer == button.Discard

    def _closes_read_only(self, text: str) -> bool:
        """Ask whether to save decisions elsewhere, because another window has locked the session.

        Returns True to close the window.
        """
        button = QMessageBox.StandardButton
        answer = self._ask_to_close(text, tr("Save elsewhere…"), tr("Close without saving"))
        if answer == button.Save:
            self.save_session_as()
        elif answer == button.Discard:
            self.document.keeper.journal.give_up()
        return answer == button.Discard

    def _ask_to_close(self, text: str, save: str, close: str) -> int:
        """Ask a question, and return the chosen button: Save, Discard or Cancel.

        `save` and `close` are the labels of the Save button and the Discard button.
        """
        button = QMessageBox.StandardButton
        buttons = button.Save | button.Discard | button.Cancel
        box = QMessageBox(QMessageBox.Icon.Question, "Twist Inspector", text, buttons, self.window)
        box.setDefaultButton(button.Save)
        box.button(button.Save).setText(save)
        box.button(button.Discard).setText(close)
        answer = box.exec()
        box.deleteLater()
        return answer

    def _closes_unsaved(self, trouble: str) -> bool:
        """Show why the session cannot be written. Return True to close the window anyway."""
        button = QMessageBox.StandardButton
        later = tr("You can restore the decisions the next time you start the program.")
        text = f"{trouble} {later}"
        buttons, default = button.Close | button.Cancel, button.Close
        answer = QMessageBox.warning(self.window, "Twist Inspector", text, buttons, default)
        return answer == button.Close


def _unsaved_text(clip: str) -> str:
    return tr("{clip} has unsaved decisions.", clip=clip)


def _named_session(path: Path) -> Path:
    """Return the path, with the suffix of session files added if it is missing."""
    return path if is_session(path) else path.with_name(path.name + SESSION_SUFFIX)
