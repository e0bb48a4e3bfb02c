"""Measure the speed of `twistcore batch`.

    python -m benchmarks.batch_speed FOLDER [--made N] [--ways WAY…] [--rounds N] [--json]

The whole command is run in a new process on the folder's clips in several ways: with one worker,
with two workers, on a local Dask cluster of two workers, and as two shards, which run one after the
other with two workers each and are then joined by `twistcore merge`. Finally, the command is run
again when all clips are already finished. For each way, the table shows the seconds of the fastest
round, the processor time of all processes per clip, and the memory of the main process. The output
also shows the speed-up by the second worker, the slowest clips, a worker's memory for its largest
clip, and whether all results are equal. `--made` first fills the empty or missing folder with N
different clips of 60 to 120 frames, cut from the samples. Targets: 12 clips per second with two
workers, 1.7 times as fast as with one, and 0.5 s + 2 ms per clip if nothing is new.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from twistcore.batch import Manifest
from twistcore.formats.bvh import read_bvh, write_motion
from twistcore.skeleton.motion import Motion, Skeleton

SAMPLES = Path(__file__).resolve().parent.parent / "assets"
WAYS = {
    "1": ("--workers", "1"),
    "2": ("--workers", "2"),
    "dask": ("--local-cluster", "2"),
    "shards": ("--workers", "2"),
}
_LIMBS = ("LeftUpLeg", "LeftLeg", "LeftFoot"), ("RightArm", "RightForeArm", "RightHand")
_FRAMES = 60, 120  # smallest and largest number of frames of a generated clip
_SHARDS = 2


@dataclass
class Cost:
    """The cost of a command: its duration, processor time, and the memory of its main process."""

    seconds: float = 0.0
    processor_seconds: float = 0.0
    own_bytes: int = 0

    def __add__(self, other: Cost) -> Cost:
        """Return the cost of running two commands one after the other."""
        return Cost(
            self.seconds + other.seconds,
            self.processor_seconds + other.processor_seconds,
            max(self.own_bytes, other.own_bytes),
        )


def make_clips(folder: Path, count: int, seed: int = 1) -> None:
    """Write different clips of 60 to 120 frames, a hundred in each subfolder.

    Each clip has the hips and one limb of a sample, because a clip with all limbs costs three times
    as much.
    """
    if folder.exists() and any(folder.iterdir()):
        raise SystemExit(f"{folder} is not empty")
    rng, cuts = random.Random(seed), set[tuple[int, int, int]]()
    lines = [
        limb_of(path, limb).splitlines(keepends=True)
        for path in sorted(SAMPLES.glob("*.bvh"))
        for limb in _LIMBS
    ]
    heads = [next(k for k, x in enumerate(one) if x.startswith("Frames:")) for one in lines]
    while len(cuts) < count:
        which, frames = rng.randrange(len(lines)), rng.randint(*_FRAMES)
        cut = which, rng.randrange(heads[which] + 2, len(lines[which]) - frames), frames
        if cut in cuts:
            continue
        one, at = lines[which], heads[which]
        path = folder / f"{len(cuts) // 100:03d}" / f"clip_{len(cuts):05d}.bvh"
        cuts.add(cut)
        path.parent.mkdir(parents=True, exist_ok=True)
        rows = one[cut[1] : cut[1] + frames]
        path.write_text("".join([*one[:at], f"Frames: {frames}\n", one[at + 1], *rows]), "ascii")


def limb_of(path: Path, limb: Sequence[str]) -> str:
    """Return a clip as BVH text with only its root and a limb, given by its joints."""
    motion = read_bvh(path).motion
    names = motion.skeleton.names
    joints = [0, *(names.index(name) for name in limb)]
    skeleton = Skeleton(
        tuple(names[k] for k in joints),
        np.arange(-1, len(limb)),
        motion.skeleton.offsets[joints],
        ((len(limb), (0.0, -3.0, 0.0)),),
    )
    places = motion.positions[:, :1]
    small = Motion(skeleton, motion.rotations[:, joints], (0,), places, motion.frame_time)
    with tempfile.TemporaryDirectory() as scratch:
        write_motion(small, Path(scratch, "limb.bvh"))
        return Path(scratch, "limb.bvh").read_text("ascii")


def run(*words: str) -> Cost:
    """Run a whole command of `twistcore` and return its cost."""
    begun, own, before = time.perf_counter(), 0, os.times()
    with tempfile.TemporaryFile() as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "twistcore", *words], stdout=subprocess.DEVNULL, stderr=said
        )
        while process.poll() is None:
            own = max(own, _own_bytes(process.pid))
            time.sleep(0.02)
        if process.returncode > 1:  # 1: a clip has too few frames to be examined
            said.seek(0)
            raise SystemExit(f"{' '.join(words)}: {said.read()[-2000:].decode(errors='replace')}")
    used = sum(os.times()[2:4]) - sum(before[2:4])
    return Cost(time.perf_counter() - begun, used, own)


def _own_bytes(pid: int) -> int:
    """Return the peak memory of a process without its children, in bytes, or 0 if unknown."""
    try:
        lines = Path(f"/proc/{pid}/status").read_text("ascii").splitlines()
        return next(int(x.split()[1]) << 10 for x in lines if x.startswith("VmHWM:"))
    except (OSError, StopIteration):
        return 0


def process_clips(folder: Path, out: Path, way: str) -> Cost:
    """Process all clips in one of the WAYS, and return the cost."""
    if way != "shards":
        return run("batch", str(folder), "-o", str(out), *WAYS[way])
    cost, parts = Cost(), [f"{out}-{k + 1}" for k in range(_SHARDS)]
    for k, part in enumerate(parts):
        shard = "--shard", f"{k + 1}/{_SHARDS}"
        cost += run("batch", str(folder), "-o", part, *WAYS[way], *shard)
    return cost + run("merge", *parts, "-o", str(out))


def mark(out: Path) -> str:
    """Return a hash of all results in a folder, to compare two runs."""
    whole = hashlib.sha256()
    with Manifest.open(out) as manifest:
        for record in manifest.each_record():
            found = [record.name, record.state, record.sha256, record.result]
            whole.update(json.dumps(found, sort_keys=True).encode())
    return whole.hexdigest()


def slowest(seconds: Sequence[float]) -> dict[str, float]:
    """Return the median, the 99th percentile and the maximum of the clips' times, in seconds."""
    names = "median", "99 percent below", "slowest"
    found = np.percentile(seconds, (50.0, 99.0, 100.0)).tolist()
    return {name: round(value, 3) for name, value in zip(names, found, strict=True)}


def main() -> None:
    """Measure every variant and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--made", type=int, default=0, help="make so many small clips first")
    parser.add_argument("--ways", nargs="+", choices=WAYS, default=list(WAYS))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if arguments.made:
        make_clips(arguments.folder, arguments.made)
    costs: dict[str, list[Cost]] = {name: [] for name in (*arguments.ways, "again")}
    marks = set[str]()
    with tempfile.TemporaryDirectory() as folder:
        for k in range(arguments.rounds):
            for name in arguments.ways:  # in turn, so that other load affects all
                out = Path(folder, f"{name}-{k}")
                costs[name].append(process_clips(arguments.folder, out, name))
                marks.add(mark(out))
                print(f"{name}: {costs[name][-1]}", file=sys.stderr, flush=True)
            costs["again"].append(process_clips(arguments.folder, out, "2"))
        with Manifest.open(out) as manifest:
            rows = list(manifest.rows().values())
    best = {name: min(one.seconds for one in found) for name, found in costs.items()}
    count, size = len(rows), sum(row.bytes for row in rows)
    figures = {
        "clips": count,
        "not_done": sum(row.state != "done" for row in rows),
        "bytes": size,
        "seconds": {name: round(value, 3) for name, value in best.items()},
        "all_seconds": {name: [round(c.seconds, 3) for c in f] for name, f in costs.items()},
        "clips_a_second": {name: round(count / best[name], 2) for name in arguments.ways},
        "processor_ms_a_clip": {
            name: round(1e3 * min(c.processor_seconds for c in found) / count, 2)
            for name, found in costs.items()
        },
        "own_mib": {n: max(c.own_bytes for c in found) >> 20 for n, found in costs.items()},
        "seconds_a_clip": slowest([row.seconds for row in rows]),
        "two_are_faster_by": round(best["1"] / best["2"], 3) if {"1", "2"} <= set(best) else None,
        "again_allowed": 0.5 + 0.002 * count,
        "peak_bytes": max(row.peak_bytes for row in rows),
        "results": sorted(marks),
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
