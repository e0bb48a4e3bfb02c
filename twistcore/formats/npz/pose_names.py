"""Array names under which files store SMPL poses.

AMASS [Mahmood et al. 2019] has `poses` and `trans`. Its SMPL-X release also stores parts of `poses`
in separate arrays. Other files have only such arrays, named as in AMASS or in the package smplx.
AIST++ [Li et al. 2021] has `smpl_poses`, `smpl_trans` and `smpl_scaling`.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from twistcore.errors import NpzError
from twistcore.formats.npz.body import BODIES, BODY, MODELS
from twistcore.formats.npz.stored_arrays import Arrays
from twistcore.work.frozen import dataclass

POSES, TRANS = "poses", "trans"
SMPL_POSES, SMPL_TRANS, SMPL_SCALING = "smpl_poses", "smpl_trans", "smpl_scaling"
_AIST_FPS = 60.0
_ROOTS, _BODIES, _PLACES = (
    ("root_orient", "global_orient"),
    ("pose_body", "body_pose"),
    (TRANS, "transl"),
)
_LEFT_EYE, _RIGHT_EYE = "left_eye_smplhf", "right_eye_smplhf"
# The first and the last joint of each array that has only some of the joints.
PARTS = {
    "root_orient": ("pelvis", "pelvis"), "global_orient": ("pelvis", "pelvis"),
    "pose_body": ("left_hip", "right_wrist"), "body_pose": ("left_hip", "right_wrist"),
    "pose_hand": ("left_index1", "right_thumb3"), "left_hand_pose": ("left_index1", "left_thumb3"),
    "right_hand_pose": ("right_index1", "right_thumb3"), "pose_jaw": ("jaw", "jaw"),
    "jaw_pose": ("jaw", "jaw"), "pose_eye": (_LEFT_EYE, _RIGHT_EYE),
    "leye_pose": (_LEFT_EYE, _LEFT_EYE), "reye_pose": (_RIGHT_EYE, _RIGHT_EYE),
}  # fmt: skip
_HANDS = (("pose_hand",), ("left_hand_pose", "right_hand_pose"))
_JAWS, _EYES = (("pose_jaw",), ("jaw_pose",)), (("pose_eye",), ("leye_pose", "reye_pose"))


@dataclass(frozen=True)
class PosePart:
    """An array with some of the joints of the poses, such as 'pose_body' of SMPL-X.

    Attributes
    ----------
    name
        The array's name.
    start, stop
        Columns [start, stop) of the pose that the array contains.
    """

    name: str
    start: int
    stop: int


@dataclass(frozen=True)
class PoseNames:
    """The array names in one file layout.

    Attributes
    ----------
    joints
        Number of joints of the body model.
    parts
        Arrays that together contain each number of a pose once.
    place
        Name of the array with the root's position.
    scale
        Units of the position per metre.
    rate
        Frame rate to assume if the file has none, with the name of its data set, or None.
    left
        Names of arrays with joints that are neither read nor changed.
    """

    joints: int
    parts: tuple[PosePart, ...]
    place: str
    scale: float = 1.0
    rate: tuple[float, str] | None = None
    left: tuple[str, ...] = ()


def has_pose_names(names: Collection[str]) -> bool:
    """Return True if the names belong to arrays of poses over time."""
    parts = _first(_ROOTS, names) and _first(_BODIES, names) and _first(_PLACES, names)
    video = {"results", "sequence_results"}.issubset(names)
    return POSES in names or SMPL_POSES in names or bool(parts) or video


def find_pose_names(arrays: Arrays) -> PoseNames | None:
    """Return the layout of a file, or None if the file has no known names.

    Raises NpzError if an array is damaged.
    """
    if POSES in arrays:
        return _whole(arrays, POSES, TRANS)
    if SMPL_POSES in arrays:
        scale = _scale(arrays)
        rate = _AIST_FPS, "AIST++"
        return _whole(arrays, SMPL_POSES, SMPL_TRANS, scale, rate)
    return _by_parts(arrays)


def _whole(
    arrays: Arrays,
    poses: str,
    place: str,
    scale: float = 1.0,
    rate: tuple[float, str] | None = None,
) -> PoseNames:
    """Return the layout in which one array has all joints. Raises NpzError for a wrong shape."""
    shape = arrays.array(poses).shape
    width = (
        3 * shape[1] if len(shape) == 3 and shape[2] == 3 else shape[1] if len(shape) == 2 else 0
    )
    if width not in {3 * n for n in BODIES}:
        shapes = " or ".join(f"{3 * n} ({MODELS[n]})" for n in BODIES)
        raise NpzError(
            f"{arrays.path}: expected {poses} as rotation vectors of shape frames x "
            f"{shapes}, found {shape}"
        )
    return PoseNames(width // 3, (PosePart(poses, 0, width),), place, scale, rate)


def _scale(arrays: Arrays) -> float:
    """Return the units per metre of AIST++'s positions.

    Raises NpzError if the number is invalid.
    """
    if SMPL_SCALING not in arrays:
        return 1.0
    found = arrays.array(SMPL_SCALING)
    value = float(found.reshape(-1)[0]) if found.size == 1 and found.dtype.kind in "fiu" else np.nan
    if not (np.isfinite(value) and 1e-6 < value < 1e6):
        raise NpzError(f"{arrays.path}: expected one number above 0 in {SMPL_SCALING!r}")
    return value


def _by_parts(arrays: Arrays) -> PoseNames | None:
    """Return the layout with separate arrays for root, body, hands and face, or None.

    Hands and face are used if they are complete.
    """
    root, body, place = (_first(names, arrays) for names in (_ROOTS, _BODIES, _PLACES))
    if not (root and body and place):
        return None
    widths = _width(arrays, root), _width(arrays, body)
    if widths not in ((3, 63), (3, 69)):
        return None  # these are matrices, several people, or another model
    frames = len(arrays.array(body))
    if widths[1] == 69:
        return PoseNames(24, (PosePart(root, 0, 3), PosePart(body, 3, 72)), place)

    def there(choices: tuple[tuple[str, ...], ...], joints: int) -> tuple[str, ...]:
        """Return the first of several groups of array names that exists and is complete, or ().

        A group is complete if its arrays contain all of its `joints` in every frame.
        """
        for names in choices:
            if all(name in arrays and len(arrays.array(name)) == frames for name in names):
                widths = [_width(arrays, name) for name in names]
                if widths == [3 * joints // len(names)] * len(names):
                    return names
        return ()

    hands, face = there(_HANDS, 30), (*there(_JAWS, 1), *there(_EYES, 2))
    joints = BODY if not hands else 55 if len(face) > 1 else 52
    names = BODIES[joints].names
    chosen = (root, body, *(face if joints == 55 else ()), *hands)
    parts = tuple(_part(name, names) for name in chosen)
    left = tuple(name for name in PARTS if name in arrays and name not in chosen)
    return PoseNames(joints, parts, place, left=left)


def _part(name: str, joints: tuple[str, ...]) -> PosePart:
    first, last = PARTS[name]
    return PosePart(name, 3 * joints.index(first), 3 * joints.index(last) + 3)


def _width(arrays: Arrays, name: str) -> int:
    """Return an array's number of values per frame, or 0 if its shape is wrong for one person."""
    shape: tuple[int, ...] = arrays.array(name).shape
    if len(shape) == 3 and shape[2] == 3:
        return 3 * shape[1]
    return shape[1] if len(shape) == 2 else 0


def _first(wanted: tuple[str, ...], there: Collection[str] | Arrays) -> str:
    return next((name for name in wanted if name in there), "")
