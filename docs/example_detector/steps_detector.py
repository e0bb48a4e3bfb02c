"""A detector in one file: the parent's twist jumps by at least τ, and jumps back."""

import numpy as np

import twistcore as tc
from twistcore.detection import DetectorInfo


class StepsAnalysis:
    """The signals of every chain: everything that does not depend on τ."""

    def __init__(self, motion, chains):
        self.signals = {chain.name: tc.twist_signals(motion, chain) for chain in chains}

    def automatic_tau(self, chain):
        """Return τ in radians."""
        return np.radians(10.0)

    def strength(self, chain):
        """Return the curve that is compared with τ, in radians, (frames,)."""
        return np.abs(self.signals[chain].dtheta_p)

    def intervals(self, chain, tau):
        """Return the intervals between a jump and the next jump in the other direction."""
        step, found = self.signals[chain].dtheta_p, []
        for frame in np.flatnonzero(np.abs(step) >= tau).tolist():
            if found and found[-1][1] is None and step[frame] * step[found[-1][0]] < 0.0:
                found[-1][1] = frame
            else:
                found.append([frame, None])
        pairs = [(start, stop) for start, stop in found if stop is not None]
        return [tc.Interval(chain, a, b, np.full(b - a, step[a])) for a, b in pairs]


class StepsDetector:
    """The detector. The program reads its description from `info`."""

    info = DetectorInfo(
        name="steps",
        label="the detector of steps",
        short="Steps",
        measures="Jumps of the parent's twist, and the jump back.",
        strength="|Δθp|",
        has_confidence=False,
    )

    def analyse(self, motion, chains, tell=None):
        """Analyse a motion. `tell` is called with the progress, 0…1."""
        return StepsAnalysis(motion, chains)
