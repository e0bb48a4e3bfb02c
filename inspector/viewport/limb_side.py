"""The direction from which a limb's error is best visible, and the points to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from inspector.viewport.bodies import BoneSegment
from inspector.viewport.camera import OrbitCamera, circle_direction, roll_direction
from inspector.viewport.limb_circle import (
    LEAST_RADIUS,
    Circle,
    bone_circle,
    circle_of,
    helper_circle,
)
from inspector.viewport.occlusion import occluders
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, normalise, rotate

_ON_BONE = (0.15, 0.4, 0.65, 0.9)  # positions on a bone that should be visible
_FIN = 0.06  # distance from the bone to the tip of its fin, in figure heights
_AROUND = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
_NEXT = 0.5  # share of the neighbours of a bone in the image
_STILL = 0.02  # of the figure's height; joints that move less are in place
_AIR = 0.045  # margin around the limb, in figure heights


@dataclass(frozen=True, eq=False)
class LimbSide:
    """A view of a limb.

    `direction` is the unit vector towards the camera. `points` are the points to frame, (n, 3).
    """

    direction: Array
    points: Array

    def camera(
        self,
        camera: OrbitCamera,
        height: float,
        aspect: float,
        margin: float = 1.2,
        covered: float = 0.0,
    ) -> OrbitCamera:
        """Return a camera for this view.

        `height` is the figure's height. `aspect` is the image's width divided by its height.
        `covered` is the share of the image's height that is covered at the top.
        """
        corners = [self.points + _AIR * height * e for e in (*np.eye(3), *-np.eye(3))]
        turned = camera.looking_from(self.direction)
        return turned.framing(np.vstack(corners), aspect, margin=margin, covered=covered)


def limb_joints(chain: Chain, positions: Array) -> Array:
    """Return the positions of a chain's joints, (2 or 3, 3), from positions (joints, 3)."""
    joints = [j for j in (chain.parent, chain.child, chain.grandchild) if j >= 0]
    return positions[joints]


def limb_side(
    chain: Chain,
    bones: Sequence[BoneSegment],
    before: tuple[Array, Array],
    after: tuple[Array, Array],
    facing: Array,
    up: Array,
    *,
    skeleton: Skeleton,
    height: float,
    above: int = -1,
    body: Sequence[int] = (),
) -> LimbSide | None:
    """Return the best view of a chain or limb, or None if it has no body.

    For limbs and twist bones, the circle looks open in this view.

    - before, after: global rotations (joints, 4) and positions (joints, 3)
    - facing, up: unit vectors (3,) of the figure
    - height: the height of the figure
    - above: another joint to frame, −1 for none
    - body: the joints of the person, by default all joints
    """
    rotations, positions = after
    limb = limb_joints(chain, positions)
    circle: Circle | None = None
    if isinstance(chain, Helper):
        limb = np.vstack([limb, positions[int(skeleton.parents[chain.parent])]])
        circle = helper_circle(chain, skeleton, before, height)
    elif isinstance(chain, Limb):
        circle = circle_of(chain, before[1])
        circle = None if circle is None else circle.widened(LEAST_RADIUS * height)
    middle = positions[list(body) or slice(None)].mean(axis=0)
    outward = limb.mean(axis=0) - middle
    hidden = partial(_hidden_share, chain, bones, before, after, height)
    if circle is not None:
        direction = circle_direction(circle.axis, circle.aside, outward, facing, up, hidden)
        return LimbSide(direction, np.vstack([limb, circle.at(_AROUND)]))
    if above >= 0:
        limb = np.vstack([limb, positions[above]])
        outward = limb.mean(axis=0) - middle
    # Most of the image is the turned bone; half of its neighbours is enough.
    ends = limb[:2]
    limb = np.vstack([ends, ends[1] + _NEXT * (limb[2:3] - ends[1])])
    if above >= 0:
        limb = np.vstack([limb, ends[0] + _NEXT * (positions[above] - ends[0])])
    limb = np.vstack([limb, *_first_moved(chain, skeleton, before[1], positions, height)])
    bone = main_bone(chain, bones)
    if bone is None:
        return None
    size = float(np.linalg.norm(outward))
    direction = roll_direction(
        normalise(rotate(rotations[chain.parent], bone.tip)),
        rotate(rotations[chain.parent], bone.normal),
        rotate(before[0][chain.parent], bone.normal),
        outward / size if size > 0.0 else outward,
        facing,
        up,
        hidden,
    )
    front = rotate(before[0][chain.parent], bone.normal)
    circle = bone_circle(before[1][[chain.parent, chain.child]], front, height)
    if circle is not None:
        limb = np.vstack([limb, circle.at(_AROUND)])
    return LimbSide(direction, limb)


def _first_moved(
    chain: Chain, skeleton: Skeleton, before: Array, after: Array, height: float
) -> tuple[Array, Array]:
    """Return the positions, before and after, of the first joints below a chain that move.

    The shape of both is (n, 3).
    """
    moved = np.linalg.norm(after - before, axis=1) > _STILL * height
    joints, first = [chain.parent], []
    while joints:
        joint = joints.pop()
        if moved[joint]:
            first.append(joint)
        else:
            joints += skeleton.children[joint]
    return before[first], after[first]


def main_bone(chain: Chain, bones: Sequence[BoneSegment]) -> BoneSegment | None:
    """Return a chain's bone P→C or, if that has no body, another bone that P turns, or None."""
    own = [b for b in bones if b.parent == chain.parent]
    return min(own, key=lambda b: b.child != chain.child, default=None)


def _hidden_share(
    chain: Chain,
    bones: Sequence[BoneSegment],
    before: tuple[Array, Array],
    after: tuple[Array, Array],
    height: float,
    directions: Array,
) -> Array:
    """Return the hidden share of a limb, the larger one of before and after, (directions,)."""
    joints = [j for j in (chain.parent, chain.child, chain.grandchild) if j >= 0]
    own = list(pairwise(joints))
    if isinstance(chain, Limb):
        own += [(chain.parent, chain.child), (chain.child, chain.end)]
    parents = [b.parent for b in bones]
    tips = np.array([b.tip for b in bones])
    bone = main_bone(chain, bones) if type(chain) is Chain else None
    shares = []
    poses = [before] if np.allclose(before[1], after[1]) else [before, after]
    for rotations, positions in poses:
        ends = positions[parents] + rotate(rotations[parents], tips)
        rods = occluders(bones, ends, positions, own, height)
        places = np.array(_ON_BONE)[:, None]
        points = np.vstack(
            [positions[a] + places * (positions[b] - positions[a]) for a, b in pairwise(joints)]
        )
        if bone is not None:  # its fins, before and after, may also be behind the bone below
            turns = np.stack([before[0][chain.parent], after[0][chain.parent]])
            fins = points[: len(places)] + _FIN * height * rotate(turns, bone.normal)[:, None]
            fins = fins.reshape(-1, 3)
            points = np.vstack([points, fins])
            below = [k for k, b in enumerate(bones) if (b.parent, b.child) in own[1:]]
            rod = occluders([bones[k] for k in below], ends[below], positions, (), height)
            shares.append(rod.hidden_share(fins, directions))
        shares.append(rods.hidden_share(points, directions))
    most: Array = np.max(shares, axis=0)
    return most
