"""Switch clips in quick succession: python -m benchmarks.switched_clips [--times 400] [--seed 1].

Another clip is repeatedly opened before the previous one is analysed. Meanwhile, random input is
simulated: edges, intervals and empty areas of the plots are dragged, rows are clicked, numbers and
notes are typed, menus and palettes are answered, and actions are triggered. The output shows the
memory at the end, and all exceptions and Qt warnings, of which there should be none.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("QT_API", "pyside6")

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractItemView, QApplication, QWidget

from benchmarks.alive import alive, heard, resident
from benchmarks.day_at_the_window import with_errors
from benchmarks.endurance import Sitting
from inspector.app import make_application
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait

ASSETS = Path(__file__).resolve().parent.parent / "assets"
_CLIPS = ("walk_injected.bvh", "dance.bvh", "walk.bvh", "basketball.bvh")
_WITH_ERRORS = ("walk.bvh", "dance.bvh")
# Actions that are not triggered: they end the program, ask for a file, open a clip of their own,
# or take seconds.
_LEFT_OUT = (
    "close", "full_screen", "open_dialog", "open_folder", "show_about", "go_to_frame",
    "save_session_as", "save_profile", "load_profile", "compare_profiles", "export_page",
    "open_lesson", "open_video", "record_dialog", "save_clip_table", "write_report", "show_guide",
    "theme_dark", "theme_light", "theme_system", "preferences", "show_shortcuts", "export_dialog",
    "export_at_once", "tour", "exercise", "keep_rig", "presentation", "why_quaternions",
    "track_joints",
)  # fmt: skip
_PRESSED = (Qt.Key.Key_1, Qt.Key.Key_Down, Qt.Key.Key_Return, Qt.Key.Key_Escape)
_LEFT = Qt.MouseButton.LeftButton
_KEYS = (
    Qt.KeyboardModifier.NoModifier,
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
)


@dataclass
class Hand:
    """A source of random actions. `held` is the plot in which the mouse button is held down."""

    window: MainWindow
    rng: random.Random
    held: QWidget | None = None
    done: Counter[str] = field(default_factory=Counter)

    def step(self) -> None:
        """Carry out one random action."""
        things = (self.pull, self.pull, self.let_go, self.row, self.popup, self.card)
        thing = self.rng.choice((*things, *(self.action,) * 3))
        thing()
        self.done[thing.__name__] += 1

    def _place(self, widget: QWidget) -> QPoint:
        x, y = (self.rng.randrange(max(1, n)) for n in (widget.width(), widget.height()))
        return QPoint(x, y)

    def pull(self) -> None:
        """Press the mouse button at an interval's edge or centre, or continue a drag."""
        window = self.window
        if self.held is not None:
            QTest.mouseMove(self.held, self._place(self.held))
            return
        shown = [pane for pane in window.timeline.panes.values() if pane.isVisible()]
        if not shown:
            return
        pane = self.rng.choice(shown)
        view, at = pane.viewport(), self._place(pane.viewport())
        if window.document.intervals and self.rng.random() < 0.8:
            interval = self.rng.choice(window.document.intervals).interval
            edges = interval.start - 0.5, interval.stop - 0.5
            frame = self.rng.choice((*edges, sum(edges) / 2.0))
            at = QPoint(round(pane.view.mapViewToDevice(QPointF(frame, 0.0)).x()), at.y())
        QTest.mousePress(view, _LEFT, Qt.KeyboardModifier.NoModifier, at)
        QTest.mouseMove(view, at + QPoint(15, 0))
        self.held = view

    def let_go(self) -> None:
        """Release the mouse button if it is held down."""
        if self.held is not None:
            at = self._place(self.held)
            QTest.mouseRelease(self.held, _LEFT, Qt.KeyboardModifier.NoModifier, at)
            self.held = None

    def row(self) -> None:
        """Click a random place in a table or list."""
        shown = [t for t in self.window.findChildren(QAbstractItemView) if t.isVisible()]
        view = self.rng.choice(shown).viewport()
        QTest.mouseClick(view, _LEFT, self.rng.choice(_KEYS), self._place(view))

    def popup(self) -> None:
        """Press a key in the open popup or dialog, if there is one."""
        box = QApplication.activePopupWidget() or QApplication.activeModalWidget()
        if box is not None:
            QTest.keyClick(box, self.rng.choice(_PRESSED))

    def card(self) -> None:
        """Change the frames of the selected interval by typing, and type a note."""
        card = self.window.detail
        for box in (card.start, card.stop):
            if box.isEnabled():
                box.setValue(box.value() + self.rng.choice((-3, 3)))
        if card.note.isEnabled():
            card.note.setText(f"{self.rng.random():.3f}")

    def action(self) -> None:
        """Trigger a random action."""
        names = [name for name in self.window.actions_by_id if name not in _LEFT_OUT]
        self.window.actions_by_id[self.rng.choice(names)].trigger()


def switch(window: MainWindow, clips: list[Path], times: int, seed: int) -> Counter[str]:
    """Open random clips one after the other. Return the actions carried out between them."""
    hand = Hand(window, random.Random(seed))
    sitting = Sitting(window, clips, hand.rng)
    sitting.open(clips[0])
    window.open_path(clips[0].parent)
    for k in range(times):
        window.open_path(hand.rng.choice(clips))
        for _ in range(hand.rng.randrange(8)):
            hand.step()
            if hand.rng.random() < 0.5:
                wait(hand.rng.choice((0, 0, 5, 20)))
        if hand.rng.random() < 0.5:
            sitting.wait(lambda: not window.document.opener.busy, "a clip opens")
        if k % 20 == 0:
            for other in QApplication.topLevelWidgets():
                if other.isVisible() and other is not window:
                    other.close()
    sitting.wait(lambda: not window.document.opener.busy, "the last clip opens")
    return hand.done


def main() -> int:
    """Run the test. Print the actions and the reported problems."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    app = make_application()
    with tempfile.TemporaryDirectory() as scratch, heard() as said:
        os.environ["XDG_STATE_HOME"] = str(Path(scratch, "state"))
        os.environ["TWIST_INSPECTOR_SETTINGS"] = str(Path(scratch, "settings.json"))
        folder = Path(scratch, "clips")
        folder.mkdir()
        clips = [Path(shutil.copy(ASSETS / name, folder)) for name in _CLIPS]
        for name in _WITH_ERRORS:
            clips.append(folder / f"errors_{name}")
            with_errors(ASSETS / name, clips[-1])
        window = MainWindow(Settings(theme="light", turn_ms=0), None)
        window.resize(1440, 900)
        window.show()
        QTest.qWaitForWindowExposed(window)
        done = switch(window, clips, chosen.times, chosen.seed)
        full, held = resident(), alive()
        window.document.review.mark_saved()
        window.close_without_asking()
        wait(200)
        app.processEvents()
    print(f"{chosen.times} switches, " + ", ".join(f"{n} × {what}" for what, n in done.items()))
    print(f"{full:.0f} MiB, of which {held.mib:.0f} are in use; {held.clips} clips alive")
    for text, n in Counter(said.wrong).most_common():
        print(f"reported {n} ×: {text}")
    print(f"{len(said.wrong)} exceptions and warnings")
    return 1 if said.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
