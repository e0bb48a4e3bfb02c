"""Compute the quantities of [Choi26 §3] for a single frame, as captured or with changes."""

from twistcore.analysis.decomposition.altered_frame import (
    WhatIf,
    motion_of_altered_frame,
    partial_rotation_at_stage,
)
from twistcore.analysis.decomposition.frame_correction import FrameCorrection, correct_frame
from twistcore.analysis.decomposition.frame_quantities import UNDEFINED, Decomposition, decompose
from twistcore.analysis.decomposition.rotation_forms import (
    LOCK,
    EulerChannels,
    euler_channels,
    twist_swing_factors,
    unwrapped_twist,
)

__all__ = [
    "LOCK",
    "UNDEFINED",
    "Decomposition",
    "EulerChannels",
    "FrameCorrection",
    "WhatIf",
    "correct_frame",
    "decompose",
    "euler_channels",
    "motion_of_altered_frame",
    "partial_rotation_at_stage",
    "twist_swing_factors",
    "unwrapped_twist",
]
