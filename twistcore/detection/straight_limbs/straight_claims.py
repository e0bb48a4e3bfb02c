"""Decide which twist errors a chain has in straight poses and which between jumps [Method]."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from twistcore.detection.counter_twist.counter_rotation import CounterRotation
from twistcore.detection.counter_twist.edges import Edges
from twistcore.detection.counter_twist.offsets import interval_twist_errors_over_time
from twistcore.detection.counter_twist.pairing import (
    PairTable,
    best_edge_pairs,
    edge_pair_table,
    running_counter_rotation_sums,
)
from twistcore.detection.limbs import Limbs
from twistcore.detection.straight_limbs.straight_course import (
    error_course,
    twist_increment_change_scale,
)
from twistcore.detection.straight_limbs.straight_spells import (
    Bend,
    Mask,
    Spell,
    StraightError,
    find_straight_limb_twist_errors,
    find_straight_ranges,
    limb_bend_per_frame,
    unexplained_opposite_rotation,
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

LARGEST = float(np.radians(75.0))  # a larger error would turn the hinge to the other side
CLEAR = 10.0  # minimum ratio of an error to the spread of the hinge; a smaller one may be play
# A correction may increase the distance from the hinge by this factor, because a straight bone
# naturally deviates from its hinge.
NEARLY = 1.6
ROUNDS = 3  # rounds of removing jumps that contradict the bent limb
# If the intervals between jumps leave at most this much more opposite rotation unexplained, in
# radians, they explain the motion.
AS_LITTLE = float(np.radians(2.0))
BESIDE = 1  # frames on either side of a spell that may belong to its transitions


@dataclass(frozen=True, eq=False)
class _Jumping:
    """A twist error in an interval between two jumps.

    Attributes
    ----------
    start
        The first frame.
    offset
        The twist error in each frame, radians.
    peaks
        The peak frames of the edges.
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
    """The jumps of a chain, and the data from which the intervals between them are computed.

    Attributes
    ----------
    counter
        The twist increments of all chains that are analysed together, and their residuals.
    row
        The row of the chain in `counter`.
    edges
        The possible edges of the chain.
    step
        Mask of the frames in which the offset of an interval may change, shape (frames,).
    tables
        The evidence (gain) for each pair of edges, one table for each segment between cuts.
    tau
        The automatic τ in radians.
    fps
        The frame rate.
    """

    counter: CounterRotation
    row: int
    edges: Edges
    step: Mask
    tables: tuple[PairTable, ...]
    tau: float
    fps: float

    def without(self, peaks: Mask) -> Jumps:
        """Return a copy without edges that have a peak in the frames of a mask, (frames,)."""
        edges = self.edges[~peaks[self.edges.peak]]
        sums = running_counter_rotation_sums(self.counter, self.row, self.step)
        tables = tuple(edge_pair_table(edges, sums, table.low, table.high) for table in self.tables)
        return replace(self, edges=edges, tables=tables)

    def offset(self) -> Array:
        """Return the sum of the offsets of all intervals in each frame, in radians, (frames,)."""
        total = np.zeros(self.counter.x.shape[1])
        for j in self.found():
            total[j.frames] += j.offset
        return total

    def found(self) -> list[_Jumping]:
        """Return the intervals that best explain the jumps, including intervals with one edge."""
        out = []
        for table in self.tables:
            pairs = best_edge_pairs(table, self.tau, self.fps)
            courses = interval_twist_errors_over_time(
                pairs, table, self.counter, self.row, self.step
            )
            for pair, found in zip(pairs, courses, strict=True):
                peaks = table.edges.peak[[k for k in pair[:2] if k >= 0]].tolist()
                out.append(_Jumping(found.start, found.offset, tuple(peaks)))
        return out


@dataclass(frozen=True, eq=False)
class StraightLimb:
    """The errors of a limb while it is straight.

    Attributes
    ----------
    errors
        The errors, sorted by start.
    claimed
        Mask of the frames in which jumps are part of these errors, shape (frames,).
    bend
        The bend of the limb.
    """

    errors: tuple[StraightError, ...]
    claimed: Mask
    bend: Bend

    @property
    def offset(self) -> Array:
        """The sum of the errors in each frame, in radians, (frames,)."""
        total = np.zeros(len(self.claimed))
        for e in self.errors:
            total[e.start : e.stop] += e.offset
        return total

    def leaves(self, jumps: Jumps) -> Jumps:
        """Return the jumps that are not part of these errors and that agree with the bent limb.

        An interval between jumps contradicts the bent limb if its correction would rotate the limb
        out of its hinge plane. The edges of such an interval are removed.
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


def find_straight_limb_errors(
    motion: Motion, chain: Chain, jumps: Jumps, by_itself: Callable[[], tuple[Array, Array]]
) -> StraightLimb | None:
    """Return the twist errors of a straight limb that the jumps of its chain do not explain.

    The result is None if there are no such errors, or if the chain has no hinge, for example
    because it has no grandchild. An interval between jumps takes priority over an error of the
    straight limb in only two cases: its correction brings the bent limb back into its hinge plane,
    or it explains the opposite rotations of parent and child almost as well.

    Parameters
    ----------
    motion
        The motion.
    chain
        The chain.
    jumps
        The jumps of the chain.
    by_itself
        Function that returns the twist increments of parent and child without the effects of jumps
        in neighbouring chains, radians, each with the shape (frames,).
    """
    if chain.grandchild < 0:
        return None
    fps, tables = motion.fps, jumps.tables
    bend = limb_bend_per_frame(motion.rotations[:, chain.child], chain.axis, chain.arm, fps)
    if bend.azimuth is None:
        return None
    captured = jumps.counter.x[jumps.row], jumps.counter.y[jumps.row]
    if not any(find_straight_ranges(captured, bend, t.low, t.high, fps) for t in tables):
        return None
    increments = by_itself()
    found = jumps.found()
    certain = [j for j in found if _is_nearer_hinge(j, bend)]
    left = _without(increments, certain)
    unsaid = [j for j in found if _is_nearer_hinge(j, bend) is None]
    errors: list[StraightError] = []
    claimed = np.zeros(motion.frames, dtype=bool)
    step = motion.angle_step
    scales = (
        twist_increment_change_scale(left[0], step),
        twist_increment_change_scale(left[1], step),
    )
    for table in tables:
        beside = [j for j in unsaid if table.low <= j.start < table.high]
        for spell in find_straight_ranges(left, bend, table.low, table.high, fps):
            if own := _error_of(left, scales, beside, bend, spell, fps):
                errors += own
                claimed[max(spell.start - BESIDE, 0) : spell.stop + 1 + BESIDE] = True
    for j in certain:
        claimed[list(j.peaks)] = False
    return StraightLimb(tuple(errors), claimed, bend) if errors else None


def remove_twist_errors(limbs: Limbs, offsets: Mapping[int, Array]) -> Limbs:
    """Return a copy of the limbs with twist errors removed.

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
    """Return the errors in a spell whose correction keeps the limb in its hinge plane.

    A spell is a range of frames in which the limb is straight. The result is empty if intervals
    between jumps explain it. Only the segment that contains the spell is examined, because a long
    clip has thousands of spells.

    Parameters
    ----------
    increments
        The twist increments of parent and child, radians, each with the shape (frames,).
    scales
        The scales of both increments in the whole clip, from :func:`twist_increment_change_scale`.
    jumping
        The intervals between jumps in the segment that contains the spell.
    bend
        The bend of the limb.
    spell
        The spell.
    fps
        The frame rate.
    """
    low, high = spell.low, spell.high
    x, y = (v[low:high] for v in increments)
    here = Spell(spell.start - low, spell.stop - low, 0, high - low)
    delta, jumped = np.zeros(high - low), np.zeros(high - low)
    own = slice(here.start, here.stop)
    delta[own] = error_course((x, y), scales, here.start, here.stop, 0, high - low, fps)
    for j in jumping:
        jumped[j.start - low : j.start - low + len(j.offset)] += j.offset
    if jumped[own].any():
        least, left = (
            unexplained_opposite_rotation((x, y), scales, d, here, fps) for d in (delta, jumped)
        )
        if left <= least + AS_LITTLE:
            return []
    found = find_straight_limb_twist_errors((x, y), delta, here, fps)
    errors = [replace(e, start=e.start + low, peak=e.peak + low) for e in found]
    return [
        e
        for e in errors
        if CLEAR * bend.spread <= np.abs(e.offset).max() < LARGEST
        and bend.nearer(slice(e.start, e.stop), e.offset, share=NEARLY)
    ]


def _without(increments: tuple[Array, Array], jumping: Sequence[_Jumping]) -> tuple[Array, Array]:
    """Return the increments of parent and child after removing intervals, in radians."""
    known = np.zeros(len(increments[0]))
    for j in jumping:
        known[j.frames] += j.offset
    steps = np.diff(known, prepend=known[:1])
    return wrap(increments[0] - steps), wrap(increments[1] + steps)


def _is_nearer_hinge(jumping: _Jumping, bend: Bend) -> bool | None:
    """Return True if correcting an interval brings the bent limb closer to its hinge plane.

    The result is None if this is unknown.
    """
    return bend.nearer(jumping.frames, jumping.offset, bend.bent[jumping.frames])
