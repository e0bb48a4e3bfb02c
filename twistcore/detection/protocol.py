"""What a detector is: what it announces about itself, and what it answers. No numpy is loaded."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

from twistcore.work.frozen import dataclass

if TYPE_CHECKING:
    from twistcore.detection.interval import Interval
    from twistcore.skeleton.chain import Chain
    from twistcore.skeleton.motion import Motion
    from twistcore.skeleton.rotation import Array
    from twistcore.work.progress import Tell


@dataclass(frozen=True)
class DetectorInfo:
    """What people are shown of a detector; declared in the detector's own file.

    Parameters
    ----------
    name : str
        The word for ``--method``, files and profiles: small letters, digits, ``-`` and ``_``.
    label : str
        Its name within a sentence: "the paper's detector".
    measures : str
        One sentence on what it measures.
    short : str
        The label over a column; the name if not given.
    strength : str
        Word or symbol of its strength, the curve that the τ line lies on. "m" is the paper's m(t).
    has_confidence : bool
        True if its intervals have a confidence.
    tau : str
        What its automatic τ is: "noise floor", or a fixed "automatic τ".
    limb_flips : bool
        True if the benchmark looks for flips of limbs along with it.
    note : str
        What the benchmark writes about it; `measures` if not given.
    action : str
        The words of the menu; "Detect with" and the label if not given.
    """

    name: str
    label: str
    measures: str
    short: str = ""
    strength: str = "strength"
    has_confidence: bool = True
    tau: str = "automatic τ"
    limb_flips: bool = True
    note: str = ""
    action: str = ""

    @property
    def is_m(self) -> bool:
        """Whether its strength is the paper's m(t), which is drawn along with any other."""
        return self.strength == "m"

    @property
    def column(self) -> str:
        """The label over a column."""
        return self.short or self.name

    @property
    def menu_text(self) -> str:
        """The words of the menu."""
        return self.action or f"Detect with {self.label}"


class Analysis(Protocol):
    """What a detector knows of a motion before any τ."""

    def automatic_tau(self, chain: str) -> float:
        """τ in radians when nobody names one."""
        ...

    def strength(self, chain: str) -> Array:
        """The curve that the τ line lies on, radians ≥ 0, shape (frames,)."""
        ...

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Intervals of a chain at τ radians, by start."""
        ...


class Detector(Protocol):
    """A way of finding twist errors."""

    @property
    def info(self) -> DetectorInfo:
        """What people are shown of it."""
        ...

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
    ) -> Analysis:
        """Everything that does not depend on τ; tell: how far it is."""
        ...
