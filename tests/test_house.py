"""The house: no circles, arrows down only; its picture is drawn from these imports."""

from __future__ import annotations

import ast
import re
import runpy
import subprocess
import sys
from collections import Counter
from graphlib import TopologicalSorter
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).resolve().parents[1]
HOUSES = ("inspector", "twistcore")
MODULES = [f for h in HOUSES for f in sorted((ROOT / h).rglob("*.py")) if f.stem != "__init__"]
SPAWNED = ("inspector.folder.survey_worker", "inspector.tuning.cost_worker")

SEVERAL_MEANINGS = {  # only ever fewer
    *("Column", "Scope", "counter_rotation"),
}
MOST_IMPORTS, MOST_NAMES = 15, 12
AS_THE_STANDARD_LIBRARY = {"twistcore.work.frozen"}  # in place of dataclasses: not counted
# Today's exceptions, with their numbers: only ever fewer and smaller.
MANY_IMPORTS = {
    "inspector.lessons.classroom": 16,
    "inspector.lessons.guided_exercise": 20,
    "inspector.panels.chains_panel": 18,
    "inspector.panels.detail_card": 24,
    "inspector.panels.intervals_panel": 17,
    "inspector.session.document": 18,
    "inspector.session.export_files": 19,
    "inspector.session.opening": 24,
    "inspector.shots": 17,
    "inspector.teaching.gizmo_drawing": 22,
    "inspector.teaching.teaching_panel": 16,
    "inspector.timeline.timeline": 20,
    "inspector.tuning.tuning_panel": 19,
    "inspector.viewport.frame_drawing": 21,
    "inspector.viewport.scene": 19,
    "inspector.viewport.viewport": 18,
    "inspector.window.main_window": 23,
    "inspector.window.review_actions": 19,
    "twistcore.analysis.clip_analysis": 30,
    "twistcore.batch.clip_result": 16,
    "twistcore.cli.batch_command": 20,
    "twistcore.cli.correct_commands": 20,
    "twistcore.cli.detect_commands": 17,
    "twistcore.cli.quamo_commands": 20,
    "twistcore.cli.quamo_study_commands": 17,
    "twistcore.cli.tune_command": 18,
    "twistcore.detection.consistency.detector": 20,
    "twistcore.report.document": 16,
    "twistcore.review.journal": 18,
    "twistcore.review.session": 16,
}
MANY_NAMES = {
    "inspector.session.session_files": 14,
    "inspector.session.settings_checks": 15,
    "twistcore.cli.arguments.argument_types": 19,
    "twistcore.cli.output": 16,
    "twistcore.files.atomic": 13,
    "twistcore.files.document_values": 19,
    "twistcore.skeleton.rotation": 21,
    "twistcore.study.evaluation": 13,
}


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


def _module(file: Path) -> str:
    return ".".join(file.relative_to(ROOT).with_suffix("").parts)


@pytest.fixture(scope="module")
def public_names() -> dict[str, set[str]]:
    """Public classes and functions at the top of each module."""
    kinds = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    return {
        _module(file): {
            node.name
            for node in ast.parse(file.read_text("utf-8")).body
            if isinstance(node, kinds) and not node.name.startswith("_")
        }
        for file in MODULES
    }


def test_a_public_name_has_one_home(public_names: dict[str, set[str]]) -> None:
    """One name, one meaning; `main` is what a program begins with."""
    homes = Counter(name for names in public_names.values() for name in names)
    several = {name for name, count in homes.items() if count > 1} - {"main"}
    assert several - SEVERAL_MEANINGS == set(), "find a name that nothing else has"
    assert several == SEVERAL_MEANINGS, "take what has one meaning now off the list"


def test_modules_import_few_of_ours(graph: grimp.ImportGraph) -> None:
    counts = {
        name: len(graph.find_modules_directly_imported_by(name) - AS_THE_STANDARD_LIBRARY)
        for name in map(_module, MODULES)
    }
    _assert_within(counts, MOST_IMPORTS, MANY_IMPORTS)


def test_modules_have_few_public_names(public_names: dict[str, set[str]]) -> None:
    counts = {module: len(names) for module, names in public_names.items()}
    _assert_within(counts, MOST_NAMES, MANY_NAMES)


def _assert_within(counts: dict[str, int], most: int, exceptions: dict[str, int]) -> None:
    over = {name: n for name, n in counts.items() if n > exceptions.get(name, most)}
    assert not over, f"at most {most}, or as listed: split the module"
    idle = {name for name in exceptions if counts.get(name, 0) <= most}
    assert not idle, "take these off the list of exceptions"


def test_docstrings_refer_to_functions_and_classes_that_exist():
    texts = {path: path.read_text("utf-8") for path in MODULES}
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    nodes = (node for text in texts.values() for node in ast.walk(ast.parse(text)))
    known = {node.name for node in nodes if isinstance(node, kinds)}
    role = re.compile(r":(?:func|class|meth):`[^`]*?([A-Za-z_]\w*)(?:\(\))?>?`")
    assert role.search(":func:`a text <other.place>`")[1] == "place"
    unknown = {
        f"{path.relative_to(ROOT)}: {found[0]}"
        for path, text in texts.items()
        for found in role.finditer(text)
        if found[1] not in known
    }
    assert not unknown
