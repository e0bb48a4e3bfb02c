"""Pictures of the real window for the docs: `python dev.py shot`."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from PySide6.QtTest import QTest

from inspector.app import make_application
from inspector.settings import Settings

IMAGES = Path(__file__).parent.parent / "docs" / "images"
_SIZE = (1440, 900)
_SETTLE_MS = 700


def main() -> int:
    """Take every picture; returns the exit code."""
    make_application()
    from inspector.main_window import SAMPLE, MainWindow

    def skin(window: MainWindow) -> None:
        window.actions_by_id["skin"].trigger()
        window.actions_by_id["side_by_side"].trigger()

    def trails(window: MainWindow) -> None:
        window.actions_by_id["trails"].trigger()
        window.view_iso()

    def queue(window: MainWindow) -> None:
        window.queue.open(SAMPLE.parent)
        window.clips_dock.show()
        while window.queue.running:
            QTest.qWait(50)

    def nothing(window: MainWindow) -> None:
        del window

    pictures: tuple[tuple[str, str, Callable[[MainWindow], None]], ...] = (
        ("inspector", "light", nothing),
        ("inspector-dark", "dark", nothing),
        ("skin-side-by-side", "dark", skin),
        ("trails", "light", trails),
        ("folder", "light", queue),
    )
    IMAGES.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(shutil.copy(SAMPLE, folder))
        for name, theme, prepare in pictures:
            window = MainWindow(Settings(theme=theme), None)
            window.resize(*_SIZE)
            window.show()
            window.open_path(clip)
            while window.document.data is None:
                QTest.qWait(20)
            QTest.qWait(_SETTLE_MS)
            window.next_interval()
            window.accept()
            window.accept()
            judged = window.document.interval
            assert judged is not None
            window.document.go_to((judged.interval.start + judged.interval.stop) // 2)
            prepare(window)
            if prepare is not trails:
                window.focus_chain()
            QTest.qWait(_SETTLE_MS)
            path = IMAGES / f"{name}.png"
            window.grab().save(str(path))
            print(path.relative_to(IMAGES.parent.parent))
            window.document.review.mark_saved()
            window.close()
            QTest.qWait(50)
    return 0


if __name__ == "__main__":
    sys.exit(main())
