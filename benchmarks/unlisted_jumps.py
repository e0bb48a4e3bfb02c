"""Count the large rotations from frame to frame that the program does not list.

    python -m benchmarks.unlisted_jumps FOLDER… [--degrees D] [--list N]

A large turn is a rotation of a joint by at least D degrees (default 45) from one frame to the next
that is more than four times the median of the two rotations before and the two after. Fast movement
at a low frame rate is therefore not a large turn. A turn counts as listed if an interval at its
frame, with a tolerance of two frames, concerns the joint, a chain or limb with the joint, or the
whole body. For each folder, the table shows all turns, the listed turns, and the turns in frames
where only another joint or nothing is listed.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

import numpy as np

from benchmarks.real_corrections import clips_of
from benchmarks.severity_order import stand_out
from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.detection import Interval, Kind
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import geodesic_angle

_NEAR = 2  # tolerance in frames
_WHOLE = {Kind.BODY_STEP, Kind.FROZEN, Kind.NOISE_BURST}


def large_turns(motion: Motion, degrees: float) -> list[tuple[int, int, float]]:
    """Return the frame, the joint and the angle in degrees of every large turn.

    The frame is the later of the two frames.
    """
    if motion.frames < 6:
        return []
    turns = np.degrees(geodesic_angle(motion.rotations[1:], motion.rotations[:-1]))
    steps, joints = np.nonzero(stand_out(turns, degrees))
    return [
        (int(t) + 3, int(j), float(turns[t + 2, j])) for t, j in zip(steps, joints, strict=True)
    ]


def joints_of(interval: Interval, analysis: ClipAnalysis) -> set[int] | None:
    """Return the joints that an interval concerns, or None if it concerns the whole body."""
    if interval.kind in _WHOLE:
        return None
    skeleton = analysis.motion.skeleton
    named = {skeleton.index(interval.joint)} if interval.joint in skeleton.names else set()
    for chain in (*analysis.chains, *analysis.limbs):
        if chain.name == interval.chain:
            named |= {j for j in (chain.parent, chain.child, chain.grandchild) if j >= 0}
            named |= {j for j, p in enumerate(skeleton.parents) if p == chain.parent}
    return named


def main() -> None:
    """Print the table, and the first turns in frames where nothing is listed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--degrees", type=float, default=45.0)
    parser.add_argument("--list", type=int, default=20, metavar="N")
    options = parser.parse_args()
    missing = []
    print(f"{'folder':24s} {'clips':>6s} {'turns':>6s} {'listed':>7s} {'other':>6s} {'none':>5s}")
    for folder in options.folders:
        count: Counter[str] = Counter()
        for path in clips_of(folder):
            try:
                analysis = analyse(read_clip(path))
            except TwistError:
                continue
            count["clips"] += 1
            turns = large_turns(analysis.motion, options.degrees)
            found = list(analysis.detect()) if turns else []
            spans = [(i, joints_of(i, analysis)) for i in found]
            for frame, joint, size in turns:
                near = [j for i, j in spans if i.start - _NEAR <= frame <= i.stop + _NEAR]
                own = any(j is None or joint in j for j in near)
                verdict = "listed" if own else "other" if near else "none"
                count["turns"] += 1
                count[verdict] += 1
                if not own:
                    name = analysis.motion.skeleton.names[joint]
                    missing.append((verdict, size, f"{path.name} {name} frame {frame}"))
        print(
            f"{folder.name:24s} {count['clips']:6d} {count['turns']:6d} {count['listed']:7d} "
            f"{count['other']:6d} {count['none']:5d}"
        )
    for verdict, size, where in sorted(missing, reverse=True)[: options.list]:
        print(f"{verdict:6s} {size:6.1f}°  {where}")


if __name__ == "__main__":
    main()
