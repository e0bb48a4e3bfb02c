"""Group errors that belong together, so that a reviewer can decide on them in one step.

The groups do not depend on a reviewer's decisions. They are formed by three rules:

1. *Edges*: intervals of one limb belong together if their edges are at most one frame apart and, in
   addition, one of them is a jump or they share a frame. A jump has only one edge, its first frame.
   This rule joins a flip with the jumps at its edges.
2. *Overlap*: intervals of one limb belong together if they share at least 80 % of the frames of the
   longer one. This rule joins a leg with its foot.
3. *Series*: if at least three groups formed so far have the same kind of error in the same chain,
   in the same direction and of similar size, they become one group.

Two corrections of different kinds for the same frames of a limb are *alternatives* if one of them
is open (not applied automatically). A reviewer chooses between them, and only the one with the
higher confidence is in the group.

An interval belongs to the limb that begins at the interval's joint or at the nearest joint above
it. If there is no such limb, it belongs to the root.

Computation time grows linearly with the number of intervals, apart from sorting.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise

import numpy as np

from twistcore.detection import Interval, Kind
from twistcore.skeleton.chain import Chain, group_connected_chains
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Skeleton
from twistcore.work.frozen import dataclass

_NEAR = 1  # maximum number of frames between edges that touch
_SHARED = 0.8  # minimum share of the longer interval's frames
_SERIES = 3  # minimum number of groups in a series
_SIMILAR = 1.3  # maximum ratio of the largest to the smallest size in a series
_JUMP = 4  # maximum number of frames of a jump
# A series is named after an error that is longer than its first one by this factor.
_FAR_LONGER = 10


@dataclass(frozen=True)
class ErrorGroup:
    """At least two errors that belong together.

    Attributes
    ----------
    members
        Indices of the intervals. The first one represents the group: it is the main error or, in a
        series, the first main error.
    name
        A short description, such as 'Left knee flips and the 2 jumps at its edges'.
    short
        The name without the errors that accompany the main one, such as 'Left knee flips'.
    """

    members: tuple[int, ...]
    name: str
    short: str


def error_groups(
    intervals: Sequence[Interval], chains: Iterable[Chain], skeleton: Skeleton
) -> tuple[ErrorGroup, ...]:
    """Return the groups of intervals that belong together, sorted by their first member.

    An interval belongs to at most one group. `chains` are all chains and limbs to which the
    intervals belong.
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
        ErrorGroup(members, *_names(intervals, members, by_name, repeated))
        for members, repeated in _with_series(intervals, parts)
        if len(members) > 1
    ]
    return tuple(sorted(groups, key=lambda group: group.members[0]))


def _limb_starts(skeleton: Skeleton, chains: Iterable[Chain]) -> list[int]:
    """Return, for each joint, the first joint of its limb, or the root if it has no limb."""
    found = group_connected_chains(skeleton, tuple(chains))
    first = {min(chain.parent for chain in line) for line in found}
    starts: list[int] = []
    for joint, parent in enumerate(skeleton.parents):
        starts.append(joint if joint in first or parent < 0 else starts[parent])
    return starts


class _Union:
    """Disjoint sets of indices that can be merged (union-find)."""

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
    """Return True if an error is a jump: momentary and impossible to correct."""
    lasts = interval.repairable or interval.kind.info.lasting
    return not lasts and interval.frames <= _JUMP


def _touching(intervals: Sequence[Interval], members: Iterable[int]) -> Iterator[tuple[int, int]]:
    """Yield index pairs of intervals in one limb whose edges touch.

    `members` are the indices of the limb's intervals.
    """
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
    """Yield index pairs that connect the intervals in `meeting`, whose edges touch.

    Intervals without a common frame are connected only if `meeting` contains a jump. Without a
    jump, one error simply ends where the next one begins.
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
    """Yield index pairs of intervals in different chains of a limb that share most frames."""
    last: dict[str, int] = {}  # the latest interval of each chain
    for k in sorted(members, key=lambda k: intervals[k].start):
        here = intervals[k]
        for other in last.values():
            there = intervals[other]
            common = min(here.stop, there.stop) - here.start
            if common >= _SHARED * max(here.frames, there.frames):
                yield k, other
        last[here.chain] = k


def drop_weaker_correction_alternatives(
    intervals: Sequence[Interval],
    chains: Iterable[Chain],
    skeleton: Skeleton,
    *,
    chosen: Iterable[Interval] = (),
) -> tuple[Interval, ...]:
    """Return the intervals, excluding those whose correction has a more certain alternative.

    Alternatives are corrections of different kinds for the same frames of a limb. If two of them
    were applied together, the limb would end up in neither of the two intended poses.

    Parameters
    ----------
    intervals
        The intervals whose corrections are shown together.
    chains
        All chains and limbs to which the intervals belong.
    skeleton
        The clip's skeleton.
    chosen
        The intervals that a person has accepted or selected, which are always returned.
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
    """Return the members of a group, excluding members that have a more certain alternative.

    `part` contains the indices of the group's intervals, and `chosen` the id() of each interval
    that is never excluded.
    """
    repairs = sorted((k for k in part if intervals[k].repairable), key=lambda k: intervals[k].start)
    instead = defaultdict[int, set[int]](set)  # alternatives to each correction
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
    """Return the indices of a group's errors: first the main error, then the others by start."""

    def weight(k: int) -> tuple[bool, bool, int, int]:
        interval = intervals[k]
        return interval.repairable, not _is_jump(interval), interval.frames, -k

    lead = max(part, key=weight)
    return lead, *sorted((k for k in part if k != lead), key=lambda k: intervals[k].start)


def _with_series(
    intervals: Sequence[Interval], parts: Iterable[tuple[int, ...]]
) -> Iterator[tuple[tuple[int, ...], int]]:
    """Join the groups of each series. Yield each group with the number of groups joined into it."""
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
    """Yield runs of groups whose main errors have similar sizes and the same direction.

    Angles are compared modulo a full turn, because +179° and −179° are nearly the same half turn.
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
    """Return an interval's angle in its middle frame, radians (faster than the median angle)."""
    return float(
        interval.offset[interval.frames // 2] if interval.repairable else interval.residual
    )


def _names(
    intervals: Sequence[Interval],
    members: tuple[int, ...],
    chains: Mapping[str, Chain],
    repeated: int,
) -> tuple[str, str]:
    """Return a group's name, such as 'Left knee flips and the 2 jumps at its edges', and its short
    form.

    `repeated` is the number of similar groups that were joined, or 1.
    """
    lead = intervals[members[0]]
    longest = max((intervals[k] for k in members), key=lambda i: i.frames)
    # Only a series can begin with an error that is not its longest, so there are several more
    # errors.
    if longest.kind.info.happens and longest.frames >= _FAR_LONGER * lead.frames:
        part = _part(longest, chains[longest.chain], False)
        what = longest.kind.info.happens.format(part=part)
        name = f"{what} for {longest.frames} frames, and {len(members) - 1} more errors"
        return name, what
    part, info = _part(lead, chains[lead.chain], repeated > 1), lead.kind.info
    what = short = info.happens.format(part=part) if info.happens else f"{part}: {info.name}"
    others = len(members) - 1
    if repeated > 1:
        same = [k for k in members if _is_like(intervals[k], lead)]
        others = len(members) - len(same)
        short = f"{len(same)} times: {what}"
        what = f"the same error {len(same)} times: {what}"
    jumps = sum(_is_jump(intervals[k]) for k in members) == others and not _is_jump(lead)
    if not others:
        name = what
    elif not jumps:
        name = f"{what}, and 1 more error" if others == 1 else f"{what}, and {others} more errors"
    elif repeated > 1:
        name = f"{what}, with {others} jumps at the edges"
    elif others == 1:
        name = f"{what} and the jump at its edge"
    else:
        name = f"{what} and the {others} jumps at its edges"
    return name, short


def _is_like(interval: Interval, lead: Interval) -> bool:
    return (interval.chain, interval.kind, interval.joint) == (lead.chain, lead.kind, lead.joint)


def _part(interval: Interval, chain: Chain, inside: bool) -> str:
    """Return the name of the body part that is wrong.

    If `inside` is True, the name is for the middle of a sentence and begins in lower case.
    """
    if interval.joint:
        return interval.joint
    if not isinstance(chain, Limb) or not chain.segment:
        return chain.label
    side = chain.side.lower() if inside and not chain.person else chain.side
    part = f"{side} {chain.middle_word}"
    return f"{chain.person} · {part}" if chain.person else part
