"""Measure recall for injected spikes of joints, and count detections in the original clips.

    python -m benchmarks.joint_spikes FOLDER… [--rate HZ] [--seed N] [--first N]

For every clip below each folder, the output shows the spikes, joint jumps, place jumps and body
steps per minute found in the original. Then a spike is injected into a random joint every 30 to 60
frames. It counts as found if a spike or jump of this joint, or a body step, is detected in its
frames. A second number also counts spikes in whose frames a flip or counter-twist of that joint is
found, because a spike may happen to rotate the joint about the line of a limb.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from benchmarks.real_corrections import clips_of
from twistcore.analysis.clip_analysis import analyse
from twistcore.detection import Interval, Kind
from twistcore.detection.all_joints.finders import limits_of
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, exponential, multiply, normalise
from twistcore.synthesis.injection import clip_random_generator

OF_JOINTS = (Kind.SPIKE, Kind.JOINT_JUMP, Kind.PLACE_JUMP, Kind.BODY_STEP)
_FINDS = {*OF_JOINTS, Kind.LONE_JUMP}
_APART = 30  # number of frames between two spikes, so that each is surrounded by correct frames
_BORDER = 16  # number of frames at each end without a spike
_LARGEST = 120.0  # largest angle of a spike, degrees
_ABOVE = 1.5  # smallest angle, as a multiple of the smallest spike that is detected at the joint


@dataclass(frozen=True, eq=False)
class InjectedSpike:
    """An incorrect rotation of a joint that lasts a few frames.

    Attributes
    ----------
    joint
        Index of the joint.
    start, stop
        Frames [start, stop) of the spike.
    turn
        Rotation vector by which the joint is rotated, radians, shape (3,).
    """

    joint: int
    start: int
    stop: int
    turn: Array


def draw_spikes(
    motion: Motion, rng: np.random.Generator, most: int = 20
) -> tuple[InjectedSpike, ...]:
    """Draw spikes of random joints about random axes, sorted by start.

    A spike lasts from one frame to 0.03 s. Its angle is at most 120°, and at least 1.5 times the
    smallest spike that is detected at the joint. Joints without three rotation channels have no
    spikes.

    Parameters
    ----------
    motion
        The clean motion.
    rng
        The random generator.
    most
        Maximum number of spikes.
    """
    limits = limits_of(motion, find_chains(motion))
    joints = np.flatnonzero(limits.spike < _LARGEST)
    if not len(joints):
        return ()
    found: list[InjectedSpike] = []
    frame = _BORDER + int(rng.integers(_APART))
    while frame + limits.longest + _BORDER < motion.frames and len(found) < most:
        joint = int(rng.choice(joints))
        size = np.radians(rng.uniform(_ABOVE * limits.spike[joint], _LARGEST))
        turn = size * normalise(rng.standard_normal(3))
        stop = frame + int(rng.integers(1, limits.longest + 1))
        found.append(InjectedSpike(joint, frame, stop, turn))
        frame = stop + _APART + int(rng.integers(_APART))
    return tuple(found)


def inject_spikes(motion: Motion, spikes: Iterable[InjectedSpike]) -> Motion:
    """Return the motion with spikes added. A spike also moves all joints below its joint."""
    rotations = motion.rotations.copy()
    for spike in spikes:
        at = slice(spike.start, spike.stop)
        turned = multiply(rotations[at, spike.joint], exponential(spike.turn))
        rotations[at, spike.joint] = normalise(turned)
    return motion.with_rotations(rotations)


def at_rate(motion: Motion, fps: float) -> Motion:
    """Return every n-th frame of a motion, at the given frame rate or the nearest higher one."""
    step = max(1, int(motion.fps / fps + 1e-6))
    kept = motion.at(np.arange(0, motion.frames, step))
    return type(kept)(
        kept.skeleton,
        kept.rotations,
        kept.positioned,
        kept.positions,
        motion.frame_time * step,
        motion.angle_step,
    )


def is_other(spike: InjectedSpike, found: list[Interval], turned: dict[str, set[int]]) -> bool:
    """Return True if a twist error or flip of the joint is found in the frames of the spike.

    `turned` has the joints that each chain's correction rotates, keyed by chain name.
    """
    frames = spike.start, spike.stop
    return any((i.start, i.stop) == frames and spike.joint in turned[i.chain] for i in found)


def is_found(spike: InjectedSpike, found: list[Interval], names: tuple[str, ...]) -> bool:
    """Return True if a detection in the frames of the spike concerns its joint or the whole body.

    `names` are the names of all joints.
    """
    return any(
        i.start <= spike.stop
        and spike.start <= i.stop
        and (i.kind == Kind.BODY_STEP or i.joint == names[spike.joint])
        for i in found
    )


def measured(folder: Path, given: argparse.Namespace) -> str:
    """Measure the clips in a folder and return a line with the results.

    `given` are the options of the command.
    """
    sound: Counter[str] = Counter()
    minutes, drawn, hit, known_by_other, extra = 0.0, 0, 0, 0, 0
    missed: Counter[str] = Counter()
    for path in islice(clips_of(folder), given.first):
        try:
            motion = read_clip(path).motion
            if given.rate:
                motion = at_rate(motion, given.rate)
            before = list(analyse(motion).detect(kinds=_FINDS))
            spikes = draw_spikes(motion, clip_random_generator(given.seed, path.name))
            dirty = analyse(inject_spikes(motion, spikes))
            every = list(dirty.detect())
        except TwistError as error:
            print(f"left out: {error}")
            continue
        minutes += motion.duration / 60.0
        sound.update(i.kind for i in before if i.kind in OF_JOINTS)
        names = motion.skeleton.names
        after = [i for i in every if i.kind in _FINDS]
        good = [is_found(spike, after, names) for spike in spikes]
        turned = {c.name: set(c.changed_joints(motion.skeleton)) for c in dirty.chains_and_limbs}
        others = [i for i in every if i.repairable]
        known_by_other += sum(
            not ok and is_other(s, others, turned) for s, ok in zip(spikes, good, strict=True)
        )
        missed.update(names[s.joint] for s, ok in zip(spikes, good, strict=True) if not ok)
        drawn, hit = drawn + len(spikes), hit + sum(good)
        known = {(i.kind, i.joint, i.start) for i in before}
        new = [i for i in after if (i.kind, i.joint, i.start) not in known]
        extra += sum(not any(is_found(s, [i], names) for s in spikes) for i in new)
    per = ", ".join(f"{k} {n / minutes:.2f}" for k, n in sorted(sound.items())) or "none"
    return (
        f"{folder}: {minutes:.1f} min; without injection, a minute: {per} "
        f"(all {sum(sound.values()) / max(minutes, 1e-9):.2f}); injected {drawn}, found "
        f"{100.0 * hit / max(drawn, 1):.1f} %, with flips and counter-twists "
        f"{100.0 * (hit + known_by_other) / max(drawn, 1):.1f} %, others along with them {extra}; "
        f"missed {dict(missed.most_common(4))}"
    )


def main() -> None:
    """Measure every folder given on the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--rate", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=None)
    given = parser.parse_args()
    for folder in given.folders:
        print(measured(folder, given), flush=True)


if __name__ == "__main__":
    main()
