"""Find a blend from a first pose, during which all joints follow the same course s(t) [Method].

A published clip often begins in a T-pose that is blended into the capture. Each joint moves from
its first rotation towards the capture, and at time t it has covered the fraction s(t) of the path.
The fraction is the same for all joints, in linear and in eased blends, and whether rotations or
channels are interpolated. At the beginning and the end of the blend, the acceleration of each joint
therefore points along the joint's path and is proportional to s″(t). Natural motion has no such
common course, so no s explains more than a small part of its accelerations.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array

SECONDS, FRAMES = 0.27, 8  # length of the longest blend, in seconds and at least in frames
# Lengths in frames that are tried. A blend of another length is found with the nearest of these.
LENGTHS = (2, 3, 5, 8, 12, 18, 25, 32, 45, 64)
TURNING = float(np.sin(0.5 * np.radians(1.0)))  # joints that turn less are ignored
FAR = float(np.sin(0.5 * np.radians(2.0)))  # a shorter path has no direction
# Minimum share of all joints that must turn. If nearly all are still, an error is not a blend.
LIVELY = 1.0 / 3.0
# A rotation is zero below AT_REST. The clip begins in a rest pose if this share of the turning
# joints begins with zero rotation.
AT_REST, RESTING = 1e-9, 0.4
# The largest share of a joint's acceleration that the course may leave unexplained (the median over
# the joints), and the smallest share of joints that must follow the course. A blend from a rest
# pose, in which hardly any capture begins, needs less evidence than a blend from any other pose.
FROM_REST, FROM_ANY = (0.6, 0.45), (0.2, 0.7)
EXPLAINED = 0.5  # a joint with a smaller unexplained share follows the course
UNDER, OVER = -0.1, 1.3  # limits of s, since a spline overshoots
# In a blend, s takes at least twice as long from BEGUN to NEARLY as from 0 to BEGUN. A later,
# faster rise is the end of an error.
BEGUN, NEARLY = 0.1, 0.9
KEEPING = 0.4  # minimum share of the joints that follow the course in a frame of the blend
LONGER_LAG = 8  # number of frames of a blend per additional frame of the second differences' lag
BEHIND = 6  # minimum number of captured frames after the blend


def count_held_frames(rotations: Array) -> int:
    """Return the number of frames directly after frame 0 that repeat the pose of frame 0.

    `rotations` has the shape (frames, joints, 4).
    """
    if len(rotations) < 2 or not np.array_equal(rotations[0], rotations[1]):
        return 0
    moved = (rotations != rotations[0]).any(axis=(1, 2))
    return int(moved.argmax()) - 1 if moved.any() else len(rotations) - 1


def trailing_rest_frames_of_rotations(rotations: Array, fps: float) -> int:
    """Return the number of frames at the end of a clip that repeat a rest pose or blend into it.

    `rotations` has the shape (frames, joints, 4).
    """
    held = count_held_frames(rotations[::-1])
    blended = leading_blend_end(rotations[::-1][held:], fps, from_rest=True)
    return held + blended if blended else 0


def leading_blend_end(rotations: Array, fps: float, *, from_rest: bool = False) -> int:
    """Return the first frame after a blend from frame 0, or 0 if there is no blend.

    `rotations` has the shape (frames, joints, 4). If `from_rest` is True, only a blend from a rest
    pose (in which many joints have zero rotation) is searched for.
    """
    longest = max(FRAMES, round(SECONDS * fps))
    q = rotations[: 2 * longest + 1].transpose(1, 0, 2)
    joints, frames, _ = q.shape
    still = np.abs(q[:, 0, 1:]).max(axis=1) < AT_REST
    if frames < LENGTHS[0] + BEHIND or (from_rest and still.sum() < RESTING * LIVELY * joints):
        return 0
    way = np.where(np.matmul(q, q[:, 0, :, None]) < 0.0, -q, q) - q[:, :1]
    turning = np.abs(way).max(axis=(1, 2)) > TURNING
    way, resting = way[turning], still[turning].sum() >= RESTING * turning.sum()
    if len(way) < LIVELY * joints or (from_rest and not resting):
        return 0
    least, share = FROM_REST if resting else FROM_ANY
    best = 0
    for length in LENGTHS:
        if length > longest or length > frames - BEHIND:
            break
        left = _unexplained_shares(way, length)
        if left is None:
            continue
        median = float(np.sort(left)[len(left) // 2])
        if median < least and (left < EXPLAINED).sum() >= share * len(way):
            best, least = length, median
    return _last_frame(way, best) if best else 0


def _unexplained_shares(way: Array, length: int) -> Array | None:
    """Return the share of each joint's acceleration that a blend does not explain, weighted by s″².

    `way` contains the differences from the first quaternion, shape (joints, frames, 4), and
    `length` is the length of the blend in frames. Joints that move little are omitted. The result
    is None if most joints move little, or if s does not look like a blend.
    """
    lag = 1 + length // LONGER_LAG
    shares, to, s = _course(way[:, : length + 1 + 2 * lag], length)
    if 2 * len(to) < len(way) or not _like_a_blend(s):
        return None
    given, left, bend = _accelerations(shares, to, s, lag)
    weight = bend * bend
    return np.asarray((left @ weight) / np.maximum(given @ weight, 1e-30))


def _like_a_blend(s: Array) -> bool:
    """Return True if s(t), (frames,), begins to rise early and takes several frames to reach 1."""
    begun, nearly = int((s > BEGUN).argmax()), int((s > NEARLY).argmax())
    return s.min() > UNDER and s.max() < OVER and 1 < nearly >= 3 * begun - 2 > 0


def _course(way: Array, length: int) -> tuple[Array, Array, Array]:
    """Return the paths of the joints that move far, the directions of these paths, and s(t).

    `way` contains the differences from the first quaternion, shape (joints, frames, 4). Each path
    is scaled so that the difference in frame `length` has length 1. The direction of this
    difference is also returned, shape (joints, 4). s is the median progress of the joints along
    their directions, shape (frames,).
    """
    to = way[:, length]
    far = np.sqrt(np.einsum("jc,jc->j", to, to))
    which = far > FAR
    far = far[which, None]
    to, shares = to[which] / far, way[which] / far[:, None]
    along = np.sort(np.matmul(shares, to[:, :, None])[..., 0], axis=0)
    return shares, to, along[len(along) // 2] if len(along) else np.zeros(way.shape[1])


def _accelerations(shares: Array, to: Array, s: Array, lag: int) -> tuple[Array, Array, Array]:
    """Return the squared accelerations, their squared residuals after fitting s″, and s″.

    The first two results have the shape (joints, n), and s″ has the shape (n,). The arguments are
    the results of :func:`_course` and the lag of the second differences. Frame 0 is not used.
    """
    bends, bend = _second_differences(shares[:, 1:], lag), _second_differences(s[None, 1:], lag)[0]
    rest = bends - bend[:, None] * to[:, None]
    given, left = (np.einsum("jtc,jtc->jt", a, a) for a in (bends, rest))
    return given, left, bend


def _second_differences(values: Array, lag: int) -> Array:
    """Return the second differences along axis 1 between values `lag` frames apart."""
    return np.asarray(values[:, 2 * lag :] - 2.0 * values[:, lag:-lag] + values[:, : -2 * lag])


def _last_frame(way: Array, length: int) -> int:
    """Return the last frame of a blend, which is the last in which enough joints follow s(t).

    `way` contains the differences from the first quaternion, shape (joints, frames, 4), and
    `length` is the approximate length of the blend in frames.
    """
    lag = 1 + length // LONGER_LAG
    shares, to, s = _course(way[:, : 2 * length + BEHIND], length)
    given, left, _ = _accelerations(shares, to, s, lag)
    keeping: NDArray[np.intp] = np.flatnonzero((left < EXPLAINED * given).mean(axis=0) >= KEEPING)
    return int(keeping[-1]) + 1 + lag if len(keeping) else length
