"""Jitter, speed, foot slide and jumps of the stored angles, for every joint.

The measures need no ground truth, and a high value is not proof of an error. For measures of the
whole figure, see the module `figure`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.quality.figure import CONTACT_MM, SLIDE_MM
from twistcore.detection.cuts import leading_frames
from twistcore.errors import TwistError
from twistcore.formats.clip import Clip
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.quamo.topology import metres_per_unit
from twistcore.skeleton.joint_names import FEET, TOES
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.people import find_people, joint_names
from twistcore.skeleton.rotation import Array, conjugate, logarithm, multiply

SLIDE_SPEED = 0.001 * SLIDE_MM / NETWORK_DT  # m/s: 20 mm between two frames at 25 Hz
_SHORTEST = 4  # frames needed for a third difference
_TALL = 1.75  # metres: height of a person, assumed if a clip does not give the length of its unit
_JUMP = 90.0  # degrees by which the change of a written angle exceeds the joint's turn in a jump


@dataclass(frozen=True, eq=False)
class JointQuality:
    """Quality measures of every joint over time, NaN where undefined, as in a T-pose at the start.

    - jitter: magnitude of the third difference of the local rotation, degrees per frame³, (frames,
      joints), at the second of the four frames
    - speed: local angular speed since the previous frame, degrees/s
    - excess: the largest change of an Euler angle, minus the joint's rotation since the
      previous frame, degrees ≥ 0
    - flipped: True if the quaternion of these angles is in a different hemisphere than in the
      previous frame
    - slide: horizontal speed of a foot's joint while it is on the ground, m/s
    - feet: the joints of the feet
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

        A median is not affected by the jumps at the edges of a twist error.
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
        """The number of frames, (joints,), in which stored angles jump but the pose does not.

        Jumps of an angle by more than 90° and quaternions that change hemisphere are counted.
        """
        far = np.nan_to_num(self.excess) > _JUMP
        count: NDArray[np.int64] = (far | self.flipped).sum(axis=0)
        return count

    @property
    def slides(self) -> Array:
        """The percentage of frames in which a joint slides, (joints,), NaN outside the feet."""
        share = 100.0 * (np.nan_to_num(self.slide) >= SLIDE_SPEED).mean(axis=0)
        out = np.full(share.shape, np.nan)
        out[list(self.feet)] = share[list(self.feet)]
        return out


def joint_quality(
    clip: Clip, positions: Array, up: int = 1, motion: Motion | None = None
) -> JointQuality:
    """Return the quality measures of a clip's joints.

    `positions` are global positions with shape (frames, joints, 3), in the file's unit. `up` is the
    axis that points up. Lengths are in metres if the unit is known or the skeleton looks like one
    of CMU's; if not, they are scaled to a height of 1.75 m. `motion` is measured instead of the
    clip's own motion, for example a tracked one with these positions; jumps of the stored angles
    are still measured in the clip.
    """
    motion = clip.motion if motion is None else motion
    frames, joints = positions.shape[:2]
    turn = np.full((frames, joints, 3), np.nan)
    q = motion.rotations
    first = leading_frames(motion)
    turn[first + 1 :] = np.degrees(logarithm(multiply(q[first + 1 :], conjugate(q[first:-1]))))
    jitter = np.full((frames, joints), np.nan)
    if frames >= _SHORTEST:
        jitter[1:-2] = np.linalg.norm(np.diff(turn[1:], n=2, axis=0), axis=-1)
    flipped = np.zeros((frames, joints), dtype=np.bool_)
    flipped[first + 1 :] = np.einsum("tji,tji->tj", q[first + 1 :], q[first:-1]) < 0.0
    feet = foot_joints(motion.skeleton)
    slide = np.full((frames, joints), np.nan)
    scale = _metres(motion.skeleton)
    for joint in feet:
        slide[first:, joint] = _slide(scale * positions[first:, joint], motion.frame_time, up)
    return JointQuality(
        jitter=jitter,
        speed=np.linalg.norm(turn, axis=-1) / motion.frame_time,
        excess=np.maximum(_written_steps(clip, joints) - np.linalg.norm(turn, axis=-1), 0.0),
        flipped=flipped,
        slide=slide,
        feet=feet,
    )


def joint_accelerations(motion: Motion, positions: Array) -> Array:
    """Return the magnitude of the joints' accelerations at 25 Hz, (frames, joints), in m/s².

    `positions` are global positions with shape (frames, joints, 3), in the motion's unit. The
    acceleration is NaN within 0.04 s of an end of the clip or of a T-pose at its start.
    """
    step = max(1, round(NETWORK_DT / motion.frame_time))
    out = np.full(positions.shape[:2], np.nan)
    own = positions[leading_frames(motion) :]
    if len(own) > 2 * step:
        bent = own[2 * step :] - 2.0 * own[step:-step] + own[: -2 * step]
        seconds = step * motion.frame_time
        size = np.linalg.norm(bent, axis=-1) / seconds**2
        out[leading_frames(motion) + step : len(out) - step] = _metres(motion.skeleton) * size
    return out


def foot_joints(skeleton: Skeleton) -> tuple[int, ...]:
    """Return the joints of ankles and toes, recognised by their names."""
    stems = {*FEET, *TOES}
    return tuple(
        k
        for k, name in enumerate(joint_names(skeleton, find_people(skeleton)))
        if name.side and any(name.stem.startswith(stem) for stem in stems)
    )


def _slide(places: Array, dt: float, up: int) -> Array:
    """Return a joint's horizontal speed since the previous frame, m/s, (frames,).

    The speed is NaN while the joint is in the air.
    """
    height = places[:, up]
    low = height < np.percentile(height, 2.0) + 0.001 * CONTACT_MM
    level = np.delete(places, up, axis=1)
    speed = np.full(len(places), np.nan)
    speed[1:] = np.linalg.norm(np.diff(level, axis=0), axis=1) / dt
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
