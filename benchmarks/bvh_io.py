"""Reading, posing and writing BVH beside other readers: python -m benchmarks.bvh_io [--runs N].

One run, a process for each tool in every round, medians. The clip is a sample tiled to 20,000
frames of 96 channels, once with 6 decimals throughout and once as the sample is written. Peers that
are not installed (pip install 'twist-inspector[peers]') are skipped with a line.

The first row is twistcore with its compiled loops, as in a process that has read much or called
warm(); the second before that, or without numba.

parse: file → skeleton and numbers. fk: numbers → positions of every joint in every frame,
for us with the quaternions. write: 2 joints (6 of 96 columns) changed in every frame, to a file;
the peers write all columns, as they can do no other. memory: peak of parsing, imports left out.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

FRAMES = 20_000
SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "dance.bvh"
TOOLS = (
    "twistcore",
    "  before warm()",
    "pybvh",
    "pymotion",
    "bvhio",
    "bvhsdk",
    "numpy.loadtxt",
    "numpy.fromstring",
)
SLOW = ("bvhio", "bvhsdk")  # take minutes for FK of the whole; measured over fewer frames
ROUNDS = 3
Steps = tuple[Callable[[], Any], Callable[[Any], Any] | None, Callable[[Any], Any] | None]


def tiled(frames: int, uniform: bool) -> bytes:
    """The sample's rows over and over; with `uniform` every number has 6 decimals."""
    data = SAMPLE.read_bytes().replace(b"\r\n", b"\n")
    head, _, motion = data.partition(b"MOTION\n")
    rows = [row.strip() for row in motion.split(b"\n")[2:] if row.strip()]
    if uniform:
        rows = [b" ".join(b"%.6f" % float(t) for t in row.split()) for row in rows]
    body = b"\n".join(rows[k % len(rows)] for k in range(frames))
    return head + b"MOTION\nFrames: %d\nFrame Time: .0083333\n" % frames + body + b"\n"


def steps(tool: str, path: str, out: str) -> Steps:
    """(parse, forward kinematics or None, write or None) of one tool."""
    return _STEPS[tool](path, out)


def _ours(path: str, out: str) -> Steps:
    from twistcore.compiled import warm

    warm()
    return _by_numpy(path, out)


def _by_numpy(path: str, out: str) -> Steps:
    from dataclasses import replace

    from twistcore.bvh import read_bvh, write_bvh
    from twistcore.motion import forward_kinematics
    from twistcore.rotation import multiply, quaternion_from_axis_angle

    def write(clip: Any) -> None:
        clip.__dict__.pop("token_spans", None)  # found again each time, as in a program run
        write_bvh(clip, clip.__dict__["_corrected"], out)

    def fk(clip: Any) -> Any:
        if "_corrected" not in clip.__dict__:
            at = clip.skeleton.index("LeftArm")
            turn = quaternion_from_axis_angle([1.0, 0.0, 0.0], np.full(len(clip.values), 0.3))
            rotations = clip.motion.rotations.copy()
            for joint in (at, at + 1):
                rotations[:, joint] = multiply(rotations[:, joint], turn)
            clip.__dict__["_corrected"] = clip.motion.with_rotations(rotations)
        return forward_kinematics(replace(clip).motion)

    return lambda: read_bvh(path), fk, write


def _pybvh(path: str, out: str) -> Steps:
    import pybvh
    from pybvh.spatial_coord import frames_to_node_positions

    return (
        lambda: pybvh.read_bvh_file(path),
        frames_to_node_positions,
        lambda clip: pybvh.write_bvh_file(clip, out, verbose=False),
    )


def _pymotion(path: str, out: str) -> Steps:
    from pymotion.io.bvh import BVH
    from pymotion.ops.skeleton import fk

    def parse() -> Any:
        bvh = BVH()
        bvh.load(path)
        return bvh

    def pose(bvh: Any) -> Any:
        rotations, positions, parents, offsets, *_ = bvh.get_data()
        return fk(rotations, positions[:, 0], offsets, parents)

    return parse, pose, lambda bvh: bvh.save(out)


def _bvhio(path: str, out: str) -> Steps:
    import bvhio

    return lambda: bvhio.readAsBvh(path), None, lambda clip: bvhio.writeBvh(out, clip)


def _bvhsdk(path: str, out: str) -> Steps:
    import bvhsdk

    def write(clip: Any) -> None:
        bvhsdk.WriteBVH(clip, str(Path(out).parent), Path(out).stem)

    return lambda: bvhsdk.ReadFile(path), None, write


def _numpy(read: Callable[[Any], Any]) -> Callable[[str, str], Steps]:
    def of(path: str, _out: str) -> Steps:
        def parse() -> Any:
            text = Path(path).read_text("ascii")
            return read(text[text.index("\n", text.index("Frame Time")) :])

        return parse, None, None

    return of


_STEPS: dict[str, Callable[[str, str], Steps]] = {
    "twistcore": _ours,
    "  before warm()": _by_numpy,
    "pybvh": _pybvh,
    "pymotion": _pymotion,
    "bvhio": _bvhio,
    "bvhsdk": _bvhsdk,
    "numpy.loadtxt": _numpy(lambda text: np.loadtxt(io.StringIO(text))),
    "numpy.fromstring": _numpy(lambda text: np.fromstring(text, sep=" ")),
}


def measure(tool: str, path: str, runs: int, clock: Callable[[], float]) -> dict[str, float]:
    """Medians in seconds, and the peak of memory in MB, of one tool in this process."""
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        parse, fk, write = steps(tool, path, str(Path(folder) / "out.bvh"))
        before = _memory()
        times: dict[str, list[float]] = {"parse": [], "fk": [], "write": []}
        peak = 0.0
        for _ in range(runs):
            begun = clock()
            clip = parse()
            times["parse"].append(clock() - begun)
            peak = peak or _memory() - before
        for name, step in (("fk", fk), ("write", write)):
            if step is None:
                continue
            if tool == "twistcore" and name == "fk":
                step(clip)
            for _ in range(runs):
                begun = clock()
                step(clip)
                times[name].append(clock() - begun)
    found = {name: statistics.median(t) for name, t in times.items() if t}
    return {**found, "memory": peak}


def _memory() -> float:
    """Peak of this process in MB; ru_maxrss would begin with the parent's."""
    status = Path("/proc/self/status")
    if status.exists():
        return int(status.read_text().partition("VmHWM:")[2].split()[0]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _in_process(tool: str, path: Path, runs: int, cpu: bool) -> dict[str, float] | str:
    command = [sys.executable, "-m", "benchmarks.bvh_io", "--one", tool, str(path)]
    command += ["--runs", str(runs), *(["--cpu"] if cpu else [])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        return "not installed" if "ModuleNotFound" in done.stderr else lines[-1][:80]
    result: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return result


def _table(title: str, data: bytes, arguments: argparse.Namespace) -> None:
    size, slow_frames = len(data) / 1e6, arguments.slow_frames
    print(f"\n{title}: {FRAMES} frames × 96 channels, {size:.1f} MB")
    head = f"{'':<18} {'parse MB/s':>11} {'×':>6} {'fk s':>7} {'×':>6} {'write MB/s':>11} {'×':>6}"
    print(f"{head} {'memory MB':>10} {'× file':>7}")
    rounds: dict[str, list[dict[str, float] | str]] = {tool: [] for tool in TOOLS}
    with tempfile.TemporaryDirectory() as folder:
        full, short = Path(folder) / "big.bvh", Path(folder) / "short.bvh"
        full.write_bytes(data)
        short.write_bytes(tiled(slow_frames, "uniform" in title))
        # In turn, again and again: what else the machine does then meets all of them alike.
        for k in range(ROUNDS):
            for tool in TOOLS:
                if tool not in SLOW:
                    rounds[tool].append(_in_process(tool, full, arguments.runs, arguments.cpu))
                elif k == 0:
                    rounds[tool].append(_in_process(tool, short, 1, arguments.cpu))
    ours: dict[str, float] = {}
    for tool, results in rounds.items():
        failed = next((r for r in results if isinstance(r, str)), None)
        if failed is not None:
            print(f"{tool:<18} {failed}")
            continue
        measured = [r for r in results if isinstance(r, dict)]
        found = {key: statistics.median(r[key] for r in measured) for key in measured[0]}
        share = slow_frames / FRAMES if tool in SLOW else 1.0
        ours = ours or found
        cells = [f"{tool:<18}"]
        for name, width in (("parse", 11), ("fk", 7), ("write", 11)):
            took = found[name] / share if name in found else None
            text = "–" if took is None else f"{took if name == 'fk' else size / took:.2f}"
            ratio = "–" if took is None else f"{took / ours[name]:.1f}"
            cells += [f"{text:>{width}}", f"{ratio:>6}"]
        memory = found["memory"] / share
        print(*cells, f"{memory:>10.0f}", f"{memory / size:>7.1f}", flush=True)


def _start() -> float:
    """Seconds that warm() takes in a process of its own, the cache being there."""
    code = (
        "import time, twistcore.bvh; from twistcore.compiled import warm\n"
        "begun = time.perf_counter(); warm(); print(time.perf_counter() - begun)"
    )
    runs = [subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)]
    runs += [subprocess.run(runs[0].args, stdout=subprocess.PIPE, check=True) for _ in range(3)]
    return statistics.median(float(run.stdout) for run in runs[1:])


def main() -> int:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--slow-frames", type=int, default=1000)
    parser.add_argument("--cpu", action="store_true", help="processor time, for a busy machine")
    parser.add_argument("--one", nargs=2, metavar=("TOOL", "FILE"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        with contextlib.redirect_stdout(sys.stderr):
            clock = time.process_time if arguments.cpu else time.perf_counter
            found = measure(*arguments.one, arguments.runs, clock)
        print(json.dumps(found))
        return 0
    print(
        f"{'processor time, ' if arguments.cpu else ''}medians of {ROUNDS} rounds of "
        f"{arguments.runs} runs, {os.cpu_count()} cores, numpy {np.__version__}; "
        "× is how many times longer than twistcore"
    )
    print(f"warm() takes {_start():.2f} s once a process")
    _table("uniform decimals", tiled(FRAMES, uniform=True), arguments)
    _table("mixed decimals", tiled(FRAMES, uniform=False), arguments)
    return 0


if __name__ == "__main__":
    sys.exit(main())
