"""Kill the program at random moments: python -m benchmarks.kills [--decisions N] [--exports N] …

The benchmark needs Linux and a screen (such as `xvfb-run`). The program is killed with kill -9.
There are three kinds of trials:

- Decisions: the program is killed between random commands in its real window. The disk must contain
  the last reported state or the next one, to the byte, and the next run must continue from there.
- Exports: the program is killed while it exports. Each file must be complete or missing, existing
  files must equal the output of `twistcore apply` for the session, and the next export must not
  leave any partial file.
- Folders: the program is killed while it surveys a folder. None of its processes may remain.

--equal makes 15 exports in a row without a kill; each must equal the output of `apply` for its
session. --minutes limits the time: later trials are skipped and reported. The output shows the
number of trials and failures. The exit code is 1 if any trial failed.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.gui.kills import (
    equal_exports,
    killed_in_an_export,
    killed_twice_among_decisions,
    killed_with_a_folder,
)

_Trial = Callable[[Path, int], object]


def run(name: str, trial: _Trial, seeds: Sequence[int], kills: int, until: float) -> int:
    """Run a trial with every seed, and return the number of failures.

    Parameters
    ----------
    name
        Name of the kind of trial.
    trial
        The trial, called with a folder and a seed.
    seeds
        The seeds.
    kills
        Number of kills in each trial.
    until
        Time after which no trial begins.
    """
    failed, found = 0, 0
    for done, seed in enumerate(seeds, 1):
        if time.monotonic() > until:
            break
        with tempfile.TemporaryDirectory() as folder:
            try:
                found += trial(Path(folder), seed) or 0  # type: ignore[call-overload]
            except Exception:  # report each failure, and try the next
                print(f"{name}, seed {seed}:", file=sys.stderr)
                traceback.print_exc()
                failed += 1
        more = f", {found} processes" if name == "folders" else ""
        left = f" of {kills * len(seeds)}" if done < len(seeds) else ""
        print(f"{name}: {kills * done}{left}{more}, {failed} failed", flush=True)
    return failed


def main(argv: Sequence[str] | None = None) -> int:
    """Run all trials, print the numbers of trials and failures, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--decisions", type=int, default=60, help="kills between decisions (60; even)"
    )
    parser.add_argument("--exports", type=int, default=40, help="kills during exports (40)")
    parser.add_argument("--folders", type=int, default=40, help="kills during a survey (40)")
    parser.add_argument("--equal", type=int, default=150, help="exports without a kill (150)")
    parser.add_argument("--seed", type=int, default=0, help="the first seed (0)")
    parser.add_argument(
        "--minutes", type=float, default=1e6, help="time after which no more trials begin"
    )
    words = parser.parse_args(argv)
    until = time.monotonic() + 60.0 * words.minutes
    failed = 0
    for name, trial, kills, count in (
        ("folders", killed_with_a_folder, 1, words.folders),
        ("exports", killed_in_an_export, 1, words.exports),
        ("decisions", killed_twice_among_decisions, 2, words.decisions),
        ("equal exports", equal_exports, 15, words.equal),
    ):
        seeds = range(words.seed, words.seed + count // kills)
        failed += run(name, trial, seeds, kills, until)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
