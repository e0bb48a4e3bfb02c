"""Frames of chains and limbs, each asked why nothing is found there."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from twistcore.analysis import Detection
from twistcore.chain import Chain
from twistcore.detection import Interval
from twistcore.detection.consistency import ConsistencyAnalysis
from twistcore.limb import Limb
from twistcore.rotation import Array
from twistcore.why_not.counter_twist import no_counter_twist
from twistcore.why_not.limb_flip import no_limb_flip
from twistcore.why_not.paper_event import no_event
from twistcore.why_not.reason import Place, Reason, Why

BESIDE = 1  # frames from an interval's edge: a jump there belongs to it


def why_not(found: Detection, name: str, frame: int, *, first: int = 0) -> Reason:
    """Why no interval has its edge at a frame of a chain or limb.

    found: the intervals that there are, such as a review's, with their τ; first: what people call
    the clip's first frame, for the sentence alone. TwistError for a name that the clip lacks.
    """
    clip = found.analysis
    chain, tau = clip.chain(name), found.tau[name]
    detector = clip.detector(found.method)
    names = clip.motion.skeleton.names
    joints = names[chain.parent], names[chain.child]
    strength = float(detector.strength(name)[frame])
    place = Place(chain, joints, frame, strength, tau, clip.motion.fps, first)
    if (own := _at(found, name, frame)) is not None:
        return _in_interval(place, own)
    for interval in detector.intervals(name, tau):
        if _covers(interval, frame):
            text = f"the detector's interval of {place.named(interval)} is elsewhere in the review"
            return place.reason(Why.MOVED, text)
    if isinstance(chain, Limb):
        return no_limb_flip(place, clip.flips.limbs[name], _edges_near(found, chain, frame))
    analysis = clip.by(found.method)
    if isinstance(analysis, ConsistencyAnalysis):
        return no_counter_twist(place, analysis, _edges_near(found, chain, frame), clip.chains)
    return no_event(place, clip.signals[name])


def peaks_without_interval(found: Detection, name: str, *, first: int = 0) -> list[Reason]:
    """Every peak of the strength that is past τ and neither in an interval nor at its edge.

    A peak is the highest frame, the first of equals, of a run of frames at τ and above.
    """
    strength = found.analysis.detector(found.method).strength(name)
    return [
        why_not(found, name, frame, first=first)
        for frame in _peaks(strength, found.tau[name])
        if _at(found, name, frame) is None
    ]


def _peaks(strength: Array, tau: float) -> Iterable[int]:
    past = np.concatenate([[False], strength >= tau, [False]])
    borders = np.flatnonzero(past[1:] != past[:-1]).reshape(-1, 2)
    return [start + int(np.argmax(strength[start:stop])) for start, stop in borders.tolist()]


def _covers(interval: Interval, frame: int) -> bool:
    return interval.start - BESIDE <= frame <= interval.stop + BESIDE


def _at(found: Detection, name: str, frame: int) -> Interval | None:
    """The interval of a chain or limb that a frame is in or beside, the shortest of several."""
    there = [i for i in found if i.chain == name and _covers(i, frame)]
    return min(there, key=lambda i: i.frames, default=None)


def _in_interval(place: Place, interval: Interval) -> Reason:
    inside = interval.start <= place.frame < interval.stop
    where = "in" if inside else "at an edge of"
    strength, tau = place.strength, place.tau
    reason = place.reason(Why.INTERVAL, "", start=interval.start, stop=interval.stop)
    text = reason.text.partition(" is ")[0]
    side = "above" if strength >= tau else "below"
    text = f"{text}, {side} τ, is {where} the interval of {place.named(interval)}."
    return Reason(place.chain.name, place.frame, Why.INTERVAL, strength, tau, text, reason.numbers)


def _edges_near(found: Detection, chain: Chain, frame: int) -> list[tuple[Interval, Chain]]:
    """Intervals of others that turn a joint of the chain and have an edge at the frame."""
    skeleton = found.analysis.motion.skeleton
    others = {c.name: c for c in found.chains_and_limbs if c.name != chain.name}
    own = set(_turned(chain))
    near = []
    for i in found:
        other = others.get(i.chain)
        if other is None or min(abs(frame - i.start), abs(frame - i.stop)) > BESIDE:
            continue
        ends = other.changed_joints(skeleton) if isinstance(other, Limb) else _turned(other)
        if own.intersection(ends):
            near.append((i, other))
    return near


def _turned(chain: Chain) -> tuple[int, ...]:
    """The joints whose turns tell of an error."""
    if isinstance(chain, Limb):
        return chain.parent, chain.child, chain.end
    return chain.parent, chain.child
