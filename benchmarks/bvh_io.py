"""Compare reading, posing and writing of BVH with other libraries.

    python -m benchmarks.bvh_io [--runs N]

The clip is a sample repeated up to 20,000 frames of 96 channels. It has three forms: with 6
decimals throughout; as the sample is written (4 decimals, and a row of integers in every 435); and
with 6 significant digits (%g). The times are medians over processes and exclude imports. Each
process carries out every step once, like a program that handles a single clip. The tools run in
turn. Libraries that are not installed (pip install 'twist-inspector[peers]') are skipped with a
message.

The step `parse` reads skeleton and numbers from the file. `fk` computes the positions of all joints
in all frames (ours includes quaternions). `write` writes a file in which 2 joints (6 of 96 columns)
have changed in every frame; other libraries can only write all columns. `memory` is the peak during
parsing, excluding imports.
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
    "pybvh",
    "pymotion",
    "bvhio",
    "bvhsdk",
    "numpy.loadtxt",
    "numpy.fromstring",
)
SLOW = ("bvhio", "bvhsdk")  # measured over fewer frames, because they take minutes
FORMS = {"uniform decimals": "%.6f", "as the sample is written": "", "varying decimals": "%g"}
Steps = tuple[
    Callable[[], Any], Callable[[Any], Any] | None, Callable[[Any], Callable[[], Any]] | None
]


def tiled(frames: int, form: str) -> bytes:
    """Return a BVH file with the sample's rows, repeated.

    If a format is given, all numbers are changed slightly and written in this format.
    """
    data = SAMPLE.read_bytes().replace(b"\r\n", b"\n")
    head, _, motion = data.partition(b"MOTION\n")
    rows = [row.strip() for row in motion.split(b"\n")[2:] if row.strip()]
    if form:
        rows = [" ".join(form % (1.0001 * float(t)) for t in row.split()).encode() for row in rows]
    body = b"\n".join(rows[k % len(rows)] for k in range(frames))
    return head + b"MOTION\nFrames: %d\nFrame Time: .0083333\n" % frames + body + b"\n"


def steps(tool: str, path: str, out: str) -> Steps:
    """Return functions for the steps of one tool: parse, compute positions, and prepare writing.

    A step that the tool does not support is None.
    """
    return _STEPS[tool](path, out)


def _ours(path: str, out: str) -> Steps:
    from twistcore.formats.bvh import read_bvh
    from twistcore.formats.clip import write_clip
    from twistcore.skeleton.motion import forward_kinematics
    from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle

    def write(clip: Any) -> Callable[[], Any]:
        at = clip.skeleton.index("LeftArm")
        turn = quaternion_from_axis_angle([1.0, 0.0, 0.0], np.full(len(clip.values), 0.3))
        rotations = clip.motion.rotations.copy()
        for joint in (at, at + 1):
            rotations[:, joint] = multiply(rotations[:, joint], turn)
        corrected = clip.motion.with_rotations(rotations)
        return lambda: write_clip(clip, corrected, out)

    return lambda: read_bvh(path), lambda clip: forward_kinematics(clip.motion), write


def _pybvh(path: str, out: str) -> Steps:
    import pybvh
    from pybvh.spatial_coord import frames_to_node_positions

    return (
        lambda: pybvh.read_bvh_file(path),
        frames_to_node_positions,
        lambda clip: lambda: pybvh.write_bvh_file(clip, out, verbose=False),
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

    return parse, pose, lambda bvh: lambda: bvh.save(out)


def _bvhio(path: str, out: str) -> Steps:
    import bvhio

    return lambda: bvhio.readAsBvh(path), None, lambda clip: lambda: bvhio.writeBvh(out, clip)


def _bvhsdk(path: str, out: str) -> Steps:
    import bvhsdk

    folder, stem = str(Path(out).parent), Path(out).stem
    return (
        lambda: bvhsdk.ReadFile(path),
        None,
        lambda clip: lambda: bvhsdk.WriteBVH(clip, folder, stem),
    )


def _numpy(read: Callable[[Any], Any]) -> Callable[[str, str], Steps]:
    def of(path: str, _out: str) -> Steps:
        def parse() -> Any:
            text = Path(path).read_text("ascii")
            return read(text[text.index("\n", text.index("Frame Time")) :])

        return parse, None, None

    return of


_STEPS: dict[str, Callable[[str, str], Steps]] = {
    "twistcore": _ours,
    "pybvh": _pybvh,
    "pymotion": _pymotion,
    "bvhio": _bvhio,
    "bvhsdk": _bvhsdk,
    "numpy.loadtxt": _numpy(lambda text: np.loadtxt(io.StringIO(text))),
    "numpy.fromstring": _numpy(lambda text: np.fromstring(text, sep=" ")),
}


def measure(tool: str, path: str, clock: Callable[[], float]) -> dict[str, float]:
    """Measure the steps of one tool in this process.

    Returns the seconds of each step, and the peak memory in MB while the file is parsed.
    """
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as folder:
        parse, fk, write = steps(tool, path, str(Path(folder) / "out.bvh"))
        before, begun = _memory(), clock()
        clip = parse()
        found = {"parse": clock() - begun, "memory": _memory() - before}
        if fk:
            begun = clock()
            fk(clip)
            found["fk"] = clock() - begun
        if write:
            save = write(clip)
            begun = clock()
            save()
            found["write"] = clock() - begun
    return found


def _memory() -> float:
    """Return the peak memory of this process in MB.

    On Linux, ru_maxrss is not used, because it begins at the parent's peak.
    """
    status = Path("/proc/self/status")
    if status.exists():
        return int(status.read_text().partition("VmHWM:")[2].split()[0]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _in_process(tool: str, path: Path, cpu: bool) -> dict[str, float] | str:
    command = [sys.executable, "-m", "benchmarks.bvh_io", "--one", tool, str(path)]
    command += ["--cpu"] if cpu else []
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        return "not installed" if "ModuleNotFound" in done.stderr else lines[-1][:80]
    result: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return result


def _table(title: str, arguments: argparse.Namespace) -> None:
    data, slow_frames = tiled(FRAMES, FORMS[title]), arguments.slow_frames
    size = len(data) / 1e6
    print(f"\n{title}: {FRAMES} frames × 96 channels, {size:.1f} MB")
    head = f"{'':<18} {'parse MB/s':>11} {'×':>6} {'fk s':>7} {'×':>6} {'write MB/s':>11} {'×':>6}"
    print(f"{head} {'memory MB':>10} {'× file':>7}")
    rounds: dict[str, list[dict[str, float] | str]] = {tool: [] for tool in TOOLS}
    with tempfile.TemporaryDirectory() as folder:
        full, short = Path(folder) / "big.bvh", Path(folder) / "short.bvh"
        full.write_bytes(data)
        short.write_bytes(tiled(slow_frames, FORMS[title]))
        # The tools run in turn, so that other load on the machine affects all of them equally.
        for k in range(arguments.runs):
            for tool in TOOLS:
                if tool not in SLOW:
                    rounds[tool].append(_in_process(tool, full, arguments.cpu))
                elif k == 0:
                    rounds[tool].append(_in_process(tool, short, arguments.cpu))
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


def main() -> int:
    """Measure all tools and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=9)
    parser.add_argument("--slow-frames", type=int, default=1000)
    parser.add_argument("--cpu", action="store_true", help="processor time, for a busy machine")
    parser.add_argument("--one", nargs=2, metavar=("TOOL", "FILE"), help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        with contextlib.redirect_stdout(sys.stderr):
            clock = time.process_time if arguments.cpu else time.perf_counter
            found = measure(*arguments.one, clock)
        print(json.dumps(found))
        return 0
    print(
        f"{'processor time, ' if arguments.cpu else ''}medians of {arguments.runs} "
        f"processes, {os.cpu_count()} cores, numpy {np.__version__}; "
        "× is how many times longer than twistcore"
    )
    for title in FORMS:
        _table(title, arguments)
    return 0


if __name__ == "__main__":
    sys.exit(main())
