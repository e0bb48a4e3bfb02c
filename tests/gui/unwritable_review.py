"""Verdicts on a clip whose folder cannot be written: `unwritable_review.py CLIP`.

For each line of input a new window opens the clip. Prints, each in a line, what the window says,
how many verdicts it opened with, and whether the next one was saved.
"""

import sys
from pathlib import Path

from inspector.app import make_application
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from twistcore.review import Decision


def review(clip: Path) -> None:
    window = MainWindow(Settings(turn_ms=0), None)
    window.show()
    window.open_path(clip)
    while window.document.data is None:
        wait(5)
    print(window.bar.label.text())
    print(sum(j.decision == Decision.ACCEPTED for j in window.document.intervals))
    window.actions_by_id["next_interval"].trigger()
    window.actions_by_id["accept"].trigger()
    saved = window.files.save_session()
    window.close()
    window.deleteLater()
    wait(20)
    print(saved, flush=True)  # last, since the test goes on with the files


def main() -> None:
    _app = make_application()
    for _ in sys.stdin:
        review(Path(sys.argv[1]))


main()
