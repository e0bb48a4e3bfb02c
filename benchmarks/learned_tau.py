"""Is τ from verdicts as good as τ from injected errors? python -m benchmarks.learned_tau FOLDER.

The folder holds clips named SUBJECT_TRIAL.bvh. τ is suggested from the clips of some subjects: by
errors injected into them, and by the verdicts of a simulated reviewer on 200 listed intervals, a
tenth of which are wrong (the detector's own false alarms; or decoys, which this person calls
natural). Both are judged on clips of other subjects, each chain in turn, with other seeds: FSR of
P0 and of small errors (H6), and the false alarms in the clips without errors of their own. After ±
stands half of where 90 % of the results lie when the judged clips are drawn anew.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial, reduce
from operator import add
from pathlib import Path

import numpy as np

from benchmarks.simulated_reviewer import DECOY, NATURAL, Reviewed, reviewed_folder, sampled
from twistcore.analysis import analyse
from twistcore.bvh import read_bvh
from twistcore.motion import Motion
from twistcore.rotation import Array
from twistcore.synthesis import parse_protocol, prepare
from twistcore.tuning import TauCurve, clip_tuning, tau_curve
from twistcore.tuning.common_tau import common_tau
from twistcore.tuning.injected_curve import PROTOCOLS
from twistcore.tuning.verdicts_of import performer_of

VERDICTS = 200
DRAWS = 1000


@dataclass(frozen=True, eq=False)
class Judge:
    """A clip to judge on: by chain its curves by protocol."""

    curves: Mapping[str, Mapping[str, TauCurve]]


def captured(path: Path, harder: str) -> Motion:
    """The clip's motion, made harder."""
    motion = read_bvh(path).motion
    return prepare(motion, analyse(motion).chains, parse_protocol(harder))


def suggest(path: Path, harder: str) -> dict[str, TauCurve]:
    """The curves of a clip that τ is chosen by, by chain."""
    tuning = clip_tuning(captured(path, harder), path.name)
    return {name: tuning.curve(name) for name in tuning.names}


def judge(path: Path, harder: str, seeds: Sequence[int]) -> Judge:
    """The curves of a clip that τ is judged by."""
    tuning = clip_tuning(captured(path, harder), path.name)
    given = {"name": path.name, "seeds": seeds}
    return Judge(
        {
            n: {
                p: tau_curve(tuning.clean, tuning.clean.chain(n), **given, protocols=(p,))
                for p in PROTOCOLS
            }
            for n in tuning.names
        }
    )


def result(clip: Judge, tau: Mapping[str, float]) -> Array:
    """Repaired and all error frames of each protocol, then false alarms; in a row."""
    row = np.zeros(2 * len(PROTOCOLS) + 1)
    for name, curves in clip.curves.items():
        if name not in tau:
            continue
        for k, protocol in enumerate(PROTOCOLS):
            curve = curves[protocol]
            place = int(np.abs(np.log(curve.tau / tau[name])).argmin())
            row[2 * k] += curve.repaired[place]
            row[2 * k + 1] += curve.errors
        row[-1] += curves[PROTOCOLS[0]].alarms[place]
    return row


def report(title: str, rows: Array, tau: Sequence[float]) -> None:
    """Print what a τ brings."""
    rng = np.random.default_rng(0)
    drawn = rng.multinomial(len(rows), np.full(len(rows), 1 / len(rows)), DRAWS) @ rows
    total, told = rows.sum(axis=0), []
    for k, protocol in enumerate(PROTOCOLS):
        low, high = np.percentile(100 * drawn[:, 2 * k] / drawn[:, 2 * k + 1], [5, 95])
        share = 100 * total[2 * k] / total[2 * k + 1]
        told.append(f"{protocol} {share:7.3f} ± {(high - low) / 2:.3f} %")
    low, middle, high = np.degrees(np.percentile(tau, [0, 50, 100]))
    print(
        f"  {title:<34} τ {low:5.2f}-{high:5.2f}°, median {middle:5.2f}°   {'   '.join(told)}   "
        f"{total[-1]:.0f} false alarms"
    )


def by_verdicts(
    clips: Sequence[Reviewed], kinds: Sequence[str], names: Sequence[str], seed: int
) -> dict[str, float]:
    """τ of chains by 200 verdicts; what little is listed is taken as it is."""
    given = sampled(clips, kinds, np.random.default_rng(seed), VERDICTS)
    found = common_tau(given)
    return {name: found.tau(name) or np.nan for name in names}


def main() -> None:
    """Two ways round: each half of the subjects is learned from once."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--step", type=int, default=3, help="every step-th clip")
    parser.add_argument("--seeds", type=int, default=2, help="of the judge")
    parser.add_argument("--passes", type=int, default=2, help="of the reviewer over the clips")
    parser.add_argument("--harder", default="P0", help="what is done to clips first: rich+H1")
    arguments = parser.parse_args()
    paths = sorted(arguments.folder.glob("*.bvh"))
    who = [performer_of(p.name) for p in paths]
    most = max(sorted(set(who)), key=who.count)
    first = [p for p in paths if performer_of(p.name) == most]
    others = [p for p in paths if performer_of(p.name) != most]
    seeds = range(601, 601 + arguments.seeds)
    for fit, test in ((first, others), (others, first)):
        fit, test = fit[:: arguments.step], test[:: arguments.step]
        with ProcessPoolExecutor(os.cpu_count()) as pool:
            harder = arguments.harder
            injected = list(pool.map(partial(suggest, harder=harder), fit))
            judges = list(pool.map(partial(judge, harder=harder, seeds=seeds), test))
        whose = [sorted({performer_of(p.name) for p in some}) for some in (fit, test)]
        print(f"\nLearned from {', '.join(whose[0])}; judged on {', '.join(whose[1])}")
        names = sorted({n for curves in injected for n in curves})
        tau = {n: reduce(add, (c[n] for c in injected if n in c)).suggested() for n in names}
        report("injected errors", np.array([result(c, tau) for c in judges]), [*tau.values()])
        passes = [c for k in range(arguments.passes) for c in reviewed_folder(fit, k, harder)]
        for title, kinds in (
            ("verdicts, wrong: decoys", (DECOY,)),
            ("verdicts, wrong: false alarms", (NATURAL,)),
        ):
            if any(about in kinds for c in passes for about in c.about):
                taus = by_verdicts(passes, kinds, names, 0)
                report(title, np.array([result(c, taus) for c in judges]), [*taus.values()])


if __name__ == "__main__":
    main()
