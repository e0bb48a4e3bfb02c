"""Many clips: what is in each, worst first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from twistcore.analysis import detect
from twistcore.bvh import read_bvh
from twistcore.detection import DEFAULT_METHOD, Interval
from twistcore.refinement import applied_unasked
from twistcore.tuning import Profile


@dataclass(frozen=True)
class ClipSurvey:
    """A clip at a glance: frames, frames a second, intervals found, and their severity."""

    path: Path
    frames: int
    fps: float
    intervals: int
    severity: float


def survey(path: Path, profile: Profile | None = None) -> ClipSurvey:
    """Read and analyse a clip, at a profile's τ where there is one; raises TwistError."""
    clip, profile = read_bvh(path), profile or Profile({})
    found = detect(clip, method=profile.method or DEFAULT_METHOD, tau_radians=profile.tau)
    frames, fps = clip.motion.frames, clip.motion.fps
    return ClipSurvey(path, frames, fps, len(found), severity(found, frames))


def severity(intervals: Iterable[Interval], frames: int) -> float:
    """How bad a clip is: the mean error a frame, degrees summed over all chains.

    Each interval counts by its confidence, so that doubtful ones do not push a clip to the top.
    """
    total = sum(
        float(np.degrees(np.abs(i.offset)).sum()) * (1.0 if i.confidence is None else i.confidence)
        for i in applied_unasked(intervals)
    )
    return total / max(frames, 1)
