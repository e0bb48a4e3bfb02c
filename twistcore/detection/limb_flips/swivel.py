"""Compute the swivel of a limb: the angle of its middle joint about the line between its ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.prediction import Mask
from twistcore.skeleton.angles import vector_angles_about_axis
from twistcore.skeleton.limb import Limb, joint_path, limb_middle_and_end_positions
from twistcore.skeleton.medians import medians
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    cross_products,
    multiply,
    rotate,
    twist_angle,
    vector_lengths,
    wrap,
)
from twistcore.work.frozen import dataclass

BENT = 0.03  # share of the limb's length; nearer to the line, the middle joint shows no angle
_FOLDED = 0.02  # share of the limb's length; an end nearer to the first joint defines no line
_REFINED = 5  # maximum number of rounds to refine the usual side
_ALIKE = np.radians(40.0)  # measures of a rotation that differ by less agree
_LARGE = np.radians(90.0)  # a larger rotation may take two frames


@dataclass(frozen=True, eq=False)
class Swivel:
    """The swivel of a limb about the line from its first joint P to its end E.

    C is the middle joint. Angles are in radians, and lengths are fractions of the limb's length.

    Attributes
    ----------
    angle
        The swivel angle φ: the angle of C about the line, measured from `side`, shape (frames,).
    jump
        The rotation of the limb about the line since the previous frame, shape (frames,). It is
        defined even if the limb is straight.
    height
        The distance of C from the line, shape (frames,).
    step
        The movement of E relative to P since the previous frame, shape (frames,).
    line
        The unit vector from P to E in world space, shape (frames, 3).
    child
        The position of C relative to P in world space, shape (frames, 3).
    end
        The rotation of E in world space, shape (frames, 4).
    side
        The usual direction from the line to C, in the coordinates of P's parent, shape (3,).
    """

    angle: Array
    jump: Array
    height: Array
    step: Array
    line: Array
    child: Array
    end: Array
    side: Array

    def angle_at(self, to_child: Array, to_end: Array) -> Array:
        """Return the swivel angle φ in radians for different positions of C and E, (frames,).

        The positions are in the form that
        :func:`~twistcore.skeleton.limb.limb_middle_and_end_positions` returns.
        """
        line = to_end / np.maximum(vector_lengths(to_end), 1e-12)[:, None]
        aside = to_child - np.einsum("ti,ti->t", to_child, line)[:, None] * line
        return _angle(line, aside, self.side)


def compute_limb_swivel(motion: Motion, limb: Limb) -> Swivel:
    """Compute the swivel of a limb.

    `angle` and `jump` are 0 in frames in which the line is undefined.
    """
    to_child, to_end = limb_middle_and_end_positions(motion, limb)
    length = float(vector_lengths(to_child).mean() + vector_lengths(to_end - to_child).mean())
    size = vector_lengths(to_end)
    lined = size > _FOLDED * length
    line = to_end / np.maximum(size, 1e-12)[:, None]
    aside = to_child - np.einsum("ti,ti->t", to_child, line)[:, None] * line
    height = vector_lengths(aside) / length
    side = _usual_side(line, aside, height)
    angle = np.where(lined & (height > 1e-9), _angle(line, aside, side), 0.0)
    # From here on, values are in world space, in which a rotation of P's parent is not compensated
    # by a rotation of P.
    above = _global_rotation(motion, int(motion.skeleton.parents[limb.parent]))
    line, aside = rotate(above, line), rotate(above, aside)
    upper = multiply(above, motion.rotations[:, limb.parent])
    lower = upper
    for joint in joint_path(motion.skeleton, limb.parent, limb.end)[:-1]:
        lower = multiply(lower, motion.rotations[:, joint])
    jump = _jump(upper, lower, line, aside, height)
    jump[1:][~(lined[1:] & lined[:-1])] = 0.0
    step = np.zeros(motion.frames)
    step[1:] = vector_lengths(np.diff(rotate(above, to_end), axis=0)) / length
    end = multiply(lower, motion.rotations[:, limb.end])
    child = rotate(above, to_child) / length
    return Swivel(angle, jump, height, step, line, child, end, side)


def _global_rotation(motion: Motion, joint: int) -> Array:
    """Return the global rotation of a joint, (frames, 4), or the identity if the joint is −1."""
    out = np.zeros((motion.frames, 4))
    out[:, 0] = 1.0
    while joint >= 0:
        out = multiply(motion.rotations[:, joint], out)
        joint = int(motion.skeleton.parents[joint])
    return out


def _jump(upper: Array, lower: Array, line: Array, aside: Array, height: Array) -> Array:
    """Return how far a limb rotated about its line since the previous frame, radians, (frames,).

    The line is from P to E. Three measures show the angle: the rotation of P, the rotation of the
    bone that ends in E, and the position of C. The result is the angle on which the position and at
    least one rotation agree, because a counter-twist or a spinning bone changes a rotation but does
    not move a joint. In a straight limb, C's position does not show the angle, so only the two
    rotations are compared. If the measures disagree, the smallest angle is returned. However, if
    the rotations and the position changed in different frames, the measures may agree over two
    frames. In that case, the angle over two frames is used.

    Parameters
    ----------
    upper, lower
        The global rotations of P and of the bone that ends in E, shape (frames, 4).
    line
        The unit vector from P to E, shape (frames, 3).
    aside
        The vector from the line to C, shape (frames, 3).
    height
        The distance of C from the line as a fraction of the limb's length, shape (frames,).
    """
    out = np.zeros(len(line))
    limb = upper, lower, line, aside, height
    out[1:], alike = _agreed([part[:-1] for part in limb], [part[1:] for part in limb])
    # The angle from frame k to k + 2 is the sum of out[k + 1] and out[k + 2].
    unlike = np.flatnonzero(~(alike[:-1] & alike[1:]))
    over_two, alike_two = _agreed([p[unlike] for p in limb], [p[unlike + 2] for p in limb])
    for i in np.flatnonzero(alike_two & (np.abs(over_two) > _LARGE)):
        pair = out[unlike[i] + 1 : unlike[i] + 3]
        if np.abs(pair).max() < _LARGE:
            pair[1] = wrap(over_two[i] - pair[0])
    return out


def _agreed(before: Sequence[Array], after: Sequence[Array]) -> tuple[Array, Mask]:
    """Return how far a limb rotates between pairs of frames, and a mask of the reliable angles.

    Both results have the shape (n,), and angles are in radians. `before` and `after` each contain
    the parameters of :func:`_jump` for n frames. An angle is reliable if the different measures of
    it agree.
    """
    upper, lower, line, aside, height = after
    way = _least_turn(before[2], line)
    of_upper, of_lower = (
        _roll(*q, way, line) for q in zip(before[:2], (upper, lower), strict=True)
    )
    seen = np.minimum(height, before[4]) > BENT
    place = vector_angles_about_axis(line, rotate(way, before[3]), aside)
    judge = np.where(seen, place, of_lower)
    off_upper, off_lower = wrap(of_upper - judge), wrap(of_lower - judge)
    nearer = np.where(seen & (np.abs(off_lower) < np.abs(off_upper)), off_lower, off_upper)
    least = np.where(np.abs(of_upper) < np.abs(judge), of_upper, judge)
    alike = np.abs(nearer) < _ALIKE
    return np.where(alike, wrap(judge + 0.5 * nearer), least), alike


def _least_turn(a: Array, b: Array) -> Array:
    """Return the shortest rotations from unit vectors a to unit vectors b, (n, 3) → (n, 4)."""
    q = np.concatenate([1.0 + np.einsum("ti,ti->t", a, b)[:, None], cross_products(a, b)], axis=1)
    size = vector_lengths(q)[:, None]
    turn: Array = np.where(size > 1e-6, q / np.maximum(size, 1e-12), [1.0, 0.0, 0.0, 0.0])
    return turn


def _roll(before: Array, after: Array, way: Array, line: Array) -> Array:
    """Return the angle by which a bone rolls about a line between frames, in radians, (n,).

    `before` and `after` are the rotations of the bone, (n, 4). `line` is the unit vector along the
    line, and `way` is the shortest rotation of the line between the frames, which is not part of
    the angle.
    """
    turn = multiply(after, conjugate(before))
    return twist_angle(multiply(turn, conjugate(way)), line)


def _usual_side(line: Array, aside: Array, height: Array) -> Array:
    """Return the usual direction from a limb's line to its middle joint, (3,).

    The parameters have the same meaning as in :func:`_jump`.
    """
    size = vector_lengths(aside)[:, None]
    weighed = aside / np.maximum(size, 1e-12) * (height / max(height.max(), 1e-12))[:, None]
    side: Array = medians(weighed, 0)
    for _ in range(_REFINED):
        agree = np.einsum("ti,ti->t", weighed, side - (line @ side)[:, None] * line) > 0.0
        if not agree.any():
            break
        side = weighed[agree].mean(axis=0)
    return side


def _angle(line: Array, aside: Array, side: Array) -> Array:
    """Return the angles about the line from direction `side` to the vectors `aside`, radians."""
    return vector_angles_about_axis(line, side - (line @ side)[:, None] * line, aside)
