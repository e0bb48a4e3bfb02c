"""Explain in a sentence, with the detector's numbers, why there is no interval at a frame.

Every peak above τ outside all intervals has a reason. Reasons are consistent with the strength
curve: 'below τ' is given only for a frame whose strength is below τ.
"""

from twistcore.analysis.why_not.frames import (
    peaks_above_tau_outside_intervals,
    why_frame_bounds_no_interval,
    why_peaks_lack_interval,
)
from twistcore.analysis.why_not.reason import Reason, Why

__all__ = [
    "Reason",
    "Why",
    "peaks_above_tau_outside_intervals",
    "why_frame_bounds_no_interval",
    "why_peaks_lack_interval",
]
