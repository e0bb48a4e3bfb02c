"""Detecting again in the open clip: at another τ, by another detector, or below τ."""

from __future__ import annotations

from collections.abc import Mapping

from twistcore.analysis import ClipAnalysis
from twistcore.detection import Analysis, Interval
from twistcore.review import Redetect, ReviewState


def at_tau(detector: Analysis, tau: Mapping[str, float], drag: int = 0) -> Redetect:
    """The command that detects anew in the chains named, at τ in radians."""
    found = tuple(i for name, t in tau.items() for i in detector.intervals(name, t))
    return Redetect(dict(tau), found, drag=drag)


def by_method(clip: ClipAnalysis, method: str, tau: Mapping[str, float]) -> Redetect:
    """The command that detects by another detector: at its own τ in chains that `tau` lacks."""
    found = clip.detect(method, tau_radians=tau)
    return Redetect(dict(found.tau), found.intervals, method=method)


def faint_intervals(clip: ClipAnalysis, state: ReviewState) -> list[Interval]:
    """What the detector finds between half of τ and τ, where the review has nothing."""
    detector, out = clip.by(state.method), []
    for chain in clip.chains:
        known = [(j.interval.start, j.interval.stop) for j in state.of_chain(chain.name)]
        candidates = detector.intervals(chain.name, 0.5 * state.tau[chain.name])
        out += [c for c in candidates if all(c.stop <= a or c.start >= b for a, b in known)]
    return out
