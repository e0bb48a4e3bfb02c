"""Measure hand-tuned gains and the spline at other frame rates.

    python -m benchmarks.quamo_rates FOLDER

Every fourth clip is used at its native 120 Hz and at 60 Hz. Synthetic noise drawn at this rate is
added to it. The clip is then tracked with the gains for 25 Hz, tracked with gains that depend on
the rate, or smoothed. The metrics are ratios output / input against the truth at 25 Hz. Jitter is
the mean third difference of positions at the clip's own rate.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from twistcore.analysis.quality.figure import quality_of_positions
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.formats.smpl.skeleton import CMU_UNIT, find_network_joints, smpl_joint_positions
from twistcore.quamo import Gains, HandGains, track, track_both_ways
from twistcore.quamo.resample import interpolate_poses_at_times, network_sample_times
from twistcore.quamo.spline import (
    CUTOFF,
    PLACE_SHARE,
    default_spline_cutoff,
    rotations_smoothed_by_spline,
    smoothed_by_spline,
)
from twistcore.quamo.tracker import TrackResult
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.study.quamo.pose_errors import METRICS, pose_metrics
from twistcore.synthesis import clip_random_generator

EVERY, STEPS = 4, (1, 2)  # use every fourth clip, with every frame and with every second frame
Run = Callable[[Array, Array, float], tuple[Array, Array]]
SHOWN = ("MPJPE", "Accel", "G-MPJPE", "G-Accel", "FS")


def by_hand(way: Callable[..., TrackResult], gains: Gains | None = None) -> Run:
    """Return a method that tracks with hand-tuned gains.

    By default, the gains depend on the frame rate. `way` is a function that tracks.
    """

    def run(q_hat: Array, r_hat: Array, dt: float) -> tuple[Array, Array]:
        found = way(q_hat, r_hat, dt, HandGains(gains))
        return found.q, found.r

    return run


def spline(cutoff_of: Callable[[float], float]) -> Run:
    """Return a method that applies the smoothing spline of `quamo refine`.

    `cutoff_of` is a function that returns the cut-off in Hz for a frame time.
    """
    return lambda q_hat, r_hat, dt: (
        rotations_smoothed_by_spline(q_hat, cutoff_of(dt), dt),
        smoothed_by_spline(r_hat, PLACE_SHARE * cutoff_of(dt), dt),
    )


ROWS: dict[str, Run] = {
    "for 25 Hz: κP 600, κD 15": by_hand(track, Gains()),
    "following the rate": by_hand(track),
    "following the rate, both ways": by_hand(track_both_ways),
    "spline, 4 Hz": spline(lambda _: CUTOFF),
    "spline, following the rate": spline(default_spline_cutoff),
}


def motions(folder: Path, every: int = EVERY) -> Iterator[tuple[str, Array, Array, Array, float]]:
    """Yield the name, rotations, root positions, offsets and frame time of every N-th clip.

    The clips have 24 joints. Lengths are in metres. `every` is N.
    """
    for path in clip_paths_in_folder(folder, suffixes=BVH)[::every]:
        motion = read_bvh(path).motion
        motion = motion.sliced(1, motion.frames)
        topology = find_network_joints(motion.skeleton)
        yield (
            path.stem,
            topology.reduced(motion.rotations),
            CMU_UNIT * motion.translation(0),
            CMU_UNIT * topology.offsets,
            motion.frame_time,
        )


def measured(folder: Path, level: str, step: int) -> dict[str, Array]:
    """Return the ratios of METRICS and of the jitter, keyed by method.

    Longer clips have more weight. `step` is the number of frames between used frames.
    """
    sums = {name: np.zeros(len(METRICS) + 1) for name in ("input", *ROWS)}
    for name, q_all, r_all, offsets, native in motions(folder):
        q, r, dt = q_all[::step], r_all[::step], step * native
        times = network_sample_times(len(q), dt)
        q_hat, r_hat = add_pose_noise(
            q, r, Noise(LEVELS[level]), clip_random_generator(0, name), dt=dt
        )
        truth = 1000.0 * smpl_joint_positions(offsets, *interpolate_poses_at_times(q, r, times))
        for row in sums:
            found = (q_hat, r_hat)
            if row in ROWS:
                found = ROWS[row](q_hat, r_hat, dt)
            at_25 = 1000.0 * smpl_joint_positions(
                offsets, *interpolate_poses_at_times(*found, times)
            )
            jitter = quality_of_positions(1000.0 * smpl_joint_positions(offsets, *found)).jitter
            sums[row] += len(q) * np.array([*pose_metrics(at_25, truth).values(), jitter])
    return {row: sums[row] / sums["input"] for row in ROWS}


def main() -> None:
    """Print a row for each frame rate, noise level and method."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    print("| rate, noise | gains | " + " | ".join((*SHOWN, "jitter")) + " |")
    print("|---|---|" + "---|" * (len(SHOWN) + 1))
    for step in STEPS:
        for level in LEVELS:
            for row, ratio in measured(arguments.folder, level, step).items():
                cells = [ratio[METRICS.index(m)] for m in SHOWN] + [ratio[-1]]
                told = " | ".join(f"{v:.2f}" for v in cells)
                print(f"| {120 // step} Hz, {level} | {row} | {told} |")


if __name__ == "__main__":
    main()
