"""Flips of a whole limb about the line from its first joint to its end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from twistcore.detection.interval import Interval
from twistcore.limb import Limb
from twistcore.motion import Motion
from twistcore.progress import Tell, nobody
from twistcore.rotation import Array


@dataclass(frozen=True, eq=False)
class LimbFlipAnalysis:
    """All limbs before any τ; what the detectors of chains answer for a chain, for a limb."""

    limbs: Mapping[str, Limb]

    def automatic_tau(self, limb: str) -> float:
        """τ in radians when nobody names one: a jump of the swivel in a frame."""
        raise NotImplementedError

    def strength(self, limb: str) -> Array:
        """How far the swivel jumps in every frame beyond its motion, radians ≥ 0, (frames,)."""
        raise NotImplementedError

    def intervals(self, limb: str, tau: float) -> tuple[Interval, ...]:
        """Flips of a limb at τ radians, by start."""
        raise NotImplementedError


def analyse_limbs(
    motion: Motion, limbs: Sequence[Limb], tell: Tell = nobody
) -> LimbFlipAnalysis:
    """Everything that does not depend on τ; tell: how far it is."""
    del motion, tell
    return LimbFlipAnalysis({limb.name: limb for limb in limbs})
