"""Where Blender is for the tests that need it: TWIST_BLENDER names it, or a Python that has bpy."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

BLENDER = os.environ.get("TWIST_BLENDER") or shutil.which("blender")

needs_blender = pytest.mark.skipif(
    BLENDER is None, reason="no Blender: set TWIST_BLENDER to it, or to a Python that has bpy"
)


def blender(folder, *jobs):
    """Do jobs of in_blender.py in one process; what the scripts printed."""
    listed, words = folder / "jobs.json", [BLENDER]
    listed.write_text(json.dumps([[str(w) if isinstance(w, Path) else w for w in j] for j in jobs]))
    inside = str(Path(__file__).with_name("in_blender.py"))
    if Path(BLENDER).name.startswith("python"):
        words += [inside, str(listed)]
    else:
        words += ["--background", "--factory-startup", "--python", inside, "--", str(listed)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout
