"""Write the sample clip for the lesson on thresholds and carried rolls.

    python -m benchmarks.lesson_clip OUT.bvh

The right forearm of `assets/walk.bvh` gets white noise and three twist errors of 5°, 18° and 70°,
and the left thigh gets a carried roll of 60°.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Kind
from twistcore.formats.clip import write_clip
from twistcore.formats.reading import read_clip
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import exponential, multiply
from twistcore.synthesis import InjectedError, inject

ASSETS = Path(__file__).resolve().parent.parent / "assets"
NOISY, SIGMA, SEED = "RightForeArm", 0.4, 1  # degrees about each axis
TWISTS = ((60, 80, 5.0), (150, 175, -18.0), (260, 290, 70.0))  # frames [start, stop), degrees
ROLLED, ROLL = "LeftUpLeg", (92, 122, 60.0)


def lesson_motion(motion: Motion) -> Motion:
    """Return the walk with noise, three twist errors and a carried roll."""
    chains = {c.name: c for c in analyse(motion).chains}
    rotations, rng = motion.rotations.copy(), np.random.default_rng(SEED)
    for joint in (chains[NOISY].parent, chains[NOISY].child):
        noise = rng.normal(0.0, np.radians(SIGMA), (motion.frames, 3))
        rotations[:, joint] = multiply(rotations[:, joint], exponential(noise))
    errors = [
        InjectedError(NOISY, start, stop, np.radians(np.full(stop - start, degrees)))
        for start, stop, degrees in TWISTS
    ]
    start, stop, degrees = ROLL
    offset = np.radians(np.full(stop - start, degrees))
    errors.append(InjectedError(ROLLED, start, stop, offset, kind=Kind.CARRIED_ROLL, carried=True))
    return inject(motion.with_rotations(rotations), list(chains.values()), errors)


def main() -> None:
    """Write the clip to the path given on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    clip = read_clip(ASSETS / "walk.bvh")
    write_clip(clip, lesson_motion(clip.motion), parser.parse_args().out)


if __name__ == "__main__":
    main()
