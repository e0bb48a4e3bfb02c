"""The paths of files and folders in a checkout."""

from __future__ import annotations

import os
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
STAMP = VENV / "twist-inspector.stamp"
OUT = ROOT / "out"
# The version and the hashes of every package in .venv and in a bundle, for all systems and all
# supported versions of Python. `pip install` of the program does not use these files, because it
# must be compatible with the packages that the user already has.
LOCK, BUNDLE_LOCK = ROOT / "requirements.lock", ROOT / "packaging" / "bundle.lock"
