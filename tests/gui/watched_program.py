"""The program as it is started by a person, and a way to look into it: never to act on it.

`watched_program.py [WORDS OF THE PROGRAM]`. Each line of standard input is an expression over
`window`, `app` and `rect`; its value goes to standard output as a line of JSON behind `_MARK`.
What acts on the program is the X server's mouse and keyboard.
"""

import contextlib
import json
import os
import sys

from PySide6.QtCore import QPoint, QRect, QSocketNotifier, Qt, QTimer
from PySide6.QtWidgets import QApplication, QTableView, QWidget

import inspector.__main__
import inspector.app

_MARK = "watched: "
_BUSY_MS = 2000


def rect(widget, part=None):
    """Left, top, width, height on the screen in its own pixels; of a part of it in its own."""
    box = part if isinstance(part, QRect) else widget.rect()
    place, scale = widget.mapToGlobal(QPoint(0, 0)), widget.devicePixelRatioF()
    at = widget.screen().geometry().topLeft()
    left, top = place.x() + box.x() - at.x(), place.y() + box.y() - at.y()
    return [round(scale * v) for v in (left, top, box.width(), box.height())]


def row(table: QTableView, number: int):
    """The rectangle of a row of a table, within its first two columns."""
    model = table.model()
    cells = [table.visualRect(model.index(number, k)) for k in range(min(2, model.columnCount()))]
    return rect(table.viewport(), cells[0].united(cells[-1]))


def entry(action_id: str):
    """The rectangle of an action's entry in the menu or bar that shows it."""
    action = _window().actions_by_id[action_id]
    for owner in action.associatedObjects():
        if isinstance(owner, QWidget) and owner.isVisible() and hasattr(owner, "actionGeometry"):
            box = owner.actionGeometry(action)
            if not box.isEmpty():
                return rect(owner, box)
    return None


def menu(name: str):
    """The rectangle of a menu's title in the menu bar."""
    bar = _window().menuBar()
    (action,) = [a for a in bar.actions() if a.text().replace("&", "") == name]
    return rect(bar, bar.actionGeometry(action))


def _window():
    return next(
        (w for w in QApplication.topLevelWidgets() if type(w).__name__ == "MainWindow"), None
    )


def _answer(line: str) -> str:
    names = {
        "window": _window(),
        "app": QApplication.instance(),
        "QApplication": QApplication,
        "Qt": Qt,
        "rect": rect,
        "row": row,
        "entry": entry,
        "menu": menu,
    }
    try:
        value = eval(line, names)  # our own tests' expressions
    except Exception as error:  # told to the test, which fails with it
        return json.dumps({"error": f"{type(error).__name__}: {error}"})
    return json.dumps({"value": value}, default=str)


def _watch(app: QApplication) -> QSocketNotifier:
    rest = b""
    asked: list[bytes] = []
    # A timer of no time is due once nothing else is: keys and clicks that have come are done, what
    # they change is laid out and painted. A program that is never idle answers all the same.
    idle, never_idle = (QTimer(app, singleShot=True, interval=ms) for ms in (0, _BUSY_MS))

    def read() -> None:
        nonlocal rest
        got = os.read(0, 65536)
        if not got:
            watcher.setEnabled(False)
            return
        *lines, rest = (rest + got).split(b"\n")
        asked.extend(lines)
        for timer in (idle, never_idle):
            timer.start()

    def answer() -> None:
        never_idle.stop()
        while asked:
            with contextlib.suppress(BrokenPipeError):
                print(_MARK + _answer(asked.pop(0).decode()), flush=True)

    for timer in (idle, never_idle):
        timer.timeout.connect(answer)
    watcher = QSocketNotifier(0, QSocketNotifier.Type.Read, app)
    watcher.activated.connect(read)
    return watcher


def main() -> int:
    made = inspector.app.make_application
    kept = []

    def make_and_watch(language: str) -> QApplication:
        app = made(language)
        kept.append(_watch(app))
        return app

    inspector.app.make_application = make_and_watch
    return inspector.__main__.main(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
