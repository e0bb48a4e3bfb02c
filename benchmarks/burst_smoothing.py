"""Smooth injected noise bursts, and compare with a Butterworth filter over the whole clip.

    python -m benchmarks.burst_smoothing FOLDER… [--seeds N]

The bursts of `benchmarks.noise_bursts` are injected into every clip, at 20, 30 and 120 frames per
second. Then `quamo refine --where noisy` smooths the detected bursts, and a second-order
Butterworth filter at 3.5 Hz, run in both directions, smooths all frames of all joints. The output
shows

- the mean distance of the joints from the truth in mm, for a figure of 1.75 m, inside the burst and
  in all other frames,
- the number of bursts in which the smoothed motion is at least as close to the truth as the
  filtered motion, and
- the number of values changed outside the smoothed frames.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.noise_bursts import RATES, at_rate, with_noise
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.quamo.bursts import noise_burst_spans_to_smooth, smooth_noise_burst_spans
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import Array, normalise
from twistcore.study.quamo.rivals import (
    quaternion_filter_from_array_filter,
    zero_phase_butterworth_filter,
)

WAYS = ("input", "Butterworth", "smoothed bursts")
HEIGHT_MM, CUTOFF = 1750.0, 3.5


def distances(made: Motion, truth: Motion, inside: Array) -> tuple[float, float]:
    """Return the mean distances of joints inside and outside the burst, in mm.

    `inside` is a mask of the burst's frames.
    """
    scale = HEIGHT_MM / truth.skeleton.height
    apart = np.linalg.norm(forward_kinematics(made)[1] - forward_kinematics(truth)[1], axis=-1)
    return scale * float(apart[inside].mean()), scale * float(apart[~inside].mean())


def filtered(motion: Motion) -> Motion:
    """Return the motion with all rotations filtered forward and backward."""
    run = quaternion_filter_from_array_filter(zero_phase_butterworth_filter)
    q = run(motion.rotations, motion.frame_time, (2.0, CUTOFF))
    return motion.with_rotations(normalise(q))


def measured(motion: Motion, rng: np.random.Generator) -> tuple[Array, int] | None:
    """Inject a burst into a motion and smooth it.

    Returns the distances of each method, shape (methods, 2), and the number of values changed
    outside the smoothed frames, or None if the clip is too short.
    """
    if (made := with_noise(motion, rng)) is None:
        return None
    noisy, frames = made
    inside = np.zeros(motion.frames, dtype=bool)
    inside[frames] = True
    spans = noise_burst_spans_to_smooth(noisy)
    smooth = smooth_noise_burst_spans(noisy, spans)
    treated = np.zeros(motion.rotations.shape[:2], dtype=bool)
    for span in spans:
        treated[span.start : span.stop, span.joint] = True
    changed = (smooth.rotations != noisy.rotations).any(axis=-1)
    found = [distances(m, motion, inside) for m in (noisy, filtered(noisy), smooth)]
    return np.array(found), int((changed & ~treated).sum())


def main() -> None:
    """Measure the smoothing at every frame rate, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+", metavar="FOLDER")
    parser.add_argument("--seeds", type=int, default=3)
    given = parser.parse_args()
    paths = sorted(path for folder in given.folders for path in folder.rglob("*.bvh"))
    for fps in RATES:
        found = []
        for path in paths:
            try:
                motion = read_clip(path).motion
            except TwistError:
                continue
            motion = at_rate(motion.sliced(count_leading_rest_frames(motion), motion.frames), fps)
            if abs(motion.fps - fps) > 0.2 * fps:
                continue
            for seed in range(given.seeds):
                rng = np.random.default_rng([101 + seed, *path.name.encode()])
                if (one := measured(motion, rng)) is not None:
                    found.append(one)
        if not found:
            continue
        every = np.array([mm for mm, _ in found])
        better = int((every[:, 2, 0] <= every[:, 1, 0]).sum())
        print(f"{fps:g} Hz: {len(found)} bursts, {better} at most the filter's distance inside")
        for way, (inside, outside) in zip(WAYS, every.mean(axis=0), strict=True):
            print(f"  {way}: {inside:.2f} mm inside, {outside:.3f} mm in other frames")
        print(f"  numbers changed outside the treated frames: {sum(n for _, n in found)}")


if __name__ == "__main__":
    main()
