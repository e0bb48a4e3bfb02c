"""An interval in which a joint's rotation is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from twistcore.detection.kind import Kind
from twistcore.skeleton.angles import circular_median
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

__all__ = ["Interval", "Kind", "circular_median", "create_interval_without_offset"]


@dataclass(frozen=True, eq=False)
class Interval:
    """Frames [start, stop) in which a chain or limb has an error.

    Parameters
    ----------
    chain : str
        The name of the chain or limb.
    start, stop : int
        The first frame, counted from 0, and the frame after the last one.
    offset : ndarray, shape (stop − start,)
        The wrong angle in each frame, radians, by which the parent joint is twisted or, in a limb
        flip, the limb is rotated about the line between its ends. 0 for kinds without an offset.
    confidence : float, optional
        The probability that the correction is right, 0…1; None if the detector does not compute it.
    open : bool
        True if the frames outside the interval may be the wrong ones, or if only one joint is
        wrong. Such an interval is not corrected automatically.
    residual : float
        The offset that remains after the last edge, radians. For kinds without an offset, the
        rotation angle of the joint, or σ of a noise burst.
    explain : callable, optional
        Function that returns the evidence. It is called only when the evidence is needed.
    kind : Kind
        The kind of error.
    carried : bool
        True if the joints below rotated with the error: for a limb flip in which the end joint
        rotated with the limb, for every carried roll, and for some errors of a single joint.
    joint : str
        The name of the wrong joint if only one joint is wrong, of the noisiest joint of a noise
        burst, or of the first joint of a frozen limb.
    followed : float
        The fraction of the offset that the child compensates. This is 1 unless the child clearly
        compensates only a part.

    Examples
    --------
    >>> import numpy as np
    >>> import twistcore as tc
    >>> tc.Interval("LeftArm", 100, 120, np.radians(np.full(20, 90.0)))
    <Interval LeftArm 100–120: +90.0°>
    >>> interval = tc.detect(tc.read_clip("assets/walk_injected.bvh"))[0]
    >>> interval.frames, round(float(np.degrees(interval.delta)), 1), interval.kind.value
    (16, -20.8, 'counter-twist')
    """

    chain: str
    start: int
    stop: int
    offset: Array
    confidence: float | None = None
    open: bool = False
    residual: float = 0.0
    explain: Callable[[], dict[str, Any]] | None = None
    kind: Kind = Kind.COUNTER_TWIST
    carried: bool = False
    joint: str = ""
    followed: float = 1.0

    def __repr__(self) -> str:
        sure = "" if self.confidence is None else f", confidence {self.confidence:.2f}"
        turn = f"{math.degrees(self.shown):+.1f}°{sure}{', open' if self.open else ''}"
        turn += "" if self.kind == Kind.COUNTER_TWIST else f", {self.kind}"
        return f"<Interval {self.chain} {self.start}–{self.stop}: {turn}>"

    @property
    def evidence(self) -> dict[str, Any] | None:
        """The evidence, keyed by name and ready for JSON, with angles in degrees, or None."""
        return self.explain() if self.explain else None

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling, with evidence that no longer refers to the analysis."""
        computed = "as_written", "for_review"
        own = {name: value for name, value in vars(self).items() if name not in computed}
        evidence = self.evidence
        return {**own, "explain": evidence and partial(dict, evidence)}

    @cached_property
    def as_written(self) -> Interval:
        """The interval with its offset rounded as in files: nine decimals of a degree, no −0.0.

        The result is cached in the interval, because a detector returns mostly the same intervals
        while a user drags τ. A separate cache would keep intervals, and the clip to which their
        `explain` refers, in memory after the clip is closed.
        """
        offset = self.offset
        one = (
            offset[:1] if offset.strides == (0,) else offset
        )  # one value is enough for a constant offset
        degrees = np.round(np.degrees(wrap(one)), 9) + 0.0
        return replace(self, offset=np.broadcast_to(np.radians(degrees), offset.shape))

    @cached_property
    def for_review(self) -> Interval:
        """The interval as stored in a review, with the offset to remove if a person accepts it.

        For kinds that are corrected only if a person accepts them, a detected interval has an
        offset of 0, so it is not corrected automatically. In a review, its offset is the value
        `correction_deg` of the evidence, or `residual` if there is no such value.
        """
        if not self.kind.info.repairer:
            return self.as_written
        degrees = (self.evidence or {}).get("correction_deg")
        turn = self.residual if degrees is None else math.radians(degrees)
        return replace(self, offset=np.broadcast_to(turn, (self.frames,))).as_written

    @property
    def frames(self) -> int:
        """The number of frames in the interval."""
        return self.stop - self.start

    @property
    def delta(self) -> float:
        """The circular median of the offset, radians in (−π, π]."""
        return circular_median(self.offset)

    @property
    def size(self) -> float:
        """The angle shown in tables, in radians.

        This is the median offset if the interval is correctable, and `residual` if not.
        """
        return self.delta if self.correctable or not self.kind.known else self.residual

    @property
    def largest(self) -> float:
        """The offset with the largest magnitude, in radians, or 0 if there are no frames."""
        return float(self.offset[np.abs(self.offset).argmax()]) if len(self.offset) else 0.0

    @property
    def soft_ended(self) -> bool:
        """True for a counter-twist that begins or ends gradually.

        This means that its first or last offset is less than a quarter of its largest offset.
        """
        if self.kind != Kind.COUNTER_TWIST or not len(self.offset):
            return False
        return bool(np.abs(self.offset[[0, -1]]).min() < 0.25 * abs(self.largest))

    @property
    def shown(self) -> float:
        """The angle to display, in radians: `size`, or `largest` if `size` is misleading.

        The median of a gradually changing offset depends on where the interval ends, and the median
        of an offset in both directions may be near 0.
        """
        twist = self.kind == Kind.COUNTER_TWIST
        both_ways = twist and abs(self.size) < 0.5 * abs(self.largest)
        return self.largest if both_ways or self.soft_ended else self.size

    def angle_text(self, digits: int) -> str:
        """Return `shown` as a string such as '+90.0°'. `digits` is the number of decimal places.

        The string has the form '±8.0°' for a kind without a direction, such as noise, and is '–'
        for frozen frames.
        """
        if not (sign := self.kind.info.sign):
            return "–"
        degrees = f"{math.degrees(self.shown):+.{digits}f}°"
        return degrees.replace("+", sign)

    @property
    def seen_at(self) -> int:
        """The first frame in which the offset is at least nine tenths of the largest offset."""
        there = np.flatnonzero(np.abs(self.offset) >= 0.9 * abs(self.largest))
        return self.start + (int(there[0]) if len(there) else 0)

    @property
    def repairable(self) -> bool:
        """True if the interval is a twist error of a kind that can be corrected."""
        return self.kind.repairable

    @property
    def correctable(self) -> bool:
        """True if the motion changes when a person accepts the interval.

        In reviews from earlier versions, single-joint errors have no offset, and accepting them
        does not change the motion.
        """
        return self.repairable or (self.kind.correctable and bool(self.offset.any()))

    @property
    def automatic(self) -> bool:
        """True if intervals of this kind may be corrected without a person's decision."""
        return self.repairable and self.kind.info.automatic

    def may_be_same(self, other: Interval) -> bool:
        """Return True if another interval may describe the same error.

        The two intervals must have the same chain and kind. For single-joint errors, the joint must
        also be the same.
        """
        same = (self.chain, self.kind) == (other.chain, other.kind)
        return same and (self.joint == other.joint or not self.kind.info.repairer)

    def with_offset(self, start: int, offset: Array) -> Interval:
        """Return a copy with a different start and offset. `stop` is set to match the offset."""
        return replace(self, start=start, stop=start + len(offset), offset=offset)

    def within(self, low: int, high: int) -> Interval:
        """Return the part of the interval in frames [low, high).

        Its frame numbers are relative to `low`.
        """
        start, stop = max(self.start, low), min(self.stop, high)
        return self.with_offset(start - low, self.offset[start - self.start : stop - self.start])


def create_interval_without_offset(
    kind: Kind, chain: str, start: int, stop: int, residual: float, evidence: dict[str, Any]
) -> Interval:
    """Return an open interval without an offset. `residual` is in radians.

    The item 'joint' of `evidence` is the name of the joint that has the error.
    """
    return Interval(
        chain,
        start,
        stop,
        np.zeros(stop - start),
        open=True,
        residual=residual,
        explain=partial(dict, evidence),
        kind=kind,
        joint=evidence["joint"],
    )
