"""A review to try commands on: the walk with eight errors, by the paper's detector, and flips."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from hypothesis import strategies as st

from tests.conftest import ASSETS
from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection import Interval, Kind
from twistcore.detection.interval_offsets import (
    new_constant_offset_interval,
    resized_interval,
    with_offset_of_size,
)
from twistcore.detection.limb_flips import LimbFlips
from twistcore.detection.limb_flips import analyse_limbs as known
from twistcore.formats.bvh import read_bvh
from twistcore.review import (
    Annotate,
    CarryOver,
    Decide,
    Decision,
    Edit,
    Insert,
    LeaveOut,
    Redetect,
    Review,
    Sign,
    start_review,
)
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.limb import find_limbs
from twistcore.skeleton.own_axis import own_bone_axis
from twistcore.skeleton.rotation import multiply, quaternion_from_axis_angle

CLIP = read_bvh(ASSETS / "walk_injected.bvh")
CHAINS = find_chains(CLIP.motion)
LIMBS = find_limbs(CLIP.motion, CHAINS)
TAU = {c.name: np.radians(5.0) for c in CHAINS}


@cache
def _analysis(*names):
    """Of the clip with these chains alone, or all: found once, for the hundreds of reviews."""
    return analyse(CLIP.motion, [c for c in CHAINS if c.name in names or not names])


def fresh():
    found = _analysis().detect(tau_radians=TAU)
    return Review(start_review("paper", TAU, found, [c.name for c in CHAINS]))


@dataclass(frozen=True)
class FoundFlips:
    """A detector of flips that always finds the same; as `analyse_limbs` makes one."""

    found: tuple[Interval, ...]
    limbs: Mapping[str, LimbFlips] = field(default_factory=dict)

    def automatic_tau(self, limb):
        return 0.5

    def strength(self, limb):
        return np.full(CLIP.motion.frames, 0.25)

    def intervals(self, limb, tau):
        return tuple(i for i in self.found if i.chain == limb and tau < i.delta)


def flip(limb="RightUpLeg-RightFoot", start=100, stop=108, degrees=170.0, **more):
    """A flip of a limb of the walk, of one offset."""
    offset = np.full(stop - start, np.radians(degrees))
    more = {"kind": Kind.LIMB_FLIP, "confidence": 0.97, **more}
    return Interval(limb, start, stop, offset, **more)


CARRIED = flip("LeftUpLeg-LeftFoot", 200, 206, 160.0, carried=True)


def flipped(motion, *flips):
    """The motion with these flips put in."""
    return refine(motion, LIMBS, [replace(i, offset=-i.offset) for i in flips])


def spun(joint, start, stop, degrees, motion, axis=None):
    """The motion in which a joint alone is turned, about its bone or an axis, in some frames."""
    at = motion.skeleton.index(joint)
    axis = own_bone_axis(motion.skeleton, at) if axis is None else axis
    turn = quaternion_from_axis_angle(axis, np.radians(degrees))
    rotations = motion.rotations.copy()
    rotations[start:stop, at] = multiply(rotations[start:stop, at], turn)
    return motion.with_rotations(rotations)


def find_flips(monkeypatch, *found):
    """Let every analysis find these flips; the list that comes back grows with each one made.

    What taking out a flip that is none makes jump is not told, nor what it makes worse.
    """
    made = []

    def analyse_limbs(motion, limbs, tell=None):
        made.append([limb.name for limb in limbs])
        return FoundFlips(found, known(motion, limbs).limbs)

    monkeypatch.setattr("twistcore.detection.stretches.find_stretches", lambda _: {})

    def lone_jumps(motion, chains, *_refined):
        return {chain.name: () for chain in chains}

    monkeypatch.setattr("twistcore.analysis.clip_analysis.analyse_limbs", analyse_limbs)
    monkeypatch.setattr("twistcore.analysis.clip_analysis.protected_measures", lambda *_: ())
    monkeypatch.setattr("twistcore.detection.lone_jumps.lone_jumps", lone_jumps)
    return made


BY = st.sampled_from(["", "me"])


def redetect(chain, degrees, drag=0):
    tau = float(np.radians(degrees))
    return Redetect({chain: tau}, _analysis(chain).detect(tau_radians=tau), drag=drag)


def signing(state):
    ids = st.sampled_from([j.id for j in state.intervals])
    return st.builds(Sign, st.tuples(ids, ids), st.sampled_from(["me", "you"]))


def commands(state):
    ids = st.sampled_from([j.id for j in state.intervals])
    return st.one_of(
        st.builds(Decide, st.tuples(ids), st.sampled_from(list(Decision)), BY),
        st.builds(
            Decide,
            st.tuples(ids),
            st.just(Decision.REJECTED),
            BY,
            reason=st.text(max_size=3),
        ),
        st.builds(Annotate, ids, st.text(max_size=8), st.text(max_size=3)),
        st.builds(
            lambda i, grow: Edit(
                i,
                resized_interval(
                    state.find(i).interval,
                    state.find(i).interval.start,
                    state.find(i).interval.stop + grow,
                ),
            ),
            ids,
            st.integers(0, 5),
        ),
        st.builds(
            lambda i, d: Edit(i, with_offset_of_size(state.find(i).interval, d)),
            ids,
            st.floats(-3, 3),
        ),
        st.builds(
            lambda s: Insert(new_constant_offset_interval("LeftArm", s, s + 4, 0.5)),
            st.integers(0, 300),
        ),
        st.builds(lambda s: LeaveOut(((s, s + 9), (s + 5, 340))), st.integers(0, 300)),
        st.just(CarryOver(fresh().state.intervals[:3])),
        st.builds(redetect, st.sampled_from(["LeftForeArm", "RightUpLeg"]), st.floats(0.5, 150)),
    )
