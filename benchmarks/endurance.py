"""Use the window for an hour: python -m benchmarks.endurance FOLDER [--minutes 60] [--seed 1].

Copies of the folder's clips, with random errors, are reviewed repeatedly in the real window.
Intervals are judged with the keyboard, edited and dragged, and steps are undone and redone. τ is
dragged, and the tuning tab and the teaching tab with its gizmo and what-if sliders are used. Clips
are exported with a report, and other clips are opened while they are being analysed. The folder
queue, dialogs and lessons are opened and closed.

Every minute, while the first clip is open and nothing is running, living objects are counted. The
run fails if memory grows by more than 5 % after minute ten (or a fifth of the time, if sooner), if
the number of windows, widgets, threads, processes, files, clips, reviews or intervals grows, or if
an exception or a Qt warning occurs.
"""

from __future__ import annotations

import argparse
import os
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("QT_API", "pyside6")

import numpy as np
from PySide6.QtCore import Qt, QThreadPool, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QWidget

from benchmarks.alive import Alive, Said, alive, children, heard
from benchmarks.day_at_the_window import with_errors
from inspector.app import exclude_from_collection, make_application
from inspector.session.export_files import ExportChoice
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from twistcore.analysis.decomposition import WhatIf
from twistcore.detection.interval_offsets import resized_interval
from twistcore.formats.clip_files import BVH, clip_paths_in_folder

MOST = 1.05  # largest allowed memory as a multiple of the memory at minute ten
SETTLED = 10.0  # minutes until caches reach their final size
_PATIENCE = 120.0  # seconds for any single action
# Counts that must not grow.
_LEVEL = ("files", "threads", "processes", "windows", "widgets", "ours", "clips", "analyses")
_OF_REVIEW = ("reviews", "states", "intervals")
_LESSONS = ("tour", "exercise")
_DIALOGS = (
    "open_dialog", "save_session_as", "export_dialog", "preferences", "command_palette",
    "show_shortcuts", "show_about", "record_dialog", "add_chain", "go_to_frame", "reject_for",
    "accept_confident", "open_lesson", "export_page", "load_profile", "show_guide",
    "why_quaternions",
)  # fmt: skip
_LOOKS = ("skin", "side_by_side", "trails", "colour_by_offset", "both_detectors", "presentation")


@dataclass
class Sitting:
    """A simulated user at a window. `done` counts how often each action was carried out."""

    window: MainWindow
    clips: list[Path]
    rng: random.Random
    done: Counter[str] = field(default_factory=Counter)

    # -- input and waiting ------------------------------------------------------------------------

    def wait(self, ready: Callable[[], bool], what: str) -> None:
        """Run the event loop until a condition holds. Raises TimeoutError with the text `what`."""
        end = time.monotonic() + _PATIENCE
        while not ready():
            if time.monotonic() > end:
                raise TimeoutError(what)
            wait(5)

    def key(self, key: Qt.Key) -> None:
        """Press a key in the window."""
        QTest.keyClick(self.window, key)
        wait(2)

    def act(self, name: str) -> None:
        """Trigger an action if it is enabled."""
        self.window.actions_by_id[name].trigger()
        wait(2)

    def quiet(self) -> None:
        """Wait until no work is running: opening, export, survey, typesetting or measurement."""
        window = self.window

        def idle() -> bool:
            busy = window.document.opener.busy or window.exporter.running or window.queue.running
            return not busy and QThreadPool.globalInstance().activeThreadCount() == 0

        self.wait(idle, "it does not come to rest")
        wait(100)
        self.wait(idle, "it does not come to rest")

    def open(self, path: Path) -> None:
        """Open a clip and wait until it is loaded."""
        window = self.window
        window.open_path(path)
        self.wait(
            lambda: not window.document.opener.busy and window.document.data is not None, "open"
        )
        assert window.document.data is not None
        self.done["open"] += 1
        for button in window.bar.buttons():
            if button.text() in ("Restore", "Forget them"):
                button.click()
                break
        wait(2)

    # -- actions --------------------------------------------------------------------------------

    def judge(self) -> None:
        """Decide on intervals with the keyboard, and undo some of these decisions."""
        for _ in range(4):
            self.act("next_interval")
            self.key(self.rng.choice([Qt.Key.Key_A, Qt.Key.Key_A, Qt.Key.Key_R]))
        for name in self.rng.choices(("undo", "redo", "reset", "turn_end"), k=4):
            self.act(name)

    def edit(self) -> None:
        """Drag an edge of an interval, and insert, change and remove an interval by hand."""
        document = self.window.document
        self.act("next_of_all")
        if (judged := document.interval) is not None and judged.interval.repairable:
            drag = document.begin_drag()
            for more in range(1, 6):
                interval = judged.interval
                document.edit(
                    judged.id,
                    resized_interval(interval, interval.start, interval.stop + more),
                    drag,
                )
                wait(2)
        document.select_interval(None)
        document.go_to(document.frames // 2)
        self.act("insert_interval")
        self.act("make_following")
        self.act("make_level")
        self.act("remove_interval")
        self.act("undo")

    def scrub(self) -> None:
        """Move the playhead through the whole clip, change display options, and play briefly."""
        document, look = self.window.document, self.rng.choice(_LOOKS)
        self.act(look)
        for frame in self.rng.choices(range(document.frames), k=10):
            document.go_to(frame)
            wait(2)
        self.act("toggle_play")
        wait(100)
        self.act("toggle_play")
        self.act(look)

    def drag_tau(self) -> None:
        """Drag the τ of a chain up, and undo this."""
        document = self.window.document
        assert document.data is not None
        chain = self.rng.choice(document.data.chains_and_limbs).name
        document.select_chain(chain)
        drag = document.begin_drag()
        for tau in np.geomspace(0.02, 1.0, 12):
            document.set_tau(float(tau) * self.rng.uniform(0.9, 1.1), chain, drag)
            wait(2)
        self.act("undo")

    def tune(self) -> None:
        """Show the tuning tab for a while, so that it measures."""
        self.act("show_tuning")
        wait(600)
        self.act("suggest_tau")
        bring = self.window.docks["intervals"]
        bring.raise_()
        wait(20)

    def teach(self) -> None:
        """Use the teaching tab: its gizmo, what-if sliders and stages."""
        window = self.window
        self.act("show_teaching")
        for chain in window.document.data.chains[:3] if window.document.data else ():
            window.document.select_chain(chain.name)
            for turn in self.rng.choices(range(-150, 150), k=3):
                window.taught.set_what_if(WhatIf(twist=float(np.radians(turn)), counter=True))
                wait(5)
        window.taught.reset()
        window.docks["intervals"].raise_()
        wait(20)

    def other_detector(self) -> None:
        """Switch to the paper's detector and back to the default one."""
        for method in ("use_paper", "use_consistency"):
            self.act(method)
            self.wait(lambda: not self.window.document.opener.busy, method)

    def export(self) -> None:
        """Export with a report into a temporary folder."""
        self.window.document.accept_undecided()
        with tempfile.TemporaryDirectory() as folder:
            self.window.files.export(ExportChoice(Path(folder) / "corrected.bvh"))
            self.wait(lambda: not self.window.exporter.running, "export")
        self.act("save_session")

    def switch(self) -> None:
        """Open clips before the previous one is loaded, with many commands in between."""
        window = self.window
        names = ["accept", "reject", "undo", "redo", "next_interval", "next_faint", "why_not",
                 "start_here", "insert_interval", "turn_end", "focus_chain", "reset", "use_paper",
                 "toggle_play", "show_tuning", "show_teaching", "next_clip", "play_edge",
                 "use_consistency", "zoom_to_interval"]  # fmt: skip
        for _ in range(10):
            window.open_path(self.rng.choice(self.clips))
            for name in self.rng.choices(names, k=3):
                self.act(name)
            wait(self.rng.choice((0, 5, 40, 200)))
            self.done["switch"] += 1
        self.wait(lambda: not window.document.opener.busy, "switch")

    def dialogs(self) -> None:
        """Open and close some of the dialogs."""
        for name in self.rng.sample(_DIALOGS, 4):
            self.dialog(name)

    def dialog(self, name: str) -> None:
        """Open a dialog by its action, and close it."""
        QTimer.singleShot(30, self._close_dialogs)  # works even if the dialog blocks this function
        self.act(name)
        wait(60)
        self._close_dialogs()

    def _close_dialogs(self) -> None:
        for box in self._others():
            box.reject() if isinstance(box, QDialog) else box.close()

    def _others(self) -> list[QWidget]:
        return [w for w in QApplication.topLevelWidgets() if w.isVisible() and w is not self.window]

    def lesson(self) -> None:
        """Start the tour or an exercise, and leave it again."""
        window, name = self.window, self.rng.choice(_LESSONS)
        self.wait(lambda: not window.document.opener.busy, name)  # wait for the opened clip, too
        own = window.document.data.clip.path if window.document.data else None
        self.act(name)
        if name == "tour":
            player = window.lesson_actions.player
            self.wait(lambda: player.at >= 0, name)
            for _ in range(4):
                player.show_me.click()
                player.forward.click()
                wait(50)
        else:
            wait(100)
        window.lesson_actions.leave_guide()
        self.wait(lambda: not window.document.opener.busy, name)
        back = window.document.data.clip.path if window.document.data else None
        assert back == own, f"{back} is open after the {name}, and was {own}"

    def folder(self) -> None:
        """Survey the folder again, and cancel the survey halfway."""
        window = self.window
        window.open_path(self.clips[0].parent)
        wait(self.rng.choice((200, 1500)))
        window.queue.close()
        window.document.opener.cancel()
        wait(20)

    # -- the run --------------------------------------------------------------------------------

    def visit(self, path: Path) -> None:
        """Open a clip, judge it, and carry out three more actions."""
        self.open(path)
        self.judge()
        more = (
            self.edit, self.scrub, self.drag_tau, self.tune, self.teach, self.other_detector,
            self.export, self.switch, self.dialogs, self.lesson, self.folder,
        )  # fmt: skip
        for thing in self.rng.sample(more, 3):
            thing()
            self.done[thing.__name__] += 1

    def count(self) -> Alive:
        """Count the living objects while the first clip is open and nothing is running."""
        window = self.window
        window.queue.close()
        window.docks["intervals"].raise_()
        self.open(self.clips[0])
        self.open(self.clips[1])
        self.open(self.clips[0])
        self.quiet()
        self.wait(lambda: not children(), f"processes stay: {children()}")
        return alive()


def grown(noted: list[tuple[float, Alive]]) -> list[str]:
    """Return descriptions of the counts that grew after the first minutes.

    `noted` has the counts by minute. For memory, the medians over the first and the last tenth of
    the time are compared.
    """
    settled = min(SETTLED, noted[-1][0] / 5.0)
    rest = [a for minute, a in noted if minute >= settled]
    few = max(1, len(rest) // 10)
    first, last = rest[:few], rest[-few:]
    out = []
    before, after = (float(np.median([a.mib for a in part])) for part in (first, last))
    if after > MOST * before:
        out.append(f"memory: {before:.0f} → {after:.0f} MiB")
    half = len(rest) // 2
    for name in (*_LEVEL, *_OF_REVIEW):
        early, late = ([getattr(a, name) for a in part] for part in (rest[:half], rest[half:]))
        if early and min(late) > max(early):
            out.append(f"{name}: {max(early)} → {min(late)}")
    return out


def sit(app: QApplication, clips: list[Path], minutes: float, seed: int) -> tuple[
    list[tuple[float, Alive]], Sitting, Said
]:  # fmt: skip
    """Review clips for some minutes. Return the counts by minute, the actions and the problems."""
    noted: list[tuple[float, Alive]] = []
    with heard() as said:
        window = MainWindow(Settings(theme="light", turn_ms=0), None)
        window.resize(1440, 900)
        window.show()
        window.activateWindow()
        QTest.qWaitForWindowActive(window, 10_000)
        exclude_from_collection()
        sitting = Sitting(window, clips, random.Random(seed))
        begun = last = time.monotonic()
        print(f"  minute {Alive.heads()}   wrong", flush=True)
        sitting.open(clips[0])
        for name in _DIALOGS:  # first, since some dialogs stay alive once they have been shown
            sitting.dialog(name)
        while True:
            for clip in clips:
                try:
                    sitting.visit(clip)
                except Exception as error:  # counted; the run continues
                    said.note(type(error), error, error.__traceback__)
                    sitting._close_dialogs()
                now = time.monotonic()
                if now - last >= min(60.0, 6.0 * minutes):
                    last = now
                    noted.append(((now - begun) / 60.0, sitting.count()))
                    print(f"{noted[-1][0]:8.1f} {noted[-1][1]}  {len(said.wrong):6d}", flush=True)
                if now - begun >= 60.0 * minutes:
                    break
            else:
                continue
            break
        window.document.review.mark_saved()
        window.close_without_asking()
        wait(200)
        app.processEvents()
    return noted, sitting, said


def main() -> int:
    """Run the test. Print the counts per minute, and the counts that grew."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="a folder of BVH clips; only copies are touched")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        os.environ["XDG_STATE_HOME"] = str(Path(scratch, "state"))
        os.environ["TWIST_INSPECTOR_SETTINGS"] = str(Path(scratch, "settings.json"))
        folder = Path(scratch, "clips")
        folder.mkdir()
        sources = clip_paths_in_folder(arguments.folder, suffixes=BVH)
        for source in sources:
            with_errors(source, folder / source.name)
        app = make_application()
        noted, sitting, said = sit(
            app, clip_paths_in_folder(folder), arguments.minutes, arguments.seed
        )
        shutil.rmtree(folder)
    print("\n" + ", ".join(f"{n} × {name}" for name, n in sorted(sitting.done.items())))
    for text, n in Counter(said.wrong).most_common():
        print(f"reported {n} ×: {text}")
    more = grown(noted)
    for line in more:
        print(f"grown: {line}")
    print("nothing grew" if not more else "", f"{len(said.wrong)} exceptions and warnings")
    return 1 if more or said.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
