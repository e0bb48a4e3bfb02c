"""Estimate from all evidence the probability that the correction of a counter-twist is right."""

from twistcore.detection.evidence.chain_signals import ChainSignals
from twistcore.detection.evidence.judgement import (
    Judgement,
    judgement_of,
    lacks_rotation_at_error_edges,
)
from twistcore.detection.evidence.terms import (
    Background,
    SuspectedError,
    Terms,
    measure_evidence,
    usual_bend_side,
)

__all__ = [
    "Background",
    "ChainSignals",
    "Judgement",
    "SuspectedError",
    "Terms",
    "judgement_of",
    "lacks_rotation_at_error_edges",
    "measure_evidence",
    "usual_bend_side",
]
