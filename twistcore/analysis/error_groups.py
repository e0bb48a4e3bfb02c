"""Groups of errors that belong together, so that a reviewer can decide on all of them in one step.

Three rules form the groups. None of them depends on a reviewer's decisions:

1. *Edges*: on one limb, intervals whose edges are at most one frame apart belong together, if one
   of them is a jump or if they share a frame. A jump has only one edge, its first frame. This rule
   joins a flip with the jumps at its edges.
2. *Overlap*: on one limb, intervals that share at least 80 % of the longer one's frames belong
   together. This rule joins a leg with its foot.
3. *Series*: if at least three of these groups have the same kind of error in the same chain, in the
   same direction and of similar size in the middle, they are one group.

Two corrections of different kinds for the same frames of a limb are alternatives if one of them is
open. A reviewer chooses one of them, and only the one with more confidence is in the group.

The limb of an interval is the limb of its joint: the nearest joint above it at which a limb begins,
or the root. The cost grows linearly with the number of intervals, apart from sorting.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from twistcore.detection import Interval, Kind
from twistcore.skeleton.chain import Chain, limbs
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.work.frozen import dataclass

_NEAR = 1  # frames between edges
_SHARED = 0.8  # share of the longer interval's frames
_SERIES = 3  # minimum number of groups in a series
_SIMILAR = 1.3  # maximum ratio of the largest to the smallest size in a series
_JUMP = 4  # maximum number of frames of a jump
_FAR_LONGER = (
    10  # ratio to the frames of the first error from which a group has the name of another
)


@dataclass(frozen=True)
class ErrorGroup:
    """At least two errors that belong together.

    - members: indices of the intervals. The first one represents the group: it is the error with
      the largest extent or, in a series, the first repetition.
    - name: a short description, such as 'Left knee flips and the 2 jumps at its edges'
    """

    members: tuple[int, ...]
    name: str


def error_groups(
    intervals: Sequence[Interval], chains: Iterable[Chain], skeleton: Skeleton
) -> tuple[ErrorGroup, ...]:
    """Return the groups of intervals that belong together, sorted by their first member.

    `chains` are all chains and limbs to which the intervals refer. An interval belongs to at most
    one group. A group has at least two intervals.
    """
    by_name = {chain.name: chain for chain in chains}
    limb_starts = _limb_starts(skeleton, by_name.values())
    joints = {name: k for k, name in enumerate(skeleton.names)}
    of_limb = defaultdict[int, list[int]](list)
    for k, interval in enumerate(intervals):
        joint = joints.get(interval.joint, by_name[interval.chain].parent)
        of_limb[limb_starts[joint]].append(k)
    union = _Union(len(intervals))
    for members in of_limb.values():
        for one, other in (*_touching(intervals, members), *_overlapping(intervals, members)):
            union.join(one, other)
    parts = [
        _main_error_first(intervals, _without_alternatives(intervals, part))
        for part in union.parts()
    ]
    groups = [
        ErrorGroup(members, _name(intervals, members, by_name, repeated))
        for members, repeated in _with_series(intervals, parts)
        if len(members) > 1
    ]
    return tuple(sorted(groups, key=lambda group: group.members[0]))


def _limb_starts(skeleton: Skeleton, chains: Iterable[Chain]) -> list[int]:
    """Return, for every joint, the joint at which its limb begins, or the root if there is none."""
    found = limbs(skeleton, tuple(chains))
    first = {min(chain.parent for chain in line) for line in found}
    starts: list[int] = []
    for joint, parent in enumerate(skeleton.parents):
        starts.append(joint if joint in first or parent < 0 else starts[parent])
    return starts


class _Union:
    """Sets of indices that can be merged."""

    def __init__(self, count: int) -> None:
        self._above = list(range(count))

    def _top(self, k: int) -> int:
        above = self._above
        while above[k] != k:
            above[k] = above[above[k]]
            k = above[k]
        return k

    def join(self, one: int, other: int) -> None:
        """Merge the sets of two indices."""
        self._above[self._top(one)] = self._top(other)

    def parts(self) -> Iterable[list[int]]:
        """Return the sets, each in ascending order."""
        found = defaultdict[int, list[int]](list)
        for k in range(len(self._above)):
            found[self._top(k)].append(k)
        return found.values()


def _is_jump(interval: Interval) -> bool:
    """True for a jump: a momentary error that cannot be corrected."""
    lasts = interval.repairable or interval.kind.info.lasting
    return not lasts and interval.frames <= _JUMP


def _touching(intervals: Sequence[Interval], members: Iterable[int]) -> Iterator[tuple[int, int]]:
    """Yield pairs of intervals of one limb whose edges touch."""
    edges = [(intervals[k].start, k) for k in members]
    edges += [(intervals[k].stop, k) for k in members if not _is_jump(intervals[k])]
    edges.sort()
    meeting: list[int] = []  # intervals whose edges touch
    for place, (edge, k) in enumerate(edges):
        if place and edge - edges[place - 1][0] > _NEAR:
            yield from _touching_pairs(intervals, meeting)
            meeting = []
        meeting.append(k)
    yield from _touching_pairs(intervals, meeting)


def _touching_pairs(intervals: Sequence[Interval], meeting: list[int]) -> Iterator[tuple[int, int]]:
    """Yield pairs that connect intervals whose edges touch.

    Intervals without a common frame are connected only if one of them is a jump. If neither is, one
    error simply ends where another one begins.
    """
    if len(meeting) < 2:
        return
    jumps = any(_is_jump(intervals[k]) for k in meeting)
    reach = -1
    meeting.sort(key=lambda k: intervals[k].start)
    for one, other in pairwise(meeting):
        reach = max(reach, intervals[one].stop)
        if jumps or intervals[other].start < reach:
            yield one, other


def _overlapping(
    intervals: Sequence[Interval], members: Iterable[int]
) -> Iterator[tuple[int, int]]:
    """Yield pairs of intervals in different chains of one limb that share most of their frames."""
    last: dict[str, int] = {}  # by chain
    for k in sorted(members, key=lambda k: intervals[k].start):
        here = intervals[k]
        for other in last.values():
            there = intervals[other]
            common = min(here.stop, there.stop) - here.start
            if common >= _SHARED * max(here.frames, there.frames):
                yield k, other
        last[here.chain] = k


def without_alternatives(
    intervals: Sequence[Interval],
    chains: Iterable[Chain],
    skeleton: Skeleton,
    *,
    chosen: Iterable[Interval] = (),
) -> tuple[Interval, ...]:
    """Leave out intervals whose correction has a more certain alternative.

    If two alternatives were corrected together, the limb would end up in neither of the two
    intended poses.

    Parameters
    ----------
    intervals
        The intervals whose corrections are shown together.
    chains
        All chains and limbs to which the intervals refer.
    skeleton
        The skeleton of the clip.
    chosen
        The intervals that a person has accepted or selected. They are kept.
    """
    if len({i.kind for i in intervals if i.repairable}) < 2:
        return tuple(intervals)
    by_name = {chain.name: chain for chain in chains}
    starts = _limb_starts(skeleton, by_name.values())
    of_limb = defaultdict[int, list[int]](list)
    for k, interval in enumerate(intervals):
        chain = by_name.get(interval.chain)
        of_limb[starts[chain.parent] if chain else -1].append(k)
    first = {id(interval) for interval in chosen}
    kept = {
        k for members in of_limb.values() for k in _without_alternatives(intervals, members, first)
    }
    return tuple(interval for k, interval in enumerate(intervals) if k in kept)


def _without_alternatives(
    intervals: Sequence[Interval], part: list[int], chosen: Collection[int] = ()
) -> list[int]:
    """Leave out members of a part whose correction has a more certain alternative.

    `chosen` contains the id() of intervals that are always kept.
    """
    repairs = sorted((k for k in part if intervals[k].repairable), key=lambda k: intervals[k].start)
    instead = defaultdict[int, set[int]](set)  # the alternatives to a correction
    near: list[int] = []  # corrections that may share frames with the next one
    for k in repairs:
        here = intervals[k]
        near = [other for other in near if intervals[other].stop > here.start]
        for other in near:
            there = intervals[other]
            if there.kind != here.kind and (there.open or here.open):
                instead[k].add(other)
                instead[other].add(k)
        near.append(k)

    def doubt(k: int) -> tuple[bool, bool, float]:
        interval = intervals[k]
        return id(interval) not in chosen, interval.open, -(interval.confidence or 0.0)

    left: set[int] = set()
    for k in sorted(instead, key=doubt):
        if k not in left:
            left |= {other for other in instead[k] if id(intervals[other]) not in chosen}
    return [k for k in part if k not in left]


def _main_error_first(intervals: Sequence[Interval], part: list[int]) -> tuple[int, ...]:
    """Return a part's errors with the main error first and the others sorted by start."""

    def weight(k: int) -> tuple[bool, bool, int, int]:
        interval = intervals[k]
        return interval.repairable, not _is_jump(interval), interval.frames, -k

    lead = max(part, key=weight)
    return lead, *sorted((k for k in part if k != lead), key=lambda k: intervals[k].start)


def _with_series(
    intervals: Sequence[Interval], parts: Iterable[tuple[int, ...]]
) -> Iterator[tuple[tuple[int, ...], int]]:
    """Yield each part, with parts of a series joined, and the number of repetitions."""
    alike = defaultdict[tuple[str, Kind, str, bool], list[tuple[int, ...]]](list)
    for part in parts:
        lead = intervals[part[0]]
        alike[lead.chain, lead.kind, lead.joint, lead.carried].append(part)
    for candidates in alike.values():
        if len(candidates) < _SERIES:
            yield from ((part, 1) for part in candidates)
            continue
        for run in _similar(intervals, candidates):
            if len(run) < _SERIES:
                yield from ((part, 1) for part in run)
            else:
                run.sort(key=lambda part: intervals[part[0]].start)
                yield tuple(k for part in run for k in part), len(run)


def _similar(
    intervals: Sequence[Interval], parts: list[tuple[int, ...]]
) -> Iterator[list[tuple[int, ...]]]:
    """Yield runs of parts whose first errors have similar sizes and the same direction.

    Angles are compared modulo a full turn, because +179° and −179° are the same half turn.
    """
    turn = 2.0 * np.pi
    sized = sorted((_middle(intervals[part[0]]) % turn, part) for part in parts)
    run: list[tuple[int, ...]] = []
    smallest = 0.0
    for size, part in sized:
        least = min(smallest, turn - smallest, size, turn - size)
        if run and size - smallest > (_SIMILAR - 1.0) * least:
            yield run
            run = []
        if not run:
            smallest = size
        run.append(part)
    yield run


def _middle(interval: Interval) -> float:
    """Return the angle in the middle frame of an interval, radians. The median would be slower."""
    return float(
        interval.offset[interval.frames // 2] if interval.repairable else interval.residual
    )


def _name(
    intervals: Sequence[Interval],
    members: tuple[int, ...],
    chains: Mapping[str, Chain],
    repeated: int,
) -> str:
    """Return a group's name, such as 'Left knee flips and the 2 jumps at its edges'."""
    lead = intervals[members[0]]
    longest = max((intervals[k] for k in members), key=lambda i: i.frames)
    # Only a series begins with another error than its longest, so there are several more.
    if longest.kind.info.happens and longest.frames >= _FAR_LONGER * lead.frames:
        part = _part(longest, chains[longest.chain], False)
        what = longest.kind.info.happens.format(part=part)
        return f"{what} for {longest.frames} frames, and {len(members) - 1} more errors"
    part, info = _part(lead, chains[lead.chain], repeated > 1), lead.kind.info
    what = info.happens.format(part=part) if info.happens else f"{part}: {info.name}"
    if repeated > 1:
        same = [k for k in members if _is_like(intervals[k], lead)]
        others = len(members) - len(same)
        what = f"the same error {len(same)} times: {what}"
    else:
        others = len(members) - 1
    jumps = sum(_is_jump(intervals[k]) for k in members) == others and not _is_jump(lead)
    if not others:
        return what
    if not jumps:
        return f"{what}, and 1 more error" if others == 1 else f"{what}, and {others} more errors"
    if repeated > 1:
        return f"{what}, with {others} jumps at the edges"
    if others == 1:
        return f"{what} and the jump at its edge"
    return f"{what} and the {others} jumps at its edges"


def _is_like(interval: Interval, lead: Interval) -> bool:
    return (interval.chain, interval.kind, interval.joint) == (lead.chain, lead.kind, lead.joint)


def _part(interval: Interval, chain: Chain, inside: bool) -> str:
    """Return the part of the body that is wrong.

    The name begins with a lower-case letter if it is `inside` a sentence.
    """
    if interval.joint:
        return interval.joint
    if not isinstance(chain, Limb) or not chain.segment:
        return chain.label
    side = chain.side.lower() if inside and not chain.person else chain.side
    part = f"{side} {chain.middle_word}"
    return f"{chain.person} · {part}" if chain.person else part
