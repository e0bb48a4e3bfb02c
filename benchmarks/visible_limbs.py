"""Measure how much of a limb is visible, compared with the best of many views.

    python -m benchmarks.visible_limbs FOLDER… [--clips N] [--intervals N] [--views N]

Random errors are injected into each clip, and the view of the limb is requested, as the key N does
in the window. The share of the limb that no other bone, head or chest hides is compared with the
largest such share over evenly distributed directions. The target is 80 % of the best view.
"""

from __future__ import annotations

import argparse
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np

from inspector.viewport.bodies import BoneSegment, find_bones
from inspector.viewport.head_and_chest import heads_and_chests
from inspector.viewport.limb_side import best_limb_error_view
from inspector.viewport.occlusion import occluders
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import Chain, find_chains
from twistcore.skeleton.figure import figure_facing_direction, figure_size, guess_up
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import Array, rotate
from twistcore.synthesis import clip_random_generator, draw_errors

TARGET = 0.8
_PLACES = np.linspace(0.05, 0.95, 10)[:, None]  # positions along a bone at which it is checked


def directions(count: int) -> Array:
    """Return evenly distributed unit vectors, shape (count, 3)."""
    level = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    around = np.pi * (1.0 + np.sqrt(5.0)) * np.arange(count)
    wide = np.sqrt(1.0 - level**2)
    return np.stack([wide * np.cos(around), level, wide * np.sin(around)], axis=1)


def seen_shares(
    chain: Chain, bones: tuple[BoneSegment, ...], pose: tuple[Array, Array], height: float,
    views: Array,
) -> Array:  # fmt: skip
    """Return the visible share of a chain's bones from each view, shape (views,).

    Parameters
    ----------
    chain
        The chain.
    bones
        The bones that may hide it.
    pose
        The global rotations and positions of all joints.
    height
        The height of the figure.
    views : array, shape (views, 3)
        The directions to the viewer.
    """
    rotations, positions = pose
    joints = [j for j in (chain.parent, chain.child, chain.grandchild) if j >= 0]
    own = list(pairwise(joints))
    parents = [b.parent for b in bones]
    ends = positions[parents] + rotate(rotations[parents], np.array([b.tip for b in bones]))
    points = [positions[a] + _PLACES * (positions[b] - positions[a]) for a, b in own]
    hidden = occluders(bones, ends, positions, own, height).hidden_share(np.vstack(points), views)
    seen: Array = 1.0 - hidden
    return seen


def ratios(motion: Motion, name: str, intervals: int, views: Array) -> list[float]:
    """Return the visible share of each interval's limb, relative to the best view.

    `name` seeds the errors, and `intervals` is the number of errors.
    """
    chains = find_chains(motion)
    rotations, positions = forward_kinematics(motion)
    up, height = (
        guess_up(positions, chains, motion.skeleton),
        figure_size(positions, motion.skeleton),
    )
    fronts = heads_and_chests(chains, motion.skeleton, rotations, positions, height)
    bones = (*find_bones(motion, up, height), *(front.bone for front in fronts))
    rng = clip_random_generator(46, name)
    errors = draw_errors(motion, chains, rng)
    chosen = [errors[k] for k in rng.permutation(len(errors))[:intervals]]
    found = []
    for error in chosen:
        chain = next(c for c in chains if c.name == error.chain)
        frame = (error.start + error.stop) // 2
        offset = np.zeros(motion.frames)
        offset[error.start : error.stop] = -error.offset
        dirty = remove_twist(motion, chains, {chain.name: offset}).sliced(frame, frame + 1)
        turned, places = forward_kinematics(dirty)
        after = rotations[frame], positions[frame]
        facing = figure_facing_direction(positions[frame], chains, up)
        side = best_limb_error_view(
            chain, bones, (turned[0], places[0]), after, facing, up,
            skeleton=motion.skeleton, height=height,
        )  # fmt: skip
        if side is not None:
            best = float(seen_shares(chain, bones, after, height, views).max())
            seen = float(seen_shares(chain, bones, after, height, side.direction[None])[0])
            found.append(seen / best if best > 0.0 else 1.0)
    return found


def main() -> int:
    """Print the table. Return 1 if the mean misses the target."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--clips", type=int, default=20)
    parser.add_argument("--intervals", type=int, default=10, help="of a clip")
    parser.add_argument("--views", type=int, default=500)
    options = parser.parse_args()
    paths = [path for folder in options.folders for path in sorted(folder.glob("*.bvh"))]
    step = max(1, len(paths) // options.clips)
    views, every = directions(options.views), []
    for path in paths[::step][: options.clips]:
        own = ratios(read_bvh(path).motion, path.name, options.intervals, views)
        every += own
        print(f"{path.name:32s} {len(own):3d} intervals  mean {np.mean(own or [1.0]):.2f}")
    good = float(np.mean(np.array(every) >= TARGET))
    print(f"{len(every)} intervals: mean {np.mean(every):.3f}, smallest {min(every):.2f},")
    print(f"{100.0 * good:.1f} % show at least {TARGET:.0%} of the best of {options.views} views")
    return 0 if np.mean(every) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
