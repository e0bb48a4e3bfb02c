"""Notes about an analysed clip, which each command shows once."""

from __future__ import annotations

from twistcore.work.frozen import dataclass

NOT_EXAMINED = "not examined"  # the whole clip was not examined
UNEXAMINED = "unexamined"  # a limb or some frames were not examined
CONSTANT_OFFSET = "constant offset"  # a bone is rotated relative to its child in every frame
NOISE = "noise burst"
SMOOTHED = "smoothed"  # joints lose their fine movement for a while
FROZEN = "frozen"  # limbs do not move at all for a while
UNSEARCHED = "unsearched"  # soft errors were not searched for, because the clip has too many frames
RESTLESS_CLIP = "restless"  # the clip has too many lone jumps for any interval to be certain


@dataclass(frozen=True)
class Note:
    """A sentence about a clip.

    Attributes
    ----------
    kind
        A short word for the subject, such as 'frozen'.
    text
        The sentence.
    """

    kind: str
    text: str

    def __str__(self) -> str:
        return self.text

    def to_json(self) -> dict[str, str]:
        """Return the note's fields, keyed by name."""
        return {"kind": self.kind, "text": self.text}
