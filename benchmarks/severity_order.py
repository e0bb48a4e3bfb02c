"""Compare the order of clips by severity with their order by a plain count of jumps.

    python -m benchmarks.severity_order FOLDER... [--first N]

For every clip in or below the folders, the severity is compared with the number of jumps per
second. A jump is a movement of a joint in a frame by more than 45° or 4 % of the figure's height,
and by more than four times the median of the two frames before and after. Such a count cannot see
errors that come and go gradually, so the severity of the sudden errors alone is compared as well:
of jumps, steps, spikes, flips, stretches and turned ends, and of intervals that begin or end with
at least 45°. The output shows Spearman's rank correlation over all clips and over clips in which
either value is above 0, and the first N clips in each order.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from benchmarks.real_corrections import clips_of
from twistcore.analysis.clip_analysis import Detection, analyse
from twistcore.analysis.clip_severity import measure_clip_severity, severity_of_intervals
from twistcore.detection import Interval, Kind
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle

SUDDEN = {
    *(Kind.LONE_JUMP, Kind.JOINT_JUMP, Kind.PLACE_JUMP, Kind.SPIKE, Kind.BODY_STEP),
    *(Kind.LIMB_FLIP, Kind.STRETCH, Kind.TURNED_END),
}
TURN, WAY, TIMES = 45.0, 0.04, 4.0  # degrees, share of the height, multiple of the neighbours


def jumps_a_second(motion: Motion) -> float:
    """Return the number of jumps per second of rotations, and of positions relative to the root."""
    if motion.frames < 6:
        return 0.0
    turns = np.degrees(geodesic_angle(motion.rotations[1:], motion.rotations[:-1]))
    places = forward_kinematics(motion)[1]
    ways = np.linalg.norm(np.diff(places - places[:, :1], axis=0), axis=2) / motion.skeleton.height
    seconds = motion.frames * motion.frame_time
    return float(stand_out(turns, TURN).sum() + stand_out(ways, WAY).sum()) / seconds


def stand_out(steps: np.ndarray, least: float) -> np.ndarray:
    """Return a mask of the steps that reach `least` and are much larger than their neighbours.

    The neighbours are the two steps before and the two after. `steps` has the shape (frames − 1,
    joints). The first two and the last two steps are left out, so the mask has the shape (frames −
    5, joints).
    """
    around = np.median([steps[:-4], steps[1:-3], steps[3:-1], steps[4:]], axis=0)
    here = steps[2:-2]
    mask: np.ndarray = (here >= least) & (here > TIMES * around)
    return mask


def sudden_severity(found: Detection) -> float:
    """Return the severity of the errors of a clip that come or go in a single frame, in degrees."""
    motion, of = found.analysis.motion, found.analysis.chain
    sudden = ((i, of(i.chain)) for i in found if is_sudden(i))
    return severity_of_intervals(sudden, motion.frames, motion.fps)


def is_sudden(interval: Interval) -> bool:
    """Return True if an error comes or goes in a single frame."""
    ends = np.degrees(np.abs(interval.offset[[0, -1]]))
    return interval.kind in SUDDEN or float(ends.max()) >= TURN


def main() -> None:
    """Compare both orders and print the results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--first", type=int, default=12)
    given = parser.parse_args()
    names, ours, sudden, plain = [], [], [], []
    for path in (p for folder in given.folders for p in clips_of(folder)):
        try:
            motion = read_clip(path).motion
            found = analyse(motion).detect()
            ours.append(measure_clip_severity(found))
            sudden.append(sudden_severity(found))
        except TwistError as error:
            print(f"left out: {error}")
            continue
        plain.append(jumps_a_second(motion))
        names.append("/".join(path.parts[-2:]))
    a, b = np.array(ours), np.array(plain)
    print(f"{len(names)} clips, {(a > 0.0).sum()} with a severity, {(b > 0.0).sum()} with jumps")
    for what, values in (("all errors", a), ("sudden errors", np.array(sudden))):
        some = (values > 0.0) | (b > 0.0)
        whole, part = spearmanr(values, b)[0], spearmanr(values[some], b[some])[0]
        print(f"Spearman, {what}: {whole:.2f}, of {some.sum()}: {part:.2f}")
    for title, values in (("by severity", a), ("by jumps", b)):
        print(f"{title}:")
        for k in np.argsort(-values)[: given.first]:
            print(f"  {names[k]:<60} {a[k]:8.2f}° {b[k]:8.3f} per second")


if __name__ == "__main__":
    main()
