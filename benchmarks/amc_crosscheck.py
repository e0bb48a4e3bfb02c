"""Compare the joints of AMC clips with the same trials as BVH.

    python -m benchmarks.amc_crosscheck FOLDER_AMC FOLDER_BVH

Both folders contain files with the same names: the CMU Motion Capture Database as released, with
its ASF files, and a BVH version of it in which the joints have the same order. Frame 0 of such a
BVH may be a T-pose that was added later. The BVH omits the length of bones with several children
(thorax, wrists), whose joints have an OFFSET of 0.

For each trial, one file is scaled by a factor estimated from the paths of the roots. The output
shows the largest distance between the same joints in the AMC's length unit, once for joints without
an omitted length above them, and once for all joints after these lengths were restored. The exit
status is 1 if a distance is larger than the rounding of both files can explain.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from twistcore.formats.amc import read_amc
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.motion import Motion, forward_kinematics

# Numbers in the BVH have 4 decimals. For the position of the root, this is an error of up to 9e-5
# over three axes. For each angle above a hand, it is up to 3e-5 over a limb of 17 units.
MOST = 2e-4


@dataclass(frozen=True)
class Compared:
    """The result for one trial.

    Attributes
    ----------
    frames
        Number of frames.
    scale
        The factor by which the BVH was scaled.
    above
        The largest distance of joints without an omitted length above them.
    whole
        The largest distance of all joints after the lengths were restored.
    left_out
        Names of the joints whose length is omitted in the BVH.
    """

    frames: int
    scale: float
    above: float
    whole: float
    left_out: tuple[str, ...]


def compared(amc: Path, bvh: Path) -> Compared:
    """Compare two files of the same trial. Raises ValueError if the trials differ."""
    mine, theirs = read_amc(amc).motion, read_bvh(bvh).motion
    if theirs.frames == mine.frames + 1:
        theirs = theirs.sliced(1, theirs.frames)
    if mine.frames != theirs.frames:
        raise ValueError(f"{amc.name}: {mine.frames} frames, but {theirs.frames} in the BVH")
    ours, skeleton = mine.skeleton, theirs.skeleton
    if not np.array_equal(ours.parents, skeleton.parents):
        raise ValueError(f"{amc.name}: the joints of the BVH have another order")
    ways = [m.translation(0).ravel() for m in (mine, theirs)]
    scale = float(ways[0] @ ways[1] / (ways[1] @ ways[1]))
    gone = (skeleton.offsets == 0.0).all(axis=1) & (ours.offsets != 0.0).any(axis=1)
    gone[0] = False
    offsets = np.where(gone[:, None], ours.offsets / scale, skeleton.offsets)
    filled = replace(theirs, skeleton=replace(skeleton, offsets=offsets))
    below = gone.copy()
    for joint, parent in enumerate(ours.parents):
        below[joint] |= parent >= 0 and below[parent]
    kept = ~below
    names = tuple(ours.names[j] for j in np.flatnonzero(gone))
    above = _largest(mine, theirs, scale)[kept].max()
    return Compared(mine.frames, scale, above, _largest(mine, filled, scale).max(), names)


def _largest(mine: Motion, theirs: Motion, scale: float) -> np.ndarray:
    """Return the largest distance between both positions of each joint, shape (joints,)."""
    places = [forward_kinematics(m)[1] for m in (mine, theirs)]
    return np.linalg.norm(places[0] - scale * places[1], axis=-1).max(axis=0)


def main() -> int:
    """Compare every AMC file in a folder with the BVH of the same name in the other folder."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("amc", type=Path)
    parser.add_argument("bvh", type=Path)
    arguments = parser.parse_args()
    wrong = False
    for amc in sorted(arguments.amc.glob("*.amc")):
        if not (bvh := arguments.bvh / f"{amc.stem}.bvh").is_file():
            continue
        try:
            c = compared(amc, bvh)
        except ValueError as error:
            print(error)
            wrong = True
            continue
        print(
            f"{amc.stem}: {c.frames} frames, scale {c.scale:.6f}, at most {c.above:.1e}; all "
            f"joints {c.whole:.1e} with the lengths to {', '.join(c.left_out) or 'none'}"
        )
        wrong |= max(c.above, c.whole) > MOST
    return int(wrong)


if __name__ == "__main__":
    sys.exit(main())
