"""Measure recall for injected backward bends, and count detections in the original clips.

    python -m benchmarks.backward_bends FOLDER… [--seed N] [--list]

The first line for a folder shows the backward bends per minute found in the original clips, and the
number of knees and elbows with a known hinge. Then, for every size from 5° to 60°, each knee and
elbow is bent backward once, for 0.3-1.2 s, where the limb is nearly straight. The bend begins and
ends gradually, each in a quarter of this time. It counts as found if a detected backward bend of
the same joint overlaps it. Counter-twists and flips, which would explain some bends, are not
detected. --list also prints the detections in the original clips.
"""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

import numpy as np

from benchmarks.real_corrections import clips_of
from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.detection import Interval
from twistcore.detection.backward_bends import Hinge, find_backward_bends, hinge_of
from twistcore.detection.evidence import ChainSignals
from twistcore.detection.finding import KindSearch
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import multiply, normalise, quaternion_from_axis_angle, rotate
from twistcore.synthesis.injection import clip_random_generator

SIZES = 5, 10, 15, 20, 25, 30, 40, 50, 60  # degrees beyond the straight limb
_DRAWS = 12  # number of random places, of which the straightest is used
_BORDER = 0.25  # share of the bend's time in which it begins, and in which it ends


def hinges_of(clip: ClipAnalysis) -> list[tuple[Chain, Hinge | None]]:
    """Return the chain of each knee and elbow, with its hinge, or None if the hinge is unknown."""
    middle = {limb.child for limb in clip.limbs}
    chains = [c for c in clip.chains if c.child in middle and c.ends]
    return [(c, hinge_of(ChainSignals.of(clip.motion, c))) for c in chains]


def finds(clip: ClipAnalysis, motion: Motion) -> list[Interval]:
    """Return the backward bends in a motion.

    `clip` is the analysis of a clip with the same chains.
    """
    search = KindSearch(motion, clip.chains, clip.chains, named=clip.chains_and_limbs)
    return [one for own in find_backward_bends(search).values() for one in own]


def bent_backward(
    motion: Motion, chain: Chain, hinge: Hinge, degrees: float, rng: np.random.Generator
) -> tuple[Motion, int, int] | None:
    """Return the motion with the child of a chain bent backward for a while, and the bend's frames.

    `degrees` is the angle beyond the straight limb. The result is None if the clip is too short.
    """
    length = int(rng.uniform(0.3, 1.2) * motion.fps)
    if length < 4 or motion.frames < length + 8:
        return None
    starts = rng.integers(4, motion.frames - length - 3, _DRAWS).tolist()
    start = min(starts, key=lambda t: float(hinge.flexion[t : t + length].max()))
    frames = slice(start, start + length)
    t = np.arange(1, length + 1)
    ramp = np.clip(np.minimum(t, t[::-1]) / (_BORDER * length), 0.0, 1.0)
    shape = 0.5 - 0.5 * np.cos(np.pi * ramp)
    bones = rotate(motion.rotations[:, chain.child], np.broadcast_to(chain.arm, (motion.frames, 3)))
    axis = normalise(np.cross(chain.axis, bones).sum(axis=0))  # about which it usually bends
    turn = -np.radians(hinge.flexion[frames] + degrees) * shape
    back = quaternion_from_axis_angle(axis, turn)
    rotations = motion.rotations.copy()
    rotations[frames, chain.child] = multiply(back, rotations[frames, chain.child])
    return motion.with_rotations(rotations), start, start + length


def measure(folder: Path, given: argparse.Namespace) -> None:
    """Measure the clips in a folder and print the results. `given` are the options."""
    found, missed, others, depth = Counter(), Counter(), Counter(), Counter()
    sound, minutes, limbs, hinged = 0, 0.0, 0, 0
    for path in clips_of(folder):
        try:
            clip = analyse(read_clip(path))
            own = finds(clip, clip.motion)
        except TwistError:
            continue
        sound, minutes = sound + len(own), minutes + clip.motion.duration / 60.0
        if given.list:
            for one in own:
                print(f"  {path.name}: {one.joint} {one.start}-{one.stop} {one.angle_text(1)}")
        rng, hinges = clip_random_generator(given.seed, path.name), hinges_of(clip)
        limbs, hinged = limbs + len(hinges), hinged + sum(h is not None for _, h in hinges)
        known = {(one.joint, one.start) for one in own}
        for chain, hinge in hinges:
            if hinge is None:
                continue
            for degrees in SIZES:
                if (made := bent_backward(clip.motion, chain, hinge, degrees, rng)) is None:
                    continue
                bent, start, stop = made
                joint = bent.skeleton.names[chain.child]
                bends = finds(clip, bent)
                hits = [i for i in bends if i.joint == joint and i.start < stop and start < i.stop]
                (found if hits else missed)[degrees] += 1
                others[degrees] += sum(
                    i not in hits and (i.joint, i.start) not in known for i in bends
                )
                if hits:
                    depth[degrees] += abs(np.degrees(hits[0].residual) - degrees)
    print(
        f"{folder}: {sound / max(minutes, 1e-9):.2f} a minute in {minutes:.1f} minutes without "
        f"injection; hinges in {hinged} of {limbs} knees and elbows"
    )
    for degrees in SIZES:
        drawn = found[degrees] + missed[degrees]
        if drawn:
            print(
                f"  {degrees:>3}°: {found[degrees]} of {drawn} found "
                f"({100.0 * found[degrees] / drawn:.0f} %), off by "
                f"{depth[degrees] / max(found[degrees], 1):.1f}°, elsewhere {others[degrees]}"
            )


def main() -> None:
    """Measure every folder given on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--list", action="store_true")
    given = parser.parse_args()
    for folder in given.folders:
        measure(folder, given)


if __name__ == "__main__":
    main()
