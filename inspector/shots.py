"""Pictures of the real window for the docs: `python dev.py shot`."""

from __future__ import annotations

import sys
from pathlib import Path

from PySide6.QtTest import QTest

from inspector.app import make_application
from inspector.settings import Settings

IMAGES = Path(__file__).parent.parent / "docs" / "images"
_SIZE = (1440, 900)
_SETTLE_MS = 500


def main() -> int:
    """Take every picture; returns the exit code."""
    app = make_application()
    from inspector.main_window import SAMPLE, MainWindow

    IMAGES.mkdir(parents=True, exist_ok=True)
    for name, theme in (("inspector", "light"), ("inspector-dark", "dark")):
        window = MainWindow(Settings(theme=theme), None)
        window.resize(*_SIZE)
        window.show()
        window.open_path(SAMPLE)
        while window.document.data is None:
            QTest.qWait(20)
        QTest.qWait(_SETTLE_MS)
        window.next_interval()
        window.accept()
        window.accept()
        judged = window.document.interval
        assert judged is not None
        window.document.go_to((judged.interval.start + judged.interval.stop) // 2)
        window.focus_chain()
        QTest.qWait(_SETTLE_MS)
        path = IMAGES / f"{name}.png"
        window.grab().save(str(path))
        print(path.relative_to(IMAGES.parent.parent))
        window.document.review.mark_saved()
        window.close()
    app.processEvents()
    return 0


if __name__ == "__main__":
    sys.exit(main())
