"""The consistency detector, which is the default."""

from __future__ import annotations

from collections.abc import Sequence

from twistcore.detection.consistency.chain_analysis import ConsistencyAnalysis
from twistcore.detection.consistency.detector import analyse_counter_twists_of_chains
from twistcore.detection.consistency.notated import NotatedAnalysis
from twistcore.detection.protocol import DetectorInfo
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.work.progress import Tell


class ConsistencyDetector:
    """A detector of opposite rotations of parent and child that are not natural motion."""

    info = DetectorInfo(
        name="consistency",
        label="our detector",
        short="Our",
        measures=(
            "Counter-rotation that natural motion does not explain, at the start and the "
            "stop of an interval."
        ),
        strength="strength",
        tau="noise floor",
        note="counter-rotation beyond natural motion, paired into intervals; τ auto",
        action="Detect with our detector",
    )

    def analyse(
        self, motion: Motion, chains: Sequence[Chain], tell: Tell | None = None
    ) -> ConsistencyAnalysis | NotatedAnalysis:
        """Analyse chains of a motion, before a threshold τ is chosen.

        `tell` is called with the progress, from 0 to 1.
        """
        return analyse_counter_twists_of_chains(motion, chains, tell)


DETECTOR = ConsistencyDetector()
