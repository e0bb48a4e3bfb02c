"""Bones that are turned against their child in every frame, found by comparing both sides.

A constant counter-twist has no edge and changes no position, but the same bone on the other side of
the body reveals it. A body is symmetric on average, and mirrored twists about the outgoing bone
have opposite signs. So the sum of left and right is about 0 for P's twist and for C's. An error of
δ on one side adds +δ to one sum and −δ to the other, which no pose does for a whole clip.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from twistcore.skeleton.chain import Chain
from twistcore.skeleton.medians import median
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, twist_angle, wrap
from twistcore.work.frozen import dataclass

LEAST = math.radians(30.0)
_AGREE = 0.25  # share of the offset by which P's sum and C's may differ …
_POSE = math.radians(50.0)  # … or this much: so asymmetric are the usual poses of both sides
_STEADY = 0.5  # length of the mean direction: below it a twist has no usual angle
_CLEARLY = math.radians(30.0)  # one side is farther from the rest pose than the other


@dataclass(frozen=True)
class ConstantOffset:
    """A chain whose P is turned by `degrees` against C in every frame.

    Attributes
    ----------
    other
        The same chain on the other side.
    clear
        True if the rest poses show that this chain is wrong and not the other one.
    """

    chain: Chain
    other: Chain
    degrees: float
    clear: bool = True

    def __str__(self) -> str:
        if not self.clear:
            return (
                f"{self.chain.label} or {self.other.label} is turned by about "
                f"{abs(self.degrees):.0f}° against its child in every frame: the sides differ."
            )
        return (
            f"{self.chain.label} is turned by about {self.degrees:+.0f}° against its child in "
            f"every frame, compared with {self.other.label}."
        )


@dataclass(frozen=True)
class _Usual:
    """The usual angle of a joint's twist, in radians, and how much it varies, 0…1."""

    angle: float
    varies: float


@dataclass(frozen=True)
class _Pair:
    """The same bone on both sides, with the usual twists of left P, left C, right P and right C."""

    left: Chain
    right: Chain
    usual: tuple[_Usual, _Usual, _Usual, _Usual] | None


def constant_offsets(motion: Motion, chains: Sequence[Chain]) -> tuple[ConstantOffset, ...]:
    """Return the chains with a constant error that a comparison with the other side shows.

    An error of a bone also turns the C of the bone above. If two such bones are found, the lower
    one is wrong.
    """
    pairs = [_Pair(*sides, _usual_of_both(motion, *sides)) for sides in _pairs(chains)]
    above = {pair.left.child: pair for pair in pairs}
    below = {id(above[p.left.parent]): p for p in pairs if p.left.parent in above}
    found = {id(pair): _compared(pair, below.get(id(pair))) for pair in pairs}
    return tuple(
        offset
        for pair in pairs
        if (offset := found[id(pair)]) is not None
        and (id(pair) not in below or found[id(below[id(pair)])] is None)
    )


def _compared(pair: _Pair, below: _Pair | None) -> ConstantOffset | None:
    """Return the constant offset of a bone that exists on both sides, or None.

    `below` is the next bone of the limb.
    """
    if pair.usual is None:
        return None
    left_p, left_c, right_p, right_c = pair.usual
    of_p = float(wrap(left_p.angle + right_p.angle))
    of_c = -float(wrap(left_c.angle + right_c.angle))
    apart, least = float(wrap(of_p - of_c)), min(abs(of_p), abs(of_c))
    pose = min(_POSE, least)
    if below is not None and below.usual is None:
        pose = 0.0  # a twist of the bone below could be mistaken for C's
    if least < LEAST or abs(apart) > max(_AGREE * least, pose):
        return None
    # A joint that hardly turns shows the offset; the usual pose of a joint blurs it.
    blur = [left_p.varies + right_p.varies, left_c.varies + right_c.varies]
    share = blur[0] / sum(blur) if sum(blur) > 0.0 else 0.5
    offset = math.degrees(float(wrap(of_p - share * apart)))
    far = [abs(p.angle) + abs(c.angle) for p, c in ((left_p, left_c), (right_p, right_c))]
    sides = (pair.left, pair.right) if far[0] >= far[1] else (pair.right, pair.left)
    return ConstantOffset(*sides, offset, abs(far[0] - far[1]) >= _CLEARLY)


def _pairs(chains: Sequence[Chain]) -> Iterator[tuple[Chain, Chain]]:
    """Yield each bone, or piece of a bone, that exists on both sides of a person."""
    places: dict[tuple[str, str, int], dict[str, Chain]] = {}
    counts: dict[tuple[str, str, str], int] = {}
    for chain in chains:
        if chain.segment and chain.side:
            own = chain.person, chain.side, chain.segment
            counts[own] = counts.get(own, 0) + 1
            place = places.setdefault((chain.person, chain.segment, counts[own]), {})
            place[chain.side] = chain
    for sides in places.values():
        if len(sides) == 2:
            yield sides["Left"], sides["Right"]


def _usual_of_both(
    motion: Motion, left: Chain, right: Chain
) -> tuple[_Usual, _Usual, _Usual, _Usual] | None:
    """Return the usual twists of P and C on both sides, or None if one of them is undefined."""
    left_p, left_c, right_p, right_c = (
        _usual(motion, chain, joint)
        for chain in (left, right)
        for joint in (chain.parent, chain.child)
    )
    if left_p is None or left_c is None or right_p is None or right_c is None:
        return None
    return left_p, left_c, right_p, right_c


def _usual(motion: Motion, chain: Chain, joint: int) -> _Usual | None:
    """Return the circular median of a joint's twist about a chain's bone; None if undefined."""
    if chain.axis.ndim > 1:
        return None
    angle: Array = twist_angle(motion.rotations[:, joint], chain.axis)
    mean = np.exp(1j * angle).mean()
    if abs(mean) < _STEADY:
        return None
    centre = float(np.angle(mean))
    middle = float(wrap(centre + median(wrap(angle - centre))))
    return _Usual(middle, 1.0 - float(abs(mean)))
