"""Explain why there is no interval at a frame, in one sentence with the detectors' own numbers.

Every peak above τ outside all intervals has a reason. No reason contradicts the curve: 'below τ' is
given only below τ.
"""

from twistcore.analysis.why_not.frames import peaks_without_interval, unexplained_peaks, why_not
from twistcore.analysis.why_not.reason import Reason, Why

__all__ = ["Reason", "Why", "peaks_without_interval", "unexplained_peaks", "why_not"]
