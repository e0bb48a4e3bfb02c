"""Play a clip in real time. Frames are skipped if drawing is too slow."""

from __future__ import annotations

from PySide6.QtCore import QElapsedTimer, QObject, QTimer, Signal

from inspector.session.document import Document

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
_TICK_MS = 16
_AROUND_S = 0.5
_EDGE_S = 0.25  # seconds on either side of an edge


class Player(QObject):
    """Moves the document's playhead in real time, and restarts from the first frame at the end."""

    changed = Signal()  # playing has started or stopped, or the speed has changed

    def __init__(self, document: Document, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._document = document
        self._timer = QTimer(self, interval=_TICK_MS)
        self._timer.timeout.connect(self._tick)
        self._clock = QElapsedTimer()
        self._start = 0
        self._shown = 0
        self.speed = 1.0
        self.looping = False
        # The frames [first, stop) to play once, and the frame to stop at
        self._once: tuple[int, int, int] | None = None
        document.opened.connect(self.pause)

    @property
    def playing(self) -> bool:
        """Return True while the clip is playing."""
        return self._timer.isActive()

    def toggle(self) -> None:
        """Play or pause."""
        if self.playing:
            self.pause()
        elif self._document.frames > 1:
            self._begin()
            self._timer.start()
            self.changed.emit()

    def pause(self) -> None:
        """Stop playing without moving the playhead."""
        if self.playing:
            self._timer.stop()
            self._once = None
            self.changed.emit()

    def play_edge(self, *, other: bool = False) -> bool:
        """Play once across the beginning or end of the selected interval.

        The edge nearer to the playhead is played or, if `other` is True, the farther one. Returns
        False if no interval is selected.
        """
        document = self._document
        if (judged := document.interval) is None or document.data is None:
            return False
        edges = judged.interval.start, min(judged.interval.stop, document.frames - 1)
        near, far = sorted(edges, key=lambda edge: abs(edge - document.frame))
        edge = far if other else near
        around = max(2, round(_EDGE_S * document.data.motion.fps))
        first, stop = max(0, edge - around), min(document.frames, edge + around + 1)
        self.pause()
        document.go_to(first)
        self._once = first, stop, edge
        self._begin()
        self._timer.start()
        self.changed.emit()
        return True

    def set_loop(self, on: bool) -> None:
        """Start or stop looping over the selected interval, plus half a second on each side."""
        self.looping = on
        self._begin()

    def span(self) -> tuple[int, int]:
        """Return the frames [first, stop) to play: the loop or, without a loop, the whole clip."""
        frames = self._document.frames
        judged = self._document.interval
        if not self.looping or judged is None or self._document.data is None:
            return 0, frames
        around = round(_AROUND_S * self._document.data.motion.fps)
        return max(0, judged.interval.start - around), min(frames, judged.interval.stop + around)

    def set_speed(self, speed: float) -> None:
        """Set the speed as a multiple of real time; a negative speed plays backwards."""
        self.speed = speed
        self._begin()
        self.changed.emit()

    def step_speed(self, direction: int) -> None:
        """Switch to the next faster (+1) or slower (−1) speed of SPEEDS."""
        magnitude = abs(self.speed)
        at = min(range(len(SPEEDS)), key=lambda k: abs(SPEEDS[k] - magnitude)) + direction
        self.set_speed(SPEEDS[max(0, min(at, len(SPEEDS) - 1))])

    def _begin(self) -> None:
        self._start = self._shown = self._document.frame
        self._clock.start()

    def _tick(self) -> None:
        if (data := self._document.data) is None:
            self.pause()
            return
        if self._document.frame != self._shown:  # the user has moved the playhead
            self._once = None
            self._begin()
        passed = self._clock.elapsed() / 1000.0 * self.speed * data.motion.fps
        if self._once is not None:
            first, stop, edge = self._once
            if first + abs(passed) >= stop:
                self.pause()
                self._document.go_to(edge)
            else:
                self._shown = first + int(abs(passed))
                self._document.go_to(self._shown)
            return
        first, stop = self.span()
        self._shown = first + int(self._start + passed - first) % (stop - first)
        self._document.go_to(self._shown)
