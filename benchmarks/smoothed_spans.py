"""Smooth spans in clean clips, and measure how many of them are found.

    python -m benchmarks.smoothed_spans FOLDER [--seed N] [--as-they-are]

In every clip, at 20, 30 and 120 frames per second, the components of the quaternions of 2-5 joints,
or of all joints, are smoothed for 1-2 s by a Gaussian with a σ from 0.05 to 0.4 s (BrokenAMASS
smooths all joints with 0.2 s). Only joints that move are smoothed. The output shows precision by
frame, recall by frame and by span, and the spans found in the original clips. With --as-they-are,
only the original clips are used, at their own frame rate.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from benchmarks.noise_bursts import RATES, at_rate
from twistcore.detection.smoothed_spans import smoothed_spans
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import continuous_quaternion_signs, normalise

SIGMAS = 0.05, 0.1, 0.2, 0.4  # seconds
_SHORTEST, _SLOWEST = 24, 15.0  # minimum number of frames of a clip, and minimum frame rate


def with_smoothed(
    motion: Motion, rng: np.random.Generator, sigma: float, *, everything: bool
) -> tuple[Motion, slice] | None:
    """Return the motion with a smoothed span, and the span, or None if the clip is too short.

    `sigma` is in seconds. `everything` is True to smooth all moving joints.
    """
    length = int(rng.uniform(1.0, 2.0) * motion.fps)
    if length >= motion.frames - 4:
        return None
    start = int(rng.integers(2, motion.frames - length - 1))
    moving = np.flatnonzero((motion.rotations != motion.rotations[0]).any(axis=(0, 2)))
    if not len(moving):
        return None
    some = rng.choice(moving, min(int(rng.integers(2, 6)), len(moving)), replace=False)
    joints, frames = moving if everything else some, slice(start, start + length)
    q = continuous_quaternion_signs(motion.rotations[:, joints])
    smooth = gaussian_filter1d(q, sigma * motion.fps, axis=0, mode="nearest")
    rotations = motion.rotations.copy()
    rotations[frames, joints] = normalise(smooth[frames])
    return motion.with_rotations(rotations), frames


def found_in(motion: Motion) -> NDArray[np.bool_]:
    """Return a mask of the frames in which smoothed spans are found, shape (frames,)."""
    mask = np.zeros(motion.frames, dtype=bool)
    for span in smoothed_spans(motion):
        mask[span.start : span.stop] = True
    return mask


def spans_in(mask: NDArray[np.bool_]) -> int:
    """Return the number of runs of consecutive True frames in a mask."""
    return int((np.diff(mask.astype(int), prepend=0) > 0).sum())


def measure(
    motion: Motion, rng: np.random.Generator, sigma: float, *, everything: bool
) -> Counter[str]:
    """Smooth a span in a clip and return the counts.

    The parameters are as in :func:`with_smoothed`.
    """
    made = with_smoothed(motion, rng, sigma, everything=everything)
    if made is None:
        return Counter()
    found, sound, truth = found_in(made[0]), found_in(motion), np.zeros(motion.frames, dtype=bool)
    truth[made[1]] = True
    return Counter(
        hit=int((found & truth).sum()),
        extra=int((found & ~truth & ~sound).sum()),
        missed=int((truth & ~found).sum()),
        spans=1,
        seen=int((found & truth).any()),
    )


def motions_of(folder: Path, fps: float | None) -> Iterator[tuple[str, Motion]]:
    """Yield the name and motion of every BVH that is long enough, at a frame rate.

    If `fps` is None, the clip's own frame rate is used.
    """
    for path in sorted(folder.rglob("*.bvh")):
        try:
            motion = read_clip(path).motion
        except TwistError:
            continue
        if fps is not None:
            motion = at_rate(motion, fps)
            if abs(motion.fps - fps) > 0.2 * fps:
                continue
        if motion.frames >= _SHORTEST and motion.fps >= _SLOWEST:
            yield path.name, motion


def main() -> None:
    """Measure every frame rate, number of joints and strength of smoothing."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--as-they-are", action="store_true", help="only the original clips")
    given = parser.parse_args()
    for fps in (None,) if given.as_they_are else RATES:
        motions = list(motions_of(given.folder, fps))
        minutes = sum(m.frames / m.fps for _, m in motions) / 60.0
        if not motions:
            continue
        false = sum(spans_in(found_in(m)) for _, m in motions)
        rate = "own rate" if fps is None else f"{fps:4.0f} Hz"
        print(f"{rate}: {false / minutes:.2f} spans per minute in {minutes:.1f} original minutes")
        if given.as_they_are:
            continue
        for everything in (False, True):
            for sigma in SIGMAS:
                total: Counter[str] = Counter()
                for name, motion in motions:
                    rng = np.random.default_rng([given.seed, *name.encode()])
                    total += measure(motion, rng, sigma, everything=everything)
                if not total["spans"]:
                    continue
                precision = total["hit"] / max(total["hit"] + total["extra"], 1)
                recall = total["hit"] / (total["hit"] + total["missed"])
                print(
                    f"  {'all' if everything else '2-5'} joints, σ {sigma:4.2f} s: "
                    f"precision {precision:.3f}, recall {recall:.3f}, "
                    f"{total['seen']} of {total['spans']} spans seen",
                    flush=True,
                )


if __name__ == "__main__":
    main()
