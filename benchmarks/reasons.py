"""Check the reasons for peaks above τ that have no interval: python -m benchmarks.reasons FOLDER…

    python3 dev.py bench reasons FOLDER… [--json FILE] [--clips GLOB] [--show WORD]

For every clip and three detectors (consistency, paper and limb flips) at their automatic τ, all
peaks above τ outside intervals and edges are counted by the reason that `twistcore detect
--explain` gives. A peak without a reason, or with one that contradicts the curve, is listed; the
exit status is then 1.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from twistcore.analysis.clip_analysis import Detection, analyse
from twistcore.analysis.why_not import Reason, Why, why_peaks_lack_interval
from twistcore.detection import Interval, Kind
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh

NEAR = 1  # largest number of frames between an interval's edge and a peak that belongs to it
LONE = 0.25  # a rotation below this share of the larger one does not count as turning back
BELOW_ONLY = frozenset({Why.BELOW})
NEVER_PEAKS = frozenset({Why.BELOW, Why.INTERVAL, Why.CUT})  # reasons that no peak past τ can have
KINDS = {
    "consistency": ("consistency", Kind.COUNTER_TWIST),
    "paper": ("paper", Kind.COUNTER_TWIST),
    "limbs": ("consistency", Kind.LIMB_FLIP),
}


def peaks(found: Detection, name: str) -> list[int]:
    """Return the frames of the peaks above τ outside intervals, found frame by frame.

    This function does not use the code that finds the reasons, so that it can check that code.
    `name` is the name of a chain or limb.
    """
    strength = found.analysis.detector(found.method).strength(name).tolist()
    own = [i for i in found if i.chain == name]
    out, best = [], -1
    for frame, value in enumerate([*strength, -math.inf]):
        if value >= found.tau[name]:
            best = frame if best < 0 or value > strength[best] else best
        elif best >= 0:
            if not any(_touched(i, best) for i in own):
                out.append(best)
            best = -1
    return out


def _touched(interval: Interval, frame: int) -> bool:
    return interval.start - NEAR <= frame <= interval.stop + NEAR


def contradictions(found: Detection, reason: Reason) -> Iterator[str]:
    """Yield contradictions between a reason and the curve, the intervals or its own numbers."""
    strength = float(found.analysis.detector(found.method).strength(reason.chain)[reason.frame])
    tau, numbers = found.tau[reason.chain], reason.numbers
    if reason.strength != strength or reason.tau != tau:
        yield f"reason: {reason.strength} against {reason.tau}; curve: {strength} against {tau}"
    past = strength >= tau
    if (" above τ" in reason.text) != past or (" below τ" in reason.text) == past:
        yield f"the curve is {'past' if past else 'below'} τ, unlike the reason"
    if reason.why in BELOW_ONLY and past:
        yield "below τ"
    there = any(i.chain == reason.chain and _touched(i, reason.frame) for i in found)
    if there != (reason.why == Why.INTERVAL):
        yield "an interval is there" if there else "there is no interval"
    if reason.why == Why.ONE_JOINT:
        turns = sorted(abs(numbers[f"residual_{v}_deg"]) for v in "xy")
        if turns[0] > LONE * turns[1] or turns[1] < math.degrees(tau):
            yield f"one joint turns: {turns}"
    if (
        reason.why in (Why.IMAGE, Why.OTHER)
        and past
        and not any(_is_meant(i, reason) for i in found)
    ):
        yield "the named interval does not exist"
    if not reason.text.endswith(".") or "nan" in reason.text:
        yield f"not a sentence: {reason.text}"


def _is_meant(interval: Interval, reason: Reason) -> bool:
    """Return True if the interval belongs to the chain that the reason names."""
    if reason.why == Why.IMAGE:
        return bool(interval.chain == reason.numbers["of"])
    return interval.chain == reason.chain


def wrong(found: Detection, name: str) -> tuple[list[Reason], list[str]]:
    """Return all reasons for the peaks of a chain or limb, and the errors in these reasons."""
    reasons = why_peaks_lack_interval(found, name)
    lines = [f"{name} {r.frame}: {what}" for r in reasons for what in contradictions(found, r)]
    lines += [f"{name} {r.frame}: {r.why} at a peak" for r in reasons if r.why in NEVER_PEAKS]
    missing = set(peaks(found, name)) ^ {r.frame for r in reasons}
    lines += [f"{name} {frame}: no reason, or no peak" for frame in sorted(missing)]
    return reasons, lines


def main() -> int:
    """Count the reasons in all folders. Return 1 if a reason is missing or wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n", 1)[0])
    parser.add_argument("folder", type=Path, nargs="+")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--clips", default="*.bvh", help="which files of the folders")
    parser.add_argument("--show", default="", help="print the sentences of this reason")
    options = parser.parse_args()
    counts: dict[str, Counter[str]] = {kind: Counter() for kind in KINDS}
    suspicious: Counter[str] = Counter()
    clips, bad = 0, []
    for path in sorted(p for f in options.folder for p in f.rglob(options.clips)):
        try:
            analysis = analyse(read_bvh(path))
        except TwistError as error:
            print(f"{path}: {error}", file=sys.stderr)
            continue
        clips += 1
        for kind, (method, of) in KINDS.items():
            found = analysis.detect(method)  # all chains: intervals of others may be the cause
            looked_at = found.limbs if of == Kind.LIMB_FLIP else found.chains
            for name in (c.name for c in looked_at):
                reasons, lines = wrong(found, name)
                counts[kind].update(r.why.value for r in reasons)
                suspicious.update({kind: sum(r.suspicious for r in reasons)})
                bad += [f"{path.name} {kind} {line}" for line in lines]
                for r in reasons:
                    if options.show == r.why.value:
                        print(f"{path.stem} {name}: {r.text}")
    words = sorted({w for c in counts.values() for w in c})
    print(f"{clips} clips; peaks past τ without an interval, by reason")
    print("".join(f"{h:>16}" for h in ("", *KINDS)))
    for word in words:
        print(f"{word:>16}" + "".join(f"{counts[k][word]:>16}" for k in KINDS))
    print(f"{'all':>16}" + "".join(f"{counts[k].total():>16}" for k in KINDS))
    print(f"{'suspicious':>16}" + "".join(f"{suspicious[k]:>16}" for k in KINDS))
    for line in bad:
        print(f"WRONG {line}")
    if options.json:
        options.json.write_text(json.dumps({"clips": clips, "counts": counts, "wrong": bad}))
    return int(bool(bad))


if __name__ == "__main__":
    sys.exit(main())
