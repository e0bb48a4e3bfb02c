"""Estimate from all evidence the probability that the correction of a counter-twist is right."""

from twistcore.detection.evidence.chain_signals import ChainSignals
from twistcore.detection.evidence.judgement import Judgement, judgement_of, unanswered
from twistcore.detection.evidence.terms import (
    Background,
    SuspectedError,
    Terms,
    terms_of,
    usual_side,
)

__all__ = [
    "Background",
    "ChainSignals",
    "Judgement",
    "SuspectedError",
    "Terms",
    "judgement_of",
    "terms_of",
    "unanswered",
    "usual_side",
]
