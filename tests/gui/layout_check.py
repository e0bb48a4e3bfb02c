"""Walk all visible widgets of the real window: `layout_check.py WIDTH HEIGHT THEME CLIP PNG`.

Prints one line a defect: text that does not fit its widget, siblings that overlap.
"""

import sys
from itertools import combinations
from pathlib import Path

from PySide6.QtCore import QRect
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QComboBox, QLabel, QMenuBar, QWidget

from inspector.app import make_application

app = make_application()

from inspector.main_window import MainWindow  # noqa: E402
from inspector.settings import Settings  # noqa: E402


def name(widget: QWidget) -> str:
    text = getattr(widget, "text", lambda: "")() if not isinstance(widget, QComboBox) else ""
    return f"{type(widget).__name__} {widget.objectName()!r} {text[:40]!r}"


def defects(window: QWidget):
    visible = [w for w in window.findChildren(QWidget) if w.isVisible() and w.width() > 0]
    for widget in visible:
        if isinstance(widget, QLabel | QAbstractButton | QComboBox):
            text = widget.text() if not isinstance(widget, QComboBox) else widget.currentText()
            hint = widget.minimumSizeHint()
            wraps = isinstance(widget, QLabel) and widget.wordWrap()
            if text and not wraps and widget.width() < hint.width():
                yield f"{name(widget)} is {widget.width()} wide and needs {hint.width()}"
            if text and widget.height() < hint.height() - 1:
                yield f"{name(widget)} is {widget.height()} high and needs {hint.height()}"
    for parent in [window, *visible]:
        if parent.layout() is None:
            continue
        laid = [parent.layout().itemAt(k).widget() for k in range(parent.layout().count())]
        for a, b in combinations([w for w in laid if w is not None and w.isVisible()], 2):
            common = QRect(a.geometry()).intersected(b.geometry())
            if common.width() > 1 and common.height() > 1:
                yield f"{name(a)} and {name(b)} overlap by {common.width()}×{common.height()}"
    bar = window.findChild(QMenuBar)
    if bar is not None and bar.sizeHint().width() > window.width():
        yield "the menu bar does not fit"


def main() -> None:
    width, height, theme, clip, png = sys.argv[1:6]
    window = MainWindow(Settings(theme=theme), None)
    window.resize(int(width), int(height))
    window.show()
    window.open_path(Path(clip))
    while window.document.data is None:
        QTest.qWait(10)
    window.next_interval()
    window.accept()
    QTest.qWait(400)
    if (window.width(), window.height()) != (int(width), int(height)):
        print(f"the window needs {window.width()}×{window.height()}")
    for defect in defects(window):
        print(defect)
    window.grab().save(png)
    window.document.review.mark_saved()
    window.close()


main()
