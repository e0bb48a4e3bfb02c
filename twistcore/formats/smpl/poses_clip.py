"""Convert poses of SMPL's joints, as in files of AMASS or video pose estimators, to a clip."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from twistcore.errors import TwistError
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.bvh.compose import bvh_text
from twistcore.formats.clip import LONGEST, SHORTEST, Clip, ClipWarning
from twistcore.formats.smpl.pose_files import PosesError, read_pose_file
from twistcore.formats.smpl.pose_layouts import Poses, find_poses
from twistcore.formats.smpl.rest_pose import smpl_rest_pose_change
from twistcore.formats.smpl.skeleton import (
    JOINTS,
    find_network_joints,
    make_smpl_skeleton,
    metres_per_unit,
)
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, multiply, quaternion_from_axis_angle, rotate

# The rotation about x, in radians, from a file with this axis up to a clip with y up.
_TURNS = {"y": 0.0, "z": -0.5 * np.pi, "-y": np.pi}


def read_smpl_poses_as_clip(
    path: Path,
    *,
    template: Path | None = None,
    unit: float | None = None,
    fps: float | None = None,
    up: str | None = None,
    person: str | None = None,
) -> Clip:
    """Read the poses of one person as a clip, in metres and with y up (docs/quamo.md, *Use*).

    The bone lengths come from a template or from an array `offsets` in the file, shape (24, 3), in
    metres. If the file has `offsets`, they also define the rest pose and the root's rest position,
    even if a template is given. The warnings of the clip list all assumptions.

    Parameters
    ----------
    path
        The pose file.
    template
        A BVH file with the 24 joints, whose rest pose may differ from SMPL's (see `rest_pose`).
    unit
        The length of one unit of the template in metres, by default the unit of CMU's clips.
    fps
        The frame rate to use instead of the file's.
    up
        The axis that points up in the file: 'y', 'z' or '-y'. By default, the up axis of the
        file's layout or, if unknown, the axis along which the figure is upright.
    person
        The number of the person, required if there are several people.

    Raises
    ------
    TwistError
        If the file or the template does not contain suitable poses or joints (`PosesError`), or if
        the template is not a BVH file (`BvhError`).
    OSError
        If a file cannot be read.
    """
    poses = find_poses(path, read_pose_file(path), person)
    rate = poses.rate if fps is None else fps
    if rate is None:
        raise PosesError(f"{path} has no frame rate; set the frame rate of the video with --fps")
    if not SHORTEST <= 1.0 / rate <= LONGEST:
        raise PosesError(
            f"{path}: expected a rate from 1 to 10,000 frames per second, found {rate:g}"
        )
    offsets, rotations, notes = _on_skeleton(path, poses, template, unit)
    axis, said = _upwards(poses, up)
    turn = quaternion_from_axis_angle(np.array([1.0, 0.0, 0.0]), _TURNS[axis])
    rotations[:, 0] = multiply(turn, rotations[:, 0])
    # SMPL rotates the root about its rest position, so this position is added in the file's axes.
    places = rotate(turn, poses.places + offsets[0])
    motion = Motion(make_smpl_skeleton(offsets), rotations, (0,), places[:, None], 1.0 / rate)
    clip = parse_bvh(bvh_text(motion).encode("utf-8", "surrogateescape"), path)
    told = tuple(ClipWarning(text) for text in (*poses.notes, *notes, *said))
    return replace(clip, warnings=clip.warnings + told)


def _on_skeleton(
    path: Path, poses: Poses, template: Path | None, unit: float | None
) -> tuple[Array, Array, tuple[str, ...]]:
    """Return the rest offsets of the clip, the rotations relative to its rest pose, and notes.

    The offsets are in metres, (24, 3), and the rotations have the shape (frames, 24, 4).
    """
    given = poses.offsets
    if given is not None and (given.shape != (JOINTS, 3) or not np.isfinite(given).all()):
        raise PosesError(f"{path}: expected finite offsets of shape (24, 3), found {given.shape}")
    if template is None:
        if given is None:
            raise PosesError(
                f"{path} has no rest offsets; specify a BVH file with --template, or add an array "
                "'offsets' in metres with the shape (24, 3)"
            )
        return given, poses.rotations.copy(), ()
    source = read_bvh(template).skeleton
    try:
        offsets = find_network_joints(source).offsets
        offsets = metres_per_unit(source, unit) * offsets
        offsets[0] = 0.0  # the rest position of a template's root has no meaning
        change = smpl_rest_pose_change(offsets, given)
    except TwistError as error:
        raise PosesError(f"{template}: {error}") from None
    if given is not None:
        offsets[0] = given[0]
    return offsets, change.carried(poses.rotations), change.notes


def _upwards(poses: Poses, asked: str | None) -> tuple[str, tuple[str, ...]]:
    """Return the axis that points up in the file, and notes if it was assumed or seems wrong.

    `asked` is the axis that the user chose, or None.
    """
    # The mean direction of the pelvis's y axis, which points up in SMPL's rest pose.
    mean = rotate(poses.rotations[:, 0], np.array([0.0, 1.0, 0.0])).mean(axis=0)
    along = {"y": mean[1], "z": mean[2], "-y": -mean[1]}
    stands = max(along, key=lambda name: float(along[name]))
    axis = asked or poses.up or stands
    notes = []
    if asked is None:
        why = "as usual in this layout" if poses.up else "the figure is then upright"
        notes.append(
            f"The file's {axis} axis is taken as up ({why}); choose another axis with --up."
        )
    if along[axis] < 0.3 and along[stands] > 0.6:
        notes.append(f"With {axis} up, the figure is not upright; with --up={stands}, it is.")
    return axis, tuple(notes)
