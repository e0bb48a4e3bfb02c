"""Measure jitter, speed, foot slide and jumps of the stored angles, for every joint.

The measures need no ground truth, and a high value does not prove an error. The module `figure`
measures a figure as a whole.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.quality.figure import CONTACT_MM, SLIDE_MM
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.errors import TwistError
from twistcore.formats.clip import Clip
from twistcore.formats.smpl.skeleton import metres_per_unit
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.joint_names import FEET, TOES
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.people import find_people, interpret_person_joint_names
from twistcore.skeleton.rotation import Array, conjugate, logarithm, multiply, vector_lengths

SLIDE_SPEED = 0.001 * SLIDE_MM / NETWORK_DT  # m/s; this is 20 mm between two frames at 25 Hz
_SHORTEST = 4  # number of frames that a third difference needs
_TALL = 1.75  # metres; height of a person, assumed if the length unit of a clip is unknown
_JUMP = 90.0  # degrees; an angle jumps if it changes by this much more than the joint rotates


@dataclass(frozen=True, eq=False)
class JointQuality:
    """Quality measures of every joint in every frame.

    Values are NaN where they are undefined, for example in a T-pose at the start of the clip.

    Attributes
    ----------
    jitter
        Magnitude of the third difference of the local rotation, degrees per frame³, shape (frames,
        joints). It is stored in the second of the four frames.
    speed
        Local angular speed since the previous frame, degrees/s, shape (frames, joints).
    excess
        Largest change of a stored angle since the previous frame, minus the angle by which the
        joint actually rotated, degrees, at least 0, shape (frames, joints).
    flipped
        True if the quaternion changes its hemisphere from the previous frame, shape (frames,
        joints).
    slide
        Horizontal speed of a foot joint while it is on the ground, m/s, shape (frames, joints).
    feet
        Indices of the foot joints.
    """

    jitter: Array
    speed: Array
    excess: Array
    flipped: NDArray[np.bool_]
    slide: Array
    feet: tuple[int, ...]

    @property
    def usual_jitter(self) -> Array:
        """The median jitter of each joint, degrees per frame³, (joints,).

        Unlike a mean, the median is not affected by the jumps at the edges of a twist error.
        """
        known = self.jitter[np.isfinite(self.jitter).all(axis=1)]
        if not len(known):
            return np.zeros(self.jitter.shape[1])
        return np.median(known, axis=0)

    @property
    def top_speed(self) -> Array:
        """The highest angular speed of each joint, degrees/s, (joints,)."""
        top: Array = np.nan_to_num(self.speed).max(axis=0)
        return top

    @property
    def jumps(self) -> NDArray[np.int64]:
        """The number of frames in which stored angles jump but the pose does not, (joints,).

        A jump is a change of an angle by more than 90°, or a change of a quaternion's hemisphere.
        """
        far = np.nan_to_num(self.excess) > _JUMP
        count: NDArray[np.int64] = (far | self.flipped).sum(axis=0)
        return count

    @property
    def slides(self) -> Array:
        """The percentage of frames in which each foot joint slides, (joints,); NaN for others."""
        share = 100.0 * (np.nan_to_num(self.slide) >= SLIDE_SPEED).mean(axis=0)
        out = np.full(share.shape, np.nan)
        out[list(self.feet)] = share[list(self.feet)]
        return out


def joint_quality(
    clip: Clip, positions: Array, up: int = 1, motion: Motion | None = None
) -> JointQuality:
    """Measure the quality of a clip's joints.

    Parameters
    ----------
    clip
        The clip. Jumps of the stored angles are measured in it.
    positions
        Global positions, in the file's unit, shape (frames, joints, 3). They are converted to
        metres if the unit is known or the skeleton looks like a CMU skeleton. If not, the figure is
        assumed to be 1.75 m tall.
    up
        Index of the axis that points up.
    motion
        The motion to measure, for example a tracked motion that has these positions. By default,
        the clip's motion.
    """
    motion = clip.motion if motion is None else motion
    frames, joints = positions.shape[:2]
    turn = np.full((frames, joints, 3), np.nan)
    q = motion.rotations
    first = count_leading_rest_frames(motion)
    turn[first + 1 :] = np.degrees(logarithm(multiply(q[first + 1 :], conjugate(q[first:-1]))))
    jitter = np.full((frames, joints), np.nan)
    if frames >= _SHORTEST:
        jitter[1:-2] = vector_lengths(np.diff(turn[1:], n=2, axis=0))
    flipped = np.zeros((frames, joints), dtype=np.bool_)
    flipped[first + 1 :] = np.einsum("tji,tji->tj", q[first + 1 :], q[first:-1]) < 0.0
    feet = ankle_and_toe_joints(motion.skeleton)
    slide = np.full((frames, joints), np.nan)
    scale = _metres(motion.skeleton)
    for joint in feet:
        slide[first:, joint] = _slide(scale * positions[first:, joint], motion.frame_time, up)
    return JointQuality(
        jitter=jitter,
        speed=vector_lengths(turn) / motion.frame_time,
        excess=np.maximum(_written_steps(clip, joints) - vector_lengths(turn), 0.0),
        flipped=flipped,
        slide=slide,
        feet=feet,
    )


def joint_accelerations(motion: Motion, positions: Array) -> Array:
    """Return the magnitude of the joints' accelerations at 25 Hz, m/s², (frames, joints).

    `positions` are global positions, in the motion's unit, shape (frames, joints, 3). The result is
    NaN in a T-pose at the start of the clip, and within 0.04 s of it or of the ends of the clip.
    """
    step = max(1, round(NETWORK_DT / motion.frame_time))
    out = np.full(positions.shape[:2], np.nan)
    own = positions[count_leading_rest_frames(motion) :]
    if len(own) > 2 * step:
        bent = own[2 * step :] - 2.0 * own[step:-step] + own[: -2 * step]
        seconds = step * motion.frame_time
        size = vector_lengths(bent) / seconds**2
        out[count_leading_rest_frames(motion) + step : len(out) - step] = (
            _metres(motion.skeleton) * size
        )
    return out


def ankle_and_toe_joints(skeleton: Skeleton) -> tuple[int, ...]:
    """Return the indices of the ankles and toes, found by their names."""
    stems = {*FEET, *TOES}
    return tuple(
        k
        for k, name in enumerate(interpret_person_joint_names(skeleton, find_people(skeleton)))
        if name.side and any(name.stem.startswith(stem) for stem in stems)
    )


def _slide(places: Array, dt: float, up: int) -> Array:
    """Return a joint's horizontal speed since the previous frame, m/s, (frames,).

    The result is NaN while the joint is in the air. `places` are positions in metres, (frames, 3).
    """
    height = places[:, up]
    low = height < np.percentile(height, 2.0) + 0.001 * CONTACT_MM
    level = np.delete(places, up, axis=1)
    speed = np.full(len(places), np.nan)
    speed[1:] = vector_lengths(np.diff(level, axis=0)) / dt
    speed[1:][~(low[1:] & low[:-1])] = np.nan
    return speed


def _metres(skeleton: Skeleton) -> float:
    try:
        return metres_per_unit(skeleton)
    except TwistError:
        return _TALL / skeleton.height


def _written_steps(clip: Clip, joints: int) -> Array:
    out = np.full((clip.frames, joints), np.nan)
    for joint in range(joints):
        angles = clip.angles(joint)
        if angles.shape[1]:
            out[1:, joint] = np.abs(np.diff(angles, axis=0)).max(axis=1)
    return out
