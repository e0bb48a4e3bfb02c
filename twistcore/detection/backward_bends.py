"""Backward bends: a knee or an elbow bends against its hinge, without a jump.

In most of a clip, a knee or an elbow bends to one side. The angle to that side is its flexion,
which is negative where the joint bends backward. A few degrees are natural, and a rig may add more.
The limit therefore includes the play of the joint across its hinge and its usual extension.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np

from twistcore.detection.all_joints.finders import find_joint_jumps, find_spikes
from twistcore.detection.all_joints.joint_steps import StepLimits
from twistcore.detection.capture_faults import find_bursts
from twistcore.detection.evidence import Witnesses, usual_side
from twistcore.detection.finding import Found, KindSearch
from twistcore.detection.interval import Interval, Kind
from twistcore.detection.lone_jumps import chain_of_joint, find_lone_jumps
from twistcore.detection.runs import runs
from twistcore.detection.stretches import find_stretches
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.medians import quantile
from twistcore.skeleton.rotation import Array
from twistcore.work.frozen import dataclass

BACKWARD = 10.0  # degrees of hyperextension, in addition to the play and the usual extension
MOST_PLAY = 25.0  # degrees across the hinge; a joint with more play is not a hinge
FORWARD = 25.0  # degrees of flexion in at least 5 % of the clip; with less, the hinge is unknown
_OFTEN = 2.0  # ratio of frames that bend forward to frames that bend backward
_USUAL = 0.25  # share of the clip that shows how far a joint is usually extended
SHORTEST, FEWEST = 0.1, 3  # seconds and frames: a shorter bend is a spike
_BESIDE = 3  # frames between the edges of a bend and of another error that explains it
_COVERS = 0.5  # share of a bend; an error that covers more of it explains the bend


@dataclass(frozen=True, eq=False)
class Hinge:
    """The flexion of a knee or an elbow in degrees, (frames,), and its natural hyperextension.

    - play: the 95 % quantile of the angle across the hinge
    - extended: the hyperextension that is reached or exceeded in a quarter of the clip, or 0
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

        `degrees` is the largest hyperextension in these frames. A bend consists of the frames
        beyond half of the limit and must exceed the limit in at least `shortest` frames.
        """
        back = -self.flexion
        for start, stop in runs(back > self.extended + 0.5 * (self.limit - self.extended)):
            if (back[start:stop] > self.limit).sum() >= shortest:
                yield start, stop, float(back[start:stop].max())


def hinge_of(signals: Witnesses) -> Hinge | None:
    """Return the hinge at the child joint C of a chain.

    The result is None if the clip does not show to which side C bends.
    """
    side = usual_side(signals, np.zeros(signals.frames, dtype=bool))
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
        if (hinge := hinge_of(Witnesses.of(motion, chain))) is None:
            continue
        own = owner[chain.child]
        for start, stop, back in hinge.backward(shortest):
            if _jumps(hinge.flexion, start, stop, motion.fps):
                continue
            if not _explained_by(_others(search, chain), start, stop):
                one = _interval(own.name, names[chain.child], start, stop, back, hinge.limit)
                found.setdefault(own.name, []).append(one)
    return found


def _jumps(flexion: Array, start: int, stop: int, fps: float) -> bool:
    """Return True if the flexion jumps in frames [start, stop) or at one of their edges."""
    most = float(StepLimits.of(1, fps, set()).jump[0])
    around = flexion[max(start - 1, 0) : stop + 1]
    return bool((np.abs(np.diff(around)) > most).any())


def _others(search: KindSearch, chain: Chain) -> list[Interval]:
    """Return the other errors that may bend the child joint C of a chain, or appear to bend it."""
    names = search.motion.skeleton.names
    joints = {names[chain.parent], names[chain.child]}
    child = {own.name: own.child for own in search.named}
    errors = [error for error in search.errors() if child[error.chain] == chain.child]
    finders = find_lone_jumps, find_stretches, find_spikes, find_joint_jumps, find_bursts
    shown = (one for find in finders for own in find(search).values() for one in own)
    return errors + [one for one in shown if one.joint in joints]


def _explained_by(others: Sequence[Interval], start: int, stop: int) -> bool:
    """Return True if another error covers most of the frames [start, stop).

    The result is also True if an error begins or ends near the first or the last of these frames.
    """
    return any(
        min(stop, one.stop) - max(start, one.start) > _COVERS * (stop - start)
        or any(
            abs(edge - own) <= _BESIDE for edge in (one.start, one.stop) for own in (start, stop)
        )
        for one in others
    )


def _interval(chain: str, joint: str, start: int, stop: int, back: float, limit: float) -> Interval:
    evidence = {"joint": joint, "backward_deg": back, "limit_deg": limit}
    return Interval(
        chain,
        start,
        stop,
        np.zeros(stop - start),
        open=True,
        residual=math.radians(back),
        explain=partial(dict, evidence),
        kind=Kind.BACKWARD_BEND,
        joint=joint,
    )
