"""Find bones that are twisted relative to their child by a constant angle in the whole clip.

In a constant counter-twist, the twist of a parent P is off by δ and the twist of its child C by −δ
in every frame. There is no edge, and no position changes, so such an offset can be found only by
comparison. It is reported but never corrected. A bone is compared with

- the same bone on the other side of the body, because a body is symmetric on average; mirrored
  twists have opposite signs
- its rest pose, but only in legs, because arms are far from their rest pose in many
  clips without errors
- the same bone in another take of the same skeleton, if the user names one
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from twistcore.errors import ClipMismatchError
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.medians import median
from twistcore.skeleton.motion import Motion, Skeleton
from twistcore.skeleton.rotation import Array, twist_angle, vector_lengths, wrap
from twistcore.work.frozen import dataclass

LEAST = math.radians(30.0)  # a smaller offset is ignored
# The offsets of P and C may differ by this share of the offset, or by this angle, because the usual
# poses of two sides or takes differ by as much.
_AGREE, _POSE = 0.25, math.radians(50.0)
_STEADY = 0.5  # a twist whose mean direction is a shorter vector has no usual angle
_ROUNDING = 1e-9  # a smaller circular variance may be an error of rounding
# The wrong side is known if the sides' distances from the rest pose differ by at least this angle.
_CLEARLY = math.radians(30.0)
_LEGS = ("UpLeg", "Leg")
_ALIKE = math.cos(math.radians(25.0))  # maximum angle between the same bone in two skeletons


@dataclass(frozen=True)
class ConstantOffset:
    """A chain whose parent is twisted relative to its child by a constant angle.

    Attributes
    ----------
    chain
        The chain.
    degrees
        The constant angle.
    other
        The chain on the other side of the body if the sides were compared, or None.
    reference
        The name of the take with which the clip was compared, or '' for the other side or the rest
        pose.
    clear
        True if the rest pose shows that this chain, not `other`, is the wrong one.
    """

    chain: Chain
    degrees: float
    other: Chain | None = None
    reference: str = ""
    clear: bool = True

    def __str__(self) -> str:
        if self.other is not None and not self.clear:
            return (
                f"{self.chain.label} or {self.other.label} is twisted by about "
                f"{abs(self.degrees):.0f}° relative to its child in every frame: the sides differ."
            )
        if self.other is None and not self.reference:
            return (
                f"{self.chain.label} is twisted by about {self.degrees:+.0f}° relative to its "
                "child in every frame, compared with the rest pose."
            )
        standard = self.reference if self.other is None else self.other.label
        return (
            f"{self.chain.label} is twisted by about {self.degrees:+.0f}° relative to its child in "
            f"every frame, compared with {standard}."
        )


@dataclass(frozen=True)
class _Usual:
    """The usual twist angle of a joint, in radians, and its circular variance, 0…1."""

    angle: float
    varies: float

    @property
    def mirrored(self) -> _Usual:
        """The twist expected of the corresponding joint on the other side of the body."""
        return _Usual(-self.angle, self.varies)


_Twists = tuple[_Usual, _Usual]  # the usual twists of a chain's P and C about P's bone
_REST: _Twists = (_Usual(0.0, 0.0), _Usual(0.0, 0.0))


def constant_offsets(motion: Motion, chains: Sequence[Chain]) -> tuple[ConstantOffset, ...]:
    """Find the chains with a constant offset from the body's other side or the rest pose."""
    usual = {chain.name: _usual_twists(motion, chain) for chain in chains}
    by_side = _lowest(
        offset
        for left, right in _pairs(chains)
        if (offset := _between_sides(left, right, usual, chains)) is not None
    )
    known = {one.name for found in by_side for one in (found.chain, found.other) if one}
    legs = [chain for chain in chains if chain.segment in _LEGS and chain.name not in known]
    at_rest: dict[str, _Twists | None] = dict.fromkeys(usual, _REST)
    return (*by_side, *_offsets(legs, usual, at_rest, chains, exact=True))


def constant_offsets_from_other_take(
    motion: Motion, chains: Sequence[Chain], reference: Motion, name: str
) -> tuple[ConstantOffset, ...]:
    """Find the chains with a constant offset from another take of the same skeleton.

    `reference` is the other take and `name` is its name. Raises ClipMismatchError if its skeleton
    is different.
    """
    _check_skeleton(motion.skeleton, reference.skeleton, chains, name)
    usual = {chain.name: _usual_twists(motion, chain) for chain in chains}
    expected = {chain.name: _usual_twists(reference, chain) for chain in chains}
    return _offsets(chains, usual, expected, chains, name)


def _check_skeleton(own: Skeleton, other: Skeleton, chains: Sequence[Chain], name: str) -> None:
    """Raise ClipMismatchError if a reference skeleton has different joints or chain bones.

    Different bone lengths and slightly different directions are accepted, because the reference may
    be the skeleton of another person.
    """
    wanted = f"{name}: expected a reference with the same skeleton as the clip"
    if len(own) != len(other):
        raise ClipMismatchError(f"{wanted}, found {len(other)} joints instead of {len(own)}")
    for here, there in zip(own.names, other.names, strict=True):
        if here != there:
            raise ClipMismatchError(f"{wanted}, found the joint {there!r} instead of {here!r}")
    for chain in chains:
        bones = own.offsets[chain.child], other.offsets[chain.child]
        parents = own.parents[chain.child], other.parents[chain.child]
        turned = float(bones[0] @ bones[1]) < _ALIKE * float(np.prod(vector_lengths(bones)))
        if turned or parents[0] != parents[1]:
            joint = own.names[chain.child]
            raise ClipMismatchError(f"{wanted}, found a different parent bone of {joint!r}")


def _offsets(
    among: Sequence[Chain],
    usual: Mapping[str, _Twists | None],
    expected: Mapping[str, _Twists | None],
    chains: Sequence[Chain],
    reference: str = "",
    *,
    exact: bool = False,
) -> tuple[ConstantOffset, ...]:
    """Return the constant offsets of chains relative to their expected twists.

    Parameters
    ----------
    among
        The chains to compare.
    usual, expected
        The usual and the expected twists, keyed by chain name.
    chains
        All chains of the clip.
    reference
        The name of the take that the expected twists are from, or ''.
    exact
        True if the offsets of a chain's parent and child must agree closely.
    """
    return _lowest(
        ConstantOffset(chain, math.degrees(offset), reference=reference)
        for chain in among
        if (own := usual[chain.name]) is not None
        and (other := expected[chain.name]) is not None
        and (offset := _offset(own, other, exact=exact or _hides_below(chain, usual, chains)))
    )


def _between_sides(
    left: Chain, right: Chain, usual: Mapping[str, _Twists | None], chains: Sequence[Chain]
) -> ConstantOffset | None:
    """Return the constant offset between a left and a right bone, or None if there is none."""
    of_left, of_right = usual[left.name], usual[right.name]
    if of_left is None or of_right is None:
        return None
    mirrored = of_right[0].mirrored, of_right[1].mirrored
    exact = any(_hides_below(chain, usual, chains) for chain in (left, right))
    if (offset := _offset(of_left, mirrored, exact=exact)) is None:
        return None
    far = [abs(p.angle) + abs(c.angle) for p, c in (of_left, of_right)]
    sides = (left, right) if far[0] >= far[1] else (right, left)
    clear = abs(far[0] - far[1]) >= _CLEARLY
    return ConstantOffset(sides[0], math.degrees(offset), sides[1], clear=clear)


def _offset(own: _Twists, expected: _Twists, *, exact: bool) -> float | None:
    """Return the constant twist of a parent P relative to its child C, in radians, or None.

    The result is None if an offset is small or if the offsets of P and C do not agree. `own` and
    `expected` are the usual and the expected twists of P and C. `exact` is True if the offsets must
    agree closely.
    """
    of_p = float(wrap(own[0].angle - expected[0].angle))
    of_c = -float(wrap(own[1].angle - expected[1].angle))
    apart, least = float(wrap(of_p - of_c)), min(abs(of_p), abs(of_c))
    pose = 0.0 if exact else min(_POSE, least)
    if least < LEAST or abs(apart) > max(_AGREE * least, pose):
        return None
    # The less the twist of a joint varies, the more exactly it shows the offset.
    blur = [own[k].varies + expected[k].varies for k in (0, 1)]
    return float(wrap(of_p - blur[0] / sum(blur) * apart))


def _hides_below(
    chain: Chain, usual: Mapping[str, _Twists | None], chains: Sequence[Chain]
) -> bool:
    """Return True if the next chain below has no usual twist.

    A twist in that chain may then be mistaken for a twist of this chain's child.
    """
    return any(usual[one.name] is None for one in chains if one.parent == chain.child)


def _lowest(found: Iterable[ConstantOffset]) -> tuple[ConstantOffset, ...]:
    """Return the offsets, excluding bones directly above another bone with an offset.

    An error of a bone also rotates the child joint of the bone above, so the lower bone is the
    wrong one.
    """
    offsets = tuple(found)
    parents = {one.parent for o in offsets for one in (o.chain, o.other) if one is not None}
    return tuple(offset for offset in offsets if offset.chain.child not in parents)


def _pairs(chains: Sequence[Chain]) -> Iterator[tuple[Chain, Chain]]:
    """Yield the left and right chain of each bone, or piece of a bone, that has both."""
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


def _usual_twists(motion: Motion, chain: Chain) -> _Twists | None:
    """Return the usual twists of a chain's parent and child, or None if either is undefined."""
    of_p, of_c = (_usual(motion, chain, joint) for joint in (chain.parent, chain.child))
    return None if of_p is None or of_c is None else (of_p, of_c)


def _usual(motion: Motion, chain: Chain, joint: int) -> _Usual | None:
    """Return a joint's usual twist about a chain's bone, or None if the twist varies too much."""
    if chain.axis.ndim > 1:
        return None
    angle: Array = twist_angle(motion.rotations[:, joint], chain.axis)
    mean = np.exp(1j * angle).mean()
    if abs(mean) < _STEADY:
        return None
    centre = float(np.angle(mean))
    middle = float(wrap(centre + median(wrap(angle - centre))))
    return _Usual(middle, max(1.0 - float(abs(mean)), _ROUNDING))
