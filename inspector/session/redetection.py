"""Detecting again in the open clip: at another τ, by another detector, or below τ."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from inspector.session.opening import Analysed
from twistcore.detection import DETECTORS, Interval, resolve_tau
from twistcore.review import Redetect
from twistcore.tuning import Profile


def at_tau(data: Analysed, tau: Mapping[str, float], drag: int = 0) -> Redetect:
    """The command that detects anew in the chains named, at τ in radians."""
    found = tuple(i for name, t in tau.items() for i in data.analysis.intervals(name, t))
    return Redetect(dict(tau), found, drag=drag)


def by_method(data: Analysed, method: str, tau: Mapping[str, float]) -> Redetect:
    """The command that detects by another detector: at its own τ in chains that `tau` lacks."""
    analysis = DETECTORS[method].analyse(data.motion, data.chains)
    tau = resolve_tau(analysis, data.chains, tau)
    found = [i for name, t in tau.items() for i in analysis.intervals(name, t)]
    return Redetect(tau, tuple(found), method=method)


def by_profile(data: Analysed, profile: Profile) -> Redetect | None:
    """The command that detects by a profile: its τ, and its detector if it names one.

    None where it says nothing about the clip.
    """
    own = {n: t for n, t in profile.tau.items() if n in data.review.state.tau}
    if profile.method not in ("", data.review.state.method):
        return by_method(data, profile.method, own)
    return at_tau(data, own) if own else None


def as_reviewed(data: Analysed) -> Analysed:
    """The clip with the analysis by the detector that its review names.

    An undo may have gone back to another one: its curve belongs to its τ.
    """
    method = data.review.state.method
    if method == data.method:
        return data
    analysis = DETECTORS[method].analyse(data.motion, data.chains)
    return replace(data, analysis=analysis, method=method)


def faint_intervals(data: Analysed) -> list[Interval]:
    """What the detector finds between half of τ and τ, where the review has nothing."""
    state, out = data.review.state, []
    for chain in data.chains:
        known = [(j.interval.start, j.interval.stop) for j in state.of_chain(chain.name)]
        candidates = data.analysis.intervals(chain.name, 0.5 * state.tau[chain.name])
        out += [c for c in candidates if all(c.stop <= a or c.start >= b for a, b in known)]
    return out
