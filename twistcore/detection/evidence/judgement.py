"""Compute the probability that a correction is right, and express the doubts about it in words.

The probability is a logistic function of terms. The sign of each term follows from physics. The
weights were fitted to injected errors and to intervals in public captures that were judged one by
one (see `benchmarks.evidence`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from twistcore.detection.evidence.terms import BENT, Terms
from twistcore.work.frozen import dataclass

# The weight of each term of :func:`unweighted_evidence_scores`, in log odds.
WEIGHTS: Mapping[str, float] = MappingProxyType(
    {
        "base": -0.62,
        "azimuth_rougher": 1.38,
        "azimuth_stays": 0.61,
        "off_its_side": 0.81,
        "back_to_its_side": 1.55,
        "straight": 0.75,
        "no_azimuth": 0.98,
        "both_turn_more": 0.97,
        "both_turn_less": 0.99,
        "both_joints": 0.54,
        "silent_joint": 0.77,
        "often": 0.86,
        "natural_size": 1.16,
        "long": 2.35,
    }
)
_LONG = 0.7  # seconds: a longer interval is mostly motion
_LONG_SILENT = 2.0  # seconds: the same limit for an interval that a silent joint shows
_CLEAR, _SILENT = 3.0, 20.0  # nats: clear evidence from the azimuth, or from a silent joint
_AGAINST = -5.0  # nats: with less evidence from a bone, the bone clearly does not rotate
_QUIET = 0.1  # degrees: a bone with a smaller usual rotation hardly rotates
_SPEAKS = 0.7  # nats: minimum evidence from the azimuth or the usual side for a correction
# Degrees: maximum spread of a hinge, and how much farther a correction may rotate the bone from it.
_HINGE, _OFF = 3.0, 1.0
_SMALL = 3.0  # degrees: a person decides about a smaller rotation, unless it is clear
# The log odds of a correction that rotates a bone away from its hinge or that corrects noise.
_NEVER = -3.0
_MOTION = -3.0  # log odds below which an interval is considered natural motion
_SURE = 1.5  # log odds from which no doubts are listed
_LISTED_BELOW = -0.4  # a term with at most these log odds is listed as a doubt

# Degrees: the assumed size of natural opposite rotations if the clip has too little natural motion.
_USUAL = 10.0
_UNNAMED = "joint"
# Everyday names for the joint at the end of a segment.
MIDDLE = {
    "Shoulder": "shoulder",
    "Arm": "elbow",
    "UpLeg": "knee",
    "ForeArm": "wrist",
    "Leg": "ankle",
}


@dataclass(frozen=True)
class Judgement:
    """The judgement of an interval from all evidence.

    Attributes
    ----------
    score
        The log odds that the correction is right.
    doubts
        The reasons against the correction in words, the strongest first.
    terms
        The parts of the score, keyed by name.
    motion
        True if the interval is natural motion or the roll of one joint, with odds of at least
        twenty to one.
    small
        True if a person must decide, because the rotation is small and neither the azimuth nor a
        silent joint shows it clearly.
    """

    score: float
    doubts: tuple[str, ...]
    terms: Mapping[str, float]
    motion: bool = False
    small: bool = False

    @property
    def probability(self) -> float:
        """The probability that the correction is right, 0…1."""
        return 1.0 / (1.0 + math.exp(-max(-30.0, min(30.0, self.score))))


def unweighted_evidence_scores(t: Terms) -> dict[str, float]:
    """Return the terms of the score before weighting, keyed by the names in :data:`WEIGHTS`."""
    told = t.hinged and t.edge_bend > BENT and t.for_azimuth < _SPEAKS and t.for_side < _SPEAKS
    known = not math.isnan(t.off_before)
    nearer = math.log((t.off_before + 1.0) / (t.off_after + 1.0)) if known else 0.0
    long = _LONG_SILENT if t.silent else _LONG
    together = math.log(max(t.together, 0.05) / 2.0)
    beside = math.log(max(t.step / (t.natural or _USUAL), 0.2) / 2.5)
    return {
        "base": 1.0,
        "azimuth_rougher": -_clip(t.rougher / 10.0, 0.0, 3.0) * told,
        "azimuth_stays": -_clip(-t.for_azimuth - 0.2, 0.0, 3.0) * t.hinged,
        "off_its_side": -_clip(-nearer, 0.0, 1.7),
        "back_to_its_side": _clip(nearer - 0.4, 0.0, 1.6),
        "straight": _clip(1.0 - t.least_bend / 40.0, 0.0, 1.0) * t.hinged,
        "no_azimuth": -float(not t.hinged),
        "both_turn_more": -_clip(together, 0.0, 2.5),
        "both_turn_less": _clip(-together, 0.0, 3.0),
        "both_joints": _clip(min(t.for_x, t.for_y) / 5.0, -0.5, 1.5),
        "silent_joint": max(_clip(max(t.for_x, t.for_y) / 10.0 - 1.0, 0.0, 1.5), float(t.silent)),
        "often": -_clip(math.log(t.rate / 0.3), 0.0, 2.0) if t.rate else 0.0,
        "natural_size": _clip(beside, -1.6 if t.natural else 0.0, 1.0),
        "long": 0.0 if _clear(t) else -_clip(math.log(t.seconds / long), 0.0, 2.5),
    }


def _clear(t: Terms) -> bool:
    """Return True if the azimuth or one of the joints clearly shows the error at its edges."""
    return t.for_azimuth > _CLEAR or max(t.for_x, t.for_y) > _SILENT


def lacks_rotation_at_error_edges(t: Terms) -> bool:
    """Return True if the parent or the child clearly does not rotate at the edges of the error.

    The result is False if either of them hardly rotates in the rest of the clip, because a rotation
    of that joint at the edges is then sufficient evidence.
    """
    return not t.quiet < _QUIET and min(t.for_x, t.for_y) < _AGAINST


def judgement_of(t: Terms, segment: str = "", *, straight: bool = False) -> Judgement:
    """Judge an interval from the evidence about it.

    Parameters
    ----------
    t
        The evidence.
    segment
        The segment of the chain, which determines the name of the joint in the doubts.
    straight
        True if the interval was found as an error of a straight limb. In such an error, both bones
        must rotate at the ends of the interval.
    """
    parts = {name: WEIGHTS[name] * value for name, value in unweighted_evidence_scores(t).items()}
    motion = sum(parts.values()) < _MOTION
    vetoes = []
    if t.side_spread < _HINGE and t.off_after > t.off_before + _OFF:
        vetoes.append("off_its_hinge")
    if straight and lacks_rotation_at_error_edges(t):
        vetoes.append("unanswered")
    if t.noise > 0.0:
        vetoes.append("noise")
    for veto in vetoes:
        parts[veto] = min(0.0, _NEVER - sum(parts.values()))
    small = t.step < _SMALL and not (_clear(t) or t.silent)
    joint = MIDDLE.get(segment, _UNNAMED)
    score = sum(parts.values())
    against = [n for n in sorted(parts, key=parts.__getitem__) if parts[n] <= _LISTED_BELOW]
    listed = dict.fromkeys([*reversed(vetoes), *against])
    if "off_its_hinge" in listed:  # "off_its_side" would repeat this doubt
        listed.pop("off_its_side", None)
    doubts = [_in_words(name, t, joint) for name in listed if score < _SURE]
    if small:
        doubts.insert(0, _in_words("small", t, joint))
    words = tuple(d for d in doubts if d)
    return Judgement(score, words, MappingProxyType(parts), motion, small)


def _in_words(term: str, t: Terms, joint: str) -> str:
    """Return the doubt that a term expresses, as a clause, or '' for a term without words."""
    if term == "noise":
        return f"there is a burst of noise of {t.noise:.0f}°"
    if term == "off_its_hinge":
        return (
            f"the {joint} would bend {t.off_after - t.off_before:.0f}° further out of its "
            "hinge plane"
        )
    if term == "off_its_side":
        return (
            f"the {joint} would bend in a direction {t.off_after:.0f}° away from its usual "
            "direction in this clip"
        )
    if term == "azimuth_rougher":
        return f"the direction in which the {joint} bends would jump; now it changes smoothly"
    if term == "azimuth_stays":
        return f"the direction in which the {joint} bends does not jump with the twist"
    if term == "no_azimuth":
        if joint == _UNNAMED:
            return "no joint below the limb shows which way the limb bends"
        return f"no joint below the {joint} shows which way it bends"
    if term == "both_turn_more":
        return (
            f"together, the two bones rotate by {t.together:.0f} times the offset, so the limb "
            "moves fast"
        )
    if term == "long":
        return f"it lasts {t.seconds:.1f} s, longer than almost any error"
    if term == "unanswered":
        return "one of the two bones does not turn where the interval begins or ends"
    if term == "small":
        return (
            f"the turn is only {t.step:.1f}°, and neither a joint at rest nor the azimuth "
            "confirms it"
        )
    if term == "often":
        return f"such turns occur {t.rate or 0.0:.1f} times a second in this {joint}"
    if term == "natural_size":
        return f"turns of up to {t.natural or 0.0:.0f}° are usual in this {joint}"
    return ""


def _clip(value: float, low: float, high: float) -> float:
    return max(low, min(high, value))
