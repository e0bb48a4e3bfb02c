"""Propose the frames and the offset of an interval that the user inserts by hand."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from twistcore.analysis.correction.joint_repairs import interval_joint_index, remove_joint_roll
from twistcore.detection import Interval, Kind
from twistcore.detection.finding import KindSearch
from twistcore.detection.interval_offsets import (
    angles_relative_to_adjacent_frames,
    new_constant_offset_interval,
)
from twistcore.detection.limb_flips import BENT, LimbFlips
from twistcore.detection.stretches import (
    find_stretches,
    roll_deviation,
    wrongly_rolled_joint_interval,
)
from twistcore.skeleton.angles import circular_median
from twistcore.skeleton.medians import median
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, geodesic_angle, slerp
from twistcore.skeleton.signals import TwistSignals

_REACH = 0.5  # seconds before and after the frame in which edges are searched for
_HALF = 0.05  # seconds before and after the frame if there are no edges
_JUMPS = Kind.LONE_JUMP, Kind.JOINT_JUMP  # kinds that may be the edge of another error
_SOON = 0.2  # seconds; longest spike
_BACK = 0.4  # largest angle between the frames before and after a spike, as a share of its jump
_FAINT, _FAINT_FLIP = np.radians(1.0), np.radians(25.0)  # smallest jumps that count as edges


def proposed_interval(chain: str, signals: TwistSignals, frame: int, fps: float) -> Interval:
    """Return an interval between the strongest counter-rotations before and after a frame.

    In a counter-rotation, the parent and the child rotate in opposite directions. The
    counter-rotations are searched for within half a second of the frame. If there is none of 1° or
    more, the interval is 0.1 s long. The offset is as in :func:`interval_with_proposed_offset`.

    Parameters
    ----------
    chain
        Name of the chain.
    signals
        The chain's signals.
    frame
        A frame inside the interval.
    fps
        Frames per second.
    """
    frames = len(signals.theta_p)
    reach = max(2, round(_REACH * fps))
    first, last = max(1, frame - reach), min(frames, frame + reach + 1)
    start = _strongest(signals.strength, first, frame + 1)
    stop = _strongest(signals.strength, max(frame, start) + 1, last)
    return interval_with_proposed_offset(
        chain, signals, *_both_edges(start, stop, frame, frames, fps)
    )


def interval_with_proposed_offset(
    chain: str, signals: TwistSignals, start: int, stop: int
) -> Interval:
    """Return an interval over [start, stop) with an offset proposed from the chain's signals.

    The offset is the median of the parent's twist θp in the interval, relative to a line between
    the frames before and after the interval.
    """
    level = median(angles_relative_to_adjacent_frames(signals.theta_p, start, stop))
    return new_constant_offset_interval(chain, start, stop, level)


def propose_limb_flip_at_frame(limb: LimbFlips, frame: int) -> Interval:
    """Return a limb flip between the nearest jumps before and after a frame.

    If there is no jump of 25° or more within half a second, the interval is 0.1 s long. The offset
    is the median of the swivel angle in the interval, relative to a line between the frames before
    and after the interval. For a straight limb, the offset is the jump at the start.
    """
    jumps = np.flatnonzero(np.abs(limb.departures) >= _FAINT_FLIP)
    near = jumps[np.abs(jumps - frame) <= max(2, round(_REACH * limb.fps))]
    start = int(near[near <= frame].max(initial=-1))
    stop = int(near[near > frame].min(initial=len(limb.departures)))
    stop = stop if stop < len(limb.departures) else -1
    return propose_limb_flip_in_frames(
        limb, *_both_edges(start, stop, frame, len(limb.departures), limb.fps)
    )


def propose_limb_flip_in_frames(limb: LimbFlips, start: int, stop: int) -> Interval:
    """Return a limb flip in frames [start, stop).

    The offset is computed as in :func:`propose_limb_flip_at_frame`.
    """
    level = circular_median(angles_relative_to_adjacent_frames(limb.swivel.angle, start, stop))
    if median(limb.swivel.height[start:stop]) < BENT:
        level = float(limb.departures[start])
    flip = replace(
        new_constant_offset_interval(limb.limb.name, start, stop, level), kind=Kind.LIMB_FLIP
    )
    return replace(flip, carried=limb.end_carried(start, flip.offset))


def propose_error_at_jump(
    search: KindSearch, jump: Interval, others: Iterable[Interval]
) -> Interval | None:
    """Suggest an error that begins or ends at a jump of a joint, or return None.

    `jump` is a lone jump or a joint jump. The error is a stretch if the joint stays rotated about
    its bone, and a spike if the joint soon returns. `others` are the other intervals of the clip.
    Raises TwistError if the clip does not have the jump's joint.
    """
    joint = interval_joint_index(search.motion.skeleton, jump)
    return _stretch_at(search, joint, jump, others) or _spike_at(search.motion, joint, jump)


def _stretch_at(
    search: KindSearch, joint: int, jump: Interval, others: Iterable[Interval]
) -> Interval | None:
    """Return the stretch that begins or ends at a jump, or None.

    In a stretch, the joint stays rotated about its bone. If the detector finds a stretch at the
    jump, it is returned. If not, two spans are compared: from the previous jump of the joint (or
    the clip's start) to this jump, and from this jump to the next jump (or the clip's end). The
    stretch is the span in which the roll deviates more from the joint's usual roll. If the usual
    roll is unknown, it is the shorter span.

    The result is None if the roll deviates by less than half of the jump in both spans, or if
    rotating the joint back about its bone removes less than half of a joint jump.
    """
    for found in (i for own in find_stretches(search).values() for i in own):
        if found.joint == jump.joint and jump.start in (found.start, found.stop):
            return found.for_review
    same = (i.start for i in others if i.kind in _JUMPS and i.joint == jump.joint)
    edges = sorted({0, search.motion.frames, jump.start, *same})
    at = edges.index(jump.start)
    spans = list(pairwise(edges[max(at - 1, 0) : at + 2]))
    off = roll_deviation(search, joint, (spans[0][0], spans[-1][1]))
    if off is None:
        if jump.kind != Kind.LONE_JUMP:
            return None
        span = min(reversed(spans), key=lambda span: span[1] - span[0])
        turn = jump.residual if span[0] == jump.start else -jump.residual
        return wrongly_rolled_joint_interval(search, jump.chain, joint, span, turn)
    levels = {span: off[slice(*span)] for span in spans}
    turns = {span: circular_median(own[np.isfinite(own)]) for span, own in levels.items()}
    span, turn = max(turns.items(), key=lambda item: abs(item[1]))
    if abs(turn) < 0.5 * abs(jump.residual):
        return None
    made = wrongly_rolled_joint_interval(search, jump.chain, joint, span, turn)
    removed = jump.kind == Kind.LONE_JUMP or _removes(search, made, jump)
    return made if removed else None


def _removes(search: KindSearch, stretch: Interval, jump: Interval) -> bool:
    """Return True if the correction of a stretch removes at least half of a jump."""
    joint, first, stop = (
        interval_joint_index(search.motion.skeleton, stretch),
        jump.start - 1,
        jump.start + 1,
    )
    before = (search.corrected() or search.motion.sliced)(first, stop)
    after = remove_joint_roll(before, [stretch.within(first, stop)])
    turn, left = (float(geodesic_angle(*m.rotations[:, joint])) for m in (before, after))
    return left <= 0.5 * turn


def _spike_at(motion: Motion, joint: int, jump: Interval) -> Interval | None:
    """Return the spike that begins or ends at a jump, or None.

    In a spike, the joint returns within 0.2 s.
    """
    own, at = motion.rotations[:, joint], jump.start
    longest = max(3, round(_SOON * motion.fps))
    size = float(geodesic_angle(own[at - 1], own[at]))
    ends = ((at, t) for t in range(at + 1, min(at + longest + 1, motion.frames)))
    starts = ((t, at) for t in range(max(at - longest, 1), at))
    for start, stop in sorted([*ends, *starts], key=lambda span: span[1] - span[0]):
        other = stop if start == at else start
        jumps = geodesic_angle(own[other - 1], own[other]) >= 0.5 * size
        if jumps and geodesic_angle(own[start - 1], own[stop]) <= _BACK * size:
            way = slerp(own[start - 1], own[stop], 0.5)
            off = float(geodesic_angle(own[(start + stop) // 2], way))
            return replace(
                new_constant_offset_interval(jump.chain, start, stop, off),
                open=True,
                residual=off,
                kind=Kind.SPIKE,
                carried=True,
                joint=jump.joint,
            )
    return None


def _both_edges(start: int, stop: int, frame: int, frames: int, fps: float) -> tuple[int, int]:
    """Return the edges of a proposed interval, after replacing missing edges (−1).

    A missing edge is placed 0.1 s from the other edge. If both are missing, the interval is placed
    around the frame.
    """
    half = max(1, round(_HALF * fps))
    if start < 0:
        start = max(0, (stop if stop >= 0 else frame + half + 1) - 2 * half - 1)
        start = min(start, frame)
    if stop < 0:
        stop = min(frames, max(frame + 1, start + 2 * half + 1))
    return start, stop


def _strongest(strength: Array, first: int, last: int) -> int:
    if last <= first:
        return -1
    at = first + int(np.argmax(strength[first:last]))
    return at if strength[at] >= _FAINT else -1
