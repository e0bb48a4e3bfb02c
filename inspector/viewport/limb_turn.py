"""The rotation of the selected limb or bone at a frame, and the circle that shows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inspector.viewport.bodies import BoneSegment
from inspector.viewport.limb_circle import (
    LEAST_RADIUS,
    Circle,
    bone_circle,
    find_limb_circle,
    helper_circle,
)
from inspector.viewport.limb_side import main_bone
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, rotate

_RIM, _SHARES = 20, (0.3, 0.5, 0.65, 0.8, 0.9, 1.0, 1.1)
LEAST_ANGLE = 0.5  # degrees; the rotation of a bone by less is not shown


@dataclass(frozen=True, eq=False)
class Turn:
    """A correction as a rotation about a limb or bone, drawn as a mark that moves on a circle.

    Attributes
    ----------
    circle
        The circle before correction.
    drawn
        The angle to draw, which is the offset in radians.
    after
        The position of the mark after correction, (3,).
    line
        True if the circle is about the line of a limb, False if it is about a bone.
    """

    circle: Circle
    drawn: float
    after: Array
    line: bool = True

    @property
    def spoke(self) -> Array:
        """The line from the centre of the circle to the middle of the fan's edge, (2, 3)."""
        return np.stack([self.circle.centre, self.circle.at(np.array([-0.5 * self.drawn]))[0]])

    @property
    def fan(self) -> Array:
        """Points that are spread over the fan, (n, 3).

        The fan is the sector of the circle from the captured to the corrected mark.
        """
        rim = self.circle.at(np.linspace(0.0, -self.drawn, _RIM))
        centre = self.circle.centre
        return np.vstack([centre + share * (rim - centre) for share in _SHARES])


def limb_correction_turn(
    chain: Chain,
    offset: float,
    before: tuple[Array, Array],
    after: tuple[Array, Array],
    bones: Sequence[BoneSegment],
    skeleton: Skeleton,
    height: float,
) -> Turn | None:
    """Return the rotation that corrects a chain or limb in a frame, or None if it has no circle.

    A chain has a circle only if the correction rotates its bone. Its fan leads from the captured
    front of the bone to its corrected front.

    Parameters
    ----------
    offset
        The offset in radians.
    before, after
        The global rotations (joints, 4) and positions (joints, 3) before and after correction.
    height
        The height of the figure.
    """
    if isinstance(chain, Limb):
        circle = find_limb_circle(chain, before[1])
        if circle is None:
            return None
        wide = circle.widened(LEAST_RADIUS * height)
        mark = after[1][chain.child] if wide is circle else wide.at(np.array([-offset]))[0]
        return Turn(wide, offset, mark)
    if isinstance(chain, Helper):
        circle = helper_circle(chain, skeleton, before, height)
        if circle is None:
            return None
        placed = helper_circle(chain, skeleton, after, height) or circle
        return Turn(circle, offset, placed.centre + placed.aside)
    bone = main_bone(chain, bones)
    if bone is None or abs(offset) < np.radians(LEAST_ANGLE):
        return None
    front = rotate(before[0][chain.parent], bone.normal)
    circle = bone_circle(before[1][[chain.parent, chain.child]], front, height)
    if circle is None:
        return None
    mark = circle.at(np.array([-offset]))[0]
    return Turn(circle, offset, mark, line=False)
