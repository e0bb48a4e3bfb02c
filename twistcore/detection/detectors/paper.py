"""The detector of [Choi26] §3.3, unchanged. It is the baseline in all tables."""

from __future__ import annotations

from collections.abc import Sequence

from twistcore.detection.paper import PaperAnalysis
from twistcore.detection.protocol import DetectorInfo
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.signals import signals_of_chains
from twistcore.work.progress import Tell


class PaperDetector:
    """A detector of frames in which parent and child twist in opposite directions by at least τ.

    In these frames, min(|Δθp|, |Δθc|) ≥ τ.
    """

    info = DetectorInfo(
        name="paper",
        label="the paper's detector",
        short="Paper's",
        measures="The smaller of |Δθp| and |Δθc| where parent and child twist in opposite "
        "directions.",
        strength="m",
        has_confidence=False,
        limb_flips=False,
        note="[Choi26] §3.3, angles wrapped, τ 5°; the correction removes the running sum",
        action="Detect with the paper's detector",
    )

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
    ) -> PaperAnalysis:
        """Compute the signals of chains, which do not depend on τ.

        `tell` is called with the progress, from 0 to 1.
        """
        return PaperAnalysis(signals_of_chains(motion, chains, tell))


DETECTOR = PaperDetector()
