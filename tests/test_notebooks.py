"""The notebooks of docs/: stored without results, run from top to bottom, and come out right."""

import os
import re
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat", reason="the extra docs brings it")
nbclient = pytest.importorskip("nbclient", reason="the extra docs brings it")

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "notebooks"
# What each says at its end, and how many figures it draws.
NOTEBOOKS = {
    "first_steps": (r"found again: 0\n", 3),
    "paper_tables": (r"\nconsistency +100\.00 +0\.00 +0\.00 +0\.0\n", 2),
    "own_rig": (r"<Interval Spine 100–118: \+9\.0°, confidence 1\.00>", 1),
}


def read(name):
    return nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)


def test_every_notebook_is_run_here():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == NOTEBOOKS.keys()


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_is_stored_without_results(name):
    nbformat.validate(read(name))
    for cell in read(name).cells:
        if cell.cell_type == "code":
            assert not cell.outputs
            assert cell.execution_count is None


# zmq and tornado, under nbclient, have warnings of their own about event loops.
@pytest.mark.thorough
@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs_and_comes_out_right(name, tmp_path):
    said, figures = NOTEBOOKS[name]
    here = {"IPYTHONDIR": str(tmp_path), "TMPDIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    environment = {k: v for k, v in os.environ.items() if k != "MPLBACKEND"} | here
    notebook = read(name)
    place = {"metadata": {"path": str(FOLDER)}}
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3", resources=place).execute(
        env=environment
    )
    outputs = [o for cell in notebook.cells for o in cell.get("outputs", ())]
    text = "".join(o.text for o in outputs if o.output_type == "stream" and o.name == "stdout")
    assert re.search(said, text), text
    assert sum("image/png" in o.get("data", {}) for o in outputs) == figures
    assert not [o.text for o in outputs if o.output_type == "stream" and "Warning" in o.text]
