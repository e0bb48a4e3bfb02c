"""Notes about an analysed clip: sentences that each command shows once."""

from __future__ import annotations

from twistcore.work.frozen import dataclass

NOT_EXAMINED = "not examined"  # about the whole clip
UNEXAMINED = "unexamined"  # about a limb, or about some frames
CONSTANT_OFFSET = "constant offset"  # a bone that is turned against its child in every frame
NOISE = "noise burst"
SMOOTHED = "smoothed"  # joints that lost their fine movement for a while
FROZEN = "frozen"  # limbs that do not move at all for a while
UNSEARCHED = "unsearched"  # frames without a search for soft errors, because there were too many
RESTLESS_CLIP = "restless"  # too many lone jumps for any interval to be certain


@dataclass(frozen=True)
class Note:
    """A sentence about a clip. `kind` is a short word for the subject of the note."""

    kind: str
    text: str

    def __str__(self) -> str:
        return self.text

    def to_json(self) -> dict[str, str]:
        """Return the note's fields, keyed by name."""
        return {"kind": self.kind, "text": self.text}
