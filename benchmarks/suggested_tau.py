"""Test the suggested τ: python -m benchmarks.suggested_tau FOLDER [--seed N] [--seeds N].

τ is suggested for every chain from each single clip, and from all clips of the folder together (a
profile), with the seeds of `twistcore tune`. Then errors with other seeds are injected. The table
compares the FSR at the suggested τ with the FSR at the best fixed τ, chosen in hindsight from all
clips and chains, and shows the false alarms in all original clips.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial, reduce
from operator import add
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection import DEFAULT_METHOD, DETECTORS
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.rotation import Array
from twistcore.tuning import GRID, TauCurve, injected_tau_curve, prepare_clip_tuning
from twistcore.tuning.injected_curve import PROTOCOLS


@dataclass(frozen=True, eq=False)
class Tried:
    """The τ curves of one chain in one clip.

    Attributes
    ----------
    chain
        Name of the chain.
    curve
        The curve from which τ is suggested.
    trials
        The curves with other seeds, keyed by protocol.
    alarms
        Number of intervals corrected in the original clip, for each τ of the grid.
    """

    chain: str
    curve: TauCurve
    trials: dict[str, TauCurve]
    alarms: Array


def try_clip(path: Path, method: str, seeds: Sequence[int]) -> list[Tried]:
    """Return the τ curves of all chains of a clip. `seeds` are the seeds of the test errors."""
    motion = read_bvh(path).motion
    tuning = prepare_clip_tuning(motion, path.name, method=method)
    as_is = analyse(motion).by(method)
    out = []
    for chain in map(tuning.clean.chain, tuning.names):
        given = {"name": path.name, "method": method, "seeds": seeds}
        trials = {
            p: injected_tau_curve(tuning.clean, chain, **given, protocols=(p,)) for p in PROTOCOLS
        }
        alarms = [len(automatic_corrections(as_is.intervals(chain.name, t))) for t in GRID]
        out.append(Tried(chain.name, tuning.curve(chain.name), trials, np.array(alarms)))
    return out


def report(title: str, tried: Sequence[Tried], tau: Sequence[float]) -> None:
    """Print a block of results. `tau` has the τ chosen for each of `tried`, in radians."""
    place = [int(np.argmin(np.abs(t.curve.tau - x))) for t, x in zip(tried, tau, strict=True)]
    alarms = sum(int(t.alarms[k]) for t, k in zip(tried, place, strict=True))
    low, middle, high = np.degrees(np.percentile(tau, [0, 50, 100]))
    print(
        f"\n{title}: τ {low:.2f}-{high:.2f}°, median {middle:.2f}°; {alarms} false alarms in total"
    )
    for name, chosen in (*((p, (p,)) for p in PROTOCOLS), ("both", PROTOCOLS)):
        errors = sum(t.trials[p].errors for t in tried for p in chosen)
        own = sum(
            t.trials[p].repaired[k] for t, k in zip(tried, place, strict=True) for p in chosen
        )
        fixed = reduce(add, (t.trials[p].repaired for t in tried for p in chosen))
        best = int(np.argmax(fixed))
        print(
            f"  {name:<5} {errors:7d} error frames   FSR {100 * own / errors:7.3f} %   "
            f"best fixed τ {np.degrees(GRID[best]):5.2f}°: {100 * fixed[best] / errors:7.3f} %   "
            f"lost {100 * (fixed[best] - own) / errors:6.3f} points"
        )


def main() -> None:
    """Test the suggestions and print both blocks of results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=601, help="the first seed of the trial")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--method", choices=sorted(DETECTORS), default=DEFAULT_METHOD)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    arguments = parser.parse_args()
    paths = clip_paths_in_folder(arguments.folder, suffixes=BVH)
    if not paths:
        parser.error(f"{arguments.folder}: no BVH")
    seeds = range(arguments.seed, arguments.seed + arguments.seeds)
    with ProcessPoolExecutor(arguments.workers) as pool:
        work = partial(try_clip, method=arguments.method, seeds=seeds)
        tried = [t for clip in pool.map(work, paths) for t in clip]
    print(
        f"{len(paths)} clips, {sum(t.curve.minutes for t in tried):.1f} "
        f"minutes times chains, detector {arguments.method}, seeds {seeds[0]}-{seeds[-1]}"
    )
    report("From each clip by itself", tried, [t.curve.suggested() for t in tried])
    profile = {
        name: reduce(add, (t.curve for t in tried if t.chain == name))
        for name in {t.chain for t in tried}
    }
    report("From all clips together", tried, [profile[t.chain].suggested() for t in tried])


if __name__ == "__main__":
    main()
