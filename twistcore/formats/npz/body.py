"""Joint names of SMPL, SMPL-H and SMPL-X, and bone lengths for files that have none.

The shapes of the models are not included. Arms, legs and height are those of an average adult in a
T-pose, with y up, facing z, and the left side at +x [Winter, Biomechanics and Motor Control of
Human Movement, fig. 4.1, after Drillis and Contini 1966]. The positions of the spine's joints and
of the first finger joints are estimates.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

Triple: TypeAlias = tuple[float, float, float]

BODY = 22  # number of joints without the hands, the same in all models
_BODY_NAMES = (
    "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2",
    "left_ankle", "right_ankle", "spine3", "left_foot", "right_foot", "neck", "left_collar",
    "right_collar", "head", "left_shoulder", "right_shoulder", "left_elbow", "right_elbow",
    "left_wrist", "right_wrist",
)  # fmt: skip
_BODY_PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19)
_FINGERS = ("index", "middle", "pinky", "ring", "thumb")
_FACE = ("jaw", "left_eye_smplhf", "right_eye_smplhf")

_HEIGHT = 1.7  # metres
# Offsets from the parent as shares of the height, with x to the left, y up and z forward. Joints of
# the right side are mirrored.
_SHARES: dict[str, Triple] = {
    "left_hip": (0.055, -0.05, 0.0), "left_knee": (0.0, -0.245, 0.0),
    "left_ankle": (0.0, -0.246, 0.0), "left_foot": (0.0, -0.03, 0.08),
    "spine1": (0.0, 0.06, 0.0), "spine2": (0.0, 0.08, 0.0), "spine3": (0.0, 0.035, 0.0),
    "neck": (0.0, 0.115, 0.0), "head": (0.0, 0.05, 0.0),
    "left_collar": (0.05, 0.045, 0.0), "left_shoulder": (0.079, 0.02, 0.0),
    "left_elbow": (0.186, 0.0, 0.0), "left_wrist": (0.146, 0.0, 0.0),
    "left_hand": (0.054, 0.0, 0.0),
    "jaw": (0.0, 0.0, 0.02), "left_eye_smplhf": (0.018, 0.05, 0.045),
    "left_index1": (0.054, 0.0, 0.014), "left_middle1": (0.054, 0.0, 0.0),
    "left_ring1": (0.052, 0.0, -0.012), "left_pinky1": (0.048, 0.0, -0.024),
    "left_thumb1": (0.014, -0.005, 0.016),
}  # fmt: skip
_SHARES |= {f"left_{finger}{k}": (0.018, 0.0, 0.0) for finger in _FINGERS for k in (2, 3)}
_ENDS: dict[str, Triple] = {
    "head": (0.0, 0.08, 0.0), "left_foot": (0.0, 0.0, 0.05), "left_wrist": (0.1, 0.0, 0.0),
    "left_hand": (0.05, 0.0, 0.0),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class BodyModel:
    """The joints of a body model, with typical bone lengths.

    Attributes
    ----------
    names
        Names of the joints.
    parents
        Index of each joint's parent, shape (joints,).
    offsets
        Offsets from the parents at rest, metres, shape (joints, 3).
    ends
        End Sites of joints without children, as in :class:`Skeleton`.
    """

    names: tuple[str, ...]
    parents: NDArray[np.int64]
    offsets: Array
    ends: tuple[tuple[int, Triple], ...]


def _hand(side: str) -> list[tuple[str, str]]:
    """Return the names of a hand's joints, each with the name of its parent."""
    wrist = f"{side}_wrist"
    return [
        (f"{side}_{finger}{k}", f"{side}_{finger}{k - 1}" if k > 1 else wrist)
        for finger in _FINGERS
        for k in (1, 2, 3)
    ]


def _offset(name: str, shares: dict[str, Triple]) -> Triple | None:
    """Return a joint's offset in metres, mirrored for the right side, or None if unknown.

    `shares` has the offsets of the joints, except those on the right side, as fractions of the body
    height.
    """
    left = name.replace("right_", "left_")
    if left not in shares:
        return None
    x, y, z = (_HEIGHT * share for share in shares[left])
    return (x if left == name else -x), y, z


def _model(below: list[tuple[str, str]]) -> BodyModel:
    """Return a model with the body's 22 joints and further joints.

    `below` lists the names of the further joints, each with the name of its parent.
    """
    names = (*_BODY_NAMES, *(name for name, _ in below))
    parents = (*_BODY_PARENTS, *(names.index(above) for _, above in below))
    offsets = [_offset(name, _SHARES) or (0.0, 0.0, 0.0) for name in names]
    ends = tuple(
        (j, end)
        for j, name in enumerate(names)
        if (end := _offset(name, _ENDS)) is not None and (j not in parents or name == "head")
    )
    return BodyModel(names, np.array(parents, dtype=np.int64), np.array(offsets), ends)


_HANDS = [*_hand("left"), *_hand("right")]
BODIES = {
    BODY: _model([]),  # the body without hands
    24: _model([(f"{side}_hand", f"{side}_wrist") for side in ("left", "right")]),
    52: _model(_HANDS),
    55: _model([*((name, "head") for name in _FACE), *_HANDS]),
}
MODELS = {BODY: "a body without hands", 24: "SMPL", 52: "SMPL-H", 55: "SMPL-X"}
