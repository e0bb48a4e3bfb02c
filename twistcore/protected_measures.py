"""What a correction must not make worse: measured on the limb and its neighbours, before and after.

Five measures that need no eye. Each is taken in the frames around the interval alone, but for the
hinge, which the rest of the clip tells.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from twistcore.body import ancestors
from twistcore.chain import Chain
from twistcore.detection.evidence import Witnesses, usual_side
from twistcore.detection.evidence.witnesses import wrapped
from twistcore.detection.interval import Interval
from twistcore.detection.lone_jumps import may_be_too_fast, own_axis, too_fast, turns_about
from twistcore.helper import Helper
from twistcore.limb import Limb, bones, path, places
from twistcore.motion import Motion
from twistcore.rotation import Array, multiply, rotate
from twistcore.twist_removal import refine

HINGE, TURNS, ROLL, PATH, ENDS = "hinge", "impossible turns", "next joint's roll", "path", "ends"
NAMES = HINGE, TURNS, ROLL, PATH, ENDS
UNITS = {HINGE: "°", TURNS: "frames", ROLL: "° a frame", PATH: "%", ENDS: "%"}
EXACT = 3.0  # degrees within which 95 % of a clip is on a joint's hinge
TOLERANCE = {HINGE: 1.0, TURNS: 0.0, ROLL: 5.0, PATH: 0.1, ENDS: 0.1}
SHARE = {ROLL: 0.5}  # of what it was before: where that is more than the tolerance
_BESIDE = 3  # frames on either side of an interval
_BENT = 30.0  # degrees: below it a straight limb is told by its course, not by its hinge


@dataclass(frozen=True)
class Measure:
    """One measure of one correction.

    name: one of NAMES; unit: of UNITS; before, after: as captured and corrected; worse: whether it
    grew by more than its tolerance; joint: where it was measured, by the skeleton's name.
    """

    name: str
    unit: str
    before: float
    after: float
    worse: bool
    joint: str

    @property
    def growth(self) -> float:
        """By how much it got worse; negative where it got better."""
        return self.after - self.before


@dataclass(frozen=True, eq=False)
class Hinges:
    """The sides to which the joints of a clip bend, made when first asked for.

    motion: of the clip; finds: all its intervals, whose frames say nothing of a hinge; known:
    signals of chains that were made before.
    """

    motion: Motion
    finds: Sequence[Interval] = ()
    known: Mapping[str, Witnesses] = field(default_factory=dict)
    _exact: dict[str, Array | None] = field(default_factory=dict)

    def off(self, chain: Chain) -> Array | None:
        """How far a joint is off its hinge, degrees, (frames,); None where it has no exact one.

        NaN where the limb is too straight to show it.
        """
        if chain.name not in self._exact:
            self._exact[chain.name] = self._made(chain)
        return self._exact[chain.name]

    def _made(self, chain: Chain) -> Array | None:
        signals = self.known.get(chain.name)
        if signals is None or signals.frames != self.motion.frames:
            signals = Witnesses.of(self.motion, chain)
        busy = np.zeros(self.motion.frames, dtype=bool)
        for find in self.finds:
            if find.chain == chain.name:
                busy[max(find.start - 1, 0) : find.stop + 1] = True
        side = usual_side(signals, busy)
        if side is None or side.furthest > EXACT:
            return None
        return np.where(signals.bend > _BENT, side.off, np.nan)


def protected_measures(
    motion: Motion,
    chains: Iterable[Chain],
    interval: Interval,
    hinges: Hinges | None = None,
    others: Sequence[Interval] = (),
) -> tuple[Measure, ...]:
    """What a correction changes in the limb and its neighbours.

    Measured, with how much of it is not yet worse:

    - *hinge*: how far the joint that is turned is off its exact hinge, in the mean over the frames
      in which the limb is bent by more than 30°; only where 95 % of the clip is within 3° of one.
      Not yet worse by 1°.
    - *impossible turns*: frames in which a joint of the limb turns about its own axis faster than
      any body does (:func:`lone_jumps.limit`). Not one more.
    - *next joint's roll*: the fastest turn of the joint below about its own bone, degrees a frame:
      of C after a counter-twist, of the limb's end after a flip. 5° more, or half as much again.
    - *path*: of a flip, the length of the middle joint's path, % of the limb. 0.1 % more.
    - *ends*: how far a joint moves that should stay, % of the skeleton's height. 0.1 %.

    chains: of the motion, limbs among them; hinges: made once a clip for all its corrections, else
    from the motion alone; others: what is corrected as well, before and after. Nothing is measured
    of what cannot be corrected.
    """
    every = tuple(chains)
    chain = next((c for c in every if c.name == interval.chain), None)
    if chain is None or isinstance(chain, Helper) or not interval.repairable:
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


class _State:
    """A limb in the frames around an interval, as captured or as corrected."""

    def __init__(self, motion: Motion, chain: Chain) -> None:
        self.motion, self.chain = motion, chain

    def own(self, joint: int) -> Array:
        """Rotations of a joint in its parent's frame, (frames, 4)."""
        return self.motion.rotations[:, joint]

    @cached_property
    def from_above(self) -> dict[int, Array]:
        """Rotations of P and the joints down to C or a limb's end, in the frame P hangs in."""
        first, *below = _joints_of(self.chain, self.motion)
        out = {first: self.own(first)}
        for joint, above in zip(below, (first, *below), strict=False):
            out[joint] = multiply(out[above], self.own(joint))
        return out

    @cached_property
    def _above(self) -> Array:
        """Rotations in the room of the joint that P hangs on, (frames, 4)."""
        q = np.broadcast_to(np.array([1.0, 0.0, 0.0, 0.0]), (self.motion.frames, 4))
        for joint in ancestors(self.motion.skeleton, self.chain.parent)[::-1]:
            q = multiply(q, self.own(joint))
        return q

    def impossible(self, joint: int, axis: Array) -> int:
        """Frames in which a joint turns about its axis faster than any body does."""
        own = turns_about(self.own(joint), axis)
        if not may_be_too_fast(own, self.motion.fps).any():  # which is the rule, and soon known
            return 0
        in_room = turns_about(multiply(self._above, self.from_above[joint]), axis)
        return int(too_fast(in_room, own, self.motion.fps).sum())

    @cached_property
    def places(self) -> tuple[Array, Array]:
        """Where a limb's C and E are from P, in the frame of P's parent."""
        assert isinstance(self.chain, Limb)
        return places(self.motion, self.chain)


class _Around:
    """The frames around an interval, as captured and corrected."""

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
        own = _within(interval, low, high)
        self.others = [
            _within(i, low, high)
            for i in others
            if i is not interval and i.start < high and i.stop > low
        ]
        needed = {interval.chain, *(i.chain for i in self.others)}
        here = [c.sliced(low, high) for c in chains if c.name in needed]
        before = refine(part, here, self.others) if self.others else part
        after = refine(part, here, [*self.others, own])
        self.changed = not np.array_equal(before.rotations, after.rotations)
        self.before, self.after = _State(before, self.chain), _State(after, self.chain)
        self.next_joint = chain.grandchild if isinstance(chain, Limb) else chain.child

    @property
    def both(self) -> tuple[_State, _State]:
        """As captured, and corrected."""
        return self.before, self.after

    def measure(self, name: str, before: float, after: float, joint: int) -> Measure:
        """What was measured at a joint, with whether it is worse."""
        worse = after > before + max(TOLERANCE[name], SHARE.get(name, 0.0) * before)
        joint_name = self.before.motion.skeleton.names[joint]
        return Measure(name, UNITS[name], before, after, worse, joint_name)


def _within(interval: Interval, low: int, high: int) -> Interval:
    """The part of an interval in frames [low, high), counted from low."""
    start, stop = max(interval.start, low), min(interval.stop, high)
    offset = interval.offset[start - interval.start : stop - interval.start]
    return interval.with_offset(start - low, offset)


def _off_hinge(around: _Around, chains: Sequence[Chain], hinges: Hinges) -> Measure | None:
    """Degrees by which the joint that is turned is off its exact hinge, while the limb is bent."""
    interval = around.interval
    chain = next((c for c in chains if _turns_in(c, around.next_joint)), None)
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
        Witnesses.of(m, here).azimuth[inside][there]
        for m in (around.captured, *(s.motion for s in around.both))
    ]
    before, after = (
        float(np.sqrt(np.mean(wrapped(off[there] + a - azimuth[0]) ** 2))) for a in azimuth[1:]
    )
    return around.measure(HINGE, before, after, around.next_joint)


def _turns_in(chain: Chain, joint: int) -> bool:
    """Whether a chain shows to which side a joint bends."""
    return not isinstance(chain, Limb | Helper) and chain.child == joint and chain.grandchild >= 0


def _impossible(around: _Around) -> Measure:
    """Frames in which a joint of the limb turns about its own axis faster than any body does."""
    motion = around.before.motion
    counts: dict[int, tuple[int, int]] = {}
    for joint in around.before.from_above:
        if (axis := own_axis(motion.skeleton, joint)) is not None:
            before, after = (s.impossible(joint, axis) for s in around.both)
            counts[joint] = before, after
    joint = max(counts, key=lambda j: counts[j][1] - counts[j][0], default=around.chain.parent)
    sums = [float(sum(n)) for n in zip((0, 0), *counts.values(), strict=True)]
    return around.measure(TURNS, sums[0], sums[1], joint)


def _roll(around: _Around) -> Measure | None:
    """The fastest turn of the next joint about its own bone, in its parent's frame."""
    joint = around.next_joint
    axis = own_axis(around.before.motion.skeleton, joint)
    if axis is None:
        return None
    before, after = (
        float(np.degrees(np.abs(turns_about(s.own(joint), axis)).max())) for s in around.both
    )
    return around.measure(ROLL, before, after, joint)


def _path(around: _Around) -> Measure | None:
    """The length of the middle joint's path in the frame of the limb's parent, % of the limb."""
    if not isinstance(limb := around.chain, Limb):
        return None
    whole = sum(bones(around.before.motion, limb))
    before, after = (
        100.0 * float(np.linalg.norm(np.diff(s.places[0], axis=0), axis=1).sum()) / whole
        for s in around.both
    )
    return around.measure(PATH, before, after, limb.child)


def _ends(around: _Around) -> Measure:
    """How far a joint moves that the correction should leave in its place, % of the height."""
    chain, motion = around.chain, around.before.motion
    moved: dict[int, Array] = {}
    turning: tuple[int, ...]
    if isinstance(chain, Limb):
        last = chain.end
        moved[last] = around.after.places[1] - around.before.places[1]
        turning = () if around.interval.carried else (last,)
    else:
        turning = chain.parent, chain.child
    for joint in turning:
        now, then = (s.from_above[joint] for s in around.both)
        for child in motion.skeleton.children[joint]:
            place = np.broadcast_to(motion.translation(child), (motion.frames, 3))
            moved[child] = rotate(then, place) - rotate(now, place)
    largest = {j: float(np.linalg.norm(v, axis=1).max()) for j, v in moved.items()}
    joint = max(largest, key=lambda j: largest[j], default=chain.child)
    share = 100.0 * largest.get(joint, 0.0) / motion.skeleton.height
    return around.measure(ENDS, 0.0, share, joint)


def _joints_of(chain: Chain, motion: Motion) -> tuple[int, ...]:
    """P, what is between, and C; of a limb down to its end."""
    last = chain.grandchild if isinstance(chain, Limb) else chain.child
    return chain.parent, *path(motion.skeleton, chain.parent, last)
