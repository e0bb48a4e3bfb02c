"""Show the errors of groups one after the other, before a decision applies to all of them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from weakref import WeakSet

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtGui import QGuiApplication
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
_MOST_CHECKS = 200  # without a painted error, that is about two seconds


class LookThrough(QObject):
    """Shows the errors of groups that have not been painted yet, and then calls a function.

    Each error is shown for a while, and at least until one of its frames has been painted. If the
    3D view is hidden, the error does not count as painted.

    The function is not called if the user presses Esc, selects something else, changes the review,
    opens a menu or a dialog, minimises the window or goes to another program, or if nothing is
    painted for about two seconds.
    """

    began = Signal(int, int)  # with the numbers of errors to show, and of errors not yet painted
    showing = Signal(int, int)  # with the number of this error, and the number of errors to show
    # The decision was not made; True if this was not reported and nothing else was changed
    stopped = Signal(bool)
    done = Signal(int, int)  # with the numbers of errors that were painted, and that were decided

    def __init__(
        self, document: Document, intervals: IntervalsPanel, player: Player, viewport: Viewport
    ) -> None:
        """Prepare the object. `intervals` is the table in which the groups are selected."""
        super().__init__(viewport)
        self._document, self._intervals = document, intervals
        self._player, self._viewport = player, viewport
        self._painted = WeakSet[Interval]()  # since the clip was opened
        self._decided: tuple[Judged, ...] = ()
        self._left: list[int] = []
        self._count = 0  # number of errors to show
        self._milliseconds = 0
        self._checks = 0  # number of checks whether this error has been painted
        self._then: Callable[[], bool] | None = None
        self._state: ReviewState | None = None  # the review when the first error was shown
        self._rows = frozenset[int]()  # ids of the intervals in the selected rows at that time
        # The selected interval and the frame while an error is shown
        self._expected: tuple[int | None, int] | None = None
        self._moving = False
        self._away = False  # since the first error was shown
        self._timer = QTimer(self, singleShot=True)
        self._timer.timeout.connect(self._step)
        self._escape = DragEscape(document, self.stop, self)
        viewport.interval_painted.connect(self._note_painted)
        document.leaving.connect(self.stop)
        document.opened.connect(self._painted.clear)
        document.frame_changed.connect(self._check)
        document.interval_changed.connect(self._check)
        document.intervals_changed.connect(self._check)
        intervals.ids_changed.connect(self._check)
        app = QGuiApplication.instance()
        assert isinstance(app, QGuiApplication)
        app.applicationStateChanged.connect(self._application_changed)

    @property
    def running(self) -> bool:
        """True while errors are being shown."""
        return self._then is not None

    def begin(
        self,
        decided: Iterable[Judged],
        grouped: Collection[int],
        milliseconds: int,
        then: Callable[[], bool],
    ) -> None:
        """Show the errors of groups that were not painted yet, and call `then` after that.

        If all were painted, call `then` now.

        Parameters
        ----------
        decided
            The intervals that the decision changes.
        grouped
            The ids of the intervals in the selected groups. Only these are shown.
        milliseconds
            The minimum time for which each error is shown.
        then
            The function that makes the decision and returns False on failure.
        """
        document, decided = self._document, tuple(decided)
        unseen = [j for j in decided if j.id in grouped and j.interval not in self._painted]
        worst = {j.id for j in sorted(unseen, key=document.severity, reverse=True)[:MOST]}
        if not worst:
            then()
            return
        self._left = [judged.id for judged in unseen if judged.id in worst]
        self._decided, self._count, self._then = decided, len(worst), then
        self._milliseconds, self._away = milliseconds, False
        self._state = document.review.state
        self._rows = frozenset(self._intervals.selected_ids())
        self._escape.begin()
        self.began.emit(self._count, len(unseen))
        self._show_next()

    def stop(self) -> bool:
        """Stop without a decision. Returns False if nothing is being shown."""
        if not self.running:
            return False
        self._end()
        self.stopped.emit(self._document.review.state is self._state)
        return True

    def _end(self) -> None:
        self._then, self._expected = None, None
        self._timer.stop()
        self._escape.end()

    def _show_next(self) -> None:
        self._moving = True
        with self._intervals.visit_order(), self._intervals.keep_selection():
            self._document.select_interval(self._left.pop(0), jump=True)
        self._moving = False
        self._expected = self._now()
        self._check()  # a filter by chain may have changed the rows
        if self.running:
            self._checks = 0
            self._timer.start(self._milliseconds)
            self.showing.emit(self._count - len(self._left), self._count)

    def _now(self) -> tuple[int | None, int]:
        frame = -1 if self._player.playing else self._document.frame
        return self._document.interval_id, frame

    def _check(self) -> None:
        """Stop if the user has selected, decided or edited something, or moved the playhead."""
        if not self.running or self._moving:
            return
        same = self._now() == self._expected and self._document.review.state is self._state
        if not same or frozenset(self._intervals.selected_ids()) != self._rows:
            self.stop()

    def _application_changed(self, state: Qt.ApplicationState) -> None:
        """Remember whether the user has gone to another program.

        A popup that closes may do the same for a moment, so `_step` stops, and not this method.
        """
        self._away = state != Qt.ApplicationState.ApplicationActive

    def _note_painted(self) -> bool:
        """Return True if a frame of the selected interval is painted, and remember the interval."""
        judged, frame = self._document.interval, self._viewport.painted_frame
        if judged is None or frame is None:
            return False
        interval = judged.interval
        painted = interval.start <= frame < interval.stop or frame == interval.seen_at
        if painted:
            self._painted.add(interval)
        return painted

    def _step(self) -> None:
        others = QApplication.activeModalWidget(), QApplication.activePopupWidget()
        window = self._viewport.window()
        unseen = self._away or window.isMinimized() or not window.isVisible()
        if unseen or any(others):
            self.stop()
        elif not self._note_painted() and not self._viewport.is_hidden:
            self._checks += 1
            if self._checks > _MOST_CHECKS:
                self.stop()
            else:
                self._timer.start(_AGAIN_MS)
        elif self._left:
            self._show_next()
        else:
            self._finish()

    def _finish(self) -> None:
        then = self._then
        assert then is not None
        self._end()
        painted = sum(judged.interval in self._painted for judged in self._decided)
        if then():
            self.done.emit(painted, len(self._decided))
        else:
            self.stopped.emit(False)
