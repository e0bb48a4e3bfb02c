"""The window with a folder under survey, to be killed: `opened_folder.py FOLDER`."""

import sys
from pathlib import Path

from inspector.app import make_application
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait


def main() -> None:
    _app = make_application()
    window = MainWindow(Settings(turn_ms=0), None)
    window.show()
    window.open_path(Path(sys.argv[1]))
    while not window.queue.running:
        wait(5)
    print("at work", flush=True)
    wait(600_000)


if __name__ == "__main__":  # not in the processes that it spawns
    main()
