"""Find carried rolls: a parent P rolls by a wrong angle, and its child C rolls with it.

In a counter-twist, P rotates by δ about its bone axis a, and C rotates by −δ about the same axis.
In a carried roll, C also rotates by δ about its own bone axis b, so the local rotations are

    q_P ⊗ R_a(δ),   R_a(−δ) ⊗ q_C ⊗ R_b(δ)

In both errors, C's bone keeps its direction. The roll R_b(δ) does not change the azimuth θc of C's
bone about P's bone [Choi26 Eq. 6-7]. After all rolls of C about b are removed from the motion, a
carried roll is a counter-twist, so the consistency detector can find it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field, replace

import numpy as np
from numpy.typing import ArrayLike

from twistcore.detection.consistency.chain_analysis import ConsistencyAnalysis
from twistcore.detection.consistency.detector import analyse_counter_twists_of_chains
from twistcore.detection.consistency.notated import NotatedAnalysis
from twistcore.detection.evidence.chain_signals import (
    PACE,
    ChainSignals,
    Mask,
    evict_oldest_cache_entries,
)
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.prediction import Index
from twistcore.skeleton.angles import wrap_degrees
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.motion import Motion
from twistcore.work.frozen import dataclass

LEAST_BEND = 20.0  # degrees; the azimuth of a straighter limb is mostly noise
LEAST = 3.0  # degrees; smaller turns of P at an edge are ignored
WIDEST = 0.06  # maximum duration of an edge in seconds
_AGREE = 0.4  # share of P's turn by which the turns of the azimuth and of C may differ from it
# Share of the usual effort of the search for soft errors. In 345 restless clips, a higher effort
# finds nothing more.
_EFFORT = 0.2
# Minimum ratio of P's turn at an edge to its usual turn, after the pace is subtracted from both.
_OUTSTANDING = 4.0


@dataclass(frozen=True, eq=False)
class CarriedRolls:
    """The analysis of carried rolls, before a threshold is chosen.

    Both attributes are keyed by chain name. Chains without an edge that looks like a carried roll
    are omitted.

    Attributes
    ----------
    known
        The consistency detector's analyses of the motion after the child's roll about its own bone
        is removed.
    signals
        The signals of these chains.
    """

    known: Mapping[str, ConsistencyAnalysis | NotatedAnalysis]
    signals: Mapping[str, ChainSignals]
    _rolls: dict[Interval, Interval | None] = field(default_factory=dict)  # by detected interval

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        """Return the carried rolls of a chain at threshold τ in radians, sorted by start."""
        if chain not in self.known:
            return ()
        found = map(self._roll, self.known[chain].intervals(chain, tau))
        return tuple(roll for roll in found if roll is not None)

    def _roll(self, found: Interval) -> Interval | None:
        """Convert a detected counter-twist to a carried roll, or return None if it is not one.

        The result is cached.
        """
        if found not in self._rolls:
            carried = is_roll_carried_to_child(self.signals[found.chain], found)
            roll = replace(found, kind=Kind.CARRIED_ROLL, carried=True) if carried else None
            self._rolls[found] = roll
        return self._rolls[found]


@dataclass(frozen=True, eq=False)
class CarriedRollTest:
    """A test of whether a counter-twist in a motion is a carried roll.

    The signals of a chain are computed on first use. In a long clip, only the signals of the last
    few chains are cached.
    """

    motion: Motion
    _signals: dict[str, ChainSignals] = field(default_factory=dict)

    def is_carried(self, chain: Chain, twist: Interval) -> bool:
        """Return True if the child rolls with the parent in a counter-twist of the chain."""
        if not can_carry_roll_to_child(chain):
            return False
        if chain.name not in self._signals:
            known = evict_oldest_cache_entries(self._signals, self.motion.frames, fewest=2)
            known[chain.name] = ChainSignals.of(self.motion, chain)
        return is_roll_carried_to_child(self._signals[chain.name], twist)


def analyse_rolls_carried_to_child(
    motion: Motion, chains: Iterable[Chain], *, reuse: bool = False
) -> CarriedRolls:
    """Analyse the carried rolls of chains as far as possible without a threshold τ.

    Known counter-twists must already be removed from `motion`, or they would be found again. If
    `reuse` is True, the rotations of `motion` are changed during the analysis instead of copied,
    which saves memory.
    """
    signals = {}
    for chain in chains:
        if can_carry_roll_to_child(chain):
            own = ChainSignals.of(motion, chain)
            if _has_edge(own):
                signals[chain.name] = own.detached(), chain
    rotations = motion.rotations if reuse else motion.rotations.copy()
    known: dict[str, ConsistencyAnalysis | NotatedAnalysis] = {}
    for group in _apart([chain for _, chain in signals.values()]):
        for chain in group:
            rotations[:, chain.child] = signals[chain.name][0].unrolled
        # Without its roll, C's rotation turns P's bone axis to the direction of C's bone.
        as_twists = [replace(chain, arm=chain.axis) for chain in group]
        analysis = analyse_counter_twists_of_chains(
            motion.with_rotations(rotations), as_twists, effort=_EFFORT
        )
        known |= dict.fromkeys((chain.name for chain in group), analysis.detached())
        for chain in group:
            rotations[:, chain.child] = signals[chain.name][0].q_child
    return CarriedRolls(known, {name: own for name, (own, _) in signals.items()})


def can_carry_roll_to_child(chain: Chain) -> bool:
    """Return True if carried rolls can be found in a chain.

    The chain must have a grandchild joint, whose position determines the azimuth, and bones of
    constant direction. Helper bones and inner pieces of a divided bone are excluded.
    """
    constant = chain.axis.ndim == chain.arm.ndim == 1
    return chain.grandchild >= 0 and chain.ends and constant and not isinstance(chain, Helper)


def bent_frames(motion: Motion, chain: Chain) -> Mask:
    """Return a mask of the frames in which a chain is bent enough for a carried roll, (frames,).

    The mask is False everywhere if carried rolls cannot be found in the chain.
    """
    if not can_carry_roll_to_child(chain):
        return np.zeros(motion.frames, dtype=bool)
    return np.asarray(ChainSignals.of(motion, chain).bend >= LEAST_BEND)


def _apart(chains: Iterable[Chain]) -> list[list[Chain]]:
    """Divide chains into groups in which no two chains share a joint."""
    groups: list[list[Chain]] = []
    for chain in chains:
        fits = (g for g in groups if all(_share_no_joint(chain, other) for other in g))
        if (group := next(fits, None)) is None:
            groups.append(group := [])
        group.append(chain)
    return groups


def _share_no_joint(a: Chain, b: Chain) -> bool:
    return {a.parent, a.child}.isdisjoint((b.parent, b.child))


def _has_edge(signals: ChainSignals) -> bool:
    """Return True if a chain moves at least once as at the edge of a carried roll.

    The parent's rotation must be far larger than its usual rotation over the same number of frames.
    """
    for width in range(1, max(1, round(WIDEST * signals.fps)) + 1):
        x = np.abs(signals.beyond_pace("x", width))
        at = np.flatnonzero(x >= LEAST)
        if len(at):
            usual = (1.48 * np.nanmean(np.sqrt(x))) ** 2
            at = at[x[at] > _OUTSTANDING * usual]
        if len(at):
            at = at[signals.bend[np.maximum(at - 1, 0)] >= LEAST_BEND]
        if len(at) and _turned(signals, at, width).any():
            return True
    return False


def _turned(signals: ChainSignals, at: Index, width: int) -> Mask:
    """Return a mask of the frames `at` in which the joints rotate as in a carried roll, (n,).

    The rotations are measured over `width` frames.
    """
    names = "x", "azimuth_turns", "roll_turns"
    return _alike(*(signals.beyond_pace(name, width)[at] for name in names))


def _alike(x: ArrayLike, azimuth: ArrayLike, roll: ArrayLike) -> Mask:
    """Return True where the angles of a parent and child change as in a carried roll.

    If the parent twists by an angle, the azimuth changes by about minus this angle, and the child
    rolls by about this angle. `x` is the parent's twist, `azimuth` the change of the azimuth, and
    `roll` the child's roll, in degrees.
    """
    x, azimuth, roll = np.asarray(x), np.asarray(azimuth), np.asarray(roll)
    limit = _AGREE * np.abs(x)
    back, along = (
        np.abs(wrap_degrees(x + azimuth)) <= limit,
        np.abs(wrap_degrees(x - roll)) <= limit,
    )
    return np.asarray(back & along)


def is_roll_carried_to_child(signals: ChainSignals, found: Interval) -> bool:
    """Return True if a detected counter-twist is a carried roll.

    The limb must be bent throughout the interval, and the child must roll with the parent at every
    edge.
    """
    around = slice(max(found.start - 1, 0), found.stop + 1)
    if signals.bend[around].min() < LEAST_BEND:
        return False
    edges = [(e["start"], e["stop"]) for e in (found.evidence or {}).get("edges", ())]
    if not edges:  # a soft onset, up to the largest offset
        edges = [(found.start, found.start + int(np.abs(found.offset).argmax()) + 1)]
    return all(_edge_is_carried(signals, start, stop) for start, stop in edges)


def _edge_is_carried(signals: ChainSignals, start: int, stop: int) -> bool:
    near = np.r_[max(start - PACE, 0) : start, stop : min(stop + PACE, signals.frames)]
    series = signals.x, signals.azimuth_turns, signals.roll_turns
    paces = (turns[near].mean() if len(near) else 0.0 for turns in series)
    turned = (
        wrap_degrees(turns[start:stop].sum() - (stop - start) * pace)
        for turns, pace in zip(series, paces, strict=True)
    )
    return bool(_alike(*turned))
