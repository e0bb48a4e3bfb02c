"""Open clips and sessions in the background.

The previous clip stays open until the new one has been read.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal, SignalInstance
from shiboken6 import isValid

from inspector.language import tr
from inspector.session.first_look import FirstLook, first_look
from inspector.session.opening import ClipMissingError, analyse_file, analyse_session
from inspector.widgets.background import OneTask, run_in_gui_thread
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.formats.clip import Clip
from twistcore.tuning import Profile
from twistcore.work.progress import Tell

_Made = TypeVar("_Made")
_WONDER_S = 1.0  # seconds until progress is shown


class ClipOpener(QObject):
    """Reads and analyses one clip at a time in the background.

    A new request cancels the previous one.
    """

    began = Signal(str)  # a description of the work
    read = Signal(object)  # with a FirstLook: the clip was read, and is being analysed
    share = Signal(float)  # progress, 0…1, of slow work
    over = Signal()  # the work has ended, failed or was cancelled
    analysed = Signal(object)  # with an Analysed: the clip was read and analysed
    locate = Signal(object)  # with the path of a session file: ask the user for its clip

    def __init__(self, tell: SignalInstance, ask: SignalInstance, parent: QObject) -> None:
        """Create an opener that has not opened a clip yet.

        `tell` and `ask` are the document's signals `message` and `question`.
        """
        super().__init__(parent)
        self._tell, self._ask = tell, ask
        self._task = OneTask(self)
        self._since = 0.0
        self._request = 0  # number of requests to open a clip

    @property
    def busy(self) -> bool:
        """Return True while work is running in the background."""
        return self._task.running

    def open(self, path: Path, profile: Profile | None = None) -> None:
        """Open a clip in the background.

        `profile` contains the threshold τ for each chain. It is used if the clip has no session.
        """
        what, seen = tr("Opening {name}", name=path.name), self._first_look()
        self._start(what, lambda tell: analyse_file(path, profile, tell, seen), self.analysed.emit)

    def open_session(self, path: Path, clip: Path | None = None) -> None:
        """Open a session and its clip in the background.

        If the clip was moved, `clip` is its new path.
        """
        what, seen = tr("Opening {name}", name=path.name), self._first_look()
        self._start(what, lambda tell: analyse_session(path, clip, tell, seen), self.analysed.emit)

    def ask(self, clip: ClipAnalysis, method: str, then: Callable[[], object]) -> None:
        """Call `then` as soon as the detector `method` has analysed the clip.

        If the clip has not been analysed with this detector yet, start the analysis in the
        background.
        """
        if clip.kept(method) is not None:
            then()
        else:
            what = tr("Detecting errors in {clip}", clip=clip.name)
            self._start(what, lambda tell: clip.by(method, tell), lambda _: then())

    def prepare(
        self, what: str, work: Callable[[Tell], _Made], then: Callable[[_Made], object]
    ) -> None:
        """Run `work` for the open clip in the background, then call `then` with the result.

        `what` describes the work and is shown with the progress bar.
        """
        self._start(what, work, then)

    def cancel(self) -> None:
        """Cancel any background work, such as opening a clip."""
        if self.busy:
            self._task.cancel()
            self.over.emit()

    def _start(self, what: str, work: Callable[[Tell], Any], then: Callable[[Any], object]) -> None:
        def done(result: object) -> None:
            self.over.emit()
            then(result)

        self._since = time.monotonic()
        self._task.run(work, done, self._fail, self._show_progress)
        self.began.emit(what)

    def _first_look(self) -> Callable[[Clip], None]:
        """Return a function that shows the clip of the work that starts next, if it still runs."""
        self._request += 1
        request = self._request

        def show(look: FirstLook) -> None:
            if isValid(self) and self.busy and request == self._request:
                self.read.emit(look)

        def seen(clip: Clip) -> None:
            with suppress(Exception):  # without a picture, the clip is opened all the same
                run_in_gui_thread(partial(show, first_look(clip)))

        return seen

    def _show_progress(self, share: float) -> None:
        if time.monotonic() - self._since > _WONDER_S:
            self.share.emit(share)

    def _fail(self, error: Exception) -> None:
        self.over.emit()
        if isinstance(error, ClipMissingError):
            session = error.session
            self._ask.emit(str(error), ((tr("Locate clip…"), lambda: self.locate.emit(session)),))
        else:
            self._tell.emit(str(error), True)
