"""Measure the automatic corrections in real captures.

    python -m benchmarks.real_corrections FOLDER [--json FILE]

FOLDER contains a folder of clips for every set. The protected measures
(:mod:`twistcore.analysis.correction.protected_measures`) are computed for every automatic
correction. Each has a column with the number of corrections that make it worse, out of those for
which it could be measured (goal: none). For counter-twists, the table also shows how many automatic
corrections make the twists of parent and child, the azimuth and the rotation of both smoother
(goal: 98 %), and how many intervals are left for review.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import REPAIRED, ClipAnalysis, analyse
from twistcore.analysis.correction.protected_measures import NAMES, Hinges, protected_measures
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.detection import Interval, Kind
from twistcore.detection.evidence import ChainSignals
from twistcore.detection.robust_cost import residual_cost
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.formats.suffixes import clip_suffix
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion

NEAR = 3  # number of frames on either side of an edge
COUNTS = "clips", "twists", "smoother", "flips", "left"


def clips_of(folder: Path) -> Iterator[Path]:
    """Yield all files in a folder and its subfolders that may be clips, sorted."""
    return (p for p in sorted(folder.rglob("*")) if p.is_file() and clip_suffix(p.name))


def roughness(
    before: Motion, after: Motion, chain: Chain, interval: Interval
) -> tuple[float, float]:
    """Return the roughness of a chain's angles at an interval's edges, before and after correction.

    Roughness is the cost of second differences. Each angle is scaled by its usual size in the
    original clip.
    """
    old, new = ChainSignals.of(before, chain), ChainSignals.of(after, chain)
    at = np.zeros(before.frames, dtype=bool)
    for edge in (interval.start, interval.stop):
        at[max(edge - NEAR, 1) : edge + NEAR] = True
    if interval.soft_ended:
        at[max(interval.start - NEAR, 1) : interval.stop + NEAR] = True
    costs = np.zeros(2)
    for name in ("x", "y", "azimuth_turns", "together"):
        seen = at & (old.both_frames > 0.34) if name == "azimuth_turns" else at
        if name == "azimuth_turns" and not old.hinged:
            continue
        turns = [
            w.together(0, w.frames) if name == "together" else getattr(w, name) for w in (old, new)
        ]
        changes = [np.diff(t, axis=0, prepend=0.0 * t[:1]) for t in turns]
        sizes = [c if c.ndim == 1 else np.linalg.norm(c, axis=1) for c in changes]
        scale = max(1.48 * float(np.median(np.abs(sizes[0]))), 0.02)
        costs += [residual_cost(s[seen] / scale).sum() for s in sizes]
    return float(costs[0]), float(costs[1])


def measure(analysis: ClipAnalysis) -> Counter[str]:
    """Return the counts for one clip."""
    motion, found = analysis.motion, analysis.detect(kinds=REPAIRED)
    done, chains = automatic_corrections(found), analysis.chains_and_limbs
    hinges = Hinges(motion, found.intervals)
    count = Counter(left=len(found) - len(done))
    for interval in done:
        for one in protected_measures(motion, chains, interval, hinges, done):
            count[f"{one.name}: measured"] += 1
            count[f"{one.name}: worse"] += one.worse
        if interval.kind == Kind.LIMB_FLIP:
            count["flips"] += 1
        elif interval.kind == Kind.COUNTER_TWIST:
            count["twists"] += 1
            chain = analysis.chain(interval.chain)
            before, after = roughness(motion, refine(motion, [chain], [interval]), chain, interval)
            count["smoother"] += after < before
    return count


def row_of(count: Counter[str]) -> str:
    """Return the numbers for a set, one for each column of the table."""
    measured = (f"{count[f'{n}: worse']}/{count[f'{n}: measured']}" for n in NAMES)
    return "".join(f"{count[name]:>10}" for name in COUNTS) + "".join(f"{m:>19}" for m in measured)


def main() -> None:
    """Measure the corrections in every set of clips, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rows: dict[str, Counter[str]] = {}
    heads = "".join(f"{name:>10}" for name in COUNTS) + "".join(f"{name:>19}" for name in NAMES)
    print(f"{'set':<28}{heads}")
    for folder in sorted(p for p in given.folder.iterdir() if p.is_dir()):
        rows[folder.name] = row = Counter()
        for path in clips_of(folder):
            try:
                row.update(measure(analyse(read_clip(path))))
                row["clips"] += 1
            except TwistError as error:
                print(f"left out: {error}")
        print(f"{folder.name:<28}{row_of(row)}", flush=True)
    print(f"{'all':<28}{row_of(sum(rows.values(), Counter[str]()))}")
    if given.json:
        given.json.write_text(json.dumps({k: dict(v) for k, v in rows.items()}, indent=2))


if __name__ == "__main__":
    main()
