"""Correct a single frame of a chain, step by step as in [Choi26 §3.3]."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from twistcore.analysis.decomposition.altered_frame import WhatIf, frame_motion_with_user_changes
from twistcore.analysis.decomposition.frame_quantities import Decomposition, decompose
from twistcore.detection.paper import paper_detector_error_increments
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, geodesic_angle, multiply, wrap


@dataclass(frozen=True, eq=False)
class FrameCorrection:
    """A frame of a chain before and after its correction [Choi26 §3.3].

    Quaternions have the shape (4,). Angles are in radians.

    Attributes
    ----------
    before
        The quantities of the frame before the correction.
    tau
        Threshold τ.
    err
        err(t), which is 0 if no error begins or ends in this frame.
    offset_before
        offset(t−1), the paper's running sum up to the previous frame.
    whole
        The full offset, in (−π, π].
    applied
        The fraction of `whole` that is removed, 0…1.
    q_parent, q_child
        Rotations of parent and child before the correction.
    parent_after, child_after
        Rotations of parent and child after the correction.
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
        """The paper's running sum offset(t), not wrapped into (−π, π] [Choi26 §3.3.1]."""
        return self.offset_before + self.err

    @property
    def taken(self) -> float:
        """The angle that is removed from the parent's twist, radians."""
        return self.applied * self.whole

    @property
    def difference(self) -> float:
        """The angle by which the correction changes the child's global rotation, radians.

        By [Choi26 Eq. 14], it must be 0.
        """
        before = multiply(self.q_parent, self.q_child)
        return float(geodesic_angle(before, multiply(self.parent_after, self.child_after)))


def detect_and_correct_frame(
    motion: Motion,
    chain: Chain,
    frame: int,
    what_if: WhatIf,
    *,
    tau: float,
    offset_before: float,
    own: float | None = None,
) -> FrameCorrection:
    """Detect an error in a frame, and compute its correction.

    Parameters
    ----------
    motion, chain, frame
        The frame.
    what_if
        The user's changes to the frame.
    tau
        Threshold τ, radians.
    offset_before
        offset(t−1), radians.
    own
        Offset of a known interval, radians, to remove instead of offset(t). By default, offset(t).
    """
    untouched = replace(what_if, applied=0.0)
    before = decompose(motion, chain, frame, untouched if untouched.changes else None)
    strength = before.strength if before.strength_is_defined else 0.0
    err = float(paper_detector_error_increments(before.dtheta_p, strength, tau))
    whole = float(wrap(offset_before + err if own is None else own))
    joints = [chain.parent, chain.child]
    pair = motion.rotations[frame, joints]
    if untouched.changes:
        pair = frame_motion_with_user_changes(motion, chain, frame, untouched).rotations[0, joints]
    after = pair
    if what_if.applied:
        after = frame_motion_with_user_changes(
            motion, chain, frame, what_if, offset=whole
        ).rotations[0, joints]
    # Of q and −q, choose the one whose swing has cos(α/2) ≥ 0, as in Eq. 6.
    sign = 1.0 if float(np.dot(before.q, pair[0])) >= 0.0 else -1.0
    return FrameCorrection(
        before, tau, err, offset_before, whole, what_if.applied,
        sign * pair[0], pair[1], sign * after[0], after[1],
    )  # fmt: skip
