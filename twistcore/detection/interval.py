"""An interval in which a joint's rotation is wrong."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from twistcore.detection.kind import Kind
from twistcore.skeleton.medians import median
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

__all__ = ["Interval", "Kind", "circular_median"]


@dataclass(frozen=True, eq=False)
class Interval:
    """Frames [start, stop) in which P of a chain or limb has an error, which is given per frame.

    Parameters
    ----------
    chain : str
        Name of the chain or limb.
    start, stop : int
        Frames from 0; `stop` is exclusive.
    offset : ndarray, shape (stop − start,)
        The angle to remove from P's twist, or from its turn about the limb's line, radians.
    confidence : float, optional
        The probability that the interval is right, 0…1; None if the detector has none.
    open : bool
        True if the frames outside the interval may be the wrong ones, or if only one joint is
        wrong. Such an interval is not corrected automatically.
    residual : float
        The offset that remains after the closing edge, the turn of a lone jump or of a single
        joint, or σ of a noise burst, radians.
    explain : callable, optional
        Function that returns the evidence; called only when a person asks for it.
    kind : Kind
        The kind of error.
    carried : bool
        True for a limb flip in which E turned with P, for every carried roll, in which C rolled
        with P, and for an error of a single joint in which the joints below turned with it.
    joint : str
        The name of the joint that is wrong alone, is the noisiest, or begins a frozen limb.
    followed : float
        The fraction of the offset that C turned back; less than 1 only if it clearly turned back
        only a part.

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
        """The evidence, keyed by name, as numbers, texts and lists for JSON; angles in degrees."""
        return self.explain() if self.explain else None

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for another process, with the evidence instead of the analysis."""
        computed = "as_written", "for_review"
        own = {name: value for name, value in vars(self).items() if name not in computed}
        evidence = self.evidence
        return {**own, "explain": evidence and partial(dict, evidence)}

    @cached_property
    def as_written(self) -> Interval:
        """The interval with its offset rounded as in files: nine decimals of a degree, no −0.0.

        The result is cached on the interval, because dragging τ mostly returns the same objects. A
        separate table would keep them alive after their clip is closed, since `explain` refers to
        the clip.
        """
        offset = self.offset
        one = (
            offset[:1] if offset.strides == (0,) else offset
        )  # only one value of a constant offset, as in files
        degrees = np.round(np.degrees(wrap(one)), 9) + 0.0
        return replace(self, offset=np.broadcast_to(np.radians(degrees), offset.shape))

    @cached_property
    def for_review(self) -> Interval:
        """The interval as a review stores it, with the offset to remove if a person accepts it.

        For a kind that only a person can correct, the detection has no offset, so that nothing
        corrects it automatically. Its offset is `correction_deg` of the evidence, or the residual.
        """
        if not self.kind.info.repairer:
            return self.as_written
        degrees = (self.evidence or {}).get("correction_deg")
        turn = self.residual if degrees is None else math.radians(degrees)
        return replace(self, offset=np.broadcast_to(turn, (self.frames,))).as_written

    @property
    def frames(self) -> int:
        """The number of frames of the interval."""
        return self.stop - self.start

    @property
    def delta(self) -> float:
        """The circular median of the offset, radians in (−π, π]."""
        return circular_median(self.offset)

    @property
    def size(self) -> float:
        """The angle for tables in radians: the median offset, a lone jump's turn, or σ of noise."""
        return self.delta if self.correctable or not self.kind.known else self.residual

    @property
    def largest(self) -> float:
        """The offset with the largest size, with its sign, in radians, or 0 without frames."""
        return float(self.offset[np.abs(self.offset).argmax()]) if len(self.offset) else 0.0

    @property
    def soft_ended(self) -> bool:
        """True if a counter-twist's offset is below a quarter of its maximum at either end."""
        if self.kind != Kind.COUNTER_TWIST or not len(self.offset):
            return False
        return bool(np.abs(self.offset[[0, -1]]).min() < 0.25 * abs(self.largest))

    @property
    def shown(self) -> float:
        """The angle to show to people: `size`, or the largest offset if that describes it better.

        The median of a ramp or a drift depends on how much of its ends is included, and an offset
        in both directions may have a median near 0.
        """
        twist = self.kind == Kind.COUNTER_TWIST
        both_ways = twist and abs(self.size) < 0.5 * abs(self.largest)
        return self.largest if both_ways or self.soft_ended else self.size

    def angle_text(self, digits: int) -> str:
        """Return `shown` as text, such as '+90.0°', '±8.0°' for noise, or '–' for frozen frames."""
        if not (sign := self.kind.info.sign):
            return "–"
        degrees = f"{math.degrees(self.shown):+.{digits}f}°"
        return degrees.replace("+", sign)

    @property
    def seen_at(self) -> int:
        """The first frame in which the offset is at least half of the largest offset."""
        there = np.flatnonzero(np.abs(self.offset) >= 0.5 * abs(self.largest))
        return self.start + (int(there[0]) if len(there) else 0)

    @property
    def repairable(self) -> bool:
        """True for a twist error that can be corrected."""
        return self.kind.repairable

    @property
    def correctable(self) -> bool:
        """True if accepting the interval changes the motion.

        In reviews of earlier versions, errors of a single joint have no offset: a person who
        accepted one has only seen it.
        """
        return self.repairable or (self.kind.correctable and bool(self.offset.any()))

    @property
    def automatic(self) -> bool:
        """True if the kind of error may be corrected without a person's decision."""
        return self.repairable and self.kind.info.automatic

    def may_be_same(self, other: Interval) -> bool:
        """True if both have the same chain and kind, and the same joint if a single joint is
        wrong.
        """
        same = (self.chain, self.kind) == (other.chain, other.kind)
        return same and (self.joint == other.joint or not self.kind.info.repairer)

    def with_offset(self, start: int, offset: Array) -> Interval:
        """Return the interval with another start and offset."""
        return replace(self, start=start, stop=start + len(offset), offset=offset)

    def within(self, low: int, high: int) -> Interval:
        """Return the part in frames [low, high), with frame numbers relative to `low`."""
        start, stop = max(self.start, low), min(self.stop, high)
        return self.with_offset(start - low, self.offset[start - self.start : stop - self.start])


def circular_median(angles: Array) -> float:
    """Return the circular median of angles (n,), radians in (−π, π], or 0 if there are none."""
    if len(angles) == 0:
        return 0.0
    centre = np.angle(np.exp(1j * angles).sum()) if len(angles) > 1 else angles[0]
    return float(wrap(centre + median(wrap(angles - centre))))
