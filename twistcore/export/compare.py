"""What differs between two clips, in joints, frames and degrees, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from twistcore.errors import ClipMismatchError
from twistcore.motion import Motion, forward_kinematics
from twistcore.rotation import geodesic_angle

_SAME = np.radians(1e-9)


@dataclass(frozen=True)
class JointDifference:
    """Frames [start, stop) in which a joint's local rotation differs, and by how much at most."""

    joint: str
    start: int
    stop: int
    max_degrees: float


@dataclass(frozen=True)
class Difference:
    """All joints that differ; the largest change of a global rotation and of a joint's place."""

    joints: tuple[JointDifference, ...]
    max_position: float
    max_position_of_height: float
    moved_channels: int

    @property
    def frames(self) -> int:
        """Number of frames in which anything rotates otherwise."""
        return len({t for j in self.joints for t in range(j.start, j.stop)})


def compare(a: Motion, b: Motion) -> Difference:
    """Compare two motions of one skeleton; ClipMismatchError where they are not comparable."""
    if a.skeleton.names != b.skeleton.names or (a.skeleton.parents != b.skeleton.parents).any():
        raise ClipMismatchError("the two clips have different skeletons")
    if a.frames != b.frames:
        raise ClipMismatchError(f"the clips have {a.frames} and {b.frames} frames")
    if a.positioned != b.positioned:
        raise ClipMismatchError("the two clips have different position channels")
    angle = geodesic_angle(a.rotations, b.rotations)
    found = []
    for joint in np.flatnonzero((angle > _SAME).any(axis=0)):
        edges = np.flatnonzero(np.diff(angle[:, joint] > _SAME, prepend=False, append=False))
        for start, stop in edges.reshape(-1, 2):
            largest = float(np.degrees(angle[start:stop, joint].max()))
            found.append(JointDifference(a.skeleton.names[joint], int(start), int(stop), largest))
    moved = np.linalg.norm(forward_kinematics(a)[1] - forward_kinematics(b)[1], axis=-1)
    channels = int((np.abs(a.positions - b.positions) > 0).any(axis=(0, 2)).sum())
    largest_move = float(moved.max())
    return Difference(tuple(found), largest_move, largest_move / a.skeleton.height, channels)


def difference_to_json(difference: Difference, a: str, b: str) -> dict[str, Any]:
    """The comparison as a JSON document."""
    return {
        "schema": "twistcore.diff/1",
        "a": a,
        "b": b,
        "frames": difference.frames,
        "joints": [
            {"joint": j.joint, "start": j.start, "stop": j.stop, "max_deg": j.max_degrees}
            for j in difference.joints
        ],
        "max_position": difference.max_position,
        "max_position_of_height": difference.max_position_of_height,
        "changed_position_channels": difference.moved_channels,
    }
