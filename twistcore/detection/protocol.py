"""The interfaces of a detector and of its analysis. This module does not load numpy."""

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
    """The description of a detector, which is declared in the detector's file.

    Parameters
    ----------
    name : str
        The name for ``--method``, files and profiles: lower-case letters, digits, ``-`` and ``_``.
    label : str
        The detector's name for use within a sentence: "the paper's detector".
    measures : str
        A sentence about the quantity that the detector measures.
    short : str
        The heading of a table column; `name` if not given.
    strength : str
        The word or symbol for the strength, the curve that is compared with τ; "m" for m(t) of
        [Choi26].
    has_confidence : bool
        True if the detector returns a confidence for its intervals.
    tau : str
        The description of the automatic τ: "noise floor", or "automatic τ" if it is fixed.
    limb_flips : bool
        True if the benchmark also searches for limb flips with this detector.
    note : str
        The description in the benchmark; `measures` if not given.
    action : str
        The text of the menu item; "Detect with" followed by `label` if not given.
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
        """True if the strength is m(t) of [Choi26]. No separate curve for m(t) is then needed."""
        return self.strength == "m"

    @property
    def column(self) -> str:
        """The heading of a table column: `short`, or `name` if `short` is empty."""
        return self.short or self.name

    @property
    def menu_text(self) -> str:
        """The text of the menu item that runs the detector."""
        return self.action or f"Detect with {self.label}"


class Analysis(Protocol):
    """The analysis of a motion by a detector, before a threshold is chosen."""

    def automatic_tau(self, chain: str) -> float:
        """Return the automatic τ of a chain, in radians."""
        ...

    def strength(self, chain: str) -> Array:
        """Return the strength of a chain, which is compared with τ, in radians ≥ 0, (frames,)."""
        ...

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the intervals of a chain at threshold τ in radians, sorted by start."""
        ...


class Detector(Protocol):
    """A method of finding twist errors."""

    @property
    def info(self) -> DetectorInfo:
        """The detector's name and display texts."""
        ...

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
    ) -> Analysis:
        """Analyse chains of a motion as far as possible without a threshold τ.

        `tell` is called with the progress, from 0 to 1.
        """
        ...
