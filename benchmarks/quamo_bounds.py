"""Compute bounds for the tables of QuaMo: python -m benchmarks.quamo_bounds FOLDER [--seeds N].

Every number is a ratio output / input on held-out CMU subjects at 25 Hz, with the noise of `quamo
evaluate`. Filters and regressions are optimal fits to the clips of all *other* subjects with new
noise. Rows marked 'oracle' use information that no tracker has: they show what would be needed to
reach a target. q̂ and r̂ are the noisy rotations and root positions.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.quamo_fits import (
    PathFilter,
    foot_steps,
    known_way,
    pose_regression,
    root_filter,
    shrunk,
    without_offset,
)
from twistcore.quamo.spline import PLACE_SHARE, rotations_smoothed_by_spline, smoothed_by_spline
from twistcore.quamo.state_space import NETWORK_DT, Gains
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.methods import hand_tuned_method
from twistcore.study.quamo.noise import Noise
from twistcore.study.quamo.pose_errors import METRICS, pose_metrics
from twistcore.study.quamo.sequences import HELD_OUT, Sequence24, read_cmu_bvh_sequence_folder
from twistcore.study.quamo.tables import (
    CONDITIONS,
    Method,
    NoiseCondition,
    noisy_clip,
    score_methods,
)

GAINS = ((400.0, 16.0), (550.0, 16.0), (600.0, 15.0), (900.0, 20.0), (1200.0, 24.0))
CUTOFFS = (3.0, 4.0, 5.0, 6.0)  # Hz
ROOT_GAINS = ((100.0, 8.0), (200.0, 12.0), (400.0, 20.0))
# For each delay of a filter in frames, the weights of Accel relative to the distance.
AIMS = ((0, (1.0, 3.0, 10.0, 30.0)), (1, (3.0,)), (2, (3.0,)))


def still(_: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
    """Repeat the first frame, so that there is no acceleration."""
    return np.broadcast_to(q_hat[:1], q_hat.shape), np.broadcast_to(r_hat[:1], r_hat.shape)


def then_by_hand(method: Method) -> Method:
    """Return a method that applies another method, and then tracks with hand-tuned gains."""

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        return hand_tuned_method()(clip, *method(clip, q_hat, r_hat))

    return run


def splined(cutoff: float) -> Method:
    """Return a method that smooths with the spline. `cutoff` is in Hz."""
    return lambda _, q_hat, r_hat: (
        rotations_smoothed_by_spline(q_hat, cutoff, NETWORK_DT),
        smoothed_by_spline(r_hat, PLACE_SHARE * cutoff, NETWORK_DT),
    )


def root_by_hand(kp: float, kd: float) -> Method:
    """Return a method that tracks only the root, with hand-tuned gains."""

    def run(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        return q_hat, hand_tuned_method(Gains(root_kp=kp, root_kd=kd))(clip, q_hat, r_hat)[1]

    return run


def smoothness_rows(clips: Sequence[Sequence24], noise: Noise) -> dict[str, Method]:
    """Return methods for the table of smoothness, keyed by row.

    The methods are hand-tuned gains along their trade-off, and splines over the whole file.
    """
    del clips, noise
    by_hand = {f"κP {kp:g}, κD {kd:g}": hand_tuned_method(Gains(kp=kp, kd=kd)) for kp, kd in GAINS}
    of_file = {f"spline of the file, {cutoff:g} Hz": splined(cutoff) for cutoff in CUTOFFS}
    return {"stands still: no acceleration at all": still, **by_hand, **of_file}


def root_rows(clips: Sequence[Sequence24], noise: Noise) -> dict[str, Method]:
    """Return methods for the table of the root, keyed by row.

    The methods range from gains and filters of r̂ to the exactly known path.
    """
    return {
        **{f"κP {kp:g}, κD {kd:g}": root_by_hand(kp, kd) for kp, kd in ROOT_GAINS},
        "filter of r̂": root_filter(clips, noise),
        "+ feet of q̂ on the ground": root_filter(clips, noise, foot_steps(False, False)),
        "+ feet of q̂, true contacts (oracle)": root_filter(clips, noise, foot_steps(False, True)),
        "+ true feet and contacts (oracle)": root_filter(clips, noise, foot_steps(True, True)),
        "the root's way known exactly (oracle)": known_way(noise),
    }


def pose_rows(clips: Sequence[Sequence24], noise: Noise) -> dict[str, Method]:
    """Return methods for the table of poses, keyed by row.

    The methods know poses of other subjects, of the same subject, or the true pose.
    """
    drawn = shrunk(clips, noise, 4.0)
    rows: dict[str, Method] = {
        "drawn towards the others' mean poses": drawn,
        "the same, then hand gains": then_by_hand(drawn),
    }
    for ridge in (0.01, 0.1):
        rows[f"linear in the pose, from others, ridge {ridge:g}"] = pose_regression(
            clips, noise, ridge
        )
    rows["linear in the pose, from the subject itself, ridge 0.01 (oracle)"] = pose_regression(
        clips, noise, 0.01, own=True
    )
    rows["each joint's mean error over the clip taken off (oracle)"] = without_offset
    return rows


def filter_ratios(
    clips: Sequence[Sequence24], noise: Noise, weights: Sequence[float], ahead: int, seeds: int
) -> list[Array]:
    """Return the ratios output / input of the best filter for each weight of Accel.

    `ahead` is the delay of the filter in frames. Each array is in the order of METRICS.
    """
    path = PathFilter(clips, noise, ahead)
    sums = np.zeros((len(weights) + 1, len(METRICS)))
    by_subject = {s: [path.taps(s, w) for w in weights] for s in HELD_OUT}
    for clip in (c for c in clips if c.subject in HELD_OUT):
        truth = clip.places_mm(clip.q, clip.r)
        for seed in range(seeds):
            given = clip.places_mm(*noisy_clip(clip, noise, seed))
            made = [path.filtered(given, taps) for taps in by_subject[clip.subject]]
            sums += len(truth) * np.array([pose_metrics(m, truth).values() for m in (given, *made)])
    return list(sums[1:] / sums[0])


Rows = Callable[[Sequence[Sequence24], Noise], dict[str, Method]]


def measured(
    clips: Sequence[Sequence24], make: Rows, conditions: Sequence[NoiseCondition], seeds: int
) -> dict[str, list[Array]]:
    """Return the ratios of each method for each condition, keyed by row.

    `make` is a function that returns the methods, keyed by row.
    """
    held = [c for c in clips if c.subject in HELD_OUT]
    rows: dict[str, list[Array]] = defaultdict(list)
    for condition in conditions:
        methods = make(clips, condition.noise)
        scores = score_methods(held, methods, range(seeds), [condition])
        for name in methods:
            rows[name].append(scores.ratio(name, condition))
    return rows


def table(
    title: str, rows: Mapping[str, list[Array]], conditions: Sequence[NoiseCondition], shown: str
) -> str:
    """Return a Markdown table with a row per method and the metrics `shown` of each condition."""
    metrics = shown.split()
    heads = [f"{c}: {m}" for c in conditions for m in metrics]
    lines = [f"| {title} | " + " | ".join(heads) + " |", "|---|" + "---|" * len(heads)]
    for name, values in rows.items():
        cells = [f"{v[METRICS.index(m)]:.2f}" for v in values for m in metrics]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Measure all methods and print three tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=3)
    arguments = parser.parse_args()
    clips, _ = read_cmu_bvh_sequence_folder(arguments.folder)
    apart = [c for c in CONDITIONS if not c.systematic]
    smooth = measured(clips, smoothness_rows, apart, arguments.seeds)
    for condition in apart:
        for ahead, weights in AIMS:
            ratios = filter_ratios(clips, condition.noise, weights, ahead, arguments.seeds)
            for weight, ratio in zip(weights, ratios, strict=True):
                waits = f", waits {40 * ahead} ms" if ahead else ""
                smooth[f"best filter, Accel weighs {weight:g}{waits}"].append(ratio)
    print(table("smoothness", smooth, apart, "MPJPE Accel G-MPJPE G-Accel"))
    for title, make, conditions, shown in (
        ("root", root_rows, apart, "GRE G-MPJPE G-Accel"),
        ("pose", pose_rows, CONDITIONS, "MPJPE"),
    ):
        print(table(title, measured(clips, make, conditions, arguments.seeds), conditions, shown))


if __name__ == "__main__":
    main()
