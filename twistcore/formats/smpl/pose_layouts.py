"""Find the poses of a person in a pose file, in any of the layouts that pose estimators write."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from twistcore.formats.smpl.pose_files import (
    PosesError,
    describe_pose_file_value,
    printable_pose_file_text,
)
from twistcore.formats.smpl.pose_rotations import check_smpl_pose_values, quaternions_from_poses
from twistcore.formats.smpl.skeleton import JOINTS
from twistcore.skeleton.resampling import interpolate_poses_at_times
from twistcore.skeleton.rotation import Array

Names: TypeAlias = dict[Any, Any]
RATES = ("mocap_framerate", "mocap_frame_rate", "fps", "frame_rate")  # names of the frame rate
# The names of an array with the poses of all joints and of the root's position, and the axis that
# points up. World coordinates are preferred to camera coordinates, in which y points down.
_WHOLE = (
    ("pose_world", "trans_world", "y"),
    ("poses", "trans", "z"),
    ("pose", "trans", "-y"),
    ("pred_rotmat", "pred_trans", "-y"),
)
_ROOT, _BODY = ("global_orient", "root_orient"), ("body_pose", "pose_body")
# Positions relative to a camera with an assumed focal length. The depth may be tens of metres and
# may jump.
_CAMERA = ("pred_cam_t", "cam_t", "camera")
_PLACE = ("transl", "trans", "cam_trans", *_CAMERA)
_FRAMES = ("frame_ids", "frame")
_ROWS_AT = "reorganize_idx"  # the frame number of each row
_OFFSETS = "offsets"
_UP = "up"  # a name that this module adds for the up axis of a layout
_COUNTS = (24, 22, 52, 55)  # numbers of joints: SMPL, SMPL without hands, SMPL-H and SMPL-X
_BODY_JOINTS = 22  # joints without the hands, which are the same in all layouts
_NUMERIC = (np.ndarray, np.generic, float, int)
_MOST = 1_000_000  # maximum number of frames, hours of video
_UNSEEN = 100_000  # maximum number of missing frames, an hour
_PERSONS = 10_000  # maximum number of people


@dataclass(frozen=True, eq=False)
class Poses:
    """The poses of one person in the axes of the file, one for each frame of the video.

    Attributes
    ----------
    rotations
        Local rotations of the 24 joints relative to SMPL's rest pose, shape (frames, 24, 4).
    places
        The root's positions, metres, shape (frames, 3).
    up
        The up axis of the layout: 'y', 'z' or '-y'; None if unknown.
    rate
        The number of frames per second, None if unknown.
    offsets
        The rest offsets in the file, metres, shape (24, 3); None if there are none.
    notes
        A sentence for each assumption and each skipped part.
    """

    rotations: Array
    places: Array
    up: str | None
    rate: float | None
    offsets: Array | None
    notes: tuple[str, ...] = ()


def find_poses(path: Path, names: Names, person: str | None = None) -> Poses:
    """Return the poses of one person in a file.

    `names` contains the contents of the file, and `person` is the number of the person in the file,
    which is required if there are several people. Missing frames are interpolated, and a note
    reports this. Raises PosesError if the poses cannot be found.
    """
    persons = _persons(path, names)
    if None in persons:
        if person is not None:
            raise PosesError(f"{path} contains one person without a number; leave --person out")
        return _poses(path, persons[None])
    if not persons:
        raise PosesError(f"{path} contains no person")
    if len(persons) > 1 if person is None else person not in persons:
        wanted = (
            "--person to choose one" if person is None else f"a person in the file, not {person}"
        )
        some = list(persons.items())[:30]
        who = printable_pose_file_text(", ".join(f"{k} ({_frames(v)} frames)" for k, v in some))
        raise PosesError(f"{path}: expected {wanted}; the file contains {who}")
    return _poses(path, persons[next(iter(persons)) if person is None else person])


# -- persons ---------------------------------------------------------------------------------------


def _persons(path: Path, names: Names, *, inside: bool = False) -> dict[Any, Names]:
    """Return the arrays of each person, keyed by number, or by None if people have no numbers.

    `inside` is True for the contents of a dict within the dict of the file. Only one such level is
    opened, since a dict in a pickle may contain itself.
    """
    if not inside and isinstance(held := names.get("outputs"), dict):
        return _persons(path, held, inside=True)
    if not inside and isinstance(held := names.get("smpl_params_global"), dict):
        return {k: {**v, _UP: "y"} for k, v in _persons(path, held, inside=True).items()}
    if "smpl_thetas" in names:
        return _by_rows(path, names)
    if _is_layout(names):
        return _by_axis(path, names)
    if names and all(isinstance(v, dict) for v in names.values()):
        if any("smpl" in v and "tid" in v for v in names.values()):
            return _by_frames(names)
        if all(_is_layout(v) for v in names.values()):
            return {str(k): v for k, v in names.items()}
    raise PosesError(
        f"{path}: expected 'poses' and 'trans', or 'global_orient', 'body_pose' and 'transl', "
        f"or an estimator's names (docs/quamo.md); found {describe_pose_file_value(names)}"
    )


def _is_layout(names: Names) -> bool:
    whole = any(pose in names for pose, _, _ in _WHOLE)
    return whole or (_first(names, _ROOT) is not None and _first(names, _BODY) is not None)


def _by_axis(path: Path, names: Names) -> dict[Any, Names]:
    """Split arrays whose first axis is the person, and return the arrays of each person.

    The array of the root's position must have this axis as well. A second axis of length 1 means
    that each person has a single frame, but only if the poses have this axis too, since no body has
    only one joint.
    """
    place = names.get(_first(names, _PLACE) or "")
    if not isinstance(place, np.ndarray) or place.ndim != 3:
        return {None: names}
    bodies = [_shape(names[n]) for n in (*(row[0] for row in _WHOLE), *_BODY) if n in names]
    if place.shape[1] == 1 and not any(len(s) > 2 and s[1] == 1 for s in bodies):
        return {None: names}
    _check_persons(path, len(place))
    used = {n for row in _WHOLE for n in row[:2]} | {*_ROOT, *_BODY, *_PLACE}
    for name in used & names.keys():
        if _shape(names[name])[:1] != place.shape[:1]:
            raise PosesError(
                f"{path}: expected {len(place)} people in {name}, found "
                f"{describe_pose_file_value(names[name])}"
            )
    own = {n: names[n] for n in used & names.keys()}
    shared = {n: names[n] for n in (*RATES, *_FRAMES, _OFFSETS, _UP) if n in names}
    return {str(k): {**{n: v[k] for n, v in own.items()}, **shared} for k in range(len(place))}


def _check_persons(path: Path, count: int) -> None:
    if count > _PERSONS:
        raise PosesError(f"{path}: expected at most {_PERSONS} people, found {count}")


def _by_rows(path: Path, names: Names) -> dict[Any, Names]:
    """Split arrays with one row per person and frame, and return the arrays of each person.

    World coordinates are used if the file has them.
    """
    wanted = ("smpl_thetas", "world_trans", "world_global_rots", "cam_trans", "track_ids", _ROWS_AT)
    arrays = {n: _numbers(path, names, n) for n in wanted if n in names}
    rows = len(arrays["smpl_thetas"]) if arrays["smpl_thetas"].ndim else 0
    for name, values in arrays.items():
        if not rows or values.shape[:1] != (rows,):
            raise PosesError(
                f"{path}: expected {rows or 'some'} rows in {name}, found {values.shape}"
            )
        arrays[name] = values.reshape(rows, -1)
    poses, place = arrays["smpl_thetas"], arrays.get("cam_trans")
    if {"world_trans", "world_global_rots"} <= arrays.keys():
        poses = np.concatenate([arrays["world_global_rots"], poses[:, 3:]], axis=1)
        place = arrays["world_trans"]
    if place is None:
        raise PosesError(f"{path}: expected the root's position in 'world_trans' or 'cam_trans'")
    ids = arrays.get("track_ids", np.zeros((rows, 1)))[:, 0]
    out: dict[Any, Names] = {}
    persons, which, counts = np.unique(ids, return_inverse=True, return_counts=True)
    _check_persons(path, len(persons))
    every = np.split(np.argsort(which, kind="stable"), np.cumsum(counts)[:-1])
    for who, own in zip(persons, every, strict=True):
        # World coordinates are those of the camera in the first frame, so y points down.
        record = {"pose": poses[own], "trans": place[own]}
        at = arrays[_ROWS_AT][own, 0] if _ROWS_AT in arrays else None
        out[f"{who:g}"] = record if at is None else {**record, "frame_ids": at}
    return out


def _by_frames(names: Names) -> dict[Any, Names]:
    """Convert a dict of frames, each with the data of its people, to arrays for each person.

    Frames in which a person was not visible are skipped, because they only repeat the last pose.
    """
    out: dict[Any, Names] = {}
    for k, frame in enumerate(names.values()):
        lists = [_items(frame.get(n)) for n in ("tid", "smpl", "camera")]
        unseen = [str(time) != "0" for time in _items(frame.get("tracked_time"))]
        for row, (who, pose, place) in enumerate(zip(*lists, strict=False)):
            if not isinstance(pose, dict) or any(unseen[row : row + 1]):
                continue
            record = out.setdefault(str(who), {"frame_ids": [], "camera": []})
            record["frame_ids"].append(frame.get("time", k))
            record["camera"].append(place)
            for name in (*_ROOT[:1], *_BODY[:1]):
                record.setdefault(name, []).append(pose.get(name))
    return out


def _items(found: Any) -> list[Any]:
    return list(found) if isinstance(found, list) or _shape(found) else []


def _shape(found: Any) -> tuple[int, ...]:
    return found.shape if isinstance(found, np.ndarray) else ()


def _frames(names: Names) -> int:
    """Return the number of frames of a person, for use in a message."""
    shapes = [_shape(names[n]) for n in ("trans_world", *_PLACE) if n in names]
    return shapes[0][0] if shapes and shapes[0] else 0


# -- one person ------------------------------------------------------------------------------------


def _poses(path: Path, names: Names) -> Poses:
    """Return the poses of one person, given the arrays of this person.

    Raises PosesError, which names the wrong array and, if possible, the frame.
    """
    notes: list[str] = []
    up: str | None
    rows = [row for row in _WHOLE if row[0] in names]
    row = next((row for row in rows if row[1] in names), rows[0] if rows else None)
    if row:
        pose, trans, up = row
        rotations = quaternions_from_poses(path, pose, _numbers(path, names, pose), _COUNTS, notes)
    else:
        root, body = _first(names, _ROOT) or "", _first(names, _BODY) or ""
        trans, up = _first(names, _PLACE) or "", "y" if str(names.get(_UP)) == "y" else None
        if not trans:
            raise PosesError(
                f"{path}: expected the root's position, of shape frames x 3, in one of "
                f"{', '.join(_PLACE)}"
            )
        parts = [
            quaternions_from_poses(path, name, _numbers(path, names, name), counts, notes)
            for name, counts in ((root, (1,)), (body, (23, 21)))
        ]
        if len(parts[0]) != len(parts[1]):
            raise PosesError(
                f"{path}: expected as many frames in {root} as in {body}, found "
                f"{len(parts[0])} and {len(parts[1])}"
            )
        rotations = np.concatenate(parts, axis=1)
        if trans in _CAMERA:
            up = "-y"
            notes.append(
                f"The root's position is {trans!r}, in front of a camera whose focal length was "
                "assumed: its depth was not measured and is held constant."
            )
    frames, count = rotations.shape[:2]
    if frames > _MOST:
        raise PosesError(f"{path}: expected at most {_MOST} frames, found {frames}")
    whole = np.zeros((frames, JOINTS, 4))
    whole[..., 0] = 1.0
    kept = JOINTS if count == JOINTS else _BODY_JOINTS
    whole[:, :kept] = rotations[:, :kept]
    places = _numbers(path, names, trans)
    if places.shape == (frames, 1, 3):
        places = places[:, 0]
    if places.shape != (frames, 3):
        raise PosesError(f"{path}: expected {trans} of shape ({frames}, 3), found {places.shape}")
    check_smpl_pose_values(path, trans, places)
    if trans in _CAMERA:
        places = np.column_stack([places[:, :2], np.full(frames, np.median(places[:, 2]))])
    offsets = _numbers(path, names, _OFFSETS) if _OFFSETS in names else None
    poses = Poses(whole, places, up, _rate(path, names), offsets, tuple(notes))
    numbered = _first(names, _FRAMES)
    return _at_frames(path, names, numbered, poses) if numbered else poses


def _at_frames(path: Path, names: Names, numbered: str, poses: Poses) -> Poses:
    """Interpolate missing frames, so that there is a pose for each frame number.

    `numbered` is the name of the array with the frame number of each pose.
    """
    ids = _numbers(path, names, numbered).ravel()
    if len(ids) != len(poses.rotations):
        raise PosesError(
            f"{path}: expected {len(poses.rotations)} numbers in {numbered}, found {len(ids)}"
        )
    if not (np.isfinite(ids).all() and (np.diff(ids) > 0).all() and (ids == np.rint(ids)).all()):
        raise PosesError(f"{path}: expected increasing whole numbers in {numbered}")
    span = int(ids[-1] - ids[0]) + 1
    if span == len(ids):
        return poses
    if span > min(_MOST, 20 * len(ids), len(ids) + _UNSEEN):
        raise PosesError(
            f"{path}: too many frames are missing: {numbered} lists {len(ids)} of {span} frames"
        )
    times = np.interp(np.arange(ids[0], ids[-1] + 1), ids, np.arange(len(ids)))
    rotations, places = interpolate_poses_at_times(poses.rotations, poses.places, times)
    first = int(ids[np.argmax(np.diff(ids) > 1)]) + 1
    note = (
        f"{span - len(ids)} of {span} frames are missing, at most {int(np.diff(ids).max()) - 1} in "
        f"a row; the first is frame {first}. They are interpolated between their neighbours."
    )
    return replace(poses, rotations=rotations, places=places, notes=(*poses.notes, note))


def _first(names: Names, wanted: tuple[str, ...]) -> str | None:
    return next((name for name in wanted if name in names), None)


def _numbers(path: Path, names: Names, name: str) -> Array:
    """Return the named array as float64, after stacking a list of arrays of the same shape."""
    found = names.get(name)
    if found is None:
        raise PosesError(
            f"{path}: expected the array {name!r}, found {describe_pose_file_value(names)}"
        )
    if isinstance(found, list) and all(isinstance(item, _NUMERIC) for item in found):
        if len({np.shape(item) for item in found}) == 1:
            found = np.stack([np.asarray(item) for item in found])
    elif isinstance(found, _NUMERIC):
        found = np.asarray(found)
    if not isinstance(found, np.ndarray) or found.dtype.kind not in "fiu":
        raise PosesError(
            f"{path}: expected numbers in {name!r}, found {describe_pose_file_value(found)}"
        )
    with np.errstate(invalid="ignore", over="ignore"):  # a signalling NaN causes a warning
        return np.asarray(found, dtype=np.float64)


def _rate(path: Path, names: Names) -> float | None:
    name = _first(names, RATES)
    if name is None:
        return None
    values = _numbers(path, names, name)
    if values.size != 1 or not (np.isfinite(values).all() and values.item() > 0.0):
        raise PosesError(f"{path}: expected a rate above 0 in {name!r}; set it with --fps")
    return float(values.item())
