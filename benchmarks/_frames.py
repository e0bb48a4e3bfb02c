"""The command line and the table of benchmarks that draw frames of a copied clip."""

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
    """Measure a copy of the clip and print a table. Return 1 if it misses a target, else 0.

    - about: the description in the command's help
    - clip, frames: the default values of the options
    - measure: a function that returns the numbers
    - is_good: a function that returns True if the numbers meet the targets
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
