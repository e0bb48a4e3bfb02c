"""Measure panning the timeline with many intervals: python -m benchmarks.pan.

One chain of 100,000 frames has 1,000 or 10,000 intervals. In the real window, the plots are panned
sixty times by a twentieth of the view, with half and with a hundredth of the clip in view. The
output shows the median and 95th percentile of the time for panning and repainting.
"""

from __future__ import annotations

import os
import time
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("QT_API", "pyside6")

import numpy as np
from PySide6.QtCore import QEvent
from PySide6.QtWidgets import QApplication

from benchmarks.tau_drag import CHAIN, SAMPLE, tiled
from inspector.app import make_application
from inspector.session.opening import analyse_clip
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.formats.bvh import read_bvh
from twistcore.review import Redetect

FRAMES = 100_000


def main() -> None:
    """Measure panning and print the table."""
    make_application()
    window = MainWindow(Settings(theme="light"), None)
    window.resize(1440, 900)
    window.show()
    document = window.document
    with TemporaryDirectory() as folder:
        document.show_clip(analyse_clip(tiled(read_bvh(SAMPLE), FRAMES, Path(folder))))
        document.select_chain(CHAIN)
        _measure(window)
        document.review.mark_saved()
        window.close()


def _measure(window: MainWindow) -> None:
    document, timeline = window.document, window.timeline
    print(" intervals   frames in view   median    p95   (ms)")
    for count in (1_000, 10_000):
        step = FRAMES // count
        found = tuple(
            new_constant_offset_interval(CHAIN, k, k + step // 2, 0.3)
            for k in range(1, FRAMES - step, step)
        )
        document.do(Redetect({CHAIN: 0.1}, found))
        wait(500)
        for view in (FRAMES // 2, FRAMES // 100):
            timeline.visible.show(0, view)
            wait(100)
            taken = []
            for step_number in range(60):
                begun = time.perf_counter()
                timeline.visible.pan(view / 20 * (1 if step_number % 20 < 10 else -1))
                QApplication.sendEvent(window, QEvent(QEvent.Type.UpdateRequest))
                taken.append(1e3 * (time.perf_counter() - begun))
                QApplication.processEvents()
            print(
                f"{count:10,d}   {view:14,d}   {np.median(taken):6.1f} "
                f"{np.percentile(taken, 95):6.1f}"
            )


if __name__ == "__main__":
    main()
