"""Measure tracking on rigs that were not used for tuning.

    python -m benchmarks.quamo_other_rigs FOLDER

Any BVH with rotations and a position can be used. All joints get the noise of `quamo noise` at the
clip's frame rate. They are tracked causally, tracked in both directions, or smoothed by the spline,
with default settings. The table shows the ratios output / input at 25 Hz over all joints of the
rig, as means over clips and seeds, and the largest ratio of any clip. Every figure is assumed to be
1.75 m tall.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.quamo.resample import interpolate_poses_at_times, network_sample_times
from twistcore.quamo.spline import default_spline_cutoff
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.quamo.track_clip import (
    find_figure_position_joint,
    select_writable_joints,
    smooth_captures_with_spline,
    track_with_hand_gains,
)
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.synthesis import clip_random_generator

SEEDS = (41, 42)
HEIGHT_MM = 1750.0
SHORTEST, LONGEST = 60, 1500  # frames; a longer clip is cut, and a shorter one is skipped
SHOWN = ("MPJPE", "Accel", "G-MPJPE", "G-Accel")


def places_mm(motion: Motion, scale: float) -> Array:
    """Return the global positions of joints at 25 Hz in mm, shape (samples, joints, 3).

    `scale` is the length of the clip's unit in mm.
    """
    times = network_sample_times(motion.frames, motion.frame_time)
    moved = [
        interpolate_poses_at_times(motion.rotations, motion.positions[:, k], times)
        for k in range(motion.positions.shape[1])
    ]
    places = np.stack([r for _, r in moved], axis=1)
    at_25 = replace(motion, rotations=moved[0][0], positions=places, frame_time=NETWORK_DT)
    return scale * forward_kinematics(at_25)[1]


def errors(found: Array, truth: Array, placed: int) -> Array:
    """Return the errors in SHOWN, in mm and mm/frame².

    `found` and `truth` are positions, (samples, joints, 3). The first two errors are relative to
    the joint `placed`.
    """
    out = []
    for a, b in (
        (found - found[:, placed, None], truth - truth[:, placed, None]),
        (found, truth),
    ):
        bent = np.diff(a, 2, axis=0) - np.diff(b, 2, axis=0)
        out += [np.linalg.norm(x, axis=-1).mean() for x in (a - b, bent)]
    return np.array(out)


def made_noisy(motion: Motion, level: str, seed: int, name: str, scale: float) -> Motion:
    """Return the motion with noise on all joints and on the position of the root.

    `name` and `seed` seed the noise. `scale` is the length of the clip's unit in mm.
    """
    joints, placed = (
        select_writable_joints(motion.skeleton, None),
        find_figure_position_joint(motion),
    )
    assert placed is not None
    r = motion.translation(placed)
    wanted, rng = Noise(LEVELS[level]), clip_random_generator(seed, name)
    q_hat, r_hat = add_pose_noise(
        motion.rotations[:, joints], r, wanted, rng, unit=scale / 1000.0, dt=motion.frame_time
    )
    rotations, positions = motion.rotations.copy(), motion.positions.copy()
    rotations[:, joints] = q_hat
    positions[:, motion.positioned.index(placed)] += r_hat - r
    return replace(motion, rotations=rotations, positions=positions)


def ways(motion: Motion) -> dict[str, Motion]:
    """Return the motion after tracking or smoothing by each method, keyed by method name."""
    joints = select_writable_joints(motion.skeleton, None)
    spline = smooth_captures_with_spline(
        motion, joints, default_spline_cutoff(motion.frame_time), place=True
    )
    return {
        "hand, causal": track_with_hand_gains(motion, joints, causal=True, place=True).motion,
        "hand, both ways": track_with_hand_gains(motion, joints, causal=False, place=True).motion,
        "spline": spline,
    }


def main() -> None:
    """Measure all clips and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    found: dict[tuple[str, str], list[Array]] = {}
    clips = 0
    for path in clip_paths_in_folder(parser.parse_args().folder, suffixes=BVH):
        motion = read_bvh(path).motion
        motion = motion.sliced(count_leading_rest_frames(motion), motion.frames)
        placed = find_figure_position_joint(motion)
        if motion.frames < SHORTEST or placed is None:
            continue
        clips += 1
        motion = motion.sliced(0, min(motion.frames, LONGEST))
        body = forward_kinematics(motion)[1][motion.frames // 2]
        scale = HEIGHT_MM / float(np.ptp(body, axis=0).max())
        truth = places_mm(motion, scale)
        for level in LEVELS:
            for seed in SEEDS:
                given = made_noisy(motion, level, seed, path.name, scale)
                before = errors(places_mm(given, scale), truth, placed)
                for way, made in ways(given).items():
                    after = errors(places_mm(made, scale), truth, placed)
                    found.setdefault((level, way), []).append(after / before)
    print(f"{clips} clips, seeds {SEEDS[0]}-{SEEDS[-1]}\n")
    heads = " | ".join(f"{name} (largest)" for name in SHOWN)
    print(f"| noise | way | {heads} |\n|---|---|" + "---|" * len(SHOWN))
    for (level, way), rows in found.items():
        mean, most = np.mean(rows, axis=0), np.max(rows, axis=0)
        cells = " | ".join(f"{a:.3f} ({b:.2f})" for a, b in zip(mean, most, strict=True))
        print(f"| {level} | {way} | {cells} |")


if __name__ == "__main__":
    main()
