"""Smooth the joints chosen in a review with a spline, after the twist correction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twistcore.detection import Interval
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.errors import TwistError
from twistcore.files.document_values import shorten_foreign_message
from twistcore.quamo.bursts import (
    NoisySpan,
    noise_burst_cutoff,
    noise_burst_spans_to_smooth,
    smooth_noise_burst_spans,
)
from twistcore.quamo.spline import check_spline_cutoff
from twistcore.quamo.track_clip import (
    TrackedMotion,
    select_writable_joints,
    smooth_captures_with_spline,
)
from twistcore.quamo.tracking_settings import Tracking
from twistcore.skeleton.motion import Motion


def settings_to_smooth_noise_bursts(
    motion: Motion, interval: Interval, known: Tracking | None
) -> Tracking | None:
    """Return settings that smooth the noise bursts in an interval, in addition to those in `known`.

    All joints with noise in the interval's frames are smoothed, each only in the frames of its
    burst. `known` are the existing settings, if any. The result is None if the interval has no
    noise.
    """
    names, index = motion.skeleton.names, motion.skeleton.index
    able = set(select_writable_joints(motion.skeleton, None).tolist())
    bursts = {
        (span.joint, span.start, span.stop)
        for span in noise_burst_spans_to_smooth(motion)
        if span.joint in able and span.start < interval.stop and interval.start < span.stop
    }
    if not bursts:
        return None
    bursts |= {(index(name), start, stop) for name, start, stop in (known.bursts if known else ())}
    return Tracking(
        tuple(names[joint] for joint in sorted({joint for joint, _, _ in bursts})),
        causal=False,
        spline=True,
        cutoff=noise_burst_cutoff(motion.frame_time),
        bursts=tuple((names[joint], start, stop) for joint, start, stop in sorted(bursts)),
    )


def check_smoothing_fits_motion(motion: Motion, tracking: Tracking) -> None:
    """Raise TwistError if a motion cannot be smoothed with these settings."""
    check_spline_cutoff(tracking.cutoff, motion.frame_time)
    for name, start, stop in tracking.bursts:
        if stop > motion.frames:
            raise TwistError(
                f"expected frames up to {motion.frames}, found {start}–{stop} in a burst of "
                f"{shorten_foreign_message(name)}"
            )


def smoothed_motion(motion: Motion, joints: NDArray[np.int64], tracking: Tracking) -> TrackedMotion:
    """Return the motion smoothed by the spline.

    `joints` are the indices of the joints, which are ignored if the settings list bursts. The
    result contains no tracker steps.
    """
    first = count_leading_rest_frames(motion)
    if tracking.bursts:
        index = motion.skeleton.index
        spans = [NoisySpan(index(name), start, stop) for name, start, stop in tracking.bursts]
        made = smooth_noise_burst_spans(motion, spans, tracking.cutoff, first=first)
    else:
        made = smooth_captures_with_spline(
            motion, joints, tracking.cutoff, place=tracking.place, first=first
        )
    none = np.zeros(motion.rotations.shape[:2], dtype=np.bool_)
    return TrackedMotion(made, none, none, (), np.zeros(0), joints)
