"""One way from a clip to its intervals: chains, signals and detectors, each asked once and kept."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from threading import Lock
from types import MappingProxyType

import numpy as np

from twistcore.bvh import Clip
from twistcore.chain import Chain, find_chains
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Analysis, Interval
from twistcore.errors import TwistError
from twistcore.limb import Limb
from twistcore.motion import Motion, forward_kinematics
from twistcore.progress import Tell, nobody
from twistcore.rotation import Array
from twistcore.signals import TwistSignals, signals_of_chains

Tau = float | Mapping[str, float]  # for all chains, or by the name of a chain


class ClipAnalysis:
    """What is known of a motion before any decision: it does not change, and is safe in threads.

    motion: what was analysed; chains, limbs: those looked at; name: of the clip, for people.
    """

    def __init__(self, motion: Motion, chains: Sequence[Chain], name: str = "motion") -> None:
        self.motion, self.name = motion, name
        self.chains = tuple(c for c in chains if not isinstance(c, Limb))
        self.limbs = tuple(c for c in chains if isinstance(c, Limb))
        self._by_method: dict[str, Analysis] = {}
        self._making = Lock()

    def __repr__(self) -> str:
        done = ", ".join(self._by_method) or "no detector asked yet"
        return f"<ClipAnalysis {self.name}: {len(self.chains)} chains, {done}>"

    def chain(self, name: str) -> Chain:
        """The chain of a name; TwistError says which there are."""
        return _named(self.chains, name, self.name)

    @cached_property
    def signals(self) -> Mapping[str, TwistSignals]:
        """θp, θc and m of every chain by name."""
        return signals_of_chains(self.motion, self.chains)

    @cached_property
    def reliability(self) -> Mapping[str, float]:
        """Median of ‖v⊥‖/‖v‖ by chain, 0…1: low where a straight limb leaves θc undefined."""
        return {k: float(np.median(s.azimuth_reliability)) for k, s in self.signals.items()}

    @cached_property
    def poses(self) -> tuple[Array, Array]:
        """Global rotations (frames, joints, 4) and positions (frames, joints, 3)."""
        return forward_kinematics(self.motion)

    def by(self, method: str = DEFAULT_METHOD, tell: Tell = nobody) -> Analysis:
        """What a detector knows of the motion; made when it is first asked for.

        tell: how far it is. TwistError for a method that there is not.
        """
        if method not in DETECTORS:
            raise TwistError(f"no detector {method!r}; expected one of {', '.join(DETECTORS)}")
        if kept := self.kept(method):  # also while another one is being made
            return kept
        with self._making:
            if method not in self._by_method:
                made = DETECTORS[method].analyse(self.motion, self.chains, tell)
                self._by_method[method] = made
            return self._by_method[method]

    def kept(self, method: str) -> Analysis | None:
        """What a detector knows if it was asked before; waits for nothing."""
        return self._by_method.get(method)

    def detect(
        self,
        method: str = DEFAULT_METHOD,
        *,
        tau_radians: Tau | None = None,
        tau_degrees: Tau | None = None,
    ) -> Detection:
        """The intervals of all chains at τ, for all or by chain name; else at the automatic τ."""
        analysis = self.by(method)
        tau = {c.name: analysis.automatic_tau(c.name) for c in self.chains}
        tau |= self._given(tau_radians, tau_degrees)
        found = [i for name, t in tau.items() for i in analysis.intervals(name, t)]
        return Detection(self, method, MappingProxyType(tau), tuple(found))

    def _given(self, radians: Tau | None, degrees: Tau | None) -> dict[str, float]:
        """τ by chain in radians, of the chains that it is given for."""
        if degrees is not None:
            if radians is not None:
                raise TwistError("expected τ in degrees or in radians, found both")
            return {name: math.radians(t) for name, t in self._given(degrees, None).items()}
        if isinstance(radians, Mapping):
            return {self.chain(name).name: float(t) for name, t in radians.items()}
        return {} if radians is None else {c.name: float(radians) for c in self.chains}


@dataclass(frozen=True, eq=False)
class Detection:
    """The intervals of a clip, by chain and start, and what they were found by.

    method: the detector; tau: radians by chain name.
    """

    analysis: ClipAnalysis
    method: str
    tau: Mapping[str, float]
    intervals: tuple[Interval, ...]

    def __repr__(self) -> str:
        found = f"{len(self)} interval{'' if len(self) == 1 else 's'}"
        return f"<Detection {self.analysis.name}: {found} by {self.method}>"

    @property
    def chains(self) -> tuple[Chain, ...]:
        """The chains that were looked at."""
        return self.analysis.chains

    def __len__(self) -> int:
        return len(self.intervals)

    def __iter__(self) -> Iterator[Interval]:
        return iter(self.intervals)

    def __getitem__(self, at: int) -> Interval:
        return self.intervals[at]


def analyse(clip: Clip | Motion, chains: Sequence[Chain | str] | None = None) -> ClipAnalysis:
    """A clip or a motion ready to be asked; chains: those named, in the clip's order, or all.

    TwistError for a chain that it lacks.
    """
    if isinstance(clip, Clip):
        motion, name, where = clip.motion, clip.name, str(clip.path)
    elif isinstance(clip, Motion):
        motion, name, where = clip, "motion", "motion"
    else:
        raise TypeError(f"expected a clip or a motion, found {type(clip).__name__} {clip!r:.80}")
    if chains is None:
        return ClipAnalysis(motion, find_chains(motion), name)
    given = [c for c in chains if isinstance(c, Chain)]
    if len(given) == len(chains):
        return ClipAnalysis(motion, given, name)
    every = find_chains(motion)
    wanted = {_named(every, str(c), where).name for c in chains}
    return ClipAnalysis(motion, [c for c in every if c.name in wanted], name)


def detect(
    clip: Clip | Motion,
    chains: Sequence[Chain | str] | None = None,
    method: str = DEFAULT_METHOD,
    *,
    tau_degrees: Tau | None = None,
    tau_radians: Tau | None = None,
) -> Detection:
    """Intervals in which a parent and its child twist against each other.

    chains: all, or those named; tau_degrees, tau_radians: the threshold for all chains or by
    chain name, the detector's own where none is given.
    """
    found = analyse(clip, chains)
    return found.detect(method, tau_degrees=tau_degrees, tau_radians=tau_radians)


def _named(chains: Sequence[Chain], name: str, where: str) -> Chain:
    for chain in chains:
        if chain.name == name:
            return chain
    known = ", ".join(sorted(c.name for c in chains)) or "–"
    raise TwistError(f"{where}: no chain {name!r}; expected one of {known}")
