"""Measure the speed of the consistency detector: python -m benchmarks.detection_speed [--frames N]…

A sample is repeated up to 10,000 frames, and errors are injected into all ten chains. The output
shows the medians in ms of

- the analysis, which does not depend on τ, in total and without the tables of pairs of edges (the
  rest is signals and predictions),
- the first τ of ten chains,
- a new τ of ten chains, and
- a new τ of one chain.

An analysis caches its solutions, so every τ is used once and selects a new set of edges. Set
OMP_NUM_THREADS=1 to use one core. Targets: 100 for signals and predictions, 20, 20, 2.

Then find_chains, the analysis and the intervals at the automatic τ are measured for rigs of N
joints in one line (--line N…), with 1,000 frames and an error in each chain every 140 frames.
Target: 2,000 at 300 joints.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from twistcore.analysis.clip_analysis import detect
from twistcore.detection.consistency import detector as consistency
from twistcore.detection.consistency.chain_analysis import ChainAnalysis
from twistcore.detection.detectors.consistency import ConsistencyDetector
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import quaternion_from_euler
from twistcore.synthesis import InjectedError, inject

SAMPLE = Path(__file__).resolve().parent.parent / "assets" / "basketball.bvh"
FIRST = float(np.radians(2.0))
BELOW = (0.02, 0.05, 0.1, 0.2)  # shares of a chain's edges above `FIRST` that a new τ excludes


def laden(frames: int, seed: int = 1) -> tuple[Motion, tuple[Chain, ...]]:
    """Return the sample, played forward and backward up to `frames`, with errors, and its chains.

    Each chain has an error every 140 frames.
    """
    motion = read_bvh(SAMPLE).motion
    length = motion.frames - 1  # frame 0 is a T-pose
    at = 1 + np.abs((np.arange(frames) + length - 1) % (2 * length - 2) - (length - 1))
    motion = replace(motion, rotations=motion.rotations[at], positions=motion.positions[at])
    return with_errors(motion, np.random.default_rng(seed))


def one_line(joints: int, frames: int, seed: int = 1) -> tuple[Motion, tuple[Chain, ...]]:
    """Return a motion of joints in one line, with errors, and its chains.

    The joints sway by about 10° at 60 Hz and have 0.05° of noise.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(frames)[:, None, None] / 60.0
    angles = np.radians(0.05) * rng.standard_normal((frames, joints, 3))
    for _ in range(3):
        rate, phase = rng.uniform(1.0, 9.0, (joints, 3)), rng.uniform(0.0, 2.0 * np.pi, (joints, 3))
        angles += np.radians(rng.uniform(2.0, 12.0, (joints, 3))) * np.sin(rate * t + phase)
    offsets = rng.normal([0.0, 5.0, 0.0], 1.0, (joints, 3))
    skeleton = Skeleton(tuple(f"J{j}" for j in range(joints)), np.arange(-1, joints - 1), offsets)
    rotations = quaternion_from_euler("ZXY", angles)
    return with_errors(Motion(skeleton, rotations, (0,), np.zeros((frames, 1, 3)), 1.0 / 60.0), rng)


def with_errors(motion: Motion, rng: np.random.Generator) -> tuple[Motion, tuple[Chain, ...]]:
    """Inject an error into each chain every 140 frames, and return the motion and its chains."""
    frames, chains, errors = motion.frames, find_chains(motion), []
    for chain in chains:
        for start in range(20 + int(rng.integers(100)), frames - 160, 140):
            n, sign = int(rng.integers(1, 21)), rng.choice([-1.0, 1.0])
            delta = np.radians(rng.uniform(5.0, 180.0)) * sign
            errors.append(InjectedError(chain.name, start, start + n, np.full(n, delta)))
    return inject(motion, chains, errors), chains


def new_taus(chain: ChainAnalysis) -> list[float]:
    """Return values of τ in radians, each of which selects a different set of edges."""
    jumps = np.sort(np.abs(chain.edges.jump))
    jumps = jumps[jumps >= FIRST]
    out = sorted({int(share * len(jumps)) for share in BELOW} - {0})
    return [float(0.5 * (jumps[k - 1] + jumps[k])) for k in out]


def milliseconds(act: Callable[..., object], *arguments: object) -> float:
    """Return the duration of a call in milliseconds."""
    begin = time.perf_counter()
    act(*arguments)
    return 1e3 * (time.perf_counter() - begin)


def detected(motion: Motion) -> int:
    """Return the number of intervals of all chains, each at its automatic τ."""
    return len(detect(motion, find_chains(motion)))


def main() -> None:
    """Measure the speed and print the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, nargs="*", default=[10_000])
    parser.add_argument("--line", type=int, nargs="*", default=[300])
    parser.add_argument("--repeats", type=int, default=9)
    arguments = parser.parse_args()
    detector = ConsistencyDetector()
    in_tables: list[float] = []
    pair_table = consistency.edge_pair_table

    def timed(*given: Any) -> Any:
        begun = time.perf_counter()
        table = pair_table(*given)
        in_tables.append(1e3 * (time.perf_counter() - begun))
        return table

    consistency.edge_pair_table = timed
    for frames in arguments.frames:
        motion, chains = laden(frames)
        analyse: list[float] = []
        signals: list[float] = []
        first: list[float] = []
        ten: list[float] = []
        one: list[float] = []
        found = 0
        for _ in range(arguments.repeats):
            in_tables.clear()
            analyse.append(milliseconds(detector.analyse, motion, chains))
            signals.append(analyse[-1] - sum(in_tables))
            analysis = detector.analyse(motion, chains)
            first.append(sum(milliseconds(analysis.intervals, c.name, FIRST) for c in chains))
            each = [
                [
                    milliseconds(analysis.intervals, c.name, tau)
                    for tau in new_taus(analysis.chains[c.name])
                ]
                for c in chains
            ]
            one += [value for values in each for value in values]
            ten += [sum(values) for values in zip(*each, strict=False)]
            found = sum(len(analysis.intervals(c.name, FIRST)) for c in chains)
        print(
            f"{frames:7,} frames, {len(chains)} chains, {found} intervals: "
            f"analyse {median(analyse):6.1f} ms (signals and predictions {median(signals):.1f}), "
            f"first τ {median(first):5.1f} ms, "
            f"a new τ {median(ten):5.1f} ms for all, {median(one):.2f} ms for one"
        )
    for joints in arguments.line:
        motion, chains = one_line(joints, 1000)
        times = [milliseconds(detected, motion) for _ in range(arguments.repeats)]
        print(
            f"{joints:7,} joints in one line, {motion.frames:,} frames, {len(chains)} chains, "
            f"{detected(motion)} intervals: {median(times):.0f} ms"
        )


if __name__ == "__main__":
    main()
