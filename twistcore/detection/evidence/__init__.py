"""How likely it is that the repair of a counter-twist is right, by all that the chain shows."""

from twistcore.detection.evidence.judgement import Judgement, judgement_of, unanswered
from twistcore.detection.evidence.terms import Find, Terms, taken_by, terms_of, usual_side
from twistcore.detection.evidence.witnesses import Witnesses

__all__ = [
    "Find",
    "Judgement",
    "Terms",
    "Witnesses",
    "judgement_of",
    "taken_by",
    "terms_of",
    "unanswered",
    "usual_side",
]
