"""Read an .npz file or a pickle of poses as a clip."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import NpzError
from twistcore.files.ordinary import read_file
from twistcore.formats.clip import LONGEST, SHORTEST, ClipWarning
from twistcore.formats.npz.archive import LARGEST, open_archive, too_large_error
from twistcore.formats.npz.body import BODIES, BODY
from twistcore.formats.npz.clip import NpzClip, PklClip
from twistcore.formats.npz.pose_names import (
    PARTS,
    POSES,
    TRANS,
    PoseNames,
    PosePart,
    find_pose_names,
)
from twistcore.formats.npz.stored_arrays import Arrays, open_pickle
from twistcore.formats.npz.video_poses import PLACE, THETAS, VideoPoses, read_video_poses
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array
from twistcore.work.progress import Tell, ignore_progress

_RATES = ("mocap_framerate", "mocap_frame_rate", "fps", "frame_rate")
_ASSUMED_FPS = 30.0
_FRAMES = 1_000_000  # maximum number of frames, which is hours of motion
# Names of poses in files of pose estimators that another command reads.
_ELSEWHERE = (
    "global_orient", "root_orient", "body_pose", "pose_body", "pose_world", "pose", "pred_rotmat",
    "smpl_thetas", "smpl_params_global", "outputs",
)  # fmt: skip


def read_npz(path: str | Path, *, fps: float | None = None, tell: Tell | None = None) -> NpzClip:
    """Read an .npz file of poses (docs/amass.md) without running any code in it.

    Parameters
    ----------
    path
        The file.
    fps
        Frames per second to use instead of the file's rate.
    tell
        Called with the progress, 0…1.

    Raises
    ------
    NpzError
        If the file is damaged or does not contain poses. Missing values, such as the frame rate,
        are not an error. Values that were assumed are listed in `Clip.warnings`.
    """
    path = Path(path)
    return parse_npz(_bytes_of(path, "an .npz"), path, fps=fps, tell=tell)


def read_pkl(path: str | Path, *, fps: float | None = None, tell: Tell | None = None) -> PklClip:
    """Read a pickle of poses, such as AIST++'s, without running any code in it.

    Parameters and errors are those of :func:`read_npz`.
    """
    path = Path(path)
    return parse_pkl(_bytes_of(path, "a pickle"), path, fps=fps, tell=tell)


def parse_npz(
    data: bytes,
    path: str | Path = "clip.npz",
    *,
    fps: float | None = None,
    tell: Tell | None = None,
) -> NpzClip:
    """Parse the bytes of an .npz file. See :func:`read_npz`."""
    archive = open_archive(Path(path), data)
    names = find_pose_names(archive)
    if names is None and (video := read_video_poses(archive)) is not None:
        place = PLACE if PLACE in video else ""
        names = PoseNames(24, (PosePart(THETAS, 0, 72),), place)
        return NpzClip(**_read(data, video, names, fps, tell or ignore_progress))
    return NpzClip(**_read(data, archive, names, fps, tell or ignore_progress))


def parse_pkl(
    data: bytes,
    path: str | Path = "clip.pkl",
    *,
    fps: float | None = None,
    tell: Tell | None = None,
) -> PklClip:
    """Parse the bytes of a pickle. See :func:`read_pkl`."""
    pickled = open_pickle(Path(path), data)
    return PklClip(**_read(data, pickled, find_pose_names(pickled), fps, tell or ignore_progress))


def _bytes_of(path: Path, what: str) -> bytes:
    try:
        if path.stat().st_size > LARGEST:
            raise too_large_error(path)
        return read_file(path)
    except FileNotFoundError:
        raise NpzError(f"{path}: expected {what}, but the file does not exist") from None
    except IsADirectoryError:
        raise NpzError(f"{path}: expected {what}, but this is a folder") from None
    except OSError as error:
        raise NpzError(f"{path}: cannot be read ({error.strerror})") from None


def _read(
    data: bytes, arrays: Arrays, names: PoseNames | None, fps: float | None, tell: Tell
) -> dict[str, Any]:
    """Return the arguments for creating the clip.

    Raises NpzError if there are no poses.
    """
    path = arrays.path
    if names is None:
        raise _no_poses(arrays)
    warnings: list[str] = [*arrays.notes] if isinstance(arrays, VideoPoses) else []
    poses = _poses(arrays, names)
    tell(0.5)
    trans = np.zeros((len(poses), 3))
    if names.place:
        trans = _numbers(arrays, names.place)
        if trans.ndim == 3 and trans.shape[1] == 1:
            trans = trans[:, 0]
        if trans.shape != (len(poses), 3):
            raise NpzError(
                f"{path}: expected {names.place} of shape ({len(poses)}, 3), found {trans.shape}"
            )
        _check_finite(arrays, names.place, trans)
    frame_time = 1.0 / fps if fps is not None else _frame_time(arrays, names, warnings)
    skeleton, rest = _skeleton(arrays, names.joints, warnings)
    repeated = _repeated(arrays, names, poses, skeleton.names, warnings)
    tell(1.0)
    return {
        "path": path,
        "data": data,
        "skeleton": skeleton,
        "frame_time": frame_time,
        "warnings": tuple(map(ClipWarning, warnings)),
        "archive": arrays,
        "poses": poses,
        "parts": names.parts,
        "place": names.place,
        "trans": trans,
        "scale": names.scale,
        "rest": rest,
        "repeated": repeated,
    }


def _no_poses(arrays: Arrays) -> NpzError:
    also = any(name in arrays for name in _ELSEWHERE)
    other = " (`twistcore quamo refine` reads other layouts)" if also else ""
    return NpzError(
        f"{arrays.path}: expected the arrays {POSES!r} and {TRANS!r} of AMASS, or another "
        f"layout listed in docs/amass.md, found {arrays.described()}{other}"
    )


def _poses(arrays: Arrays, names: PoseNames) -> NDArray[Any]:
    """Return the rotation vectors, (frames, 3 · joints). Raises NpzError if they are invalid."""
    path = arrays.path
    found: list[NDArray[Any]] = []
    for part in names.parts:
        values = _numbers(arrays, part.name)
        if values.size != len(values) * (part.stop - part.start):
            raise NpzError(
                f"{path}: expected {part.stop - part.start} numbers per frame in {part.name}, "
                f"found shape {values.shape}"
            )
        flat = values.reshape(len(values), part.stop - part.start)
        if not 1 <= len(flat) <= _FRAMES:
            raise NpzError(f"{path}: expected 1 to {_FRAMES} frames, found {len(flat)}")
        if found and len(flat) != len(found[0]):
            first = names.parts[0].name
            raise NpzError(
                f"{path}: expected as many frames in {part.name} as in {first}, found {len(flat)} "
                f"and {len(found[0])}"
            )
        _check_finite(arrays, part.name, flat)
        found.append(flat)
    if len(found) == 1:
        return found[0]
    poses = np.empty((len(found[0]), 3 * names.joints), np.result_type(*found))
    for part, flat in zip(names.parts, found, strict=True):
        poses[:, part.start : part.stop] = flat
    return poses


def _numbers(archive: Arrays, name: str) -> NDArray[Any]:
    if name not in archive:
        raise NpzError(f"{archive.path}: expected the array {name!r}, found {archive.described()}")
    found = archive.array(name)
    if found.dtype.kind != "f":
        raise NpzError(
            f"{archive.path}: expected floating-point numbers in {name!r}, found {found.dtype}"
        )
    return found


def _check_finite(archive: Arrays, name: str, values: NDArray[Any], row: str = "frame") -> None:
    with np.errstate(invalid="ignore", over="ignore"):  # a signalling NaN would warn
        good = np.abs(values.astype(np.float64)) < 1e6
    if not good.all():
        first = int(np.argwhere(~good)[0, 0])
        raise NpzError(
            f"{archive.path}: expected finite numbers below a million in {name!r}, found "
            f"{values[~good][0]:g} in {row} {first}"
        )


def _frame_time(archive: Arrays, names: PoseNames, warnings: list[str]) -> float:
    """Return the seconds per frame from the file.

    If the file has no rate, the layout's rate or 30 fps is used, and a warning is added.
    """
    rate, whose = names.rate or (_ASSUMED_FPS, "")
    assumed = (
        f"{rate:g} frames per second are assumed (set another rate with --fps on the command line)"
    )
    if whose:
        assumed = (
            f"{rate:g} frames per second are assumed, as in {whose} (set another rate with "
            "--fps on the command line)"
        )
    for name in _RATES:
        if name not in archive:
            continue
        found = archive.array(name)
        if found.dtype.kind in "fiu" and found.size == 1:
            fps = float(found.reshape(-1)[0])
            if np.isfinite(fps) and fps > 0.0 and SHORTEST <= 1.0 / fps <= LONGEST:
                return 1.0 / fps
        warnings.append(f"{name} is not usable; {assumed}.")
        return 1.0 / rate
    warnings.append(f"The file has no frame rate; {assumed}.")
    return 1.0 / rate


def _skeleton(archive: Arrays, joints: int, warnings: list[str]) -> tuple[Skeleton, Array]:
    """Return the skeleton, and the root's rest position in metres, (3,).

    A file may have 'offsets' from the parents, or positions 'J' in the rest pose, for all joints or
    for the first joints of the body. For other files, a template is used.
    """
    body = BODIES[joints]
    offsets = body.offsets.copy()
    for name in ("offsets", "J"):
        if name not in archive:
            continue
        with np.errstate(invalid="ignore", over="ignore"):  # a signalling NaN would warn
            given = np.asarray(_numbers(archive, name), dtype=np.float64)
        count = joints if given.shape == (joints, 3) else BODY
        if given.shape not in ((joints, 3), (24, 3), (BODY, 3)):
            raise NpzError(
                f"{archive.path}: expected {name!r} in metres with the shape ({joints}, 3), "
                f"found {given.shape}"
            )
        _check_finite(archive, name, given, "joint")
        above = body.parents[:count]
        if name == "J":
            given = given[:count] - np.where((above >= 0)[:, None], given[above], 0.0)
        offsets[:count] = given[:count]
        if count < joints:
            warnings.append(
                f"The rest offsets of the hands come from a template, because {name!r} has "
                "only the body."
            )
        return Skeleton(body.names, body.parents, offsets), offsets[0]
    warnings.append(
        "The rest offsets come from a template of an average adult, because the file has "
        "only the body's shape. To use the body's own offsets, add an array 'J' with the positions "
        "of its "
        "joints at rest."
    )
    return Skeleton(body.names, body.parents, offsets, body.ends), offsets[0]


def _repeated(
    archive: Arrays,
    layout: PoseNames,
    poses: NDArray[Any],
    names: tuple[str, ...],
    warnings: list[str],
) -> tuple[PosePart, ...]:
    """Return the arrays that repeat numbers of the poses exactly, bit by bit."""
    found = []
    parts = {part.name for part in layout.parts}
    those = repr(POSES) if POSES in parts else "the array of poses"
    for name, (first, last) in PARTS.items():
        if name not in archive or name in parts:
            continue
        if last not in names:
            if name in layout.left:
                warnings.append(f"{name!r} is not read; it is left unchanged.")
            continue
        there = archive.array(name)
        start, stop = 3 * names.index(first), 3 * names.index(last) + 3
        if len(names) == 24 and there.size > len(poses) * (stop - start):
            stop = poses.shape[1]  # SMPL's body includes the hands
        same = poses[:, start:stop]
        equal = (there.size, there.dtype) == (same.size, same.dtype)
        if equal and there.tobytes() == same.tobytes():
            found.append(PosePart(name, start, stop))
        else:
            warnings.append(f"{name!r} differs from {those}; it is left unchanged.")
    return tuple(found)
