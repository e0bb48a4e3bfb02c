"""Explain why the consistency detector found no interval at a frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from twistcore.analysis.why_not.given_up import BESIDE, SoftErrors, soft_error_below_tau
from twistcore.analysis.why_not.reason import (
    AskedFrame,
    EdgesIn,
    Reason,
    Why,
    format_signed_degrees,
    format_unsigned_degrees,
)
from twistcore.detection import Interval
from twistcore.detection.consistency.chain_analysis import ChainAnalysis, ConsistencyAnalysis
from twistcore.detection.counter_twist.counter_rotation import AGREE_SHARE, SIGNIFICANT
from twistcore.detection.counter_twist.edges import Edges
from twistcore.detection.counter_twist.pairing import OPEN_GAIN, PRIOR, PairTable
from twistcore.detection.prediction import Mask
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import wrap

ONE_JOINT = 0.25  # share of the larger rotation; a joint that rotates less counts as still
# Multiple of σ. If increment and residual differ by more, the effect of another error was removed.
UNDONE = 4.0
_NEAR = 4  # number of frames on either side that show how much a joint usually rotates
_EACH = 0.5 * PRIOR  # minimum evidence of each of two edges, in nats


@dataclass(frozen=True)
class _Edge:
    """An edge of a chain, where an error may begin or end.

    Attributes
    ----------
    table
        The table of edges from which the edge comes.
    index
        Index of the edge in the table.
    start, stop
        Frames [start, stop) of the edge.
    jump, sigma
        Jump of the twist, and its standard deviation σ, radians.
    gain
        Evidence for the edge, nats.
    x, y
        Rotations of the chain's parent and child minus the predicted motion, radians.
    """

    table: PairTable
    index: int
    start: int
    stop: int
    jump: float
    sigma: float
    gain: float
    x: float
    y: float


def why_no_counter_twist(
    place: AskedFrame,
    analysis: ConsistencyAnalysis,
    edges_in: EdgesIn,
    chains: Sequence[Chain],
) -> Reason:
    """Return the reason why no interval begins or ends at a frame.

    Parameters
    ----------
    place
        The frame.
    analysis
        The analysis of all chains.
    edges_in
        Function that returns the errors of other chains and limbs with an edge in given frames.
    chains
        All chains that were analysed.
    """
    t, own = place.frame, analysis.chains[place.chain.name]
    if analysis.cut[t]:
        return place.reason(Why.CUT, _describe_cut(place, analysis.cut))
    table = next((p for p in own.tables if p.low < t < p.high), None)
    if table is None:
        low = int(np.flatnonzero(analysis.cut[:t])[-1])
        later = np.flatnonzero(analysis.cut[t:])
        high = t + int(later[0]) if len(later) else len(analysis.cut)
        because = f"{place.span(low, high)} between cuts are not enough to tell errors from motion"
        return place.reason(Why.SHORT, because, start=low, stop=high)
    if place.strength < place.tau:
        return soft_error_below_tau(place, own) or _below(
            place, analysis, edges_in(t, t + 1), chains
        )
    for interval in analysis.taken_for_motion(place.chain.name, place.tau):
        if interval.start - BESIDE <= t <= interval.stop + BESIDE:
            return _motion(place, interval)
    edge = _edge_at(place, own, table)
    if near := edges_in(edge.start, edge.stop) if edge else edges_in(t, t + 1):
        return _other_error(place, near, edge)
    soft = SoftErrors(place, analysis, chains)
    given = soft.with_edge_in(edge.start, edge.stop) if edge else soft.with_edge_in(t, t + 1)
    if given is not None:
        return soft.better_explanation(given, _numbers(edge) if edge else {})
    if edge is None:
        return _run_below_tau(place, own)
    return _single(place, edge) or _unpaired(place, own, edge, soft)


def _motion(place: AskedFrame, interval: Interval) -> Reason:
    """Return the reason for an interval that the evidence classifies as natural motion."""
    told = interval.evidence or {}
    why = "; ".join(told.get("doubts", ()))
    frames = place.span(interval.start, interval.stop)
    because = (
        f"the evidence as a whole shows that {format_signed_degrees(interval.shown)} in {frames} "
        "is motion"
    )
    return place.reason(
        Why.MOTION,
        f"{because}: {why}" if why else because,
        start=interval.start,
        stop=interval.stop,
        evidence=told.get("evidence"),
    )


def _describe_cut(place: AskedFrame, cut: Mask) -> str:
    """Describe the cut or transition to which a frame belongs."""
    t = place.frame
    low, high = t, t + 1
    while low and cut[low - 1]:
        low -= 1
    while high < len(cut) and cut[high]:
        high += 1
    if high - low > 1:
        return (
            f"{place.span(low, high)} are a cut or a transition to or from a rest pose, not motion"
        )
    if t == 0:
        return "it is the first frame, so no motion leads into it"
    return "the whole body jumps there, as at a cut, so no motion leads into it"


# --- below τ --------------------------------------------------------------------------------------


def _below(
    place: AskedFrame,
    analysis: ConsistencyAnalysis,
    near: Sequence[tuple[Interval, Chain]],
    chains: Sequence[Chain],
) -> Reason:
    """Return the reason for a frame below τ, where a single joint may rotate by more than τ."""
    own, t = analysis.chains[place.chain.name], place.frame
    c, row = own.limb, own.row
    rx, ry = float(c.rx[row, t]), float(c.ry[row, t])
    sigma_x, sigma_y = float(c.sigma_x[row, t]), float(c.sigma_y[row, t])
    x, y = float(c.x[row, t]), float(c.y[row, t])
    numbers = _degrees(x=x, y=y, residual_x=rx, residual_y=ry, sigma_x=sigma_x, sigma_y=sigma_y)
    of, error = _explained_joint(own, t, place.tau), _error_nearby(place, analysis, near, chains)
    if of and error:
        because = f"{place.joints[of - 1]} only seems to turn, because of {error}"
        return place.reason(Why.IMAGE, because, **numbers)
    beyond = _turns(place, rx, ry)
    most, least = max(abs(rx), abs(ry)), min(abs(rx), abs(ry))
    if most >= place.tau and least <= ONE_JOINT * most:
        return place.reason(Why.ONE_JOINT, f"only one joint turns there ({beyond})", **numbers)
    if most >= place.tau and not c.event[row, t] and abs(wrap(rx + ry)) > AGREE_SHARE * most:
        return place.reason(Why.UNEQUAL, f"the turns do not cancel out ({beyond})", **numbers)
    if min(abs(x), abs(y)) >= place.tau and x * y < 0.0:
        because = (
            f"{_turns(place, x, y)}, but natural motion predicts these changes to within "
            f"{format_signed_degrees(rx)} and {format_signed_degrees(ry)} "
            f"(σ {format_unsigned_degrees(sigma_x)} and {format_unsigned_degrees(sigma_y)})"
        )
        return place.reason(Why.MOTION, because, **numbers)
    return place.reason(Why.BELOW, f"{beyond} beyond what the motion explains", **numbers)


def _error_nearby(
    place: AskedFrame,
    analysis: ConsistencyAnalysis,
    near: Sequence[tuple[Interval, Chain]],
    chains: Sequence[Chain],
) -> str:
    """Describe an error of another chain that rotates a joint of this chain at the frame, or ''."""
    if near:
        interval, other = near[0]
        return place.error(interval, other)
    joints = {place.chain.parent, place.chain.child}
    jumps = {}
    for chain in chains:
        if chain.name != place.chain.name and joints & {chain.parent, chain.child}:
            c, row = analysis.chains[chain.name].limb, analysis.chains[chain.name].row
            jump, sigma = float(c.d[row, place.frame]), float(c.sigma[row, place.frame])
            if abs(jump) > SIGNIFICANT * sigma:
                jumps[chain.label] = jump
    if not jumps:
        return ""
    label = max(jumps, key=lambda name: abs(jumps[name]))
    return f"the jump of {label} there ({format_signed_degrees(jumps[label])})"


def _explained_joint(own: ChainAnalysis, t: int, tau: float) -> int:
    """Return the joint whose rotation is ignored because another chain's error explains it.

    The result is 1 for the chain's parent, 2 for its child, and 0 for neither.
    """
    c, row = own.limb, own.row
    around = slice(max(t - _NEAR, 1), t + _NEAR + 1)
    for joint, (v, r, s) in enumerate(
        ((c.x[row], c.rx[row], c.sigma_x[row]), (c.y[row], c.ry[row], c.sigma_y[row])), start=1
    ):
        captured = float(wrap(v[t] - median(v[around])))
        undone = abs(float(wrap(captured - r[t])))
        if abs(captured) >= tau and undone > max(UNDONE * s[t], 0.5 * abs(captured)):
            return joint
    return 0


# --- above τ --------------------------------------------------------------------------------------


def _edge_at(place: AskedFrame, own: ChainAnalysis, table: PairTable) -> _Edge | None:
    """Return the edge above τ that covers the frame, or None.

    If there are several, the edge whose peak is at this frame is preferred, and then the edge with
    the most evidence.
    """
    e, t = table.edges, place.frame
    at = np.flatnonzero((e.start <= t) & (t < e.stop) & (np.abs(e.jump) >= place.tau))
    if not len(at):
        return None
    shown = (e.peak[at] == t) & (np.abs(np.abs(e.jump[at]) - place.strength) < 1e-9)
    k = int(at[np.lexsort((-e.gain[at], ~shown))[0]])
    span = slice(int(e.start[k]), int(e.stop[k]))
    c, row = own.limb, own.row
    x, y = (float(wrap(r[row, span].sum())) for r in (c.rx, c.ry))
    jump, sigma, gain = (float(v[k]) for v in (e.jump, e.sigma, e.gain))
    return _Edge(table, k, span.start, span.stop, jump, sigma, gain, x, y)


def _other_error(
    place: AskedFrame, near: Sequence[tuple[Interval, Chain]], edge: _Edge | None
) -> Reason:
    interval, other = near[0]
    because = f"it belongs to {place.error(interval, other)}"
    numbers = _numbers(edge) if edge else {}
    return place.reason(Why.IMAGE, because, of=interval.chain, **numbers)


def _run_below_tau(place: AskedFrame, own: ChainAnalysis) -> Reason:
    """Return the reason for a frame above τ in an edge whose total jump is below τ."""
    e, t = own.edges, place.frame
    at = np.flatnonzero((e.start <= t) & (t < e.stop))
    if not len(at):
        return place.reason(Why.MOTION, "it is not an edge of an error")
    k = int(at[np.argmax(np.abs(e.jump[at]))])
    span = place.span(int(e.start[k]), int(e.stop[k]))
    because = f"the changes in {span} add up to only {format_signed_degrees(float(e.jump[k]))}"
    return place.reason(Why.MOTION, because, jump_deg=math.degrees(e.jump[k]))


def _single(place: AskedFrame, edge: _Edge) -> Reason | None:
    """Return the reason for an edge that cannot belong to a counter-twist, or None.

    Such an edge has one joint that does not rotate, rotations that do not cancel, or evidence so
    weak that the rotations are regarded as natural motion.
    """
    turns = _turns(place, edge.x, edge.y)
    span = place.span(edge.start, edge.stop) if edge.stop - edge.start > 1 else ""
    sizes = abs(edge.x), abs(edge.y)
    numbers = _numbers(edge)
    if min(sizes) <= ONE_JOINT * max(sizes):
        only = place.joints[int(sizes[1] > sizes[0])]
        because = (
            f"only {only} turns over {span} ({turns}), so this is not a counter-twist"
            if span
            else f"only {only} turns there ({turns}), so this is not a counter-twist"
        )
        return place.reason(Why.ONE_JOINT, because, **numbers)
    if edge.gain >= _EACH:
        return None
    open_by = float(wrap(edge.x + edge.y))
    if abs(open_by) > AGREE_SHARE * max(sizes):
        alike = (
            "both joints turn the same way"
            if edge.x * edge.y > 0.0
            else "the turns do not cancel out"
        )
        alike = f"{alike} over {span}" if span else alike
        because = f"{alike} ({turns}; {format_signed_degrees(open_by)} remains)"
        return place.reason(Why.UNEQUAL, because, open_deg=math.degrees(open_by), **numbers)
    taken = "it is treated as motion"
    taken = f"{taken} over {span}" if span else taken
    because = (
        f"{taken} ({turns}): the jump is {abs(edge.jump) / edge.sigma:.1f} times σ = "
        f"{format_unsigned_degrees(edge.sigma, 2)} and its evidence is {edge.gain:.1f}, but an "
        "edge "
        f"requires {_EACH:.0f}"
    )
    return place.reason(Why.MOTION, because, **numbers)


def _unpaired(place: AskedFrame, own: ChainAnalysis, edge: _Edge, soft: SoftErrors) -> Reason:
    """Return the reason why a clear edge is not part of an interval.

    Either no edge at the other end of an error matches it, or the best match belongs to a different
    interval.
    """
    e, numbers = edge.table.edges, _numbers(edge)
    turns = _turns(place, edge.x, edge.y)
    passing = {k: g for k, g in edge.table.partners(edge.index).items() if _passes(place, e, k)}
    if passing:
        best = max(passing, key=lambda k: passing[k])
        first, last = sorted((edge.index, best), key=lambda k: int(e.start[k]))
        span = int(e.start[first]), int(e.stop[last])
        rivals = [i for i in own.intervals(place.tau) if i.start < span[1] and span[0] <= i.stop]
        partner = (
            f"its best partner, {format_signed_degrees(float(e.jump[best]))} at "
            f"{_peak(place, e, best)}"
        )
        if not rivals:
            given = (i for i in soft.dropped() if i.start < span[1] and span[0] <= i.stop)
            return soft.better_explanation(next(given, None), numbers, f"{partner},")
        named = " and ".join(place.named(i) for i in rivals)
        because = f"{partner}, is part of a better explanation: {named}"
        return place.reason(Why.OTHER, because, partner=int(e.peak[best]), **numbers)
    alone = (
        f"on its own, it is too uncertain (evidence {edge.gain:.0f}; {OPEN_GAIN:.0f} is needed)"
        if edge.gain < OPEN_GAIN
        else "on its own, it explains these frames less well than another detection"
    )
    back = wrap(e.jump + edge.jump)
    apart = (e.stop <= edge.start) | (e.start >= edge.stop)
    asked = np.flatnonzero((np.abs(e.jump) >= place.tau) & apart & (np.abs(back) < abs(edge.jump)))
    if not len(asked):
        because = f"no other jump above τ reverses it ({turns}); {alone}"
        return place.reason(Why.NO_PARTNER, because, **numbers)
    k = int(asked[np.lexsort((np.abs(e.peak[asked] - place.frame), np.abs(back[asked])))[0]])
    rest, away = float(back[k]), abs(int(e.peak[k]) - place.frame)
    partner = f"{format_signed_degrees(float(e.jump[k]))} at {_peak(place, e, k)}"
    if abs(rest) > ONE_JOINT * abs(edge.jump):
        left = format_signed_degrees(rest)
        because = (
            f"no other jump reverses it ({turns}): the closest, {partner}, leaves a "
            f"difference of {left}"
        )
    else:
        because = (
            f"the jump that best reverses it ({turns}) is {partner}: it leaves a difference of "
            f"{format_signed_degrees(rest)} and is {away} frames away, and the evidence of the "
            "two jumps "
            f"({edge.gain:.0f} and {float(e.gain[k]):.0f}) is too weak for an interval"
        )
    numbers |= {"partner": int(e.peak[k]), "open_deg": math.degrees(rest)}
    return place.reason(Why.NO_PARTNER, f"{because}; {alone}", **numbers)


def _passes(place: AskedFrame, edges: Edges, k: int) -> bool:
    return abs(float(edges.jump[k])) >= place.tau


def _peak(place: AskedFrame, edges: Edges, k: int) -> str:
    return place.called(int(edges.peak[k]))


def _turns(place: AskedFrame, x: float, y: float) -> str:
    """Describe the rotations `x` of the parent and `y` of the child, which are in radians."""
    parent, child = place.joints
    return f"{parent} {format_signed_degrees(x)}, {child} {format_signed_degrees(y)}"


def _numbers(edge: _Edge) -> dict[str, Any]:
    degrees = _degrees(jump=edge.jump, sigma=edge.sigma, residual_x=edge.x, residual_y=edge.y)
    return {"start": edge.start, "stop": edge.stop, "gain": edge.gain, **degrees}


def _degrees(**angles: float) -> dict[str, float]:
    return {f"{name}_deg": math.degrees(angle) for name, angle in angles.items()}
