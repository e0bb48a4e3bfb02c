"""What a detector declares about itself, and what it returns. This module loads no numpy."""

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
    """How a detector is shown; declared in the detector's own file.

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
        The word or symbol for its strength, the curve that the τ line lies on. "m" is the paper's
        m(t).
    has_confidence : bool
        True if its intervals have a confidence.
    tau : str
        How its automatic τ is described: "noise floor", or a fixed "automatic τ".
    limb_flips : bool
        True if the benchmark also searches for limb flips with it.
    note : str
        The benchmark's description; `measures` if not given.
    action : str
        The menu text; "Detect with" and the label if not given.
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
        """True if its strength is the paper's m(t), which is drawn along with any other."""
        return self.strength == "m"

    @property
    def column(self) -> str:
        """The label over a column."""
        return self.short or self.name

    @property
    def menu_text(self) -> str:
        """The menu text."""
        return self.action or f"Detect with {self.label}"


class Analysis(Protocol):
    """The analysis of a motion by a detector, before a threshold is chosen."""

    def automatic_tau(self, chain: str) -> float:
        """Return the automatic τ, radians."""
        ...

    def strength(self, chain: str) -> Array:
        """Return the curve that the τ line lies on, radians ≥ 0, shape (frames,)."""
        ...

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of a chain at τ radians, by start."""
        ...


class Detector(Protocol):
    """A way of finding twist errors."""

    @property
    def info(self) -> DetectorInfo:
        """How the detector is shown."""
        ...

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
    ) -> Analysis:
        """Analyse a motion as far as that does not depend on τ; tell: called with the progress."""
        ...
