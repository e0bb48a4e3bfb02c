"""Measure QuaMo's time per frame on one core: python -m benchmarks.quamo_speed [--frames N].

The benchmark measures 24 joints: first the streaming call `tc.Tracker.step` alone, then tracking
with forward kinematics (FK), with hand-tuned gains and with the networks in numpy. If PyTorch is
installed, the networks' step in PyTorch on one thread is compared with numpy in the same run. The
times are CPU times of this process, as medians over blocks of frames. Set OMP_NUM_THREADS=1.
Target: < 2 ms. The time of ten million additions in plain Python describes the machine.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import numpy as np

from twistcore.errors import TwistError
from twistcore.formats.smpl.skeleton import make_smpl_skeleton
from twistcore.quamo import HandGains, Stepper, Tracker
from twistcore.quamo.network import Network, initial_gain_network_for_training, read_network
from twistcore.quamo.weights import FINAL, WEIGHTS, gain_network_file_name
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.study.quamo.sequences import read_cmu_bvh_sequence
from twistcore.study.quamo.torch_model import import_torch, make_torch_tracking_step, track_windows

SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "dance.bvh"
BLOCK = 50


def main() -> None:
    """Measure every method and print a line for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument(
        "--weights", type=Path, default=WEIGHTS / gain_network_file_name("full", FINAL)
    )
    arguments = parser.parse_args()
    sequence = read_cmu_bvh_sequence(SAMPLE)
    skeleton = make_smpl_skeleton(sequence.offsets)
    q, r = add_pose_noise(sequence.q, sequence.r, Noise(LEVELS["A"]), np.random.default_rng(0))
    at = np.arange(arguments.frames) % len(q)
    q, r = q[at], r[at]
    widths = {512: initial_gain_network_for_training(512, 64, np.random.default_rng(0), "full")}
    if arguments.weights.exists():
        shipped = read_network(arguments.weights)
        widths = {shipped.width: shipped} | widths

    def with_kinematics(tracker: Stepper) -> Callable[[int], None]:
        def frame(k: int) -> None:
            state = tracker.step(q[k], r[k], 0.04).state
            forward_kinematics(Motion(skeleton, state.q[None], (0,), state.r[None, None], 0.04))

        return frame

    stream = Tracker(fps=25.0)
    alone = timed(lambda k: stream.step((q[k], r[k])), len(q))
    print(f"ten million additions in plain Python: {additions():.2f} s")
    print(f"streaming call: {alone:.3f} ms")
    print(f"hand gains with FK: {timed(with_kinematics(Stepper(HandGains())), len(q)):.3f} ms")
    for width, network in widths.items():
        controller = network.started(q, r)
        full = timed(with_kinematics(Stepper(controller)), len(q))
        print(f"networks of width {width} with FK: {full:.3f} ms")
        compare_torch(network, q, r)


def additions() -> float:
    """Return the CPU time of ten million additions in plain Python, in seconds."""
    begin, total = time.process_time(), 0
    for k in range(10_000_000):
        total += k
    return time.process_time() - begin


def timed(frame: Callable[[int], None], frames: int) -> float:
    """Return the median CPU time per frame over blocks of frames, in milliseconds.

    `frame` is a function that processes the frame with an index.
    """
    blocks = []
    for start in range(0, frames - BLOCK + 1, BLOCK):
        begin = time.process_time()
        for k in range(start, start + BLOCK):
            frame(k)
        blocks.append((time.process_time() - begin) / BLOCK * 1e3)
    return median(blocks)


def compare_torch(network: Network, q: np.ndarray, r: np.ndarray) -> None:
    """Print the times of numpy and PyTorch without FK, measured in turn over blocks of frames."""
    try:
        torch = import_torch()
    except TwistError:
        print("  PyTorch is not installed: no ratio")
        return
    torch.set_num_threads(1)
    weights = {k: torch.tensor(v) for k, v in network.weights.items()}
    step = make_torch_tracking_step(torch, network.variant)
    ours, theirs = [], []
    for start in range(0, len(q) - 99, 100):
        part = slice(start, start + 100)
        begin = time.process_time()
        tracker = Stepper(network.started(q[part], r[part]))
        for k in range(start, start + 100):
            tracker.step(q[k], r[k], 0.04)
        middle = time.process_time()
        with torch.no_grad():
            track_windows(torch, weights, q[None, part], r[None, part], step)
        ours.append((middle - begin) * 10.0)
        theirs.append((time.process_time() - middle) * 10.0)
    a, b = median(ours), median(theirs)
    print(f"  without FK: numpy {a:.3f} ms, PyTorch {b:.3f} ms, ratio {a / b:.2f}")


if __name__ == "__main__":
    main()
