"""Measure the window with very large clips.

    python -m benchmarks.large_clips [--frames N] [--joints N]

Two clips are opened in the real window. The first is the sample with eight errors, repeated up to
200,000 frames. The second is a generated skeleton of many short limbs (300 joints, 3,000 frames)
with one error in each of ten limbs. The output shows the cost of opening, the memory at the end,
the file size, and the median and 95th percentile of the cost of each user action until its last
pixel is drawn. The actions are moving the playhead, dragging an edge of an interval, dragging τ,
deciding on an interval and undoing this, and zooming the plots.

The times are CPU times of the whole process with all threads, so other programs do not count. With
a graphics card, the 3D view costs less.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

os.environ.setdefault("QT_API", "pyside6")

import numpy as np
from PySide6.QtCore import QEventLoop
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from benchmarks.alive import give_back, resident
from inspector.app import exclude_from_collection, make_application
from inspector.session.settings import Settings
from inspector.window.main_window import MainWindow
from tests.gui.waiting import wait
from twistcore.detection.interval_offsets import resized_interval
from twistcore.formats.bvh import write_motion
from twistcore.review import Decision
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import quaternion_from_axis_angle
from twistcore.synthesis import InjectedError, inject

SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "walk_injected.bvh"
FRAMES, JOINTS, FRAMES_OF_JOINTS = 200_000, 300, 3_000
_LIMB = 5  # number of joints of a generated limb
_STEPS = 60  # number of actions of each kind
_PATIENCE = 1_800.0  # seconds to wait for the clip


def long_clip(path: Path, frames: int) -> None:
    """Write a clip that repeats the frames of the sample."""
    head, _, rows = SAMPLE.read_text("ascii").rstrip().partition("Frame Time:")
    step, *lines = rows.splitlines()
    head = re.sub(r"Frames:.*", f"Frames: {frames}", head)
    with path.open("w", encoding="ascii") as file:
        file.write(f"{head}Frame Time:{step}\n")
        for first in range(0, frames, len(lines)):
            file.write("\n".join(lines[: frames - first]) + "\n")


def many_joints(path: Path, joints: int, frames: int) -> None:
    """Write a clip of a generated body: a root, and limbs of five joints that swing and twist.

    In ten of these limbs, a parent is twisted by 40° for half a second, and its child is twisted
    back.
    """
    rng = np.random.default_rng(1)
    names, parents, offsets = ["Hips"], [-1], [np.zeros(3)]
    for joint in range(1, joints):
        limb, k = divmod(joint - 1, _LIMB)
        turn = 2.0 * np.pi * limb * _LIMB / joints
        parents.append(joint - 1 if k else 0)
        names.append(f"Limb{limb + 1}Joint{k + 1}")
        around = np.array([np.cos(turn), 0.0, np.sin(turn)])
        offsets.append(np.array([0.0, -8.0, 0.0]) if k else 10.0 * around)
    count = len(names)
    tips = tuple((k, (0.0, -4.0, 0.0)) for k in range(count) if k not in parents)
    skeleton = Skeleton(tuple(names), np.array(parents), np.array(offsets), tips)
    t = np.arange(frames) / 120.0
    rotations = np.zeros((frames, count, 4))
    for joint in range(count):
        axis = rng.normal(size=3)
        speed, size = rng.uniform(0.2, 1.2), rng.uniform(0.1, 0.6)
        angle = size * np.sin(2.0 * np.pi * speed * t + rng.uniform(0.0, 6.0))
        rotations[:, joint] = quaternion_from_axis_angle(axis / np.linalg.norm(axis), angle)
    motion = Motion(skeleton, rotations, (0,), np.zeros((frames, 1, 3)), 1.0 / 120.0)
    chains = find_chains(motion)
    errors = [
        InjectedError(chains[k].name, start, start + 60, np.full(60, np.radians(40.0)))
        for k in rng.choice(len(chains), 10, replace=False)
        for start in (frames // 3,)
    ]
    write_motion(inject(motion, chains, errors), path)


@dataclass
class Measured:
    """The results for one clip.

    Attributes
    ----------
    opened
        CPU time of opening, in milliseconds.
    shown
        A description of the clip.
    steps
        CPU times in milliseconds, keyed by action.
    mib
        Memory at the end, in MiB.
    """

    opened: float = 0.0
    shown: str = ""
    steps: dict[str, list[float]] = field(default_factory=dict)
    mib: float = 0.0

    def lines(self) -> list[str]:
        """Return the results as the lines of a table."""
        out = [self.shown, f"  {'opened':<28} {self.opened / 1e3:8.1f} s"]
        for what, times in self.steps.items():
            middle, high = np.percentile(times, (50, 95))
            out.append(f"  {what:<28} {middle:8.1f} ms {high:8.1f} ms")
        return [*out, f"  {'memory':<28} {self.mib:8.0f} MiB"]


def a_window() -> MainWindow:
    """Return a visible window without a clip."""
    window = MainWindow(Settings(theme="light", turn_ms=0), None)
    window.resize(1440, 900)
    window.show()
    QTest.qWaitForWindowExposed(window)
    exclude_from_collection()
    return window


def measure(app: QApplication, window: MainWindow, path: Path, steps: int = _STEPS) -> Measured:
    """Open a clip and imitate a user. Each kind of action is repeated up to `steps` times."""
    found = Measured()
    document, rng = window.document, np.random.default_rng(1)

    def drawn() -> None:
        app.processEvents()
        while window.viewport.pending:
            app.processEvents(QEventLoop.ProcessEventsFlag.AllEvents, 1)
        app.processEvents()

    def step(what: str, do: Callable[[], object]) -> None:
        begun = time.process_time()
        do()
        drawn()
        found.steps.setdefault(what, []).append(1e3 * (time.process_time() - begun))

    begun, end = time.process_time(), time.monotonic() + _PATIENCE
    window.open_path(path)
    while document.data is None and time.monotonic() < end:
        wait(20)
    drawn()
    found.opened = 1e3 * (time.process_time() - begun)
    if document.data is None:
        raise TimeoutError(f"{path} was not open after {_PATIENCE:.0f} s")
    motion, frames = document.data.motion, document.frames
    found.shown = (
        f"{frames:,d} frames, {len(motion.skeleton)} joints, {len(document.data.chains)} chains, "
        f"{len(document.intervals):,d} intervals, {path.stat().st_size / 1e6:.0f} MB"
    )
    wait(500)
    for frame in rng.integers(0, frames, steps):
        step("the playhead anywhere", lambda to=int(frame): document.go_to(to))
    for frame in range(frames // 2, frames // 2 + steps):
        step("the next frame", lambda to=frame: document.go_to(to))
    repairable = [j for j in document.intervals if j.interval.repairable]
    judged = repairable[len(repairable) // 2]
    document.select_interval(judged.id, jump=True)
    step("zoom to the interval", window.timeline.visible.zoom_to_interval)
    drag, old = document.begin_drag(), judged.interval
    for k in range(steps):
        new = resized_interval(old, old.start, old.stop + 1 + k % 30)
        step("a border dragged", lambda to=new: document.edit(judged.id, to, drag))
    step("zoom to all", window.timeline.visible.show_all)
    drag = document.begin_drag()
    for degrees in np.geomspace(2.0, 120.0, steps):
        tau = float(np.radians(degrees))
        step("τ dragged", lambda to=tau: document.set_tau(to, document.chain, drag))
    step("undone", document.undo)
    for _ in range(steps // 3):
        step("to the next interval", lambda: window.actions_by_id["next_interval"].trigger())
        step("judged", lambda: document.decide(Decision.ACCEPTED, [document.interval_id or 0]))
    for _ in range(steps // 6):
        step("undone", document.undo)
    give_back()
    found.mib = resident()
    return found


def main() -> None:
    """Measure both clips and print a table for each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--frames", type=int, default=FRAMES, help="frames of the long clip; 0: none"
    )
    parser.add_argument(
        "--joints", type=int, default=JOINTS, help="joints of the other clip; 0: none"
    )
    chosen = parser.parse_args()
    if chosen.joints and chosen.frames:  # each in a separate process, to separate the memory
        print("CPU time of the process: median and 95th percentile", flush=True)
        for only in (["--frames", "0"], ["--joints", "0"]):
            subprocess.run([sys.executable, "-m", __spec__.name, *sys.argv[1:], *only], check=True)
        return
    app = make_application()
    with TemporaryDirectory() as scratch:
        os.environ["XDG_STATE_HOME"] = str(Path(scratch, "state"))
        os.environ["TWIST_INSPECTOR_SETTINGS"] = str(Path(scratch, "settings.json"))
        path = Path(scratch, "clip.bvh")
        if chosen.joints:
            many_joints(path, chosen.joints, FRAMES_OF_JOINTS)
        else:
            long_clip(path, chosen.frames)
        window = a_window()
        print(*measure(app, window, path).lines(), sep="\n", flush=True)
        window.document.review.mark_saved()
        window.close_without_asking()


if __name__ == "__main__":
    main()
