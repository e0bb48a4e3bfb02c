"""Compare tracking in both directions with the causal tracker.

    python -m benchmarks.quamo_both_ways FOLDER

The clips are those of held-out CMU subjects at 25 Hz, with the noise of `quamo evaluate` and with
seeds that were used neither for the tables in the docs nor for choosing gains. The table shows
ratios output / input against the truth, and the lag without noise in ms. --native N also measures
every N-th clip at its own rate, with noise drawn at that rate. Jitter is the third difference in mm
per frame³, followed by the clean clip's jitter. --by-clip prints one row per clip instead, for the
tracker in both directions and for the spline.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.quamo_rates import motions
from twistcore.analysis.quality.figure import quality_of_positions
from twistcore.formats.smpl.skeleton import smpl_joint_positions
from twistcore.quamo import HandGains, track, track_both_ways
from twistcore.quamo.network import Network, read_network
from twistcore.quamo.resample import interpolate_poses_at_times, network_sample_times
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.quamo.tracker import Controller
from twistcore.quamo.weights import WEIGHTS, gain_network_file_name
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.methods import SPLINE, baseline_methods
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.study.quamo.pose_errors import METRICS, pose_metrics
from twistcore.study.quamo.sequences import HELD_OUT, Sequence24, read_cmu_bvh_sequence_folder
from twistcore.study.quamo.tables import CONDITIONS, Method, score_methods
from twistcore.synthesis import clip_random_generator

SEEDS = (11, 12, 13)
OF_FILES = ("MPJPE", "Accel", "G-Accel", "FS")  # the metrics with targets for whole files
SHOWN = ("MPJPE", "Accel", "G-MPJPE", "GRE", "G-Accel", "FS")
APART = tuple(c for c in CONDITIONS if not c.systematic)
WAYS = {"causal": track, "both ways": track_both_ways}
Started = Callable[[Sequence24, Array, Array], tuple[Controller, str]]


def by_hand(_: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Controller, str]:
    """Return a controller with the default hand-tuned gains, and its integration scheme.

    The parameters are those of `Started`, and are not used.
    """
    del q_hat, r_hat
    return HandGains(), "exact"


def learned(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Controller, str]:
    """Return the network trained without the clip's subject, and its integration scheme.

    `q_hat` and `r_hat` are the noisy rotations and root positions.
    """
    network = _network(clip.subject)
    return network.started(q_hat, r_hat), network.integration


@cache
def _network(subject: str) -> Network:
    return read_network(WEIGHTS / gain_network_file_name("full", subject))


def method(way: str, started: Started) -> Method:
    """Return a tracker as a method that processes noisy versions of a clip.

    `way` is a key of WAYS, and `started` returns the controller for a clip.
    """

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        controller, integration = started(clip, q_hat, r_hat)
        found = WAYS[way](q_hat, r_hat, NETWORK_DT, controller, integration=integration)
        return found.q, found.r

    return run


def lag_ms(clips: Sequence[Sequence24], run: Method) -> float:
    """Return the lag of positions in clean clips in ms, fitted by least squares to their speeds."""
    behind = speed = 0.0
    for clip in clips:
        truth = clip.places_mm(clip.q, clip.r)
        found = clip.places_mm(*(x[:, 0] for x in run(clip, clip.q[:, None], clip.r[:, None])))
        moving = np.gradient(truth, NETWORK_DT, axis=0)
        behind += float(((truth - found) * moving).sum())
        speed += float((moving * moving).sum())
    return 1000.0 * behind / speed


def at_25_hz(clips: Sequence[Sequence24], rows: Mapping[str, Method]) -> list[str]:
    """Return a line for each noise level and method, with the ratios of SHOWN and the lag."""
    scores = score_methods(clips, rows, SEEDS, APART)
    late = {name: lag_ms(clips, run) for name, run in rows.items()}
    lines = []
    for condition in APART:
        for name in rows:
            ratio = scores.ratio(name, condition)
            cells = " | ".join(f"{ratio[METRICS.index(m)]:.3f}" for m in SHOWN)
            lines.append(f"| {condition} | {name} | {cells} | {late[name]:+.1f} |")
    return lines


def by_clip(clips: Sequence[Sequence24], run: Method) -> list[str]:
    """Return a line for each clip, with the ratios of OF_FILES at each noise level."""
    lines = []
    for clip in clips:
        scores = score_methods([clip], {"": run}, SEEDS, APART)
        ratios = [scores.ratio("", c)[METRICS.index(m)] for c in APART for m in OF_FILES]
        lines.append(f"| {clip.name} | " + " | ".join(f"{r:.2f}" for r in ratios) + " |")
    return lines


def at_own_rate(folder: Path, every: int) -> list[str]:
    """Return a line of ratios and jitter for each clip, noise level and direction.

    Every `every`-th clip is tracked at its own rate with hand-tuned gains.
    """
    lines = []
    for name, q, r, offsets, dt in list(motions(folder, every)):
        times = network_sample_times(len(q), dt)
        truth = 1000.0 * smpl_joint_positions(offsets, *interpolate_poses_at_times(q, r, times))
        clean = quality_of_positions(1000.0 * smpl_joint_positions(offsets, q, r)).jitter
        for level in LEVELS:
            given = add_pose_noise(
                q, r, Noise(LEVELS[level]), clip_random_generator(SEEDS[0], name), dt=dt
            )
            before = pose_metrics(
                1000.0 * smpl_joint_positions(offsets, *interpolate_poses_at_times(*given, times)),
                truth,
            )
            for way, run in WAYS.items():
                found = run(*given, dt, HandGains())
                at_25 = 1000.0 * smpl_joint_positions(
                    offsets, *interpolate_poses_at_times(found.q, found.r, times)
                )
                after = np.array(pose_metrics(at_25, truth).values())
                ratio = after / np.maximum(before.values(), 1e-9)
                cells = " | ".join(f"{ratio[METRICS.index(m)]:.3f}" for m in SHOWN)
                jitter = quality_of_positions(
                    1000.0 * smpl_joint_positions(offsets, found.q, found.r)
                ).jitter
                lines.append(
                    f"| {name}, {1.0 / dt:.0f} Hz | {level} | {way} | {cells} | {jitter:.2f} "
                    f"({clean:.2f}) |"
                )
    return lines


def main() -> None:
    """Measure the clips and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--by-clip", action="store_true")
    parser.add_argument("--native", type=int, metavar="N")
    arguments = parser.parse_args()
    clips = [c for c in read_cmu_bvh_sequence_folder(arguments.folder)[0] if c.subject in HELD_OUT]
    if not clips:
        parser.error(f"no clip of CMU's subjects {', '.join(HELD_OUT)} in {arguments.folder}")
    if arguments.by_clip:
        rivals = baseline_methods(clips)
        files = {"hand, both ways": method("both ways", by_hand), SPLINE: rivals[SPLINE]}
        heads = " | ".join(f"{c}: {m}" for c in APART for m in OF_FILES)
        for name, run in files.items():
            print(f"\n{name}\n\n| clip | {heads} |\n|" + "---|" * (1 + 2 * len(OF_FILES)))
            print("\n".join(by_clip(clips, run)))
        return
    rows = {f"hand, {way}": method(way, by_hand) for way in WAYS}
    if all((WEIGHTS / gain_network_file_name("full", c.subject)).exists() for c in clips):
        rows |= {f"learned, {way}": method(way, learned) for way in WAYS}
    heads = " | ".join(SHOWN)
    print(f"{len(clips)} clips, {sum(len(c.q) for c in clips)} frames at 25 Hz\n")
    print(f"| noise | gains, way | {heads} | lag, ms |\n|---|---|" + "---|" * (len(SHOWN) + 1))
    print("\n".join(at_25_hz(clips, rows)))
    if arguments.native:
        print(f"\n| clip | noise | way | {heads} | jitter (clean) |")
        print("|---|---|---|" + "---|" * (len(SHOWN) + 1))
        print("\n".join(at_own_rate(arguments.folder, arguments.native)))


if __name__ == "__main__":
    main()
