"""Go to the automatic correction in the folder whose verdict would be most informative."""

from __future__ import annotations

from inspector.feature import HostWindow
from inspector.folder.informative_intervals import Informative, InformativeIntervals
from inspector.folder.queue import FolderQueue
from inspector.language import tr


class InformativeStep:
    """Opens the clip of the most informative automatic correction, and selects the interval."""

    def __init__(
        self, intervals: InformativeIntervals, queue: FolderQueue, window: HostWindow
    ) -> None:
        self._intervals, self._queue, self._window = intervals, queue, window
        self._wanted: Informative | None = None  # set while its clip is being opened
        intervals.found.connect(self._go)
        window.document.opened.connect(self._arrive)

    def next(self) -> None:
        """Look for the most informative interval without a verdict, and go to it."""
        self._intervals.look()

    def _go(self, found: Informative | None) -> None:
        if found is None:
            self._window.bar.show_message(self._nothing(), False)
            return
        self._wanted = found
        data = self._window.document.data
        if data is not None and data.clip.path == found.path:
            self._arrive()
        else:
            self._window.open_path(found.path)

    def _nothing(self) -> str:
        if self._queue.folder is None:
            return tr("Open a folder first (Ctrl+Shift+O).")
        if self._queue.running:
            return tr("The folder is still being analysed.")
        if self._intervals.ordered:
            return tr("Every automatic correction in this folder has a verdict.")
        return tr("No clip in this folder has an automatic correction.")

    def _arrive(self) -> None:
        """Select the most informative interval after its clip has been opened."""
        wanted, document = self._wanted, self._window.document
        data = document.data
        if wanted is None or data is None:
            return
        self._wanted = None
        if data.clip.path != wanted.path:  # another clip was opened instead
            return
        for judged in document.intervals:
            if wanted.correction.is_in(judged.interval):
                document.select_interval(judged.id, jump=True)
                return
        self._window.bar.show_message(
            tr("The proposed interval is no longer listed in {clip}.", clip=wanted.path.name), False
        )
