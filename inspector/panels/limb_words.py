"""What a limb's middle joint and end are called, to be put into a sentence."""

from __future__ import annotations

from inspector.language import tr_as
from twistcore.skeleton.limb import Limb

# In a language whose words have genders with what stands before them: 'das Knie'.
_MIDDLES = {
    "elbow": tr_as("the limb's", "elbow"),
    "knee": tr_as("the limb's", "knee"),
    "middle joint": tr_as("the limb's", "middle joint"),
}
_ENDS = {
    "hand": tr_as("the limb's", "hand"),
    "foot": tr_as("the limb's", "foot"),
    "end": tr_as("the limb's", "end"),
}
_HEADS = {
    "hand": tr_as("heading", "Hand:"),
    "foot": tr_as("heading", "Foot:"),
    "end": tr_as("heading", "End:"),
}


def middle_of(limb: Limb) -> str:
    """Its knee or elbow."""
    return _MIDDLES[limb.middle_word]


def end_in_words(word: str) -> str:
    """Its 'hand', 'foot' or 'end', twistcore's word, in a sentence."""
    return _ENDS[word]


def end_as_heading(word: str) -> str:
    """The same before what is said of it."""
    return _HEADS[word]
