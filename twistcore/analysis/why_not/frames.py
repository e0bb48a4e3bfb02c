"""Explain why there is no interval at a frame of a chain or limb."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from twistcore.analysis.clip_analysis import REPAIRED, Detection
from twistcore.analysis.why_not.counter_twist import why_no_counter_twist
from twistcore.analysis.why_not.given_up import BESIDE
from twistcore.analysis.why_not.limb_flip import why_no_limb_flip
from twistcore.analysis.why_not.reason import (
    AskedFrame,
    EdgesIn,
    Reason,
    Why,
    format_distinct_degrees,
    format_signed_degrees,
)
from twistcore.detection import Interval, Kind
from twistcore.detection.consistency.chain_analysis import ConsistencyAnalysis
from twistcore.detection.consistency.notated import NotatedAnalysis
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.skeleton.signals import TwistSignals

# A soft error explains a strength if it changes by at least this share of the strength.
_ENOUGH = 0.5


def why_frame_bounds_no_interval(
    found: Detection, name: str, frame: int, *, first: int = 0
) -> Reason:
    """Return the reason why no interval begins or ends at a frame of a chain or limb.

    Parameters
    ----------
    found
        A detection or a review, with its intervals and τ.
    name
        Name of the chain or limb.
    frame
        The frame, counted from 0.
    first
        Frame number that is shown for the clip's first frame.

    Raises
    ------
    TwistError
        If the clip has no chain or limb of this name.
    """
    clip = found.analysis
    chain, tau = clip.chain(name), found.tau[name]
    detector = clip.detector(found.method)
    names = clip.motion.skeleton.names
    joints = names[chain.parent], names[chain.child]
    strength = float(detector.strength(name)[frame])
    place = AskedFrame(chain, joints, frame, strength, tau, clip.motion.fps, first)
    if (own := _at(found, name, frame)) is not None:
        return _in_interval(place, own)
    for interval in clip.detector(found.method, REPAIRED).intervals(name, tau):
        if _covers(interval, frame):
            text = (
                f"{place.named(interval)} was found here, but it was left out or moved in "
                "the review"
            )
            return place.reason(Why.MOVED, text)
    near = partial(_edges_near, found, chain, strength)
    if isinstance(chain, Limb):
        return why_no_limb_flip(place, clip.flips.limbs[name], near)
    if isinstance(chain, Helper):
        return _no_helper_roll(place, float(clip.helper_rolls.own[name][frame]))
    analysis = clip.by(found.method)
    if isinstance(analysis, NotatedAnalysis):
        return _in_notation(place, analysis, near, clip.chains)
    if isinstance(analysis, ConsistencyAnalysis):
        return why_no_counter_twist(place, analysis, near, clip.chains)
    return _no_event(place, clip.signals[name])


def _no_event(place: AskedFrame, signals: TwistSignals) -> Reason:
    """Return the reason why the paper's detector finds no event at a frame.

    Every event of this detector begins an interval.
    """
    p, c = float(signals.dtheta_p[place.frame]), float(signals.dtheta_c[place.frame])
    parent, child = place.joints
    numbers = {"dtheta_p_deg": math.degrees(p), "dtheta_c_deg": math.degrees(c)}
    turns = (
        f"{parent} twists by {format_signed_degrees(p)}, and the azimuth of {child} changes by "
        f"{format_signed_degrees(c)}"
    )
    if place.strength >= place.tau:  # in a review, intervals may differ from the detector's
        return place.reason(
            Why.NO_PARTNER, (f"the review no longer has an interval here: {turns}"), **numbers
        )
    if p * c < 0.0:
        return place.reason(Why.BELOW, turns, **numbers)
    alike = "but not in opposite directions"
    return place.reason(Why.BELOW, f"{turns}, {alike}", **numbers)


def _no_helper_roll(place: AskedFrame, own: float) -> Reason:
    """Return the reason why no helper roll begins or ends at a frame.

    `own` is the angle by which the helper alone rotates in this frame, radians.
    """
    helper, driver = place.joints
    if place.strength < place.tau:
        return place.reason(Why.BELOW, f"{helper} does not turn suddenly about its bone")
    if own == 0.0:
        because = f"{driver}, or the joint above {driver} and {helper}, also turns there"
        return place.reason(Why.IMAGE, because)
    return place.reason(Why.NO_PARTNER, f"no later jump of {helper} reverses it")


def _in_notation(
    place: AskedFrame, analysis: NotatedAnalysis, near: EdgesIn, chains: Sequence[Chain]
) -> Reason:
    """Return the reason for a frame of a clip with repeated or interpolated frames.

    The reason comes from the clip's distinct frames or, if these show nothing, from all frames.
    """
    kept, frame = analysis.kept, place.frame
    at = kept.of(frame)
    if analysis.fine is not None:
        by_key = analysis.coarse.strength(place.chain.name)[at] if kept.end(at) == frame else 0.0
        if by_key < place.strength or not by_key:
            return why_no_counter_twist(place, analysis.fine, near, chains)
    elif kept.end(at) != frame:
        because = f"it is a copy of {place.called(kept.end(at))}"
        return place.reason(Why.MOTION if place.strength >= place.tau else Why.BELOW, because)

    def near_kept(start: int, stop: int) -> list[tuple[Interval, Chain]]:
        found = near(kept.begin(start), kept.end(stop - 1) + 1)
        return [
            (replace(i, start=kept.of(i.start), stop=kept.of(i.stop - 1) + 1), c) for i, c in found
        ]

    counted = replace(place, frame=at, fps=kept.motion.fps, kept=kept)
    own = [c.at(kept.first) for c in chains]
    return why_no_counter_twist(counted, analysis.coarse, near_kept, own)


def why_peaks_lack_interval(found: Detection, name: str, *, first: int = 0) -> list[Reason]:
    """Return the reason for each of the :func:`peaks_above_tau_outside_intervals` of a chain or
    limb.

    `first` is the frame number that is shown for the clip's first frame.
    """
    return [
        why_frame_bounds_no_interval(found, name, t, first=first)
        for t in peaks_above_tau_outside_intervals(found, name)
    ]


def peaks_above_tau_outside_intervals(found: Detection, name: str) -> list[int]:
    """Return the frames of the peaks above τ outside intervals and their edges.

    A peak is the frame with the highest strength in a run of frames at or above τ, or the first of
    several equally high frames.
    """
    strength = found.analysis.detector(found.method).strength(name)
    past = np.concatenate([[False], strength >= found.tau[name], [False]])
    borders = np.flatnonzero(past[1:] != past[:-1]).reshape(-1, 2)
    peaks = [a + int(np.argmax(strength[a:b])) for a, b in borders.tolist()]
    # Comparing each peak with each interval would take quadratic time.
    covered = np.zeros(len(strength), dtype=np.bool_)
    for i in found:
        if i.chain == name:
            covered[max(0, i.start - BESIDE) : i.stop + BESIDE + 1] = True
    return [t for t in peaks if not covered[t]]


def _covers(interval: Interval, frame: int) -> bool:
    return interval.start - BESIDE <= frame <= interval.stop + BESIDE


def _at(found: Detection, name: str, frame: int) -> Interval | None:
    """Return the shortest interval of a chain or limb at a frame or next to it, or None."""
    there = [i for i in found if i.chain == name and _covers(i, frame)]
    return min(there, key=lambda i: (not i.start <= frame < i.stop, i.frames), default=None)


def _in_interval(place: AskedFrame, interval: Interval) -> Reason:
    lone = not interval.repairable
    strength, tau = place.strength, place.tau
    reason = place.reason(Why.INTERVAL, "", start=interval.start, stop=interval.stop)
    here, past = reason.text.partition(" is ")[0], strength >= tau
    if interval.start <= place.frame < interval.stop:
        frames = place.span(interval.start, interval.stop).partition(" ")[2]
        called = place.called(place.frame).capitalize()
        size = format_signed_degrees(interval.shown)
        told = {"frames": frames, "size": size, "joint": interval.joint}
        what = interval.kind.info.here.format(**told)
        shown, _ = format_distinct_degrees(strength, tau)
        side = f"The strength is {shown}, above τ" if past else f"The strength is {shown}, below τ"
        text = f"{called} is in an interval: {what}. {side}."
    else:
        side = f"{here}, above τ" if past else f"{here}, below τ"
        named = place.named(interval)
        text = f"{side}, is next to {named}." if lone else f"{side}, is at an edge of {named}."
    return Reason(place.chain.name, place.frame, Why.INTERVAL, strength, tau, text, reason.numbers)


def _edges_near(
    found: Detection, chain: Chain, strength: float, start: int, stop: int
) -> list[tuple[Interval, Chain]]:
    """Return the intervals of other chains that rotate joints of `chain` near [start, stop).

    An interval must have an edge in or next to these frames. A gradual error is also included if
    its offset changes enough there to explain the strength.
    """
    others = {c.name: c for c in found.chains_and_limbs if c.name != chain.name}
    skeleton = found.analysis.motion.skeleton
    own = {skeleton.names[j] for j in _turned(chain)}
    near = []
    for i in found:
        other = others.get(i.chain)
        at = any(start - BESIDE <= edge < stop + BESIDE for edge in (i.start, i.stop))
        at |= i.soft_ended and _change(i, start, stop) >= _ENOUGH * strength
        if other is not None and not i.kind.of_capture and at and own & _wrong(i, other, skeleton):
            near.append((i, other))
    # Lone jumps come last, because they explain least.
    return sorted(near, key=lambda pair: pair[0].kind == Kind.LONE_JUMP)


def _change(interval: Interval, start: int, stop: int) -> float:
    """Return how much an interval's offset changes in or next to frames [start, stop), radians."""
    low, high = (min(max(t - interval.start, 0), interval.frames) for t in (start - 2, stop + 1))
    return float(np.ptp(interval.offset[low:high])) if low < high else 0.0


def _wrong(interval: Interval, chain: Chain, skeleton: Skeleton) -> set[str]:
    """Return the names of the joints whose rotation is wrong in an interval of a chain or limb."""
    if not interval.repairable:
        return {interval.joint}
    joints = chain.changed_joints(skeleton) if isinstance(chain, Limb) else _turned(chain)
    return {skeleton.names[j] for j in joints}


def _turned(chain: Chain) -> tuple[int, ...]:
    """Return the joints of a chain or limb whose rotation reveals an error."""
    if isinstance(chain, Limb):
        return chain.parent, chain.child, chain.end
    return chain.parent, chain.child
