"""The reason why a frame has no interval, as a keyword and as a sentence with numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

from twistcore.detection import Interval
from twistcore.detection.lone_jumps import largest_natural_turn
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.notation import DistinctFrames


class Why(StrEnum):
    """Keywords for the reasons why no interval begins or ends at a frame, as stored in files."""

    INTERVAL = "interval"  # the frame is in an interval or next to one
    MOVED = "moved"  # the detector found an interval here, but the review moved it
    BELOW = "below tau"
    CUT = "cut"  # all joints jump in the same frame, at a T-pose or a cut
    SHORT = "short piece"  # there are too few frames between two cuts
    IMAGE = "image"  # an error of another chain or limb rotates a joint of this one
    ONE_JOINT = "one joint"
    UNEQUAL = "unequal"  # both joints rotate, but the rotations do not cancel
    MOTION = "motion"  # natural motion explains the rotations
    NO_PARTNER = "no partner"
    OTHER = "other interval"  # the jump's partner belongs to another interval, which explains more


_FRAMES = ("start", "stop", "partner")  # names of the numbers that are frames

# Reasons that are already certain or whose cause is elsewhere, so that nobody needs to check the
# frame.
_SETTLED = frozenset({Why.INTERVAL, Why.MOVED, Why.BELOW, Why.CUT, Why.SHORT, Why.IMAGE})


# A function that returns the intervals of other chains that have an edge in frames [start, stop)
# and rotate a joint of this chain.
EdgesIn = Callable[[int, int], Sequence[tuple[Interval, Chain]]]


@dataclass(frozen=True)
class Reason:
    """The reason why no interval begins or ends at a frame of a chain or limb.

    Parameters
    ----------
    chain, frame
        Name of the chain or limb, and the frame, from 0.
    why
        The keyword.
    strength, tau
        Strength at the frame, and threshold τ, radians.
    text
        The sentence.
    numbers
        Numbers in the sentence, keyed by their names in JSON. Angles are in degrees.
    suspicious
        True if the frame is above τ and a person should check it.
    """

    chain: str
    frame: int
    why: Why
    strength: float
    tau: float
    text: str
    numbers: Mapping[str, Any]
    suspicious: bool = False

    def to_json(self) -> dict[str, Any]:
        """Return the reason as a dict for JSON. Frames count from 0, and angles are in degrees."""
        return {
            "chain": self.chain,
            "frame": self.frame,
            "strength_deg": math.degrees(self.strength),
            "tau_deg": math.degrees(self.tau),
            "reason": self.why.value,
            "text": self.text,
            "suspicious": self.suspicious,
            "numbers": dict(self.numbers),
        }


@dataclass(frozen=True)
class AskedFrame:
    """A frame for which a reason is requested.

    Attributes
    ----------
    chain
        The chain or limb.
    joints
        Names of the chain's parent and child.
    frame
        The frame, as an index into the frames that were examined.
    strength, tau
        Strength at the frame, and threshold τ, radians.
    fps
        Number of examined frames per second.
    first
        Frame number that is shown for the clip's first frame.
    kept
        The frames that were examined, or None for all frames of the clip.
    """

    chain: Chain
    joints: tuple[str, str]
    frame: int
    strength: float
    tau: float
    fps: float
    first: int = 0
    kept: DistinctFrames | None = None

    def in_clip(self, frame: int) -> int:
        """Convert the index of an examined frame to its index in the clip."""
        return frame if self.kept is None else self.kept.end(frame)

    def reason(self, why: Why, because: str, **numbers: Any) -> Reason:
        """Return a reason whose sentence contains the strength, τ and the cause `because`."""
        strength, tau = format_distinct_degrees(self.strength, self.tau)
        past = self.strength >= self.tau
        here = self.called(self.frame)
        text = (
            f"{strength} at {here} is above τ = {tau}, but {because}."
            if past
            else f"{strength} at {here} is below τ = {tau}: {because}."
        )
        numbers |= {k: self.in_clip(numbers[k]) for k in _FRAMES if k in numbers}
        # A body can turn this fast, so nobody needs to check the frame.
        alone = why == Why.ONE_JOINT and self.strength < largest_natural_turn(self.fps)
        suspicious = past and why not in _SETTLED and not alone
        return Reason(
            self.chain.name,
            self.in_clip(self.frame),
            why,
            self.strength,
            self.tau,
            text,
            numbers,
            suspicious,
        )

    def called(self, frame: int) -> str:
        """Return a frame as shown to users, such as 'frame 12'."""
        return f"frame {self.in_clip(frame) + self.first}"

    def span(self, start: int, stop: int) -> str:
        """Return frames [start, stop) as shown in tables, such as 'frames 323–329'.

        The second number is `stop`, which is excluded.
        """
        if stop - start == 1:
            return self.called(start)
        return f"frames {self.in_clip(start) + self.first}–{self.in_clip(stop) + self.first}"

    def named(self, interval: Interval) -> str:
        """Describe an interval by its offset or, if it has none, by its kind and joint."""
        span, size = self.span(interval.start, interval.stop), format_signed_degrees(interval.shown)
        if named := interval.kind.info.named:
            return named.format(span=span, size=size, joint=interval.joint)
        return f"the interval in {span} ({size})"

    def error(self, interval: Interval, other: Chain) -> str:
        """Describe an error of another chain or limb, with its frames."""
        if not interval.repairable:
            return self.named(interval)
        span = self.span(interval.start, interval.stop)
        return f"the error of {other.label} in {span} ({format_signed_degrees(interval.shown)})"


def format_signed_degrees(angle: float) -> str:
    """Format an angle in radians as signed degrees, such as '+1.2°'."""
    return f"{math.degrees(angle):+.1f}°".replace("-", "−")


def format_unsigned_degrees(angle: float, digits: int = 1) -> str:
    """Format the magnitude of an angle in radians as degrees, such as '1.2°'."""
    return f"{abs(math.degrees(angle)):.{digits}f}°"


def format_distinct_degrees(one: float, other: float) -> tuple[str, str]:
    """Format the magnitudes of two angles with enough digits to tell them apart."""
    for digits in range(1, 6):
        said = format_unsigned_degrees(one, digits), format_unsigned_degrees(other, digits)
        if said[0] != said[1]:
            break
    return said
