"""Measure how fast the window follows a τ that is dragged: python -m benchmarks.tau_drag.

The sample is repeated up to 3,000, 10,000 and 100,000 frames (or --frames N…). Each repetition has
three different errors, from 1° to 150°, so that every move of τ changes the intervals found. τ is
dragged over 60 values in the real window. The output shows the median and 95th percentile of the
time

- until the core has found the new intervals,
- until plots, table and strip are also on the screen, and
- until the 3D view is drawn where it changes.

A frame on a 60 Hz screen takes 16.7 ms. The second line of each length is measured with the tuning
tab in front, so that its two plots are painted as well. The last line shows how long the tab's
curve takes to appear for the first length, and how long the event loop is blocked meanwhile.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("QT_API", "pyside6")

import numpy as np
from PySide6.QtCore import QEvent, QEventLoop, QObject
from PySide6.QtWidgets import QApplication, QWidget

from inspector.app import exclude_from_collection, make_application
from inspector.session.opening import analyse_clip
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.clip import Clip, create_file_patch_for_motion
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import InjectedError, inject

SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "walk.bvh"
CHAIN = "LeftForeArm"
# Each value is used once, because an analysis caches its solutions.
TAUS = np.geomspace(0.5, 120.0, 60)


def tiled(clip: Clip, frames: int, folder: Path) -> Clip:
    """Return the clip, repeated up to `frames`, with different errors in each repetition.

    Only the motion is repeated, not the bytes. The clip's path is in `folder`, where the journal of
    the review is written.
    """
    motion = clip.motion
    chains = find_chains(motion)
    rng = np.random.default_rng(1)
    rounds = []
    for _ in range(-(-frames // motion.frames)):
        errors = []
        for third in range(3):
            start = (3 * third + 1) * motion.frames // 10
            stop = start + int(rng.integers(10, motion.frames // 5))
            size = np.radians(np.exp(rng.uniform(np.log(1.0), np.log(150.0))))
            offset = np.full(stop - start, rng.choice([-size, size]))
            errors.append(InjectedError(CHAIN, start, stop, offset))
        twisted = inject(motion, chains, errors)
        data = create_file_patch_for_motion(clip, twisted).data
        rounds.append(parse_bvh(data, clip.path).values)
    return replace(clip, path=folder / clip.path.name, values=np.concatenate(rounds)[:frames])


class _Painted(QObject):
    """An event filter that records which widgets have been painted since `expect_all`."""

    def __init__(self, widgets: list[QWidget]) -> None:
        super().__init__()
        self._widgets = widgets
        self.waiting: set[QWidget] = set()
        for widget in widgets:
            widget.installEventFilter(self)

    def expect_all(self) -> None:
        """Discard the record and start again."""
        self.waiting = set(self._widgets)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 — Qt's name
        """Record paint events. All events are passed on."""
        if event.type() == QEvent.Type.Paint:
            self.waiting.discard(watched)
        return False


def measure(
    app: QApplication, frames: int, folder: Path, *, tuning: bool = False
) -> tuple[np.ndarray, int]:
    """Return the times of every step in ms, shape (3, steps), and the largest number of intervals.

    The rows are the times until the core is done; until plots, table and strip are on the screen;
    and until the 3D view is drawn as well. If `tuning` is True, the tuning tab is in front of the
    interval table, and its two plots are painted instead.
    """
    window = MainWindow(Settings(theme="light"), None)
    window.resize(1440, 900)
    window.show()
    exclude_from_collection()
    clip = tiled(read_bvh(SAMPLE), frames, folder)
    untouched = analyse_clip(clip).analysis.by()
    document, timeline = window.document, window.timeline
    document.show_clip(analyse_clip(clip))
    document.select_chain(CHAIN)
    document.go_to(clip.values.shape[0] // 2)
    wait(300)
    plots = [pane.viewport() for pane in timeline.panes.values() if pane.isVisible()]
    watched = [window.intervals.table.viewport()]
    if tuning:
        window.actions_by_id["show_tuning"].trigger()
        watched = [window.tuning.curves.histogram.viewport(), window.tuning.curves.cost.viewport()]
        # The cost is measured for the single repetition on disk; its curve has as many points.
        shutil.copy(SAMPLE, folder)
        longest_turn(app, lambda: len(window.tuning.costs.curves) == len(window.tuning.costs.names))
        wait(300)
    painted = _Painted([*plots, timeline.overview, *watched])
    times, most = [], 0
    drag = document.begin_drag()
    for degrees in TAUS:
        tau = float(np.radians(degrees))
        begun = time.perf_counter()
        untouched.intervals(CHAIN, tau)
        core = time.perf_counter() - begun
        found = len(document.review.state.of_chain(CHAIN))
        painted.expect_all()
        begun = time.perf_counter()
        document.set_tau(tau, CHAIN, drag)
        for widget in watched:
            widget.update()  # even if nothing in it has changed
        while painted.waiting:
            app.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 1)
        flat = time.perf_counter() - begun
        while window.viewport.pending:
            app.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 1)
        app.processEvents()
        whole = time.perf_counter() - begun
        times.append((core, flat, whole))
        most = max(most, found, len(document.review.state.of_chain(CHAIN)))
    document.review.mark_saved()
    window.close()
    return 1e3 * np.array(times).T, most


def appearing(app: QApplication, frames: int, folder: Path) -> tuple[float, float, float, float]:
    """Measure how the curve of the tuning tab appears for a newly opened clip.

    Returns the seconds until the selected chain's curve is drawn and until all curves are known,
    and the longest time in milliseconds for which the event loop is blocked, meanwhile and in an
    equally long time without measurements.
    """
    head, _, rows = SAMPLE.read_text().rstrip().partition("Frame Time:")
    step, *lines = rows.splitlines()
    many = [lines[k % len(lines)] for k in range(frames)]
    head = re.sub(r"Frames:.*", f"Frames: {frames}", head)
    path = folder / "long.bvh"
    path.write_text("\n".join([f"{head}Frame Time:{step}", *many]) + "\n")
    window = MainWindow(Settings(theme="light"), None)
    window.resize(1440, 900)
    window.show()
    window.open_path(path)
    longest_turn(app, lambda: window.document.data is not None)
    window.document.select_chain(CHAIN)
    wait(1000)
    costs, drawn = window.tuning.costs, window.tuning.curves.cost.fsr
    begun = time.perf_counter()
    window.actions_by_id["show_tuning"].trigger()
    stall = longest_turn(app, lambda: np.size(drawn.getData()[0]) > 1)
    first = time.perf_counter() - begun
    stall = max(stall, longest_turn(app, lambda: len(costs.curves) == len(costs.names)))
    every = time.perf_counter() - begun
    window.document.select_chain("RightLeg")  # the same loop without measuring
    quiet = longest_turn(app, lambda: False, every)
    window.close()
    return first, every, stall, quiet


def longest_turn(app: QApplication, ready: Callable[[], bool], seconds: float = 60.0) -> float:
    """Run the event loop until `ready` returns True, but not longer than `seconds`.

    Return the longest time in milliseconds for which the event loop was blocked.
    """
    longest, end = 0.0, time.perf_counter() + seconds
    while not ready() and time.perf_counter() < end:
        begun = time.perf_counter()
        app.processEvents()
        longest = max(longest, time.perf_counter() - begun)
        time.sleep(0.002)
    return 1e3 * longest


def main() -> None:
    """Measure all lengths and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, action="append", help="clip lengths to measure")
    chosen = parser.parse_args().frames or [3_000, 10_000, 100_000]
    app = make_application()
    print("                        core      plots, table, strip      and 3D")
    print("  frames  intervals   median   p95   median   p95   median   p95   (ms)")
    for frames in chosen:
        for tuning in (False, True):
            with TemporaryDirectory() as folder:
                times, most = measure(app, frames, Path(folder), tuning=tuning)
            figures = "".join(f"  {np.median(t):7.2f} {np.percentile(t, 95):5.1f}" for t in times)
            note = "   tuning tab in front" if tuning else ""
            print(f"{frames:8,d}  {most:9d}{figures}{note}")
    with TemporaryDirectory() as folder:
        first, every, stall, quiet = appearing(app, chosen[0], Path(folder))
    print(
        f"\n{chosen[0]:,d} frames: curve of the selected chain after {first:.2f} s, of all after "
        f"{every:.2f} s; longest stall of the event loop meanwhile {stall:.0f} ms, "
        f"with nothing to measure {quiet:.0f} ms"
    )


if __name__ == "__main__":
    main()
