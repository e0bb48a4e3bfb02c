"""Track a whole clip forward and backward in time. The result has no lag, but is not causal.

A joint that rotates steadily is 2κD/κP − Δt behind its reference in a forward pass, and equally far
ahead of it in a backward pass, from the end of the clip to its beginning. The result is therefore
computed halfway between the two passes:

    q(t) = (a + s b) / |a + s b|,  s = ±1 so that s a·b ≥ 0;   r(t) = ½ (r_a + r_b)

a and r_a are the rotation and the position at time t in the forward pass, which tracks the
reference q̂(0 … T). b and r_b are those of the backward pass, which tracks q̂(T … 0). Only the order
of the rotations is reversed, not the rotations themselves. The quotient is halfway along the
shorter arc, for either sign of the quaternions.

For small deviations, the frequency response of the result is the real part of the frequency
response H(f) of a single pass. Every frequency keeps its phase, the lag is 0, and the overshoot
after a step is halved. For small Δt, the overshoot would vanish with κD = √(2κP), but this distorts
slow motion, since Re H = 1 − O(f⁴) requires κD = √(κP/2). If the clip is reversed, the result is
reversed bit for bit, except for the signs of quaternions.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twistcore.quamo.state_space import EXACT, AccelerationTerms
from twistcore.quamo.tracker import LOST_COSINE, Controller, State, Step, TrackResult, track
from twistcore.skeleton.rotation import Array, normalise
from twistcore.work.progress import Tell

_FORWARDS, _BACKWARDS = 0, 1  # indices of the passes in arrays that contain both


def track_both_ways(
    q_hat: Array,
    r_hat: Array,
    dt: float,
    controller: Controller,
    *,
    integration: str = EXACT,
    keep_steps: bool = False,
    tell: Tell | None = None,
) -> TrackResult:
    """Track a clip in both directions of time, and return the motion halfway between the passes.

    The parameters are the same as for :func:`track`. Both passes are computed together, step by
    step.

    Returns
    -------
    TrackResult
        The quaternions are in the hemisphere of the forward pass. `snapped` is True for joints that
        were reset to the reference in either pass, and `apart` is True for joints whose rotations
        in the two passes differ by more than 90°. `steps` contains the steps of the forward pass,
        and `steps_back` the steps of the backward pass in the order of the frames. The first of
        `steps` and the last of `steps_back` are the initial states of the passes.
    """
    q_two, r_two = np.stack([q_hat, q_hat[::-1]], 1), np.stack([r_hat, r_hat[::-1]], 1)
    found = track(
        q_two,
        r_two,
        dt,
        controller.both_ways(q_two, r_two),
        integration=integration,
        keep_steps=keep_steps,
        tell=tell,
    )
    ahead, back = found.q[:, _FORWARDS], found.q[::-1, _BACKWARDS]
    return TrackResult(
        halfway_rotations(ahead, back),
        0.5 * (found.r[:, _FORWARDS] + found.r[::-1, _BACKWARDS]),
        found.snapped[:, _FORWARDS] | found.snapped[::-1, _BACKWARDS],
        tuple(_of_direction(step, _FORWARDS) for step in found.steps),
        tuple(_of_direction(step, _BACKWARDS) for step in reversed(found.steps)),
        np.abs(np.einsum("...i,...i->...", ahead, back)) < LOST_COSINE,
    )


def halfway_rotations(a: Array, b: Array) -> Array:
    """Return the rotations halfway from a to b, (…, 4), along the shorter arc.

    The resulting quaternions are in the hemisphere of a. If a and b are swapped, the result is the
    same bit for bit, except for the signs.
    """
    dot = np.einsum("...i,...i->...", a, b)
    return normalise(a + np.where(dot[..., None] < 0.0, -b, b))


def _of_direction(step: Step, way: int) -> Step:
    """Return the part of a combined step of both passes that belongs to the pass `way`, 0 or 1."""
    state = State(**{name: value[way] for name, value in vars(step.state).items()})
    if step.gains is None or step.parts is None:
        return Step(state, step.snapped[way])
    own = {
        name: np.broadcast_to(value, (step.state.r if "root" in name else step.state.omega).shape)
        for name, value in vars(step.gains).items()
        if name != "clip"
    }
    gains = replace(step.gains, **{name: value[way] for name, value in own.items()})
    parts = AccelerationTerms(**{name: value[way] for name, value in vars(step.parts).items()})
    return Step(state, step.snapped[way], gains, parts)
