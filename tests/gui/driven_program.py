"""The program in a process of its own, told what to do: `driven_program.py CLIP`.

Reads a command a line from standard input and answers each with a line of JSON: what the window
says and offers, and the review. Commands: accept [N] (the first undecided), note SIZE, undo, save,
export [replace], add JOINTS (a chain), remove CHAIN, wait_for_chains, tour, leave, tour_and_leave,
open NAME, select (the first), press TEXT, close ANSWER, limit BYTES (of any file it writes; 'none'
lifts it), front, state.
"""

import json
import resource
import signal
import sys
from pathlib import Path

from PySide6.QtCore import QEvent, QTimer
from PySide6.QtWidgets import QApplication, QMessageBox

from inspector.app import make_application
from inspector.session.export_files import ExportChoice
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from tests.gui.windows import wait_until_active
from twistcore.review import Annotate, Decision
from twistcore.skeleton.rig import OwnChain

SETTINGS = Settings(turn_ms=0, autosave=False)


class Driver:
    """Does what the commands say in a window that is shown and has no clip open."""

    def __init__(self, window: MainWindow, clip: Path) -> None:
        self.window = window
        opened = []
        connection = window.document.opened.connect(lambda: opened.append(True))
        window.open_path(clip)
        while not opened:
            wait(5)
        window.document.opened.disconnect(connection)
        wait(20)

    def do(self, command: str) -> dict[str, object]:
        """Do what a command says, and answer."""
        word, _, rest = command.partition(" ")
        getattr(self, word)(*([rest] if rest else []))
        return self.answer()

    def accept(self, place: str = "") -> None:
        undecided = [
            (k, j.id)
            for k, j in enumerate(self.window.document.intervals)
            if j.decision == Decision.UNDECIDED
        ]
        (first, *_) = (i for k, i in undecided if not place or k == int(place))
        self.window.document.select_interval(first)
        self.window.actions_by_id["accept"].trigger()

    def note(self, size: str) -> None:
        first = self.window.document.intervals[0]
        self.window.document.do(Annotate(first.id, "x" * int(size)))

    def undo(self) -> None:
        self.window.actions_by_id["undo"].trigger()

    def save(self) -> None:
        self.window.files.save_session()

    def export(self, replace: str = "") -> None:
        clip = self.window.document.data.clip.path
        path = clip.with_name(f"{clip.stem}_refined.bvh")
        self.window.files.export(ExportChoice(path, replace=bool(replace)))
        self.window.exporter.finish()

    def add(self, joints: str) -> None:
        document = self.window.document
        own, state = OwnChain(tuple(joints.split())), document.review.state
        document.change_chains(state.rig.with_chain(document.data.motion, own), f"Add {own.name}")
        self.wait_for_chains()

    def remove(self, chain: str) -> None:
        self.window.document.select_chain(chain)
        self.window.actions_by_id["remove_chain"].trigger()
        self.wait_for_chains()

    def wait_for_chains(self) -> None:
        while self.window.document.opener.busy:
            wait(5)

    def tour(self) -> None:
        self.window.actions_by_id["tour"].trigger()
        while self.window.lesson_actions.player.at < 0:
            wait(5)

    def leave(self) -> None:
        self.window.lesson_actions.leave_guide()

    def tour_and_leave(self) -> None:
        """Before the tour's clip is there."""
        self.window.actions_by_id["tour"].trigger()
        self.window.lesson_actions.leave_guide()

    def open(self, name: str) -> None:
        clip = self.window.document.data.clip.path
        self.window.open_path(clip.with_name(name))
        while self.window.document.data.clip.path.name != name:
            wait(5)

    def select(self) -> None:
        self.window.document.select_interval(self.window.document.intervals[0].id)

    def press(self, text: str) -> None:
        opened = []
        self.window.document.opened.connect(lambda: opened.append(True))
        (button,) = [b for b in self.window.bar.buttons() if b.text() == text]
        button.click()
        if text in ("Take over", "Open the new version"):
            while not opened:
                wait(5)

    def close(self, answer: str = "") -> None:
        def click() -> None:
            box = QApplication.activeModalWidget()
            assert isinstance(box, QMessageBox)
            box.button(getattr(QMessageBox.StandardButton, answer)).click()

        if answer:
            QTimer.singleShot(50, click)
        self.window.close()

    def limit(self, size: str) -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        _, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        soft = resource.RLIM_INFINITY if size == "none" else int(size)
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    def front(self) -> None:
        """Another program was in front until now."""
        wait_until_active(self.window)
        QApplication.sendEvent(self.window, QEvent(QEvent.Type.ActivationChange))

    def state(self) -> None:
        """Only answer."""

    def answer(self) -> dict[str, object]:
        wait(30)
        window, document = self.window, self.window.document
        return {
            "says": window.bar.label.text() if window.bar.isVisible() else "",
            "offers": [b.text() for b in window.bar.buttons()],
            "decisions": [j.decision.value for j in document.intervals],
            "note": max((len(j.note) for j in document.intervals), default=0),
            "chains": [c.name for c in document.data.chains],
            "saved": document.data is None or document.review.saved,
            "open": window.isVisible(),
        }


def main() -> None:
    app = make_application()
    window = MainWindow(SETTINGS, None)
    window.show()
    driver = Driver(window, Path(sys.argv[1]))
    print(json.dumps(driver.answer()), flush=True)
    for line in sys.stdin:
        print(json.dumps(driver.do(line.strip())), flush=True)
    app.closeAllWindows()


if __name__ == "__main__":
    main()
