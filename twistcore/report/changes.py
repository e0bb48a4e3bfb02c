"""Measure the changes that a correction made, and check that nothing else changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import ClipAnalysis, Detection
from twistcore.analysis.correction.protected_measures import (
    NAMES,
    UNITS,
    Hinges,
    ProtectedMeasure,
    protected_measures,
)
from twistcore.detection import Interval
from twistcore.errors import TwistError
from twistcore.export.compare import Difference
from twistcore.formats.bvh import BvhClip
from twistcore.formats.clip import Clip, changed_rotations
from twistcore.formats.reading import read_clip
from twistcore.review import ReviewState
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.work.frozen import dataclass

_ROWS = 4096  # frames compared at a time


@dataclass(frozen=True)
class JointChange:
    """The change of a joint's local rotation by a correction.

    Attributes
    ----------
    joint
        Name of the joint.
    frames
        Number of frames in which the rotation changed.
    max_deg, rms_deg
        Largest and root mean square angle of the change over these frames, in degrees.
    """

    joint: str
    frames: int
    max_deg: float
    rms_deg: float


@dataclass(frozen=True)
class FidelityCheck:
    """The result of comparing a written file with its source.

    Attributes
    ----------
    name
        Name of the written file.
    what
        The compared parts: 'columns' of numbers, compared byte by byte, or 'joints', whose
        rotations are compared bit by bit.
    total
        Number of columns or joints.
    same
        Number of columns or joints without a difference.
    outside
        Number of differences in frames without a correction.
    head
        True if the bytes before the numbers are equal, None if the format has no such part.
    """

    name: str
    what: str
    total: int
    same: int
    outside: int
    head: bool | None


@dataclass(frozen=True)
class MeasureSum:
    """The changes that all corrections caused in one protected measure.

    A protected measure is a quantity that a correction must not make worse.

    Attributes
    ----------
    name, unit
        Name and unit of the measure.
    measured
        Number of corrections for which the measure is defined.
    better, worse
        Number of corrections that improved or worsened it.
    most
        The largest increase by a correction, 0 if there is none.
    rows
        The corrections that worsened it, sorted by chain and frames.
    """

    name: str
    unit: str
    measured: int
    better: int
    worse: int
    most: float
    rows: tuple[WorseRow, ...]


@dataclass(frozen=True)
class WorseRow:
    """A correction of a chain in frames [start, stop) that made a measure of a joint worse."""

    chain: str
    start: int
    stop: int
    joint: str
    before: float
    after: float


def sum_correction_effects_on_measures(
    motion: Motion,
    chains: Sequence[Chain],
    applied: Sequence[Interval],
    finds: Sequence[Interval],
) -> tuple[MeasureSum, ...]:
    """Return how the corrections changed each protected measure of limbs and their neighbours.

    A protected measure is a quantity that a correction must not make worse.

    Parameters
    ----------
    motion
        The motion before the correction.
    chains
        The chains and limbs.
    applied
        The corrected intervals. Each one is measured with all others corrected, too.
    finds
        All intervals of the clip.
    """
    hinges = Hinges(motion, finds)
    every: dict[str, list[tuple[Interval, ProtectedMeasure]]] = {name: [] for name in NAMES}
    for interval in applied:
        for one in protected_measures(motion, chains, interval, hinges, applied):
            every[one.name].append((interval, one))
    return tuple(_sum_of(name, found) for name, found in every.items() if found)


def _sum_of(name: str, found: Sequence[tuple[Interval, ProtectedMeasure]]) -> MeasureSum:
    least = 1e-6  # smaller changes are rounding errors, in any unit
    return MeasureSum(
        name,
        UNITS[name],
        len(found),
        sum(m.growth < -least for _, m in found),
        sum(m.worse for _, m in found),
        max(0.0, *(m.growth for _, m in found)),
        tuple(
            WorseRow(i.chain, i.start, i.stop, m.joint, m.before, m.after)
            for i, m in found
            if m.worse
        ),
    )


def joint_changes(before: Motion, after: Motion, difference: Difference) -> tuple[JointChange, ...]:
    """Return the changes of all joints whose rotation differs, in the order of `difference`."""
    spans: dict[str, list[tuple[int, int]]] = {}
    for run in difference.joints:
        spans.setdefault(run.joint, []).append((run.start, run.stop))
    out = []
    for joint, runs in spans.items():
        at = before.skeleton.index(joint)
        frames = np.concatenate([np.arange(*run) for run in runs])
        angle = np.degrees(
            geodesic_angle(before.rotations[frames, at], after.rotations[frames, at])
        )
        rms = float(np.sqrt(np.mean(angle**2)))
        out.append(JointChange(joint, len(frames), float(angle.max()), rms))
    return tuple(out)


def check_fidelity_of_written_clip(clip: Clip, refined: Motion, written: Path) -> FidelityCheck:
    """Read a written file and compare it with its source.

    `refined` is the corrected motion. Raises TwistError if the file cannot be read or has a
    different number of frames, joints or columns.
    """
    again = read_clip(written)
    head: bool | None = None
    if isinstance(clip, BvhClip) and isinstance(again, BvhClip):
        what, differs = "columns", ~_same_numbers(clip, again)
        head = clip.text[: clip.data_start] == again.text[: again.data_start]
    elif again.motion.rotations.shape == clip.motion.rotations.shape:
        what, differs = "joints", (again.motion.rotations != clip.motion.rotations).any(axis=-1)
    else:
        raise TwistError(
            f"{written} does not have the same number of frames and joints as {clip.name}"
        )
    corrected = changed_rotations(clip, refined).any(axis=1)
    corrected |= (clip.motion.positions != refined.positions).any(axis=(1, 2))
    same = int((~differs.any(axis=0)).sum())
    outside = int(differs[~corrected].sum())
    return FidelityCheck(written.name, what, differs.shape[1], same, outside, head)


def _same_numbers(one: BvhClip, other: BvhClip) -> NDArray[np.bool_]:
    """Return a mask of the numbers that have the same bytes in both clips, (frames, columns)."""
    shape = one.values.shape
    if other.values.shape != shape:
        raise TwistError(
            f"{other.path} does not have the same number of frames and columns as {one.name}"
        )
    texts = [np.frombuffer(clip.text, np.uint8) for clip in (one, other)]
    spans = [clip.token_spans for clip in (one, other)]
    same = np.empty(shape[0] * shape[1], np.bool_)
    step = _ROWS * shape[1]
    for a in range(0, len(same), step):
        starts = [s[a : a + step] for s, _ in spans]
        lengths = [e[a : a + step] - s for (_, e), s in zip(spans, starts, strict=True)]
        alike = lengths[0] == lengths[1]
        for k in range(int(lengths[0].max(initial=0))):
            letters = [
                text[np.minimum(s + k, len(text) - 1)]
                for text, s in zip(texts, starts, strict=True)
            ]
            alike &= (k >= lengths[0]) | (letters[0] == letters[1])
        same[a : a + step] = alike
    return same.reshape(shape)


def detect_remaining_errors(
    refined: Motion, chains: Sequence[Chain], state: ReviewState
) -> Detection:
    """Detect errors in the corrected motion, with the review's detector and τ."""
    analysis = ClipAnalysis(refined, chains, rig=state.rig)
    found = analysis.detect(state.method, tau_radians=dict(state.tau))
    known = {name: t for name, t in found.tau.items() if name in state.tau}
    return replace(found, tau=known, intervals=tuple(i for i in found if i.chain in known))
