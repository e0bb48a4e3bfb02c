"""Measure which errors tracking hides if it runs before detection.

    python -m benchmarks.quamo_before_detection CLIPS

Twist errors of a protocol are injected into every clip of a folder. Detection runs on the raw clip
and on the same clip after tracking with QuaMo's hand-tuned gains. An error counts as found if an
interval in its chain has an IoU of at least 0.5 with it, and as touched if they share a frame. An
interval that touches no error counts as "elsewhere". The share of repaired error frames (FSR)
[Choi26 §4.2.1] is measured after the correction. The raw clip is compared with the clean clip, and
the tracked clip with the tracked clean clip, so that the tracker's lag does not count. --both-ways
tracks in both directions of time instead of causally.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import detect
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection import Interval
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.quamo.track_clip import track_with_hand_gains
from twistcore.skeleton.chain import Chain, find_chains, uncorrectable_joints
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.synthesis import (
    SUCCESS,
    InjectedError,
    clip_random_generator,
    draw_errors,
    draw_targets,
    inject,
    parse_protocol,
    prepare_clean_motion_for_injection,
)

SIZES = (0.0, 15.0, 45.0, 90.0, 181.0)  # edges of the classes of error size, in degrees


@dataclass
class Count:
    """Counts over several clips.

    Attributes
    ----------
    found, errors
        Numbers of found and of all errors, by class of size.
    repaired, frames
        Numbers of repaired and of all error frames.
    touched
        Number of touched errors.
    intervals, elsewhere
        Numbers of all intervals, and of intervals that touch no error.
    """

    found: np.ndarray = field(default_factory=lambda: np.zeros(len(SIZES) - 1, dtype=int))
    errors: np.ndarray = field(default_factory=lambda: np.zeros(len(SIZES) - 1, dtype=int))
    repaired: int = 0
    frames: int = 0
    touched: int = 0
    intervals: int = 0
    elsewhere: int = 0

    def add(
        self,
        clean: Motion,
        dirty: Motion,
        refined: Motion,
        found: Sequence[Interval],
        errors: Sequence[InjectedError],
        chains: dict[str, Chain],
        size_of: Motion,
    ) -> None:
        """Add the counts of one clip.

        Parameters
        ----------
        clean
            The motion without errors, with which the corrected motion is compared.
        dirty, refined
            The motion with errors, and the motion after the correction.
        found
            The detected intervals.
        errors
            The injected errors.
        chains
            The chains, keyed by name.
        size_of
            The clean motion into which the errors were injected.
        """
        for error in errors:
            at = slice(error.start, error.stop)
            size = float(np.degrees(np.abs(error.offset).max()))
            bin_ = int(np.searchsorted(SIZES, size, side="right")) - 1
            self.errors[bin_] += 1
            self.found[bin_] += any(covers(i, error) for i in found if i.chain == error.chain)
            self.touched += any(touches(i, error) for i in found)
            parent = chains[error.chain].parent
            before = geodesic_angle(size_of.rotations[at, parent], dirty.rotations[at, parent])
            after = geodesic_angle(clean.rotations[at, parent], refined.rotations[at, parent])
            self.repaired += int((after <= SUCCESS * before).sum())
            self.frames += error.stop - error.start
        self.intervals += len(found)
        self.elsewhere += sum(not any(touches(i, e) for e in errors) for i in found)


def covers(interval: Interval, error: InjectedError) -> bool:
    """Return True if the IoU of interval and error is at least 0.5."""
    both = min(interval.stop, error.stop) - max(interval.start, error.start)
    union = max(interval.stop, error.stop) - min(interval.start, error.start)
    return both >= 0.5 * union


def touches(interval: Interval, error: InjectedError) -> bool:
    """Return True if interval and error are in the same chain and share a frame."""
    both = min(interval.stop, error.stop) - max(interval.start, error.start)
    return interval.chain == error.chain and both > 0


def main() -> None:
    """Inject errors, detect them in each order of steps, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("clips", type=Path, nargs="?", default=Path("assets"))
    parser.add_argument("--protocol", default="P0")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--both-ways", action="store_true")
    arguments = parser.parse_args()
    track = partial(track_with_hand_gains, causal=not arguments.both_ways)
    protocol = parse_protocol(arguments.protocol)
    raw, tracked, after = Count(), Count(), Count()
    paths = [
        p for p in clip_paths_in_folder(arguments.clips, suffixes=BVH) if "injected" not in p.stem
    ]
    for path in paths:
        motion = read_bvh(path).motion
        motion = motion.sliced(count_leading_rest_frames(motion), motion.frames)
        chains = [c for c in find_chains(motion) if not uncorrectable_joints(motion, c)]
        by_name = {c.name: c for c in chains}
        clean = prepare_clean_motion_for_injection(motion, chains, protocol)
        joints = np.arange(len(clean.skeleton))
        clean_tracked = track(clean, joints).motion
        for seed in range(arguments.seeds):
            rng = clip_random_generator(seed, path.name)
            targets = draw_targets(chains, rng, protocol)
            errors = draw_errors(clean, targets, rng, protocol)
            dirty = inject(clean, chains, errors)
            found = detect(dirty, chains)
            refined = refine(dirty, chains, found)
            raw.add(clean, dirty, refined, found, errors, by_name, clean)
            late = track(dirty, joints).motion
            late_found = detect(late, chains)
            repaired = refine(late, chains, late_found)
            tracked.add(clean_tracked, dirty, repaired, late_found, errors, by_name, clean)
            in_order = track(refined, joints).motion
            after.add(clean_tracked, dirty, in_order, found, errors, by_name, clean)
    print(
        f"{len(paths)} clips of {arguments.clips.resolve().name}, protocol {protocol.name}, "
        f"seeds 0–{arguments.seeds - 1}, {int(raw.errors.sum())} errors in {raw.frames} frames\n"
    )
    classes = [f"{a:g}–{b:g}°" for a, b in zip(SIZES[:-1], (*SIZES[1:-1], 180.0), strict=True)]
    print(
        "| order | found of all | "
        + " | ".join(classes)
        + " | touched | intervals | elsewhere | FSR |"
    )
    print("|---|---|" + "---|" * len(classes) + "---|---|---|---|")
    for name, count in (
        ("detect and refine the raw clip", raw),
        ("track, then detect and refine", tracked),
        ("detect, refine, then track", after),
    ):
        total = int(count.errors.sum())
        shares = [
            f"{100 * f / n:.1f} %" if n else "–"
            for f, n in zip(count.found, count.errors, strict=True)
        ]
        print(
            f"| {name} | {100 * count.found.sum() / max(total, 1):.1f} % | "
            + " | ".join(shares)
            + f" | {100 * count.touched / max(total, 1):.1f} % | {count.intervals}"
            + f" | {count.elsewhere} | {100 * count.repaired / max(count.frames, 1):.1f} % |"
        )


if __name__ == "__main__":
    main()
