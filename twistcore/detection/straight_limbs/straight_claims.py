"""Errors of a chain while its limb is straight, and jumps that they do not explain [Method]."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from twistcore.detection.counter_twist.counter_rotation import CounterRotation
from twistcore.detection.counter_twist.edges import Edges
from twistcore.detection.counter_twist.offsets import offsets_of
from twistcore.detection.counter_twist.pairing import (
    PairTable,
    best_pairs,
    pair_table,
    running_sums,
)
from twistcore.detection.limbs import Limbs
from twistcore.detection.straight_limbs.straight_course import course, scale_of
from twistcore.detection.straight_limbs.straight_spells import (
    Bend,
    Mask,
    Spell,
    StraightError,
    bend_of,
    errors_in,
    left_over,
    spells,
)
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    multiply,
    quaternion_from_axis_angle,
    wrap,
)
from twistcore.work.frozen import dataclass

LARGEST = float(np.radians(75.0))  # largest δ; a larger one would turn the hinge around
CLEAR = 10.0  # ratio to the spread of a hinge; a smaller δ may be play of the hinge
# factor by which removing δ may increase the distance from the hinge, because a straight bone
# naturally deviates from it
NEARLY = 1.6
ROUNDS = 3  # rounds of removing jumps that contradict the bent limb
AS_LITTLE = float(np.radians(2.0))  # by how much more counter-turn jumps may leave
BESIDE = 1  # frames on either side of an error that may belong to its transitions


@dataclass(frozen=True, eq=False)
class _Jumping:
    """The error of an interval between jumps, and the peak frames of its edges.

    `offset` is δ in radians from frame `start` on, shape (frames,).
    """

    start: int
    offset: Array
    peaks: tuple[int, ...]

    @property
    def frames(self) -> slice:
        """The frames of the interval as a slice."""
        return slice(self.start, self.start + len(self.offset))


@dataclass(frozen=True, eq=False)
class Jumps:
    """The data from which the intervals between the jumps of a chain are computed.

    `tau` is in radians.
    """

    counter: CounterRotation
    row: int
    edges: Edges
    step: Mask
    tables: tuple[PairTable, ...]
    tau: float
    fps: float

    def without(self, peaks: Mask) -> Jumps:
        """Return the jumps without the edges with a peak frame in the mask `peaks`, (frames,)."""
        edges = self.edges[~peaks[self.edges.peak]]
        sums = running_sums(self.counter, self.row, self.step)
        tables = tuple(pair_table(edges, sums, table.low, table.high) for table in self.tables)
        return replace(self, edges=edges, tables=tables)

    def offset(self) -> Array:
        """Return the sum of the offsets of all intervals, in radians, (frames,)."""
        total = np.zeros(self.counter.x.shape[1])
        for j in self.found():
            total[j.frames] += j.offset
        return total

    def found(self) -> list[_Jumping]:
        """Return the intervals that best explain the jumps.

        Intervals that end at a border of a segment are included.
        """
        out = []
        for table in self.tables:
            pairs = best_pairs(table, self.tau, self.fps)
            courses = offsets_of(pairs, table, self.counter, self.row, self.step)
            for pair, found in zip(pairs, courses, strict=True):
                peaks = table.edges.peak[[k for k in pair[:2] if k >= 0]].tolist()
                out.append(_Jumping(found.start, found.offset, tuple(peaks)))
        return out


@dataclass(frozen=True, eq=False)
class StraightLimb:
    """The errors of a limb while it is straight, sorted by start.

    `claimed` is the mask of the frames in which the errors begin and end.
    """

    errors: tuple[StraightError, ...]
    claimed: Mask
    bend: Bend

    @property
    def offset(self) -> Array:
        """The sum of the errors, in radians, (frames,)."""
        total = np.zeros(len(self.claimed))
        for e in self.errors:
            total[e.start : e.stop] += e.offset
        return total

    def leaves(self, jumps: Jumps) -> Jumps:
        """Return the jumps that belong to none of these errors and agree with the bent limb.

        The edges of an interval are removed if the correction of the interval would turn the bent
        limb away from its hinge.
        """
        claimed = self.claimed.copy()
        for _ in range(ROUNDS):
            jumps = jumps.without(claimed)
            gainsaid = [j for j in jumps.found() if _is_nearer_hinge(j, self.bend) is False]
            if not gainsaid:
                break
            for j in gainsaid:
                claimed[list(j.peaks)] = True
        return jumps


def straight_limb(
    motion: Motion, chain: Chain, jumps: Jumps, by_itself: Callable[[], tuple[Array, Array]]
) -> StraightLimb | None:
    """Return the errors of a chain in its straight spells that its jumps do not explain.

    The result is None if there are no such errors, or if the chain has no hinge, for example
    because it has no grandchild. The bend decides which of two spells contains the error, not the
    length. An interval between jumps takes priority only if it brings the bent limb back to its
    hinge, or if it leaves little more counter-turn unexplained. `by_itself` is a function that
    returns the increments of P and C without the effect of jumps in neighbouring chains, each
    (frames,), in radians.
    """
    if chain.grandchild < 0:
        return None
    fps, tables = motion.fps, jumps.tables
    bend = bend_of(motion.rotations[:, chain.child], chain.axis, chain.arm, fps)
    if bend.azimuth is None:
        return None
    captured = jumps.counter.x[jumps.row], jumps.counter.y[jumps.row]
    if not any(spells(captured, bend, t.low, t.high, fps) for t in tables):
        return None
    increments = by_itself()
    found = jumps.found()
    certain = [j for j in found if _is_nearer_hinge(j, bend)]
    left = _without(increments, certain)
    unsaid = [j for j in found if _is_nearer_hinge(j, bend) is None]
    errors: list[StraightError] = []
    claimed = np.zeros(motion.frames, dtype=bool)
    step = motion.angle_step
    scales = scale_of(left[0], step), scale_of(left[1], step)
    for table in tables:
        beside = [j for j in unsaid if table.low <= j.start < table.high]
        for spell in spells(left, bend, table.low, table.high, fps):
            if own := _error_of(left, scales, beside, bend, spell, fps):
                errors += own
                claimed[max(spell.start - BESIDE, 0) : spell.stop + 1 + BESIDE] = True
    for j in certain:
        claimed[list(j.peaks)] = False
    return StraightLimb(tuple(errors), claimed, bend) if errors else None


def without_errors(limbs: Limbs, offsets: Mapping[int, Array]) -> Limbs:
    """Return limbs without errors.

    `offsets` contains the errors in radians, shape (frames,), keyed by the row of their chain.
    """
    joints = limbs.joints.copy()
    for row, offset in offsets.items():
        chain, at = divmod(row, limbs.count)
        axis = limbs.axes[chain, at]
        back = quaternion_from_axis_angle(axis, -offset)
        joints[chain, at] = multiply(joints[chain, at], back)
        joints[chain + 1, at] = multiply(conjugate(back), joints[chain + 1, at])
    return limbs.with_joints(joints)


def _error_of(
    increments: tuple[Array, Array],
    scales: tuple[float, float],
    jumping: Sequence[_Jumping],
    bend: Bend,
    spell: Spell,
    fps: float,
) -> list[StraightError]:
    """Return the errors of a spell whose removal brings the limb closer to its hinge.

    The result is empty if the intervals between jumps are sufficient. `scales` are the scales of
    the increments in the whole clip. `jumping` are the intervals between jumps in the segment of
    the spell. Only frames near the spell are examined, because a long clip has thousands of spells.
    """
    low, high = spell.low, spell.high
    x, y = (v[low:high] for v in increments)
    here = Spell(spell.start - low, spell.stop - low, 0, high - low)
    delta, jumped = np.zeros(high - low), np.zeros(high - low)
    own = slice(here.start, here.stop)
    delta[own] = course((x, y), scales, here.start, here.stop, 0, high - low, fps)
    for j in jumping:
        jumped[j.start - low : j.start - low + len(j.offset)] += j.offset
    if jumped[own].any():
        least, left = (left_over((x, y), scales, d, here, fps) for d in (delta, jumped))
        if left <= least + AS_LITTLE:
            return []
    found = errors_in((x, y), delta, here, fps)
    errors = [replace(e, start=e.start + low, peak=e.peak + low) for e in found]
    return [
        e
        for e in errors
        if CLEAR * bend.spread <= np.abs(e.offset).max() < LARGEST
        and bend.nearer(slice(e.start, e.stop), e.offset, share=NEARLY)
    ]


def _without(increments: tuple[Array, Array], jumping: Sequence[_Jumping]) -> tuple[Array, Array]:
    """Return the increments of P and C without the given errors, in radians, (frames,) each."""
    known = np.zeros(len(increments[0]))
    for j in jumping:
        known[j.frames] += j.offset
    steps = np.diff(known, prepend=known[:1])
    return wrap(increments[0] - steps), wrap(increments[1] + steps)


def _is_nearer_hinge(jumping: _Jumping, bend: Bend) -> bool | None:
    """Return True if the bent limb is closer to its hinge without the given interval.

    The result is None if this is unknown.
    """
    return bend.nearer(jumping.frames, jumping.offset, bend.bent[jumping.frames])
