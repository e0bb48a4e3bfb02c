"""What accepting would do: the motion with every interval corrected that is not rejected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twistcore.chain import Chain, uncorrectable_joints
from twistcore.detection import Interval
from twistcore.motion import Motion, forward_kinematics
from twistcore.refinement import offsets_by_chain, remove_twist
from twistcore.review import ReviewState
from twistcore.rotation import Array
from twistcore.signals import TwistSignals, twist_signals


class Corrections:
    """Offsets of a clip's intervals, summed by chain and kept from one change to the next.

    An undecided interval counts, so that it can be judged by what accepting it would do.
    """

    def __init__(self, motion: Motion, chains: tuple[Chain, ...]) -> None:
        self._motion, self._chains = motion, chains
        # No view shows what an export cannot write.
        self._free = {c.name for c in chains if not uncorrectable_joints(motion, c)}
        self._offsets: dict[str, Array] = {}
        self._summed: dict[str, list[Interval]] = {}  # what each of them is the sum of

    def update(self, state: ReviewState) -> None:
        """Take the intervals of a review; the sums of chains that are as they were stand."""
        chosen: dict[str, list[Interval]] = {}
        for interval in state.chosen(undecided=True):
            if interval.chain in self._free:
                chosen.setdefault(interval.chain, []).append(interval)
        for chain in [c for c in self._summed if self._summed[c] != chosen.get(c)]:
            del self._summed[chain], self._offsets[chain]
        for chain, intervals in chosen.items():
            if chain not in self._summed:
                self._offsets |= offsets_by_chain(intervals, self._motion.frames)
                self._summed[chain] = intervals

    def offset(self, chain: str) -> Array:
        """Twist error of a chain's parent, radians, (frames,)."""
        return self._offsets.get(chain, np.zeros(self._motion.frames))

    def pose(self, frame: int) -> tuple[Array, Array] | None:
        """Global rotations (joints, 4) and positions (joints, 3); None where all is as captured."""
        offsets = {name: o[frame : frame + 1] for name, o in self._offsets.items()}
        if not any(o[0] for o in offsets.values()):
            return None
        one = self._motion.sliced(frame, frame + 1)
        chains = [_at_frame(c, frame) for c in self._chains]
        rotations, positions = forward_kinematics(remove_twist(one, chains, offsets))
        return rotations[0], positions[0]

    def signals(self, chain: Chain) -> TwistSignals:
        """The signals of a chain after the corrections."""
        refined = remove_twist(self._motion, self._chains, self._offsets)
        return twist_signals(refined, chain)


def _at_frame(chain: Chain, frame: int) -> Chain:
    """The chain with the bone axis of one frame, where it varies."""
    if chain.axis.ndim == 1:
        return chain
    return replace(chain, axis=chain.axis[frame : frame + 1])
