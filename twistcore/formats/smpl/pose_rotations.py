"""Convert the joint rotations of pose estimators to unit quaternions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from twistcore.formats.smpl.pose_files import PosesError
from twistcore.skeleton.rotation import Array, exponential

# RᵀR of a matrix R in a file may deviate from I by the first value without a note, and by the
# second value with a note. The nearest rotation is then used.
_SILENT, _SAID = 1e-3, 0.05


def quaternions_from_poses(
    path: Path, name: str, values: Array, counts: tuple[int, ...], notes: list[str]
) -> Array:
    """Convert axis-angle vectors or rotation matrices to unit quaternions, (frames, joints, 4).

    Raises PosesError if the shape is not supported, a number is not finite, or a matrix is not a
    rotation.

    Parameters
    ----------
    path
        The file, for error messages.
    name
        The name of the array in the file, for error messages and notes.
    values
        Axis-angle vectors in radians, shape (frames, 3·joints) or (frames, joints, 3), or matrices,
        shape (frames, 9·joints), (frames, joints, 3, 3) or, for one joint, (frames, 3, 3).
    counts
        The allowed numbers of joints.
    notes
        A list to which a sentence is added if matrices deviate from rotations by more than 0.001.
    """
    frames = len(values) if values.ndim else 0
    tail = values.shape[1:]
    if values.ndim and not frames:
        raise PosesError(f"{path}: expected at least one frame in {name}, found none")
    for n in counts:
        if tail in ((3 * n,), (n, 3)):
            check_smpl_pose_values(path, name, values)
            return exponential(values.reshape(frames, n, 3))
        if tail in ((9 * n,), (n, 3, 3)) or (n == 1 and tail == (3, 3)):
            check_smpl_pose_values(path, name, values)
            return _from_matrices(path, name, values.reshape(frames, n, 3, 3), notes)
    shapes = " or ".join(f"(frames, {3 * n})" for n in counts)
    raise PosesError(
        f"{path}: expected {name} as axis-angle vectors of shape {shapes} or as matrices, "
        f"found shape {values.shape}"
    )


def check_smpl_pose_values(path: Path, name: str, values: Array) -> None:
    """Raise PosesError if a number is NaN, infinite, or at least a million in magnitude."""
    good = np.abs(values) < 1e6
    if not good.all():
        frame = int(np.argwhere(~good)[0, 0])
        raise PosesError(
            f"{path}: expected finite numbers below a million in {name}, found "
            f"{values[~good][0]:g} in frame {frame}"
        )


def _from_matrices(path: Path, name: str, matrices: Array, notes: list[str]) -> Array:
    products = np.einsum("fjki,fjkl->fjil", matrices, matrices)
    off = np.abs(products - np.eye(3)).max(axis=(2, 3))
    near = (off <= _SAID)[..., None, None]
    off[np.linalg.det(np.where(near, matrices, np.eye(3))) < 0.0] = np.inf  # a reflection
    worst = float(off.max())
    if worst > _SAID:
        frame, joint = (int(k) for k in np.argwhere(off > _SAID)[0])
        raise PosesError(
            f"{path}: expected rotation matrices in {name}, but the matrix in frame {frame} "
            f"of joint {joint} is not a rotation"
        )
    if worst > _SILENT:
        notes.append(
            f"Matrices in {name} deviate from rotations by up to {worst:.2g}: the nearest "
            "rotations are used."
        )
    u, _, vt = np.linalg.svd(matrices)
    turned = Rotation.from_matrix((u @ vt).reshape(-1, 3, 3)).as_quat(scalar_first=True)
    out: Array = turned.reshape(*matrices.shape[:2], 4)
    return out
