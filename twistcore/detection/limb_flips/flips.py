"""Find limb flips: compute the swivel of each limb, find its jumps, and explain them by flips."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import field
from functools import partial
from typing import Any

import numpy as np

from twistcore.detection.cuts import find_cuts
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.limb_flips.explanation import (
    Run,
    Unexplained,
    explain_limb_jumps,
    why_unexplained,
)
from twistcore.detection.limb_flips.jumps import (
    SHARP,
    Jump,
    median_around,
    natural_departure_scale,
    rotations_minus_nearby_median,
    sharp_jumps,
    soft_jumps,
)
from twistcore.detection.limb_flips.swivel import Swivel, compute_limb_swivel
from twistcore.detection.noise_bursts import largest_joint_and_ancestor_noise
from twistcore.detection.prediction import Index, Mask
from twistcore.skeleton.chain import group_chains_by_person
from twistcore.skeleton.limb import Limb, joint_path
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    rotate,
    vector_lengths,
    wrap,
)
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress

TAU = float(np.radians(55.0))  # natural departures in 40 CMU clips at 120 Hz reach 51°
SURE = 1.5  # minimum log odds of a flip that is corrected automatically
_BESIDE = 3  # frames on either side of a flip in which the path of the middle joint is measured
# If there are at least SEVERAL limbs and more than the share TOGETHER of them jumps in a frame, the
# whole pose jumps in this frame, as at a cut.
SEVERAL, TOGETHER = 3, 0.5


@dataclass(frozen=True, eq=False)
class LimbFlips:
    """The analysis of one limb, before a threshold is chosen.

    Attributes
    ----------
    limb
        The limb.
    fps
        The frame rate.
    swivel
        The swivel of the limb.
    departures
        The rotation of the limb since the previous frame, minus the median of nearby frames,
        radians, shape (frames,). The rotation is about the line from the first joint to the end.
    capture
        Mask of the frames that are not at a cut or a jump of the whole pose, shape (frames,).
    noisy
        Mask of the frames with a burst of noise in any limb of the person, shape (frames,).
    soft
        The jumps that take several frames.
    """

    limb: Limb
    fps: float
    swivel: Swivel
    departures: Array
    capture: Mask
    noisy: Mask
    soft: tuple[Jump, ...]
    _solved: dict[int, tuple[list[Run], tuple[Interval, ...]]] = field(
        default_factory=dict, init=False
    )

    def intervals(self, tau: float) -> tuple[Interval, ...]:
        """Return the flips at threshold τ in radians, sorted by start."""
        return self._explained(self.jumps(tau))[1]

    def scale_at(self, frames: Index) -> Array:
        """Return the natural magnitude of `departures` near given frames, in radians, (n,)."""
        return natural_departure_scale(self.departures, self.swivel.height, self.fps, frames)

    def steps_at(self, frames: Index) -> Array:
        """Return how far the limb's end moves in given frames, minus its usual movement, (n,).

        The usual movement is the median in nearby frames. The result is a fraction of the limb's
        length, at least 0.
        """
        step = self.swivel.step
        return np.maximum(step[frames] - median_around(step, frames), 0.0)

    def jumps(self, tau: float) -> list[Jump]:
        """Return the jumps of at least τ radians, and smaller ones that may be a flip's other edge.

        The jumps are sorted by start.
        """
        sharp = sharp_jumps(self.departures, self.scale_at, self.steps_at, tau)
        return sorted((*sharp, *self.soft), key=lambda j: (j.start, j.stop))

    def why_unexplained(self, jumps: Sequence[Jump], jump: Jump) -> Unexplained:
        """Return the costs that show why `jump`, one of `jumps`, is not an edge of a flip."""
        runs, _ = self._explained(jumps)
        s = self.swivel
        return why_unexplained(jumps, jump, runs, s.angle, s.height, self.capture, self.fps)

    def _explained(self, jumps: Sequence[Jump]) -> tuple[list[Run], tuple[Interval, ...]]:
        passing = sum(j.leads for j in jumps)  # the number of jumps of at least τ identifies them
        if passing not in self._solved:
            s = self.swivel
            runs = explain_limb_jumps(jumps, s.angle, s.height, self.capture, self.fps)
            self._solved[passing] = runs, tuple(self._interval(run) for run in runs)
        return self._solved[passing]

    def doubts(self, run: Run) -> list[str]:
        """Return the doubts about correcting a flip, as clauses for the user.

        A correction is doubtful near noise, or if it makes the path of the middle joint longer or
        rougher.
        """
        found = []
        if self.noisy[max(run.start - 1, 0) : run.stop + 1].any():
            found.append("there is a burst of noise")
        now, then = measure_flip_effect_on_path(self.swivel, run.start, run.offset)
        if then[0] >= now[0]:
            found.append(f"the {self.limb.middle_word} would travel a longer path")
        elif then[1] >= now[1]:
            found.append(f"the {self.limb.middle_word} would move less smoothly")
        return found

    def departures_without(self, offset: Array) -> Array:
        """Return `departures` as they would be without a flip, in radians, (frames,).

        `offset` contains the angle of the flip in each frame, in radians, (frames,).
        """
        turns = wrap(self.swivel.jump - np.diff(offset, prepend=offset[:1]))
        return np.where(
            self.capture, rotations_minus_nearby_median(np.where(self.capture, turns, 0.0)), 0.0
        )

    def end_carried(self, start: int, offset: Array) -> bool:
        """Return True if the limb's end joint rotated with the limb in a flip.

        In this case, rotating the end joint back makes the jumps at the edges of the flip smaller.
        `start` is the first frame of the flip, and `offset` contains its angles in radians.
        """
        along, kept = (_end_turns(self.swivel, start, offset, along=a) for a in (True, False))
        return along < kept

    def _interval(self, run: Run) -> Interval:
        return Interval(
            self.limb.name,
            run.start,
            run.stop,
            run.offset,
            open=run.odds < SURE or bool(self.doubts(run)),
            confidence=1.0 / (1.0 + math.exp(-min(run.odds, 50.0))),
            residual=run.residual,
            explain=partial(_explained, self, run),
            kind=Kind.LIMB_FLIP,
            carried=self.end_carried(run.start, run.offset),
        )


def measure_flip_effect_on_path(swivel: Swivel, start: int, offset: Array) -> tuple[Array, Array]:
    """Measure the path of a limb's middle joint near a flip, as captured and without the flip.

    `start` is the first frame of the flip, and `offset` contains its angles in radians. Each result
    consists of the length of the path and the total length of its second differences, as fractions
    of the limb's length.
    """
    stop = start + len(offset)
    low = max(start - _BESIDE, 0)
    captured = swivel.child[low : stop + _BESIDE]
    fixed = captured.copy()
    turn = quaternion_from_axis_angle(swivel.line[start:stop], -offset)
    fixed[start - low : stop - low] = rotate(turn, fixed[start - low : stop - low])
    now, then = (
        np.array([vector_lengths(np.diff(c, k, axis=0)).sum() for k in (1, 2)])
        for c in (captured, fixed)
    )
    return now, then


def _end_turns(swivel: Swivel, start: int, offset: Array, *, along: bool) -> float:
    """Return the total rotation of a limb's end at the edges of a flip after its correction.

    The result is in radians. `along` is True if the end rotated with the limb, so that the
    correction rotates the end back too.
    """
    end = swivel.end
    total = 0.0
    for inside, outside, level in (
        (start, start - 1, offset[0]),
        (start + len(offset) - 1, start + len(offset), offset[-1]),
    ):
        if not 0 <= outside < len(end):
            continue
        q = end[inside]
        if along:
            q = multiply(quaternion_from_axis_angle(swivel.line[inside], -level), q)
        total += float(geodesic_angle(q, end[outside]))
    return total


def _explained(limb: LimbFlips, run: Run) -> dict[str, Any]:
    """Return the evidence for a flip, keyed by name.

    Angles are in degrees, and odds are log odds.
    """
    swivel = limb.swivel
    edges = (run.first, *run.followed, run.last)
    (length, roughness), (after, rough_after) = measure_flip_effect_on_path(
        swivel, run.start, run.offset
    )
    return {
        "edges": [_edge(j) for j in edges],
        "closing_residual_deg": math.degrees(run.residual),
        "side": run.side,
        "odds": run.odds,
        "path": float(length),
        "path_corrected": float(after),
        "path_roughness": float(roughness),
        "path_roughness_corrected": float(rough_after),
        "doubts": limb.doubts(run),
    }


def _edge(jump: Jump) -> dict[str, Any]:
    return {
        "start": jump.start,
        "stop": jump.stop,
        "jump_deg": math.degrees(jump.turn),
        "sigma_deg": math.degrees(jump.scale),
        "sharp": jump.sharp,
    }


@dataclass(frozen=True, eq=False)
class LimbFlipAnalysis:
    """The analysis of all limbs, before a threshold is chosen. It implements `Analysis`.

    `limbs` contains the analysis of each limb, keyed by the limb's name.
    """

    limbs: Mapping[str, LimbFlips]

    def automatic_tau(self, limb: str) -> float:
        """Return the automatic τ in radians, which is the same for all limbs."""
        del limb
        return TAU

    def strength(self, limb: str) -> Array:
        """Return the strength of a limb, the magnitude of its departures, in radians, (frames,).

        A departure is the limb's rotation since the previous frame minus the median of nearby
        frames.
        """
        return np.abs(self.limbs[limb].departures)

    def intervals(self, limb: str, tau: float) -> tuple[Interval, ...]:
        """Return the flips of a limb at threshold τ in radians, sorted by start."""
        return self.limbs[limb].intervals(tau)


def analyse_limbs(
    motion: Motion, limbs: Sequence[Limb], tell: Tell | None = None
) -> LimbFlipAnalysis:
    """Analyse the flips of limbs, before a threshold τ is chosen.

    `tell` is called with the progress, from 0 to 1.
    """
    tell = tell or ignore_progress
    border = find_cuts(motion)
    swivels = []
    for k, limb in enumerate(limbs):
        tell(k / len(limbs))
        swivels.append(compute_limb_swivel(motion, limb))
    if len(limbs) >= SEVERAL:
        jumping = [np.abs(rotations_minus_nearby_median(s.jump)) >= TAU for s in swivels]
        border |= np.mean(jumping, axis=0) > TOGETHER
    noisy = {
        person: largest_joint_and_ancestor_noise(
            motion, (j for b in of for j in _joints(motion, b))
        )
        > 0.0
        for person, of in group_chains_by_person(limbs).items()
    }
    return LimbFlipAnalysis(
        {
            limb.name: _of_limb(limb, swivel, border, noisy[limb.person], motion.fps)
            for limb, swivel in zip(limbs, swivels, strict=True)
        }
    )


def _joints(motion: Motion, limb: Limb) -> tuple[int, ...]:
    return limb.parent, *joint_path(motion.skeleton, limb.parent, limb.end)


def _of_limb(limb: Limb, swivel: Swivel, border: Mask, noisy: Mask, fps: float) -> LimbFlips:
    turns = np.where(border, 0.0, swivel.jump)
    departures = np.where(border, 0.0, rotations_minus_nearby_median(turns))
    soft = soft_jumps(turns, np.abs(departures) >= SHARP, fps)
    return LimbFlips(limb, fps, swivel, departures, ~border, noisy, tuple(soft))
