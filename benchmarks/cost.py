"""Measure the cost of detection.

    python -m benchmarks.cost FOLDER... [--profile N] [--made FRAMES ERRORS]

Errors are detected in every BVH clip in or below the folders, as by `twistcore detect --json`. The
output shows the processor time per megabyte of file (median, worst and their ratio), and the ten
most expensive clips. The options are:

- --profile N: show the functions that take the most time, for the N worst clips
- --made FRAMES ERRORS: measure the sample, repeated up to FRAMES frames and with ERRORS injected
  twist errors, in a separate process, and show its detections, processor time and peak memory
- --clip: measure one file in the same way
- --cold: show the processor time of a whole `twistcore detect` in a new process, compared with
  reading the same file and computing all angular speeds with plain numpy, or with pybvh (--pybvh is
  an interpreter that has it)

Seconds are processor time, on which other programs have little effect. Set OPENBLAS_NUM_THREADS=1,
because threads of a linear algebra library also count. Compiled modules are kept, as in an
installation. A clip of less than 0.1 MB counts as 0.1 MB, because every clip has a minimum cost.
"""

from __future__ import annotations

import argparse
import cProfile
import json
import os
import pstats
import re
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import Detection, analyse
from twistcore.errors import TwistError
from twistcore.export.detection_json import intervals_to_json
from twistcore.formats.bvh import write_motion
from twistcore.formats.reading import read_clip
from twistcore.skeleton.chain import find_chains
from twistcore.synthesis import InjectedError, inject

SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "walk.bvh"
LEAST_MB = 0.1
SHORT, ROUNDS = 0.5, 3  # a clip that takes less than SHORT seconds is measured ROUNDS times
COLD_RUNS = 7


@dataclass(frozen=True)
class Cost:
    """The cost of detection in one clip.

    Attributes
    ----------
    path
        The clip.
    seconds
        Processor time.
    mb
        Size of the file in MB.
    frames, finds
        Numbers of frames and of detections.
    """

    path: Path
    seconds: float
    mb: float
    frames: int
    finds: int

    @property
    def per_mb(self) -> float:
        """Return the processor time per megabyte."""
        return self.seconds / max(self.mb, LEAST_MB)


def detected(path: Path) -> Detection:
    """Detect errors in a clip with all steps of `twistcore detect --json`."""
    found = analyse(read_clip(path)).detect()
    json.dumps([intervals_to_json(found), [note.to_json() for note in found.notes]])
    return found


def cost_of(path: Path) -> Cost:
    """Measure the cost of detection in a clip, for a short clip as the best of several rounds."""
    best, found = np.inf, None
    for _ in range(ROUNDS):
        begin = time.process_time()
        found = detected(path)
        best = min(best, time.process_time() - begin)
        if best > SHORT:
            break
    assert found is not None
    size = path.stat().st_size / 1e6
    return Cost(path, best, size, found.analysis.motion.frames, len(found))


def clips_below(folders: Sequence[Path]) -> list[Path]:
    """Return all BVH files in and below the folders, but files of equal name and size only once."""
    found: dict[tuple[str, int], Path] = {}
    for folder in folders:
        for path in sorted(folder.rglob("*.bvh")) if folder.is_dir() else [folder]:
            found.setdefault((path.name, path.stat().st_size), path)
    return list(found.values())


def say_profile(path: Path) -> None:
    """Print the functions of twistcore that take the most time for a clip, with their shares."""
    profile = cProfile.Profile()
    profile.runcall(detected, path)
    table = pstats.Stats(profile)
    total = table.total_tt  # type: ignore[attr-defined]
    rows = [
        (cumulative, own, calls, f"{Path(file).stem}.{name}")
        for (file, _, name), (_, calls, own, cumulative, _) in table.stats.items()  # type: ignore[attr-defined]
        if "twistcore" in file and not name.startswith("<")
    ]
    print(f"  {path.name}: {total:.1f} s under the profiler")
    for cumulative, own, calls, name in sorted(rows, reverse=True)[:25]:
        print(f"    {cumulative / total:6.1%} all, {own / total:6.1%} own, {calls:7,d} × {name}")


def make_clip(path: Path, frames: int, errors: int) -> None:
    """Write the sample, repeated up to `frames`, with injected twist errors of 20 to 60°."""
    head, _, rows = SAMPLE.read_text("ascii").rstrip().partition("Frame Time:")
    step, *lines = rows.splitlines()
    lines = lines + lines[::-1]  # forward and backward, so that the motion is continuous
    head = re.sub(r"Frames:.*", f"Frames: {frames}", head)
    with path.open("w", encoding="ascii") as file:
        file.write(f"{head}Frame Time:{step}\n")
        for first in range(0, frames, len(lines)):
            file.write("\n".join(lines[: frames - first]) + "\n")
    motion = read_clip(path).motion
    chains, rng = find_chains(motion), np.random.default_rng(1)
    each = -(-errors // len(chains))
    made = []
    for chain in chains:
        for place in np.linspace(30, frames - 60, each).astype(int).tolist():
            length = int(rng.integers(6, max(8, min(30, frames // each - 10))))
            size = np.radians(rng.uniform(20.0, 60.0) * rng.choice([-1.0, 1.0]))
            made.append(InjectedError(chain.name, place, place + length, np.full(length, size)))
    write_motion(inject(motion, chains, made[:errors]), path)


_CHILD = """
import sys, time
from pathlib import Path
from benchmarks.cost import detected
from twistcore.work.memory import peak_memory
found = detected(Path(sys.argv[1]))
finds, frames = len(found), found.analysis.motion.frames
print(f"{frames:,d} frames, {finds:,d} finds: {time.process_time():.1f} s, "
      f"peak {peak_memory() / 1024**3:.2f} GiB")
"""


def say_alone(path: Path) -> None:
    """Print the time and memory that detection in a clip takes in a separate process."""
    subprocess.run([sys.executable, "-c", _CHILD, str(path)], check=True)


_PLAIN = """
import sys
import numpy as np
text = open(sys.argv[1]).read()
head, _, rows = text.partition("Frame Time:")
orders = [line.split()[2:] for line in head.splitlines() if line.split()[:1] == ["CHANNELS"]]
step, _, rows = rows.partition("\\n")
values = np.fromstring(rows, sep=" ").reshape(-1, sum(map(len, orders)))
column, speeds = 0, []
for order in orders:
    turn = None
    for k, name in enumerate(order):
        if name.endswith("rotation"):
            angle = np.radians(values[:, column + k])
            c, s, z, o = np.cos(angle), np.sin(angle), np.zeros(len(angle)), np.ones(len(angle))
            one = {"X": [[o, z, z], [z, c, -s], [z, s, c]], "Y": [[c, z, s], [z, o, z], [-s, z, c]],
                   "Z": [[c, -s, z], [s, c, z], [z, z, o]]}[name[0]]
            one = np.moveaxis(np.array(one), -1, 0)
            turn = one if turn is None else turn @ one
    column += len(order)
    if turn is not None:
        change = np.swapaxes(turn[:-1], 1, 2) @ turn[1:]
        cosine = 0.5 * (np.trace(change, axis1=1, axis2=2) - 1.0)
        speeds.append(np.arccos(np.clip(cosine, -1.0, 1.0)) / float(step))
print(len(speeds), np.max(speeds))
"""


_PYBVH = """
import sys
import pybvh
print(pybvh.read_bvh_file(sys.argv[1]).angular_velocities().shape)
"""


def cold_seconds(command: Sequence[str]) -> float:
    """Return the smallest processor time of a command in a new process, including its children."""
    best, quiet = np.inf, subprocess.DEVNULL
    kept = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    kept |= {"PYTHONPYCACHEPREFIX": str(Path(tempfile.gettempdir(), "twistcore-cost"))}
    for _ in range(COLD_RUNS):
        before = os.times()
        subprocess.run(command, check=True, stdout=quiet, stderr=quiet, env=kept)
        after = os.times()
        used = after.children_user + after.children_system
        best = min(best, used - before.children_user - before.children_system)
    return float(best)


def say_cold(path: Path, with_pybvh: str) -> None:
    """Print the cost of a whole command as a ratio to the cost of reading the same clip.

    `with_pybvh` is an interpreter that has pybvh, or '' to use numpy.
    """
    nothing = cold_seconds([sys.executable, "-c", "import numpy"])
    plain = cold_seconds(
        [with_pybvh or sys.executable, "-c", _PYBVH if with_pybvh else _PLAIN, str(path)]
    )
    ours = cold_seconds([sys.executable, "-m", "twistcore", "detect", str(path), "--json"])
    print(f"interpreter and numpy {nothing:.3f} s, reading and speeds {plain:.3f} s")
    print(f"twistcore detect {ours:.3f} s: {ours / plain:.2f} × that")


def say_costs(costs: Sequence[Cost], profiled: int) -> None:
    """Print the table of costs and the ten most expensive clips."""
    slowest = sorted(costs, key=lambda c: -c.per_mb)
    median = statistics.median(c.per_mb for c in costs)
    worst = slowest[0].per_mb
    above = sum(c.per_mb > 5.0 * median for c in costs)
    print(
        f"{len(costs)} clips: median {median:.3f} s/MB, worst {worst:.3f}, ratio "
        f"{worst / median:.1f}; {above} above five times the median; "
        f"{sum(c.seconds for c in costs):.1f} s in all"
    )
    for c in slowest[:10]:
        print(
            f"  {c.per_mb:8.3f} s/MB {c.per_mb / median:6.1f} × {c.seconds:7.2f} s {c.frames:6,d} "
            f"frames {c.finds:4d} finds  {c.path.parent.name}/{c.path.name}"
        )
    for c in slowest[:profiled]:
        say_profile(c.path)


def main() -> None:
    """Run the chosen measurements."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--profile", type=int, default=0, metavar="N")
    parser.add_argument("--made", nargs=2, type=int, metavar=("FRAMES", "ERRORS"))
    parser.add_argument("--clip", type=Path, help="time and memory of one file only")
    parser.add_argument("--cold", type=Path, help="start-up with one file")
    parser.add_argument("--pybvh", default="", help="an interpreter that has pybvh, for --cold")
    parser.add_argument("--table", type=Path, help="append a line of JSON per clip")
    chosen = parser.parse_args()
    if chosen.made:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "made.bvh")
            make_clip(path, *chosen.made)
            say_alone(path)
    if chosen.clip:
        say_alone(chosen.clip)
    if chosen.cold:
        say_cold(chosen.cold, chosen.pybvh)
    costs: list[Cost] = []
    for path in clips_below(chosen.folders):
        try:
            cost = cost_of(path)
        except TwistError as error:
            print(f"left out: {error}")
            continue
        costs.append(cost)
        if chosen.table:
            line = [str(path), cost.seconds, cost.mb, cost.frames, cost.finds]
            with chosen.table.open("a") as table:
                table.write(json.dumps(line) + "\n")
    if costs:
        say_costs(costs, chosen.profile)


if __name__ == "__main__":
    main()
