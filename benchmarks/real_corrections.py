"""What is corrected unasked in real captures, by measures that need no eye.

    python -m benchmarks.real_corrections FOLDER [--json FILE]

FOLDER holds a folder of clips for every set. Of every automatic counter-twist: whether it takes a
joint off the hinge that it keeps to elsewhere by more than 1° (goal: none), and whether the twists
of P and C, the azimuth and the turn of both run smoother after it than before (goal: 98 %). Of
every automatic limb flip: whether the path of the elbow or knee gets longer (goal: none). And how
many finds are left for a person.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from twistcore.analysis import REPAIRED, ClipAnalysis, analyse
from twistcore.chain import Chain
from twistcore.clip_suffixes import clip_suffix
from twistcore.detection import Interval, Kind
from twistcore.detection.evidence import Find, Witnesses, taken_by, terms_of
from twistcore.detection.robust_cost import residual_cost
from twistcore.errors import TwistError
from twistcore.formats import read_clip
from twistcore.motion import Motion
from twistcore.twist_removal import applied_unasked, refine

HINGE, BEND, OFF = 3.0, 25.0, 1.0  # degrees: how still it stands, where it is bent, how far off
BESIDE = 3  # frames around an edge


def clips_of(folder: Path) -> Iterator[Path]:
    """All files that may be clips, in order."""
    return (p for p in sorted(folder.rglob("*")) if p.is_file() and clip_suffix(p.name))


def off_hinge(
    motion: Motion, chain: Chain, interval: Interval, every: Sequence[Interval]
) -> float | None:
    """By how much a correction takes the joint off its hinge, degrees; None where it has none.

    every: all finds, whose frames say nothing of the hinge.
    """
    known = Witnesses.of(motion, chain)
    if not known.hinged:
        return None
    find = Find(interval.start, interval.stop, np.degrees(interval.offset))
    if not (known.bend[interval.start : interval.stop] > BEND).any():
        return None
    own = [Find(i.start, i.stop, i.offset) for i in every if i.chain == interval.chain]
    taken = taken_by(motion.frames, own)
    terms = terms_of(known, find, taken)
    if not terms.side_spread < HINGE:
        return None
    return terms.off_after - terms.off_before


def roughness(
    before: Motion, after: Motion, chain: Chain, interval: Interval
) -> tuple[float, float]:
    """Costs of the second differences of all witnesses over the edges, before and after.

    Each in the scale that it has in the clip as it was.
    """
    old, new = Witnesses.of(before, chain), Witnesses.of(after, chain)
    at = np.zeros(before.frames, dtype=bool)
    for edge in (interval.start, interval.stop):
        at[max(edge - BESIDE, 1) : edge + BESIDE] = True
    if interval.soft_ended:
        at[max(interval.start - BESIDE, 1) : interval.stop + BESIDE] = True
    costs = np.zeros(2)
    for name in ("x", "y", "azimuth_turns", "together"):
        seen = at & (old.both_frames > 0.34) if name == "azimuth_turns" else at
        if name == "azimuth_turns" and not old.hinged:
            continue
        changes = [
            np.diff(getattr(w, name), axis=0, prepend=0.0 * getattr(w, name)[:1])
            for w in (old, new)
        ]
        sizes = [c if c.ndim == 1 else np.linalg.norm(c, axis=1) for c in changes]
        scale = max(1.48 * float(np.median(np.abs(sizes[0]))), 0.02)
        costs += [residual_cost(s[seen] / scale).sum() for s in sizes]
    return float(costs[0]), float(costs[1])


def measure(analysis: ClipAnalysis) -> Counter[str]:
    """The counts of one clip."""
    motion, found = analysis.motion, analysis.detect(kinds=REPAIRED)
    done = applied_unasked(found)
    count = Counter(left=len(found) - len(done))
    for interval in done:
        chain = analysis.chain(interval.chain)
        if interval.kind == Kind.LIMB_FLIP:
            told = interval.evidence or {}
            count["flips"] += 1
            count["longer"] += told["path_corrected"] >= told["path"]
        elif interval.kind == Kind.COUNTER_TWIST:
            count["twists"] += 1
            off = off_hinge(motion, chain, interval, found.intervals)
            count["hinged"] += off is not None
            count["off hinge"] += off is not None and off > OFF
            before, after = roughness(motion, refine(motion, [chain], [interval]), chain, interval)
            count["smoother"] += after < before
    return count


def main() -> None:
    """Measure every set."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    names = "clips", "twists", "hinged", "off hinge", "smoother", "flips", "longer", "left"
    rows: dict[str, Counter[str]] = {}
    print(f"{'set':<28}" + "".join(f"{name:>10}" for name in names))
    for folder in sorted(p for p in given.folder.iterdir() if p.is_dir()):
        rows[folder.name] = row = Counter()
        for path in clips_of(folder):
            try:
                row.update(measure(analyse(read_clip(path))))
                row["clips"] += 1
            except TwistError as error:
                print(f"left out: {error}")
        print(f"{folder.name:<28}" + "".join(f"{row[name]:>10}" for name in names), flush=True)
    total = sum(rows.values(), Counter[str]())
    print(f"{'all':<28}" + "".join(f"{total[name]:>10}" for name in names))
    if given.json:
        given.json.write_text(json.dumps({k: dict(v) for k, v in rows.items()}, indent=2))


if __name__ == "__main__":
    main()
