"""Explain why no limb flip begins or ends at a frame."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from twistcore.analysis.why_not.reason import (
    AskedFrame,
    EdgesIn,
    Reason,
    Why,
    format_signed_degrees,
    format_unsigned_degrees,
)
from twistcore.detection.limb_flips import LimbFlips
from twistcore.detection.limb_flips.explanation import LONGEST, NEVER_CLOSED
from twistcore.detection.limb_flips.jumps import Jump
from twistcore.skeleton.rotation import wrap


def why_no_limb_flip(place: AskedFrame, flips: LimbFlips, edges_in: EdgesIn) -> Reason:
    """Return the reason why no limb flip begins or ends at a frame.

    `edges_in` returns the errors of other chains and limbs that have an edge in given frames.
    """
    t = place.frame
    numbers: dict[str, Any] = {
        "turn_deg": math.degrees(flips.departures[t]),
        "scale_deg": math.degrees(_scale(flips, t)),
        "end_step": float(flips.steps_at(np.array([t]))[0]),
    }
    if t == 0 or not flips.capture[t]:
        because = (
            "it is the first frame, so no motion leads into it"
            if t == 0
            else (
                "many limbs jump there, or the frame belongs to a cut or a transition to "
                "another pose, so no motion leads into it"
            )
        )
        return place.reason(Why.CUT, because, **numbers)
    jumps = flips.jumps(place.tau)
    if place.strength < place.tau:
        return _below(place, flips, jumps, numbers)
    if near := edges_in(t, t + 1):
        interval, other = near[0]
        because = f"it belongs to {place.error(interval, other)}"
        return place.reason(Why.IMAGE, because, of=interval.chain, **numbers)
    jump = next(j for j in jumps if j.sharp and j.start == t)
    return _left(place, flips, jumps, jump, numbers)


def _scale(flips: LimbFlips, frame: int) -> float:
    return float(flips.scale_at(np.array([frame]))[0])


def _below(
    place: AskedFrame, flips: LimbFlips, jumps: Sequence[Jump], numbers: dict[str, Any]
) -> Reason:
    soft = [j for j in jumps if not j.sharp and j.start <= place.frame < j.stop]
    if soft:
        whole = max(soft, key=lambda j: abs(j.turn))
        because = (
            f"over {place.span(whole.start, whole.stop)}, the limb turns "
            f"{format_signed_degrees(whole.turn)} about its line, but no sharp jump nearby "
            "reverses this turn convincingly"
        )
        return place.reason(Why.BELOW, because, soft_deg=math.degrees(whole.turn), **numbers)
    because = (
        f"the limb turns {format_signed_degrees(float(flips.departures[place.frame]))} more about "
        f"its line than in nearby frames (σ {format_unsigned_degrees(_scale(flips, place.frame))})"
    )
    return place.reason(Why.BELOW, because, **numbers)


def _left(
    place: AskedFrame, flips: LimbFlips, jumps: Sequence[Jump], jump: Jump, numbers: dict[str, Any]
) -> Reason:
    """Return the reason why a jump above τ does not begin or end a flip.

    The reason includes the costs of explaining the frames with and without a flip.
    """
    left = flips.why_unexplained(jumps, jump)
    numbers = numbers | {"cost_left": left.cost}
    if left.run is None:
        return _no_partner(place, flips, jumps, jump, numbers)
    run = left.run
    span = place.span(run.start, run.stop)
    numbers |= {
        "start": run.start,
        "stop": run.stop,
        "cost_flip": left.price,
        "spares": left.spared,
    }
    if left.price < left.spared:
        because = (
            f"it could be an edge of a flip in {span}, but another flip explains the frames better"
        )
        return place.reason(Why.OTHER, because, **numbers)
    moves = (
        f"the limb's rotation varies by about {format_unsigned_degrees(jump.scale)} in nearby "
        "frames"
    )
    if jump.step > 0.03:
        moves = (
            f"{moves}, and the limb's end moves by {100.0 * jump.step:.0f} % of the limb's length"
        )
    because = (
        f"it is treated as motion: {moves}, and a flip in {span} with this edge explains the "
        f"frames less well (cost {left.price:.1f}) than no flip (cost {left.spared:.1f})"
    )
    return place.reason(Why.MOTION, because, **numbers)


def _no_partner(
    place: AskedFrame,
    flips: LimbFlips,
    jumps: Sequence[Jump],
    jump: Jump,
    numbers: dict[str, Any],
) -> Reason:
    """Return the reason for a jump without a matching second jump nearby to complete a flip."""
    reach = LONGEST * flips.fps
    others = [
        (abs(float(wrap(j.turn + jump.turn))), j)
        for j in jumps
        if j is not jump and max(j.start - jump.stop, jump.start - j.stop) <= reach
    ]
    if not others:
        because = f"no other jump within {LONGEST:.0f} s reverses it"
        return place.reason(Why.NO_PARTNER, because, **numbers)
    open_by, best = min(others, key=lambda o: o[0])
    because = (
        f"no other jump reverses it: the closest in size, {format_signed_degrees(best.turn)} at "
        f"{place.called(best.start)}, leaves a difference of {format_unsigned_degrees(open_by)}"
    )
    if open_by < NEVER_CLOSED:
        because = f"{because}, and no flip can occur between the two"
    return place.reason(Why.NO_PARTNER, because, open_deg=math.degrees(open_by), **numbers)
