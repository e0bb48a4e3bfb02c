"""Measure the processor time of the key N and of a frame step in the window.

    python -m benchmarks.review_steps [--clip CLIP] [--rounds N] [--against CHECKOUT]

The whole window is measured, with the default skin side by side. The key N goes to the next
interval, and a step moves the playhead by a frame. Each measurement ends when everything is
painted. The third number is for a step of the 3D view alone. Processor time depends less on other
programs than elapsed time. With `--against`, another checkout is measured alternately with this
one, and the last column is the ratio.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CLIP = ROOT / "assets" / "kick.bvh"
WHAT = {"N": "N", "step": "a frame step", "view": "skin side by side"}
_STEPS, _REST_S = 12, 0.05


def serve(clip: Path) -> None:
    """Measure the actions named on standard input, and print the results, until end of file.

    `clip` is the clip to open.
    """
    from PySide6.QtCore import QCoreApplication, QEvent

    from inspector.app import make_application
    from inspector.collector import exclude_from_collection
    from inspector.session.document import Document
    from inspector.session.opening import analyse_file
    from inspector.session.settings import Settings
    from inspector.viewport.solid_and_ghost import Style
    from inspector.viewport.viewport import Viewport
    from inspector.widgets.theme import LIGHT, Colours
    from inspector.window.main_window import MainWindow

    app = make_application()
    window = MainWindow(Settings(theme="light", order="chain"), None)
    window.resize(1440, 900)
    window.show()
    exclude_from_collection()
    window.document.show_clip(analyse_file(clip))
    alone = Document()
    alone.show_clip(analyse_file(clip))
    view = Viewport(alone, Colours(LIGHT))
    view.resize(1280, 411)
    view.show()
    view.look(style=Style.SKIN, split=True)

    def settle(seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            app.processEvents()
            QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
            if window.viewport.pending or window.viewport.turning or view.pending:
                end = time.monotonic() + seconds
            time.sleep(0.002)

    def next_interval() -> None:
        window.actions_by_id["next_interval"].trigger()
        settle(_REST_S)

    def step(document: Document) -> None:
        frame = document.frame
        document.go_to(frame + 1 if frame % 2 == 0 and frame + 1 < document.frames else frame - 1)
        while window.viewport.pending or view.pending:
            app.processEvents()
        app.processEvents()

    settle(1.0)
    work: dict[str, Callable[[], None]] = {
        "N": next_interval,
        "step": lambda: step(window.document),
        "view": lambda: step(alone),
    }
    for _ in range(len(window.document.intervals)):
        next_interval()
    alone.select_interval(alone.intervals[0].id, jump=True)
    settle(1.0)
    for line in sys.stdin:
        spent = []
        for _ in range(_STEPS):
            begun = time.process_time()
            work[line.strip()]()
            spent.append(1e3 * (time.process_time() - begun))
        print("measured", json.dumps(spent), flush=True)
    window.document.review.mark_saved()
    alone.review.mark_saved()
    view.close()
    window.close()


class Worker:
    """A window of the program in a checkout, running in a separate process."""

    def __init__(self, root: Path, folder: Path, clip: Path) -> None:
        folder.mkdir()
        own = shutil.copy(clip, folder)
        environment = {
            **os.environ,
            "PYTHONPATH": str(root),
            "TWIST_INSPECTOR_SETTINGS": str(folder / "settings.json"),
            "XDG_STATE_HOME": str(folder / "state"),
        }
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(Path(__file__)), "--serve", "--clip", str(own)],
            env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def measure(self, what: str) -> list[float]:
        """Return the processor time of several actions of a kind, in milliseconds."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(what + "\n")
        self._process.stdin.flush()
        for line in self._process.stdout:
            if line.startswith("measured "):
                found: list[float] = json.loads(line.removeprefix("measured "))
                return found
        raise SystemExit("the window ended early")

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def main() -> None:
    """Measure both checkouts alternately and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clip", type=Path, default=CLIP)
    parser.add_argument("--rounds", type=int, default=6)
    parser.add_argument("--against", type=Path, help="another checkout to measure in turns")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        serve(options.clip)
        return
    roots = [ROOT, *([options.against.resolve()] if options.against else [])]
    with tempfile.TemporaryDirectory() as folder:
        folders = [Path(folder) / str(k) for k in range(len(roots))]
        workers = [Worker(*place, options.clip) for place in zip(roots, folders, strict=True)]
        times: dict[str, list[list[float]]] = {what: [[] for _ in roots] for what in WHAT}
        for _ in range(options.rounds):
            for what, spent in times.items():
                for worker, own in zip(workers, spent, strict=True):
                    own += worker.measure(what)
        for worker in workers:
            worker.close()
    print("processor milliseconds, median       " + "".join(f"{r.name:>16}" for r in roots))
    for what, spent in times.items():
        medians = [float(np.median(own)) for own in spent]
        ratio = f"{medians[0] / medians[1]:>10.2f}" if len(medians) > 1 else ""
        print(f"{WHAT[what]:<37}" + "".join(f"{m:>16.1f}" for m in medians) + ratio)


if __name__ == "__main__":
    main()
