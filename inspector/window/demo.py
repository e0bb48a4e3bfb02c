"""Scripts that operate the window: one takes a screenshot, the other performs a whole review."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication, QMessageBox

from inspector.folder.feature import feature as folder
from inspector.folder.queued_clip import ClipState
from inspector.session.export_files import ExportChoice
from inspector.window.main_window import MainWindow
from twistcore.files.encoding import escape_control_characters
from twistcore.review import Decision

_SETTLE_MS = 350  # time in which the views are redrawn
_LOOK_MS = 200  # time between checks for an open dialog, which nobody would answer
_GIVE_UP_MS = 120_000


class Script(QObject):
    """A script that opens a file and then operates the window in steps.

    The window can redraw between the steps, and is closed after the last step. If a question or a
    dialog appears, the script fails, because there is no user to answer.

    Attributes
    ----------
    code
        The exit code: 0, or 2 after an error.
    """

    def __init__(
        self,
        window: MainWindow,
        path: Path | None,
        steps: Callable[[Script], list[Callable[[], None]]],
    ) -> None:
        """Create a script.

        Parameters
        ----------
        path
            A clip, a session or a folder; None for the empty window.
        steps
            A function that returns the steps in order. It is called when the clip is loaded.
        """
        super().__init__(window)
        self.window = window
        self.code = 0
        self._path, self._make_steps = path, steps
        self._over = False
        self._steps: Iterator[Callable[[], None]] | None = None
        document = window.document
        document.opened.connect(self._begin)
        document.message.connect(self._watch)
        document.question.connect(self._stop_at_question)
        window.part(folder).queue.changed.connect(self._folder_changed)
        self._dialogs = QTimer(self, interval=_LOOK_MS)
        self._dialogs.timeout.connect(self._look_for_dialog)
        self._dialogs.start()
        QTimer.singleShot(0, self, self._open)  # a running event loop is needed to close the window
        QTimer.singleShot(_GIVE_UP_MS, self, lambda: self.fail("The script did not end in time."))

    def shoot(self, path: Path) -> None:
        """Save a screenshot of the window. If the file cannot be written, the script fails."""
        path.parent.mkdir(parents=True, exist_ok=True)
        if not self.window.grab().save(str(path)):
            self.fail(f"{path}: the image could not be written.")

    def fail(self, text: str) -> None:
        """Print an error message and end the script."""
        if not self._over:
            print(escape_control_characters(text))
            self.code = 2
            self._finish()

    def _open(self) -> None:
        if self._path is None:
            self._begin()
        else:
            self.window.open_path(self._path)
            self._folder_changed()

    def _begin(self) -> None:
        if self._steps is None:
            self._steps = iter(self._make_steps(self))
            self._next()

    def _next(self) -> None:
        QTimer.singleShot(_SETTLE_MS, self, self._step)

    def _step(self) -> None:
        if self._over or self._steps is None:
            return
        looking = self.window.review_actions.look_through.running
        if self.window.viewport.turning or looking:  # take no screenshot while the camera moves
            self._next()
            return
        step = next(self._steps, None)
        if step is None:
            self._finish()
            return
        try:
            step()
        except OSError as error:
            self.fail(f"{error.filename} could not be written: {error.strerror}.")
        except Exception as error:  # nobody would see the error, and the script would never end
            self.fail(f"{type(error).__name__}: {error}")
        self._next()

    def _watch(self, text: str, wrong: bool) -> None:
        if wrong:
            self.fail(text)

    def _stop_at_question(self, text: str, _answers: object) -> None:
        if self._steps is None:  # a question asked while the clip is opened needs no answer
            self.fail(text)

    def _folder_changed(self) -> None:
        queue = self.window.part(folder).queue
        if self._steps is not None or queue.folder is None:
            return
        clips = queue.ordered
        if not clips:
            self.fail(f"{queue.folder}: there is no clip in this folder.")
        elif all(clip.state == ClipState.FAILED for clip in clips):
            self.fail(f"{queue.folder}: no clip can be opened: {clips[0].reason}")
        elif all(clip.state == ClipState.FAILED or clip.done for clip in clips):
            self.fail(f"{queue.folder}: all clips are decided already.")

    def _look_for_dialog(self) -> None:
        dialog = QApplication.activeModalWidget()
        if dialog is not None and not self._over:
            text = dialog.text() if isinstance(dialog, QMessageBox) else dialog.windowTitle()
            dialog.close()
            self.fail(f"A script cannot answer this question: {text}")

    def _finish(self) -> None:
        self._over = True
        if self.window.document.data is not None:
            self.window.document.review.mark_saved()
        self.window.close_without_asking()


def screenshot_script(window: MainWindow, picture: Path, path: Path | None) -> Script:
    """Return a script that saves a screenshot of a clip's first interval or the empty window."""

    def steps(script: Script) -> list[Callable[[], None]]:
        review, shoot = window.review_actions, partial(script.shoot, picture)
        if window.document.data is None:
            return [shoot]
        return [partial(review.step_interval, +1), review.look, shoot]

    return Script(window, path, steps)


def demo_script(window: MainWindow, folder: Path, path: Path) -> Script:
    """Return a script that accepts every interval, exports the clip and saves a screenshot."""
    folder = folder.absolute()  # the exporter would resolve a relative path from the clip's folder
    review, document = window.review_actions, window.document
    accept = partial(review.decide, Decision.ACCEPTED)

    def to_middle() -> None:
        if judged := document.interval:
            document.go_to((judged.interval.start + judged.interval.stop) // 2)

    def accept_rest() -> None:
        left = [j.id for j in document.intervals if j.decision != Decision.ACCEPTED]
        if left:
            document.decide(Decision.ACCEPTED, left)

    def steps(script: Script) -> list[Callable[[], None]]:
        def export() -> None:
            assert document.data is not None
            folder.mkdir(parents=True, exist_ok=True)
            clip = document.data.clip
            target = folder / f"{clip.path.stem}_refined.{clip.format}"
            # Replace the files of an earlier run
            window.files.export(ExportChoice(target, replace=True))
            window.exporter.finish()
            if not script.code:
                print(escape_control_characters(window.bar.label.text()))

        shoot = partial(script.shoot, folder / "inspector.png")
        first = partial(review.step_interval, +1)
        return [first, accept, accept, to_middle, review.look, shoot, accept_rest, export]

    return Script(window, path, steps)
