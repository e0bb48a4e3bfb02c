"""Prepare a clip for a protocol: drop the T-pose, and find chains, limbs and natural events."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.detection import DEFAULT_METHOD, Kind
from twistcore.detection.carried_rolls import can_carry_roll_to_child
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.detection.natural_events import (
    NaturalEvent,
    chains_and_limbs_with_events,
    limb_flip_events,
    natural_events,
)
from twistcore.errors import TwistError
from twistcore.skeleton.chain import (
    Chain,
    find_chains,
    group_connected_chains,
    uncorrectable_joints,
)
from twistcore.skeleton.limb import Limb, find_limbs
from twistcore.skeleton.motion import Motion
from twistcore.study.evaluation import joints_with_possible_errors
from twistcore.synthesis import (
    Protocol,
    independent_chains,
    last_limb_chains,
    prepare_clean_motion_for_injection,
)

SHORTEST = 16  # number of frames that is enough for two intervals and some frames around them
AUDITOR = DEFAULT_METHOD
# Segments that end at an elbow, at a knee or at an unknown joint.
STRAIGHTENS = ("", "Arm", "UpLeg")


@dataclass(frozen=True, eq=False)
class CleanScene:
    """The clean motion into which errors are injected, with its correctable chains and limbs.

    Attributes
    ----------
    clip
        Name of the clip.
    protocol
        The protocol.
    motion
        The clean motion.
    chains, limbs
        The chains and limbs that can be corrected.
    dropped
        Number of frames that were skipped at the start of the file.
    events
        Natural events: detections of the auditing detector in the clean motion.
    """

    clip: str
    protocol: Protocol
    motion: Motion
    chains: tuple[Chain, ...]
    limbs: tuple[Limb, ...]
    dropped: int
    events: tuple[NaturalEvent, ...]

    @cached_property
    def groups(self) -> tuple[tuple[Chain, ...], ...]:
        """Groups of chains and limbs that share joints. Each error affects only one group."""
        return group_connected_chains(self.motion.skeleton, (*self.chains, *self.limbs))

    @property
    def targets(self) -> tuple[Chain, ...]:
        """The chains or limbs in which the protocol injects errors.

        Depending on the protocol, these are all chains, all limbs, or only one type of chain:
        chains that can be straightened, chains that can have carried rolls, or chains that end in
        a foot or a hand.
        """
        if self.protocol.straight:
            return tuple(c for c in self.chains if c.grandchild >= 0 and c.segment in STRAIGHTENS)
        if self.protocol.single:
            return last_limb_chains(self.motion.skeleton, self.chains)
        if self.protocol.carried:
            return tuple(c for c in self.chains if can_carry_roll_to_child(c))
        return self.limbs if self.protocol.limb else self.chains

    @cached_property
    def joints(self) -> NDArray[np.int64]:
        """Sorted indices of the parents and children of all chains and of the ends of all limbs."""
        return joints_with_possible_errors((*self.chains, *self.limbs))

    @cached_property
    def eventful(self) -> frozenset[str]:
        """Names of the chains and limbs with natural events, which are detections in clean motion.

        The audited tables omit these chains and limbs.
        """
        return chains_and_limbs_with_events(
            self.motion.skeleton, self.chains, self.limbs, self.events
        )

    def passes(self) -> tuple[tuple[int, tuple[Chain, ...]], ...]:
        """Return the index and the targets of each pass. Errors are injected into the targets.

        Depending on the protocol, the targets are a chain, a limb, a chain and the next one, or
        several independent chains.
        """
        if self.protocol.clean:
            return ()
        if self.protocol.together > 1:
            chains, many = self.chains, self.protocol.together
            return tuple((k, independent_chains(chains, k, many)) for k in range(len(chains)))
        if not self.protocol.both:
            return tuple((k, (target,)) for k, target in enumerate(self.targets))
        return tuple(
            (k, (a, b))
            for k, a in enumerate(self.chains)
            for b in self.chains
            if a.child == b.parent
        )


def make_clean_scene(
    name: str, motion: Motion, protocol: Protocol, auditor: str = AUDITOR
) -> CleanScene:
    """Prepare a clip for a protocol.

    Frames before the capture are removed, and the protocol's changes are applied. The function then
    searches for chains, limbs and natural events.

    Parameters
    ----------
    name
        Name of the clip.
    motion
        The motion of the clip.
    protocol
        The protocol.
    auditor
        Name of the detector whose detections count as natural events.

    Raises
    ------
    TwistError
        If there is no chain, or if fewer than 16 frames remain.
    """
    dropped = count_leading_rest_frames(motion)
    capture = motion.sliced(dropped, motion.frames)
    prepared = prepare_clean_motion_for_injection(capture, find_chains(capture), protocol)
    if prepared.frames < SHORTEST:
        raise TwistError(f"{name}: expected at least {SHORTEST} frames, found {prepared.frames}")
    every = find_chains(prepared)
    chains = tuple(c for c in every if not uncorrectable_joints(prepared, c))
    if not chains:
        raise TwistError(f"{name}: the clip has no chain for a twist error")
    whole = tuple(x for x in find_limbs(prepared, every) if not uncorrectable_joints(prepared, x))
    clip, step = ClipAnalysis(prepared, (*chains, *whole)), protocol.step
    found = [
        *natural_events(chains, clip.by(auditor)),
        *limb_flip_events(whole, clip.detect(auditor, kinds={Kind.LIMB_FLIP})),
    ]
    events = tuple(
        replace(e, start=dropped + e.start * step, stop=dropped + e.stop * step) for e in found
    )
    return CleanScene(name, protocol, prepared, chains, whole, dropped, events)
