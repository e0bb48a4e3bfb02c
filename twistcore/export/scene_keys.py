"""What is keyed in a scene that the clip came from, and by what the scene is known to be that one.

A scene turns the axes of its joints as its importer, its rig and its bind pose want it. With A the
rotation between the worlds, G a joint's global rotation in the clip and S in the scene, S = A·G·B
with B constant, so that a joint's local rotation in the scene is PRE·q·POST with q its rotation in
the clip, PRE = S_above⁻¹·A·G_above and POST = G⁻¹·A⁻¹·S. All of it is measured in the scene in
frames that no correction touches; a correction is then the turn POST⁻¹·q⁻¹·q'·POST, done last.
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
_SAME = 1e-7  # radians: a global rotation that a correction left as it was


@dataclass(frozen=True, eq=False)
class Reference:
    """A frame in which joints are as they were: where everything is, in the clip's axes.

    positions: (joints, 3), the file's length unit; joints: of the keyed joints that are untouched
    here, by index, the global rotations of what is above (the identity for a root) and their own,
    quaternions (w, x, y, z).
    """

    frame: int
    positions: Array
    joints: Mapping[int, tuple[Array, Array]]


@dataclass(frozen=True, eq=False)
class SceneKeys:
    """The corrections of a clip as keys: by joint the frames (n,) and q and q', each (n, 4).

    unseen: joints that are corrected in every frame, of which no frame tells how the scene turns
    their axes but by what the scene shows before anything was keyed.
    """

    frames: Mapping[int, NDArray[np.intp]]
    before: Mapping[int, Array]
    after: Mapping[int, Array]
    references: tuple[Reference, ...]
    unseen: tuple[int, ...]


def scene_keys(motion: Motion, corrected: Motion) -> SceneKeys:
    """The local rotations that differ, and up to five frames of reference for each joint.

    Raises TwistError where nothing differs.
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
    """Frames of reference, and the joints that have none of their own.

    Best are frames in which every joint is free; where there is none, each joint gets its own.
    """
    unseen = tuple(j for j, own in free.items() if not own.any())
    seen = [own for j, own in free.items() if j not in unseen]
    every = np.logical_and.reduce(seen) if seen else np.ones(frames, dtype=np.bool_)
    if every.any():
        return _spread(every), unseen
    return sorted({frame for own in seen for frame in _spread(own)}), unseen


def _spread(free: NDArray[np.bool_]) -> list[int]:
    """Up to five of the frames, far apart."""
    at = np.flatnonzero(free)
    picked = np.linspace(0, len(at) - 1, min(len(at), MOST_REFERENCES)).round().astype(int)
    return sorted(set(at[picked].tolist()))
