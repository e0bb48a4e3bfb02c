"""Smooth only the bursts of noise in a clip, and leave every other frame as it is.

Within a burst, the rotations are replaced by the smoothing spline that continues the values and the
speeds of the good frames around it, so no border is visible.
"""

from __future__ import annotations

from collections.abc import Iterable

from twistcore.detection.noise_bursts import noise_bursts
from twistcore.detection.runs import overlapping
from twistcore.quamo.pieces import pieces
from twistcore.quamo.spline import smoothed_rotations, usual_cutoff
from twistcore.skeleton.motion import Motion
from twistcore.work.frozen import dataclass

_CUTOFF = 2.5  # Hz; lower than in a whole clip, because the noise of a burst is stronger
_APART = 0.3  # seconds between two bursts that are treated as one
_BORDER = 0.04  # seconds next to a burst in which there may be noise that was not found


@dataclass(frozen=True)
class NoisySpan:
    """A joint's frames [start, stop) to smooth."""

    joint: int
    start: int
    stop: int


def burst_cutoff(dt: float) -> float:
    """Return the default cut-off in bursts for a frame time, in Hz."""
    return min(_CUTOFF, usual_cutoff(dt))


def noisy_spans(motion: Motion) -> tuple[NoisySpan, ...]:
    """Return the frames of each joint to smooth, sorted by start.

    Bursts of several joints that overlap, or nearly do, have the same frames in all of these
    joints, since a burst is often found a little too short in one of them.
    """
    border = max(1, round(_BORDER * motion.fps))
    found = []
    for group in overlapping(noise_bursts(motion), round(_APART * motion.fps)):
        start = max(min(b.start for b in group) - border, 0)
        stop = min(max(b.stop for b in group) + border, motion.frames)
        found += [NoisySpan(joint, start, stop) for joint in sorted({b.joint for b in group})]
    return tuple(found)


def smooth_spans(
    motion: Motion, spans: Iterable[NoisySpan], cutoff: float | None = None, *, first: int = 0
) -> Motion:
    """Return the motion with the rotations in these spans smoothed.

    All other numbers keep their bits. Spans are not smoothed across a cut or before the frame
    `first`. `cutoff` is in Hz, by default :func:`burst_cutoff`. Raises TwistError if it does not
    fit the clip's frame rate.
    """
    cutoff = burst_cutoff(motion.frame_time) if cutoff is None else cutoff
    rotations = motion.rotations.copy()
    captures = pieces(motion, first)
    for span in spans:
        for start, stop in captures:
            own = max(span.start, start) - start, min(span.stop, stop) - start
            if own[0] < own[1]:
                q = motion.rotations[start:stop, span.joint]
                made = smoothed_rotations(q, cutoff, motion.frame_time, own)
                rotations[start:stop, span.joint] = made
    return motion.with_rotations(rotations)
