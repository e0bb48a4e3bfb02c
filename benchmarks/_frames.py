"""Provide the command line and the table of benchmarks that draw frames of a clip."""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

Figures = dict[str, float | int | str]


def run(
    about: str,
    clip: Path,
    frames: int,
    measure: Callable[[Path, int], Figures],
    is_good: Callable[[Figures], bool],
) -> int:
    """Measure a copy of a clip, print a table, and return the exit code: 1 if a target is missed.

    Parameters
    ----------
    about
        The description in the command's help.
    clip, frames
        The default values of the options.
    measure
        A function that returns the results.
    is_good
        A function that returns True if the results meet the targets.
    """
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--clip", type=Path, default=clip)
    parser.add_argument("--frames", type=int, default=frames)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:  # a review's journal is written next to its clip
        figures = measure(Path(shutil.copy(options.clip, folder)), options.frames)
    good = is_good(figures)
    if options.json:
        print(json.dumps(figures))
    else:
        for name, value in (figures | {"target": "met" if good else "MISSED"}).items():
            print(f"{name:>16}  {value}")
    return 0 if good else 1
