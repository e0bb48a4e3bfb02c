"""Measure the speed of `twistcore batch`.

    python -m benchmarks.batch_speed FOLDER [--rounds N] [--json]

The whole command runs in a new process over the folder's clips, with one worker, with two workers,
and on a local Dask cluster of two. Then it runs again with all clips already finished. The table
shows the seconds (of the fastest round), clips and bytes per second, the speed-up by the second
worker, a worker's memory for its largest clip, and whether all results are equal. Targets: 12 clips
per second with two workers, 1.7 times as fast as with one, and 0.5 s + 2 ms per clip if nothing is
new.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from twistcore.batch import Manifest

WAYS = {"1": ("--workers", "1"), "2": ("--workers", "2"), "dask": ("--local-cluster", "2")}


def run(folder: Path, out: Path, *words: str) -> float:
    """Run the whole command and return its duration in seconds."""
    command = [sys.executable, "-m", "twistcore", "batch", str(folder), "-o", str(out), *words]
    begin = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - begin


def mark(out: Path) -> str:
    """Return a hash of all results in a folder, to compare two runs."""
    with Manifest.open(out) as manifest:
        results = {record.name: record.result for record in manifest.each_record()}
    return hashlib.sha256(json.dumps(results, sort_keys=True).encode()).hexdigest()


def main() -> None:
    """Measure every variant and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    seconds: dict[str, list[float]] = {name: [] for name in (*WAYS, "again")}
    marks, records = set(), []
    with tempfile.TemporaryDirectory() as folder:
        for k in range(arguments.rounds):
            for name, words in WAYS.items():  # in turn, so that load on the machine affects all
                out = Path(folder, f"{name}-{k}")
                seconds[name].append(run(arguments.folder, out, *words))
                marks.add(mark(out))
            seconds["again"].append(run(arguments.folder, Path(folder, f"2-{k}")))
        with Manifest.open(Path(folder, "2-0")) as manifest:
            records = manifest.records()
    best = {name: min(found) for name, found in seconds.items()}
    size = sum(record.bytes for record in records)
    figures = {
        "clips": len(records),
        "bytes": size,
        "seconds": {name: round(value, 3) for name, value in best.items()},
        "all_seconds": {name: [round(s, 3) for s in found] for name, found in seconds.items()},
        "clips_a_second": {name: round(len(records) / best[name], 2) for name in WAYS},
        "bytes_a_second": round(size / best["2"]),
        "two_are_faster_by": round(best["1"] / best["2"], 3),
        "again_allowed": 0.5 + 0.002 * len(records),
        "peak_bytes": max(record.peak_bytes for record in records),
        "equal_results": len(marks) == 1,
        "load": os.getloadavg(),
    }
    if arguments.json:
        print(json.dumps(figures, indent=1))
        return
    for name, value in figures.items():
        print(f"{name:<18} {value}")


if __name__ == "__main__":
    main()
