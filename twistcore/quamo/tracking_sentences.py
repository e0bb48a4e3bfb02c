"""Describe in words how a clip was tracked or smoothed, and with what result."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.quamo.pieces import capture_start_frames_after
from twistcore.quamo.response import (
    describe_tracker_lag_and_overshoot,
    steady_tracking_lags,
    tracking_overshoots,
)
from twistcore.quamo.state_space import Gains
from twistcore.quamo.track_clip import TrackedMotion
from twistcore.quamo.tracker import (
    describe_diverging_tracker_passes,
    describe_frames,
    describe_joint_resets,
)
from twistcore.skeleton.motion import Motion

SPLINE_WAY = (
    "a spline needs the whole clip: every frame depends on later ones; no lag; motion faster than "
    "the cut-off is flattened"
)


def capture_cuts_as_text(motion: Motion, first: int) -> str:
    """Return text such as 'cuts at frames 120, 300–305' (305 excluded), or '' without cuts."""
    cut = np.zeros(motion.frames, dtype=np.bool_)
    cut[capture_start_frames_after(motion, first)] = True
    return f"cut{'' if cut.sum() == 1 else 's'} at {describe_frames(cut)}" if cut.any() else ""


def tracking_method_text(causal: bool, gains: Gains | None) -> str:
    """Return a short description of the tracker's direction and gains."""
    how = f"tracked {'causally' if causal else 'both ways'} with "
    if gains is None:
        return how + "learned gains"
    return how + f"hand-set gains, κP {gains.kp:.4g}, κD {gains.kd:.3g}, κA {gains.ka:g}"


def tracking_lag_sentence(causal: bool, gains: Gains | None, dt: float, *, place: bool) -> str:
    """Return a sentence about which frames tracking uses and how far the result lags behind.

    `dt` is the frame time in seconds. `place` is True if the position is tracked, too.
    """
    if not causal:
        return "tracking both ways needs the whole clip: every frame depends on later ones; no lag"
    if gains is None:
        return "causal: each frame waits 40 ms for the next sample at 25 Hz, and lags slightly more"
    words = "causal: no frame depends on a later one"
    what = ("a joint", "the position")[: 1 + place]
    for name, late, over in zip(
        what, steady_tracking_lags(gains, dt), tracking_overshoots(gains, dt), strict=False
    ):
        words += f"; {describe_tracker_lag_and_overshoot(name, late, over)}"
    return words


def lost_tracking_sentences(
    found: TrackedMotion, names: Sequence[str], *, causal: bool
) -> list[str]:
    """Return sentences about the frames in which the tracker did not follow its input."""
    apart = describe_diverging_tracker_passes(found.apart, names)
    return [
        *describe_joint_resets(found.snapped, names, causal=causal),
        *([apart] if apart else []),
    ]
