"""The program driving itself: a screenshot, or a whole review with its results."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from PySide6.QtCore import QObject, QTimer

from inspector.export import ExportChoice
from inspector.main_window import MainWindow

_SETTLE_MS = 350  # the views redraw once an event-loop turn; give them a few
_GIVE_UP_MS = 120_000


class _Script(QObject):
    """Runs steps once a clip is open, one after the other with time to redraw between them."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self.window = window
        self.code = 0
        self._steps: Iterator[Callable[[], None]] = iter(self.steps())
        window.document.opened.connect(self._next)
        window.document.message.connect(self._watch)
        QTimer.singleShot(_GIVE_UP_MS, self, self._give_up)

    def steps(self) -> list[Callable[[], None]]:
        """What to do, in order."""
        raise NotImplementedError

    def shoot(self, path: Path) -> None:
        """Save a picture of the window."""
        path.parent.mkdir(parents=True, exist_ok=True)
        if not self.window.grab().save(str(path)):
            print(f"{path}: the picture could not be written")
            self.code = 2

    def _next(self) -> None:
        QTimer.singleShot(_SETTLE_MS, self, self._step)

    def _step(self) -> None:
        step = next(self._steps, None)
        if step is None:
            self._finish()
            return
        step()
        self._next()

    def _watch(self, text: str, wrong: bool) -> None:
        if wrong:
            print(text)
            self.code = 2
            self._finish()

    def _give_up(self) -> None:
        print("the clip did not open in time")
        self.code = 2
        self._finish()

    def _finish(self) -> None:
        if self.window.document.data is not None:
            self.window.document.review.mark_saved()
        self.window.close()


class Screenshot(_Script):
    """Open, go to the first interval, take a picture."""

    def __init__(self, window: MainWindow, path: Path) -> None:
        self._path = path
        super().__init__(window)

    def steps(self) -> list[Callable[[], None]]:
        """See the class."""
        window = self.window
        return [window.next_interval, window.focus_chain, lambda: self.shoot(self._path)]


class Demo(_Script):
    """Judge every interval by the keys' own actions, export, leave a picture."""

    def __init__(self, window: MainWindow, folder: Path) -> None:
        self._folder = folder
        super().__init__(window)

    def steps(self) -> list[Callable[[], None]]:
        """See the class."""
        window = self.window
        return [
            window.next_interval,
            window.accept,
            window.accept,
            self._to_middle,
            window.focus_chain,
            lambda: self.shoot(self._folder / "inspector.png"),
            self._accept_rest,
            self._export,
        ]

    def _to_middle(self) -> None:
        if judged := self.window.document.interval:
            self.window.document.go_to((judged.interval.start + judged.interval.stop) // 2)

    def _accept_rest(self) -> None:
        for _ in self.window.document.intervals:
            self.window.accept()

    def _export(self) -> None:
        data = self.window.document.data
        assert data is not None
        self._folder.mkdir(parents=True, exist_ok=True)
        self.window.export(ExportChoice(self._folder / f"{data.clip.path.stem}_refined.bvh"))
        self.window.exporter.finish()
        print(self.window.bar.label.text())
