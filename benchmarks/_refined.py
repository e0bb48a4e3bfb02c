"""Correct a clip with `twistcore refine`, for several benchmarks."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

from twistcore.cli import main as twistcore
from twistcore.errors import TwistError

EVERYTHING = ("--min-confidence", "0", "--include-open")  # options to correct all detections


def refine_file(path: Path, output: Path, *words: str) -> None:
    """Correct the clip at `path` and write it to `output`. Raises TwistError if this fails.

    `words` are additional options of `twistcore refine`.
    """
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = twistcore(["refine", str(path.resolve()), "-o", str(output), *words])
    if not output.exists():
        raise TwistError(f"refine ended with {status}: {said.getvalue().strip()}")
