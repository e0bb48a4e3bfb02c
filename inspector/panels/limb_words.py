"""The words for a limb's middle joint, for its end, and for the body part after a bone."""

from __future__ import annotations

from inspector.language import tr, tr_as, translate_core_sentence
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb

# A translation may include the article, such as 'das Knie' in German.
_MIDDLES = {
    "elbow": tr_as("the limb's", "elbow"),
    "knee": tr_as("the limb's", "knee"),
    "middle joint": tr_as("the limb's", "middle joint"),
}
_ENDS = {
    "hand": tr_as("the limb's", "hand"),
    "foot": tr_as("the limb's", "foot"),
    "end": tr_as("the limb's", "end"),
    "next joint": tr_as("the part that turns back", "next joint"),
}
_HEADS = {
    "hand": tr_as("heading", "Hand:"),
    "foot": tr_as("heading", "Foot:"),
    "end": tr_as("heading", "End:"),
    "next joint": tr_as("heading", "Next joint:"),
}

_PARTS = {  # the beginning of a sentence, keyed by label (side and segment)
    "Left Shoulder": tr("The left shoulder"),
    "Left Arm": tr("The left upper arm"),
    "Left ForeArm": tr("The left forearm"),
    "Left UpLeg": tr("The left thigh"),
    "Left Leg": tr("The left shin"),
    "Left arm": tr("The left arm"),
    "Left leg": tr("The left leg"),
    "Right Shoulder": tr("The right shoulder"),
    "Right Arm": tr("The right upper arm"),
    "Right ForeArm": tr("The right forearm"),
    "Right UpLeg": tr("The right thigh"),
    "Right Leg": tr("The right shin"),
    "Right arm": tr("The right arm"),
    "Right leg": tr("The right leg"),
}
_NEXT = {  # the body part that turns back, keyed by segment
    "Shoulder": tr_as("the part that turns back", "upper arm"),
    "Arm": tr_as("the part that turns back", "forearm"),
    "ForeArm": tr_as("the part that turns back", "hand"),
    "UpLeg": tr_as("the part that turns back", "shin"),
    "Leg": tr_as("the part that turns back", "foot"),
}
_PIECE = tr_as("the part that turns back", "next part of the bone")
_JOINT = tr_as("the part that turns back", "next joint")


def middle_joint_word(limb: Limb) -> str:
    """Return the word for the limb's middle joint: 'knee', 'elbow' or 'middle joint'."""
    return _MIDDLES[limb.middle_word]


def limb_end_in_sentence(word: str) -> str:
    """Return the word for a limb's end within a sentence.

    `word` is 'hand', 'foot', 'end' or 'next joint'.
    """
    return _ENDS[word]


def limb_end_heading(word: str) -> str:
    """Return the word for a limb's end as a heading with a colon.

    `word` is 'hand', 'foot', 'end' or 'next joint'.
    """
    return _HEADS[word]


def next_part(chain: Chain) -> str:
    """Return the body part after the chain's bone, such as 'hand' for a forearm."""
    return _NEXT.get(chain.segment, _JOINT) if chain.ends else _PIECE


def part_of_body(chain: Chain) -> str:
    """Return the body part of a chain or limb as the beginning of a sentence."""
    return _PARTS.get(chain.label) or translate_core_sentence(chain.label)
