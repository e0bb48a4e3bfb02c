"""Measure the time to show a frame in the 3D view, compared with a window of plain tubes.

    python benchmarks/scrub.py [--clip CLIP] [--frames N] [--json]

Both windows are 1280×411 and are repainted synchronously and in turn during one run, so that other
load on the machine affects them equally.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyvista as pv
from PySide6.QtCore import QEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget
from pyvistaqt import QtInteractor

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks._frames import Figures, run
from inspector.session.document import Document
from inspector.session.open_clip import Show
from inspector.session.opening import Analysed, analyse_file
from inspector.viewport import opengl
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import DARK, Colours
from tests.gui.waiting import wait
from twistcore.detection import Interval
from twistcore.review import Insert

SIZE = (1280, 411)
CLIP = Path(__file__).resolve().parent.parent / "assets" / "walk.bvh"
TARGET_MS, TARGET_RATIO = 25.0, 1.5


class Tubes(QWidget):
    """A minimal 3D view of a skeleton: one tube per bone, without roll and ground."""

    def __init__(self, data: Analysed) -> None:
        super().__init__()
        self._data = data
        skeleton = data.motion.skeleton
        lines = [(2, int(p), j) for j, p in enumerate(skeleton.parents) if p >= 0]
        lines = [x for x in lines if np.linalg.norm(skeleton.offsets[x[2]]) > 1e-6]
        self._ends = np.array(lines)[:, 1:]
        self._ring = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
        radius = 0.02 * skeleton.height
        self._circle = radius * np.stack([np.cos(self._ring), np.sin(self._ring)], axis=1)
        faces = []
        for k in range(len(lines)):
            for i in range(12):
                m = (i + 1) % 12
                faces += [4, 24 * k + i, 24 * k + m, 24 * k + 12 + m, 24 * k + 12 + i]
        self._mesh = pv.PolyData(self._points(0), faces=faces)
        self.view = QtInteractor(self, auto_update=False, multi_samples=opengl.multisamples())
        self.view.resize(*SIZE)
        self.view.add_mesh(self._mesh, color="#cccccc", render=False)
        self.view.reset_camera(render=False)

    def _points(self, frame: int) -> np.ndarray:
        start, stop = (self._data.positions[frame][self._ends[:, k]] for k in (0, 1))
        axis = stop - start
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        u = np.cross(axis, [0.31, 0.83, 0.46])
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        v = np.cross(axis, u)
        ring = self._circle[None, :, :1] * u[:, None] + self._circle[None, :, 1:] * v[:, None]
        both = np.stack([start[:, None] + ring, stop[:, None] + ring], axis=1)
        return both.reshape(-1, 3).astype(np.float32)

    def show_frame(self, frame: int) -> None:
        """Move the tubes to the pose in a frame, and repaint."""
        self._mesh.points[:] = self._points(frame)
        self._mesh.GetPoints().Modified()
        self._mesh.Modified()
        repaint(self.view)


def repaint(view: QWidget) -> None:
    """Repaint a widget immediately. QWidget.repaint() would wait for the next vsync."""
    QWidget.update(view)
    QApplication.sendEvent(view.window(), QEvent(QEvent.Type.UpdateRequest))


def time_of(action: Callable[..., None], *arguments: int) -> float:
    """Return the duration of a call in milliseconds."""
    start = time.perf_counter()
    action(*arguments)
    return 1e3 * (time.perf_counter() - start)


def measure(clip: Path, frames: int) -> Figures:
    """Measure both windows, and return the medians and the 95th percentile in milliseconds."""
    data = analyse_file(clip)
    document = Document()
    document.show_clip(data)
    viewport, tubes = Viewport(document, Colours(DARK)), Tubes(data)
    for window in (viewport, tubes):
        window.resize(*SIZE)
        window.show()
        QTest.qWaitForWindowExposed(window)
        wait(300)
    if data.chains:  # show a ghost in half of the frames
        whole = Interval(
            data.chains[0].name, 0, document.frames // 2, np.full(document.frames // 2, 1.0)
        )
        document.do(Insert(whole))
    document.set_show(Show.BOTH)

    def scrub(frame: int) -> None:
        document.go_to(frame)
        viewport.refresh()
        repaint(viewport.view)

    chosen = np.linspace(1, document.frames - 1, frames).astype(int)
    ours, skinned, beside, bare = [], [], [], []
    order = [int(f) for f in np.random.default_rng(1).permutation(chosen)]
    for style, split, into in (
        (Style.WEDGES, False, ours),
        (Style.SKIN, False, skinned),
        (Style.WEDGES, True, beside),
    ):
        viewport.look(style=style)
        viewport.look(split=split)
        for frame in order[:5]:  # the first frames compile shaders
            scrub(frame)
            tubes.show_frame(frame)
        for frame in order:
            into.append(time_of(scrub, frame))
            other = time_of(tubes.show_frame, frame)
            if into is ours:
                bare.append(other)
    document.close_clip()
    viewport.close()
    tubes.view.close()
    tubes.close()
    return {
        "clip": clip.name,
        "driver": opengl.renderer_name(),
        "frames": len(ours),
        "view_median_ms": round(float(np.median(ours)), 2),
        "view_p95_ms": round(float(np.percentile(ours, 95)), 2),
        "tubes_median_ms": round(float(np.median(bare)), 2),
        "skin_median_ms": round(float(np.median(skinned)), 2),
        "beside_median_ms": round(float(np.median(beside)), 2),
        "ratio": round(float(np.median(ours) / np.median(bare)), 2),
    }


def is_good(figures: Figures) -> bool:
    """Return True if the median and the ratio meet their targets."""
    median, ratio = (float(figures[k]) for k in ("view_median_ms", "ratio"))
    return median <= TARGET_MS and ratio <= TARGET_RATIO


def main() -> int:
    """Print the table. Return 1 if a target is missed."""
    _app = QApplication.instance() or QApplication([])
    return run(__doc__.splitlines()[0], CLIP, 200, measure, is_good)


if __name__ == "__main__":
    sys.exit(main())
