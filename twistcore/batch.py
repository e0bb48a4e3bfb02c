"""Many clips: what is in each, worst first."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from twistcore.bvh import read_bvh
from twistcore.chain import find_chains
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Interval, resolve_tau
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
    motion = read_bvh(path).motion
    chains = find_chains(motion)
    method = (profile.method if profile else "") or DEFAULT_METHOD
    analysis = DETECTORS[method].analyse(motion, chains)
    tau = resolve_tau(analysis, chains, profile.tau if profile else None)
    found = [i for name, t in tau.items() for i in analysis.intervals(name, t)]
    return ClipSurvey(path, motion.frames, motion.fps, len(found), severity(found, motion.frames))


def severity(intervals: Iterable[Interval], frames: int) -> float:
    """How bad a clip is: the mean error a frame, degrees summed over all chains.

    Each interval counts by its confidence, so that doubtful ones do not push a clip to the top.
    """
    total = sum(
        float(np.degrees(np.abs(i.offset)).sum()) * (1.0 if i.confidence is None else i.confidence)
        for i in intervals
        if not i.open
    )
    return total / max(frames, 1)
