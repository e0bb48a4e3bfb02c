"""Find helper rolls, in which a twist bone (helper) rolls by a wrong angle while no joint does.

The cause may be a jump, or a driver of the rig that flips at ±180°. A helper normally follows a
fraction of the roll of the joint C at the end of its bone. If the helper jumps about the bone while
C does not jump and the helper's parent does not rotate the other way, only the helper is wrong.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from twistcore.detection.consistency.chain_analysis import ChainAnalysis
from twistcore.detection.consistency.detector import find_jumps
from twistcore.detection.cuts import find_cuts, segments_between
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.limbs import Limbs
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, quaternion_from_axis_angle
from twistcore.skeleton.twist_increments import twist_increments
from twistcore.work.frozen import dataclass
from twistcore.work.progress import ignore_progress

SMALLEST_ROLL = math.radians(20.0)  # a smaller roll does not visibly twist the skin
# A turn of C, or an opposite turn of the parent, explains a jump of the helper if it is at least
# this share of the jump.
_EXPLAINED = 0.4
_AXIS = np.array([1.0, 0.0, 0.0])  # any axis: only the angles of the helpers are used


@dataclass(frozen=True, eq=False)
class HelperAnalysis:
    """The analysis of helper rolls, before a threshold is chosen.

    Attributes
    ----------
    helpers
        The analysis of the jumps of each helper about its bone, keyed by name.
    own
        The angle by which each helper alone rotates in each frame, in radians, shape (frames,),
        keyed by name.
    """

    helpers: Mapping[str, ChainAnalysis]
    own: Mapping[str, Array]

    def automatic_tau(self, helper: str) -> float:
        """Return the automatic τ of a helper in radians, at least 20°."""
        return max(SMALLEST_ROLL, self.helpers[helper].automatic_tau())

    def strength(self, helper: str) -> Array:
        """Return the strength of a helper's jumps about its bone, in radians ≥ 0, (frames,)."""
        return self.helpers[helper].strength()

    def intervals(self, helper: str, tau: float) -> tuple[Interval, ...]:
        """Return the helper rolls at threshold τ in radians, sorted by start."""
        found = self.helpers[helper].intervals(max(tau, SMALLEST_ROLL))
        return tuple(
            replace(
                i,
                kind=Kind.HELPER_ROLL,
                joint=helper,
                confidence=None,  # the confidence is not measured for this kind
                explain=partial(_explained, helper, self.own[helper], i),
            )
            for i in found
            if abs(i.shown) >= SMALLEST_ROLL and self._alone(helper, i)
        )

    def _alone(self, helper: str, interval: Interval) -> bool:
        """Return True if only the helper rotates at an edge of the interval."""
        own = self.own[helper]
        edges = [t for t in (interval.start, interval.stop) if 0 < t < len(own)]
        return any(abs(own[t]) > (1.0 - _EXPLAINED) * abs(interval.shown) for t in edges)


def analyse_helper_rolls(motion: Motion, helpers: Sequence[Helper]) -> HelperAnalysis:
    """Analyse the rolls of helpers as far as possible without a threshold τ."""
    if not helpers or motion.frames < 2:
        return HelperAnalysis({}, {})
    cut = find_cuts(motion)
    segments = segments_between(cut, motion.fps)
    cut[:1] = True
    rolls, own = [], {}
    for helper in helpers:
        above = int(motion.skeleton.parents[helper.parent])
        q, c = motion.rotations[:, helper.parent], motion.rotations[:, helper.child]
        over, roll = twist_increments(motion.rotations[:, above], q, helper.axis)
        _, driver = twist_increments(q, c, helper.axis)
        own[helper.name] = _own_turn(roll, driver, over)
        rolls.append(np.cumsum(roll))
    # Pair each helper with its inverse as the child: the twist increments are then x and y = −x, as
    # in a counter-twist.
    turned = np.array([quaternion_from_axis_angle(_AXIS, r) for r in rolls])
    limbs = Limbs(
        np.array([turned, turned * (1.0, -1.0, -1.0, -1.0)]), _axes(len(rolls)), motion.angle_step
    )
    jumps = find_jumps(limbs, motion.fps, cut, segments, ignore_progress)
    known = {
        h.name: ChainAnalysis(h.name, motion.fps, j.counter, row, j.edges, j.step, j.tables)
        for row, (h, j) in enumerate(zip(helpers, jumps, strict=True))
    }
    return HelperAnalysis(known, own)


def accumulated_helper_roll(motion: Motion, helper: Helper) -> Array:
    """Return the accumulated roll of a helper about its bone, in radians, (frames,)."""
    above = int(motion.skeleton.parents[helper.parent])
    q = motion.rotations[:, helper.parent]
    return np.asarray(np.cumsum(twist_increments(motion.rotations[:, above], q, helper.axis)[1]))


def _explained(helper: str, own: Array, interval: Interval) -> dict[str, str | float | None]:
    """Return the evidence for an interval, keyed by name: the helper's jumps at both edges.

    `own` contains the angle by which only the helper rotates in each frame, in radians, (frames,).
    """
    opens, closes = (
        math.degrees(own[t]) if 0 < t < len(own) else None for t in (interval.start, interval.stop)
    )
    return {"helper": helper, "opens_deg": opens, "closes_deg": closes}


def _axes(count: int) -> Array:
    return np.broadcast_to(_AXIS, (1, count, 3)).copy()


def _own_turn(roll: Array, driver: Array, over: Array) -> Array:
    """Return a helper's rotations that no neighbouring joint explains, in radians, (frames,).

    `roll`, `driver` and `over` are the twist increments of the helper, of the joint at the end of
    its bone, and of the helper's parent.
    """
    size = _EXPLAINED * np.abs(roll)
    driven = (np.abs(driver) > size) & (driver * roll > 0.0)
    kept = np.abs(over + roll) < size
    return np.where(driven | kept, 0.0, roll)
