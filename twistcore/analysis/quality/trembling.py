"""Distinguish a figure that trembles from one that moves fast."""

from __future__ import annotations

import numpy as np

from twistcore.analysis.quality.figure import measure_body_motion_quality
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.quamo.resample import network_sample_times
from twistcore.skeleton.motion import Motion, forward_kinematics
from twistcore.skeleton.rotation import vector_lengths

CAPTURED = 9.0  # mm/frame³; usual jitter of captures (62 clips of CMU, Daz and ACCAD)
TIMES = 3.0
_SWINGS = -0.6  # maximum correlation of consecutive third differences; −0.75 for white noise
_TALL_MM = 1750.0
_FEWEST = 25  # minimum number of samples, which is one second


def jitter_if_trembling(motion: Motion) -> float | None:
    """Return the figure's jitter in mm/frame³ at 25 Hz if the figure trembles, or None.

    A figure trembles if its jitter is at least TIMES the usual jitter of captures. Fast but smooth
    motion, such as running, does not count, because its third differences do not change sign from
    frame to frame. If the length unit is unknown, the figure is assumed to be 1.75 m tall.
    """
    capture = motion.sliced(count_leading_rest_frames(motion), motion.frames)
    times = network_sample_times(capture.frames, capture.frame_time)
    if len(times) < _FEWEST or not capture.skeleton.height:
        return None
    low = np.floor(times).astype(np.intp)
    high = np.minimum(low + 1, capture.frames - 1)
    below, above = (forward_kinematics(capture.at(k))[1] for k in (low, high))
    places = below + (times - low)[:, None, None] * (above - below)
    third = np.diff(places, n=3, axis=0) * (_TALL_MM / capture.skeleton.height)
    size = vector_lengths(third)
    total = float((third**2).sum())
    if total == 0.0 or float(np.median(size.mean(axis=1))) < TIMES * CAPTURED:
        return None
    if float((third[1:] * third[:-1]).sum()) > _SWINGS * total:
        return None
    measured = measure_body_motion_quality(capture)
    return measured.jitter if measured else float(size.mean())
