"""Compare τ from verdicts with τ from injected errors: python -m benchmarks.learned_tau FOLDER.

The folder contains clips named SUBJECT_TRIAL.bvh. τ is learned from the clips of some subjects in
two ways: from errors injected into them, and from the verdicts of a simulated reviewer on 200
listed intervals, a tenth of which are wrong (false alarms of the detector, or decoys, which this
reviewer considers natural). Both values are tested on clips of other subjects. The test is the
study's benchmark at a given τ: errors are injected into one chain at a time, for P0 and small
errors (H6), with other seeds. Clips are not corrected first, so every detection in an original clip
counts as a false alarm, however certain it is. Each number is followed by the number of clips
without a fault and Wilson's 90 % interval of their share, because a fault that occurs in no clip
here may occur in others.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial, reduce
from operator import add
from pathlib import Path

import numpy as np

from benchmarks.simulated_reviewer import DECOY, NATURAL, Reviewed, reviewed_folder, sampled
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import DEFAULT_METHOD
from twistcore.detection.prediction import Mask
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array
from twistcore.study.benchmark.clip_scene import make_clean_scene
from twistcore.study.benchmark.passes import run_benchmark_passes, run_on_clean_motion
from twistcore.study.benchmark.tally import Tally
from twistcore.synthesis import parse_protocol, prepare_clean_motion_for_injection
from twistcore.tuning import TauCurve, prepare_clip_tuning
from twistcore.tuning.common_tau import common_tau
from twistcore.tuning.injected_curve import PROTOCOLS
from twistcore.tuning.verdict_curve import wilson_bounds
from twistcore.tuning.verdicts_of import performer_of_clip

VERDICTS = 200


def captured(path: Path, harder: str) -> Motion:
    """Return the motion of a clip, made harder for the detector by the protocol `harder`."""
    motion = read_bvh(path).motion
    return prepare_clean_motion_for_injection(
        motion, analyse(motion).chains, parse_protocol(harder)
    )


def suggest(path: Path, harder: str) -> dict[str, TauCurve]:
    """Return the curves from which a clip's τ is chosen, keyed by chain name."""
    tuning = prepare_clip_tuning(captured(path, harder), path.name)
    return {name: tuning.curve(name) for name in tuning.names}


def judge(path: Path, harder: str, seeds: Sequence[int], tau: Mapping[str, float]) -> Array:
    """Return the results of a τ for a clip.

    For each protocol, the array has the number of repaired error frames and the number of error
    frames. Its last entry is the number of false alarms. `tau` is in radians, keyed by chain name.
    """
    row = []
    for protocol in PROTOCOLS:
        scene = make_clean_scene(path.name, captured(path, harder), parse_protocol(protocol))
        clean = run_on_clean_motion(scene, DEFAULT_METHOD, tau)
        total = Tally()
        for seed in seeds:
            total = sum(
                run_benchmark_passes(scene, DEFAULT_METHOD, seed, clean, tau).values(), total
            )
        row += [total.repaired, total.frames]
    names = {c.name for c in scene.chains}
    return np.array([*row, sum(len(clean.outcome.found[n]) for n in names)], dtype=float)


def report(title: str, rows: Array, tau: Sequence[float]) -> None:
    """Print the results of a τ. `rows` are results of :func:`judge`, one for each clip."""
    total, told = rows.sum(axis=0), []
    for k, protocol in enumerate(PROTOCOLS):
        share = 100 * total[2 * k] / total[2 * k + 1]
        told.append(f"{protocol} {share:.3f} %{_clips(rows[:, 2 * k] == rows[:, 2 * k + 1])}")
    told.append(f"{total[-1]:.0f} false alarms{_clips(rows[:, -1] == 0)}")
    low, middle, high = np.degrees(np.percentile(tau, [0, 50, 100]))
    print(
        f"  {title:<30} τ {low:5.2f}-{high:5.2f}°, median {middle:5.2f}°   {'   '.join(told)}",
        flush=True,
    )


def _clips(well: Mask) -> str:
    low, high = wilson_bounds(np.array(well.sum()), np.array(len(well)))
    return f" (all well in {well.sum()} of {len(well)} clips: {100 * low:.0f}-{100 * high:.0f} %)"


def by_verdicts(
    clips: Sequence[Reviewed], kinds: Sequence[str], names: Sequence[str], seed: int
) -> dict[str, float]:
    """Return the τ of each chain learned from up to 200 verdicts, or {} if there are too few.

    `kinds` are the kinds of wrong intervals among them.
    """
    given = sampled(clips, kinds, np.random.default_rng(seed), VERDICTS)
    found = common_tau(given)
    return {name: tau for name in names if (tau := found.tau(name)) is not None}


def judged(
    clips: Sequence[Path], harder: str, seeds: Sequence[int], title: str, tau: Mapping[str, float]
) -> None:
    """Test a τ on clips and print the results, or report that there were too few verdicts."""
    if not tau:
        print(f"  {title:<30} too few verdicts for a τ")
        return
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        rows = list(pool.map(partial(judge, harder=harder, seeds=seeds, tau=tau), clips))
    report(title, np.array(rows), [*tau.values()])


def main() -> None:
    """Learn from each half of the subjects, and test on the other half."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--step", type=int, default=3, help="every step-th clip")
    parser.add_argument("--seeds", type=int, default=2, help="seeds of the test")
    parser.add_argument(
        "--passes", type=int, default=2, help="passes of the reviewer over the clips"
    )
    parser.add_argument(
        "--harder", default="P0", help="how clips are made harder first, such as rich+H1"
    )
    arguments = parser.parse_args()
    paths = clip_paths_in_folder(arguments.folder, suffixes=BVH)
    who = [performer_of_clip(p.name) for p in paths]
    most = max(sorted(set(who)), key=who.count)
    first = [p for p in paths if performer_of_clip(p.name) == most]
    others = [p for p in paths if performer_of_clip(p.name) != most]
    seeds = range(601, 601 + arguments.seeds)
    for fit, test in ((first, others), (others, first)):
        fit, test = fit[:: arguments.step], test[:: arguments.step]
        with ProcessPoolExecutor(os.cpu_count()) as pool:
            harder = arguments.harder
            injected = list(pool.map(partial(suggest, harder=harder), fit))
        whose = [sorted({performer_of_clip(p.name) for p in some}) for some in (fit, test)]
        print(f"\nLearned from {', '.join(whose[0])}; judged on {', '.join(whose[1])}")
        names = sorted({n for curves in injected for n in curves})
        tau = {n: reduce(add, (c[n] for c in injected if n in c)).suggested() for n in names}
        judged(test, harder, seeds, "injected errors", tau)
        passes = [c for k in range(arguments.passes) for c in reviewed_folder(fit, k, harder)]
        for title, kinds in (
            ("verdicts, wrong: decoys", (DECOY,)),
            ("verdicts, wrong: false alarms", (NATURAL,)),
        ):
            if any(about in kinds for c in passes for about in c.about):
                judged(test, harder, seeds, title, by_verdicts(passes, kinds, names, 0))


if __name__ == "__main__":
    main()
