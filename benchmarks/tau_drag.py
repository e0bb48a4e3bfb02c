"""How fast a dragged τ is followed: python -m benchmarks.tau_drag [--frames N]…

Tiles the sample with injected errors to 3,000, 10,000 and 100,000 frames, drags τ of one chain
over 60 values and prints the median and the 95th percentile of (a) τ → new intervals in the core,
(b) the same and the time line repainted. A frame of a 60 Hz screen is 16.7 ms.
"""

from __future__ import annotations

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path

os.environ.setdefault("QT_API", "pyside6")

import numpy as np
from PySide6.QtWidgets import QApplication

from inspector.analysed import analysed
from inspector.document import Document
from inspector.plots import Timeline
from inspector.theme import LIGHT, apply_theme
from twistcore.bvh import Clip, read_bvh

SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "walk_injected.bvh"
CHAIN = "LeftForeArm"
# Each once: an analysis remembers what it has solved, so a τ met again costs next to nothing.
TAUS = np.geomspace(0.5, 120.0, 60)


def tiled(clip: Clip, frames: int) -> Clip:
    """The clip over and over, to a number of frames; its bytes stay those of one round."""
    return replace(clip, values=clip.values[np.arange(frames) % len(clip.values)])


def measure(app: QApplication, frames: int) -> tuple[np.ndarray, np.ndarray, int]:
    """Milliseconds of every step: core, core and repaint; and the most intervals there were."""
    document = Document()
    timeline = Timeline(document, LIGHT)
    timeline.resize(1280, 300)
    timeline.show()
    clip = tiled(read_bvh(SAMPLE), frames)
    untouched = analysed(clip).analysis
    document.show_clip(analysed(clip))
    document.select_chain(CHAIN)
    for _ in range(10):
        app.processEvents()
    core, painted, most = [], [], 0
    for degrees in TAUS:
        begun = time.perf_counter()
        untouched.intervals(CHAIN, float(np.radians(degrees)))
        core.append(time.perf_counter() - begun)
    drag = document.begin_drag()
    for degrees in TAUS:
        begun = time.perf_counter()
        document.set_tau(float(np.radians(degrees)), CHAIN, drag)
        timeline.refresh()
        timeline.repaint_now()
        painted.append(time.perf_counter() - begun)
        most = max(most, len(document.review.state.of_chain(CHAIN)))
        app.processEvents()
    document.review.mark_saved()
    document.close_clip()
    timeline.close()
    return 1e3 * np.array(core), 1e3 * np.array(painted), most


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, action="append", help="clip lengths to measure")
    chosen = parser.parse_args().frames or [3_000, 10_000, 100_000]
    app = QApplication.instance() or QApplication([])
    apply_theme(app, LIGHT)
    print("  frames  intervals   core median    p95   repainted median    p95   (ms)")
    for frames in chosen:
        core, painted, most = measure(app, frames)
        print(
            f"{frames:8,d}  {most:9d}   {np.median(core):11.2f} {np.percentile(core, 95):6.2f}"
            f"   {np.median(painted):16.2f} {np.percentile(painted, 95):6.2f}"
        )


if __name__ == "__main__":
    main()
