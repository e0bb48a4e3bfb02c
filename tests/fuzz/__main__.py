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

from tests.fuzz.trial import Outcome, child, files_of, kind_named, kinds, trial, tried, write_files

SHOWN = 20  # failures of a kind that are shown in full


def main() -> int:
    """Run and print the counts."""
    if "--child" in sys.argv:
        name, *_, first, stop = sys.argv[1:]
        child(kind_named(name), int(sys.argv[3]), int(first), int(stop))
        return 0
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
    arguments = parser.parse_args()
    chosen = list(known) if "all" in arguments.kind else arguments.kind
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
        alike: dict[str, list[Outcome]] = {}
        for one in report.failures:
            alike.setdefault(one.outcome + one.told.strip().split("\n")[-1][-80:], []).append(one)
        for some in list(alike.values())[:SHOWN]:
            one = some[0]
            print(f"  {len(some)} alike: cases {', '.join(str(o.case) for o in some[:20])}")
            again = f"--seed {arguments.seed} --first {one.case} --keep FOLDER"
            print(f"  {one.outcome}, {one.seconds:.2f} s, {one.grown >> 20} MiB: {name} {again}")
            print("    " + one.told.strip().replace("\n", "\n    "), flush=True)
        failed += len(report.failures)
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
