"""Draw spikes of single joints and inject them into a motion."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from twistcore.detection.all_joints.finders import limits_of
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, exponential, multiply, normalise

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
