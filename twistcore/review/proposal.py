"""Propose the frames and the offset of an interval that the user adds by hand."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from twistcore.analysis.correction.joint_repairs import joint_of
from twistcore.detection import Interval, Kind
from twistcore.detection.interval import circular_median
from twistcore.detection.limb_flips import BENT, LimbFlips
from twistcore.detection.stretches import OFF, defined_roll, goes_along, turn_at_jumps
from twistcore.review.model import constant, off_line
from twistcore.skeleton.medians import median
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, wrap
from twistcore.skeleton.signals import TwistSignals

_REACH = 0.5  # seconds before and after the frame in which edges are searched for
_HALF = 0.05  # seconds before and after the frame if there are no edges
_FAINT, _FAINT_FLIP = np.radians(1.0), np.radians(25.0)


def proposed_interval(chain: str, signals: TwistSignals, frame: int, fps: float) -> Interval:
    """Return an interval between the strongest counter-rotations before and after a frame.

    If there is no counter-rotation of 1° or more, the interval is 0.1 s long. Its offset is the
    level of θp inside, relative to the line between the frames before and after.
    """
    frames = len(signals.theta_p)
    reach = max(2, round(_REACH * fps))
    first, last = max(1, frame - reach), min(frames, frame + reach + 1)
    start = _strongest(signals.strength, first, frame + 1)
    stop = _strongest(signals.strength, max(frame, start) + 1, last)
    return interval_over(chain, signals, *_both_edges(start, stop, frame, frames, fps))


def interval_over(chain: str, signals: TwistSignals, start: int, stop: int) -> Interval:
    """Return an interval over [start, stop).

    The offset is the level of θp relative to the line between the neighbouring frames.
    """
    level = median(off_line(signals.theta_p, start, stop))
    return constant(chain, start, stop, level)


def proposed_flip(limb: LimbFlips, frame: int) -> Interval:
    """Return a flip of a limb around a frame, between the nearest jumps before and after it.

    If there is no jump of 25° or more within half a second, the interval is 0.1 s long. Its offset
    is the level of φ inside, relative to the line between the frames before and after. For a
    straight limb, the offset is the jump at the start.
    """
    jumps = np.flatnonzero(np.abs(limb.departures) >= _FAINT_FLIP)
    near = jumps[np.abs(jumps - frame) <= max(2, round(_REACH * limb.fps))]
    start = int(near[near <= frame].max(initial=-1))
    stop = int(near[near > frame].min(initial=len(limb.departures)))
    stop = stop if stop < len(limb.departures) else -1
    return flip_over(limb, *_both_edges(start, stop, frame, len(limb.departures), limb.fps))


def flip_over(limb: LimbFlips, start: int, stop: int) -> Interval:
    """Return a flip of a limb over [start, stop), with an offset as in `proposed_flip`."""
    level = circular_median(off_line(limb.swivel.angle, start, stop))
    if median(limb.swivel.height[start:stop]) < BENT:
        level = float(limb.departures[start])
    flip = replace(constant(limb.limb.name, start, stop, level), kind=Kind.LIMB_FLIP)
    return replace(flip, carried=limb.end_carried(start, flip.offset))


def proposed_stretch(motion: Motion, jump: Interval, others: Iterable[Interval]) -> Interval:
    """Return the stretch that a lone jump begins or ends, as a suggestion that is not confirmed.

    The stretch extends from the jump to the next or the previous lone jump of the joint, or to an
    end of the clip: on the side where the joint's roll is far from the rest of the clip or, if this
    is unclear, on the shorter side. `others` are the other intervals of the clip. Raises TwistError
    if the clip has no such joint.
    """
    joint, frames = joint_of(motion.skeleton, jump), motion.frames
    same = (i.start for i in others if (i.kind, i.joint) == (jump.kind, jump.joint))
    edges = sorted({0, frames, jump.start, *same})
    at = edges.index(jump.start)
    spans = [(jump.start, edges[at + 1], jump.residual)]
    if at:
        spans.append((edges[at - 1], jump.start, -jump.residual))
    off = _off_spans(motion, joint, [(start, stop) for start, stop, _ in spans])
    likely = [span for span in spans if span[:2] in off] if len(off) == 1 else spans
    start, stop, turn = min(likely, key=lambda span: span[1] - span[0])
    delta = turn_at_jumps(motion, joint, (start, stop), turn)
    return replace(
        constant(jump.chain, start, stop, delta),
        open=True,
        residual=turn,
        kind=Kind.STRETCH,
        carried=goes_along(motion, joint, (start, stop)),
        joint=jump.joint,
    )


def _off_spans(
    motion: Motion, joint: int, spans: Sequence[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Return the spans in which a joint's roll is far from its roll in the rest of the clip."""
    roll = defined_roll(motion, joint)
    rest = np.isfinite(roll)
    for start, stop in spans:
        rest[start:stop] = False
    levels = {(a, b): roll[a:b][np.isfinite(roll[a:b])] for a, b in spans}
    if not rest.any() or not all(map(len, levels.values())):
        return []
    usual = circular_median(roll[rest])
    return [at for at, own in levels.items() if abs(wrap(circular_median(own) - usual)) > OFF]


def _both_edges(start: int, stop: int, frame: int, frames: int, fps: float) -> tuple[int, int]:
    """Return the edges of a proposed interval, replacing missing ones (−1).

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
