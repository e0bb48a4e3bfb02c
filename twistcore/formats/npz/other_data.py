"""Recognise archives and pickles without poses, such as files with a body's shape."""

from __future__ import annotations

from pathlib import Path

from twistcore.files.ordinary import open_to_read
from twistcore.formats.npz.archive import array_names_in
from twistcore.formats.npz.pose_names import SMPL_POSES, has_pose_names

_HEAD = 1 << 16  # number of bytes at the beginning of a pickle that are searched for names


def archive_without_poses(path: Path) -> bool:
    """Return True if an archive's directory lists no poses. A damaged archive gives False."""
    names = array_names_in(path)
    return names is not None and not has_pose_names(names)


def pickle_without_poses(path: Path) -> bool:
    """Return True if the beginning of a pickle does not contain the name of SMPL poses."""
    try:
        with open_to_read(path) as file:
            return SMPL_POSES.encode() not in file.read(_HEAD)
    except OSError:
        return False
