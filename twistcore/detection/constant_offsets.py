"""A bone that is turned against its child in every frame, by comparison with the other side.

No edge shows a constant counter-twist, and no position does. The same bone of the other side does:
a body is symmetric in the mean, and a mirrored twist about the outgoing bone has the other sign, so
that left + right is about 0 for P's twist and for C's. An error of δ on one side shows as +δ in the
one sum and as −δ in the other, which no pose does for a whole clip.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from twistcore.chain import Chain
from twistcore.motion import Motion
from twistcore.rotation import Array, twist_angle, wrap

LEAST = math.radians(30.0)
_AGREE = 0.25  # of the offset, by which P's sum and C's may miss each other
_STEADY = 0.5  # length of the mean direction: with less a twist has no usual angle


@dataclass(frozen=True)
class ConstantOffset:
    """A chain whose P is turned by `degrees` against C in every frame; other: the other side's."""

    chain: Chain
    other: Chain
    degrees: float

    def __str__(self) -> str:
        return (
            f"{self.chain.label} is turned by about {self.degrees:+.0f}° against its child in "
            f"every frame, compared with {self.other.label}."
        )


def constant_offsets(motion: Motion, chains: Sequence[Chain]) -> tuple[ConstantOffset, ...]:
    """Return the chains that are off by a constant, as far as the other side shows it."""
    return tuple(_found(motion, chains))


def _found(motion: Motion, chains: Sequence[Chain]) -> Iterator[ConstantOffset]:
    for left, right in _pairs(chains):
        usual = [_usual(motion, chain) for chain in (left, right)]
        if None in usual:
            continue
        (left_p, left_c), (right_p, right_c) = (u for u in usual if u is not None)
        of_p, of_c = (float(wrap(a + b)) for a, b in ((left_p, right_p), (left_c, right_c)))
        if abs(of_p) < LEAST or abs(float(wrap(of_p + of_c))) > _AGREE * abs(of_p):
            continue
        # The side that is farther from its rest pose, in both joints together.
        far = [abs(p) + abs(c) for p, c in ((left_p, left_c), (right_p, right_c))]
        sides = (left, right) if far[0] >= far[1] else (right, left)
        yield ConstantOffset(*sides, math.degrees(of_p))


def _pairs(chains: Sequence[Chain]) -> Iterator[tuple[Chain, Chain]]:
    """The same bone, or the same piece of it, of both sides of a person."""
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


def _usual(motion: Motion, chain: Chain) -> tuple[float, float] | None:
    """The usual twist of P and of C about the bone, radians; None if one has none."""
    if chain.axis.ndim > 1:
        return None
    p, c = (twist_angle(motion.rotations[:, j], chain.axis) for j in (chain.parent, chain.child))
    usual = [_middle(angle) for angle in (p, c)]
    return None if usual[0] is None or usual[1] is None else (usual[0], usual[1])


def _middle(angle: Array) -> float | None:
    """The circular median of angles, None where they point everywhere."""
    mean = np.exp(1j * angle).mean()
    if abs(mean) < _STEADY:
        return None
    centre = float(np.angle(mean))
    return float(wrap(centre + np.median(wrap(angle - centre))))
