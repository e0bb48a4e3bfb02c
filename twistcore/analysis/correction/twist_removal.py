"""Remove errors from a motion without changing anything else [Choi26 Eq. 14-15].

Errors of single joints that a person has accepted are removed last, by `joint_repairs.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import attrgetter
from types import MappingProxyType
from typing import Any, Protocol, cast, overload, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.correction.joint_repairs import JointRepairs, repaired_joints
from twistcore.detection.interval import Interval
from twistcore.errors import TwistError
from twistcore.skeleton.chain import Chain, uncorrectable_joints
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb, joint_path, limb_middle_and_end_positions
from twistcore.skeleton.motion import HasMotion, Motion, motion_of
from twistcore.skeleton.rig import AS_FOUND
from twistcore.skeleton.rotation import (
    Array,
    conjugate,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    rotate,
    vector_lengths,
    wrap,
)

SURE_ENOUGH = 0.5  # default for the minimum confidence of automatic corrections
# Share of the skeleton's height; a shorter line from a limb's first joint to its end is ignored.
_FOLDED = 1e-6
_ON_AXIS = np.sin(np.radians(0.5))


def automatic_corrections(
    intervals: Iterable[Interval],
    at_least: float | None = None,
    *,
    include_open: bool = False,
    confidence: Callable[[Interval], float | None] = attrgetter("confidence"),
) -> tuple[Interval, ...]:
    """Return the intervals that are corrected automatically.

    Only this function makes this decision. Lone jumps are excluded because they have no offset
    to remove. Helper rolls, stretches and spikes are excluded because their confidence is not
    measured.

    Parameters
    ----------
    intervals
        The intervals to choose from.
    at_least
        Minimum confidence, 0…1. By default, :data:`SURE_ENOUGH`. Intervals without a confidence,
        such as those of the paper's detector, are returned only if `at_least` is None or 0.
    include_open
        True to include open intervals.
    confidence
        Function that returns the confidence of an interval. By default, the value that the detector
        stored in the interval.
    """
    return tuple(
        i
        for i in intervals
        if i.automatic and (include_open or not i.open) and _sure(confidence(i), at_least)
    )


def _sure(confidence: float | None, at_least: float | None) -> bool:
    if confidence is None:
        return not at_least
    return confidence >= (SURE_ENOUGH if at_least is None else at_least)


def offsets_by_chain(intervals: Iterable[Interval], frames: int) -> dict[str, Array]:
    """Return the sum of the intervals' offsets for each chain, keyed by chain name.

    Offsets are in radians in (−π, π], shape (frames,). Single-joint errors are excluded.
    """
    total: dict[str, Array] = {}
    for interval in intervals:
        if interval.kind.info.repairer:
            continue
        if interval.chain not in total:
            total[interval.chain] = np.zeros(frames)
        total[interval.chain][interval.start : interval.stop] += interval.offset
    return {chain: wrap(offset) for chain, offset in total.items()}


def offsets_carried_to_child(intervals: Iterable[Interval], frames: int) -> dict[str, Array]:
    """Return the sum of the carried offsets for each chain or limb, keyed by name.

    In a carried error, the child of the chain or the end of the limb rotates along. The result has
    the same form as in :func:`offsets_by_chain`.
    """
    return offsets_by_chain((i for i in intervals if i.carried), frames)


@runtime_checkable
class Correctable(Protocol):
    """An object that knows which intervals to correct, such as a detection or a review."""

    def to_correct(self, motion: Motion) -> tuple[Sequence[Chain], Sequence[Interval]]:
        """Return the chains and limbs of the motion, and the intervals to correct."""
        ...


@overload
def refine(clip: Motion | HasMotion, found: Correctable | Iterable[Interval], /) -> Motion: ...


@overload
def refine(
    clip: Motion | HasMotion, chains: Sequence[Chain], intervals: Iterable[Interval]
) -> Motion: ...


def refine(
    clip: Motion | HasMotion,
    chains: Correctable | Iterable[Interval] | Sequence[Chain],
    intervals: Iterable[Interval] | None = None,
) -> Motion:
    """Remove errors from a motion. All other frames and joints keep exactly the same rotations.

    Call it as ``refine(clip, found)`` or as ``refine(clip, chains, intervals)``.

    Parameters
    ----------
    clip : Clip or Motion
        The clip to correct. It is not changed.
    found : Detection, Review or iterable of Interval
        The errors to remove: the automatic corrections of a detection, the accepted intervals of a
        review, or all intervals of an iterable. Their chains are looked up in the clip. Stretches
        and spikes are corrected only from a review.
    chains : sequence of Chain
        The chains and limbs to which the intervals belong.
    intervals : iterable of Interval
        The intervals to remove. Intervals of other chains are ignored, and so are intervals that
        cannot be corrected because a joint lacks rotation channels.

    Returns
    -------
    Motion
        The corrected motion, with the same skeleton, positions and number of frames.

    Raises
    ------
    TypeError
        If `clip` is neither a clip nor a motion, or `found` is none of the above.
    TwistError
        If an interval ends after the last frame.

    See Also
    --------
    Detection.refined : The corrected motion, as a method.
    write_clip : Write the result.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk_injected.bvh")
    >>> found = tc.detect(clip)
    >>> len(found), len(tc.detect(tc.refine(clip, found)))
    (8, 0)

    Remove only some of the intervals:

    >>> some = [i for i in found if i.chain == "LeftForeArm"]
    >>> len(tc.detect(tc.refine(clip, some)))
    5
    """
    motion = motion_of(clip)
    if intervals is None:
        every, intervals = _to_correct(motion, chains)
    else:
        every, intervals = cast("Sequence[Chain]", chains), list(intervals)
    if beyond := next((i for i in intervals if i.stop > motion.frames), None):
        raise TwistError(
            f"expected intervals inside the clip ({motion.frames} frames), found {beyond!r}"
        )
    # Positions stay the same object, so a writer recognises that they have not changed.
    return motion.with_rotations(refiner(motion, every, intervals)(0, motion.frames).rotations)


def refiner(
    motion: Motion, chains: Sequence[Chain], intervals: Iterable[Interval]
) -> Callable[[int, int], Motion]:
    """Return a function that computes frames [start, stop) of the result of :func:`refine`."""
    by_name, frames = {chain.name: chain for chain in chains}, motion.frames
    intervals = [
        i
        for i in intervals
        if i.chain in by_name and not joints_lacking_channels(motion, by_name[i.chain], [i])
    ]
    offsets, carried = (
        offsets_by_chain(intervals, frames),
        offsets_carried_to_child(intervals, frames),
    )
    return offset_remover(motion, chains, offsets, carried, JointRepairs(intervals))


def offset_remover(
    motion: Motion,
    chains: Sequence[Chain],
    offsets: Mapping[str, Array],
    carried: Mapping[str, Array],
    repairs: JointRepairs,
) -> Callable[[int, int], Motion]:
    """Return a function that computes frames [start, stop) of a corrected motion.

    `offsets` and `carried` are the same as in :func:`remove_twist`. `repairs` are the repairs of
    single joints.
    """

    def refined(start: int, stop: int) -> Motion:
        low, high = repairs.needed(start, stop, motion.frames)
        at = slice(low, high)
        untwisted = remove_twist(
            motion.sliced(low, high),
            [chain.at(at) for chain in chains],
            {name: offset[at] for name, offset in offsets.items()},
            {name: offset[at] for name, offset in carried.items()},
        )
        return repairs.applied(untwisted, low).sliced(start - low, stop - low)

    return refined


def _to_correct(motion: Motion, found: Any) -> tuple[Sequence[Chain], Sequence[Interval]]:
    """Return the motion's chains and the intervals to remove.

    `found` is a detection, a review or an iterable of intervals. Raises TypeError for anything
    else.
    """
    if isinstance(found, Correctable):
        return found.to_correct(motion)
    intervals = [*found] if isinstance(found, Iterable) else [found]
    for thing in intervals:
        if not isinstance(thing, Interval):
            raise TypeError(f"expected a detection, a review or intervals, found {thing!r:.80}")
    return AS_FOUND.chains(motion), intervals


def joints_lacking_channels(
    motion: Motion, chain: Chain, intervals: Iterable[Interval]
) -> tuple[str, ...]:
    """Return the names of joints that cannot be corrected because they lack rotation channels."""
    own = [i for i in intervals if i.chain == chain.name]
    carried = {i.carried for i in own if not i.kind.info.repairer}
    stuck = uncorrectable_joints(motion, chain, carried=all(carried)) if carried else ()
    skeleton = motion.skeleton
    if skeleton.rotatable is None:
        return stuck
    alone = (j for i in JointRepairs(own).intervals for j in repaired_joints(skeleton, i))
    return tuple(
        dict.fromkeys((*stuck, *(skeleton.names[j] for j in alone if not skeleton.rotatable[j])))
    )


def remove_twist(
    motion: Motion,
    chains: Sequence[Chain],
    offsets: Mapping[str, Array],
    carried: Mapping[str, Array] = MappingProxyType({}),
) -> Motion:
    """Remove offsets from chains and limbs.

    Frames with an offset of 0 stay bit-identical. The order of corrections does not matter, because
    no twist moves the line from a limb's first joint to its end in world space.

    For a chain of joints P, C and G, q'_P = q_P ⊗ R_a(−offset), where a is the bone axis, and q'_X
    = q'_P⁻¹ ⊗ q_P ⊗ q_X for every child X of P. All global rotations below P stay the same, and so
    do all joint positions except those of children off the axis (:func:`children_off_axis`). If C
    rolled with P, C is also rotated about its own bone b by R_b(−carried). G keeps its position,
    and all joints below C rotate with it.

    For a limb of joints P, C and E, q'_P = R_u(−offset) ⊗ q_P, where u is the line from P to E in
    the coordinates of P's parent. E keeps its position and, except for the carried part, its global
    rotation. C keeps its local rotation and moves.

    Parameters
    ----------
    motion
        The motion to correct. It is not changed.
    chains
        Chains and limbs.
    offsets
        Angles to remove, radians, (frames,), keyed by name.
    carried
        The part of each offset by which the chain's child or the limb's end also rotated.
    """
    rotations = motion.rotations.copy()
    for chain in chains:
        offset = offsets.get(chain.name)
        if offset is None or uncorrectable_joints(motion, chain, carried=True):
            continue
        at, along = np.flatnonzero(offset), carried.get(chain.name)
        # Only frames in which the end was carried can be corrected.
        if uncorrectable_joints(motion, chain):
            at = at[offset[at] == along[at]] if along is not None else at[:0]
        if not len(at):
            continue
        if isinstance(chain, Limb):
            kept = offset[at] if along is None else offset[at] - along[at]
            _turn_limb(motion, rotations, chain, at, offset[at], kept)
            continue
        if isinstance(chain, Helper):
            _turn_helper(motion, rotations, chain, at, offset[at])
            continue
        axis = _bone(motion, chain, at)
        parent = rotations[at, chain.parent]
        back = quaternion_from_axis_angle(axis, -offset[at])
        rotations[at, chain.parent] = normalise(multiply(parent, back))
        # For any q_P, q'_P⁻¹ ⊗ q_P = R_a(offset).
        ahead = quaternion_from_axis_angle(axis, offset[at])
        for child in motion.skeleton.children[chain.parent]:
            rotations[at, child] = normalise(multiply(ahead, rotations[at, child]))
        if along is not None and along.any():
            _roll_back(rotations, chain, np.flatnonzero(along), along)
    return motion.with_rotations(rotations)


def _roll_back(rotations: Array, chain: Chain, at: NDArray[np.intp], rolled: Array) -> None:
    """Rotate a chain's child about its own bone by −`rolled`.

    `rolled` is the angle by which the child rolled with its parent in every frame, radians. The
    grandchild keeps its position. `rotations` is changed in the frames `at`.
    """
    arm = chain.arm if chain.arm.ndim == 1 else chain.arm[at]
    back = quaternion_from_axis_angle(arm, -rolled[at])
    rotations[at, chain.child] = normalise(multiply(rotations[at, chain.child], back))


def _turn_helper(
    motion: Motion, rotations: Array, helper: Helper, at: NDArray[np.intp], offset: Array
) -> None:
    """Rotate a helper about its bone by −`offset`. The joints below keep their orientation.

    `rotations` is changed in the frames `at`. `offset` contains the angle in each of these frames,
    radians.
    """
    axis = helper.axis if helper.axis.ndim == 1 else helper.axis[at]
    before = rotations[at, helper.parent]
    after = normalise(multiply(quaternion_from_axis_angle(axis, -offset), before))
    rotations[at, helper.parent] = after
    ahead = multiply(conjugate(after), before)
    for child in motion.skeleton.children[helper.parent]:
        rotations[at, child] = normalise(multiply(ahead, rotations[at, child]))


def _turn_limb(
    motion: Motion,
    rotations: Array,
    limb: Limb,
    at: NDArray[np.intp],
    offset: Array,
    kept: Array,
) -> None:
    """Rotate a limb by −`offset` about its line, and rotate its end by +`kept` about this line.

    The line runs from the first joint to the end. It is measured in the current coordinates of the
    first joint's parent, because a correction of the chain above rotates these coordinates. If the
    end coincides with the first joint, there is no line, and the limb is not rotated. `rotations`
    is changed in the frames `at`. Both angles are in radians, shape (n,).
    """
    _, to_end = limb_middle_and_end_positions(motion.at(at).with_rotations(rotations[at]), limb)
    length = vector_lengths(to_end)
    line = to_end / np.maximum(length, 1e-12)[:, None]
    there = length > _FOLDED * motion.skeleton.height
    offset, kept = np.where(there, offset, 0.0), np.where(there, kept, 0.0)
    above = rotations[at, limb.parent]
    for joint in joint_path(motion.skeleton, limb.parent, limb.end)[:-1]:
        above = multiply(above, rotations[at, joint])
    back = quaternion_from_axis_angle(line, -offset)
    ahead = quaternion_from_axis_angle(rotate(conjugate(above), line), kept)
    # If the end rotated with the limb, its local rotation must stay bit-identical.
    for joint, turn, by in ((limb.parent, back, offset), (limb.end, ahead, kept)):
        turned = np.flatnonzero(by)
        frames = at[turned]
        rotations[frames, joint] = normalise(multiply(turn[turned], rotations[frames, joint]))


def _bone(motion: Motion, chain: Chain, at: NDArray[np.intp]) -> Array:
    """Return the unit axis of a correction in the frames `at`, (3,) or (n, 3).

    If the child has position channels, the axis points to its exact position in each frame, even if
    the direction varies by less than the 1° that detection ignores. A rotation about a mean axis
    would move the child.
    """
    if chain.child in motion.positioned:
        place = motion.translation(chain.child)[at]
        if (vector_lengths(place) > 1e-6 * motion.skeleton.height).all():
            return normalise(place)
    return chain.axis if chain.axis.ndim == 1 else chain.axis[at]


def children_off_axis(motion: Motion, chain: Chain) -> dict[str, float]:
    """Return the children of a chain's parent joint that are off the bone axis.

    A correction moves these children. The result maps their names to their distances from the axis,
    in the file's unit. It is empty for an ordinary arm or leg.
    """
    out: dict[str, float] = {}
    if isinstance(chain, Limb):  # the joints of a limb are meant to move
        return out
    skeleton = motion.skeleton
    axis = np.atleast_2d(chain.axis)
    for child in skeleton.children[chain.parent]:
        if child == chain.child:
            continue
        place = np.atleast_2d(motion.translation(child))
        away = float(vector_lengths(np.cross(place, axis)).max())
        if away > _ON_AXIS * max(float(vector_lengths(place).max()), 1e-12):
            out[skeleton.names[child]] = away
    return out
