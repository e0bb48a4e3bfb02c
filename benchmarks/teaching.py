"""Measure the time per frame with the teaching tab open: the update, the 3D view, and the tab.

    python benchmarks/teaching.py [--clip CLIP] [--frames N] [--json]

The 3D view includes the gizmo. The times are CPU times of the process, so that other programs have
little effect (threads of a software renderer are included). The 3D view is 1280×411 as in scrub.py,
and the tab is 545×640. The same frames are drawn alternately with the lesson on and off.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from PySide6.QtCore import QEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks._frames import Figures, run
from inspector.app import make_application
from inspector.session.document import Document
from inspector.session.opening import analyse_file
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.teaching_panel import TeachingPanel
from inspector.timeline.timeline import Timeline
from inspector.viewport import opengl
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import DARK, Colours
from inspector.widgets.typeset import Typesetter
from tests.gui.waiting import wait

CLIP = Path(__file__).resolve().parent.parent / "assets" / "walk_injected.bvh"
TARGET_MS = 25.0


def repaint(widget: QWidget) -> None:
    """Repaint immediately, without waiting for the screen's next refresh."""
    QApplication.sendEvent(widget.window(), QEvent(QEvent.Type.UpdateRequest))


def measure(clip: Path, frames: int) -> Figures:
    """Return the median times in milliseconds, with the tab open and closed."""
    document = Document()
    document.show_clip(analyse_file(clip))
    colours = Colours(DARK)
    viewport, timeline = Viewport(document, colours), Timeline(document, colours)
    taught = TaughtFrame(document)
    panel = TeachingPanel(taught, viewport, timeline, [], Typesetter())
    for widget, size in ((viewport, (1280, 411)), (panel, (545, 640))):
        widget.resize(*size)
        widget.show()
        QTest.qWaitForWindowExposed(widget)
    panel.set_seen(True)
    while not panel.typesetter.done:
        wait(20)
    document.select_chain("LeftForeArm")

    def scrub(frame: int) -> tuple[float, float]:
        start = time.process_time()
        document.go_to(frame)
        viewport.refresh()
        handled = time.process_time()
        repaint(viewport)
        repaint(panel)
        return 1e3 * (handled - start), 1e3 * (time.process_time() - start)

    chosen = np.linspace(1, document.frames - 1, frames).astype(int)
    order = np.random.default_rng(1).permutation(chosen)
    spent: dict[bool, list[tuple[float, float]]] = {True: [], False: []}
    for part in np.array_split(order, 4):
        for on, values in spent.items():
            panel.set_seen(on)
            wait(300)
            scrub(0)
            values += [scrub(int(f)) for f in part]
    document.close_clip()
    viewport.close()
    panel.close()
    handled, whole = np.array(spent[True]).T
    return {
        "clip": clip.name,
        "driver": opengl.renderer_name(),
        "frames": frames,
        "handled_ms": round(float(np.median(handled)), 2),
        "open_median_ms": round(float(np.median(whole)), 2),
        "open_p95_ms": round(float(np.percentile(whole, 95)), 2),
        "closed_median_ms": round(float(np.median(np.array(spent[False])[:, 1])), 2),
    }


def main() -> int:
    """Print the table. Return 1 if the target is missed."""
    _app = make_application()

    def is_good(figures: Figures) -> bool:
        return float(figures["open_median_ms"]) <= TARGET_MS

    return run(__doc__.splitlines()[0], CLIP, 120, measure, is_good)


if __name__ == "__main__":
    sys.exit(main())
