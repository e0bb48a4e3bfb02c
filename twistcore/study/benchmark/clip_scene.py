"""A clip as a protocol sees it: T-pose dropped, prepared, limbs and natural events known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis import ClipAnalysis
from twistcore.chain import Chain, find_chains, limbs, uncorrectable_joints
from twistcore.detection.cuts import leading_frames
from twistcore.detection.natural_events import NaturalEvent, natural_events
from twistcore.errors import TwistError
from twistcore.motion import Motion
from twistcore.synthesis import Protocol, prepare

SHORTEST = 16  # frames: room for two intervals and something around them
AUDITOR = "consistency"


@dataclass(frozen=True, eq=False)
class Scene:
    """The clean motion that errors are put into, with its correctable chains.

    dropped: leading frames of the file that are no capture; events: the audit's findings.
    """

    clip: str
    protocol: Protocol
    motion: Motion
    chains: tuple[Chain, ...]
    dropped: int
    events: tuple[NaturalEvent, ...]

    @cached_property
    def limbs(self) -> tuple[tuple[Chain, ...], ...]:
        """The chains by limb: an error in one changes nothing in another."""
        return limbs(self.motion.skeleton, self.chains)

    @cached_property
    def joints(self) -> NDArray[np.int64]:
        """Parents and children of all chains, ascending."""
        return joints_of(self.chains)

    @cached_property
    def eventful(self) -> frozenset[str]:
        """Chains with a natural event: the audited table leaves them out."""
        return frozenset(e.chain for e in self.events)

    def passes(self) -> tuple[tuple[int, tuple[Chain, ...]], ...]:
        """Index and targets: each chain in turn, or each with the one below it."""
        if self.protocol.clean:
            return ()
        if not self.protocol.both:
            return tuple((k, (chain,)) for k, chain in enumerate(self.chains))
        return tuple(
            (k, (a, b))
            for k, a in enumerate(self.chains)
            for b in self.chains
            if a.child == b.parent
        )


def joints_of(chains: Sequence[Chain]) -> NDArray[np.int64]:
    """Parents and children, ascending, each once."""
    return np.array(sorted({j for c in chains for j in (c.parent, c.child)}), dtype=np.int64)


def make_scene(name: str, motion: Motion, protocol: Protocol, auditor: str = AUDITOR) -> Scene:
    """Drop the leading frames, prepare, find the chains, audit them; TwistError where none is.

    Also where fewer than 16 frames are left.
    """
    dropped = leading_frames(motion)
    capture = motion.sliced(dropped, motion.frames)
    prepared = prepare(capture, find_chains(capture), protocol)
    if prepared.frames < SHORTEST:
        raise TwistError(f"{name}: expected at least {SHORTEST} frames, found {prepared.frames}")
    chains = tuple(c for c in find_chains(prepared) if not uncorrectable_joints(prepared, c))
    if not chains:
        raise TwistError(f"{name}: no chain that a twist error could be put into")
    step, found = protocol.step, natural_events(chains, ClipAnalysis(prepared, chains).by(auditor))
    events = tuple(
        replace(e, start=dropped + e.start * step, stop=dropped + e.stop * step) for e in found
    )
    return Scene(name, protocol, prepared, chains, dropped, events)
