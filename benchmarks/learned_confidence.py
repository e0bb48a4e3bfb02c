"""Test the learned confidence: python -m benchmarks.learned_confidence FOLDER… [--seeds N].

The folders contain clips named SUBJECT_TRIAL.bvh. A simulated reviewer
(benchmarks.simulated_reviewer) decides on 200 intervals, a tenth of them wrong, in clips of some
subjects. The map from the detector's confidence to the learned one is fitted to these decisions and
tested on clips of *other* subjects, with the same share of wrong intervals, by the expected
calibration error (ECE, ten bins). Wrong intervals are false alarms of the detector, decoys that
this reviewer considers natural, or both in equal parts; in another test, 5 % of all decisions are
mistakes. Subject 05, on which the built-in map was fitted, is never used for testing. The number
after ± is half of the 90 % range over random draws of verdicts and test clips. For comparison, the
ECE of a perfect map is shown; by chance, it is not 0.

The form and prior of the map were chosen on passes 0 to 3; the reported passes begin at 4.
"""

from __future__ import annotations

import argparse
import pickle
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from benchmarks.simulated_reviewer import DECOY, NATURAL, Reviewed, reviewed_folder, sampled
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.tuning.learned_confidence import (
    ConfidenceVerdicts,
    confidence_reliability_by_bin,
    fit_confidence_to_verdicts,
    verdicts_with_confidence,
)

VERDICTS = 200
DRAWS = 20
CHOSEN_ON = 4  # number of the first passes, which chose the map and so cannot test it
SCENES = (
    ("false alarms", (NATURAL,), 0.0),
    ("decoys", (DECOY,), 0.0),
    ("both", (NATURAL, DECOY), 0.0),
    ("both, 5 % mistaken", (NATURAL, DECOY), 0.05),
)


def collected(paths: Sequence[Path], seed: int, keep: Path | None) -> list[Reviewed]:
    """Return the reviewed clips of one pass over all clips, cached in the folder `keep`."""
    file = keep / f"reviewed_{seed}.pickle" if keep else None
    if file and file.exists():
        return list(pickle.loads(file.read_bytes()))
    found = reviewed_folder(paths, seed)
    if file:
        file.write_bytes(pickle.dumps(found))
    return found


def drawn_clips(given: ConfidenceVerdicts, rng: np.random.Generator) -> ConfidenceVerdicts:
    """Return the verdicts on whole clips drawn at random with replacement."""
    clips = np.unique(given.clip)
    at = [np.flatnonzero(given.clip == c) for c in rng.choice(clips, len(clips))]
    chosen = np.concatenate(at)
    return ConfidenceVerdicts(given.confidence[chosen], given.accepted[chosen], given.clip[chosen])


def report(title: str, fit: Sequence[Reviewed], test: Sequence[Reviewed]) -> None:
    """Print one block of results for a map fitted to some clips and tested on others."""
    print(f"\n{title}: {len(fit)} passes over clips to learn from, {len(test)} to test on")
    for name, kinds, mistaken in SCENES:
        rows = []
        for seed in range(DRAWS):
            rng = np.random.default_rng(seed)
            found = fit_confidence_to_verdicts(
                verdicts_with_confidence(sampled(fit, kinds, rng, VERDICTS, mistaken))
            )
            whole = verdicts_with_confidence(sampled(test, kinds, rng, None, mistaken))
            size = len(whole)
            for judged in (whole, *(drawn_clips(whole, rng) for _ in range(5))):
                stated = found.of(judged.confidence)
                errors = (
                    confidence_reliability_by_bin(judged.confidence, judged.accepted).error,
                    confidence_reliability_by_bin(stated, judged.accepted).error,
                    confidence_reliability_by_bin(stated, rng.random(len(stated)) < stated).error,
                )
                rows.append((*errors, judged is whole))
        table = np.array(rows)
        middle = table[table[:, 3] > 0].mean(axis=0)
        low, high = np.percentile(table, [5, 95], axis=0)
        half = (high - low) / 2
        print(
            f"  {name:<20} ECE before {middle[0]:.3f} ± {half[0]:.3f}   learned {middle[1]:.3f} "
            f"± {half[1]:.3f}   by chance {middle[2]:.3f}   ({size} judged)"
        )


def main() -> None:
    """Learn from some subjects and test on the others, on the same rig and on a different one."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", type=Path, nargs="+", metavar="FOLDER")
    parser.add_argument("--seeds", type=int, default=4, help="passes over all clips")
    parser.add_argument("--first", type=int, default=CHOSEN_ON, help="the first pass's seed")
    parser.add_argument("--keep", type=Path, help="a folder to cache passes")
    arguments = parser.parse_args()
    paths = sorted(
        p for folder in arguments.folders for p in clip_paths_in_folder(folder, suffixes=BVH)
    )
    if not paths:
        parser.error("no BVH")
    passes = range(arguments.first, arguments.first + arguments.seeds)
    clips = [c for s in passes for c in collected(paths, s, arguments.keep)]
    rigs = sorted({c.clip.rig for c in clips}, key=lambda r: -sum(c.clip.rig == r for c in clips))
    own = [c for c in clips if c.clip.rig == rigs[0]]
    subjects = {
        name: [c for c in own if choose(c.clip.performer)]
        for name, choose in (
            ("05", lambda p: p == "05"),
            ("06", lambda p: p == "06"),
            ("others", lambda p: p not in ("05", "06")),
        )
    }
    for fit, test in (("05", "06"), ("05", "others"), ("06", "others"), ("others", "06")):
        report(f"Same rig, {fit} → {test}", subjects[fit], subjects[test])
    if other := [c for c in clips if c.clip.rig != rigs[0]]:
        report("Other rigs, 05 and 06 → all", subjects["05"] + subjects["06"], other)


if __name__ == "__main__":
    main()
