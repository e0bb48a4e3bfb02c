"""From the bytes of an AMASS .npz to a Clip."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.clip import LONGEST, SHORTEST, ClipWarning
from twistcore.errors import NpzError
from twistcore.motion import Skeleton
from twistcore.npz.archive import LARGEST, Archive, open_archive, too_large
from twistcore.npz.body import BODIES, BODY, MODELS
from twistcore.npz.npz_clip import POSES, TRANS, NpzClip, SamePoses
from twistcore.ordinary_files import read_file
from twistcore.progress import Tell, nobody
from twistcore.rotation import Array

_RATES = ("mocap_framerate", "mocap_frame_rate", "fps", "frame_rate")
_ASSUMED_FPS = 30.0
_ASSUMED = f"{_ASSUMED_FPS:g} frames a second are assumed (the commands' --fps says otherwise)"
_FRAMES = 1_000_000  # hours of motion
# Poses as estimators name them, which another command reads.
_ELSEWHERE = (
    "global_orient", "root_orient", "body_pose", "pose_body", "pose_world", "pose", "pred_rotmat",
    "smpl_thetas", "smpl_params_global", "outputs",
)  # fmt: skip
_LEFT_EYE, _RIGHT_EYE = "left_eye_smplhf", "right_eye_smplhf"
# Arrays that may repeat the numbers of joints, from the first to the last of them.
_PARTS = {
    "root_orient": ("pelvis", "pelvis"), "global_orient": ("pelvis", "pelvis"),
    "pose_body": ("left_hip", "right_wrist"), "body_pose": ("left_hip", "right_wrist"),
    "pose_hand": ("left_index1", "right_thumb3"), "left_hand_pose": ("left_index1", "left_thumb3"),
    "right_hand_pose": ("right_index1", "right_thumb3"), "pose_jaw": ("jaw", "jaw"),
    "jaw_pose": ("jaw", "jaw"), "pose_eye": (_LEFT_EYE, _RIGHT_EYE),
    "leye_pose": (_LEFT_EYE, _LEFT_EYE), "reye_pose": (_RIGHT_EYE, _RIGHT_EYE),
}  # fmt: skip


def read_npz(path: str | Path, *, fps: float | None = None, tell: Tell = nobody) -> NpzClip:
    """Read an .npz as AMASS has them (docs/amass.md); fps: instead of the file's; tell: how far.

    Nothing in it is run. Raises NpzError, one sentence, for what is something else or damaged; what
    was assumed is in Clip.warnings.
    """
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST:
            raise too_large(path)
        data = read_file(path)
    except FileNotFoundError:
        raise NpzError(f"{path}: expected an .npz, but there is no such file") from None
    except IsADirectoryError:
        raise NpzError(f"{path}: expected an .npz, but this is a folder") from None
    except OSError as error:
        raise NpzError(f"{path}: cannot be read ({error.strerror})") from None
    return parse_npz(data, path, fps=fps, tell=tell)


def parse_npz(
    data: bytes, path: str | Path = "clip.npz", *, fps: float | None = None, tell: Tell = nobody
) -> NpzClip:
    """The same from bytes in memory."""
    path = Path(path)
    archive = open_archive(path, data)
    warnings: list[str] = []
    poses = _poses(archive)
    joints = poses.shape[1] // 3
    tell(0.5)
    trans = _numbers(archive, TRANS)
    if trans.shape != (len(poses), 3):
        raise NpzError(f"{path}: expected {TRANS} of shape ({len(poses)}, 3), found {trans.shape}")
    _check_finite(archive, TRANS, trans)
    frame_time = 1.0 / fps if fps is not None else _frame_time(archive, warnings)
    skeleton, rest = _skeleton(archive, joints, warnings)
    repeated = _repeated(archive, poses, skeleton.names, warnings)
    tell(1.0)
    return NpzClip(
        path=path,
        data=data,
        skeleton=skeleton,
        frame_time=frame_time,
        warnings=tuple(map(ClipWarning, warnings)),
        archive=archive,
        poses=poses,
        trans=trans,
        rest=rest,
        repeated=repeated,
    )


def _poses(archive: Archive) -> NDArray[Any]:
    """Rotation vectors, (frames, 3 joints); NpzError where they are none, or of another body."""
    path = archive.path
    if POSES not in archive:
        also = any(name in archive for name in _ELSEWHERE)
        other = " (`twistcore quamo refine` reads other layouts)" if also else ""
        raise NpzError(
            f"{path}: expected the arrays {POSES!r} and {TRANS!r} of AMASS, found "
            f"{archive.described()}{other}"
        )
    poses = _numbers(archive, POSES)
    joints = poses.shape[1] if poses.ndim == 3 and poses.shape[2] == 3 else 0
    flat = poses.reshape(len(poses), 3 * joints) if joints else poses
    if flat.ndim != 2 or flat.shape[1] not in {3 * n for n in BODIES}:
        shapes = " or ".join(f"{3 * n} ({MODELS[n]})" for n in BODIES)
        raise NpzError(
            f"{path}: expected {POSES} as rotation vectors, frames x {shapes}, found {poses.shape}"
        )
    if not 1 <= len(flat) <= _FRAMES:
        raise NpzError(f"{path}: expected from 1 to {_FRAMES} frames, found {len(flat)}")
    _check_finite(archive, POSES, flat)
    return flat


def _numbers(archive: Archive, name: str) -> NDArray[Any]:
    if name not in archive:
        raise NpzError(f"{archive.path}: expected the array {name!r}, found {archive.described()}")
    found = archive.array(name)
    if found.dtype.kind != "f":
        raise NpzError(
            f"{archive.path}: expected floating-point numbers in {name!r}, found {found.dtype}"
        )
    return found


def _check_finite(archive: Archive, name: str, values: NDArray[Any], row: str = "frame") -> None:
    good = np.abs(values.astype(np.float64)) < 1e6
    if not good.all():
        first = int(np.argwhere(~good)[0, 0])
        raise NpzError(
            f"{archive.path}: expected finite numbers below a million in {name!r}, found "
            f"{values[~good][0]:g} in {row} {first}"
        )


def _frame_time(archive: Archive, warnings: list[str]) -> float:
    """Seconds; where the file tells none that can be meant, those of 30 frames a second."""
    for name in _RATES:
        if name not in archive:
            continue
        found = archive.array(name)
        if found.dtype.kind in "fiu" and found.size == 1:
            rate = float(found.reshape(-1)[0])
            if np.isfinite(rate) and rate > 0.0 and SHORTEST <= 1.0 / rate <= LONGEST:
                return 1.0 / rate
        warnings.append(f"{name} is not usable; {_ASSUMED}.")
        return 1.0 / _ASSUMED_FPS
    warnings.append(f"No frame rate; {_ASSUMED}.")
    return 1.0 / _ASSUMED_FPS


def _skeleton(archive: Archive, joints: int, warnings: list[str]) -> tuple[Skeleton, Array]:
    """The joints by name, and where the root rests, (3,): from the file, or as a template has it.

    'offsets': from the joint above; 'J': places at rest. Of all joints, or of the body's first.
    """
    body = BODIES[joints]
    offsets = body.offsets.copy()
    for name in ("offsets", "J"):
        if name not in archive:
            continue
        given = np.asarray(_numbers(archive, name), dtype=np.float64)
        count = joints if given.shape == (joints, 3) else BODY
        if given.shape not in ((joints, 3), (24, 3), (BODY, 3)):
            raise NpzError(
                f"{archive.path}: expected {name!r} of shape ({joints}, 3), metres, found "
                f"{given.shape}"
            )
        _check_finite(archive, name, given, "joint")
        above = body.parents[:count]
        if name == "J":
            given = given[:count] - np.where((above >= 0)[:, None], given[above], 0.0)
        offsets[:count] = given[:count]
        if count < joints:
            warnings.append(f"Rest offsets of hands are a template's: {name!r} has the body's.")
        return Skeleton(body.names, body.parents, offsets), offsets[0]
    warnings.append(
        "Rest offsets are a template's, an average adult's: the file has only the body's shape. "
        "An array 'J' with the places of its joints at rest makes them its own."
    )
    return Skeleton(body.names, body.parents, offsets, body.ends), offsets[0]


def _repeated(
    archive: Archive, poses: NDArray[Any], names: tuple[str, ...], warnings: list[str]
) -> tuple[SamePoses, ...]:
    """Arrays in which numbers of `poses` stand once more, bit for bit."""
    found = []
    for name, (first, last) in _PARTS.items():
        if name not in archive or last not in names:
            continue
        there = archive.array(name)
        start, stop = 3 * names.index(first), 3 * names.index(last) + 3
        if len(names) == 24 and there.size > len(poses) * (stop - start):
            stop = poses.shape[1]  # SMPL's body goes on to its hands
        same = poses[:, start:stop]
        equal = (there.size, there.dtype) == (same.size, same.dtype)
        if equal and there.tobytes() == same.tobytes():
            found.append(SamePoses(name, start, stop))
        else:
            warnings.append(f"{name!r} is not as in {POSES!r}; it is left as it is.")
    return tuple(found)
