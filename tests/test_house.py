"""The house: no circles, arrows down only; its picture is drawn from these imports."""

from __future__ import annotations

import runpy
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[1]
HOUSES = ("inspector", "twistcore")
MODULES = [f for h in HOUSES for f in sorted((ROOT / h).rglob("*.py")) if f.stem != "__init__"]
SPAWNED = ("inspector.folder.survey_worker", "inspector.tuning.cost_worker")


@pytest.fixture(scope="module")
def graph() -> grimp.ImportGraph:
    """All imports, those under TYPE_CHECKING too."""
    return grimp.build_graph(*HOUSES, cache_dir=None)


def test_no_circle_of_imports(graph: grimp.ImportGraph) -> None:
    below = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    assert len(below) > len(MODULES)
    TopologicalSorter(below).prepare()  # raises CycleError with the circle


def test_the_core_has_at_most_16_rooms() -> None:
    """Folders and modules of twistcore's root: a newcomer sees where to go."""
    root = ROOT / "twistcore"
    entries = {f.name for f in root.iterdir() if f.is_file() or (f / "__init__.py").is_file()}
    entries -= {"__init__.py", "__main__.py", "py.typed"}
    assert len(entries) <= 16, sorted(entries)


def test_the_main_window_knows_at_most_25_modules(graph: grimp.ImportGraph) -> None:
    """A feature comes into the list of features, not into the main window."""
    known = graph.find_modules_directly_imported_by("inspector.window.main_window")
    ours = {module for module in known if module.split(".")[0] in HOUSES}
    assert len(ours) <= 25, sorted(ours)


def test_the_picture_is_drawn_from_these_imports(graph: grimp.ImportGraph) -> None:
    drawing = runpy.run_path(str(ROOT / "docs" / "draw_architecture.py"))
    shown = drawing["PICTURE"].read_text("utf-8")
    assert drawing["picture"](graph) == shown, "draw it again: python docs/draw_architecture.py"


@pytest.mark.parametrize("module", SPAWNED)
def test_spawned_processes_load_no_qt(module: str) -> None:
    program = f"import sys, {module}; print(any(m.startswith('PySide6') for m in sys.modules))"
    found = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, text=True, capture_output=True
    )
    assert found.stdout == "False\n", found.stderr
