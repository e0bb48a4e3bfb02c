"""Estimate the probability that the correction of a counter-twist is right from all evidence."""

from twistcore.detection.evidence.judgement import Judgement, judgement_of, unanswered
from twistcore.detection.evidence.terms import Background, Find, Terms, terms_of, usual_side
from twistcore.detection.evidence.witnesses import Witnesses

__all__ = [
    "Background",
    "Find",
    "Judgement",
    "Terms",
    "Witnesses",
    "judgement_of",
    "terms_of",
    "unanswered",
    "usual_side",
]
