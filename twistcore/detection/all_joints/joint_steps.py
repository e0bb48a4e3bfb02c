"""Find spikes and jumps of joints about any axis.

In a *spike*, the rotation of a joint leaves its path for one or a few frames and then returns. The
path is interpolated between the frame before and the frame after the spike. A *jump* is a large
rotation from one frame to the next between calm frames. Spikes and jumps are compared with the
motion of the same joint over as many frames nearby, so that fast motion is not mistaken for either.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.medians import medians
from twistcore.skeleton.rotation import Array, multiply, vector_lengths

Mask = NDArray[np.bool_]
Index = NDArray[np.intp]

LONGEST, MOST = 0.03, 3  # maximum length of a spike in seconds and in frames, but at least 2 frames
_SLOW = 45.0  # below this frame rate, one frame is weak evidence
# The smallest spike and jump in degrees: in general, at a low frame rate, for toes and fingers.
SPIKE, SPIKE_SLOW, SPIKE_SMALL = 10.0, 20.0, 35.0
JUMP, JUMP_SLOW, JUMP_SMALL = 30.0, 45.0, 60.0
# The joint returns after a spike if the rotations before and after it differ by at most the
# share _BACK of the spike. It hardly returns if they differ by at most the share _NEARLY.
_BACK, _NEARLY = 0.4, 1.0
# Minimum ratio of a spike to the usual angle from the path nearby, and the same if the joint hardly
# returns.
_TIMES, _CLEARLY = 8.0, 20.0
_FLOOR = 0.3  # degrees; the usual motion of a joint is assumed to be at least this large
_CALM = 3.0  # minimum ratio of a jump to the largest rotation nearby
_REACH, _NEAR = 10, 3  # number of frames on either side with which a spike and a jump are compared
# Relative to each of the _ABOVE joints above, at least this share of a spike or jump must remain.
_ALONE, _ABOVE = 0.5, 3
_EDGE = 3  # number of frames at each end of a clip that are not examined
_TOGETHER = 2048  # number of candidates in a block


@dataclass(frozen=True)
class JointStep:
    """A spike or a jump of a joint in frames [start, stop).

    Attributes
    ----------
    degrees
        In a spike, the angle between the rotation and its interpolated path. In a jump, the angle
        by which the joint rotates.
    usual
        The usual value of this angle nearby, in degrees.
    """

    joint: int
    start: int
    stop: int
    degrees: float
    usual: float


@dataclass(frozen=True)
class StepLimits:
    """The minimum sizes of the spikes and jumps to report.

    Attributes
    ----------
    spike, jump
        The minimum spike and the minimum jump of each joint, degrees, shape (joints,).
    longest
        The maximum length of a spike, in frames.
    floor
        The minimum value that is assumed for the usual motion of a joint, in degrees.
    """

    spike: Array
    jump: Array
    longest: int
    floor: float = _FLOOR

    @staticmethod
    def of(joints: int, fps: float, small: set[int], angle_step: float = 0.0) -> StepLimits:
        """Return the limits for a clip.

        Parameters
        ----------
        joints
            The number of joints.
        fps
            The frame rate.
        small
            The indices of the toe and finger joints, which have higher limits.
        angle_step
            The rounding step of the angles in the file, degrees.
        """
        slow = fps < _SLOW
        spike = np.full(joints, SPIKE_SLOW if slow else SPIKE)
        jump = np.full(joints, JUMP_SLOW if slow else JUMP)
        at = sorted(small)
        spike[at], jump[at] = SPIKE_SMALL, JUMP_SMALL
        longest = min(max(2, int(LONGEST * fps + 1e-6)), MOST)
        return StepLimits(spike, jump, longest, max(_FLOOR, 2.0 * angle_step))


def step_search_margin_frames(limits: StepLimits) -> int:
    """Return the number of additional frames on each side that are needed to examine a block."""
    return _REACH + limits.longest + 2


def spikes(rotations: Array, parents: Index, counted: Mask, limits: StepLimits) -> list[JointStep]:
    """Return the spikes of all joints, sorted by start.

    Parameters
    ----------
    rotations
        Local rotations, shape (frames, joints, 4).
    parents
        The index of the parent of each joint, −1 for a root.
    counted
        Mask of the frames in which a spike may begin, shape (frames,).
    limits
        The minimum spikes to report.
    """
    found: list[JointStep] = []
    moves = _steps_over(rotations, 0.5 * limits.spike)
    frames = len(rotations)
    for n in range(1, limits.longest + 1):
        both = np.zeros_like(moves)
        both[: frames - n] = moves[: frames - n] & moves[n:]
        both &= counted[:, None]
        both[: _EDGE + 1] = False
        both[max(frames - n - _EDGE, 0) :] = False
        start, joint = np.nonzero(both)
        for k in range(0, len(start), _TOGETHER):
            at = start[k : k + _TOGETHER], joint[k : k + _TOGETHER]
            found += _spikes_at(rotations, parents, *at, n, limits)
    return _without_overlaps(found)


def joint_step_degrees(rotations: Array, step: JointStep, *, jump: bool = False) -> float:
    """Return the angle of a spike or jump, measured in the given rotations, in degrees.

    Parameters
    ----------
    rotations
        Local rotations, shape (frames, joints, 4).
    step
        The spike or jump, with frame numbers relative to these rotations.
    jump
        True for a jump, False for a spike.
    """
    own = rotations[:, step.joint]
    at = np.array([step.start])
    if jump:
        return float(_angle(own[at - 1], own[at])[0])
    return float(_departure(lambda t: own[t], at, step.stop - step.start)[0])


def _spikes_at(
    q: Array, parents: Index, start: Index, joint: Index, n: int, limits: StepLimits
) -> list[JointStep]:
    """Return the candidates that are spikes of n frames.

    `start` and `joint` contain the first frame and the joint of each candidate.
    """

    def own(t: Index) -> Array:
        return q[t, joint]

    off = _departure(own, start, n)
    back = _angle(own(start - 1), own(start + n))
    keep = (off >= limits.spike[joint]) & (back <= _NEARLY * off)
    if not keep.any():
        return []
    start, joint, off, back = start[keep], joint[keep], off[keep], back[keep]
    usual = np.maximum(_usual(q, start, joint, n), limits.floor)
    keep = off >= _least_spike(off, back, usual)
    for depth in range(1, _ABOVE + 1):

        def above(t: Index, depth: int = depth) -> Array:
            return _in_frame_above(q, parents, t, joint, depth)

        keep &= _departure(above, start, n) >= _ALONE * off
    rows = zip(joint[keep], start[keep], off[keep], usual[keep], strict=True)
    return [JointStep(int(j), int(s), int(s) + n, float(d), float(u)) for j, s, d, u in rows]


def jumps(rotations: Array, parents: Index, counted: Mask, limits: StepLimits) -> list[JointStep]:
    """Return the jumps of all joints, sorted by start.

    The parameters have the same meaning as in :func:`spikes`.
    """
    moves = _steps_over(rotations, limits.jump)
    moves &= counted[:, None]
    moves[: _EDGE + 1] = False
    moves[max(len(moves) - _EDGE, 0) :] = False
    start, joint = np.nonzero(moves)
    found: list[JointStep] = []
    for k in range(0, len(start), _TOGETHER):
        found += _jumps_at(
            rotations, parents, start[k : k + _TOGETHER], joint[k : k + _TOGETHER], limits
        )
    return sorted(found, key=lambda s: (s.start, s.joint))


def _jumps_at(
    q: Array, parents: Index, start: Index, joint: Index, limits: StepLimits
) -> list[JointStep]:
    step = _angle(q[start - 1, joint], q[start, joint])
    near = _turns_near(q, start, joint)
    usual = np.maximum(medians(near, axis=0), limits.floor)
    keep = step >= _least_jump(near, usual)
    for depth in range(1, _ABOVE + 1):
        before, after = (_in_frame_above(q, parents, t, joint, depth) for t in (start - 1, start))
        keep &= _angle(before, after) >= _ALONE * step
    rows = zip(joint[keep], start[keep], step[keep], usual[keep], strict=True)
    return [JointStep(int(j), int(s), int(s) + 1, float(d), float(u)) for j, s, d, u in rows]


def _least_spike(off: Array, back: Array, usual: Array) -> Array:
    """Return the minimum angle from the path at which each candidate is a spike, in degrees.

    The limits in :class:`StepLimits` apply as well. `off` contains the angles of the candidates
    from their paths, `back` the angles between the rotations before and after them, and `usual` the
    usual angles from the path nearby, all in degrees.
    """
    return np.asarray(np.where(back <= _BACK * off, _TIMES, _CLEARLY) * usual)


def _turns_near(q: Array, start: Index, joint: Index) -> Array:
    """Return the rotations of joints in the frames near n jumps, in degrees, (frames, n)."""
    around = [k for k in range(-_NEAR, _NEAR + 1) if k]
    at = np.clip(start + np.array(around)[:, None], 1, len(q) - 1)
    return _angle(q[at - 1, joint], q[at, joint])


def _least_jump(near: Array, usual: Array) -> Array:
    """Return the minimum rotation at which each candidate is a jump, in degrees, (n,).

    The limits in :class:`StepLimits` apply as well. `near` contains the rotations in the frames
    around the n candidates, (frames, n), and `usual` their medians, both in degrees.
    """
    return np.asarray(np.maximum(_TIMES * usual, _CALM * near.max(axis=0)))


def path_deviation_and_spike_limit(
    rotations: Array, joint: int, start: int, stop: int, limits: StepLimits
) -> tuple[Array, float]:
    """Return a joint's angle from its path, (frames,), and the minimum angle that is a spike.

    Both are in degrees. In the frames [start, stop) of a spike, the path is interpolated from the
    frame before the spike to the frame after it. In every other frame, the path is interpolated
    over as many frames around this frame.
    """
    own, frames = rotations[:, joint], len(rotations)
    n = min(stop - start, limits.longest)  # an interval that a person made may have any length
    middle, t = n // 2, np.arange(frames)
    before, behind = np.maximum(t - middle - 1, 0), np.minimum(t + n - middle, frames - 1)
    off = _angle(own, _between(own[before], own[behind], (middle + 1) / (n + 1)))
    ends = own[max(start - 1, 0)], own[min(stop, frames - 1)]
    share = np.arange(1, stop - start + 1)[:, None] / (stop - start + 1)
    off[start:stop] = _angle(own[start:stop], _between(*ends, share))
    at, one = np.array([start]), np.array([joint])
    usual = np.maximum(_usual(rotations, at, one, n), limits.floor)
    least = _least_spike(off[start:stop].min(keepdims=True), _angle(*ends), usual)
    return off, float(max(limits.spike[joint], least[0]))


def joint_rotation_and_jump_limit(
    rotations: Array, joint: int, start: int, limits: StepLimits
) -> tuple[Array, float]:
    """Return the rotation of a joint since the previous frame, (frames,), and the minimum jump.

    Both are in degrees. The minimum jump is the smallest rotation in frame `start` that is a jump.
    """
    own, one = rotations[:, joint], np.array([joint])
    turns = np.concatenate([[0.0], _angle(own[:-1], own[1:])])
    near = _turns_near(rotations, np.array([start]), one)
    usual = np.maximum(medians(near, axis=0), limits.floor)
    return turns, float(max(limits.jump[joint], _least_jump(near, usual)[0]))


def _in_frame_above(q: Array, parents: Index, t: Index, joint: Index, levels: int) -> Array:
    """Return the rotations of n joints in the coordinate systems of ancestors, (n, 4).

    Each result is the joint's rotation multiplied by the rotations of the `levels` joints above it.
    If there are fewer joints above it, all of them are used. `t` contains the frame for each joint.
    """
    turned, above = q[t, joint], parents[joint]
    for _ in range(levels):
        has = above >= 0
        turned = np.where(has[:, None], multiply(q[t, above], turned), turned)
        above = np.where(has, parents[above], -1)
    return turned


def _steps_over(rotations: Array, least: Array) -> Mask:
    """Return a mask of the large rotations since the previous frame, (frames, joints).

    `least` contains the limit for each joint in degrees, (joints,).
    """
    over = np.zeros(rotations.shape[:2], dtype=bool)
    cosine = np.einsum("tji,tji->tj", rotations[1:], rotations[:-1])
    over[1:] = np.abs(cosine) < np.cos(np.radians(0.5 * least))
    return over


def _departure(of: Callable[[Index], Array], start: Index, n: int) -> Array:
    """Return the smallest angle of each candidate from its path within n frames, in degrees.

    The path is interpolated from the frame before these n frames to the frame after them. `of` is a
    function that returns the rotations of the candidates in given frames, and `start` contains the
    first frame of each candidate.
    """
    before, behind = of(start - 1), of(start + n)
    every = [_angle(of(start + k), _between(before, behind, (k + 1) / (n + 1))) for k in range(n)]
    return np.asarray(np.min(every, axis=0))


def _usual(q: Array, start: Index, joint: Index, n: int) -> Array:
    """Return the median angle of joints from their paths over n frames near each candidate.

    The angles are in degrees. `start` and `joint` contain the first frame and the joint of each
    candidate.
    """
    ahead = np.arange(-_REACH, -n)[:, None] + start
    behind = np.arange(n + 1, _REACH + 1)[:, None] + start
    last = len(q) - n - 1
    ahead, behind = np.where(ahead < 1, behind, ahead), np.where(behind > last, ahead, behind)
    at = np.clip(np.concatenate([ahead, behind]), 1, last)
    middle = n // 2
    off = _angle(
        q[at + middle, joint],
        _between(q[at - 1, joint], q[at + n, joint], (middle + 1) / (n + 1)),
    )
    return medians(off, axis=0)


def _between(a: Array, b: Array, share: float | Array) -> Array:
    """Interpolate between rotations a and b, (…, 4), which must be close together.

    `share` is the fraction of the way from a to b, 0…1. The result has the shape (…, 4).
    """
    same = np.einsum("...i,...i->...", a, b)[..., None] >= 0.0
    sum_ = (1.0 - share) * a + share * np.where(same, b, -b)
    return np.asarray(sum_ / vector_lengths(sum_)[..., None])


def _angle(a: Array, b: Array) -> Array:
    """Return the angles between rotations a and b in degrees, (…, 4) → (…)."""
    cosine = np.abs(np.einsum("...i,...i->...", a, b))
    return np.asarray(np.degrees(2.0 * np.arccos(np.minimum(cosine, 1.0))))


def _without_overlaps(found: list[JointStep]) -> list[JointStep]:
    """Sort spikes by start, and omit spikes that overlap a larger spike of the same joint."""
    kept: dict[int, list[JointStep]] = {}
    for one in sorted(found, key=lambda s: -s.degrees):
        own = kept.setdefault(one.joint, [])
        if all(one.stop < o.start or o.stop < one.start for o in own):
            own.append(one)
    return sorted((s for own in kept.values() for s in own), key=lambda s: (s.start, s.joint))
