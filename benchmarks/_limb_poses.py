"""Find impossible limb motion from the global positions and orientations of joints.

A limb's joints are called P, C and E: hip, knee and ankle, or shoulder, elbow and wrist. The
benchmark :mod:`benchmarks.real_flips` uses this module, which does not use any code of the
detectors.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import Motion, forward_kinematics

Array = NDArray[np.float64]

FASTEST = 7500.0  # degrees per second, faster than any body segment turns about its own axis
LEAST, LEAST_SLOW, SLOW = (
    60.0,
    120.0,
    50.0,
)  # degrees per frame; LEAST_SLOW applies below SLOW frames per second
BENT = 0.05  # minimum distance of C from the line P-E in a bent limb, as a share of its length
STILL = 0.12  # maximum motion of E relative to P in a frame, as a share of the limb's length
BACKWARD = 110.0  # minimum angle in degrees from the limb's usual side
FIRST = 2  # the first frame examined for a jump
ALIKE = 0.3  # minimum ratio of the bones' lengths in a limb without known names
TINY = 1e-12


@dataclass(frozen=True)
class Limb:
    """The joints of an arm or leg.

    Attributes
    ----------
    name
        Name of the first joint.
    p, c, e
        Indices of hip, knee and ankle, or of shoulder, elbow and wrist.
    leg
        True if the limb is a leg according to its name.
    """

    name: str
    p: int
    c: int
    e: int
    leg: bool


@dataclass(frozen=True)
class Jump:
    """A rotation of a limb or joint in one frame.

    Attributes
    ----------
    of
        Name of the limb or joint.
    frame
        The frame after the rotation.
    degrees
        The angle.
    """

    of: str
    frame: int
    degrees: float


@dataclass(frozen=True)
class Pose:
    """A motion in world coordinates.

    Attributes
    ----------
    motion
        The motion.
    turned
        Orientations of the joints, rotation matrices of shape (frames, joints, 3, 3).
    at
        Positions of the joints, shape (frames, joints, 3).
    """

    motion: Motion
    turned: Array
    at: Array


def pose(motion: Motion) -> Pose:
    """Return the global orientations and positions of a motion."""
    q, at = forward_kinematics(motion)
    matrices = Rotation.from_quat(q[..., [1, 2, 3, 0]].reshape(-1, 4)).as_matrix()
    return Pose(motion, matrices.reshape(*q.shape[:2], 3, 3), at)


def find(motion: Motion) -> tuple[Limb, ...]:
    """Find the arms and legs of a skeleton by name.

    If no name is known, every two consecutive bones of similar length count as a limb.
    """
    names = motion.skeleton.names
    chains = find_chains(motion)
    real = [c for c in chains if c.grandchild >= 0]
    limbs = [
        Limb(names[c.parent], c.parent, c.child, c.grandchild, c.segment == "UpLeg") for c in real
    ]
    if any(c.segment for c in chains):
        named = [c.segment in ("Arm", "UpLeg") for c in real]
        return tuple(limb for limb, is_one in zip(limbs, named, strict=True) if is_one)
    at = forward_kinematics(motion)[1]
    found = []
    for limb in limbs:
        bones = [
            _length(at[:, b] - at[:, a]).mean() for a, b in ((limb.p, limb.c), (limb.c, limb.e))
        ]
        if min(bones) >= ALIKE * max(bones):
            found.append(limb)
    return tuple(found)


def turns(line: Array, side: Array) -> Array:
    """Return the angle in degrees by which a direction rotates about a line in each frame.

    The previous direction is first rotated by the smallest rotation from the previous line to the
    current one.

    Parameters
    ----------
    line : array, shape (frames, 3)
        Unit directions of the line.
    side : array, shape (frames, 3)
        Directions perpendicular to the line.

    Returns
    -------
    array, shape (frames,)
        0 in the first frame.
    """
    a, b = line[:-1], line[1:]
    axis, cos = np.cross(a, b), _dot(a, b)
    before = side[:-1]
    along = before * cos[:, None] + np.cross(axis, before)
    along += axis * (_dot(axis, before) / np.maximum(1.0 + cos, TINY))[:, None]
    out = np.zeros(len(line))
    out[1:] = np.degrees(np.arctan2(_dot(np.cross(along, side[1:]), b), _dot(along, side[1:])))
    return out


def off_line(c: Array, e: Array) -> tuple[Array, Array]:
    """Return the direction from P to E, and the component of C perpendicular to it.

    `c` and `e` are the positions of C and E, the middle joint and the end of a limb, relative to
    its first joint P. All arrays have the shape (frames, 3).
    """
    line = unit(e)
    return line, c - _dot(c, line)[:, None] * line


def most(fps: float) -> float:
    """Return the largest angle, in degrees, by which a body segment can rotate in one frame."""
    return LEAST_SLOW if fps < SLOW else max(LEAST, FASTEST / fps)


def swivels(world: Pose, limb: Limb) -> list[Jump]:
    """Return the rotations of a limb that are too fast for a body.

    Only rotations about the line from the limb's first joint to its end are examined.
    """
    c, e, length = _from_p(world, limb)
    line, side = off_line(c, e)
    bent = _length(side) > BENT * length
    bent[1:] &= bent[:-1]
    still = np.zeros(len(c), dtype=np.bool_)
    still[1:] = _length(np.diff(e, axis=0)) < STILL * length
    return _jumps(limb.name, turns(line, side), world.motion.fps, bent & still)


def own_side(world: Pose, limb: Limb) -> Array:
    """Return the usual side of a limb's middle joint C, shape (3,).

    This is the median direction from the line between the limb's first joint P and its end E to C.

    The direction is in the coordinates of P's parent. To exclude flips, the median is repeated over
    the frames that agree with the previous median.
    """
    _, side, _ = _in_parent(world, limb)
    side = unit(side)
    found = unit(np.median(side, axis=0))
    for _ in range(5):
        agrees = side @ found > 0.0
        if agrees.any():
            found = unit(np.median(side[agrees], axis=0))
    return found


def backward(world: Pose, limb: Limb, own: Array) -> list[int]:
    """Return the frames in which the middle joint is on the wrong side of the limb.

    `own` is the usual side, from :func:`own_side`.
    """
    line, side, length = _in_parent(world, limb)
    ahead = own - (line @ own)[:, None] * line
    across = np.abs(_dot(np.cross(ahead, side), line))
    off = np.degrees(np.arctan2(across, _dot(ahead, side)))
    wrong = (off > BACKWARD) & (_length(side) > BENT * length)
    return np.flatnonzero(wrong).tolist()


def spins(world: Pose, limbs: Iterable[Limb]) -> list[Jump]:
    """Return the rotations of joints about their own bones that are too fast for a body.

    Only the first joints of the limbs and all joints below them are examined.
    """
    skeleton = world.motion.skeleton
    below = {limb.p for limb in limbs}
    for joint, parent in enumerate(skeleton.parents.tolist()):
        if parent in below:
            below.add(joint)
    found = []
    everywhere = np.ones(world.motion.frames, dtype=np.bool_)
    for joint in sorted(below):
        bone = _bone(world.motion, joint)
        if bone is None:
            continue
        mean = unit(bone.mean(axis=0))
        across = np.cross(mean, np.eye(3)[int(np.argmin(np.abs(mean)))])
        across = across - _dot(bone, np.broadcast_to(across, bone.shape))[:, None] * bone
        line, side = (np.einsum("fij,fj->fi", world.turned[:, joint], v) for v in (bone, across))
        degrees = turns(line, side)
        found += _jumps(skeleton.names[joint], degrees, world.motion.fps, everywhere)
    return found


def moved(before: Pose, after: Pose, joints: Sequence[int], decimals: int) -> float:
    """Return the largest displacement of the given joints, as a share of the body height.

    The result is 0 if rounding to `decimals` can explain the displacement. Rounding rotates every
    joint above the given ones by at most half of the last decimal in each of its three channels.
    """
    parents, height = before.motion.skeleton.parents, before.motion.skeleton.height
    rounding = 1.5 * np.radians(10.0**-decimals)
    largest = 0.0
    for joint in joints:
        lever, above = np.zeros(before.motion.frames), int(parents[joint])
        while above >= 0:
            lever += _length(before.at[:, joint] - before.at[:, above])
            above = int(parents[above])
        distance = _length(after.at[:, joint] - before.at[:, joint])
        beyond = distance > rounding * lever + 1e-9 * height
        largest = max(largest, float(np.max(distance, where=beyond, initial=0.0)) / height)
    return largest


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("fi,fi->f", a, b)


def _length(v: Array) -> Array:
    return np.linalg.norm(v, axis=-1)


def unit(v: Array) -> Array:
    """Return vectors, shape (…, 3), scaled to length 1."""
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), TINY)


def _from_p(world: Pose, limb: Limb) -> tuple[Array, Array, float]:
    """Return C and E relative to P in world coordinates, (frames, 3), and the limb's length."""
    c, e = (world.at[:, j] - world.at[:, limb.p] for j in (limb.c, limb.e))
    return c, e, float((_length(c) + _length(e - c)).mean())


def _in_parent(world: Pose, limb: Limb) -> tuple[Array, Array, float]:
    """Return the direction from P to E, the side of C, and the limb's length.

    The directions have the shape (frames, 3) and are in the coordinates of P's parent.
    """
    c, e, length = _from_p(world, limb)
    parent = int(world.motion.skeleton.parents[limb.p])
    if parent >= 0:
        c, e = (np.einsum("fji,fj->fi", world.turned[:, parent], v) for v in (c, e))
    return (*off_line(c, e), length)


def _bone(motion: Motion, joint: int) -> Array | None:
    """Return the direction of a joint's bone in the joint's coordinates, (frames, 3), or None."""
    skeleton = motion.skeleton
    ends = [motion.translation(child) for child in skeleton.children[joint]]
    ends += [np.array(offset) for at, offset in skeleton.ends if at == joint]
    for end in ends:
        if _length(end).min() > 1e-6 * skeleton.height:
            return unit(np.broadcast_to(end, (motion.frames, 3)))
    return None


def _jumps(of: str, degrees: Array, fps: float, where: NDArray[np.bool_]) -> list[Jump]:
    wrong = (np.abs(degrees) > most(fps)) & where
    wrong[:FIRST] = False
    return [Jump(of, int(t), round(float(degrees[t]), 1)) for t in np.flatnonzero(wrong)]
