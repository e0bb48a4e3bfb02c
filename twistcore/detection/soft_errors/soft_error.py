"""An error that sets in softly."""

from __future__ import annotations

from dataclasses import dataclass

from twistcore.rotation import Array


@dataclass(frozen=True, eq=False)
class SoftError:
    """Twist error of P of the chain in `row`, from frame `start` on, (frames,), radians.

    gain: nats against natural motion; sigma: of its repair, radians; followed: the share of it by
    which C turns back.
    """

    row: int
    start: int
    offset: Array
    gain: float
    sigma: float
    followed: float = 1.0

    @property
    def stop(self) -> int:
        """The frame behind it."""
        return self.start + len(self.offset)
