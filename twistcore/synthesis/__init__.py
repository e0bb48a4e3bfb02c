"""Inject random errors into a clip, and record them as ground truth [Choi26 §4.1]."""

from twistcore.synthesis.injection import (
    InjectedError,
    clip_random_generator,
    draw_errors,
    draw_targets,
    independent_chains,
    inject,
    last_limb_chains,
)
from twistcore.synthesis.protocol import (
    PROTOCOLS,
    Protocol,
    add_twist_from_opposite_side,
    parse_protocol,
    prepare_clean_motion_for_injection,
)
from twistcore.synthesis.truth import SUCCESS, Truth, read_truth, write_truth

__all__ = [
    "PROTOCOLS",
    "SUCCESS",
    "InjectedError",
    "Protocol",
    "Truth",
    "add_twist_from_opposite_side",
    "clip_random_generator",
    "draw_errors",
    "draw_targets",
    "independent_chains",
    "inject",
    "last_limb_chains",
    "parse_protocol",
    "prepare_clean_motion_for_injection",
    "read_truth",
    "write_truth",
]
