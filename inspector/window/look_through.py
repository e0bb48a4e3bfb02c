"""Show the errors of a group one after the other, before a decision applies to all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from weakref import WeakSet

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QApplication

from inspector.panels.intervals_panel import IntervalsPanel
from inspector.session.document import Document
from inspector.session.player import Player
from inspector.timeline.drag_escape import DragEscape
from inspector.viewport.viewport import Viewport
from twistcore.detection import Interval
from twistcore.review import Judged, ReviewState

MOST = 12  # maximum number of errors to show; of a larger group, only the worst are shown
_AGAIN_MS = 10  # time between two checks whether an error has been painted


class LookThrough(QObject):
    """Shows the errors of a group that have not been painted yet, and then calls a function.

    Each error is shown for a while, and at least until it has been painted. Esc, another selection,
    a change of the review, a menu and a dialog stop this, and the function is not called.
    """

    began = Signal(int, int)  # with the numbers of errors to show, and of errors not yet painted
    showing = Signal(int, int)  # with the number of this error, and the number of errors to show
    stopped = Signal()  # not all errors were shown
    done = Signal(int, int)  # with the numbers of errors that were painted, and in the group

    def __init__(
        self, document: Document, intervals: IntervalsPanel, player: Player, viewport: Viewport
    ) -> None:
        """Prepare the object. `intervals` is the table in which the group is selected."""
        super().__init__(viewport)
        self._document, self._intervals = document, intervals
        self._player, self._viewport = player, viewport
        self._painted = WeakSet[Interval]()  # since the clip was opened
        self._group: tuple[int, ...] = ()
        self._left: list[int] = []
        self._count = 0  # number of errors to show
        self._milliseconds = 0
        self._then: Callable[[], object] | None = None
        # The selected interval, the frame and the state of the review while an error is shown
        self._expected: tuple[int | None, int, ReviewState] | None = None
        self._moving = False
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._step)
        self._escape = DragEscape(document, self.stop, self)
        viewport.interval_painted.connect(self._note_painted)
        document.leaving.connect(self.stop)
        document.opened.connect(self._painted.clear)
        document.frame_changed.connect(self._check)
        document.interval_changed.connect(self._check)
        document.intervals_changed.connect(self._check)

    @property
    def running(self) -> bool:
        """True while the errors of a group are being shown."""
        return self._then is not None

    def begin(self, group: Iterable[Judged], milliseconds: int, then: Callable[[], object]) -> None:
        """Show the errors of a group that were not painted yet, and call `then` after that.

        If all were painted, call `then` now. `milliseconds` is the minimum time for each error.
        """
        document, group = self._document, tuple(group)
        unseen = [judged for judged in group if judged.interval not in self._painted]
        worst = {j.id for j in sorted(unseen, key=document.severity, reverse=True)[:MOST]}
        if not worst:
            then()
            return
        self._left = [judged.id for judged in unseen if judged.id in worst]
        self._group, self._count, self._then = tuple(j.id for j in group), len(worst), then
        self._milliseconds = milliseconds
        self._escape.begin()
        self.began.emit(self._count, len(unseen))
        self._show_next()

    def stop(self) -> bool:
        """Stop without a decision. Returns False if nothing is being shown."""
        if not self.running:
            return False
        self._end()
        self.stopped.emit()
        return True

    def _end(self) -> None:
        self._then, self._expected = None, None
        self._timer.stop()
        self._escape.end()

    def _show_next(self) -> None:
        self._moving = True
        with self._intervals.visit_order():  # so that the group remains selected
            self._document.select_interval(self._left.pop(0), jump=True)
        self._moving = False
        self._expected = self._now()
        self._timer.start(self._milliseconds)
        self.showing.emit(self._count - len(self._left), self._count)

    def _now(self) -> tuple[int | None, int, ReviewState]:
        frame = -1 if self._player.playing else self._document.frame
        return self._document.interval_id, frame, self._document.review.state

    def _check(self) -> None:
        """Stop if the user has selected, decided or edited something, or moved the playhead."""
        if self.running and not self._moving and self._now() != self._expected:
            self.stop()

    def _note_painted(self) -> None:
        judged = self._document.interval
        if judged is not None and self._viewport.has_painted_interval():
            self._painted.add(judged.interval)

    def _step(self) -> None:
        others = QApplication.activeModalWidget(), QApplication.activePopupWidget()
        if not self._viewport.window().isVisible() or any(others):
            self.stop()
        elif not self._viewport.has_painted_interval():
            self._timer.start(_AGAIN_MS)
        else:
            self._note_painted()  # also if the 3D view is hidden
            if self._left:
                self._show_next()
            else:
                self._finish()

    def _finish(self) -> None:
        then = self._then
        assert then is not None
        self._end()
        found = map(self._document.found, self._group)
        painted = sum(judged is not None and judged.interval in self._painted for judged in found)
        then()
        self.done.emit(painted, len(self._group))
