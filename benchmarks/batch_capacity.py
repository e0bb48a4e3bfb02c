"""Estimate the workers, hours and cost that a large number of clips requires.

    python -m benchmarks.batch_capacity OUTDIR… [--hours H]

Clips and their processing times are drawn at random from manifests, and assigned to workers in two
orders: the largest file first, like `batch`, and at random. Some clips are made ten times slower,
as if the disk or another program were busy. For several numbers of clips and workers, the table
shows the hours until the last clip is finished, the utilisation of the workers, the worker-hours
and the cost. Idle workers are starting or waiting for the last clips. The last line is the number
of workers that finish in H hours.
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
SLOWER = 10.0  # factor by which some clips are slowed down

Array = NDArray[np.float64]


def measured(folders: Sequence[Path]) -> tuple[Array, Array, Array]:
    """Return the seconds, the file size and the memory (bytes) of every finished clip."""
    rows = []
    for folder in folders:
        with Manifest.open(folder) as manifest:
            done = [row for row in manifest.rows().values() if row.state == "done" and row.seconds]
            rows += [(row.seconds, row.bytes, row.peak_bytes) for row in done]
    seconds, size, peak = np.array(rows, dtype=np.float64).T
    return seconds, size, peak


def until_done(seconds: Array, workers: int, start: float) -> float:
    """Return the time until the last clip is finished, if clips are assigned in the given order.

    `seconds` are the processing times of the clips. `start` is the number of seconds that a worker
    needs to start.
    """
    free = [start] * workers
    for each in seconds.tolist():
        heapq.heapreplace(free, free[0] + each)
    return max(free)


def workers_for(seconds: Array, hours: float, start: float) -> int | None:
    """Return approximately the smallest number of workers that finish within `hours`.

    The result is None if a single clip takes longer. `start` is as in :func:`until_done`.
    """
    if seconds.max() + start > 3600.0 * hours:
        return None
    workers = max(1, int(seconds.sum() / (3600.0 * hours)))
    while until_done(seconds, workers, start) > 3600.0 * hours:
        workers = max(workers + 1, int(1.01 * workers))
    return workers


def main() -> None:
    """Simulate the batches and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path, metavar="OUTDIR")
    parser.add_argument("--hours", type=float, default=8.0, help="the time limit; default 8")
    parser.add_argument("--price", type=float, default=0.04, help="price of a worker per hour")
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
        print(f"{need} workers finish in {arguments.hours:g} h")


if __name__ == "__main__":
    main()
