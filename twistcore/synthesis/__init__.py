"""Inject random errors into a clip, and record them as ground truth [Choi26 §4.1]."""

from twistcore.synthesis.injection import (
    InjectedError,
    draw_errors,
    draw_targets,
    generator,
    independent_chains,
    inject,
    last_chains,
)
from twistcore.synthesis.protocol import (
    PROTOCOLS,
    Protocol,
    enrich,
    parse_protocol,
    prepare,
)
from twistcore.synthesis.truth import SUCCESS, Truth, read_truth, write_truth

__all__ = [
    "PROTOCOLS",
    "SUCCESS",
    "InjectedError",
    "Protocol",
    "Truth",
    "draw_errors",
    "draw_targets",
    "enrich",
    "generator",
    "independent_chains",
    "inject",
    "last_chains",
    "parse_protocol",
    "prepare",
    "read_truth",
    "write_truth",
]
