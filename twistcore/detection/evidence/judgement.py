"""The probability that a repair is right, and what speaks against it in words.

A logistic score over terms whose signs physics gives; the weights were fitted on finds in public
captures that were looked at one by one, together with injected errors: `benchmarks.evidence`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

from twistcore.detection.evidence.terms import BENT, Terms
from twistcore.work.frozen import dataclass

# Log odds for each term of :func:`weighed`.
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
_LONG = 0.7  # seconds: what lasts longer is mostly motion, unless
_LONG_TOLD = 2.0  # seconds: as long may what a silent joint tells last
_CLEAR, _SILENT = 3.0, 20.0  # nats: the azimuth is clear, or a joint that is silent elsewhere
_AGAINST = -5.0  # nats: so one of both bones is against an error of a straight limb
_QUIET = 0.1  # degrees: a bone that hardly turns
_SPEAKS = 0.7  # nats from which the azimuth or C's side speaks for the repair
_HINGE, _OFF = 3.0, 1.0  # degrees: a joint that keeps so near to its side; how far it may leave it
_SMALL = 3.0  # degrees: what turns by less is left for a person, unless it is clear
_NEVER = -3.0  # log odds of a repair that takes an exact hinge apart, or of one of noise
_MOTION = -3.0  # log odds under which a turn is taken for motion
_SURE = 1.5  # log odds from which doubts are no news
_TOLD = -0.4  # log odds from which a term is a doubt worth telling

_USUAL = 10.0  # degrees: a fast turn of a joint of which the clip tells nothing else
_UNNAMED = "joint"
# What people call the joint below a bone.
MIDDLE = {
    "Shoulder": "shoulder",
    "Arm": "elbow",
    "UpLeg": "knee",
    "ForeArm": "wrist",
    "Leg": "ankle",
}


@dataclass(frozen=True)
class Judgement:
    """What the evidence about a find comes to.

    score: log odds that the repair is right; doubts: what speaks against it in words, the strongest
    first; terms: the parts of the score by name; motion: twenty to one it is motion, or the roll of
    one joint alone, and no error; small: it turns by so little that a person has to decide, as
    neither the azimuth nor a silent joint shows it.
    """

    score: float
    doubts: tuple[str, ...]
    terms: Mapping[str, float]
    motion: bool = False
    small: bool = False

    @property
    def probability(self) -> float:
        """Of the repair being right, 0…1."""
        return 1.0 / (1.0 + math.exp(-max(-30.0, min(30.0, self.score))))


def weighed(t: Terms) -> dict[str, float]:
    """The parts of the score before their weights, by the names of :data:`WEIGHTS`."""
    told = t.hinged and t.edge_bend > BENT and t.for_azimuth < _SPEAKS and t.for_side < _SPEAKS
    known = not math.isnan(t.off_before)
    nearer = math.log((t.off_before + 1.0) / (t.off_after + 1.0)) if known else 0.0
    long = _LONG_TOLD if t.silent else _LONG
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
    """Whether the azimuth shows the find at its edges, or a joint that is silent elsewhere."""
    return t.for_azimuth > _CLEAR or max(t.for_x, t.for_y) > _SILENT


def unanswered(t: Terms) -> bool:
    """Whether at the ends of a find one of the two bones is clearly against its turn.

    Not where one hardly turns elsewhere: that it does here is evidence enough.
    """
    return not t.quiet < _QUIET and min(t.for_x, t.for_y) < _AGAINST


def judgement_of(t: Terms, segment: str = "", *, straight: bool = False) -> Judgement:
    """What the evidence comes to.

    segment: the chain's, for the words; straight: the course of a straight limb is what found it,
    so that both bones must turn at its ends.
    """
    parts = {name: WEIGHTS[name] * value for name, value in weighed(t).items()}
    motion = sum(parts.values()) < _MOTION
    vetoes = []
    if t.side_spread < _HINGE and t.off_after > t.off_before + _OFF:
        vetoes.append("off_its_hinge")
    if straight and unanswered(t):
        vetoes.append("unanswered")
    if t.noise > 0.0:
        vetoes.append("noise")
    for veto in vetoes:
        parts[veto] = min(0.0, _NEVER - sum(parts.values()))
    small = t.step < _SMALL and not (_clear(t) or t.silent)
    joint = MIDDLE.get(segment, _UNNAMED)
    score = sum(parts.values())
    against = [n for n in sorted(parts, key=parts.__getitem__) if parts[n] <= _TOLD]
    told = dict.fromkeys([*reversed(vetoes), *against])
    if "off_its_hinge" in told:  # which says as much
        told.pop("off_its_side", None)
    doubts = [_in_words(name, t, joint) for name in told if score < _SURE]
    if small:
        doubts.insert(0, _in_words("small", t, joint))
    words = tuple(d for d in doubts if d)
    return Judgement(score, words, MappingProxyType(parts), motion, small)


def _in_words(term: str, t: Terms, joint: str) -> str:
    """A term that speaks against a repair as people read it; '' for one that says nothing new."""
    if term == "noise":
        return f"there is a burst of noise of {t.noise:.0f}°"
    if term == "off_its_hinge":
        return f"the {joint} would bend {t.off_after - t.off_before:.0f}° away from its hinge plane"
    if term == "off_its_side":
        return (
            f"the {joint} would bend {t.off_after:.0f}° away from where it bends in the rest "
            "of the clip"
        )
    if term == "azimuth_rougher":
        return f"the direction in which the {joint} bends would jump where it is smooth now"
    if term == "azimuth_stays":
        return f"the direction in which the {joint} bends does not jump with the twist"
    if term == "no_azimuth":
        if joint == _UNNAMED:
            return "no joint below shows which way the limb bends"
        return f"no joint below the {joint} shows which way it bends"
    if term == "both_turn_more":
        return f"both bones together turn {t.together:.0f} times as far there: the limb moves fast"
    if term == "long":
        return f"it lasts {t.seconds:.1f} s, longer than almost any error"
    if term == "unanswered":
        return "one of the two bones does not turn with it where it begins and ends"
    if term == "small":
        return (
            f"it turns by only {t.step:.1f}°, and neither a joint at rest nor the azimuth shows it"
        )
    if term == "often":
        return f"such turns occur {t.rate or 0.0:.1f} times a second in this {joint}"
    if term == "natural_size":
        return f"turns of up to {t.natural or 0.0:.0f}° are usual in this {joint}"
    return ""


def _clip(value: float, low: float, high: float) -> float:
    return max(low, min(high, value))
