"""kill -9 at random moments: python -m benchmarks.kills [--decisions N] [--exports N] …

Needs a screen (`xvfb-run` gives one) and Linux. Decisions: the program carries out seeded commands
in its real window and is killed among them; on the disk must be the state it told last or the next
one, to the byte, and the next run must go on from there. Exports: it is killed while it exports;
each file must be whole or not there, what is there must equal `twistcore apply` of its session, and
the next export must leave nothing half written. Folders: it is killed while it surveys one; no
process may stay behind. --equal: exports without a kill, 15 by 15, each of the bytes that `apply`
makes of its session. Printed: how many of each, and how many failed; the exit code is 1 if any did.
--minutes: what was not begun by then is left out, and told.
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
    """Carry out a trial with every seed, of so many kills each; how many of them failed."""
    failed, found = 0, 0
    for done, seed in enumerate(seeds, 1):
        if time.monotonic() > until:
            break
        with tempfile.TemporaryDirectory() as folder:
            try:
                found += trial(Path(folder), seed) or 0  # type: ignore[call-overload]
            except Exception:  # each that fails is told, and the next is tried
                print(f"{name}, seed {seed}:", file=sys.stderr)
                traceback.print_exc()
                failed += 1
        more = f", {found} processes" if name == "folders" else ""
        left = f" of {kills * len(seeds)}" if done < len(seeds) else ""
        print(f"{name}: {kills * done}{left}{more}, {failed} failed", flush=True)
    return failed


def main(argv: Sequence[str] | None = None) -> int:
    """Print what was tried and what failed; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--decisions", type=int, default=60, help="kills among them (60; even)")
    parser.add_argument("--exports", type=int, default=40, help="kills in them (40)")
    parser.add_argument("--folders", type=int, default=40, help="kills with one open (40)")
    parser.add_argument("--equal", type=int, default=150, help="exports (150)")
    parser.add_argument("--seed", type=int, default=0, help="the first of as many (0)")
    parser.add_argument("--minutes", type=float, default=1e6, help="after which no more are begun")
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
