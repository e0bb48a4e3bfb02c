"""Correction of one frame of one chain by err(t), offset(t) and Eq. 14-15 of [Choi26 §3.3]."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from twistcore.analysis.decomposition.altered_frame import WhatIf, altered
from twistcore.analysis.decomposition.frame_quantities import Decomposition, decompose
from twistcore.detection.paper import error_of
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, geodesic_angle, multiply, wrap


@dataclass(frozen=True, eq=False)
class FrameCorrection:
    """A frame before and after the correction, with quaternions (4,) and angles in radians.

    - before, tau: the quantities from which the error is detected, and the threshold
    - err: err(t), 0 without an event
    - offset_before: offset(t−1), the paper's running sum
    - whole: the full offset, of which a fraction is removed, in (−π, π]
    - applied: that fraction, 0…1
    - q_parent, q_child: the rotations before the correction
    - parent_after, child_after: q'_P and q'_C
    """

    before: Decomposition
    tau: float
    err: float
    offset_before: float
    whole: float
    applied: float
    q_parent: Array
    q_child: Array
    parent_after: Array
    child_after: Array

    @property
    def offset(self) -> float:
        """The paper's running sum offset(t), not wrapped to (−π, π] [Choi26 §3.3.1]."""
        return self.offset_before + self.err

    @property
    def taken(self) -> float:
        """The angle that is removed from P's twist."""
        return self.applied * self.whole

    @property
    def difference(self) -> float:
        """The angle between q_P q_C and q'_P q'_C, which must be 0 [Choi26 Eq. 14]."""
        before = multiply(self.q_parent, self.q_child)
        return float(geodesic_angle(before, multiply(self.parent_after, self.child_after)))


def correct_frame(
    motion: Motion,
    chain: Chain,
    frame: int,
    what_if: WhatIf,
    *,
    tau: float,
    offset_before: float,
    own: float | None = None,
) -> FrameCorrection:
    """Detect an error in a captured or altered frame with the threshold τ, and correct it.

    `what_if` has the changes to the frame. `offset_before` is offset(t−1) in radians. `own` is the
    offset of a known interval to remove, or None to remove offset(t).
    """
    untouched = replace(what_if, applied=0.0)
    before = decompose(motion, chain, frame, untouched if untouched.changes else None)
    strength = before.strength if before.strength_is_defined else 0.0
    err = float(error_of(before.dtheta_p, strength, tau))
    whole = float(wrap(offset_before + err if own is None else own))
    joints = [chain.parent, chain.child]
    pair = motion.rotations[frame, joints]
    if untouched.changes:
        pair = altered(motion, chain, frame, untouched).rotations[0, joints]
    after = pair
    if what_if.applied:
        after = altered(motion, chain, frame, what_if, offset=whole).rotations[0, joints]
    # Choose q or −q so that the swing has cos(α/2) ≥ 0, as in Eq. 6.
    sign = 1.0 if float(np.dot(before.q, pair[0])) >= 0.0 else -1.0
    return FrameCorrection(
        before, tau, err, offset_before, whole, what_if.applied,
        sign * pair[0], pair[1], sign * after[0], after[1],
    )  # fmt: skip
