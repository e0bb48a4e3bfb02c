"""Measure quantities of a limb and its neighbours that a correction must not make worse.

They are measured in the frames around the interval. Only a joint's hinge plane is determined from
the rest of the clip.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.correction.joint_repairs import interval_joint_index
from twistcore.analysis.correction.twist_removal import refine
from twistcore.detection.evidence import ChainSignals, usual_bend_side
from twistcore.detection.evidence.judgement import MIDDLE
from twistcore.detection.interval import Interval
from twistcore.detection.lone_jumps import impossibly_fast_mask, possibly_too_fast_mask
from twistcore.skeleton.angles import wrap_degrees
from twistcore.skeleton.body import ancestors
from twistcore.skeleton.chain import Chain, make_chain
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb, bone_lengths, joint_path, limb_middle_and_end_positions
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.own_axis import own_bone_axis, twist_since_previous_frame
from twistcore.skeleton.rotation import Array, multiply, rotate, vector_lengths
from twistcore.work.frozen import dataclass

HINGE, TURNS, ROLL, PATH, ENDS = "hinge", "impossible turns", "next joint's roll", "path", "ends"
NAMES = HINGE, TURNS, ROLL, PATH, ENDS
UNITS = {HINGE: "°", TURNS: "frames", ROLL: "° per frame", PATH: "%", ENDS: "%"}
EXACT = 3.0  # degrees; a joint has an exact hinge if 95 % of a clip is this close to it
TOLERANCE = {HINGE: 1.0, TURNS: 0.0, ROLL: 5.0, PATH: 0.1, ENDS: 0.1}
SHARE = {ROLL: 0.5}  # share of the value before the correction; used as tolerance if it is larger
_LAST = {"Arm": "ForeArm", "UpLeg": "Leg"}  # the second bone of a limb, keyed by its first bone
_BESIDE = 3  # number of frames on either side of an interval that are measured
_BENT = 30.0  # degrees; the hinge of a limb that is bent by less is not measured


@dataclass(frozen=True)
class ProtectedMeasure:
    """A quantity that a correction must not make worse, before and after the correction.

    Attributes
    ----------
    name
        One of NAMES.
    unit
        One of UNITS.
    before, after
        The values before and after the correction.
    worse
        True if the value grew by more than its tolerance.
    joint
        The name, in the skeleton, of the joint at which the value was measured.
    word
        The everyday word for that joint, such as 'elbow'.
    """

    name: str
    unit: str
    before: float
    after: float
    worse: bool
    joint: str
    word: str

    @property
    def growth(self) -> float:
        """The increase of the value, which is negative if the correction improved it."""
        return self.after - self.before

    @property
    def doubt(self) -> str:
        """The reason to doubt the correction, as a clause."""
        if self.name == HINGE:
            return f"the {self.word} would bend {self.growth:.0f}° further out of its hinge plane"
        if self.name == TURNS:
            if self.growth <= 1.0:
                return f"in one more frame, {self.joint} would turn faster than any body can"
            more = f"{self.growth:.0f}"
            return f"in {more} more frames, {self.joint} would turn faster than any body can"
        if self.name == ROLL:
            then, now = (f"{turn:.0f}°" for turn in (self.after, self.before))
            return f"in one frame, the {self.word} would turn by {then} instead of {now}"
        if self.name == PATH:
            share = 100.0 * self.growth / max(self.before, 1e-9)
            return f"the {self.word} would travel a path that is {share:.0f} % longer"
        return f"{self.joint} would move by {self.after:.1f} % of the figure's height"


@dataclass(frozen=True, eq=False)
class Hinges:
    """The joints of a clip that bend in a single plane like a hinge, for example a knee.

    Each hinge is computed when it is first needed.

    Attributes
    ----------
    motion
        The motion.
    finds
        The intervals of the clip. Their frames are not used to determine a hinge.
    known
        Signals that were already computed, keyed by chain name.
    """

    motion: Motion
    finds: Sequence[Interval] = ()
    known: Mapping[str, ChainSignals] = field(default_factory=dict)
    _exact: dict[str, Array | None] = field(default_factory=dict)

    def off(self, chain: Chain) -> Array | None:
        """Return the deviation of a chain's child joint from its hinge plane, degrees, (frames,).

        The result is None if the joint is not an exact hinge, and NaN in frames in which the limb
        is too straight to measure the deviation.
        """
        if chain.name not in self._exact:
            self._exact[chain.name] = self._made(chain)
        return self._exact[chain.name]

    def _made(self, chain: Chain) -> Array | None:
        signals = self.known.get(chain.name)
        if signals is None or signals.frames != self.motion.frames:
            signals = ChainSignals.of(self.motion, chain)
        busy = np.zeros(self.motion.frames, dtype=bool)
        for find in self.finds:
            if find.chain == chain.name:
                busy[max(find.start - 1, 0) : find.stop + 1] = True
        side = usual_bend_side(signals, busy)
        if side is None or side.furthest > EXACT:
            return None
        return np.where(signals.bend > _BENT, side.off, np.nan)


def restrict_interval_to_frames(interval: Interval, frames: NDArray[np.intp]) -> Interval:
    """Restrict an interval to the given frames, which must be in ascending order.

    `start` and `stop` of the result are indices into `frames`. The result is empty if the interval
    contains none of the frames.
    """
    start, stop = np.searchsorted(frames, [interval.start, interval.stop]).tolist()
    return interval.with_offset(start, interval.offset[frames[start:stop] - interval.start])


def protected_measures(
    motion: Motion,
    chains: Iterable[Chain],
    interval: Interval,
    hinges: Hinges | None = None,
    others: Sequence[Interval] = (),
) -> tuple[ProtectedMeasure, ...]:
    """Measure how a correction affects the limb and its neighbours.

    Nothing is measured for an interval that cannot be corrected.

    - *hinge*: mean deviation of the corrected joint from its exact hinge, in frames in which the
      limb is bent by more than 30°. A joint has an exact hinge if 95 % of the clip is within 3° of
      it. Tolerance: 1°.
    - *impossible turns*: number of frames in which a joint of the limb rotates about its own axis
      faster than any body can (:func:`lone_jumps.largest_natural_turn`). Tolerance: none.
    - *next joint's roll*: fastest rotation of the next joint about its own bone, in degrees per
      frame. The next joint is the child for a counter-twist and the limb's end for a flip.
      Tolerance: 5°, or half of the value before the correction.
    - *path*: for a flip, length of the middle joint's path, in % of the limb's length. Tolerance:
      0.1 %.
    - *ends*: movement of a joint that should stay in place, in % of the skeleton's height. Leaf
      joints off the bone, such as helpers, may move. Tolerance: 0.1 %.

    Parameters
    ----------
    motion
        The motion.
    chains
        All chains and limbs of the motion.
    interval
        The interval to correct.
    hinges
        The clip's hinges. Pass the same object for all intervals. By default, the hinges are
        determined from the motion.
    others
        Intervals that are corrected both before and after this correction.
    """
    every = tuple(chains)
    chain = next((c for c in every if c.name == interval.chain), None)
    if chain is not None and interval.kind.info.repairer:
        chain = _bone_of(motion, every, chain, interval)
    nothing = not interval.frames or not interval.correctable
    if chain is None or isinstance(chain, Helper) or nothing:
        return ()
    around = _Around(motion, every, chain, interval, others)
    if not around.changed:
        return ()
    hinges = hinges or Hinges(motion, (interval, *others))
    measured = [
        _off_hinge(around, every, hinges),
        _impossible(around),
        _roll(around),
        _path(around),
        _ends(around),
    ]
    return tuple(m for m in measured if m is not None)


def _bone_of(
    motion: Motion, chains: Sequence[Chain], owner: Chain, interval: Interval
) -> Chain | None:
    """Return a chain that begins at the joint of a single-joint error.

    If none of `chains` does, a chain is created from the joint and its first child with a bone. The
    result is None if there is no such child. `owner` is the chain in which the error is listed.
    """
    skeleton, joint = motion.skeleton, interval_joint_index(motion.skeleton, interval)
    for chain in chains:
        if chain.parent == joint and not isinstance(chain, Limb | Helper):
            return chain
    bones = (
        make_chain(motion, joint, child, side=owner.side) for child in skeleton.children[joint]
    )
    return next((bone for bone in bones if bone is not None), None)


class _Around:
    """The frames around an interval, before and after its correction.

    In arrays of shape (frames, 2, …), the second axis has index 0 for the values before the
    correction and index 1 for the values after it.
    """

    def __init__(
        self,
        motion: Motion,
        chains: Sequence[Chain],
        chain: Chain,
        interval: Interval,
        others: Sequence[Interval],
    ) -> None:
        low, high = max(interval.start - _BESIDE, 0), min(interval.stop + _BESIDE, motion.frames)
        self.low, self.interval, self.chain = low, interval, chain.sliced(low, high)
        self.captured = part = motion.sliced(low, high)
        own = interval.within(low, high)
        self.others = [
            i.within(low, high)
            for i in others
            if i is not interval and i.start < high and i.stop > low
        ]
        needed = {interval.chain, *(i.chain for i in self.others)}
        here = [c.sliced(low, high) for c in chains if c.name in needed]
        before = refine(part, here, self.others) if self.others else part
        after = refine(part, here, [*self.others, own])
        self.changed = not np.array_equal(before.rotations, after.rotations)
        self.both = before, after
        self.skeleton = motion.skeleton
        self.next_joint = chain.grandchild if isinstance(chain, Limb) else chain.child
        self.joints = chain.parent, *joint_path(motion.skeleton, chain.parent, self.next_joint)

    @cached_property
    def own(self) -> Array:
        """Local rotations of the limb's joints, (frames, 2, joints, 4)."""
        return np.stack([m.rotations[:, self.joints] for m in self.both], axis=1)

    @cached_property
    def from_parent(self) -> Array:
        """Rotations of the limb's joints relative to the parent of the first joint.

        The shape is (frames, 2, joints, 4).
        """
        out = self.own.copy()
        for k in range(1, len(self.joints)):
            out[:, :, k] = multiply(out[:, :, k - 1], out[:, :, k])
        return out

    @cached_property
    def in_room(self) -> Array:
        """Global rotations of the limb's joints, (frames, 2, joints, 4)."""
        above = np.zeros((self.captured.frames, 2, 4))
        above[..., 0] = 1.0
        for joint in ancestors(self.skeleton, self.chain.parent)[::-1]:
            own = np.stack([m.rotations[:, joint] for m in self.both], axis=1)
            above = multiply(above, own)
        return multiply(above[:, :, None], self.from_parent)

    @cached_property
    def axes(self) -> Array:
        """The bone axis of each joint, (joints, 3), with zeros for a joint that has none."""
        axes = (own_bone_axis(self.skeleton, joint) for joint in self.joints)
        return np.array([np.zeros(3) if a is None else a for a in axes])

    @cached_property
    def turns(self) -> Array:
        """Rotation angle of each joint about its bone axis since the previous frame, in radians.

        The shape is (frames, 2, joints).
        """
        return twist_since_previous_frame(self.own, self.axes)

    @cached_property
    def places(self) -> list[tuple[Array, Array]]:
        """Positions of the limb's middle joint and end relative to its first joint.

        The list contains a pair (middle joint, end) before and a pair after the correction, in the
        coordinates of the first joint's parent.
        """
        assert isinstance(self.chain, Limb)
        return [limb_middle_and_end_positions(m, self.chain) for m in self.both]

    def measure(self, name: str, before: float, after: float, joint: int) -> ProtectedMeasure:
        """Return a measure at a joint, marked as worse if it grew by more than its tolerance."""
        worse = after > before + max(TOLERANCE[name], SHARE.get(name, 0.0) * before)
        joint_name = self.skeleton.names[joint]
        return ProtectedMeasure(
            name, UNITS[name], before, after, worse, joint_name, self._word(joint)
        )

    def _word(self, joint: int) -> str:
        """Return the everyday word for a joint of the limb, such as 'elbow'."""
        segment = self.chain.segment
        if isinstance(self.chain, Limb):
            if joint == self.chain.child:
                return self.chain.middle_word
            segment = _LAST.get(segment, "")
        return MIDDLE.get(segment, "joint")


def _off_hinge(around: _Around, chains: Sequence[Chain], hinges: Hinges) -> ProtectedMeasure | None:
    """Measure how far the corrected joint deviates from its hinge plane, degrees.

    The result is None if the joint is not an exact hinge or the limb is straight.
    """
    interval = around.interval
    chain = next((c for c in chains if _shows_bend_direction(c, around.next_joint)), None)
    if chain is None or (off := hinges.off(chain)) is None:
        return None
    there = np.abs(interval.offset) > 0.5 * abs(interval.largest)
    off = off[interval.start : interval.stop]
    there &= np.isfinite(off)
    if not there.any():
        return None
    inside = slice(interval.start - around.low, interval.stop - around.low)
    here = chain.sliced(around.low, around.low + around.captured.frames)
    azimuth = [
        ChainSignals.of(m, here).azimuth[inside][there] for m in (around.captured, *around.both)
    ]
    before, after = (
        float(np.sqrt(np.mean(wrap_degrees(off[there] + a - azimuth[0]) ** 2))) for a in azimuth[1:]
    )
    return around.measure(HINGE, before, after, around.next_joint)


def _shows_bend_direction(chain: Chain, joint: int) -> bool:
    """Return True if a chain's signals contain the direction in which the joint bends."""
    return not isinstance(chain, Limb | Helper) and chain.child == joint and chain.grandchild >= 0


def _impossible(around: _Around) -> ProtectedMeasure:
    """Count the frames in which a joint of the limb rotates faster than any body can."""
    counts, fps = np.zeros((2, len(around.joints)), dtype=int), around.captured.fps
    if possibly_too_fast_mask(around.turns, fps).any():  # a quick check that rarely finds anything
        in_room = twist_since_previous_frame(around.in_room, around.axes)
        counts = impossibly_fast_mask(in_room, around.turns, fps).sum(axis=0)
    before, after = counts.sum(axis=1).tolist()
    joint = around.joints[int(np.argmax(counts[1] - counts[0]))]
    return around.measure(TURNS, float(before), float(after), joint)


def _roll(around: _Around) -> ProtectedMeasure | None:
    """Measure the fastest rotation of the next joint about its own bone, degrees per frame.

    The rotation is relative to the joint's parent.
    """
    if not around.axes[-1].any():
        return None
    before, after = np.degrees(np.abs(around.turns[:, :, -1]).max(axis=0)).tolist()
    return around.measure(ROLL, before, after, around.next_joint)


def _path(around: _Around) -> ProtectedMeasure | None:
    """Measure the length of the middle joint's path, % of the limb's length.

    Positions are relative to the first joint, in the coordinates of its parent. The result is None
    for a chain, because only limbs have a middle joint.
    """
    if not isinstance(limb := around.chain, Limb):
        return None
    whole = sum(bone_lengths(around.captured, limb))
    before, after = (
        100.0 * float(vector_lengths(np.diff(child, axis=0)).sum()) / whole
        for child, _ in around.places
    )
    return around.measure(PATH, before, after, limb.child)


def _ends(around: _Around) -> ProtectedMeasure | None:
    """Measure the movement of joints that should stay in place, % of the skeleton's height."""
    chain, skeleton, kind = around.chain, around.skeleton, around.interval.kind
    largest: dict[int, float] = {}
    turning: Sequence[int] = around.joints
    if isinstance(chain, Limb):
        (_, before), (_, after) = around.places
        largest[chain.end] = float(vector_lengths(after - before).max())
        turning = () if around.interval.carried else (chain.end,)
    elif kind.info.repairer and not kind.by_angle:
        return None  # all joints below are meant to move
    elif kind.info.repairer and around.interval.carried:
        turning = (chain.parent,)
    for joint in turning:
        q = around.from_parent[:, :, around.joints.index(joint)]
        for child in skeleton.children[joint]:
            place = around.captured.translation(child)
            if place.any() and (joint != chain.parent or _carries(skeleton, child, chain)):
                ends = rotate(q, place if place.ndim == 1 else place[:, None])
                moved = vector_lengths(ends[:, 1] - ends[:, 0])
                largest[child] = float(moved.max())
    joint = max(largest, key=lambda j: largest[j], default=chain.child)
    share = 100.0 * largest.get(joint, 0.0) / skeleton.height
    return around.measure(ENDS, 0.0, share, joint)


def _carries(skeleton: Skeleton, joint: int, chain: Chain) -> bool:
    """Return True if `joint`, a child of the chain's parent joint, should stay in place.

    A leaf joint other than the chain's child is only a helper, and may move.
    """
    return joint == chain.child or bool(skeleton.children[joint])
