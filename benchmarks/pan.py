"""How fast the time line pans with many intervals: python -m benchmarks.pan.

1,000 and 10,000 intervals in one chain of 100,000 frames; panned by a twentieth of the view, sixty
times, with everything and with a hundredth of the clip in view; median and 95th percentile.
"""

from __future__ import annotations

import os
import time

os.environ.setdefault("QT_API", "pyside6")

import numpy as np
from PySide6.QtWidgets import QApplication

from benchmarks.tau_drag import CHAIN, SAMPLE, tiled
from inspector.analysed import analysed
from inspector.document import Document
from inspector.plots import Timeline
from inspector.theme import LIGHT, apply_theme
from twistcore.bvh import read_bvh
from twistcore.review import Redetect
from twistcore.review.model import constant

FRAMES = 100_000


def main() -> None:
    """Print the table."""
    app = QApplication.instance() or QApplication([])
    apply_theme(app, LIGHT)
    document = Document()
    timeline = Timeline(document, LIGHT)
    timeline.resize(1280, 300)
    timeline.show()
    document.show_clip(analysed(tiled(read_bvh(SAMPLE), FRAMES)))
    document.select_chain(CHAIN)
    print(" intervals   frames in view   median    p95   (ms)")
    for count in (1_000, 10_000):
        step = FRAMES // count
        found = tuple(constant(CHAIN, k, k + step // 2, 0.3) for k in range(1, FRAMES - step, step))
        document.do(Redetect({CHAIN: 0.1}, found))
        app.processEvents()
        for view in (FRAMES // 2, FRAMES // 100):
            timeline.show_range(0, view)
            app.processEvents()
            taken = []
            for _ in range(60):
                begun = time.perf_counter()
                timeline.pan(view / 20)
                timeline.refresh()
                timeline.repaint_now()
                taken.append(1e3 * (time.perf_counter() - begun))
                app.processEvents()
            print(
                f"{count:10,d}   {view:14,d}   {np.median(taken):6.1f} "
                f"{np.percentile(taken, 95):6.1f}"
            )
    document.review.mark_saved()
    document.close_clip()
    timeline.close()


if __name__ == "__main__":
    main()
