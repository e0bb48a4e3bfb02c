"""Find impossible limb motion from the global positions and orientations of joints.

The judge :mod:`benchmarks.real_flips` uses this geometry, but the detectors do not.
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

FASTEST = 7500.0  # degrees per second: no segment of a body turns faster about its own axis
LEAST, LEAST_SLOW, SLOW = (
    60.0,
    120.0,
    50.0,
)  # degrees per frame; LEAST_SLOW applies below SLOW frames per second
BENT = 0.05  # of the limb's length: distance of C from the line
STILL = 0.12  # of the limb's length: motion of E relative to P in a frame
BACKWARD = 110.0  # degrees from the limb's own side
FIRST = 2  # the first frame examined for a jump
ALIKE = 0.3  # of the longer bone: least length of the shorter one, without known names
TINY = 1e-12


@dataclass(frozen=True)
class Limb:
    """Indices of a limb's joints: hip, knee and ankle, or shoulder, elbow and wrist.

    leg: True if the limb is a leg according to its name.
    """

    name: str
    p: int
    c: int
    e: int
    leg: bool


@dataclass(frozen=True)
class Jump:
    """A rotation of a limb or joint by `degrees` from the previous frame to `frame`."""

    of: str
    frame: int
    degrees: float


@dataclass(frozen=True)
class Pose:
    """A motion in world coordinates.

    Orientations have the shape (frames, joints, 3, 3), and positions (frames, joints, 3).
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
    """Find arms and legs by name.

    If no name is known, find chains of two bones of similar length.
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
    """Return the angles, in degrees, by which `side` turned about `line` since the previous frame.

    `line` has directions, (frames, 3), and `side` directions perpendicular to them. The result is
    (frames,), with 0 in the first frame. The previous side is first rotated by the smallest
    rotation from the previous line to the current one.
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

    Both have the shape (frames, 3).
    """
    line = unit(e)
    return line, c - _dot(c, line)[:, None] * line


def most(fps: float) -> float:
    """Return the largest angle, in degrees, that a body segment can turn in one frame."""
    return LEAST_SLOW if fps < SLOW else max(LEAST, FASTEST / fps)


def swivels(world: Pose, limb: Limb) -> list[Jump]:
    """Return the jumps of a limb's swivel that are too fast for a body."""
    c, e, length = _from_p(world, limb)
    line, side = off_line(c, e)
    bent = _length(side) > BENT * length
    bent[1:] &= bent[:-1]
    still = np.zeros(len(c), dtype=np.bool_)
    still[1:] = _length(np.diff(e, axis=0)) < STILL * length
    return _jumps(limb.name, turns(line, side), world.motion.fps, bent & still)


def own_side(world: Pose, limb: Limb) -> Array:
    """Return the median direction from the limb's line to C in the frame of P's parent, (3,).

    To exclude flips, the median is repeated over the frames that agree with the previous one.
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
    """Return the frames in which C is on the wrong side of the limb.

    `own` is the usual side, the result of :func:`own_side`.
    """
    line, side, length = _in_parent(world, limb)
    ahead = own - (line @ own)[:, None] * line
    across = np.abs(_dot(np.cross(ahead, side), line))
    off = np.degrees(np.arctan2(across, _dot(ahead, side)))
    wrong = (off > BACKWARD) & (_length(side) > BENT * length)
    return np.flatnonzero(wrong).tolist()


def spins(world: Pose, limbs: Iterable[Limb]) -> list[Jump]:
    """Return impossible rotations of joints about their bones.

    Only the limbs' first joints and all joints below them are examined.
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
    """Return the joints' largest displacement as a share of the height.

    The result is 0 if rounding can explain the displacement. Rounding turns each joint above by at
    most half of the last decimal in each of its three channels.
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
    """Return vectors (…, 3) scaled to length 1."""
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), TINY)


def _from_p(world: Pose, limb: Limb) -> tuple[Array, Array, float]:
    """Return C and E relative to P in world coordinates, and the length of the limb."""
    c, e = (world.at[:, j] - world.at[:, limb.p] for j in (limb.c, limb.e))
    return c, e, float((_length(c) + _length(e - c)).mean())


def _in_parent(world: Pose, limb: Limb) -> tuple[Array, Array, float]:
    """Return the direction of the line, the side of C and the limb's length.

    The directions are in the frame of P's parent.
    """
    c, e, length = _from_p(world, limb)
    parent = int(world.motion.skeleton.parents[limb.p])
    if parent >= 0:
        c, e = (np.einsum("fji,fj->fi", world.turned[:, parent], v) for v in (c, e))
    return (*off_line(c, e), length)


def _bone(motion: Motion, joint: int) -> Array | None:
    """Return the direction of a joint's bone in the joint's frame, (frames, 3), or None."""
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
