"""Twist bones (helpers) that turn about their bone while no other joint does.

The reason may be a jump, or a driver that flips at ±180°. A helper rolls partly with the joint C at
the end of its bone. If it jumps about the bone while C does not jump and its parent does not turn
the other way, only the helper is wrong.
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
from twistcore.detection.twist_increments import twist_increments
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, quaternion_from_axis_angle
from twistcore.work.frozen import dataclass
from twistcore.work.progress import nobody

SMALLEST_ROLL = math.radians(20.0)  # a helper that is off by less does not visibly twist the skin
# Share of the helper's jump that C's turn, or its parent's opposite turn, must have.
_EXPLAINED = 0.4
_AXIS = np.array([1.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class HelperAnalysis:
    """The analysis of helpers and their jumps about the bone, before a threshold is chosen.

    `own` is the angle by which each helper turns alone in each frame, in radians, shape (frames,),
    keyed by name.
    """

    helpers: Mapping[str, ChainAnalysis]
    own: Mapping[str, Array]

    def automatic_tau(self, helper: str) -> float:
        """Return the automatic τ for the roll of a helper, at least 20°, in radians."""
        return max(SMALLEST_ROLL, self.helpers[helper].automatic_tau())

    def strength(self, helper: str) -> Array:
        """Return the magnitudes of a helper's jumps about its bone, in radians ≥ 0, (frames,)."""
        return self.helpers[helper].strength()

    def intervals(self, helper: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals in which only the helper is turned, sorted by start.

        `tau` is the threshold in radians.
        """
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
        """Return True if only the helper turned at the beginning or at the end of the interval."""
        own = self.own[helper]
        edges = [t for t in (interval.start, interval.stop) if 0 < t < len(own)]
        return any(abs(own[t]) > (1.0 - _EXPLAINED) * abs(interval.shown) for t in edges)


def analyse_helpers(motion: Motion, helpers: Sequence[Helper]) -> HelperAnalysis:
    """Analyse helpers up to the point where τ is needed."""
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
    # Pair the helper with its inverse, so that its whole roll appears as x and as −y.
    turned = np.array([quaternion_from_axis_angle(_AXIS, r) for r in rolls])
    limbs = Limbs(
        np.array([turned, turned * (1.0, -1.0, -1.0, -1.0)]), _axes(len(rolls)), motion.angle_step
    )
    jumps = find_jumps(limbs, motion.fps, cut, segments, nobody)
    known = {
        h.name: ChainAnalysis(h.name, motion.fps, j.counter, row, j.edges, j.step, j.tables)
        for row, (h, j) in enumerate(zip(helpers, jumps, strict=True))
    }
    return HelperAnalysis(known, own)


def roll_curve(motion: Motion, helper: Helper) -> Array:
    """Return the sum of a helper's turns about the bone, in radians, (frames,)."""
    above = int(motion.skeleton.parents[helper.parent])
    q = motion.rotations[:, helper.parent]
    return np.asarray(np.cumsum(twist_increments(motion.rotations[:, above], q, helper.axis)[1]))


def _explained(helper: str, own: Array, interval: Interval) -> dict[str, str | float | None]:
    """Return the evidence for an interval: the jumps of the helper at both ends, in degrees."""
    opens, closes = (
        math.degrees(own[t]) if 0 < t < len(own) else None for t in (interval.start, interval.stop)
    )
    return {"helper": helper, "opens_deg": opens, "closes_deg": closes}


def _axes(count: int) -> Array:
    return np.broadcast_to(_AXIS, (1, count, 3)).copy()


def _own_turn(roll: Array, driver: Array, over: Array) -> Array:
    """Return the turns of a helper that neither C nor an opposite turn of its parent explains.

    `roll`, `driver` and `over` are the twist increments of the helper, of C and of the parent.
    """
    size = _EXPLAINED * np.abs(roll)
    driven = (np.abs(driver) > size) & (driver * roll > 0.0)
    kept = np.abs(over + roll) < size
    return np.where(driven | kept, 0.0, roll)
