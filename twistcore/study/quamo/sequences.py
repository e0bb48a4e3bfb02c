"""Convert clips to 24 joints, metres and 25 Hz, for networks and tables."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.formats.smpl.skeleton import CMU_UNIT, find_network_joints, smpl_joint_positions
from twistcore.quamo.resample import interpolate_poses_at_times, network_sample_times
from twistcore.skeleton.rotation import Array
from twistcore.work.processes import describe_failure, map_in_processes

HELD_OUT = ("01", "05", "06", "14")


@dataclass(frozen=True, eq=False)
class Sequence24:
    """A true motion of 24 joints at 25 Hz.

    Attributes
    ----------
    name
        Name of the clip.
    subject
        The name of the captured person.
    q
        Local rotations, shape (frames, 24, 4).
    r
        Root positions, metres, shape (frames, 3).
    offsets
        Offsets of the joints from their parents, metres, shape (24, 3).
    """

    name: str
    subject: str
    q: Array
    r: Array
    offsets: Array

    def places_mm(self, q: Array, r: Array) -> Array:
        """Return joint positions in mm.

        `q` are poses, (…, 24, 4), and `r` are root positions in metres, (…, 3).
        """
        return 1000.0 * smpl_joint_positions(self.offsets, q, r)


def read_cmu_bvh_sequence(path: Path) -> Sequence24:
    """Read a BVH clip without frame 0, which is a T-pose in CMU's BVH releases.

    The subject is the part of the file name before '_'. Lengths must be in CMU's unit. Raises
    TwistError if the clip is too short or lacks a joint or root positions.
    """
    motion = read_bvh(path).motion
    try:
        topology = find_network_joints(motion.skeleton)
    except TwistError as error:
        raise TwistError(f"{path}: {error}") from None
    if 0 not in motion.positioned or motion.frames < 20:
        raise TwistError(f"{path}: expected root positions and at least 20 frames")
    motion = motion.sliced(1, motion.frames)
    times = network_sample_times(motion.frames, motion.frame_time)
    q, r = interpolate_poses_at_times(
        topology.reduced(motion.rotations), motion.translation(0), times
    )
    subject = re.split(r"[_ ]", path.stem)[0]
    r = CMU_UNIT * (r - r[:1] * np.array([1.0, 0.0, 1.0]))
    return Sequence24(path.stem, subject, q, r, CMU_UNIT * topology.offsets)


def split_into_windows(sequences: Sequence[Sequence24], frames: int) -> tuple[Sequence24, ...]:
    """Split clips into windows of `frames` frames [Le26 §4.2]. Remaining frames are dropped."""
    return tuple(
        replace(s, name=f"{s.name} {at}", q=s.q[at : at + frames], r=s.r[at : at + frames])
        for s in sequences
        for at in range(0, len(s.q) - frames + 1, frames)
    )


def read_cmu_bvh_sequence_folder(folder: Path) -> tuple[tuple[Sequence24, ...], tuple[str, ...]]:
    """Return a folder's BVH clips, sorted by name, and a sentence for each unusable clip.

    Raises TwistError if there is no BVH file.
    """
    paths = clip_paths_in_folder(folder, suffixes=BVH)
    if not paths:
        raise TwistError(f"{folder}: expected a folder with BVH files")
    found = list(map_in_processes(read_cmu_bvh_sequence, paths, workers=1))
    bad = tuple(
        describe_failure(path, error) for path, error in found if isinstance(error, Exception)
    )
    return tuple(s for _, s in found if isinstance(s, Sequence24)), bad
