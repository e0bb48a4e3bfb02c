"""Measure the folder queue: python -m benchmarks.folder_queue FOLDER [--clips N].

Copies of the folder's clips get random errors in some of their chains, and are opened as a folder
in the real window. The output shows the seconds until the first clip can be reviewed, the longest
time and the 99th percentile of the times for which the GUI thread is blocked, the clips analysed
per second, and how well the order by severity agrees with the true one. With --scrub, the playhead
moves all the time, so that drawing is included.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np
from PySide6.QtCore import QEventLoop, QTimer
from PySide6.QtWidgets import QApplication
from scipy.stats import spearmanr

from inspector.app import make_application
from inspector.collector import exclude_from_collection
from inspector.session.settings import Settings
from twistcore.analysis.clip_severity import severity_of_intervals
from twistcore.detection import Interval
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import clip_random_generator, draw_errors, inject

_TICK_MS = 4


def with_errors(source: Path, target: Path, chains_hit: int) -> float:
    """Write a clip with errors in `chains_hit` of its chains. Return its true severity."""
    clip = read_bvh(source)
    chains = find_chains(clip.motion)
    rng = clip_random_generator(1, source.name)
    chosen = [chains[k] for k in rng.permutation(len(chains))[:chains_hit]]
    errors = draw_errors(clip.motion, chosen, rng)
    dirty = inject(clip.motion, chains, errors)
    target.write_bytes(create_file_patch_for_motion(clip, dirty).data)
    by_name = {c.name: c for c in chains}
    found = [(Interval(e.chain, e.start, e.stop, e.offset), by_name[e.chain]) for e in errors]
    return severity_of_intervals(found, clip.motion.frames, clip.motion.fps)


def main() -> None:
    """Measure the queue and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--clips", type=int, default=40)
    parser.add_argument("--scrub", action="store_true", help="move the playhead all the time")
    arguments = parser.parse_args()
    make_application()
    from inspector.window.main_window import MainWindow

    with tempfile.TemporaryDirectory() as folder:
        truth = {}
        for k, source in enumerate(
            clip_paths_in_folder(arguments.folder, suffixes=BVH)[: arguments.clips]
        ):
            target = Path(folder) / source.name
            truth[target] = with_errors(source, target, k % 9)
        window = MainWindow(Settings(), None)
        window.resize(1440, 900)
        window.show()
        exclude_from_collection()  # as the program does
        loop = QEventLoop()
        QTimer.singleShot(500, loop.quit)
        loop.exec()
        stalls: list[float] = []
        last = [time.perf_counter()]

        def tick() -> None:
            now = time.perf_counter()
            stalls.append(now - last[0])
            last[0] = now
            if arguments.scrub and window.document.frames:
                window.document.go_to((window.document.frame + 1) % window.document.frames)

        timer = QTimer()
        timer.timeout.connect(tick)
        begun = time.perf_counter()
        first: list[float] = []
        window.document.opened.connect(lambda: first.append(time.perf_counter() - begun))
        window.queue.finished.connect(loop.quit)
        timer.start(_TICK_MS)
        window.open_path(Path(folder))
        loop.exec()
        timer.stop()
        seconds = time.perf_counter() - begun
        while not first:  # the worst clip opens when all are analysed, or after some seconds
            QApplication.processEvents()
        measured = [window.queue.clips[p].severity for p in truth]
        agreement = spearmanr(measured, list(truth.values())).statistic
        print(f"first clip open after       {first[0]:6.2f} s")
        pace = len(truth) / seconds
        print(f"{len(truth)} clips analysed in       {seconds:6.2f} s, {pace:.1f} per second")
        print(f"longest stall               {1e3 * max(stalls):6.1f} ms")
        print(f"99th percentile             {1e3 * np.percentile(stalls, 99):6.1f} ms")
        print(f"order against the truth     {agreement:6.3f} (Spearman)")
        window.document.review.mark_saved()
        window.close()


if __name__ == "__main__":
    main()
