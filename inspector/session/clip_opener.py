"""Opening a clip or a session in the background; what was open stays until the new one is there."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal, SignalInstance

from inspector.language import tr
from inspector.session.opening import ClipMissingError, analyse_file, analyse_session
from inspector.widgets.background import OneTask
from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.tuning import Profile
from twistcore.work.progress import Tell

_Made = TypeVar("_Made")
_WONDER_S = 1.0  # seconds until a person begins to wonder how far it is


class ClipOpener(QObject):
    """Reads and analyses one clip at a time: whatever is opened next takes its place."""

    began = Signal(str)  # what is being done
    share = Signal(float)  # how far that is, 0…1, where a person would begin to wonder
    over = Signal()  # it is done, cannot be done or was cancelled
    analysed = Signal(object)  # the clip, as Analysed
    locate = Signal(object)  # the clip of this session file is asked for

    def __init__(self, tell: SignalInstance, ask: SignalInstance, parent: QObject) -> None:
        """`tell`, `ask`: the document's `message` and `question`."""
        super().__init__(parent)
        self._tell, self._ask = tell, ask
        self._task = OneTask(self)
        self._since = 0.0

    @property
    def busy(self) -> bool:
        """Whether a clip is being read."""
        return self._task.running

    def open(self, path: Path, profile: Profile | None = None) -> None:
        """Open a clip; profile: τ for one that has no session yet."""
        what = tr("Opening {name}", name=path.name)
        self._start(what, lambda tell: analyse_file(path, profile, tell), self.analysed.emit)

    def open_session(self, path: Path, clip: Path | None = None) -> None:
        """Open a session and its clip, which may have moved to `clip`."""
        what = tr("Opening {name}", name=path.name)
        self._start(what, lambda tell: analyse_session(path, clip, tell), self.analysed.emit)

    def ask(self, clip: ClipAnalysis, method: str, then: Callable[[], object]) -> None:
        """Let a detector analyse the open clip; at once where it has done so before."""
        if clip.kept(method) is not None:
            then()
        else:
            what = tr("Detecting in {clip}", clip=clip.name)
            self._start(what, lambda tell: clip.by(method, tell), lambda _: then())

    def prepare(
        self, what: str, work: Callable[[Tell], _Made], then: Callable[[_Made], object]
    ) -> None:
        """Work for the open clip in the background, which changes nothing until it is done."""
        self._start(what, work, then)

    def cancel(self) -> None:
        """Give up what is being opened."""
        if self.busy:
            self._task.cancel()
            self.over.emit()

    def _start(self, what: str, work: Callable[[Tell], Any], then: Callable[[Any], object]) -> None:
        def done(result: object) -> None:
            self.over.emit()
            then(result)

        self._since = time.monotonic()
        self._task.run(work, done, self._fail, self._tell_share)
        self.began.emit(what)

    def _tell_share(self, share: float) -> None:
        if time.monotonic() - self._since > _WONDER_S:
            self.share.emit(share)

    def _fail(self, error: Exception) -> None:
        self.over.emit()
        if isinstance(error, ClipMissingError):
            session = error.session
            self._ask.emit(str(error), ((tr("Locate it…"), lambda: self.locate.emit(session)),))
        else:
            self._tell.emit(str(error), True)
