"""Where things are in a checkout."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
STAMP = VENV / "twist-inspector.stamp"
OUT = ROOT / "out"
# Which version of every package is installed here, each file by its hash, for every system and
# Python from the oldest on; and the same for what a bundle is made of. `pip install` of the program
# knows nothing of them: in somebody's environment it must get on with what else is there.
LOCK, BUNDLE_LOCK = ROOT / "requirements.lock", ROOT / "packaging" / "bundle.lock"
