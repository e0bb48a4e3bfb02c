"""Open clips one after the other in one view, and check that memory and VTK objects do not grow.

    python benchmarks/many_clips.py [--clips N] [--json]

Every clip is shown in both styles, side by side, with trails, and then replaced by the next.
"""

from __future__ import annotations

import argparse
import gc
import json
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from inspector.session.document import Document
from inspector.session.opening import analyse_file
from inspector.viewport.solid_and_ghost import Style
from inspector.viewport.viewport import Viewport
from inspector.widgets.theme import DARK, Colours
from tests.gui.waiting import wait

ASSETS = Path(__file__).resolve().parent.parent / "assets"
CLIPS = ("walk.bvh", "walk_injected.bvh", "dance.bvh", "basketball.bvh")
WARM = 20  # number of clips after which caches have their final size
MOST_MIB = 20.0  # largest allowed growth after these clips


def resident() -> float:
    """Return the resident memory of this process in MiB, or 0 if it is unknown."""
    try:
        pages = Path("/proc/self/statm").read_text(encoding="ascii").split()[1]
    except OSError:
        return 0.0
    return int(pages) * 4096 / 2**20


def alive() -> int:
    """Return the number of VTK objects that Python references."""
    gc.collect()
    return sum(type(o).__name__.startswith("vtk") for o in gc.get_objects())


def look(document: Document, view: Viewport, clip: Path) -> None:
    """Open a clip, and use all features that create meshes."""
    document.show_clip(analyse_file(clip))
    for style in Style:
        view.look(style=style)
        for split in (True, False):
            view.look(split=split)
            view.look(trails=split)
            document.go_to(document.frame + 50)
            view.refresh()
            wait(5)


def measure(count: int) -> dict[str, float | int]:
    """Open `count` clips, and return memory and numbers of objects after a while and at the end."""
    document = Document()
    view = Viewport(document, Colours(DARK))
    view.resize(640, 400)
    view.show()
    QTest.qWaitForWindowExposed(view)
    memory, objects, props = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        clips = [Path(shutil.copy(ASSETS / name, folder)) for name in CLIPS]
        for k in range(count):
            look(document, view, clips[k % len(clips)])
            objects.append(alive())
            memory.append(resident())
            assert view.view is not None
            props.append(view.view.renderer.GetViewProps().GetNumberOfItems())
        document.close_clip()
        view.close()
    start = min(WARM, count // 2)
    third = max(1, (count - start) // 3)
    return {
        "clips": count,
        "memory_warm_mib": round(float(np.median(memory[start : start + third])), 1),
        "memory_end_mib": round(float(np.median(memory[-third:])), 1),
        "objects_warm": max(objects[start : start + third]),
        "objects_end": max(objects[-third:]),
        "props_warm": max(props[start : start + third]),
        "props_end": max(props[-third:]),
    }


def is_level(found: dict[str, float | int]) -> bool:
    """Return True if neither memory nor the number of objects has grown."""
    return (
        found["memory_end_mib"] - found["memory_warm_mib"] <= MOST_MIB
        and found["objects_end"] <= found["objects_warm"]
        and found["props_end"] <= found["props_warm"]
    )


def main() -> int:
    """Print the table. Return 1 if something has grown."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clips", type=int, default=200)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    _app = QApplication.instance() or QApplication([])
    found = measure(options.clips)
    if options.json:
        print(json.dumps(found))
    else:
        for name, value in found.items():
            print(f"{name:>16}  {value}")
        print(f"{'level':>16}  {'yes' if is_level(found) else 'NO'}")
    return 0 if is_level(found) else 1


if __name__ == "__main__":
    sys.exit(main())
