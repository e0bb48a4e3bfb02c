"""Measure the time from the start of the program to its first picture.

    python -m benchmarks.start_up [--runs N]

A new interpreter is started N times and opens the sample in the real window. The output shows the
median seconds until the window is painted, and until the clip's figure, tables and curves are
painted. The first run, which reads files from the disk, is shown separately.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from inspector.unread_sources import disable_pyside_source_reading

SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "walk_injected.bvh"


def child(begun: float, clip: Path) -> None:
    """Open the clip and print both durations.

    `begun` is the value of time.time() before the interpreter started.
    """
    os.environ.setdefault("QT_API", "pyside6")
    disable_pyside_source_reading()  # as the program does
    from inspector.app import make_application

    app = make_application()
    from inspector.session.settings import Settings
    from inspector.window.main_window import MainWindow

    window = MainWindow(Settings(), None)
    window.show()
    window.open_path(clip)
    app.processEvents()
    shown = time.time() - begun
    while window.document.data is None or window.viewport.pending:
        app.processEvents()
    app.processEvents()
    print(shown, time.time() - begun)
    window.close()


def main() -> None:
    """Measure the start and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--child", nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.child:
        child(float(arguments.child[0]), Path(arguments.child[1]))
        return
    times = []
    with tempfile.TemporaryDirectory() as folder:
        clip = shutil.copy(SAMPLE, folder)
        for _ in range(arguments.runs + 1):
            command = [sys.executable, "-m", "benchmarks.start_up", "--child"]
            done = subprocess.run(
                [*command, repr(time.time()), clip], check=True, capture_output=True, text=True
            )
            times.append([float(t) for t in done.stdout.split()[-2:]])
    first, rest = times[0], times[1:]
    shown, pictured = (statistics.median(t[k] for t in rest) for k in (0, 1))
    print(f"first run         window {first[0]:.2f} s, picture {first[1]:.2f} s")
    print(f"median of {len(rest)}       window {shown:.2f} s, picture {pictured:.2f} s")


if __name__ == "__main__":
    main()
