"""Compare two motions joint by joint and frame by frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from twistcore.errors import ClipMismatchError
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import geodesic_angle, vector_lengths
from twistcore.work.frozen import dataclass

_SAME = np.radians(1e-9)  # smaller angles count as equal
_MOVED = 1e-3  # share of the height; angles rounded to two decimals cause a tenth of this


@dataclass(frozen=True)
class JointDifference:
    """A span of frames in which a joint's local rotation differs between two motions.

    Parameters
    ----------
    joint
        Name of the joint.
    start, stop
        The frames [start, stop).
    max_degrees
        The largest angle between the two rotations, in degrees.
    """

    joint: str
    start: int
    stop: int
    max_degrees: float


@dataclass(frozen=True)
class JointMove:
    """The change of a joint's position between two motions.

    Parameters
    ----------
    joint
        Name of the joint.
    largest
        The largest change, in the file's unit.
    of_height
        The largest change, as a fraction of the skeleton's height.
    frames
        Number of frames in which the position changes.
    """

    joint: str
    largest: float
    of_height: float
    frames: int


@dataclass(frozen=True)
class Difference:
    """All differences between two motions of one skeleton.

    Parameters
    ----------
    joints
        The spans in which local rotations differ.
    max_position
        The largest change of any joint's position, in the file's unit.
    max_position_of_height
        The same change, as a fraction of the skeleton's height.
    moved_channels
        Number of joints whose position channels differ.
    moved
        The joints whose position changed by more than rounding in the file can explain.
    rest_of_height
        The largest change of position of the joints not in `moved`, as a fraction of the height.
    """

    joints: tuple[JointDifference, ...]
    max_position: float
    max_position_of_height: float
    moved_channels: int
    moved: tuple[JointMove, ...]
    rest_of_height: float

    @property
    def frames(self) -> int:
        """The number of frames in which any rotation differs."""
        return len({t for j in self.joints for t in range(j.start, j.stop)})


def compare_motions(a: Motion, b: Motion) -> Difference:
    """Compare two motions of one skeleton, joint by joint.

    Raises ClipMismatchError if the skeletons, the numbers of frames or the position channels
    differ.
    """
    if a.skeleton.names != b.skeleton.names or (a.skeleton.parents != b.skeleton.parents).any():
        raise ClipMismatchError("the two clips have different skeletons")
    if a.frames != b.frames:
        raise ClipMismatchError(
            f"the clips have different numbers of frames: {a.frames} and {b.frames}"
        )
    if a.positioned != b.positioned:
        raise ClipMismatchError("the two clips have different position channels")
    angle = geodesic_angle(a.rotations, b.rotations)
    found = []
    for joint in np.flatnonzero((angle > _SAME).any(axis=0)):
        edges = np.flatnonzero(np.diff(angle[:, joint] > _SAME, prepend=False, append=False))
        for start, stop in edges.reshape(-1, 2):
            largest = float(np.degrees(angle[start:stop, joint].max()))
            found.append(JointDifference(a.skeleton.names[joint], int(start), int(stop), largest))
    way = vector_lengths(forward_kinematics(a)[1] - forward_kinematics(b)[1])
    channels = int((np.abs(a.positions - b.positions) > 0).any(axis=(0, 2)).sum())
    height, largest = a.skeleton.height, way.max(axis=0)
    far = largest > _MOVED * height
    moved = tuple(
        JointMove(
            a.skeleton.names[joint],
            float(largest[joint]),
            float(largest[joint]) / height,
            int((way[:, joint] > _MOVED * height).sum()),
        )
        for joint in np.flatnonzero(far)
    )
    return Difference(
        joints=tuple(found),
        max_position=float(largest.max()),
        max_position_of_height=float(largest.max()) / height,
        moved_channels=channels,
        moved=moved,
        rest_of_height=float(largest[~far].max(initial=0.0)) / height,
    )


@dataclass(frozen=True)
class Deviation:
    """The largest differences between the poses of two motions.

    Parameters
    ----------
    degrees
        The largest angle between world rotations of a joint, in degrees.
    joint, frame
        The joint and the frame in which this angle occurs.
    position
        The largest distance between positions of a joint, in the file's unit.
    of_height
        The same distance, as a fraction of the skeleton's height.
    """

    degrees: float
    joint: str
    frame: int
    position: float
    of_height: float


def largest_deviation(a: Motion, b: Motion) -> Deviation:
    """Compare the poses of two motions whose joints have the same names, in any order.

    Raises ClipMismatchError if the joints or the numbers of frames differ.
    """
    names = b.skeleton.names
    if set(a.skeleton.names) != set(names) or a.frames != b.frames:
        raise ClipMismatchError("the two clips have different joints or numbers of frames")
    own = [a.skeleton.index(name) for name in names]
    (turned, placed), (others, places) = forward_kinematics(a), forward_kinematics(b)
    angle = geodesic_angle(turned[:, own], others)
    frame, joint = np.unravel_index(int(angle.argmax()), angle.shape)
    way = float(vector_lengths(placed[:, own] - places).max())
    degrees = float(np.degrees(angle.max()))
    return Deviation(degrees, names[joint], int(frame), way, way / b.skeleton.height)


def joint_position_change_to_json(move: JointMove) -> dict[str, Any]:
    """Return the change of a joint's position as JSON data."""
    return {
        "joint": move.joint,
        "max": move.largest,
        "max_of_height": move.of_height,
        "frames": move.frames,
    }


def difference_to_json(difference: Difference, a: str, b: str) -> dict[str, Any]:
    """Return the differences as a JSON document. `a` and `b` are the names of the two clips."""
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
        "moved": [joint_position_change_to_json(move) for move in difference.moved],
    }
