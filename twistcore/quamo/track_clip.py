"""A clip tracked: chosen joints, hand gains at its own rate or learned ones at 25 Hz.

Causal, or both ways where the whole clip is there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.motion import Motion, Skeleton
from twistcore.progress import Tell, nobody
from twistcore.quamo.both_ways import track_both_ways
from twistcore.quamo.network import Network
from twistcore.quamo.resample import corrected, resampled, sample_times
from twistcore.quamo.spline import PLACE_SHARE, smoothed, smoothed_rotations, usual_cutoff
from twistcore.quamo.state_space import NETWORK_DT, Gains
from twistcore.quamo.topology import find_topology, metres_per_unit
from twistcore.quamo.tracker import HandGains, Step, Track, track
from twistcore.rotation import Array

_STILL = 1e-4  # of a quaternion; of the largest way that a place moves


@dataclass(frozen=True, eq=False)
class Tracked:
    """A tracked motion; snapped: joints set onto the input, (frames, joints of the skeleton).

    passes: every step forwards, if asked for, and then those backwards, if both ways; at: when each
    was, in frames of the clip (not whole at 25 Hz); joints: the skeleton's index of each joint of a
    step.
    """

    motion: Motion
    snapped: NDArray[np.bool_]
    passes: tuple[tuple[Step, ...], ...]
    at: Array
    joints: NDArray[np.int64]


def chosen_joints(skeleton: Skeleton, names: Sequence[str] | None) -> NDArray[np.int64]:
    """Indices of the named joints, or of all that can be written; TwistError where one is not."""
    rotatable = skeleton.rotatable
    able = np.ones(len(skeleton), dtype=np.bool_) if rotatable is None else rotatable
    if not names:
        return np.flatnonzero(able)
    for name in names:
        if name not in skeleton.names:
            raise TwistError(f"no joint {name!r}; expected some of {', '.join(skeleton.names)}")
        if not able[skeleton.index(name)]:
            raise TwistError(f"joint {name!r} has no three rotation channels to write to")
    return np.array(sorted({skeleton.index(name) for name in names}), dtype=np.int64)


def joints_of_24(
    skeleton: Skeleton, joints: NDArray[np.int64], *, strict: bool
) -> NDArray[np.int64]:
    """Those of the joints that networks know; TwistError where one is not and strict is set."""
    known = find_topology(skeleton).joints
    if strict and (other := np.setdiff1d(joints, known)).size:
        name = skeleton.names[int(other[0])]
        raise TwistError(f"joint {name!r} is not among the 24 that learned gains know")
    return np.intersect1d(joints, known)


def placed_joint(motion: Motion) -> int | None:
    """The joint whose place is the figure's: the topmost whose position channels move.

    As a rule the root; in some rigs that stands still and the hips below it move. None where no
    joint has position channels; the topmost that has some where nothing moves.
    """
    moving = _moving(motion)
    return (*moving, *motion.positioned, None)[0]


def left_out(
    motion: Motion, joints: NDArray[np.int64], placed: int | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of joints that turn, and of those whose place moves, and that nobody tracks.

    joints: whose rotation is tracked or smoothed; placed: whose place is, None for none.
    """
    names = motion.skeleton.names
    turned = np.ptp(motion.rotations, axis=0).max(axis=-1) > _STILL
    turning = np.setdiff1d(np.flatnonzero(turned), joints)
    return (
        tuple(names[int(j)] for j in turning),
        tuple(names[j] for j in _moving(motion) if j != placed),
    )


def _moving(motion: Motion) -> list[int]:
    """Joints whose position channels move, more than by the rounding of what is written."""
    way = np.ptp(motion.positions, axis=0).max(axis=-1, initial=0.0)
    least = _STILL * way.max(initial=0.0)
    return [j for j, w in zip(motion.positioned, way, strict=True) if w > least]


def track_by_hand(
    motion: Motion,
    joints: NDArray[np.int64],
    gains: Gains | None = None,
    *,
    causal: bool = True,
    place: bool = False,
    first: int = 0,
    keep_steps: bool = False,
    tell: Tell = nobody,
) -> Tracked:
    """Hand gains at the clip's own rate, those that follow the rate if none are given.

    causal: False for both ways, see :func:`track_both_ways`; place: track the place of
    :func:`placed_joint` as well, if there is one; first: where to start, earlier frames stay (a
    T-pose); tell: called with the share that is done. Raises UnstableGainsError where the gains
    diverge at this rate.
    """
    placed = placed_joint(motion) if place else None
    root = np.zeros((motion.frames - first, 3))
    if placed is not None:
        root = motion.translation(placed)[first:]
    found = (track if causal else track_both_ways)(
        motion.rotations[first:, joints],
        root,
        motion.frame_time,
        HandGains(gains),
        keep_steps=keep_steps,
        tell=tell,
    )
    snapped = np.zeros(motion.rotations.shape[:2], dtype=np.bool_)
    snapped[first:, joints] = found.snapped
    tracked = _written(motion, first, joints, found.q, placed, found.r)
    at = np.arange(first, motion.frames, dtype=np.float64)
    return Tracked(tracked, snapped, _passes(found), at, joints)


def track_learned(
    motion: Motion,
    joints: NDArray[np.int64],
    network: Network,
    *,
    unit: float | None = None,
    causal: bool = True,
    place: bool = False,
    first: int = 0,
    keep_steps: bool = False,
    tell: Tell = nobody,
) -> Tracked:
    """Gains of a network: the clip at 25 Hz is tracked, the correction carried back.

    A frame waits for the next sample of 25 Hz. unit: metres in one unit of the clip. All 24 joints
    are tracked, since the network looks at the whole body, and only `joints` are changed.
    causal: False for both ways, the network started at either end; tell: called with the share that
    is done.
    """
    topology = find_topology(motion.skeleton)
    scale = metres_per_unit(motion.skeleton, unit)
    if not motion.positioned or motion.positioned[0] != topology.joints[0]:
        raise TwistError("expected positions of the root for learned gains")
    part = motion.sliced(first, motion.frames)
    q, r = topology.reduced(part.rotations), scale * part.positions[:, 0]
    times = sample_times(len(q), motion.frame_time)
    q_in, r_in = resampled(q, r, times)
    found = (track if causal else track_both_ways)(
        q_in,
        r_in,
        NETWORK_DT,
        network.started(q_in, r_in),
        integration=network.integration,
        keep_steps=keep_steps,
        tell=tell,
    )
    q_new, r_new = corrected(q, r, times, q_in, r_in, found.q, found.r)
    restored = topology.restored(q_new, part.rotations)
    able = joints_of_24(motion.skeleton, joints, strict=False)
    placed = motion.positioned[0] if place else None
    tracked = _written(motion, first, able, restored[:, able], placed, r_new / scale)
    snapped = np.zeros(motion.rotations.shape[:2], dtype=np.bool_)
    shown_at = first + np.ceil(times - 1e-9).astype(np.intp)
    snapped[shown_at[:, None], topology.joints] = found.snapped
    return Tracked(tracked, snapped, _passes(found), first + times, topology.joints)


def smooth_clip(
    motion: Motion,
    joints: NDArray[np.int64],
    cutoff: float | None = None,
    *,
    place: bool = False,
    first: int = 0,
) -> Motion:
    """No tracker: a smoothing spline of the whole clip, which must be there to its end.

    cutoff: of rotations, Hz, :func:`usual_cutoff` if none is given; the place's is three quarters
    of it. The other words are those of :func:`track_by_hand`. TwistError where the clip's rate
    cannot have the cut-off.
    """
    dt, placed = motion.frame_time, placed_joint(motion) if place else None
    cutoff = usual_cutoff(dt) if cutoff is None else cutoff
    q = smoothed_rotations(motion.rotations[first:, joints], cutoff, dt)
    r = np.zeros((motion.frames - first, 3))
    if placed is not None:
        r = smoothed(motion.translation(placed)[first:], PLACE_SHARE * cutoff, dt)
    return _written(motion, first, joints, q, placed, r)


def _passes(found: Track) -> tuple[tuple[Step, ...], ...]:
    return tuple(steps for steps in (found.steps, found.steps_back) if steps)


def _written(
    motion: Motion,
    first: int,
    joints: NDArray[np.int64],
    q: Array,
    placed: int | None,
    r: Array,
) -> Motion:
    """The motion with these rotations of some joints, and places of `placed`, from a frame on."""
    rotations, positions = motion.rotations.copy(), motion.positions.copy()
    rotations[first:, joints] = q
    if placed is not None:
        positions[first:, motion.positioned.index(placed)] = r
    return replace(motion, rotations=rotations, positions=positions)
