"""Write the clip of an exercise in such a way that its decimals do not reveal the errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.formats.bvh import BvhClip, parse_bvh
from twistcore.formats.clip import Clip, create_file_patch_for_motion
from twistcore.skeleton.motion import Motion, check_motion
from twistcore.skeleton.rotation import Array

_MOST = 3  # maximum number of decimals of a degree; finer than any capture, coarser than most files
_ENDS_IN_0 = 0.2  # maximum share of numbers that end in 0; of random numbers, a tenth does
_POSITIONS = 6  # number of decimals of positions, which no error changes


def write_student_exercise_clip(clip: Clip, dirty: Motion, path: Path) -> None:
    """Write a clip with the rotations of `dirty`. All angles have the same number of decimals.

    There are at most as many decimals as in the file of `clip`. With more decimals, trailing zeros
    would reveal which numbers are unchanged. An existing file is replaced atomically.

    Raises TwistError if the clip is not a BVH, and OSError if it cannot be written.
    """
    check_motion(dirty)
    if not isinstance(clip, BvhClip):
        raise TwistError(f"{clip.path}: expected a BVH file for the exercise")
    values = parse_bvh(create_file_patch_for_motion(clip, dirty).data).values.copy()
    turns = [column for layout in clip.channels for column in layout.rotation]
    decimals = np.full(values.shape[1], _POSITIONS)
    decimals[turns] = fine = decimals_of_written_angles(clip.values[:, turns])
    values[:, turns] = np.round(values[:, turns], fine) + 0.0  # avoids -0.000
    form = " ".join(f"%.{k}f" for k in decimals.tolist())
    rows = "\n".join(form % tuple(row) for row in values.tolist())
    header = clip.text[: clip.token_spans[0][0]]
    write_atomically(path, header + rows.encode() + b"\n")


def decimals_of_written_angles(degrees: Array) -> int:
    """Estimate the number of decimals with which angles were written, from their trailing zeros."""
    written = np.unique(degrees[degrees != 0.0])
    for decimals in range(_MOST, 0, -1):
        shorter = np.round(written, decimals - 1) == written
        if not len(written) or np.mean(shorter) < _ENDS_IN_0:
            return decimals
    return 0
