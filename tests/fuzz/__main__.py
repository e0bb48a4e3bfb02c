"""Damaged files of a kind: python -m tests.fuzz KIND --number 10000 --seed S.

Valid files are damaged at random and read as the program reads them. Each case must end in what the
file holds, or in one sentence that says what is wrong with it, within 2 s of processor time and in
bounded memory. Every other case is listed with what makes it again; the exit status is then 1.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from tests.fuzz.trial import child, files_of, kinds, trial, tried, write_files

SHOWN = 20  # failures of a kind that are shown in full


def main() -> int:
    """Run and print the counts."""
    known = kinds()
    parser = argparse.ArgumentParser("python -m tests.fuzz", description=__doc__)
    names = [*known, "all"]
    parser.add_argument("kind", nargs="+", choices=names, metavar="KIND", help=", ".join(names))
    parser.add_argument("--number", type=int, default=1000, help="cases of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0, help="the first case")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="at most, a kind")
    told = "write the files of the first case there, and read them in this process"
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help=told)
    parser.add_argument("--child", type=int, nargs=2, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    chosen = list(known) if "all" in arguments.kind else arguments.kind
    if arguments.child:
        child(known[chosen[0]], arguments.seed, *arguments.child)
        return 0
    if arguments.keep:
        kind, case = known[chosen[0]], (arguments.seed, arguments.first)
        arguments.keep.mkdir(parents=True, exist_ok=True)
        write_files(files_of(kind, *case), arguments.keep)
        print(tried(kind, *case, arguments.keep))
        return 0
    failed = 0
    for name in chosen:
        begun = time.monotonic()
        report = trial(
            known[name],
            arguments.number,
            arguments.seed,
            first=arguments.first,
            seconds=arguments.seconds,
        )
        print(f"{report} in {time.monotonic() - begun:.0f} s", flush=True)
        for one in report.failures[:SHOWN]:
            again = f"--seed {arguments.seed} --first {one.case} --keep FOLDER"
            print(f"  {one.outcome}, {one.seconds:.2f} s, {one.grown >> 20} MiB: {name} {again}")
            print("    " + one.told.strip().replace("\n", "\n    "), flush=True)
        failed += len(report.failures)
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
