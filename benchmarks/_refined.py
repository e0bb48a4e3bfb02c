"""Correct a clip in the same way as `twistcore refine`. Several benchmarks use this module."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

from twistcore.cli import main as twistcore
from twistcore.errors import TwistError

EVERYTHING = ("--min-confidence", "0", "--include-open")  # as if all finds were accepted


def refine_file(path: Path, output: Path, *words: str) -> None:
    """Write the corrected clip to `output`. Raise TwistError if it cannot be corrected."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = twistcore(["refine", str(path.resolve()), "-o", str(output), *words])
    if not output.exists():
        raise TwistError(f"refine ended with {status}: {said.getvalue().strip()}")
