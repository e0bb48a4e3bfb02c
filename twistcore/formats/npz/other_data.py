"""Recognise archives and pickles that have no poses, for example the shape of a body or a model."""

from __future__ import annotations

from pathlib import Path

from twistcore.files.ordinary import open_to_read
from twistcore.formats.npz.archive import names_in
from twistcore.formats.npz.pose_names import SMPL_POSES, has_pose_names

_HEAD = 1 << 16  # number of bytes at the start of a pickle in which names are searched for


def archive_without_poses(path: Path) -> bool:
    """True if no poses are listed in an archive's directory. False for a damaged archive."""
    names = names_in(path)
    return names is not None and not has_pose_names(names)


def pickle_without_poses(path: Path) -> bool:
    """True if no array name of SMPL poses occurs at the beginning of a pickle."""
    try:
        with open_to_read(path) as file:
            return SMPL_POSES.encode() not in file.read(_HEAD)
    except OSError:
        return False
