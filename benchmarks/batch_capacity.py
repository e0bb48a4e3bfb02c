"""Workers, hours and cost of many clips: python -m benchmarks.batch_capacity OUTDIR… [--hours H].

Draws clips at random from those of manifests, with the seconds that each took, and lets workers
take them one after the other: the largest file first, as `batch` does, and in any order. Some are
slowed tenfold, as by a busy disk or neighbour. Printed for so many clips and workers: hours until
the last clip is done, what share of the workers' time is work (else they wait for stragglers, or
start), worker-hours and cost; then how many workers get it done in the hours wished for.
"""

from __future__ import annotations

import argparse
import heapq
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.batch import Manifest

CLIPS = (10_000, 100_000, 1_000_000)
WORKERS = (1, 4, 16, 64, 256, 1024)
SLOWER = 10.0  # times, of those that are slowed

Array = NDArray[np.float64]


def measured(folders: Sequence[Path]) -> tuple[Array, Array, Array]:
    """Seconds, bytes of the file and bytes of memory of every clip that was done."""
    rows = []
    for folder in folders:
        with Manifest.open(folder) as manifest:
            done = [row for row in manifest.rows().values() if row.state == "done" and row.seconds]
            rows += [(row.seconds, row.bytes, row.peak_bytes) for row in done]
    seconds, size, peak = np.array(rows, dtype=np.float64).T
    return seconds, size, peak


def until_done(seconds: Array, workers: int, start: float) -> float:
    """Seconds until the last of these clips is done, taken in this order; start: of a worker."""
    free = [start] * workers
    for each in seconds.tolist():
        heapq.heapreplace(free, free[0] + each)
    return max(free)


def workers_for(seconds: Array, hours: float, start: float) -> int | None:
    """About the least number of workers that are done in so many hours; None where none is."""
    if seconds.max() + start > 3600.0 * hours:
        return None
    workers = max(1, int(seconds.sum() / (3600.0 * hours)))
    while until_done(seconds, workers, start) > 3600.0 * hours:
        workers = max(workers + 1, int(1.01 * workers))
    return workers


def main() -> None:
    """Run it and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path, metavar="OUTDIR")
    parser.add_argument("--hours", type=float, default=8.0, help="to be done in; default 8")
    parser.add_argument("--price", type=float, default=0.04, help="of a worker for an hour")
    parser.add_argument("--start", type=float, default=0.5, help="seconds a worker needs to start")
    parser.add_argument("--slow", type=float, default=0.01, help="share of clips that are slowed")
    parser.add_argument("--clips", type=int, nargs="+", default=CLIPS)
    arguments = parser.parse_args()
    known, size, peak = measured(arguments.folders)
    middle, most, nearly, largest = np.percentile(known, (50, 90, 99, 100))
    print(
        f"{len(known)} clips measured: {known.mean():.3f} s each; half below {middle:.3f}, 90 % "
        f"below {most:.3f}, 99 % below {nearly:.3f}, all below {largest:.3f}; "
        f"{size.mean() / 1e6:.2f} MB each, {size.sum() / known.sum() / 1e6:.1f} MB/s; "
        f"memory up to {peak.max() / 2**20:.0f} MiB a worker"
    )
    rng = np.random.default_rng(1)
    for count in arguments.clips:
        drawn = rng.integers(len(known), size=count)
        slowed = rng.random(count) < arguments.slow
        seconds = np.where(slowed, SLOWER * known[drawn], known[drawn])
        largest_first = seconds[np.argsort(-size[drawn], kind="stable")]
        work = float(seconds.sum())
        print(
            f"\n{count:,} clips, {count * size.mean() / 1e9:,.0f} GB, {work / 3600:,.1f} h of work"
        )
        print("  workers     hours    busy  any order  worker-hours      cost")
        for workers in WORKERS:
            end = until_done(largest_first, workers, arguments.start)
            other = until_done(seconds, workers, arguments.start)
            hours = workers * end / 3600.0
            print(
                f"{workers:>9}{end / 3600:>10.3f}{work / (workers * end):>8.1%}"
                f"{other / 3600:>11.3f}{hours:>14,.1f}{hours * arguments.price:>10,.2f}"
            )
        need = workers_for(largest_first, arguments.hours, arguments.start)
        print(f"done in {arguments.hours:g} h by {need} workers")


if __name__ == "__main__":
    main()
