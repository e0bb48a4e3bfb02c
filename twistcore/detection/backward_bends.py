"""Find backward bends, in which a knee or an elbow bends against its hinge without a jump.

In most of a clip, a knee or an elbow bends to one side. The bend to that side is the flexion of the
joint. Negative flexion is hyperextension. A few degrees of hyperextension are natural, and a rig
may add more. The limit is therefore the sum of three angles: a constant, the joint's usual
hyperextension, and the joint's play (the angle by which it bends sideways).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from twistcore.detection.all_joints.finders import find_joint_jumps, find_spikes
from twistcore.detection.all_joints.joint_steps import StepLimits
from twistcore.detection.capture_faults import find_bursts
from twistcore.detection.evidence import ChainSignals, usual_bend_side
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind, create_interval_without_offset
from twistcore.detection.lone_jumps import find_lone_jumps
from twistcore.detection.stretches import find_stretches
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.joint_owners import chain_of_joint
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.medians import quantile
from twistcore.skeleton.rotation import Array
from twistcore.skeleton.runs import runs_of_true
from twistcore.work.frozen import dataclass

BACKWARD = 10.0  # degrees of hyperextension allowed in addition to the usual one and the play
MOST_PLAY = 25.0  # degrees; a joint with more play is not a hinge
FORWARD = 25.0  # degrees of flexion in at least 5 % of the clip; with less, the hinge is unknown
_OFTEN = 2.0  # minimum ratio of frames that bend forward to frames that bend backward
_USUAL = 0.25  # share of the clip in which the usual hyperextension is reached or exceeded
SHORTEST, FEWEST = 0.1, 3  # minimum duration in seconds and in frames; a shorter bend is a spike
_BESIDE = 3  # maximum distance in frames from an edge of a bend to an edge of its cause
_COVERS = 0.5  # an error that covers a larger share of a bend is its cause


@dataclass(frozen=True, eq=False)
class Hinge:
    """The flexion of a knee or an elbow, and its natural hyperextension.

    All angles are in degrees.

    Attributes
    ----------
    flexion
        The flexion in each frame, negative for a backward bend, shape (frames,).
    play
        The 95 % quantile of the angle by which the joint bends sideways.
    extended
        The hyperextension that is reached or exceeded in a quarter of the clip, or 0.
    """

    flexion: Array
    play: float
    extended: float

    @property
    def limit(self) -> float:
        """The hyperextension above which a bend is an error, in degrees."""
        return self.extended + BACKWARD + self.play

    def backward(self, shortest: float) -> Iterator[tuple[int, int, float]]:
        """Yield (start, stop, degrees) for each backward bend in frames [start, stop).

        `degrees` is the largest hyperextension in these frames. A bend begins and ends halfway
        between the usual hyperextension and the limit, and must exceed the limit in at least
        `shortest` frames.
        """
        back = -self.flexion
        for start, stop in runs_of_true(back > self.extended + 0.5 * (self.limit - self.extended)):
            if (back[start:stop] > self.limit).sum() >= shortest:
                yield start, stop, float(back[start:stop].max())


def hinge_of(signals: ChainSignals) -> Hinge | None:
    """Return the hinge at a chain's child joint, computed from the chain's signals.

    The result is None if the clip does not show to which side the joint bends.
    """
    side = usual_bend_side(signals, np.zeros(signals.frames, dtype=bool))
    if side is None:
        return None
    bend, off = np.radians(signals.bend), np.radians(side.off)
    flexion = np.degrees(np.arctan2(np.sin(bend) * np.cos(off), np.cos(bend)))
    play = quantile(np.abs(np.degrees(np.arcsin(np.sin(bend) * np.sin(off)))), 0.95)
    forward, back = (int((way * flexion > BACKWARD).sum()) for way in (1.0, -1.0))
    if play > MOST_PLAY or quantile(flexion, 0.95) < FORWARD or forward < _OFTEN * back:
        return None
    return Hinge(flexion, play, max(0.0, -quantile(flexion, _USUAL)))


def find_backward_bends(search: KindSearch) -> Found:
    """Return the backward bends of knees and elbows in all chains, keyed by chain name."""
    if search.motion.frames < 4 or not search.chains:
        return {}
    found: Found = search.once(_in_all_chains)
    return found


def _in_all_chains(search: KindSearch) -> dict[str, list[Interval]]:
    motion = search.corrected_motion()
    shortest = max(SHORTEST * motion.fps, FEWEST)
    owner, names = chain_of_joint(search.chains), motion.skeleton.names
    middle = {limb.child for limb in search.named if isinstance(limb, Limb)}
    found: dict[str, list[Interval]] = {}
    for chain in search.chains:
        if chain.child not in middle or not chain.ends:
            continue
        if (hinge := hinge_of(ChainSignals.of(motion, chain))) is None:
            continue
        own = owner[chain.child]
        for start, stop, back in hinge.backward(shortest):
            if _jumps(hinge.flexion, start, stop, motion.fps):
                continue
            if not _explained_by(_others(search, chain), start, stop):
                joint, size = names[chain.child], math.radians(back)
                evidence = {"joint": joint, "backward_deg": back, "limit_deg": hinge.limit}
                one = create_interval_without_offset(
                    Kind.BACKWARD_BEND, own.name, start, stop, size, evidence
                )
                found.setdefault(own.name, []).append(one)
    return found


def _jumps(flexion: Array, start: int, stop: int, fps: float) -> bool:
    """Return True if the flexion jumps in frames [start, stop) or at one of their edges."""
    most = float(StepLimits.of(1, fps, set()).jump[0])
    around = flexion[max(start - 1, 0) : stop + 1]
    return bool((np.abs(np.diff(around)) > most).any())


def _others(search: KindSearch, chain: Chain) -> list[Interval]:
    """Return the errors of other kinds that may cause a backward bend of a chain's child joint."""
    names = search.motion.skeleton.names
    joints = {names[chain.parent], names[chain.child]}
    child = {own.name: own.child for own in search.named}
    errors = [error for error in search.errors() if child[error.chain] == chain.child]
    finders = find_lone_jumps, find_stretches, find_spikes, find_joint_jumps, find_bursts
    shown = (one for find in finders for own in find(search).values() for one in own)
    return errors + [one for one in shown if one.joint in joints]


def _explained_by(others: Sequence[Interval], start: int, stop: int) -> bool:
    """Return True if one of the errors `others` explains a backward bend in [start, stop).

    Such an error covers most of these frames, or it begins or ends near an edge of the bend.
    """
    return any(
        min(stop, one.stop) - max(start, one.start) > _COVERS * (stop - start)
        or any(
            abs(edge - own) <= _BESIDE for edge in (one.start, one.stop) for own in (start, stop)
        )
        for one in others
    )
