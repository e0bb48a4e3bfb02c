"""Reading AMASS/SMPL-style .npz: axis-angle poses on SMPL's kinematic tree."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.bvh import Clip, parse_bvh, read_bvh
from twistcore.bvh.compose import bvh_text
from twistcore.errors import TwistError
from twistcore.motion import Motion, Skeleton
from twistcore.quamo.topology import JOINTS, find_topology, metres_per_unit, skeleton_24
from twistcore.rotation import Array, exponential, multiply, quaternion_from_axis_angle

_RATES = ("mocap_framerate", "mocap_frame_rate")
_BODY = 22  # joints before the hands, alike in files of 24 and of 52 joints


class PosesError(TwistError):
    """An .npz that cannot be read as poses: one sentence."""


def read_poses(
    path: Path,
    *,
    template: Path | None = None,
    unit: float | None = None,
    fps: float | None = None,
    up: str = "z",
) -> Clip:
    """A clip made of an .npz with `poses` (frames, 72 or 156), `trans` (frames, 3) and a rate.

    Rest offsets come from the array `offsets` (24, 3) in metres or from a BVH `template` with the
    24 joints; the file holds none of its own. unit: metres in one unit of the template, CMU's
    as a rule; the clip is in metres. up: the axis that points up in the file, 'z' as in AMASS or
    'y'; the clip's is y. Of 156 numbers the fingers' are left out. Raises PosesError.
    """
    arrays = _load(path)
    poses, trans = _array(path, arrays, "poses"), _array(path, arrays, "trans")
    if poses.ndim != 2 or poses.shape[1] not in (72, 156) or not len(poses):
        raise PosesError(
            f"{path}: expected poses of shape (frames, 72) or (frames, 156), found {poses.shape}"
        )
    if trans.shape != (len(poses), 3):
        raise PosesError(f"{path}: expected trans of shape ({len(poses)}, 3), found {trans.shape}")
    for name, values in (("poses", poses), ("trans", trans)):
        if not np.isfinite(values).all():
            row = int(np.argwhere(~np.isfinite(values))[0, 0])
            raise PosesError(
                f"{path}: expected finite numbers in {name}, found NaN or infinity in frame {row}"
            )
    rate = _rate(path, arrays, fps)
    vectors = np.zeros((len(poses), JOINTS, 3))
    count = JOINTS if poses.shape[1] == 72 else _BODY
    vectors[:, :count] = poses[:, : 3 * count].reshape(len(poses), count, 3)
    q, r = exponential(vectors), trans
    if up == "z":
        turn = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), -0.5 * np.pi)
        q[:, 0] = multiply(turn, q[:, 0])
        r = np.stack([trans[:, 0], trans[:, 2], -trans[:, 1]], axis=1)
    skeleton = _skeleton(path, arrays, template, unit)
    motion = Motion(skeleton, q, (0,), (r + skeleton.offsets[0])[:, None], 1.0 / rate)
    return parse_bvh(bvh_text(motion).encode("utf-8", "surrogateescape"), path)


def _load(path: Path) -> dict[str, NDArray[np.generic]]:
    try:
        with np.load(path, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except (ValueError, zipfile.BadZipFile, EOFError, AttributeError):
        raise PosesError(f"{path}: expected an .npz with poses, trans and a rate") from None


def _array(path: Path, arrays: dict[str, NDArray[np.generic]], name: str) -> Array:
    if name not in arrays:
        raise PosesError(f"{path}: expected the array {name!r}, found {', '.join(arrays) or '–'}")
    if arrays[name].dtype.kind not in "fiu":
        raise PosesError(f"{path}: expected numbers in {name!r}, found {arrays[name].dtype}")
    return np.asarray(arrays[name], dtype=np.float64)


def _rate(path: Path, arrays: dict[str, NDArray[np.generic]], fps: float | None) -> float:
    if fps is not None:
        return fps
    for name in _RATES:
        if name in arrays:
            values = _array(path, arrays, name)
            if values.size != 1 or not (np.isfinite(values).all() and values.item() > 0.0):
                raise PosesError(f"{path}: expected a rate above 0 in {name!r}; --fps gives one")
            return float(values.item())
    raise PosesError(f"{path}: expected the rate in 'mocap_framerate'; --fps gives one")


def _skeleton(
    path: Path, arrays: dict[str, NDArray[np.generic]], template: Path | None, unit: float | None
) -> Skeleton:
    if template is not None:
        source = read_bvh(template).skeleton
        try:
            scale = metres_per_unit(source, unit)
            return skeleton_24(scale * find_topology(source).offsets)
        except TwistError as error:
            raise PosesError(f"{template}: {error}") from None
    if "offsets" not in arrays:
        raise PosesError(
            f"{path}: expected rest offsets: a BVH with --template or an array "
            "'offsets' (24, 3) in metres"
        )
    offsets = _array(path, arrays, "offsets")
    if offsets.shape != (JOINTS, 3) or not np.isfinite(offsets).all():
        raise PosesError(f"{path}: expected finite offsets of shape (24, 3), found {offsets.shape}")
    return skeleton_24(offsets)
