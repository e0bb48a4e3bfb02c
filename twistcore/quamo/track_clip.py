"""Track or smooth chosen joints of a clip.

The tracker uses hand-tuned gains at the frame rate of the clip, or learned gains at 25 Hz. Tracking
is causal, or runs forward and backward in each capture between cuts.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.errors import TwistError
from twistcore.files.document_values import format_value_for_message
from twistcore.files.encoding import escape_control_characters
from twistcore.formats.smpl.skeleton import find_network_joints, metres_per_unit
from twistcore.quamo.both_ways import track_both_ways
from twistcore.quamo.network import Network
from twistcore.quamo.pieces import frame_ranges_between_cuts
from twistcore.quamo.resample import (
    apply_sample_corrections,
    interpolate_poses_at_times,
    network_sample_times,
)
from twistcore.quamo.spline import (
    PLACE_SHARE,
    default_spline_cutoff,
    rotations_smoothed_by_spline,
    smoothed_by_spline,
)
from twistcore.quamo.state_space import NETWORK_DT, Gains
from twistcore.quamo.tracker import HandGains, Step, TrackResult, track
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress, stage_progress

_STILL = 1e-4  # rounding error of a quaternion, or of a position relative to its range


@dataclass(frozen=True, eq=False)
class TrackedMotion:
    """A tracked motion, with information about the tracking.

    Attributes
    ----------
    motion
        The tracked motion.
    snapped
        Mask of the joints that were reset to the input, shape (frames, joints).
    apart
        Mask of the joints whose rotations in the two passes differ by more than 90°, shape (frames,
        joints).
    passes
        If requested, the steps of the forward pass and, if there was one, of the backward pass.
    at
        The time of each step in fractional frames of the clip, shape (steps,).
    joints
        The indices, in the skeleton, of the joints in each step.
    """

    motion: Motion
    snapped: NDArray[np.bool_]
    apart: NDArray[np.bool_]
    passes: tuple[tuple[Step, ...], ...]
    at: Array
    joints: NDArray[np.int64]


def select_writable_joints(skeleton: Skeleton, names: Sequence[str] | None) -> NDArray[np.int64]:
    """Return the indices of the named joints, or of all joints that can be written.

    A joint can be written if it has three rotation channels. Raises TwistError if a named joint
    does not exist or cannot be written.
    """
    rotatable = skeleton.rotatable
    able = np.ones(len(skeleton), dtype=np.bool_) if rotatable is None else rotatable
    if not names:
        return np.flatnonzero(able)
    for name in names:
        if name not in skeleton.names:
            known = escape_control_characters(", ".join(skeleton.names), most=600)
            raise TwistError(
                f"the clip has no joint {format_value_for_message(name)}; choose from {known}"
            )
        if not able[skeleton.index(name)]:
            raise TwistError(f"joint {name!r} does not have three rotation channels to write to")
    return np.array(sorted({skeleton.index(name) for name in names}), dtype=np.int64)


def select_network_joints(
    skeleton: Skeleton, joints: NDArray[np.int64], *, strict: bool
) -> NDArray[np.int64]:
    """Return the given joints that are among the 24 joints of the networks.

    If `strict` is True, any other joint raises TwistError.
    """
    known = find_network_joints(skeleton).joints
    if strict and (other := np.setdiff1d(joints, known)).size:
        name = skeleton.names[int(other[0])]
        raise TwistError(f"joint {name!r} is not one of the 24 joints that the learned gains cover")
    return np.intersect1d(joints, known)


def find_figure_position_joint(motion: Motion) -> int | None:
    """Return the joint whose position channels move the whole figure, or None if there is none.

    This is the topmost joint that moves and has at least half of all joints in its subtree. It is
    usually the root, but in some rigs the root is still and the hips below it move. If no such
    joint moves, the root is returned. The result is None if no joint has position channels.
    Movement in a T-pose at an end of the clip or across a cut is ignored.
    """
    skeleton = motion.skeleton
    carried = np.ones(len(skeleton), dtype=np.int64)  # joints in the subtree, including its top
    for joint in range(len(skeleton) - 1, -1, -1):
        if (parent := skeleton.parents[joint]) >= 0:
            carried[parent] += carried[joint]
    able = [j for j in motion.positioned if 2 * carried[j] >= len(skeleton)]
    roots = [j for j in motion.positioned if skeleton.parents[j] < 0]
    moving = _moving(motion)
    return (*(j for j in able if j in moving), *roots, *able, None)[0]


def check_position_trackable(motion: Motion, *, learned: bool = False) -> None:
    """Raise TwistError if the position of the figure cannot be tracked.

    The figure must have position channels. `learned` is True for learned gains, which track only
    the position of the root of the 24 joints.
    """
    if (placed := find_figure_position_joint(motion)) is None:
        raise TwistError(
            "expected position channels (usually of the root), which are needed to track "
            "the figure's position"
        )
    if learned and placed != (root := int(find_network_joints(motion.skeleton).joints[0])):
        names = motion.skeleton.names
        raise TwistError(
            f"the learned gains cover only the position of {names[root]!r}, but "
            f"{names[placed]!r} has the position of this figure: set the gains by hand, or "
            "track without the position"
        )


def untracked_rotating_and_moving_joints(
    motion: Motion, joints: NDArray[np.int64], placed: int | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the joints that rotate or move but are not tracked.

    `joints` contains the joints whose rotations are tracked or smoothed, and `placed` is the joint
    whose position is tracked, or None. The result is two sequences of names: the joints that rotate
    and the joints whose position changes.
    """
    names = motion.skeleton.names
    turned = _largest_way(motion, motion.rotations) > _STILL
    turning = np.setdiff1d(np.flatnonzero(turned), joints)
    return (
        tuple(names[int(j)] for j in turning),
        tuple(names[j] for j in _moving(motion) if j != placed),
    )


def _moving(motion: Motion) -> list[int]:
    """Return the joints whose position channels vary by more than the rounding of the file."""
    way = _largest_way(motion, motion.positions)
    least = _STILL * way.max(initial=0.0)
    return [j for j, w in zip(motion.positioned, way, strict=True) if w > least]


def _largest_way(motion: Motion, values: Array) -> Array:
    """Return the largest range of values within a capture, (frames, n, components) → (n,)."""
    way = np.zeros(values.shape[1])
    for start, stop in frame_ranges_between_cuts(motion, count_leading_rest_frames(motion)):
        way = np.maximum(way, np.ptp(values[start:stop], axis=0).max(axis=-1, initial=0.0))
    return way


def track_with_hand_gains(
    motion: Motion,
    joints: NDArray[np.int64],
    gains: Gains | None = None,
    *,
    causal: bool = True,
    place: bool = False,
    first: int = 0,
    keep_steps: bool = False,
    tell: Tell | None = None,
) -> TrackedMotion:
    """Track joints with hand-tuned gains at the frame rate of the clip.

    Raises UnstableGainsError if the gains diverge at this rate.

    Parameters
    ----------
    motion
        The motion.
    joints
        The indices of the joints to track.
    gains
        The gains, by default :meth:`Gains.by_hand` for the frame rate.
    causal
        If False, each capture (see :func:`frame_ranges_between_cuts`) is tracked forward and
        backward with :func:`track_both_ways`.
    place
        If True, the position of :func:`find_figure_position_joint` is tracked as well.
    first
        The first frame to track. Earlier frames, such as a T-pose, do not change.
    keep_steps
        If True, the result contains all steps.
    tell
        Function that is called with the progress, from 0 to 1.
    """
    placed = find_figure_position_joint(motion) if place else None
    root = np.zeros((motion.frames, 3)) if placed is None else motion.translation(placed)
    way = track if causal else track_both_ways

    def run(start: int, stop: int, tell: Tell) -> _Piece:
        found = way(
            motion.rotations[start:stop, joints],
            root[start:stop],
            motion.frame_time,
            HandGains(gains),
            keep_steps=keep_steps,
            tell=tell,
        )
        return _Piece(found, np.arange(start, stop, dtype=np.float64), found.q, found.r)

    return _tracked(
        motion, _spans(motion, first, causal), run, joints, joints, placed, tell or ignore_progress
    )


def track_with_network(
    motion: Motion,
    joints: NDArray[np.int64],
    network: Network,
    *,
    unit: float | None = None,
    causal: bool = True,
    place: bool = False,
    first: int = 0,
    keep_steps: bool = False,
    tell: Tell | None = None,
) -> TrackedMotion:
    """Track joints with the gains of a network at 25 Hz, and apply the correction to the clip.

    Each frame waits for the next 25 Hz sample. All 24 joints are tracked, since the network uses
    the whole body, but only the given joints are changed. Raises TwistError if the clip does not
    have these joints, or no position channels of the root.

    Parameters
    ----------
    motion
        The motion.
    joints
        The indices of the joints to change. Joints that are not among the 24 are ignored.
    network
        The network.
    unit
        The length of one unit of the clip in metres, by default CMU's unit.
    causal
        If False, each capture (see :func:`frame_ranges_between_cuts`) is tracked forward and
        backward, with an initial state from the network at either end.
    place
        If True, the position of the root is tracked as well (see :func:`check_position_trackable`).
    first, keep_steps, tell
        The same as for :func:`track_with_hand_gains`.
    """
    topology = find_network_joints(motion.skeleton)
    scale = metres_per_unit(motion.skeleton, unit)
    if not motion.positioned or motion.positioned[0] != topology.joints[0]:
        raise TwistError("learned gains need position channels of the root")
    if place:
        check_position_trackable(motion, learned=True)
    able = select_network_joints(motion.skeleton, joints, strict=False)
    way = track if causal else track_both_ways

    def run(start: int, stop: int, tell: Tell) -> _Piece:
        own = motion.sliced(start, stop)
        q, r = topology.reduced(own.rotations), scale * own.positions[:, 0]
        times = network_sample_times(len(q), motion.frame_time)
        q_in, r_in = interpolate_poses_at_times(q, r, times)
        found = way(
            q_in,
            r_in,
            NETWORK_DT,
            network.started(q_in, r_in),
            integration=network.integration,
            keep_steps=keep_steps,
            tell=tell,
        )
        q_new, r_new = apply_sample_corrections(q, r, times, q_in, r_in, found.q, found.r)
        restored = topology.restored(q_new, own.rotations)
        return _Piece(found, start + times, restored[:, able], r_new / scale)

    placed = motion.positioned[0] if place else None
    spans = _spans(motion, first, causal)
    return _tracked(motion, spans, run, able, topology.joints, placed, tell or ignore_progress)


def smooth_captures_with_spline(
    motion: Motion,
    joints: NDArray[np.int64],
    cutoff: float | None = None,
    *,
    place: bool = False,
    first: int = 0,
) -> Motion:
    """Smooth joints with a spline, separately in each capture between cuts.

    `cutoff` is the cut-off for rotations in Hz, by default :func:`default_spline_cutoff`. The
    cut-off for the position is three quarters of it. The other parameters are the same as for
    :func:`track_with_hand_gains`. Raises TwistError if the cut-off does not fit the frame rate of
    the clip.
    """
    dt, placed = motion.frame_time, find_figure_position_joint(motion) if place else None
    cutoff = default_spline_cutoff(dt) if cutoff is None else cutoff
    parts = []
    for start, stop in frame_ranges_between_cuts(motion, first):
        q = rotations_smoothed_by_spline(motion.rotations[start:stop, joints], cutoff, dt)
        r = np.zeros((stop - start, 3))
        if placed is not None:
            r = smoothed_by_spline(motion.translation(placed)[start:stop], PLACE_SHARE * cutoff, dt)
        parts.append((start, q, r))
    return _written(motion, joints, placed, parts)


@dataclass(frozen=True, eq=False)
class _Piece:
    """The result of tracking a span of frames.

    Attributes
    ----------
    found
        The result of the tracker.
    at
        The times of the steps in fractional frames of the clip.
    q, r
        The rotations, shape (frames, joints, 4), and positions, shape (frames, 3), to write.
    """

    found: TrackResult
    at: Array
    q: Array
    r: Array


def _spans(motion: Motion, first: int, causal: bool) -> tuple[tuple[int, int], ...]:
    """Return the spans to track: the captures or, for a causal pass, all frames as one span.

    A causal pass is not split, because it does not know where the cuts are.
    """
    return ((first, motion.frames),) if causal else frame_ranges_between_cuts(motion, first)


def _tracked(
    motion: Motion,
    spans: Sequence[tuple[int, int]],
    run: Callable[[int, int, Tell], _Piece],
    joints: NDArray[np.int64],
    stepped: NDArray[np.int64],
    placed: int | None,
    tell: Tell,
) -> TrackedMotion:
    """Track each span with the function `run`, and combine the results.

    `joints` contains the joints to write, and `stepped` the joints in each step of the tracker.
    `placed` is the joint whose position is written, or None.
    """
    snapped = np.zeros(motion.rotations.shape[:2], dtype=np.bool_)
    apart = np.zeros_like(snapped)
    frames = sum(stop - start for start, stop in spans)
    done, parts = 0, []
    at: list[Array] = [np.zeros(0)]
    ahead: list[Step] = []
    back: list[Step] = []
    for start, stop in spans:
        told, done = done, done + stop - start
        made = run(start, stop, stage_progress(tell, told / frames, done / frames))
        parts.append((start, made.q, made.r))
        at.append(made.at)
        ahead += made.found.steps
        back += made.found.steps_back
        shown_at = np.ceil(made.at - 1e-9).astype(np.intp)[:, None]
        snapped[shown_at, stepped] = made.found.snapped
        if made.found.apart is not None:
            apart[shown_at, stepped] = made.found.apart
    return TrackedMotion(
        _written(motion, joints, placed, parts),
        snapped,
        apart,
        tuple(tuple(steps) for steps in (ahead, back) if steps),
        np.concatenate(at),
        stepped,
    )


def _written(
    motion: Motion,
    joints: NDArray[np.int64],
    placed: int | None,
    parts: Sequence[tuple[int, Array, Array]],
) -> Motion:
    """Return the motion with new rotations of `joints` and new positions of the joint `placed`.

    Each of `parts` consists of its first frame, its rotations and its positions.
    """
    rotations, positions = motion.rotations.copy(), motion.positions.copy()
    for start, q, r in parts:
        rotations[start : start + len(q), joints] = q
        if placed is not None:
            positions[start : start + len(q), motion.positioned.index(placed)] = r
    return replace(motion, rotations=rotations, positions=positions)
