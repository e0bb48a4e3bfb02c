"""Compute the quantities of [Choi26 §3] for a single frame, as captured or with changes."""

from twistcore.analysis.decomposition.altered_frame import (
    WhatIf,
    frame_motion_with_user_changes,
    swing_then_twist_at_stage,
)
from twistcore.analysis.decomposition.frame_correction import (
    FrameCorrection,
    detect_and_correct_frame,
)
from twistcore.analysis.decomposition.frame_quantities import UNDEFINED, Decomposition, decompose
from twistcore.analysis.decomposition.rotation_forms import (
    LOCK,
    EulerChannels,
    decompose_into_euler_channels,
    double_cover_twist_angle,
    twist_times_swing_factors,
)

__all__ = [
    "LOCK",
    "UNDEFINED",
    "Decomposition",
    "EulerChannels",
    "FrameCorrection",
    "WhatIf",
    "decompose",
    "decompose_into_euler_channels",
    "detect_and_correct_frame",
    "double_cover_twist_angle",
    "frame_motion_with_user_changes",
    "swing_then_twist_at_stage",
    "twist_times_swing_factors",
]
