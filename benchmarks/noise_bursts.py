"""Inject noise bursts into clean clips, and measure detection and corrections.

    python -m benchmarks.noise_bursts FOLDER [--seed N]

In every clip, at 20, 30 and 120 frames per second, Gaussian noise of 0.05-0.1 is added to the
quaternion components of 2-5 joints for 1-2 s, as in BrokenAMASS. The output shows precision and
recall by frame, the bursts found in the original clips, and two numbers for the automatic
corrections of `refine`: corrections that overlap the burst, and frames changed outside it. Changes
that also occur without the burst are not counted.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import REPAIRED, ClipAnalysis, analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections
from twistcore.detection.noise_bursts import noise_bursts
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import normalise

RATES = 20.0, 30.0, 120.0


def at_rate(motion: Motion, fps: float) -> Motion:
    """Return every n-th frame of a motion, at about the given frame rate."""
    step = max(1, round(motion.fps / fps))
    return replace(
        motion,
        rotations=motion.rotations[::step],
        positions=motion.positions[::step],
        frame_time=motion.frame_time * step,
    )


def with_noise(motion: Motion, rng: np.random.Generator) -> tuple[Motion, slice] | None:
    """Return the motion with a burst, and the burst's frames, or None if the clip is too short."""
    length = int(rng.uniform(1.0, 2.0) * motion.fps)
    if length >= motion.frames - 4:
        return None
    start = int(rng.integers(2, motion.frames - length - 1))
    joints = rng.choice(len(motion.skeleton), int(rng.integers(2, 6)), replace=False)
    rotations, frames = motion.rotations.copy(), slice(start, start + length)
    noise = rng.normal(0.0, rng.uniform(0.05, 0.1), (length, len(joints), 4))
    rotations[frames, joints] = normalise(rotations[frames, joints] + noise)
    return motion.with_rotations(rotations), frames


def found_in(motion: Motion) -> np.ndarray:
    """Return a mask of the frames in which noise bursts are found, shape (frames,)."""
    mask = np.zeros(motion.frames, dtype=bool)
    for burst in noise_bursts(motion):
        mask[burst.start : burst.stop] = True
    return mask


def changed(clip: ClipAnalysis) -> list[tuple[str, int, int]]:
    """Return the chain and the frames of each automatic correction, as (chain, start, stop)."""
    return [(i.chain, i.start, i.stop) for i in automatic_corrections(clip.detect(kinds=REPAIRED))]


def measure(motion: Motion, rng: np.random.Generator, *, detect: bool) -> Counter[str]:
    """Return the counts for one clip. `detect` is True to count corrections as well."""
    sound = found_in(motion)
    count = Counter(false=int((np.diff(sound.astype(int), prepend=0) > 0).sum()))
    if (made := with_noise(motion, rng)) is None:
        return count
    noisy, frames = made
    found, truth = found_in(noisy), np.zeros(motion.frames, dtype=bool)
    truth[frames] = True
    count.update(hit=int((found & truth).sum()), extra=int((found & ~truth & ~sound).sum()))
    count.update(missed=int((truth & ~found).sum()), bursts=1)
    if detect:
        known = changed(analyse(motion))
        after = [one for one in changed(analyse(noisy)) if one not in known]
        before = {(c, t) for c, a, b in known for t in range(a, b)}
        count["inside"] = sum(a < frames.stop and frames.start < b for _, a, b in after)
        count["outside"] = len(
            {(c, t) for c, a, b in after for t in range(a, b) if not truth[t]} - before
        )
    return count


def main() -> None:
    """Measure the detection at every frame rate, and print the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only-find", action="store_true", help="without corrections")
    given = parser.parse_args()
    for fps in RATES:
        total: Counter[str] = Counter()
        minutes = 0.0
        for path in sorted(given.folder.rglob("*.bvh")):
            try:
                motion = at_rate(read_clip(path).motion, fps)
            except TwistError:
                continue
            if abs(motion.fps - fps) > 0.2 * fps:
                continue
            rng = np.random.default_rng([given.seed, *path.name.encode()])
            total += measure(motion, rng, detect=not given.only_find)
            minutes += motion.frames / motion.fps / 60.0
        if not total["bursts"]:
            continue
        precision = total["hit"] / max(total["hit"] + total["extra"], 1)
        recall = total["hit"] / (total["hit"] + total["missed"])
        print(
            f"{fps:4.0f} Hz: {total['bursts']} bursts, precision {precision:.3f}, "
            f"recall {recall:.3f}, "
            f"{total['false'] / minutes:.2f} per minute in {minutes:.1f} original minutes; "
            f"corrections inside {total['inside']}, frames outside {total['outside']}",
            flush=True,
        )


if __name__ == "__main__":
    main()
