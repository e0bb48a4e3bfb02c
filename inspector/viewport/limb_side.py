"""Find the best direction for viewing the error of a limb, and the points to show."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

import numpy as np

from inspector.viewport.bodies import BoneSegment
from inspector.viewport.camera import OrbitCamera, circle_viewing_direction, roll_viewing_direction
from inspector.viewport.limb_circle import (
    LEAST_RADIUS,
    Circle,
    bone_circle,
    find_limb_circle,
    helper_circle,
)
from inspector.viewport.occlusion import occluders
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.rotation import Array, normalise, rotate

_ON_BONE = (0.15, 0.4, 0.65, 0.9)  # positions on a bone, 0…1, that should be visible
_ROOM = 1.2  # size of the image relative to the shown points if they include a limb's circle
_OUTER = 0.9  # distance of the points on a fan from its centre, in radii of the fan
_FIN = 0.06  # distance from the bone to the tip of its fin, in figure heights
_AROUND = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)  # angles of points on a circle
_NEXT = 0.4  # share of each neighbouring bone that the image shows
_STILL = 0.02  # in figure heights; a joint that moves less is treated as unchanged
_AIR = 0.035  # margin around the limb, in figure heights


@dataclass(frozen=True, eq=False)
class LimbSide:
    """The best view of a limb.

    Attributes
    ----------
    direction
        The unit vector towards the camera, (3,).
    points
        The points to show, (n, 3).
    margin
        The size of the image relative to the extent of these points.
    """

    direction: Array
    points: Array
    margin: float = 1.1

    def camera(
        self, camera: OrbitCamera, height: float, aspect: float, *, covered: float = 0.0
    ) -> OrbitCamera:
        """Return a camera that shows this view.

        Parameters
        ----------
        camera
            The current camera.
        height
            The height of the figure.
        aspect
            The width of the image divided by its height.
        covered
            The share of the image's height that is covered at the top.
        """
        corners = [self.points + _AIR * height * e for e in (*np.eye(3), *-np.eye(3))]
        turned = camera.looking_from(self.direction)
        return turned.framing(np.vstack(corners), aspect, margin=self.margin, covered=covered)


def limb_joints(chain: Chain, positions: Array) -> Array:
    """Return the positions of the joints of a chain or limb, (n, 3) with n = 2 or 3.

    `positions` contains the positions of all joints, (joints, 3).
    """
    joints = [j for j in (chain.parent, chain.child, chain.grandchild) if j >= 0]
    return positions[joints]


def best_limb_error_view(
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
    """Return the best view of the error of a chain or limb, or None if the bone is not drawn.

    The view of a limb or twist bone shows its circle at an angle, so the circle looks open.

    Parameters
    ----------
    chain
        The chain, limb or twist bone.
    bones
        All bones of the figure.
    before, after
        The global rotations (joints, 4) and positions (joints, 3) before and after correction.
    facing, up
        The direction in which the figure faces, and the upward direction, unit vectors (3,).
    skeleton
        The skeleton of the clip.
    height
        The height of the figure.
    above
        The index of the joint above the chain, if it is also shown, or −1.
    body
        The joints of the person to whom the limb belongs; by default, all joints.
    """
    rotations, positions = after
    limb = limb_joints(chain, positions)
    circle: Circle | None = None
    fan = np.zeros((0, 3))
    if isinstance(chain, Helper):
        limb = np.vstack([limb, positions[int(skeleton.parents[chain.parent])]])
        circle = helper_circle(chain, skeleton, before, height)
    elif isinstance(chain, Limb):
        circle = find_limb_circle(chain, before[1])
        if circle is not None:
            circle = circle.widened(LEAST_RADIUS * height)
            fan = _fan(circle, positions[chain.child] - circle.centre)
    middle = positions[list(body) or slice(None)].mean(axis=0)
    outward = limb.mean(axis=0) - middle
    hidden = partial(_hidden_share, chain, bones, before, after, height)
    if circle is not None:
        direction = circle_viewing_direction(
            circle.axis, circle.aside, outward, facing, up, partial(hidden, fan)
        )
        return LimbSide(direction, np.vstack([limb, circle.at(_AROUND)]), _ROOM)
    if above >= 0:
        limb = np.vstack([limb, positions[above]])
        outward = limb.mean(axis=0) - middle
    # The rotated bone should fill most of the image, so only a part of its neighbours is shown.
    ends = limb[:2]
    limb = np.vstack([ends, ends[1] + _NEXT * (limb[2:3] - ends[1])])
    if above >= 0:
        limb = np.vstack([limb, ends[0] + _NEXT * (positions[above] - ends[0])])
    limb = np.vstack([limb, *_first_moved(chain, skeleton, before[1], positions, height)])
    bone = main_bone(chain, bones)
    if bone is None:
        return None
    fronts = [rotate(pose[0][chain.parent], bone.normal) for pose in (before, after)]
    circle = bone_circle(before[1][[chain.parent, chain.child]], fronts[0], height)
    if circle is not None:
        limb = np.vstack([limb, circle.at(_AROUND)])
        fan = _fan(circle, fronts[1])
    size = float(np.linalg.norm(outward))
    direction = roll_viewing_direction(
        normalise(rotate(rotations[chain.parent], bone.tip)),
        fronts[1],
        fronts[0],
        outward / size if size > 0.0 else outward,
        facing,
        up,
        partial(hidden, fan),
    )
    return LimbSide(direction, limb)


def _fan(circle: Circle, after: Array) -> Array:
    """Return points on the fan, the sector from the captured to the corrected direction, (n, 3).

    `after` is the corrected direction, (3,). The captured direction is `circle.aside`.
    """
    goal = normalise(after - (after @ circle.axis) * circle.axis)
    first = normalise(circle.aside)
    turn = float(np.arctan2(np.cross(first, goal) @ circle.axis, first @ goal))
    return circle.centre + _OUTER * (circle.at(np.linspace(0.0, turn, 3)) - circle.centre)


def _first_moved(
    chain: Chain, skeleton: Skeleton, before: Array, after: Array, height: float
) -> tuple[Array, Array]:
    """Find the joints closest to the parent of a chain that the correction moves.

    The search goes down from the parent and ends, on each branch, at the first joint that moves.

    Parameters
    ----------
    chain
        The chain or limb.
    skeleton
        The skeleton of the clip.
    before, after
        The positions of all joints before and after correction, (joints, 3).
    height
        The height of the figure.

    Returns
    -------
    tuple of ndarray
        The positions of these joints before and after correction, each (n, 3).
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
    """Return the bone of a chain from its parent P to its child C.

    If this bone is not drawn, the result is a different bone that begins at P, or None.
    """
    own = [b for b in bones if b.parent == chain.parent]
    return min(own, key=lambda b: b.child != chain.child, default=None)


def _hidden_share(
    chain: Chain,
    bones: Sequence[BoneSegment],
    before: tuple[Array, Array],
    after: tuple[Array, Array],
    height: float,
    fan: Array,
    directions: Array,
) -> Array:
    """Return the share of a limb and its fan that is hidden from each direction, (directions,).

    The result is the largest of several shares, computed before and after correction: the share of
    the limb and the fan that other bones hide, and the share of the fan that the limb itself hides.

    Parameters
    ----------
    chain
        The chain or limb.
    bones
        All bones of the figure.
    before, after
        The global rotations (joints, 4) and positions (joints, 3) before and after correction.
    height
        The height of the figure.
    fan
        Points on the fan, (n, 3).
    directions
        Unit vectors towards the camera, (directions, 3).
    """
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
        limb = [k for k, b in enumerate(bones) if (b.parent, b.child) in own[bone is not None :]]
        rod = occluders([bones[k] for k in limb], ends[limb], positions, (), height)
        places = np.array(_ON_BONE)[:, None]
        points = np.vstack(
            [positions[a] + places * (positions[b] - positions[a]) for a, b in pairwise(joints)]
        )
        marks = fan
        if bone is not None:  # the next bone may also hide this bone and its fins
            turns = np.stack([before[0][chain.parent], after[0][chain.parent]])
            fins = points[: len(places)] + _FIN * height * rotate(turns, bone.normal)[:, None]
            marks = np.vstack([points[: len(places) - 1], fins.reshape(-1, 3), fan])
        shares.append(rod.hidden_share(marks, directions))
        points = np.vstack([points, marks])
        shares.append(rods.hidden_share(points, directions))
    most: Array = np.max(shares, axis=0)
    return most
