"""Smooth only the noise bursts in a clip. All other frames remain unchanged.

In a burst, the rotations are replaced by a smoothing spline that continues the values and the
speeds of the good frames around it, so no border is visible.
"""

from __future__ import annotations

from collections.abc import Iterable

from twistcore.detection.noise_bursts import noise_bursts
from twistcore.quamo.pieces import frame_ranges_between_cuts
from twistcore.quamo.spline import default_spline_cutoff, rotations_smoothed_by_spline
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.runs import group_overlapping_spans
from twistcore.work.frozen import dataclass

_CUTOFF = 2.5  # Hz; lower than in a whole clip, because the noise of a burst is stronger
_APART = 0.3  # seconds; bursts that are closer than this are treated as one
_BORDER = 0.04  # seconds on either side of a burst that may contain undetected noise


@dataclass(frozen=True)
class NoisySpan:
    """Frames [start, stop) of a joint that should be smoothed."""

    joint: int
    start: int
    stop: int


def noise_burst_cutoff(dt: float) -> float:
    """Return the default cut-off in Hz for noise bursts, given the frame time `dt` in seconds."""
    return min(_CUTOFF, default_spline_cutoff(dt))


def noise_burst_spans_to_smooth(motion: Motion) -> tuple[NoisySpan, ...]:
    """Return the frames of each joint that should be smoothed, sorted by start.

    If noise bursts of several joints overlap or nearly overlap, the same frames are smoothed in all
    of these joints, because a detected burst is often a little too short in one of them.
    """
    border = max(1, round(_BORDER * motion.fps))
    found = []
    for group in group_overlapping_spans(noise_bursts(motion), round(_APART * motion.fps)):
        start = max(min(b.start for b in group) - border, 0)
        stop = min(max(b.stop for b in group) + border, motion.frames)
        found += [NoisySpan(joint, start, stop) for joint in sorted({b.joint for b in group})]
    return tuple(found)


def smooth_noise_burst_spans(
    motion: Motion, spans: Iterable[NoisySpan], cutoff: float | None = None, *, first: int = 0
) -> Motion:
    """Return the motion with smoothed rotations in the given spans.

    No other values change. A span is not smoothed across a cut or before the frame `first`.
    `cutoff` is the cut-off in Hz, by default the result of :func:`noise_burst_cutoff`. Raises
    TwistError if the cut-off does not fit the frame rate of the clip.
    """
    cutoff = noise_burst_cutoff(motion.frame_time) if cutoff is None else cutoff
    rotations = motion.rotations.copy()
    captures = frame_ranges_between_cuts(motion, first)
    for span in spans:
        for start, stop in captures:
            own = max(span.start, start) - start, min(span.stop, stop) - start
            if own[0] < own[1]:
                q = motion.rotations[start:stop, span.joint]
                made = rotations_smoothed_by_spline(q, cutoff, motion.frame_time, own)
                rotations[start:stop, span.joint] = made
    return motion.with_rotations(rotations)
