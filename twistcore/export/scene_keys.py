"""Compute animation keys for the scene from which a clip was exported.

The axes of a scene's joints depend on its importer, rig and bind pose, so the script measures them
in the scene. Let

- A be the rotation between the world axes of the clip and of the scene,
- G and S be the global rotations of a joint in the clip and in the scene, and
- G_above and S_above be those of its parent.

Then S = A·G·B with a constant rotation B. If the joint's local rotation in the clip is q, its local
rotation in the scene is PRE·q·POST, where PRE = S_above⁻¹·A·G_above and POST = G⁻¹·A⁻¹·S. These are
measured in reference frames, in which the joint is not corrected. To correct the joint to q', the
local rotation in the scene is multiplied on the right by POST⁻¹·q⁻¹·q'·POST.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import Array, geodesic_angle

MOST_REFERENCES = 5
_SAME = 1e-7  # radians; a global rotation that changes by less counts as unchanged


@dataclass(frozen=True, eq=False)
class Reference:
    """A frame in which some joints are not corrected, with its pose in the clip's axes.

    Attributes
    ----------
    frame
        The frame of the clip.
    positions
        The global positions, shape (joints, 3), in the file's length unit.
    joints
        The global rotations of the parent (the identity for a root) and of the joint itself, as
        quaternions (w, x, y, z), keyed by the joint's index. Joints that are corrected in this
        frame or have no keys are not listed.
    """

    frame: int
    positions: Array
    joints: Mapping[int, tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class SceneKeys:
    """The corrections of a clip as keys, and frames for measuring the scene's axes.

    Attributes
    ----------
    frames
        The corrected frames of each joint, shape (n,), keyed by the joint's index.
    before, after
        The local rotations before and after the correction, quaternions (w, x, y, z) of shape (n,
        4).
    references
        The reference frames.
    unseen
        Indices of the joints that are corrected in every frame. Their axes in the scene can be
        measured only before a key is set.
    """

    frames: Mapping[int, NDArray[np.intp]]
    before: Mapping[int, Array]
    after: Mapping[int, Array]
    references: tuple[Reference, ...]
    unseen: tuple[int, ...]


def scene_keys(motion: Motion, corrected: Motion) -> SceneKeys:
    """Return the corrected rotations as keys, with up to five reference frames per joint.

    A rotation is corrected in the frames in which it differs between the two motions. Raises
    TwistError if no rotation differs.
    """
    changed = (motion.rotations != corrected.rotations).any(axis=2)
    joints = np.flatnonzero(changed.any(axis=0)).tolist()
    if not joints:
        raise TwistError(
            "expected at least one accepted interval that can be corrected, found none"
        )
    before, positions = forward_kinematics(motion)
    after = forward_kinematics(corrected)[0]
    same = geodesic_angle(before, after) < _SAME
    parents = motion.skeleton.parents
    free: dict[int, NDArray[np.bool_]] = {}
    for joint in joints:
        above = int(parents[joint])
        free[joint] = ~changed[:, joint]
        if above >= 0:
            free[joint] &= same[:, above]
    chosen, unseen = _chosen(free, motion.frames)
    identity = np.array([1.0, 0.0, 0.0, 0.0])
    references = []
    for frame in chosen:
        there = [j for j in joints if free[j][frame] or j in unseen]
        turned = {
            j: (before[frame, parents[j]] if parents[j] >= 0 else identity, before[frame, j])
            for j in there
        }
        references.append(Reference(frame, positions[frame], turned))
    frames = {j: np.flatnonzero(changed[:, j]) for j in joints}
    return SceneKeys(
        frames,
        {j: motion.rotations[at, j] for j, at in frames.items()},
        {j: corrected.rotations[at, j] for j, at in frames.items()},
        tuple(references),
        unseen,
    )


def _chosen(
    free: Mapping[int, NDArray[np.bool_]], frames: int
) -> tuple[list[int], tuple[int, ...]]:
    """Return the reference frames, and the joints that have none.

    `free` has a mask of the frames in which each joint is not corrected, keyed by index, and
    `frames` is the number of frames. Frames in which no joint is corrected are preferred. If there
    are none, frames are chosen for each joint separately.
    """
    unseen = tuple(j for j, own in free.items() if not own.any())
    seen = [own for j, own in free.items() if j not in unseen]
    every = np.logical_and.reduce(seen) if seen else np.ones(frames, dtype=np.bool_)
    if every.any():
        return _spread(every), unseen
    return sorted({frame for own in seen for frame in _spread(own)}), unseen


def _spread(free: NDArray[np.bool_]) -> list[int]:
    """Return up to five frames in which a mask is True, far apart from each other."""
    at = np.flatnonzero(free)
    picked = np.linspace(0, len(at) - 1, min(len(at), MOST_REFERENCES)).round().astype(int)
    return sorted(set(at[picked].tolist()))
