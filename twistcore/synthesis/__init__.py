"""Twist errors put into a clip on purpose, seeded, with their truth [Choi26 §4.1]."""

from twistcore.synthesis.injection import (
    InjectedError,
    apart,
    draw_errors,
    draw_targets,
    generator,
    inject,
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
    "apart",
    "draw_errors",
    "draw_targets",
    "enrich",
    "generator",
    "inject",
    "parse_protocol",
    "prepare",
    "read_truth",
    "write_truth",
]
