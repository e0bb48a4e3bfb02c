"""What can be shown of a clip as soon as it has been read, while it is still being analysed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twistcore.formats.clip import Clip
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.figure import figure_facing_direction, guess_up
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import Array

_ASIDE = np.radians(30.0)  # the figure is seen from this far to the side of its front


@dataclass(frozen=True, eq=False)
class FirstLook:
    """A stick figure of a clip, and the numbers that describe the clip.

    Attributes
    ----------
    name
        The name of the clip's file.
    frames
        The number of frames.
    fps
        The frame rate.
    bones
        The two ends of each bone in the picture, (bones, 2, 2): to the right and up, in the file's
        length unit.
    """

    name: str
    frames: int
    fps: float
    bones: Array


def first_look(clip: Clip) -> FirstLook:
    """Return the first look at a clip: its figure in the middle frame, from the front."""
    motion = clip.motion
    middle = motion.frames // 2
    still = motion.sliced(middle, middle + 1)
    _, positions = forward_kinematics(still)
    chains = find_chains(still)
    up = guess_up(positions, chains, motion.skeleton)
    ahead = figure_facing_direction(positions[0], chains, up)
    seen_from = np.cos(_ASIDE) * ahead + np.sin(_ASIDE) * np.cross(up, ahead)
    across = np.cross(up, seen_from)
    parents = motion.skeleton.parents
    below = np.flatnonzero(parents >= 0)
    ends = np.stack([positions[0, parents[below]], positions[0, below]], axis=1)
    bones = ends @ np.stack([across, up], axis=1)
    return FirstLook(clip.name, motion.frames, motion.fps, bones)
